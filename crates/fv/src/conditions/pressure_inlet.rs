//! Velocity where the pressure is given: how fast the fluid comes in is found, its direction is not.
//!
//! The speed through a face is that of the cell behind it, which momentum and the pressure at the
//! face give; OpenFOAM takes the flux of the pass before, which converges to the same.

use super::basic::{field_text, pick};
use super::read::{leave_flux, leave_value, values};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_base::{Vec3, add, cross, dot, norm, scale, sub};
use granflow_dict::Reader;

/// Where the fluid that comes in goes.
enum Inflow {
    /// Along the normal.
    Normal,
    /// Along the normal, equally fast on all faces.
    Uniform,
    /// Along these directions, one for the patch or one per face.
    Directed(Vec<Vec3>),
    /// As in the cell.
    Free,
    /// Along the normal with this velocity along the patch, m/s.
    Tangential(Vec<Vec3>),
    /// The same, of a frame that turns about the origin with this angular velocity, rad/s.
    Rotating(Vec3),
}

struct PressureInlet {
    name: &'static str,
    inflow: Inflow,
    /// What leaves does so freely.
    outlet: bool,
}

impl PressureInlet {
    /// The velocity on face `i`; `uniform` is the mean speed out of the patch.
    fn velocity(&self, view: &PatchView<'_, Vec3>, i: usize, uniform: f64) -> Vec3 {
        let (n, cell) = (view.normal[i], view.cells[view.owner[i] as usize]);
        let speed = dot(cell, n);
        let along = |v: Vec3| v.axpy(-dot(v, n), n);
        match &self.inflow {
            Inflow::Normal => scale(n, speed),
            Inflow::Uniform => scale(n, uniform),
            Inflow::Directed(d) => {
                let d = pick(d, i);
                let through = dot(d, n);
                // A direction along the patch lets nothing through.
                if through == 0.0 { [0.0; 3] } else { scale(d, speed / through) }
            }
            Inflow::Free => cell,
            Inflow::Tangential(t) => add(along(pick(t, i)), scale(n, speed)),
            Inflow::Rotating(omega) => add(along(turning(*omega, view.centre[i])), scale(n, speed)),
        }
    }
}

/// Velocity of the fluid at rest in a frame that turns about the origin with `omega`.
pub(super) fn turning(omega: Vec3, x: Vec3) -> Vec3 {
    sub([0.0; 3], cross(omega, x))
}

use granflow_base::Value;

impl Condition<Vec3> for PressureInlet {
    fn name(&self) -> &'static str {
        self.name
    }
    fn n_totals(&self) -> usize {
        if matches!(self.inflow, Inflow::Uniform) { 2 } else { 0 }
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        for (s, cell) in view.area.iter().zip(view.owner) {
            out[0] += norm(*s);
            out[1] += dot(*s, view.cells[*cell as usize]);
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.free();
        let uniform = match view.totals {
            [area, through, ..] => through / area.max(f64::MIN_POSITIVE),
            _ => 0.0,
        };
        for i in 0..view.owner.len() {
            if self.outlet && view.flux.is_none_or(|flux| flux[i] >= 0.0) {
                continue;
            }
            closure.offset[i] = self.velocity(view, i, uniform);
            closure.slope[i] = 0.0;
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        match &self.inflow {
            Inflow::Directed(d) => vec![("inletDirection".into(), field_text(d))],
            Inflow::Tangential(t) => vec![("tangentialVelocity".into(), field_text(t))],
            Inflow::Rotating(omega) => vec![("omega".into(), super::value_text(*omega))],
            _ => Vec::new(),
        }
    }
}

/// A reader for `name`.
fn made(
    name: &'static str,
    r: &Reader<'_>,
    inflow: Inflow,
    outlet: bool,
) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    leave_flux(r);
    Box::new(PressureInlet { name, inflow, outlet })
}
fn directions(r: &Reader<'_>, c: &PatchContext<'_>) -> Inflow {
    let given = values::<Vec3>(r, "inletDirection", c.n_faces);
    if given.iter().any(|d| norm(*d) == 0.0) {
        let message = "`inletDirection` has no direction";
        r.error_at_key("inletDirection", message, "zero vector", None);
    }
    Inflow::Directed(given)
}

/// Where these come from.
const REFERENCE: &str = "OpenFOAM user guide, boundary conditions";

