//! A given speed along the normal.

use super::basic::{field_text, pick};
use super::read::{leave_value, values};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Vec3, scale};
use granflow_dict::Reader;

/// The speed out of the patch, m/s.
enum Speed {
    /// One for the patch or one per face.
    Given(Vec<f64>),
    /// One for the patch against time.
    Uniform(TimeFunction<f64>),
}

/// `U = speed * n`, the normal pointing out of the domain.
struct SurfaceNormal {
    speed: Speed,
    /// A factor against time.
    ramp: Option<TimeFunction<f64>>,
}
impl Condition<Vec3> for SurfaceNormal {
    fn name(&self) -> &'static str {
        match self.speed {
            Speed::Given(_) => "surfaceNormalFixedValue",
            Speed::Uniform(_) => "uniformNormalFixedValue",
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let time = view.around.time;
        let factor = self.ramp.as_ref().map_or(1.0, |f| f.at(time));
        for (i, n) in view.normal.iter().enumerate() {
            let speed = match &self.speed {
                Speed::Given(v) => pick(v, i),
                Speed::Uniform(f) => f.at(time),
            };
            closure.offset[i] = scale(*n, factor * speed);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = match &self.speed {
            Speed::Given(v) => vec![("refValue".into(), field_text(v))],
            Speed::Uniform(f) => f.entries("uniformValue"),
        };
        out.extend(self.ramp.iter().flat_map(|f| f.entries("ramp")));
        out
    }
}

pub(super) const GIVEN: Entry = Entry {
    name: "surfaceNormalFixedValue",
    summary: "Dirichlet: a given speed along the outward normal (inflow is negative)",
    formula: "U_f = ramp(t) refValue n",
    keys: &[
        ("refValue", "m/s, positive outwards, `uniform` or one a face"),
        ("ramp", "a function of time, default 1"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| read(r, c, Speed::Given(values(r, "refValue", c.n_faces)))),
};
pub(super) const UNIFORM: Entry = Entry {
    name: "uniformNormalFixedValue",
    summary: "Dirichlet: one speed along the outward normal, a function of time (inflow is negative)",
    formula: "U_f = ramp(t) uniformValue(t) n",
    keys: &[
        ("uniformValue", "m/s, positive outwards, a function of time"),
        ("ramp", "a function of time, default 1"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| {
        read(r, c, Speed::Uniform(TimeFunction::read(r, "uniformValue", c.dims, c.case)))
    }),
};
fn read(r: &Reader<'_>, c: &PatchContext<'_>, speed: Speed) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let ramp = TimeFunction::opt_read(r, "ramp", granflow_base::Dims::NONE, c.case);
    Box::new(SurfaceNormal { speed, ramp })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn speeds_point_out_of_the_patch() {
        let text = "type surfaceNormalFixedValue; refValue nonuniform List<scalar> 4 (1 -1 0 2); \
                    ramp linearRamp; duration 2;";
        let found = Probe::of::<[f64; 3]>(text).at(1.0).values([[9.0; 3]; 4]);
        assert_eq!(found.map(|u| u[0]), [-0.5, 0.5, 0.0, -1.0]);
        let text = "type uniformNormalFixedValue; uniformValue table ((0 0) (0.4 -1));";
        let found = Probe::of::<[f64; 3]>(text).at(0.2).values([[9.0; 3]; 4]);
        assert_eq!(found, [[0.5, 0.0, 0.0]; 4]);
    }
}
