//! Another condition's values times a function of time.

use super::{Condition, Entry, PatchClosure, PatchContext, PatchView, ZeroGradient};
use crate::time_function::{TimeFunction, raw_text};
use granflow_base::{Dims, Value};
use granflow_dict::Reader;

/// Dirichlet: the values of `of` times `scale`.
struct ScaledFixedValue<T> {
    scale: TimeFunction<f64>,
    of: Box<dyn Condition<T>>,
    entries: Vec<(String, String)>,
}
impl<T: Value> Condition<T> for ScaledFixedValue<T> {
    fn name(&self) -> &'static str {
        "scaledFixedValue"
    }
    fn n_totals(&self) -> usize {
        self.of.n_totals()
    }
    fn totals(&self, view: &PatchView<'_, T>, out: &mut [f64]) {
        self.of.totals(view, out);
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        self.of.update(view, closure);
        let scale = self.scale.at(view.around.time);
        closure.offset.iter_mut().for_each(|v| *v = v.scaled(scale));
        closure.slope.iter_mut().for_each(|k| *k *= scale);
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.entries.clone()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "scaledFixedValue",
    summary: "Dirichlet: the values of the condition `refValue { type fixedValue; ... }` times `scale`, a \
              function of time",
    formula: "phi_f = scale(t) phi_f of refValue",
    keys: &[
        ("scale", "a function of time"),
        ("refValue", "a dictionary: a condition that gives values"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(|r, c| read(r, c, super::read_scalar)),
    vector: Some(|r, c| read(r, c, super::read_vector)),
};

fn read<T: Value>(
    r: &Reader<'_>,
    c: &PatchContext<'_>,
    inner: fn(&Reader<'_>, &PatchContext<'_>) -> Box<dyn Condition<T>>,
) -> Box<dyn Condition<T>> {
    super::read::leave_value(r);
    let scale = TimeFunction::read(r, "scale", Dims::NONE, c.case);
    let Some(sub) = r.sub("refValue") else { return Box::new(ZeroGradient) };
    let of = inner(&sub, c);
    if !of.fixes_value() {
        let help = Some("write `refValue { type fixedValue; value uniform 1; }`");
        sub.error_at_key("type", "`refValue` must be a condition that gives values", "none", help);
    }
    sub.finish(granflow_dict::Severity::Error);
    let mut entries = scale.entries("scale");
    entries.extend(r.dict().get("refValue").map(|v| ("refValue".to_owned(), raw_text(v))));
    Box::new(ScaledFixedValue { scale, of, entries })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    /// icoFoam v1912 has 2.2 of these at 0.1 s.
    #[test]
    fn values_times_a_function_of_time() {
        let text = "type scaledFixedValue; scale table ((0 1) (1 2)); \
                    refValue { type fixedValue; value nonuniform List<scalar> 4 (2 1 0 -1); }";
        assert_eq!(Probe::of::<f64>(text).at(0.5).values([9.0; 4]), [3.0, 1.5, 0.0, -1.5]);
        let text = "type scaledFixedValue; scale 3; \
                    refValue { type uniformFixedValue; uniformValue (2 0 1); }";
        assert_eq!(Probe::of::<[f64; 3]>(text).values([[9.0; 3]; 4]), [[6.0, 0.0, 3.0]; 4]);
        let free = "type scaledFixedValue; scale 3; refValue { type zeroGradient; }";
        assert!(mistakes::<f64>(free).to_string().contains("gives values"));
        let entries = Probe::of::<[f64; 3]>(text).condition().entries();
        assert!(entries[1].1.contains("uniformFixedValue"), "{entries:?}");
    }
}
