//! The pressure correction with two fluids (PISO: R. I. Issa, J. Comput. Phys. 62 (1986) 40):
//! flux, pressure and velocity from continuity and the forces on faces.
//!
//! The flux is that of the velocity that momentum gives without those forces, with the old flux in
//! place of the interpolated old velocity (C. M. Rhie, W. L. Chow, AIAA J. 21 (1983) 1525), less
//! the imbalance of the faces times their mobility. What is solved for is the change of pressure:
//! its right-hand side vanishes with the imbalance, whatever the size of the pressure.

use super::TwoPhase;
use crate::pressure::share_of_correction;
use crate::{Flow, StepError};
use granflow_base::{Value, Vec3, dot};
use granflow_fv::{div_explicit, laplacian, operators};
use granflow_linsolve::{Solved, Tolerance};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// A start from rest: passes at most, and the change of pressure over the pressure that ends them.
const SETTLING: (usize, f64) = (200, 1e-15);
/// The change that ends them where the pressure is a guess.
const GUESSED: f64 = 1e-8;
/// How far each of these passes is solved.
const SETTLING_REDUCTION: f64 = 1e-6;

/// What rounding of the pressure leaves of its equation.
const ROUNDING: f64 = 1e-15;

fn size_of(exec: &Exec, b: &[f64]) -> f64 {
    exec.sum(b.len(), |r| b[r].iter().map(|b| b.abs()).sum())
}

/// What enters and leaves the cells, m3/s. A tolerance is relative to the pressure, as OpenFOAM's
/// users know it, or to the flux where that is less: in still water the pressure is large and
/// moves nothing.
fn gross_flux(exec: &Exec, mesh: &Mesh, phi: &[f64]) -> f64 {
    let gross = |c: usize| mesh.faces_of(c).map(|(f, _)| phi[f].abs()).sum::<f64>();
    exec.sum(mesh.n_cells, |r| r.map(gross).sum())
}

impl Flow {
    /// `V/a_P` of momentum in cells and on faces.
    pub(crate) fn update_two_phase_mobility(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        let (a, volume) = (&w.u_eqn.a, &mesh.volume);
        exec.for_each(&mut w.r_a.data[..mesh.n_cells], |first, out| {
            for (i, r) in out.iter_mut().enumerate() {
                let c = first + i;
                *r = volume[c] / a.val[a.diag[c] as usize];
            }
        });
        mesh.halo.update(exec, &mut w.r_a.data);
        operators::to_faces(exec, mesh, &w.r_a.data, &mut w.r_a_f);
    }

    /// One correction of flux, pressure and velocity. `settle`: the pressure of the start is not
    /// known, and is found to rounding first.
    pub(crate) fn correct_two_phase(
        &mut self,
        dt: f64,
        last: bool,
        settle: bool,
    ) -> Result<Solved, StepError> {
        self.flux_without_forces(dt);
        let usual = self.numerics.non_orthogonal_correctors;
        let most = if settle { SETTLING.0 } else { usual };
        let mut done = Solved { iterations: 0, first: 0.0, last: 0.0 };
        for k in 0..=most {
            let (solved, change) = self.solve_for_pressure(last && k == most, settle)?;
            let first = if k == 0 { solved.first } else { done.first };
            let iterations = done.iterations + solved.iterations;
            done = Solved { iterations, first, last: solved.last };
            if settle && (change <= SETTLING.1 || k >= usual && solved.iterations == 0) {
                break;
            }
        }
        self.take_flux_and_velocity();
        self.fix_level_of_two_phases();
        self.update_conditions();
        Ok(done)
    }

    /// The pressure with which everything begins to move as if nothing resisted: near enough to that
    /// of material at rest to know how hard grains press, which nobody does when a run starts. Velocity and
    /// flux stay as they are.
    pub(crate) fn guess_pressure(&mut self, dt: f64) -> Result<(), StepError> {
        self.work.eta_f.data.fill(0.0);
        self.assemble_two_phase_momentum(dt, false)?;
        self.update_two_phase_mobility();
        self.flux_without_forces(dt);
        for _ in 0..SETTLING.0 {
            if self.solve_for_pressure(true, true)?.1 <= GUESSED {
                break;
            }
        }
        self.fix_level_of_two_phases();
        self.update_conditions();
        Ok(())
    }

