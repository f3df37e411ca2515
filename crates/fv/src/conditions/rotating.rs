//! A wall that turns about an axis.

use super::basic::text;
use super::{Condition, PatchClosure, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Vec3, cross, scale, sub};

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
