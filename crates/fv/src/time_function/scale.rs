//! One function of time times another.

use super::{Form, Settings, TimeFunction};
use granflow_base::Value;
use std::sync::Arc;

struct Scale<T> {
    scale: TimeFunction<f64>,
    value: TimeFunction<T>,
}

impl<T: Value> Form<T> for Scale<T> {
    fn at(&self, time: f64) -> T {
        self.value.at(time).scaled(self.scale.at(time))
    }
}

/// `scale` with the functions `scale` and `value`.
pub(super) fn read<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    Some(Arc::new(Scale { scale: s.function("scale"), value: s.function("value") }))
}
