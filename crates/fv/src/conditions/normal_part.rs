//! Conditions that treat what is normal to the patch and what is along it each in its way.

use super::basic::{field_text, pick};
use super::mixed::fractions;
use super::read::{field_values, leave_flux, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView, read_vector};
use crate::time_function::raw_text;
use granflow_base::{Value, Vec3, dot, scale};
use granflow_dict::Reader;

/// The normal part is given, along the patch the cell's value passes.
struct FixedNormalSlip {
    value: Vec<Vec3>,
}
impl Condition<Vec3> for FixedNormalSlip {
    fn name(&self) -> &'static str {
        "fixedNormalSlip"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.free();
        closure.normal.fill(1.0);
        for (i, n) in view.normal.iter().enumerate() {
            closure.offset[i] = scale(*n, dot(pick(&self.value, i), *n));
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("fixedValue".into(), field_text(&self.value))]
    }
}

pub(super) const FIXED_NORMAL_SLIP: Entry = Entry {
    name: "fixedNormalSlip",
    summary: "slip on a surface through which the normal part of fixedValue passes",
    formula: "U_f = U_P + ((fixedValue - U_P) . n) n",
    keys: &[("fixedValue", "m/s, `uniform` or one a face; only its normal part counts")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| {
        leave_value(r);
        Box::new(FixedNormalSlip { value: field_values(r, "fixedValue", c) })
    }),
};

/// The share `1 - fraction` of slip; the rest holds what touches it.
struct PartialSlip {
    fraction: Vec<f64>,
}
impl<T: Value> Condition<T> for PartialSlip {
    fn name(&self) -> &'static str {
        "partialSlip"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(T::ZERO);
        for i in 0..view.owner.len() {
            let free = 1.0 - pick(&self.fraction, i);
            closure.slope[i] = free;
            closure.normal[i] = if T::N == 3 { free } else { 0.0 };
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("valueFraction".into(), field_text(&self.fraction))]
    }
}

pub(super) const PARTIAL_SLIP: Entry = Entry {
    name: "partialSlip",
    summary: "between slip (valueFraction 0) and no slip (1)",
    formula: "U_f = (1 - w) (U_P - (U_P . n) n), w = valueFraction; of a scalar phi_f = (1 - \
              w) phi_P",
    keys: &[("valueFraction", "0 (slip) to 1 (no slip), `uniform` or one a face")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(partial_slip),
    vector: Some(partial_slip),
};
fn partial_slip<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(PartialSlip { fraction: fractions(r, "valueFraction", c) })
}

