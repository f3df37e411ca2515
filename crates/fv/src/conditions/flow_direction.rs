//! Conditions that tell inflow from outflow.

use super::basic::{field_text, pick};
use super::{Condition, PatchClosure, PatchView};
use granflow_base::{Value, Vec3, dot, scale};

/// Zero gradient where the flow leaves, a given value where it enters.
pub struct InletOutlet<T> {
    inlet: Vec<T>,
}
impl<T: Value> InletOutlet<T> {
    /// One inlet value for the patch or one per face.
    pub fn new(inlet: Vec<T>) -> Self {
        InletOutlet { inlet }
    }
}
impl<T: Value> Condition<T> for InletOutlet<T> {
    fn name(&self) -> &'static str {
        "inletOutlet"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        // A field without a flux is not transported: nothing enters.
        let Some(flux) = view.flux else { return };
        for (i, f) in flux.iter().enumerate() {
            if *f < 0.0 {
                (closure.offset[i], closure.slope[i]) = (pick(&self.inlet, i), 0.0);
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("inletValue".into(), field_text(&self.inlet))]
    }
}

/// Velocity where the pressure is given: what leaves does so freely, what enters comes along the
/// normal of the face, as fast as the cell's velocity.
pub struct PressureInletOutletVelocity;
impl Condition<Vec3> for PressureInletOutletVelocity {
    fn name(&self) -> &'static str {
        "pressureInletOutletVelocity"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.free();
        let Some(flux) = view.flux else { return };
        for (i, f) in flux.iter().enumerate() {
            if *f < 0.0 {
                let n = view.normal[i];
                let speed = dot(view.cells[view.owner[i] as usize], n);
                (closure.offset[i], closure.slope[i]) = (scale(n, speed), 0.0);
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