pub(super) const NORMAL: Entry = Entry {
    name: "pressureInletVelocity",
    summary: "where the pressure is given: along the normal, as fast as it comes",
    formula: "U_f = (U_P . n) n",
    keys: &[],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, _| made("pressureInletVelocity", r, Inflow::Normal, false)),
};
pub(super) const UNIFORM: Entry = Entry {
    name: "pressureInletUniformVelocity",
    summary: "pressureInletVelocity with the mean speed on every face",
    formula: "U_f = n sum U_P . S/sum |S|, sums over the patch",
    keys: &[],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, _| made("pressureInletUniformVelocity", r, Inflow::Uniform, false)),
};
pub(super) const DIRECTED: Entry = Entry {
    name: "pressureDirectedInletVelocity",
    summary: "where the pressure is given: along inletDirection, as fast as it comes",
    formula: "U_f = d (U_P . n)/(d . n), d = inletDirection",
    keys: &[("inletDirection", "a vector of any length, `uniform` or one a face")],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, c| made("pressureDirectedInletVelocity", r, directions(r, c), false)),
};
pub(super) const DIRECTED_OUTLET: Entry = Entry {
    name: "pressureDirectedInletOutletVelocity",
    summary: "pressureDirectedInletVelocity where the flow enters, zero gradient where it leaves",
    formula: "U_f = d (U_P . n)/(d . n) where flux < 0, else U_P; d = inletDirection",
    keys: &[("inletDirection", "a vector of any length, `uniform` or one a face")],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, c| made("pressureDirectedInletOutletVelocity", r, directions(r, c), true)),
};
pub(super) const NORMAL_OUTLET: Entry = Entry {
    name: "pressureNormalInletOutletVelocity",
    summary: "pressureInletVelocity where the flow enters, zero gradient where it leaves",
    formula: "U_f = (U_P . n) n where flux < 0, else U_P",
    keys: &[],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, _| made("pressureNormalInletOutletVelocity", r, Inflow::Normal, true)),
};
pub(super) const SLIP: Entry = Entry {
    name: "pressureInletOutletParSlipVelocity",
    summary: "where the pressure is given: as fast as it comes, and free along the patch",
    formula: "U_f = U_P, explicit where flux < 0",
    keys: &[],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, _| made("pressureInletOutletParSlipVelocity", r, Inflow::Free, true)),
};
pub(super) const OUTLET: Entry = Entry {
    name: "pressureInletOutletVelocity",
    summary: "where the pressure is given: free where the flow leaves, along the normal where it \
              enters, with tangentialVelocity along the patch if that is given",
    formula: "U_f = (U_P . n) n + T - (T . n) n where flux < 0, else U_P; T = \
              tangentialVelocity",
    keys: &[("tangentialVelocity", "m/s, `uniform` or one a face, default 0")],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, c| {
        let inflow = match r.has("tangentialVelocity") {
            true => Inflow::Tangential(values(r, "tangentialVelocity", c.n_faces)),
            false => Inflow::Normal,
        };
        made("pressureInletOutletVelocity", r, inflow, true)
    }),
};
pub(super) const ROTATING: Entry = Entry {
    name: "rotatingPressureInletOutletVelocity",
    summary: "pressureInletOutletVelocity in a frame that turns about the origin with omega (vector, \
              rad/s)",
    formula: "U_f = (U_P . n) n + V - (V . n) n where flux < 0, else U_P; V = -omega x x_f",
    keys: &[("omega", "a vector, rad/s")],
    reference: REFERENCE,
    scalar: None,
    vector: Some(|r, _| {
        let omega = r.vector("omega", granflow_base::Dims::RATE);
        made("rotatingPressureInletOutletVelocity", r, Inflow::Rotating(omega), true)
    }),
};

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;
    use granflow_base::Vec3;

    /// The patch's normal is (-1 0 0); three cells come in, the third goes out.
    const CELLS: [Vec3; 4] = [[1.0, 2.0, 0.0], [2.0, 0.0, 1.0], [-3.0, 1.0, 0.0], [4.0, 1.0, 0.0]];
    fn found(text: &str) -> [Vec3; 4] {
        Probe::of::<Vec3>(text).flux([-1.0, -1.0, 1.0, -1.0]).values(CELLS)
    }

    #[test]
    fn what_comes_in_has_the_speed_of_the_cell_and_the_direction_that_is_given() {
        let normal = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-3.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        assert_eq!(found("type pressureInletVelocity;"), normal);
        assert_eq!(found("type pressureInletUniformVelocity;"), [[1.0, 0.0, 0.0]; 4]);
        let directed = "type pressureDirectedInletVelocity; inletDirection uniform (2 1 0);";
        let along = [[1.0, 0.5, 0.0], [2.0, 1.0, 0.0], [-3.0, -1.5, 0.0], [4.0, 2.0, 0.0]];
        assert_eq!(found(directed), along);
    }

    #[test]
    fn what_leaves_is_free() {
        let mut expected = [[1.0, 0.5, 0.0], [2.0, 1.0, 0.0], CELLS[2], [4.0, 2.0, 0.0]];
        let text = "type pressureDirectedInletOutletVelocity; inletDirection uniform (2 1 0);";
        assert_eq!(found(text), expected);
        expected = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], CELLS[2], [4.0, 0.0, 0.0]];
        assert_eq!(found("type pressureNormalInletOutletVelocity;"), expected);
        assert_eq!(found("type pressureInletOutletVelocity; phi phi;"), expected);
        assert_eq!(found("type pressureInletOutletParSlipVelocity;"), CELLS);
        // The part of the given velocity along the normal does not count.
        let text = "type pressureInletOutletVelocity; tangentialVelocity uniform (3 0.5 0);";
        expected = [[1.0, 0.5, 0.0], [2.0, 0.5, 0.0], CELLS[2], [4.0, 0.5, 0.0]];
        assert_eq!(found(text), expected);
        // icoFoam v1912 gave (u, 0.1, -2 y) at (0 y 0.05) with omega (2 0 0).
        let turned = found("type rotatingPressureInletOutletVelocity; omega (2 0 0);");
        let centre = 0.25;
        assert!(turned.iter().any(|u| *u == [1.0, 2.0 * centre, -2.0 * centre]), "{turned:?}");
        let flat = "type pressureDirectedInletVelocity; inletDirection uniform (0 0 0);";
        assert!(mistakes::<Vec3>(flat).has_errors());
    }
}
