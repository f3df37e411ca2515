//! Convection of momentum in a Crank-Nicolson step of two fluids.
//!
//! One mass flux m, that of the interface's move, carries the mass of a whole step. So it carries the mean of
//! the velocities at both ends as well, `m (U + psi U0)/(1 + psi)`: then a velocity that is the same everywhere
//! stays so, whatever the density does. What the scheme hands on from step to step are forces alone. Were
//! convection handed on with them, mass would have moved with the flux of this step, and its momentum half with
//! that of the step before.

use granflow_base::{Value, Vec3};
use granflow_fv::Unknown;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// What carries momentum through the faces: the matrix has `flux` times the velocity by `weights`.
pub(crate) struct Carried<'a> {
    /// Mass flux, kg/s.
    pub(crate) flux: &'a [f64],
    /// Share of the owner's velocity on inner faces.
    pub(crate) weights: &'a [f64],
    /// What the scheme adds to that on inner faces, N.
    pub(crate) correction: Option<&'a [Vec3]>,
}

impl Carried<'_> {
    fn through(&self, mesh: &Mesh, u: &Unknown<Vec3>, cells: &[Vec3], f: usize) -> Vec3 {
        let here = cells[mesh.owner[f] as usize];
        let value = match mesh.neighbour.get(f) {
            Some(&n) => {
                let w = self.weights[f];
                here.scaled(w).axpy(1.0 - w, cells[n as usize])
            }
            None => u.boundary_value_beside(mesh, f, here),
        };
        value.scaled(self.flux[f])
    }
}

/// What the flux carried, beyond what the matrix has.
#[derive(Default)]
pub(crate) struct Convected {
    /// Velocity on faces at the old time, m/s.
    old: Vec<Vec3>,
    /// Momentum that is no part of the matrix, N.
    beyond: Vec<Vec3>,
}

impl Convected {
    /// Adds to `explicit` (a force, owner to neighbour) what the old velocity asks for, `-psi m U0`. `old` are
    /// the cells' velocities at the old time in the first pass of a step, when the weights are theirs.
    pub(crate) fn hold(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        (carried, old, psi): (&Carried<'_>, Option<&[Vec3]>, f64),
        explicit: &mut [Vec3],
    ) {
        self.old.resize(mesh.n_faces(), [0.0; 3]);
        self.beyond.resize(mesh.n_faces(), [0.0; 3]);
        let (flux, n_inner) = (carried.flux, mesh.n_inner);
        let correction = |f: usize| match carried.correction {
            Some(correction) if f < n_inner => correction[f],
            _ => [0.0; 3],
        };
        if let Some(cells) = old {
            exec.for_each(&mut self.old, |first, out| {
                for (i, value) in out.iter_mut().enumerate() {
                    let f = first + i;
                    let all = carried.through(mesh, u, cells, f).axpy(1.0, correction(f));
                    *value = if flux[f] == 0.0 { [0.0; 3] } else { all.scaled(1.0 / flux[f]) };
                }
            });
        }
        let old = &self.old;
        exec.for_each2(&mut self.beyond, explicit, |first, beyond, explicit| {
            for i in 0..beyond.len() {
                let f = first + i;
                let of_old = old[f].scaled(psi * flux[f]);
                beyond[i] = of_old.axpy(1.0, correction(f));
                explicit[i] = explicit[i].axpy(-1.0, of_old);
            }
        });
    }

    /// Whether momentum has been assembled.
    pub(crate) fn is_known(&self) -> bool {
        !self.beyond.is_empty()
    }

    /// What leaves cell `c` in all, `m (U + psi U0)` with the velocity as it stands, N.
    pub(crate) fn leaves(
        &self,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        carried: &Carried<'_>,
        c: usize,
    ) -> Vec3 {
        let mut sum = [0.0; 3];
        for (f, s) in mesh.faces_of(c) {
            let all = carried.through(mesh, u, &u.cells.data, f).axpy(1.0, self.beyond[f]);
            sum = sum.axpy(s, all);
        }
        sum
    }
}
