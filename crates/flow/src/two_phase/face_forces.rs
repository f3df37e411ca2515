//! Forces on faces: what pressure, weight and surface tension leave of each other.
//!
//! Between the cells of a face the pressure jumps by `p_N - p_P`; weight and surface tension ask
//! for a jump of `-(G.x)(rho_N - rho_P) + sigma K (alpha_N - alpha_P)`. The difference per length
//! moves the fluid. Its non-orthogonal part comes from cell gradients of these differences, not
//! from gradients of p and of rho apart: where every face balances, so does every correction.

use super::TwoPhase;
use crate::{Flow, State};
use granflow_base::{Dims, Tensor, Value, Vec3, apply, dot, inverse_symmetric, norm, scale, unit};
use granflow_fv::{Differentiable, FaceField, Reconstruction, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(crate) struct FaceForces {
    /// Jump of the pressure that weight and surface tension ask for, owner to neighbour, Pa.
    pub(crate) jump: FaceField<f64>,
    /// Normal derivative of pressure beyond that, Pa/m.
    pub(crate) imbalance: Vec<f64>,
    /// Whether the flux through a boundary face follows from the pressure given there.
    pub(crate) open: Vec<bool>,
    /// The jump of boundary faces per length: a gradient of pressure that balances it, Pa/m.
    pub(crate) wall_gradient: Vec<f64>,
    /// Cell gradients of the differences, ghosts included; used on meshes that lean.
    gradient: Vec<Vec3>,
    /// `(sum e e^T)^-1` with e the unit vectors of the differences.
    fit: Vec<Tensor>,
    rebuild: Reconstruction,
}

impl FaceForces {
    pub(crate) fn new(mesh: &Mesh, p: &Unknown<f64>) -> FaceForces {
        let mut open = vec![false; mesh.n_faces() - mesh.n_inner];
        for (patch, condition) in mesh.patches.iter().zip(&p.conditions) {
            for f in patch.faces.clone() {
                open[f - mesh.n_inner] = condition.fixes_value();
            }
        }
        let leaning = mesh.max_nonorth_deg > 0.1;
        let fit = |c: usize| {
            let mut m = [0.0; 9];
            for (f, _) in mesh.faces_of(c) {
                let e = direction(mesh, &open, f);
                m = m.axpy(1.0, Vec3::dyad(e, e));
            }
            inverse_symmetric(&mesh.fit_to_invert(m))
        };
        FaceForces {
            jump: FaceField::new(mesh, "jump", Dims::PRESSURE, 0.0),
            imbalance: vec![0.0; mesh.n_faces()],
            wall_gradient: vec![0.0; mesh.n_faces() - mesh.n_inner],
            gradient: if leaning { vec![[0.0; 3]; mesh.n_all()] } else { Vec::new() },
            fit: if leaning { (0..mesh.n_cells).map(fit).collect() } else { Vec::new() },
            rebuild: Reconstruction::new(mesh),
            open,
        }
    }

    /// The imbalance of the pressure `p` on every face; none where the velocity is given.
    /// `limit` as for [`granflow_fv::operators::non_orthogonal_flux`].
    pub(crate) fn balance(&mut self, exec: &Exec, mesh: &Mesh, p: &Unknown<f64>, limit: f64) {
        self.balance_jumps(exec, mesh, p, limit, 1.0);
    }

    /// The same with `share` of the jumps that weight and surface tension ask for.
    fn balance_jumps(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        p: &Unknown<f64>,
        limit: f64,
        share: f64,
    ) {
        let FaceForces { jump, imbalance, open, gradient, fit, .. } = self;
        let (jump, open) = (&jump.data, &open[..]);
        let jump = |f: usize| share * jump[f];
        let difference = |f: usize| {
            let o = mesh.owner[f] as usize;
            match mesh.neighbour.get(f) {
                Some(&n) => p.cells.data[n as usize] - p.cells.data[o] - jump(f),
                None if open[f - mesh.n_inner] => {
                    p.boundary_value(mesh, f) - p.cells.data[o] - jump(f)
                }
                None => 0.0,
            }
        };
        // Beyond, corrections that lag behind would grow.
        let limit = if mesh.max_nonorth_deg > STEEPEST { limit.min(0.5) } else { limit };
        let leaning = !gradient.is_empty() && limit > 0.0;
        if leaning {
            exec.for_each(&mut gradient[..mesh.n_cells], |first, out| {
                for (i, g) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let mut sum = [0.0; 3];
                    for (f, _) in mesh.faces_of(c) {
                        let e = direction(mesh, open, f);
                        sum = sum.axpy(difference(f) / norm(mesh.delta[f]), e);
                    }
                    *g = apply(&fit[c], sum);
                }
            });
            mesh.halo.update(exec, gradient);
        }
        let gradient = &*gradient;
        exec.for_each(imbalance, |first, out| {
            for (i, b) in out.iter_mut().enumerate() {
                let f = first + i;
                let compact = difference(f) * mesh.inv_dist[f];
                *b = compact;
                let closed = f >= mesh.n_inner && !open[f - mesh.n_inner];
                if !leaning || closed {
                    continue;
                }
                let o = mesh.owner[f] as usize;
                let g = match mesh.neighbour.get(f) {
                    Some(&n) => {
                        let w = mesh.weight[f];
                        gradient[o].scaled(w).axpy(1.0 - w, gradient[n as usize])
                    }
                    None => gradient[o],
                };
                let mut part = dot(g, mesh.nonorth[f]);
                if limit < 1.0 {
                    let most = limit / (1.0 - limit) * compact.abs();
                    part = part.clamp(-most, most);
                }
                *b += part;
            }
        });
    }

    /// What drives cells (ghosts included) and faces: the imbalance of a pressure (`whole`), or of a
    /// change of it.
    pub(crate) fn slopes(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        (p, rho): (&Unknown<f64>, &[f64]),
        (limit, whole): (f64, bool),
        (cells, faces): (&mut [Vec3], &mut [f64]),
    ) {
        self.balance_jumps(exec, mesh, p, limit, if whole { 1.0 } else { 0.0 });
        faces.copy_from_slice(&self.imbalance);
        let forces = &*self;
        exec.for_each(&mut cells[..mesh.n_cells], |first, out| {
            out.iter_mut()
                .enumerate()
                .for_each(|(i, g)| *g = forces.by_density(mesh, rho, first + i));
        });
        mesh.halo.update(exec, cells);
    }

    /// The vector in cell `c` whose normal parts are `imbalance` on its faces, Pa/m.
    #[inline]
    pub(crate) fn in_cell(&self, mesh: &Mesh, c: usize) -> Vec3 {
        let mut sum = [0.0; 3];
        for (f, _) in mesh.faces_of(c) {
            sum = sum.axpy(self.imbalance[f], mesh.area[f]);
        }
        self.rebuilt(c, sum)
    }

    /// The force on cell `c`, Pa/m: its density times the vector whose normal parts are `imbalance/rho` on
    /// its faces. Beside an interface accelerations are smooth and forces are not. Without inertia this gives
    /// the face the pressure of the lighter fluid, as beside grains it must. (Corrections of the pressure alone
    /// are nearer to interFoam with [`Self::in_cell`]: the front of `dam_break` moves by a third of the
    /// difference.)
    #[inline]
    fn by_density(&self, mesh: &Mesh, rho: &[f64], c: usize) -> Vec3 {
        let mut sum = [0.0; 3];
        for (f, _) in mesh.faces_of(c) {
            let o = rho[mesh.owner[f] as usize];
            let on_face = match mesh.neighbour.get(f) {
                Some(&n) => o + (1.0 - mesh.weight[f]) * (rho[n as usize] - o),
                None => o,
            };
            sum = sum.axpy(self.imbalance[f] * (rho[c] / on_face), mesh.area[f]);
        }
        self.rebuilt(c, sum)
    }

    /// The vector in cell `c` for which `sum` is the sum of its normal parts times the area vectors.
    #[inline]
    pub(crate) fn rebuilt(&self, c: usize, sum: Vec3) -> Vec3 {
        self.rebuild.vector(c, sum)
    }
}

