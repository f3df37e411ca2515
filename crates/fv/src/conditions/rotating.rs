//! A wall that turns about an axis.

use super::basic::text;
use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Vec3, cross, scale, sub};
use granflow_dict::Reader;

/// Velocity of a solid body turning about an axis: `omega(t) axis x (x - origin)`, without slip.
pub struct RotatingWall {
    /// A point of the axis, m.
    pub origin: Vec3,
    /// Unit vector along the axis.
    pub axis: Vec3,
    /// Angular velocity in rad/s against time.
    pub omega: TimeFunction<f64>,
}
impl Condition<Vec3> for RotatingWall {
    fn name(&self) -> &'static str {
        "rotatingWallVelocity"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let omega = scale(self.axis, self.omega.at(view.around.time));
        for (i, o) in closure.offset.iter_mut().enumerate() {
            let v = cross(omega, sub(view.centre[i], self.origin));
            // A facet of a round wall must not push material through itself.
            let n = view.normal[i];
            *o = sub(v, scale(n, granflow_base::dot(v, n)));
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = vec![("origin".into(), text(self.origin)), ("axis".into(), text(self.axis))];
        out.extend(self.omega.entries("omega"));
        out
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "rotatingWallVelocity",
    summary: "no slip on a wall that turns about an axis, omega a function of time",
    formula: "U_f = V - (V . n) n, V = omega(t) a x (x_f - origin), a = axis/|axis|",
    keys: &[
        ("origin", "a point of the axis, m"),
        ("axis", "a vector of any length"),
        ("omega", "rad/s, a function of time"),
    ],
    reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 4.5",
    scalar: None,
    vector: Some(rotating_wall),
};

fn rotating_wall(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let origin = r.vector("origin", Dims::LENGTH);
    let axis = r.direction("axis");
    let omega = TimeFunction::read(r, "omega", Dims::RATE, c.case);
    Box::new(RotatingWall { origin, axis, omega })
}
