//! A profile along a direction.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView, value_text};
use crate::conditions::CaseContext;
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Value, Vec3, dot};
use granflow_dict::{Reader, number};

/// Dirichlet: a function of `direction . x - origin`.
struct FixedProfile<T> {
    /// Against the distance along the direction, m.
    profile: TimeFunction<T>,
    /// Unit vector.
    direction: Vec3,
    /// Where the profile begins along the direction, m.
    origin: f64,
}
impl<T: Value> Condition<T> for FixedProfile<T> {
    fn name(&self) -> &'static str {
        "fixedProfile"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(T::ZERO);
        for (o, x) in closure.offset.iter_mut().zip(view.centre) {
            *o = self.profile.at(dot(self.direction, *x) - self.origin);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = self.profile.entries("profile");
        out.push(("direction".into(), value_text(self.direction)));
        out.push(("origin".into(), number(self.origin)));
        out
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "fixedProfile",
    summary: "Dirichlet: a function of the distance along a direction, written as functions of time are",
    formula: "phi_f = profile(d . x_f - origin), d = direction/|direction|",
    keys: &[
        ("profile", "units of the field, written as a function of time is, of a distance in m"),
        ("direction", "a vector, of any length"),
        ("origin", "m along the direction, where the profile begins"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(read),
    vector: Some(read),
};
fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    // What it is a function of is not time.
    let case = CaseContext { times: None, ..c.case };
    let direction = r.direction("direction");
    Box::new(FixedProfile {
        profile: TimeFunction::read(r, "profile", c.dims, case).times(c.factor),
        direction,
        origin: r.scalar("origin", Dims::LENGTH),
    })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn a_parabola_across_the_patch() {
        let text = "type fixedProfile; profile polynomial ((4 1) (-4 2)); direction (0 2 0); \
                    origin 0;";
        // At y = 1/4 and 3/4: 4 y (1 - y).
        assert_eq!(Probe::of::<f64>(text).values([9.0; 4]), [0.75; 4]);
        let text = "type fixedProfile; profile table ((0 (0 0 0)) (1 (1 0 0))); \
                    direction (0 1 0); origin 0.25;";
        let mut found = Probe::of::<[f64; 3]>(text).values([[9.0; 3]; 4]).map(|u| u[0]);
        found.sort_by(f64::total_cmp);
        assert_eq!(found, [0.0, 0.0, 0.5, 0.5]);
    }
}
