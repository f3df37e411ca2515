//! A wall where grains flow as the local law says.

use super::{Condition, PatchClosure, PatchView};

/// The fluidity at the wall is the local one, g = g_loc(mu, P), of the cell behind the face.
pub struct LocalFluidity;
impl Condition<f64> for LocalFluidity {
    fn name(&self) -> &'static str {
        "localFluidity"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.fix(0.0);
        for (offset, owner) in closure.offset.iter_mut().zip(view.owner) {
            *offset = view.around.local_fluidity.get(*owner as usize).copied().unwrap_or(0.0);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