/// Greatest lean of faces with the whole non-orthogonal correction, degrees.
const STEEPEST: f64 = 50.0;
/// Least share of a fluid that has weight. Of water in air a billionth weighs a millionth as much as
/// the air; but rounding that has weight makes still water flow.
const SLIVER: f64 = 1e-9;

/// A volume fraction without slivers.
#[inline]
fn whole(a: f64) -> f64 {
    if a < SLIVER {
        0.0
    } else if a > 1.0 - SLIVER {
        1.0
    } else {
        a
    }
}

/// Along which the difference over face `f` is taken: between centres, and the normal where the
/// normal derivative is known.
#[inline]
fn direction(mesh: &Mesh, open: &[bool], f: usize) -> Vec3 {
    if f < mesh.n_inner || open[f - mesh.n_inner] {
        unit(mesh.delta[f])
    } else {
        scale(mesh.area[f], 1.0 / mesh.mag_area[f])
    }
}

impl Flow {
    /// The jumps that weight and surface tension ask for, with the interface as it stands.
    /// Conditions of alpha are up to date on return.
    pub(crate) fn update_face_forces(&mut self) {
        let Flow { exec, mesh, state, two_phase, gravity, fluid, .. } = self;
        let State { alpha, time, phi, .. } = state;
        let (Some(two), Some(alpha)) = (two_phase, alpha) else { return };
        let TwoPhase { work: t, sigma, rho_2, vof, .. } = &mut **two;
        let around = granflow_fv::Surroundings {
            time: *time,
            contact_gradient: &t.tension.contact_gradient,
            ..granflow_fv::Surroundings::default()
        };
        alpha.update(exec, mesh, &around, Some(phi));
        if *sigma != 0.0 {
            t.tension.update(exec, mesh, alpha, vof);
        }
        t.levels.update(exec, mesh, alpha);
        let weighs = gravity.hydrostatic != [0.0; 3];
        let change = fluid.rho - *rho_2;
        let (a, sigma) = (&alpha.cells.data, *sigma);
        let (levels, tension, alpha) = (&t.levels, &t.tension, &*alpha);
        exec.for_each(&mut t.forces.jump.data, |first, out| {
            for (i, jump) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = mesh.owner[f] as usize;
                let (d_rho, d_alpha) = match mesh.neighbour.get(f) {
                    Some(&n) => {
                        let n = n as usize;
                        (change * (whole(a[n]) - whole(a[o])), a[n] - a[o])
                    }
                    None => {
                        let d = alpha.boundary_value(mesh, f) - a[o];
                        (change * (whole(a[o] + d) - whole(a[o])), d)
                    }
                };
                *jump = 0.0;
                if weighs && d_rho != 0.0 {
                    *jump -= levels.on_face(mesh, f) * d_rho;
                }
                if sigma != 0.0 && d_alpha != 0.0 {
                    *jump += sigma * tension.on_face(mesh, f) * d_alpha;
                }
            }
        });
        let jump = &t.forces.jump.data[mesh.n_inner..];
        for (b, gradient) in t.forces.wall_gradient.iter_mut().enumerate() {
            *gradient = jump[b] * mesh.inv_dist[mesh.n_inner + b];
        }
    }
}
