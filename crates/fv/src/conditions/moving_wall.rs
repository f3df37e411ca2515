//! Walls that move along themselves.

use super::read::{field_values, leave_value};
use super::{Condition, Entry, FixedValue, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Value, Vec3, dot};
use granflow_dict::Reader;

/// No slip on a wall with one velocity, of which what is normal to a face does not count.
struct TranslatingWall {
    velocity: TimeFunction<Vec3>,
}
impl Condition<Vec3> for TranslatingWall {
    fn name(&self) -> &'static str {
        "translatingWallVelocity"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let u = self.velocity.at(view.around.time);
        for (o, n) in closure.offset.iter_mut().zip(view.normal) {
            *o = u.axpy(-dot(u, *n), *n);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.velocity.entries("U")
    }
}

pub(super) const TRANSLATING: Entry = Entry {
    name: "translatingWallVelocity",
    summary: "no slip on a wall that moves along itself with the velocity U, a function of time",
    formula: "U_f = U(t) - (U(t) . n) n",
    keys: &[("U", "m/s, a function of time")],
    reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.3",
    scalar: None,
    vector: Some(|r, c| {
        leave_value(r);
        let velocity = TimeFunction::read(r, "U", c.dims, c.case);
        Box::new(TranslatingWall { velocity })
    }),
};

pub(super) const MOVING: Entry = Entry {
    name: "movingWallVelocity",
    summary: "no slip on a wall of a mesh that moves; meshes stand here, so that the velocity stays \
              what value says (zero without it)",
    formula: "U_f = value",
    keys: &[("value", "m/s, `uniform` or one a face, default 0")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(moving),
};
fn moving(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    let value = match r.has("value") {
        true => field_values(r, "value", c),
        false => vec![[0.0; 3]],
    };
    Box::new(FixedValue::under_name("movingWallVelocity", value))
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn walls_move_along_themselves() {
        let text = "type translatingWallVelocity; U table ((0 (0 0 0)) (2 (4 2 0)));";
        assert_eq!(Probe::of::<[f64; 3]>(text).at(1.0).values([[9.0; 3]; 4]), [[0.0, 1.0, 0.0]; 4]);
        let text = "type movingWallVelocity; value uniform (0 0.4 0);";
        assert_eq!(Probe::of::<[f64; 3]>(text).values([[9.0; 3]; 4]), [[0.0, 0.4, 0.0]; 4]);
        let bare = Probe::of::<[f64; 3]>("type movingWallVelocity;");
        assert_eq!(bare.values([[9.0; 3]; 4]), [[0.0; 3]; 4]);
    }
}