/// The normal part is that of another condition; along the patch the cell's value passes, or where
/// the flow enters that of the other condition.
struct FixedNormalInletOutlet {
    normal: Box<dyn Condition<Vec3>>,
    /// Its dictionary, as it was given.
    given: String,
    /// Whether what enters has a given velocity along the patch.
    fix_tangential: bool,
    /// Room for the closure of the other condition.
    room: (Vec<Vec3>, Vec<f64>, Vec<f64>),
}
impl Condition<Vec3> for FixedNormalInletOutlet {
    fn name(&self) -> &'static str {
        "fixedNormalInletOutletVelocity"
    }
    fn n_totals(&self) -> usize {
        self.normal.n_totals()
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        self.normal.totals(view, out);
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        let n_faces = view.owner.len();
        let (offset, slope, normal) = &mut self.room;
        offset.resize(n_faces, [0.0; 3]);
        slope.resize(n_faces, 0.0);
        normal.resize(n_faces, 0.0);
        self.normal.update(view, &mut PatchClosure { offset, slope, normal });
        closure.free();
        closure.normal.fill(1.0);
        for (i, n) in view.normal.iter().enumerate() {
            let cell = view.cells[view.owner[i] as usize];
            let value = offset[i].axpy(slope[i], cell).axpy(-normal[i] * dot(cell, *n), *n);
            if self.fix_tangential && view.flux.is_some_and(|flux| flux[i] < 0.0) {
                (closure.offset[i], closure.slope[i], closure.normal[i]) = (value, 0.0, 0.0);
            } else {
                closure.offset[i] = scale(*n, dot(value, *n));
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        let fix = if self.fix_tangential { "true" } else { "false" };
        vec![
            ("fixTangentialInflow".into(), fix.into()),
            ("normalVelocity".into(), self.given.clone()),
        ]
    }
}

pub(super) const FIXED_NORMAL_OUTLET: Entry = Entry {
    name: "fixedNormalInletOutletVelocity",
    summary: "the normal part of the condition in normalVelocity; along the patch free, or as that \
              condition says where the flow enters",
    formula: "U_f = U_P + ((V - U_P) . n) n, V: value of the condition normalVelocity; V \
              itself where flux < 0 and fixTangentialInflow is true",
    keys: &[
        ("normalVelocity", "a dictionary: another condition"),
        ("fixTangentialInflow", "`true` or `false`"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(fixed_normal_outlet),
};
fn fixed_normal_outlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    leave_flux(r);
    let fix_tangential = r.switch("fixTangentialInflow");
    let normal = match r.sub("normalVelocity") {
        Some(sub) => read_vector(&sub, c),
        None => Box::new(super::ZeroGradient),
    };
    let given = r.dict().get("normalVelocity").map(raw_text).unwrap_or_default();
    let room = (Vec::new(), Vec::new(), Vec::new());
    Box::new(FixedNormalInletOutlet { normal, given, fix_tangential, room })
}

/// Free where the flow enters, a given value where it leaves.
struct OutletInlet<T> {
    outlet: Vec<T>,
}
impl<T: Value> Condition<T> for OutletInlet<T> {
    fn name(&self) -> &'static str {
        "outletInlet"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        for (i, f) in view.flux.into_iter().flatten().enumerate() {
            if *f >= 0.0 {
                (closure.offset[i], closure.slope[i]) = (pick(&self.outlet, i), 0.0);
            }
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("outletValue".into(), field_text(&self.outlet))]
    }
}

pub(super) const OUTLET_INLET: Entry = Entry {
    name: "outletInlet",
    summary: "a given value where the flow leaves, zero gradient where it enters",
    formula: "phi_f = outletValue where flux >= 0, else phi_P",
    keys: &[("outletValue", "units of the field, `uniform` or one a face")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(outlet_inlet),
    vector: Some(outlet_inlet),
};
fn outlet_inlet<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    leave_flux(r);
    Box::new(OutletInlet { outlet: field_values(r, "outletValue", c) })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn slip_with_a_given_normal_part_and_by_a_share() {
        let cell = [3.0, 2.0, 1.0];
        let text = "type fixedNormalSlip; fixedValue uniform (0.5 9 9);";
        assert_eq!(Probe::of::<[f64; 3]>(text).values([cell; 4]), [[0.5, 2.0, 1.0]; 4]);
        let text = "type partialSlip; valueFraction uniform 0.25;";
        assert_eq!(Probe::of::<[f64; 3]>(text).values([cell; 4]), [[0.0, 1.5, 0.75]; 4]);
        assert_eq!(Probe::of::<f64>(text).values([4.0; 4]), [3.0; 4]);
    }

    #[test]
    fn the_normal_part_of_another_condition() {
        let of = |fix: &str| {
            let text = format!(
                "type fixedNormalInletOutletVelocity; fixTangentialInflow {fix}; normalVelocity \
                 {{ type uniformFixedValue; uniformValue table ((0 (0 0 0)) (2 (2 6 0))); }}"
            );
            let flux = [-1.0, -1.0, 1.0, -1.0];
            Probe::of::<[f64; 3]>(&text).at(1.0).flux(flux).values([[9.0, 1.0, 0.0]; 4])
        };
        let (given, free) = ([1.0, 3.0, 0.0], [1.0, 1.0, 0.0]);
        assert_eq!(of("true"), [given, given, free, given]);
        assert_eq!(of("no"), [free; 4]);
    }

    #[test]
    fn what_leaves_has_a_value() {
        let text = "type outletInlet; outletValue nonuniform List<scalar> 4 (1 2 3 4);";
        let found = Probe::of::<f64>(text).flux([1.0, -1.0, 0.0, -2.0]).values([7.0; 4]);
        assert_eq!(found, [1.0, 7.0, 3.0, 7.0]);
    }
}
