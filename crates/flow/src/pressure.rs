//! The pressure correction: continuity, paper eq. 7, through consistent momentum interpolation.
//!
//! The flux through a face is interpolated from the momentum equations of its two cells without
//! their pressure gradients, plus the compact gradient over the face (C. M. Rhie, W. L. Chow,
//! AIAA J. 21 (1983) 1525), with the old flux in place of the old cell velocities, so that a
//! steady state hardly depends on the time step (S. K. Choi, Numer. Heat Transfer A 36 (1999)
//! 545). The correction p' acts with the mobility of all cells moving together (SIMPLEC: J. P. Van
//! Doormaal, G. D. Raithby, Numer. Heat Transfer 7 (1984) 147): dt/rho inside the flow however
//! large the viscosity is, so that no relaxation is needed and no step is too long.

use crate::{Flow, StepError};
use granflow_base::{Value, dot};
use granflow_fv::{Surroundings, div_explicit, laplacian, operators, source, sp};
use granflow_linsolve::Solved;

/// The mobility of all cells together exceeds that of one by at most this factor: beyond it the
/// time step is infinite as far as the mesh can tell.
const MOST_MOBILE: f64 = 1e6;
/// Tangent of the angle between face normal and line of centres from which a face counts as
/// leaning.
const LEANING: f64 = 0.02;

impl Flow {
    /// Mobilities of the momentum equation in cells and on faces.
    pub(crate) fn update_mobility(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        let (eqn, volume) = (&w.u_eqn, &mesh.volume);
        let n = mesh.n_cells;
        exec.for_each2(&mut w.r_a.data[..n], &mut w.r_at.data[..n], |first, one, all| {
            for i in 0..one.len() {
                let c = first + i;
                let a = eqn.a.val[eqn.a.diag[c] as usize];
                one[i] = volume[c] / a.abs();
                // Not dominant in a cell that more enters than leaves: its size counts.
                all[i] = volume[c] / eqn.row_sum[c].max(a.abs() / MOST_MOBILE).min(a.abs());
            }
        });
        mesh.halo.update(exec, &mut w.r_a.data);
        mesh.halo.update(exec, &mut w.r_at.data);
        operators::to_faces(exec, mesh, &w.r_a.data, &mut w.r_a_f);
        operators::to_faces(exec, mesh, &w.r_at.data, &mut w.r_at_f);
    }

