//! Facts a person should hear once: what was mapped onto something else, what was assumed.

use std::cell::RefCell;
use std::rc::Rc;

/// A shared list of messages, each held once; clones share it.
#[derive(Clone, Debug, Default)]
pub struct Notices(Rc<RefCell<Vec<String>>>);

impl Notices {
    /// An empty list.
    pub fn new() -> Notices {
        Notices::default()
    }
    /// Adds a message unless it was said before.
    pub fn say(&self, message: impl Into<String>) {
        let message = message.into();
        let mut all = self.0.borrow_mut();
        if !all.contains(&message) {
            all.push(message);
        }
    }
    /// What was said so far, in order; the list is empty afterwards.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.borrow_mut())
    }
}
