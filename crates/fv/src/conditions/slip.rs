//! Slip: no flow through the wall, no traction along it.

use super::{Condition, PatchClosure, PatchView};
use granflow_base::Value;

/// Vectors lose their normal part, scalars have zero gradient.
pub struct Slip;
impl<T: Value> Condition<T> for Slip {
    fn name(&self) -> &'static str {
        "slip"
    }
    fn update(&mut self, _: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        if T::N == 3 {
            closure.normal.fill(1.0);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