    /// Velocity that momentum gives from neighbours and sources alone, into `hby_a`, and its flux.
    fn flux_without_forces(&mut self, dt: f64) {
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let TwoPhase { work: t, .. } = &mut **two;
        let n = mesh.n_cells;
        w.u_eqn.jacobi(exec, &state.u.cells.data, &mut w.hby_a[..n]);
        crate::momentum::keep_solved(exec, mesh, &mut w.hby_a);
        mesh.halo.update(exec, &mut w.hby_a);
        let skewed = mesh.is_skewed();
        if skewed {
            numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
        }
        let (h, ahead) = (&w.hby_a, &w.ahead.data);
        let rho = if numerics.compatible { &w.rho.data } else { &t.rho_old.data };
        let r_a = &w.r_a.data;
        let (u, open, grad_u) = (&state.u, &t.forces.open, &w.grad_u);
        exec.for_each(&mut t.base.data, |first, out| {
            for (i, phi) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = mesh.owner[f] as usize;
                let Some(&nb) = mesh.neighbour.get(f) else {
                    let b = f - mesh.n_inner;
                    let value = if open[b] { h[o] } else { u.boundary_value(mesh, f) };
                    *phi = dot(value, mesh.area[f]);
                    continue;
                };
                let (nb, w) = (nb as usize, mesh.weight[f]);
                *phi = dot(h[o].scaled(w).axpy(1.0 - w, h[nb]), mesh.area[f]);
                if skewed {
                    *phi += dot(operators::skew_part::<Vec3>(mesh, grad_u, f), mesh.area[f]);
                }
                let memory = w * rho[o] * r_a[o] + (1.0 - w) * rho[nb] * r_a[nb];
                *phi += memory / dt * ahead[f];
            }
        });
        self.take_frames_from_base();
    }

    /// The flux relative to frames that turn.
    fn take_frames_from_base(&mut self) {
        if self.frames.is_none() {
            return;
        }
        let Some(two) = &mut self.two_phase else { return };
        let mut base = std::mem::take(&mut two.work.base.data);
        let time = self.state.time;
        self.take_frames(time, &mut base);
        if let Some(two) = &mut self.two_phase {
            two.work.base.data = base;
        }
    }

    /// Solves for a change of pressure and adds it; its flux is left in `work.phi_star`, what it
    /// changes in `work.p_prime`. Returns the greatest change over the greatest pressure as well.
    fn solve_for_pressure(&mut self, last: bool, settle: bool) -> Result<(Solved, f64), StepError> {
        let time = self.state.time;
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let nothing = Solved { iterations: 0, first: 0.0, last: 0.0 };
        let Some(two) = two_phase else { return Ok((nothing, 0.0)) };
        let TwoPhase { work: t, .. } = &mut **two;
        let n = mesh.n_cells;
        t.forces.balance(exec, mesh, &state.p, numerics.slanted());
        let (base, r, imbalance) = (&t.base.data, &w.r_a_f.data, &t.forces.imbalance);
        exec.for_each(&mut w.phi_star.data, |first, out| {
            for (i, phi) in out.iter_mut().enumerate() {
                let f = first + i;
                *phi = base[f] - r[f] * mesh.mag_area[f] * imbalance[f];
            }
        });
        let closure = &mut w.p_prime.closure;
        closure.offset.fill(0.0);
        for (slope, open) in closure.slope.iter_mut().zip(&t.forces.open) {
            *slope = if *open { 0.0 } else { 1.0 };
        }
        w.p_prime.cells.data.fill(0.0);
        let equation = -laplacian(&w.r_a_f) + div_explicit(&w.phi_star);
        w.p_eqn.assemble(exec, mesh, &w.p_prime, &equation)?;
        let asked = if last { &numerics.p.last } else { &numerics.p.tolerance };
        let share = share_of_correction(exec, n, w, &mut state.p.cells.data);
        let tolerance = if settle {
            Tolerance { abs: 1e-16 / share, rel: SETTLING_REDUCTION, ..*asked }
        } else {
            let whole = size_of(exec, &w.p_eqn.b) / share;
            let gross = gross_flux(exec, mesh, &w.phi_star.data);
            let least = if gross < whole { (gross / whole).max(ROUNDING / asked.abs) } else { 1.0 };
            Tolerance { abs: asked.abs * least.min(1.0) / share, ..*asked }
        };
        let failed = |source| StepError::Solve { field: "p_rgh", time, source };
        numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed)?;
        let p_prime = &mut w.p_prime.cells.data;
        let result = numerics.p.solver.solve(exec, &w.p_eqn.a, &w.p_eqn.b, p_prime, &tolerance);
        let solved = crate::settle(result, p_prime, crate::Purpose::Correction, &mut w.solves[1])
            .map_err(failed)?;
        let solved = Solved { first: share * solved.first, last: share * solved.last, ..solved };
        mesh.halo.update(exec, p_prime);
        let p_prime = &w.p_prime.cells.data;
        exec.for_each(&mut state.p.cells.data, |first, p| {
            p.iter_mut().enumerate().for_each(|(i, p)| *p += p_prime[first + i]);
        });
        if !settle {
            return Ok((solved, 0.0));
        }
        let p = &state.p.cells.data;
        let greatest = |x: &[f64]| exec.max(n, |r| r.map(|c| x[c].abs()).fold(0.0, f64::max));
        let (change, size) = (greatest(p_prime), greatest(p));
        Ok((solved, if size > 0.0 { change / size } else { 0.0 }))
    }

    /// The flux that satisfies continuity, and the velocity that goes with its forces.
    fn take_flux_and_velocity(&mut self) {
        let Flow { exec, mesh, state, work: w, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let forces = &mut two.work.forces;
        let (p_prime, phi_star, r) = (&w.p_prime, &w.phi_star.data, &w.r_a_f.data);
        let FaceForcesParts { imbalance, open } = FaceForcesParts::of(forces);
        let phi = &mut state.phi.data;
        exec.for_each2(imbalance, phi, |first, imbalance, phi| {
            for i in 0..phi.len() {
                let f = first + i;
                let here = p_prime.cells.data[mesh.owner[f] as usize];
                let change = match mesh.neighbour.get(f) {
                    Some(&n) => p_prime.cells.data[n as usize] - here,
                    None if open[f - mesh.n_inner] => -here,
                    None => 0.0,
                } * mesh.inv_dist[f];
                imbalance[i] += change;
                phi[i] = phi_star[f] - r[f] * mesh.mag_area[f] * change;
            }
        });
        let (h, r_a, forces) = (&w.hby_a, &w.r_a.data, &*forces);
        let solved = mesh.solved_dirs.map(|solved| if solved { 1.0 } else { 0.0 });
        exec.for_each(&mut state.u.cells.data[..mesh.n_cells], |first, u| {
            for (i, u) in u.iter_mut().enumerate() {
                let c = first + i;
                *u = h[c].axpy(-r_a[c], forces.in_cell(mesh, c));
                (0..3).for_each(|k| u[k] *= solved[k]);
            }
        });
    }

    /// Where no boundary fixes the level of the pressure, the total pressure of the reference cell
    /// does.
    pub(crate) fn fix_level_of_two_phases(&mut self) {
        if self.level_fixed {
            return;
        }
        let Flow { exec, mesh, state, numerics, two_phase, work: w, gravity, .. } = self;
        let Some(two) = two_phase else { return };
        let total = |cell: usize| {
            state.p.cells.data[cell]
                + w.rho.data[cell] * dot(gravity.hydrostatic, mesh.cell_centre[cell])
        };
        let mut here = [numerics.reference.map_or(0.0, |(cell, _)| total(cell))];
        exec.comm().sum(&mut here);
        let shift = two.reference_pressure - here[0];
        exec.for_each(&mut state.p.cells.data, |_, p| p.iter_mut().for_each(|p| *p += shift));
    }
}

/// Two parts of the forces on faces, one of them to be written.
struct FaceForcesParts<'a> {
    imbalance: &'a mut [f64],
    open: &'a [bool],
}

impl<'a> FaceForcesParts<'a> {
    fn of(forces: &'a mut super::face_forces::FaceForces) -> Self {
        FaceForcesParts { imbalance: &mut forces.imbalance, open: &forces.open }
    }
}
