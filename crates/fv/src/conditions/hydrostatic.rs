//! Pressure of a fluid at rest above a patch.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView, value_text};
use granflow_base::{Dims, Vec3, dot, sub};
use granflow_dict::{Reader, number};

/// `pRef + rho g . (x - xRef)` with one density, on the whole of a face or on the part that fluid 1
/// fills.
struct Hydrostatic {
    /// kg/m3, or 1 where the pressure is kinematic.
    density: f64,
    /// Units of the field inside.
    pressure: f64,
    /// Where the pressure is that, m.
    point: Vec3,
    /// Number of inner faces, where the fraction on a face is the share of the value.
    by_fraction: Option<usize>,
    /// What `entries` gives back: density and pressure in the units of the file.
    given: (f64, f64),
}
impl Condition<f64> for Hydrostatic {
    fn name(&self) -> &'static str {
        match self.by_fraction {
            None => "uniformDensityHydrostaticPressure",
            Some(_) => "phaseHydrostaticPressure",
        }
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        let weight = |x: Vec3| self.density * dot(view.around.gravity, sub(x, self.point));
        for (i, x) in view.centre.iter().enumerate() {
            let share = self.by_fraction.map_or(1.0, |n_inner| {
                let at = view.first_boundary(n_inner) + i;
                view.around.face_fraction.get(at).map_or(1.0, |a| a.clamp(0.0, 1.0))
            });
            closure.offset[i] = share * (self.pressure + weight(*x));
            closure.slope[i] = 1.0 - share;
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![
            ("rho".into(), number(self.given.0)),
            ("pRefValue".into(), number(self.given.1)),
            ("pRefPoint".into(), value_text(self.point)),
        ]
    }
}

fn read(
    r: &Reader<'_>,
    c: &PatchContext<'_>,
    by_fraction: Option<usize>,
) -> Box<dyn Condition<f64>> {
    leave_value(r);
    let density = r.non_negative("rho", Dims::DENSITY);
    let pressure = r.scalar("pRefValue", c.dims);
    let point = r.vector("pRefPoint", Dims::LENGTH);
    Box::new(Hydrostatic {
        density: density * c.factor,
        pressure: pressure * c.factor,
        point,
        by_fraction,
        given: (density, pressure),
    })
}

pub(super) const UNIFORM: Entry = Entry {
    name: "uniformDensityHydrostaticPressure",
    summary: "pRefValue + rho g.(x - pRefPoint), the pressure of a fluid at rest",
    formula: "p_f = pRefValue + rho g . (x_f - pRefPoint)",
    keys: &[("rho", "kg/m3"), ("pRefValue", "Pa"), ("pRefPoint", "m")],
    reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 1.4",
    scalar: Some(|r, c| read(r, c, None)),
    vector: None,
};
pub(super) const OF_PHASE: Entry = Entry {
    name: "phaseHydrostaticPressure",
    summary: "the same as far as the first fluid fills a face, zero gradient as far as it does not",
    formula: "p_f = a (pRefValue + rho g . (x_f - pRefPoint)) + (1 - a) p_P, a: fraction of \
              the first fluid on the face",
    keys: &[
        ("rho", "kg/m3"),
        ("pRefValue", "Pa"),
        ("pRefPoint", "m"),
        ("phaseFraction", "name of the fraction, of which there is one"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(|r, c| {
        // The name of the fraction, of which there is one.
        r.ignore("phaseFraction");
        r.ignore("phase");
        read(r, c, Some(c.n_inner))
    }),
    vector: None,
};

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn the_weight_of_what_is_above() {
        let settings = "rho 1000; pRefValue 5; pRefPoint (0 0 1);";
        let text = format!("type uniformDensityHydrostaticPressure; {settings}");
        let down = [0.0, 0.0, -10.0];
        let mut found = Probe::of::<f64>(&text).gravity(down).values([1.0; 4]);
        found.sort_by(f64::total_cmp);
        assert_eq!(found, [2505.0, 2505.0, 7505.0, 7505.0]);
        let text = format!("type phaseHydrostaticPressure; {settings}");
        let alpha = [0.0, 1.0, 0.5, 0.5];
        let found = Probe::of::<f64>(&text).gravity(down).fraction(alpha).values([1.0; 4]);
        assert_eq!(found[0], 1.0);
        assert!(found[1] == 2505.0 || found[1] == 7505.0);
        assert!(found[2] == 1253.0 || found[2] == 3753.0);
    }
}
