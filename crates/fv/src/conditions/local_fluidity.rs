//! A wall where grains flow as the local law says.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_dict::Reader;

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

pub(super) const ENTRY: Entry = Entry {
    name: "localFluidity",
    summary: "of the fluidity: a wall where grains flow as the local law says, g = g_loc",
    formula: "g_f = g_loc(mu_P, p_P)",
    keys: &[],
    reference: "D. L. Henann, K. Kamrin, PNAS 110 (2013) 6730, supporting information",
    scalar: Some(local_fluidity),
    vector: None,
};

fn local_fluidity(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    Box::new(LocalFluidity)
}
