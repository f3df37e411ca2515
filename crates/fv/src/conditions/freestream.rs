//! The flow far from a body: given where it comes in, free where it goes out.

use super::basic::{field_text, pick};
use super::read::{field_values, leave_flux, leave_value};
use super::{Condition, Entry, InletOutlet, PatchClosure, PatchContext, PatchView};
use granflow_base::{Value, Vec3, dot, norm};
use granflow_dict::Reader;

/// Share of the given velocity where the flow makes the angle with this cosine with the outward
/// normal: all of it straight in, none straight out. At rest half.
fn share_of_inflow(u: Vec3, n: Vec3) -> f64 {
    match norm(u) {
        0.0 => 0.5,
        speed => 0.5 - 0.5 * dot(u, n) / speed,
    }
}

/// The velocity on a face is a mean of the given one and the cell's, weighted by its own direction.
struct FreestreamVelocity {
    value: Vec<Vec3>,
}
impl Condition<Vec3> for FreestreamVelocity {
    fn name(&self) -> &'static str {
        "freestreamVelocity"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        /// More than the direction ever takes to settle where the two velocities are not opposed.
        const PASSES: usize = 50;
        closure.free();
        for (i, n) in view.normal.iter().enumerate() {
            let (given, cell) = (pick(&self.value, i), view.cells[view.owner[i] as usize]);
            let mut share = share_of_inflow(cell, *n);
            for _ in 0..PASSES {
                let face = cell.scaled(1.0 - share).axpy(share, given);
                let next = share_of_inflow(face, *n);
                let done = (next - share).abs() <= 1e-14;
                share = next;
                if done {
                    break;
                }
            }
            (closure.offset[i], closure.slope[i]) = (given.scaled(share), 1.0 - share);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("freestreamValue".into(), field_text(&self.value))]
    }
}

pub(super) const VELOCITY: Entry = Entry {
    name: "freestreamVelocity",
    summary: "far from a body: the given velocity as far as the flow on the face points inwards, \
              zero gradient as far as it points outwards",
    formula: "U_f = w freestreamValue + (1 - w) U_P, w = (1 - U_f . n/|U_f|)/2",
    keys: &[("freestreamValue", "m/s, `uniform` or one a face")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| {
        leave_value(r);
        Box::new(FreestreamVelocity { value: field_values(r, "freestreamValue", c) })
    }),
};

/// The pressure that belongs to it: given as far as the flow points outwards.
struct FreestreamPressure {
    value: Vec<f64>,
    n_inner: usize,
}
impl Condition<f64> for FreestreamPressure {
    fn name(&self) -> &'static str {
        "freestreamPressure"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        let first = view.first_boundary(self.n_inner);
        for (i, n) in view.normal.iter().enumerate() {
            let u = view.around.face_velocity.get(first + i).copied().unwrap_or_default();
            let share = 1.0 - share_of_inflow(u, *n);
            (closure.offset[i], closure.slope[i]) = (share * pick(&self.value, i), 1.0 - share);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("freestreamValue".into(), field_text(&self.value))]
    }
}

pub(super) const PRESSURE: Entry = Entry {
    name: "freestreamPressure",
    summary: "beside freestreamVelocity: the given pressure as far as the flow points outwards, zero \
              gradient as far as it points inwards",
    formula: "p_f = w freestreamValue + (1 - w) p_P, w = (1 + U_f . n/|U_f|)/2",
    keys: &[
        ("freestreamValue", "units of the field, `uniform` or one a face"),
        ("supersonic", "`false`"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(pressure),
    vector: None,
};
fn pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("U");
    if r.opt_switch("supersonic", false) {
        r.error_at_key("supersonic", "flows faster than sound are not computed", "set here", None);
    }
    let value = field_values(r, "freestreamValue", c);
    Box::new(FreestreamPressure { value, n_inner: c.n_inner })
}

pub(super) const EITHER: Entry = Entry {
    name: "freestream",
    summary: "inletOutlet under another name, with freestreamValue",
    formula: "phi_f = freestreamValue where flux < 0, else phi_P",
    keys: &[("freestreamValue", "units of the field, `uniform` or one a face")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(either),
    vector: Some(either),
};
fn either<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    leave_flux(r);
    if r.has("freestreamBC") {
        let message = "a condition of its own for what enters is not supported";
        let help = "write `freestreamValue`, or `uniformInletOutlet` for a value in time";
        r.error_at_key("freestreamBC", message, "set here", Some(help));
        return Box::new(super::ZeroGradient);
    }
    Box::new(InletOutlet::freestream(field_values(r, "freestreamValue", c)))
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn the_share_of_the_given_velocity_follows_the_direction() {
        let text = "type freestreamVelocity; freestreamValue uniform (2 0 0);";
        let cells = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]];
        let found = Probe::of::<[f64; 3]>(text).values(cells);
        assert_eq!([found[0], found[1], found[3]], [[2.0, 0.0, 0.0], cells[1], [2.0, 0.0, 0.0]]);
        // Of itself: u = s (2 0 0) + (1 - s) (0 1 0) with s = (1 + ux/|u|)/2.
        let [x, y, _] = found[2];
        let s = 0.5 + 0.5 * x / x.hypot(y);
        assert!((x - 2.0 * s).abs() < 1e-12 && (y - (1.0 - s)).abs() < 1e-12);
        let text = "type freestreamPressure; freestreamValue uniform 8;";
        let u = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-3.0, 4.0, 0.0]];
        let found = Probe::of::<f64>(text).velocity(u).values([2.0; 4]);
        for (f, e) in found.iter().zip([2.0, 8.0, 5.0, 2.0 + 0.8 * 6.0]) {
            assert!((f - e).abs() < 1e-12, "{found:?}");
        }
        let text = "type freestream; freestreamValue uniform 5;";
        let found = Probe::of::<f64>(text).flux([1.0, -1.0, 1.0, -1.0]).values([2.0; 4]);
        assert_eq!(found, [2.0, 5.0, 2.0, 5.0]);
        // The flux that a run begins with is that of the value.
        assert_eq!(Probe::of::<f64>(text).values([2.0; 4]), [5.0; 4]);
    }
}
