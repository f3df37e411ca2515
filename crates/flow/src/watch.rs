//! Who hears of every outer pass, so that a step of minutes is not silent.

use crate::Residuals;
use std::sync::Arc;

/// What is called.
type Hearer = dyn Fn(usize, &Residuals) + Send + Sync;

/// Called with the number of a pass of a step, from 0, and the residuals it begins with. It must return at once.
#[derive(Clone)]
pub struct Watch(pub Arc<Hearer>);

impl std::fmt::Debug for Watch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Watch")
    }
}
