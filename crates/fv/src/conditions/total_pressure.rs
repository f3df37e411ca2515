//! The total pressure is given: fluid that enters has paid `rho U^2/2` for its speed, fluid that
//! leaves meets the pressure as it is.

use super::basic::{field_text, pick};
use super::pressure_inlet::turning;
use super::read::{field_values, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Vec3, dot, sub};
use granflow_dict::Reader;

/// The total pressure, Pa.
enum Total {
    /// One for the patch or one per face.
    Given(Vec<f64>),
    /// One for the patch against time.
    Uniform(TimeFunction<f64>),
}

/// What sets the variants apart.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// The field itself.
    Field,
    /// p, and the field is p_rgh, which lacks the weight.
    Pressure,
    /// The field in a frame that turns about the origin, rad/s.
    Rotating(Vec3),
}

/// The condition.
pub struct TotalPressure {
    name: &'static str,
    p0: Total,
    of: Of,
    /// Number of inner faces of the mesh.
    n_inner: usize,
    /// Density of the case's fluid, where the flow gives none, kg/m3.
    density: f64,
}
impl TotalPressure {
    /// Of the field itself (`totalPressure`), Pa: one for the patch or one per face.
    pub fn new(p0: Vec<f64>, n_inner: usize) -> Self {
        let (name, p0) = ("totalPressure", Total::Given(p0));
        TotalPressure { name, p0, n_inner, of: Of::Field, density: 1.0 }
    }
    fn read(r: &Reader<'_>, c: &PatchContext<'_>, name: &'static str, p0: Total, of: Of) -> Self {
        leave_value(r);
        // Names of fields, which are what they are called here, and what only gases have.
        for key in ["U", "phi", "rho", "psi", "gamma"] {
            r.ignore(key);
        }
        TotalPressure { name, p0, of, n_inner: c.n_inner, density: c.case.density }
    }
    /// What the fluid that enters through face `i` has paid, Pa.
    fn paid(&self, view: &PatchView<'_, f64>, i: usize) -> f64 {
        let at = view.first_boundary(self.n_inner) + i;
        let Of::Rotating(omega) = self.of else {
            return view.around.dynamic_pressure.get(at).copied().unwrap_or(0.0);
        };
        let u = view.around.face_velocity.get(at).copied().unwrap_or_default();
        let relative = sub(u, turning(omega, view.centre[i]));
        let cell = view.owner[i] as usize;
        let rho = view.around.density.get(cell).copied().unwrap_or(self.density);
        0.5 * rho * dot(relative, relative)
    }
}
impl Condition<f64> for TotalPressure {
    fn name(&self) -> &'static str {
        self.name
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.fix(0.0);
        let g = view.around.gravity;
        for i in 0..view.owner.len() {
            let mut p = match &self.p0 {
                Total::Given(v) => pick(v, i),
                Total::Uniform(f) => f.at(view.around.time),
            };
            if view.flux.is_some_and(|flux| flux[i] < 0.0) {
                p -= self.paid(view, i);
            }
            if self.of == Of::Pressure {
                let rho = view.around.density.get(view.owner[i] as usize).copied().unwrap_or(0.0);
                p -= rho * dot(g, view.centre[i]);
            }
            closure.offset[i] = p;
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = match &self.p0 {
            Total::Given(v) => vec![("p0".into(), field_text(v))],
            Total::Uniform(f) => f.entries("p0"),
        };
        if let Of::Rotating(omega) = self.of {
            out.push(("omega".into(), super::value_text(omega)));
        }
        out
    }
}

/// Where these come from.
const REFERENCE: &str = "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.5";

pub(super) const TOTAL: Entry = Entry {
    name: "totalPressure",
    summary: "the pressure less rho U^2/2 where the flow enters, as it is where it leaves",
    formula: "p_f = p0 - rho |U_f|^2/2 where flux < 0, else p0",
    keys: &[("p0", "Pa (m2/s2 of a kinematic pressure), `uniform` or one a face")],
    reference: REFERENCE,
    scalar: Some(|r, c| {
        let p0 = Total::Given(field_values(r, "p0", c));
        Box::new(TotalPressure::read(r, c, "totalPressure", p0, Of::Field))
    }),
    vector: None,
};
pub(super) const OF_PRESSURE: Entry = Entry {
    name: "prghTotalPressure",
    summary: "totalPressure of p where the field is p_rgh = p - rho G.x",
    formula: "p_rgh,f = p0 - rho_P g . x_f - rho |U_f|^2/2 where flux < 0, else without the \
              last term",
    keys: &[("p0", "Pa, `uniform` or one a face")],
    reference: REFERENCE,
    scalar: Some(|r, c| {
        let p0 = Total::Given(field_values(r, "p0", c));
        Box::new(TotalPressure::read(r, c, "prghTotalPressure", p0, Of::Pressure))
    }),
    vector: None,
};
pub(super) const UNIFORM: Entry = Entry {
    name: "uniformTotalPressure",
    summary: "totalPressure with one value for the patch, a function of time",
    formula: "p_f = p0(t) - rho |U_f|^2/2 where flux < 0, else p0(t)",
    keys: &[("p0", "Pa (m2/s2 of a kinematic pressure), a function of time")],
    reference: REFERENCE,
    scalar: Some(|r, c| {
        let p0 = Total::Uniform(TimeFunction::read(r, "p0", c.dims, c.case).times(c.factor));
        Box::new(TotalPressure::read(r, c, "uniformTotalPressure", p0, Of::Field))
    }),
    vector: None,
};
pub(super) const ROTATING: Entry = Entry {
    name: "rotatingTotalPressure",
    summary: "totalPressure in a frame that turns about the origin with omega (vector, rad/s)",
    formula: "p_f = p0 - rho |U_f + omega x x_f|^2/2 where flux < 0, else p0",
    keys: &[
        ("p0", "Pa (m2/s2 of a kinematic pressure), `uniform` or one a face"),
        ("omega", "a vector, rad/s"),
    ],
    reference: REFERENCE,
    scalar: Some(|r, c| {
        let p0 = Total::Given(field_values(r, "p0", c));
        let omega = r.vector("omega", granflow_base::Dims::RATE);
        Box::new(TotalPressure::read(r, c, "rotatingTotalPressure", p0, Of::Rotating(omega)))
    }),
    vector: None,
};

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn what_enters_has_paid_for_its_speed() {
        let text = "type uniformTotalPressure; p0 table ((0 0) (2 20)); rho none; psi none;";
        // Nothing is said of the speed here; the dynamic pressure is that of the flow's tests.
        let found = Probe::of::<f64>(text).at(1.0).flux([1.0; 4]).values([3.0; 4]);
        assert_eq!(found, [10.0; 4]);
        // icoFoam v1912 gave 0.9934445 with U (0.1145033 0.1 -0.1) at (0 0.05 0.05).
        let text = "type rotatingTotalPressure; omega (2 0 0); p0 uniform 10;";
        let turned = |y: f64, z: f64| [3.0, 2.0 * z, -2.0 * y];
        let u = [turned(0.25, 0.25), turned(0.75, 0.25), turned(0.25, 0.75), turned(0.75, 0.75)];
        let flux = [-1.0, -1.0, -1.0, 1.0];
        let found = Probe::of::<f64>(text).flux(flux).density([2.0; 4]).velocity(u);
        assert_eq!(found.values([3.0; 4]), [1.0, 1.0, 1.0, 10.0]);
    }
}
