//! The profile that arrives, brought to a given mean.

use super::read::{leave_flux, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Value, norm};
use granflow_dict::Reader;

/// Values of the cells behind the patch, scaled where their mean over the area is more than half of
/// what is asked for, else shifted.
struct FixedMean<T> {
    mean: TimeFunction<T>,
    /// Only where the flow leaves; zero gradient where it enters.
    outlet: bool,
}
impl<T: Value> Condition<T> for FixedMean<T> {
    fn name(&self) -> &'static str {
        if self.outlet { "fixedMeanOutletInlet" } else { "fixedMean" }
    }
    fn n_totals(&self) -> usize {
        1 + T::N
    }
    fn totals(&self, view: &PatchView<'_, T>, out: &mut [f64]) {
        for (s, cell) in view.area.iter().zip(view.owner) {
            let (area, v) = (norm(*s), view.cells[*cell as usize]);
            out[0] += area;
            (0..T::N).for_each(|c| out[1 + c] += area * v.comp(c));
        }
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        let mut found = T::ZERO;
        let area = view.totals[0].max(f64::MIN_POSITIVE);
        (0..T::N).for_each(|c| found.set_comp(c, view.totals[1 + c] / area));
        let wanted = self.mean.at(view.around.time);
        let size = |v: T| v.inner(v).sqrt();
        let (factor, shift) = match size(wanted) > 0.0 && size(found) > 0.5 * size(wanted) {
            true => (size(wanted) / size(found), T::ZERO),
            false => (1.0, wanted.minus(found)),
        };
        for (i, cell) in view.owner.iter().enumerate() {
            if self.outlet && view.flux.is_none_or(|flux| flux[i] < 0.0) {
                continue;
            }
            closure.offset[i] = shift.axpy(factor, view.cells[*cell as usize]);
            closure.slope[i] = 0.0;
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.mean.entries("meanValue")
    }
}

pub(super) const FIXED_MEAN: Entry = Entry {
    name: "fixedMean",
    summary: "the values of the cells behind the patch, scaled or shifted to a given mean, a function \
              of time",
    formula: "phi_f = phi_P |M|/|m| where |m| > |M|/2, else phi_P + M - m; M = meanValue(t), m \
              = sum phi_P |S|/sum |S| over the patch",
    keys: &[("meanValue", "units of the field, a function of time")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(|r, c| Box::new(read(r, c, false))),
    vector: Some(|r, c| Box::new(read(r, c, false))),
};
pub(super) const OUTLET_INLET: Entry = Entry {
    name: "fixedMeanOutletInlet",
    summary: "fixedMean where the flow leaves, zero gradient where it enters",
    formula: "phi_f = phi_P where flux < 0; elsewhere that of fixedMean",
    keys: &[
        ("meanValue", "units of the field, a function of time"),
        ("outletValue", "written by OpenFOAM, not used"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(|r, c| Box::new(read(r, c, true))),
    vector: Some(|r, c| Box::new(read(r, c, true))),
};
fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>, outlet: bool) -> FixedMean<T> {
    leave_value(r);
    if outlet {
        leave_flux(r);
        r.ignore("outletValue");
    }
    let mean = TimeFunction::read(r, "meanValue", c.dims, c.case).times(c.factor);
    FixedMean { mean, outlet }
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn profiles_are_scaled_or_shifted_to_their_mean() {
        let of = |mean: &str| Probe::of::<f64>(&format!("type fixedMean; meanValue {mean};"));
        let cells = [1.0, 2.0, 3.0, 2.0];
        assert_eq!(of("3").values(cells), [1.5, 3.0, 4.5, 3.0]);
        assert_eq!(of("table ((0 5) (2 9))").at(1.0).values(cells), [6.0, 7.0, 8.0, 7.0]);
        assert_eq!(of("0").values(cells), [-1.0, 0.0, 1.0, 0.0]);
        let text = "type fixedMeanOutletInlet; meanValue (0 3 0);";
        let found = Probe::of::<[f64; 3]>(text).flux([1.0, -1.0, 1.0, 1.0]).values([
            [0.0, 1.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 3.0, 0.0],
            [0.0, 2.0, 0.0],
        ]);
        assert_eq!(found.map(|u| u[1]), [1.5, 2.0, 4.5, 3.0]);
    }
}
