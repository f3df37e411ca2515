//! A wall that holds what touches it as far as its friction reaches.

use super::basic::text;
use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_base::{Dims, Value, Vec3, dot, norm, scale, sub};
use granflow_dict::{Reader, number};

/// Coulomb friction between material and a wall, as a complementarity without regularisation:
///
/// stick: `U = U_wall`           where the traction that this takes is at most `mu P`,
/// slide: traction `mu P` against `U - U_wall`   elsewhere; nothing goes through the wall.
///
/// With the viscosity `eta` (Pa s) of the face and the distance `h` (m) of the cell's centre, the
/// wall holds the cell with `t = eta |U_cell - U_wall|/h` (Pa, tangential) if it sticks. So it
/// slides where `t > mu P`, with `dU/dn = -(mu P/eta) (U - U_wall)/|U - U_wall|`: of grains,
/// `eta = P/g`, the gradient is `mu g` whatever the viscosity. What tells the two apart is the
/// state of the cell alone, so that both hold exactly for the state that the residuals are
/// measured on (M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2003) 865). But where a pass of
/// an iteration, the drag held, has turned the sliding round, the wall holds for the next pass:
/// what that takes tells which way it goes.
pub struct CoulombFriction {
    /// Friction coefficient.
    pub mu: f64,
    /// Velocity of the wall, m/s; what is normal to a face does not count.
    pub wall_velocity: Vec3,
    /// Number of inner faces of the mesh.
    pub n_inner: usize,
}

impl Condition<Vec3> for CoulombFriction {
    fn name(&self) -> &'static str {
        "coulombFriction"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        let (around, first) = (view.around, view.first_boundary(self.n_inner));
        let at = |field: &[f64], i: usize| field.get(first + i).copied().unwrap_or(0.0);
        for (i, n) in view.normal.iter().enumerate() {
            let along = |v: Vec3| v.axpy(-dot(v, *n), *n);
            let wall = along(self.wall_velocity);
            let apart = sub(along(view.cells[view.owner[i] as usize]), wall);
            let distance = norm(apart);
            // Without a viscosity there is no traction yet.
            let held = at(around.wall_viscosity, i) * view.inv_dist[i];
            let limit = self.mu * at(around.wall_pressure, i).max(0.0);
            // What fills the rest of the face sticks to the wall.
            let stuck = if held > 0.0 {
                (at(around.wall_fluid, i) * view.inv_dist[i] / held).min(1.0)
            } else {
                0.0
            };
            let slid = around.slid.get(first + i).copied().unwrap_or_default();
            let slides = (1.0 - stuck) * held * distance > limit && dot(apart, slid) >= 0.0;
            (closure.offset[i], closure.slope[i], closure.normal[i]) = if slides {
                let drag = scale(apart, -limit / (held * distance));
                (drag.axpy(stuck, wall), 1.0 - stuck, 1.0 - stuck)
            } else {
                (wall, 0.0, 0.0)
            };
        }
    }
    fn friction(&self) -> Option<(f64, Vec3)> {
        Some((self.mu, self.wall_velocity))
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("mu".into(), number(self.mu)), ("wallVelocity".into(), text(self.wall_velocity))]
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "coulombFriction",
    summary: "a wall that holds up to the traction mu P; beyond it the material slides and \
              mu P drags it (no regularisation)",
    formula: "U_f = V where eta |W|/h <= mu p, else dU/dn = -(mu p/eta) W/|W| along the \
              wall and U_f . n = 0; V = wallVelocity along the wall, W = U_P - V along the \
              wall",
    keys: &[
        ("mu", "friction coefficient of the wall"),
        ("wallVelocity", "m/s; what is normal to the wall does not count"),
    ],
    reference: "G. Duvaut, J.-L. Lions, Inequalities in Mechanics and Physics, 1976, ch. 3.5",
    scalar: None,
    vector: Some(coulomb_friction),
};

fn coulomb_friction(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let mu = r.non_negative("mu", Dims::NONE);
    let wall_velocity = r.vector("wallVelocity", c.dims);
    Box::new(CoulombFriction { mu, wall_velocity, n_inner: c.n_inner })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Affine, Surroundings};

    /// Three cells 0.1 m from a wall that moves at 1 m/s (what is normal to it does not count),
    /// viscosity 2 Pa s, limit 0.5 x 8 Pa: it holds what differs by up to 0.2 m/s.
    #[test]
    fn it_holds_what_friction_can_and_drags_the_rest() {
        let around = Surroundings {
            wall_pressure: &[8.0, 8.0, -1.0],
            wall_viscosity: &[2.0; 3],
            ..Surroundings::default()
        };
        let view = PatchView {
            faces: 7..10,
            inv_dist: &[10.0; 3],
            area: &[[1.0, 0.0, 0.0]; 3],
            normal: &[[1.0, 0.0, 0.0]; 3],
            centre: &[[0.0; 3]; 3],
            owner: &[0, 1, 2],
            owner_centre: &[[0.0; 3]; 3],
            cells: &[[0.3, 1.19, 0.0], [0.3, 1.3, 0.4], [0.0, 0.9, 0.0]],
            flux: None,
            totals: &[],
            around: &around,
        };
        let mut closure = Affine::zero_gradient(3);
        let mut wall = CoulombFriction { mu: 0.5, wall_velocity: [9.0, 1.0, 0.0], n_inner: 7 };
        wall.update(&view, &mut closure.patch(0..3));
        assert_eq!((closure.offset[0], closure.slope[0]), ([0.0, 1.0, 0.0], 0.0));
        // (0.3, 0.4) from the wall, of length 0.5, less 0.2 of it.
        assert!(norm(sub(closure.offset[1], [0.0, -0.12, -0.16])) < 1e-15, "{:?}", closure.offset);
        assert_eq!((closure.slope[1], closure.normal[1]), (1.0, 1.0));
        // Grains that are pulled off the wall are not held at all.
        assert_eq!((closure.offset[2], closure.slope[2]), ([0.0, 0.0, 0.0], 1.0));
    }
}
