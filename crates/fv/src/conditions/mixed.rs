//! Between a given value and a given gradient.

use super::basic::{field_text, pick};
use super::read::{field_values, leave_value, values};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_base::Value;
use granflow_dict::Reader;

/// Robin: `fraction * value + (1 - fraction) * (cell value + gradient * distance)`.
struct Mixed<T> {
    value: Vec<T>,
    /// Outward, units of the field per metre.
    gradient: Vec<T>,
    /// 0 (the gradient is given) to 1 (the value is).
    fraction: Vec<f64>,
}
impl<T: Value> Condition<T> for Mixed<T> {
    fn name(&self) -> &'static str {
        "mixed"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        for (i, inv_dist) in view.inv_dist.iter().enumerate() {
            let fixed = pick(&self.fraction, i);
            let rise = pick(&self.gradient, i).scaled((1.0 - fixed) / inv_dist);
            closure.offset[i] = rise.axpy(fixed, pick(&self.value, i));
            closure.slope[i] = 1.0 - fixed;
        }
    }
    fn fixes_value(&self) -> bool {
        self.fraction.iter().any(|f| *f > 0.0)
    }
    fn gives_value(&self) -> bool {
        self.fraction.iter().all(|f| *f == 1.0)
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![
            ("refValue".into(), field_text(&self.value)),
            ("refGradient".into(), field_text(&self.gradient)),
            ("valueFraction".into(), field_text(&self.fraction)),
        ]
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "mixed",
    summary: "Robin: a share valueFraction of a given value, the rest of a given outward gradient",
    formula: "phi_f = w refValue + (1 - w) (phi_P + refGradient h), w = valueFraction",
    keys: &[
        ("refValue", "units of the field, `uniform` or one a face"),
        ("refGradient", "units of the field a metre, outwards, `uniform` or one a face"),
        (
            "valueFraction",
            "0 (the gradient is given) to 1 (the value is), `uniform` or one a \
                           face",
        ),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(read),
    vector: Some(read),
};
fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Mixed {
        value: field_values(r, "refValue", c),
        gradient: field_values(r, "refGradient", c),
        fraction: fractions(r, "valueFraction", c),
    })
}

/// Shares from 0 to 1.
pub(super) fn fractions(r: &Reader<'_>, key: &str, c: &PatchContext<'_>) -> Vec<f64> {
    let shares = values::<f64>(r, key, c.n_faces);
    if shares.iter().any(|f| !(0.0..=1.0).contains(f)) {
        r.error_at_key(key, format!("`{key}` must be from 0 to 1"), "not a share", None);
    }
    shares
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn a_share_of_the_value_and_the_rest_of_the_gradient() {
        let text = "type mixed; refValue uniform 2; refGradient uniform 4; \
                    valueFraction nonuniform List<scalar> 4 (0 0.25 0.5 1);";
        // 0.5 m behind the face: 6 + 4/2 where only the gradient counts.
        assert_eq!(Probe::of::<f64>(text).values([6.0; 4]), [8.0, 6.5, 5.0, 2.0]);
        assert!(Probe::of::<f64>(text).condition().fixes_value());
        assert!(!Probe::of::<f64>(text).condition().gives_value());
        let whole =
            "type mixed; refValue uniform 2; refGradient uniform 4; valueFraction uniform 1;";
        assert!(Probe::of::<f64>(whole).condition().gives_value());
        let wrong = "type mixed; refValue uniform 2; refGradient uniform 4; \
                     valueFraction uniform 1.5;";
        assert!(mistakes::<f64>(wrong).to_string().contains("from 0 to 1"));
    }
}
