//! Conditions that tell inflow from outflow.

use super::basic::{field_text, pick};
use super::{Condition, PatchClosure, PatchView};
use granflow_base::Value;

/// Zero gradient where the flow leaves, a given value where it enters.
pub struct InletOutlet<T> {
    inlet: Vec<T>,
    /// Name of the condition and of its value.
    names: (&'static str, &'static str),
    /// Whether the value is there before there is a flux.
    from_the_start: bool,
}
impl<T: Value> InletOutlet<T> {
    /// One inlet value for the patch or one per face.
    pub fn new(inlet: Vec<T>) -> Self {
        InletOutlet { inlet, names: ("inletOutlet", "inletValue"), from_the_start: false }
    }
    /// The same under the name `freestream`, whose first flux is that of its value.
    pub(super) fn freestream(inlet: Vec<T>) -> Self {
        InletOutlet { inlet, names: ("freestream", "freestreamValue"), from_the_start: true }
    }
}
impl<T: Value> Condition<T> for InletOutlet<T> {
    fn name(&self) -> &'static str {
        self.names.0
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        // A field without a flux is not transported: nothing enters.
        let Some(flux) = view.flux else {
            if self.from_the_start {
                closure.fix(T::ZERO);
                let each = closure.offset.iter_mut().enumerate();
                each.for_each(|(i, o)| *o = pick(&self.inlet, i));
            }
            return;
        };
        for (i, f) in flux.iter().enumerate() {
            if *f < 0.0 {
                (closure.offset[i], closure.slope[i]) = (pick(&self.inlet, i), 0.0);
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![(self.names.1.into(), field_text(&self.inlet))]
    }
}