    /// One pressure correction: flux, pressure and velocity. `b` of the momentum equation without
    /// pressure is in the equation itself.
    pub(crate) fn correct_pressure(&mut self, dt: f64, last: bool) -> Result<Solved, StepError> {
        self.interpolate_flux(dt);
        let time = self.state.time;
        let correctors = self.numerics.non_orthogonal_correctors;
        let skewed = self.mesh.max_nonorth_deg > 0.1 && self.numerics.non_orthogonal > 0.0;
        let Flow { exec, mesh, state, numerics, work: w, .. } = self;
        let n = mesh.n_cells;
        // p' vanishes where p is fixed and has zero gradient elsewhere.
        let closure = &mut w.p_prime.closure;
        closure.slope.copy_from_slice(&state.p.closure.slope);
        closure.offset.fill(0.0);
        w.p_prime.cells.data.fill(0.0);
        w.p_scratch.data.fill(0.0);
        let mut done = Solved { iterations: 0, first: 0.0, last: 0.0 };
        for k in 0..=correctors {
            let equation = -laplacian(&w.r_at_f) + div_explicit(&w.phi_star);
            w.p_eqn.assemble(exec, mesh, &w.p_prime, &equation)?;
            let tolerance =
                if last && k == correctors { &numerics.p.last } else { &numerics.p.tolerance };
            let failed = |source| StepError::Solve { field: "p", time, source };
            numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed)?;
            let p_prime = &mut w.p_prime.cells.data;
            let result = numerics.p.solver.solve(exec, &w.p_eqn.a, &w.p_eqn.b, p_prime, tolerance);
            let count = &mut w.solves[1];
            let solved = crate::settle_correction(result, p_prime, count).map_err(failed)?;
            let first = if k == 0 { solved.first } else { done.first };
            done = Solved { iterations: done.iterations + solved.iterations, first, ..solved };
            mesh.halo.update(exec, &mut w.p_prime.cells.data);
            numerics.gradient.of(exec, mesh, &w.p_prime, &mut w.grad_p);
            if skewed && k < correctors {
                // What the compact difference left out joins the flux that the next pass corrects.
                self_correct(exec, mesh, w, numerics.non_orthogonal);
            }
        }
        apply_flux(exec, mesh, w, &mut state.phi);
        let viscous = numerics.outer > 1;
        let (grad, r_at) = (&w.grad_p, &w.r_at.data);
        let hby_a = &w.hby_a;
        exec.for_each(&mut state.u.cells.data[..n], |first, u| {
            for (i, u) in u.iter_mut().enumerate() {
                let c = first + i;
                *u = hby_a[c].axpy(-r_at[c], grad[c]);
            }
        });
        let p_prime = &w.p_prime.cells.data;
        exec.for_each(&mut state.p.cells.data[..n], |first, p| {
            p.iter_mut().enumerate().for_each(|(i, p)| *p += p_prime[first + i]);
        });
        if viscous {
            let solved = self.correct_viscous_pressure()?;
            done.iterations += solved.iterations;
        }
        self.fix_pressure_level();
        self.update_conditions();
        Ok(done)
    }

    /// The part of the pressure that balances viscous stress: where viscosity rules, pressure
    /// answers compression by `p = -2 eta div U` (J. Cahouet, J.-P. Chabard, Int. J. Numer. Meth.
    /// Fluids 8 (1988) 869), on the scale of a cell by its mobility. Without it the pressure of a
    /// slow flow would take eta dt/(rho L^2) iterations to arrive.
    fn correct_viscous_pressure(&mut self) -> Result<Solved, StepError> {
        let time = self.state.time;
        // Of the whole operator, and of the matrix alone where the transpose part vanishes.
        let share = if self.fluid.rheology.is_constant() { 1.0 } else { 0.5 };
        let Flow { exec, mesh, state, numerics, work: w, .. } = self;
        let n = mesh.n_cells;
        let eta = &w.eta.data;
        exec.for_each(&mut w.compliance.data[..n], |first, out| {
            out.iter_mut().enumerate().for_each(|(i, k)| *k = share / eta[first + i]);
        });
        let shift = level_shift(exec, mesh, w);
        let compliance = &w.compliance.data;
        exec.for_each(&mut w.level.data[..n], |first, out| {
            out.iter_mut().enumerate().for_each(|(i, s)| *s = shift * compliance[first + i]);
        });
        w.p_prime.cells.data.fill(0.0);
        let equation =
            sp(&w.compliance) - laplacian(&w.r_a_f) + div_explicit(&w.phi_star) - source(&w.level);
        w.p_eqn.assemble(exec, mesh, &w.p_prime, &equation)?;
        let failed = |source| StepError::Solve { field: "p", time, source };
        numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed)?;
        let p_prime = &mut w.p_prime.cells.data;
        let (a, b) = (&w.p_eqn.a, &w.p_eqn.b);
        let result = numerics.p.solver.solve(exec, a, b, p_prime, &numerics.p.tolerance);
        let count = &mut w.solves[1];
        let solved = crate::settle_correction(result, p_prime, count).map_err(failed)?;
        let p_prime = &w.p_prime.cells.data;
        exec.for_each(&mut state.p.cells.data[..n], |first, p| {
            p.iter_mut().enumerate().for_each(|(i, p)| *p += p_prime[first + i]);
        });
        Ok(solved)
    }

    /// Where no boundary fixes the level of the pressure, the reference cell does.
    fn fix_pressure_level(&mut self) {
        if self.level_fixed {
            return;
        }
        let Flow { exec, mesh, state, numerics, .. } = self;
        let p = &state.p.cells.data;
        let mut here = [numerics.reference.map_or(0.0, |(cell, _)| p[cell])];
        exec.comm().sum(&mut here);
        let shift = numerics.reference_value - here[0];
        exec.for_each(&mut state.p.cells.data[..mesh.n_cells], |_, p| {
            p.iter_mut().for_each(|p| *p += shift);
        });
    }

    /// Velocity of each cell from its neighbours (into `hby_a`, the present pressure gradient
    /// included) and the flux that goes with it (into `phi_star`).
    fn interpolate_flux(&mut self, dt: f64) {
        let c = self.ddt_coefficients(dt);
        let Flow { exec, mesh, state, numerics, work: w, fluid, .. } = self;
        let n = mesh.n_cells;
        w.u_eqn.jacobi(exec, &state.u.cells.data, &mut w.hby_a[..n]);
        mesh.halo.update(exec, &mut w.hby_a);
        operators::flux(exec, mesh, &state.u, &w.hby_a, &mut w.phi_star);
        let (r_a_f, phi_start, u_start) = (&w.r_a_f.data, &w.phi_start, &w.u_start);
        let inertia = fluid.rho * (c[1] - c[2]) / dt;
        let p = &state.p;
        numerics.gradient.of(exec, mesh, p, &mut w.grad_p);
        let skewed = mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0;
        let full = skewed.then_some(&w.grad_p[..]);
        exec.for_each(&mut w.phi_star.data, |first, out| {
            for (i, phi) in out.iter_mut().enumerate() {
                let f = first + i;
                if f < mesh.n_inner {
                    let (o, nb) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                    let wf = mesh.weight[f];
                    let u_f = u_start[o].scaled(wf).axpy(1.0 - wf, u_start[nb]);
                    let memory = phi_start[f] - dot(u_f, mesh.area[f]);
                    *phi += share(mesh, f, phi_start[f], memory) * r_a_f[f] * inertia * memory;
                }
                let gradient = operators::normal_derivative(mesh, p, full, f);
                *phi -= r_a_f[f] * mesh.mag_area[f] * gradient;
            }
        });
        let (r_a, grad_p) = (&w.r_a.data, &w.grad_p);
        exec.for_each(&mut w.hby_a[..n], |first, u| {
            for (i, u) in u.iter_mut().enumerate() {
                let c = first + i;
                *u = u.axpy(-r_a[c], grad_p[c]);
            }
        });
    }
}

