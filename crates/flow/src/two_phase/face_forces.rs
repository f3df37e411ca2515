//! Forces on faces: what pressure, weight and surface tension leave of each other.
//!
//! Between the cells of a face the pressure jumps by `p_N - p_P`; weight and surface tension ask
//! for a jump of `-(G.x)(rho_N - rho_P) + sigma K (alpha_N - alpha_P)`. The difference per length
//! moves the fluid. Its non-orthogonal part comes from cell gradients of these differences, not
//! from gradients of p and of rho apart: where every face balances, so does every correction.

use super::TwoPhase;
use crate::{Flow, NormalDerivative, Numerics, State};
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

/// How normal derivatives are taken where the line of centres leans.
#[derive(Clone, Copy)]
pub(crate) struct Slanted {
    /// Of the pressure.
    pressure: NormalDerivative,
    /// Of the jumps, that is of density and fraction.
    jumps: NormalDerivative,
}

impl Numerics {
    /// Where continuity is solved: the pressure's is that of a Laplacian.
    pub(crate) fn slanted(&self) -> Slanted {
        let pressure = NormalDerivative { limit: self.non_orthogonal, orthogonal: false };
        Slanted { pressure, jumps: self.sn_grad.unwrap_or(pressure) }
    }

    /// Where momentum is.
    pub(crate) fn slanted_in_momentum(&self) -> Slanted {
        let jumps = self.slanted().jumps;
        Slanted { pressure: jumps, jumps }
    }
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

    /// The imbalance of the pressure `p` on every face; none where the velocity is given. `how` its normal
    /// derivative and that of the jumps are taken.
    pub(crate) fn balance(&mut self, exec: &Exec, mesh: &Mesh, p: &Unknown<f64>, how: Slanted) {
        self.balance_jumps(exec, mesh, p, how, 1.0);
    }

    /// The same with `share` of the jumps that weight and surface tension ask for.
    fn balance_jumps(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        p: &Unknown<f64>,
        how: Slanted,
        share: f64,
    ) {
        let Slanted { pressure, jumps } = how;
        self.imbalance.fill(0.0);
        // Taken alike, they are taken together: where every face balances, so does every correction.
        if pressure == jumps {
            return self.add_slopes(exec, mesh, (Some(p), share), pressure);
        }
        self.add_slopes(exec, mesh, (Some(p), 0.0), pressure);
        if share != 0.0 {
            self.add_slopes(exec, mesh, (None, share), jumps);
        }
    }

    /// Adds the normal derivative of a pressure less `share` of the jumps, on every face.
    fn add_slopes(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        (p, share): (Option<&Unknown<f64>>, f64),
        how: NormalDerivative,
    ) {
        let FaceForces { jump, imbalance, open, gradient, fit, .. } = self;
        let (jump, open) = (&jump.data, &open[..]);
        let difference = |f: usize| {
            let o = mesh.owner[f] as usize;
            let of = |p: &Unknown<f64>| match mesh.neighbour.get(f) {
                Some(&n) => p.cells.data[n as usize] - p.cells.data[o],
                None => p.boundary_value(mesh, f) - p.cells.data[o],
            };
            if f < mesh.n_inner || open[f - mesh.n_inner] {
                p.map_or(0.0, of) - share * jump[f]
            } else {
                0.0
            }
        };
        // Beyond, corrections that lag behind would grow.
        let limit = if mesh.max_nonorth_deg > STEEPEST { how.limit.min(0.5) } else { how.limit };
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
                let compact = match how.orthogonal && f < mesh.n_inner {
                    true => difference(f) / norm(mesh.delta[f]),
                    false => difference(f) * mesh.inv_dist[f],
                };
                *b += compact;
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
        (how, whole): (Slanted, bool),
        (cells, faces): (&mut [Vec3], &mut [f64]),
    ) {
        self.balance_jumps(exec, mesh, p, how, if whole { 1.0 } else { 0.0 });
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
        let Flow { exec, mesh, state, two_phase, gravity, fluid, numerics, .. } = self;
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
            t.tension.update(exec, mesh, alpha, (vof, numerics.compatible));
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
                    *jump += sigma * tension.on_face(f) * d_alpha;
                }
            }
        });
        let jump = &t.forces.jump.data[mesh.n_inner..];
        for (b, gradient) in t.forces.wall_gradient.iter_mut().enumerate() {
            *gradient = jump[b] * mesh.inv_dist[mesh.n_inner + b];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_fv::conditions::{FixedValue, ZeroGradient};
    use granflow_fv::{Condition, Surroundings};
    use granflow_mesh::{PatchKind, shapes};

    /// Slope of the line of centres of one face of a sheared box, of the pressure `x` and of the jump `-2 x`.
    fn slopes(how: Slanted) -> [f64; 2] {
        let exec = Exec::serial();
        let (lo, hi) = ([0.0; 3], [1.0; 3]);
        let sheared = |[x, y, z]: Vec3| [x + 0.75 * y, y, z];
        let kinds = shapes::all(PatchKind::Patch);
        let m = Mesh::new(&shapes::mapped_box([4; 3], lo, hi, kinds, sheared)).expect("sound");
        let exact = |f: usize| m.face_centre[f][0];
        let given = m.patches.iter().map(|p| -> Box<dyn Condition<f64>> {
            Box::new(FixedValue::per_face(p.faces.clone().map(exact).collect()))
        });
        let mut p = Unknown::new(&m, "p", Dims::PRESSURE, 0.0, given.collect());
        (0..m.n_cells).for_each(|c| p.cells.data[c] = m.cell_centre[c][0]);
        p.update(&exec, &m, &Surroundings::default(), None);
        let free = m.patches.iter().map(|_| Box::new(ZeroGradient) as Box<dyn Condition<f64>>);
        let still = Unknown::new(&m, "p", Dims::PRESSURE, 0.0, free.collect());
        // Between cells above each other, in the middle of the box.
        let inside = |c: u32| m.faces_of(c as usize).all(|(f, _)| f < m.n_inner);
        let across =
            |f: &usize| m.normal(*f)[1] > 0.9 && inside(m.owner[*f]) && inside(m.neighbour[*f]);
        let f = (0..m.n_inner).find(across).expect("a face");
        let mut forces = FaceForces::new(&m, &p);
        forces.balance(&exec, &m, &p, how);
        let of_pressure = forces.imbalance[f];
        for f in 0..m.n_faces() {
            let here = m.cell_centre[m.owner[f] as usize][0];
            let there = m.neighbour.get(f).map_or(exact(f), |n| m.cell_centre[*n as usize][0]);
            forces.jump.data[f] = -2.0 * (there - here);
        }
        forces.open.fill(true);
        forces.balance(&exec, &m, &still, how);
        [of_pressure, forces.imbalance[f]]
    }

    /// Centres one above the other are 0.25 apart along the normal, 0.1875 across, and 0.3125 in all; the
    /// normal derivative of x is none.
    #[test]
    fn normal_derivatives_of_pressure_and_of_jumps() {
        let plain = |limit| NormalDerivative { limit, orthogonal: false };
        let [whole, none, half] = [1.0, 0.0, 0.5].map(plain);
        let along = NormalDerivative { limit: 0.0, orthogonal: true };
        let third = plain(0.25);
        for (pressure, jumps, expected) in [
            (whole, whole, [0.0, 0.0]),
            (whole, none, [0.0, 2.0 * 0.75]),
            (none, whole, [0.75, 0.0]),
            (whole, along, [0.0, 2.0 * 0.6]),
            (along, along, [0.6, 2.0 * 0.6]),
            // A half lets all of a correction through that is as large as the difference.
            (half, none, [0.0, 1.5]),
            (whole, third, [0.0, 2.0 * 0.75 * (1.0 - 1.0 / 3.0)]),
        ] {
            let found = slopes(Slanted { pressure, jumps });
            let off = (0..2).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{pressure:?}, {jumps:?}: {found:?}, not {expected:?}");
        }
    }
}