/// The shift of the whole pressure that balances what leaks through the boundaries that fix it.
/// Compression says nothing about a uniform pressure, so `1/(2 eta)` must not hold it back. Only
/// the viscous share counts: what inertia holds back, the correction before has dealt with.
fn level_shift(
    exec: &granflow_par::Exec,
    mesh: &granflow_mesh::Mesh,
    w: &crate::work::Work,
) -> f64 {
    let (inner, faces) = (mesh.n_inner, mesh.n_faces());
    let mut sums = [0.0; 3];
    for f in inner..faces {
        let open = 1.0 - w.p_prime.closure.slope[f - inner];
        let leak = open * w.r_a_f.data[f] * mesh.mag_area[f] * mesh.inv_dist[f];
        sums[0] -= w.phi_star.data[f];
        sums[1] += leak;
        sums[2] += leak * (1.0 - w.r_a_f.data[f] / w.r_at_f.data[f]).max(0.0);
    }
    exec.comm().sum(&mut sums);
    let [inflow, leak, viscous] = sums;
    if leak > 0.0 { inflow * viscous / (leak * leak) } else { 0.0 }
}

/// The share of the old flux's memory that is kept: all of it on orthogonal faces, which keeps the
/// result nearly independent of the time step. On leaning faces, where flux and interpolated velocity
/// disagree by as much as the flux itself, their difference feeds on itself (a cylinder's wake
/// blew up): there it fades with that disagreement.
fn share(mesh: &granflow_mesh::Mesh, f: usize, flux: f64, memory: f64) -> f64 {
    let lean = mesh.nonorth[f];
    if dot(lean, lean) < LEANING * LEANING {
        return 1.0;
    }
    1.0 - (memory.abs() / flux.abs().max(f64::MIN_POSITIVE)).min(1.0)
}

/// `phi = phi* - D dp'/dn`, the flux that satisfies continuity to the solver's tolerance.
fn apply_flux(
    exec: &granflow_par::Exec,
    mesh: &granflow_mesh::Mesh,
    w: &crate::work::Work,
    phi: &mut granflow_fv::FaceField<f64>,
) {
    exec.for_each(&mut phi.data, |first, out| {
        for (i, phi) in out.iter_mut().enumerate() {
            let f = first + i;
            let gradient = operators::normal_derivative(mesh, &w.p_prime, None, f);
            *phi = w.phi_star.data[f] - w.r_at_f.data[f] * mesh.mag_area[f] * gradient;
        }
    });
}

/// Adds the non-orthogonal part of the correction to `phi_star`.
fn self_correct(
    exec: &granflow_par::Exec,
    mesh: &granflow_mesh::Mesh,
    w: &mut crate::work::Work,
    limit: f64,
) {
    // The last pass's part is taken back first: phi_star holds one correction at a time.
    let n = mesh.n_inner;
    let old = &w.p_scratch.data;
    exec.for_each(&mut w.phi_star.data[..n], |first, out| {
        out.iter_mut().enumerate().for_each(|(i, phi)| *phi += old[first + i]);
    });
    operators::non_orthogonal_flux(
        exec,
        mesh,
        &w.p_prime,
        &w.grad_p,
        &w.r_at_f,
        limit,
        &mut w.p_scratch,
    );
    let new = &w.p_scratch.data;
    exec.for_each(&mut w.phi_star.data[..n], |first, out| {
        out.iter_mut().enumerate().for_each(|(i, phi)| *phi -= new[first + i]);
    });
}

impl Flow {
    /// Refreshes ghosts and closures of velocity and pressure.
    pub(crate) fn update_conditions(&mut self) {
        let Flow { exec, mesh, state, work: w, gravity, .. } = self;
        let around = Surroundings {
            time: state.time,
            gravity: gravity.hydrostatic,
            density: &w.rho.data,
            ..Surroundings::default()
        };
        state.u.update(exec, mesh, &around, Some(&state.phi));
        state.p.update(exec, mesh, &around, Some(&state.phi));
    }
}
