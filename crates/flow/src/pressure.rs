//! The pressure correction of a single pass (PISO: R. I. Issa, J. Comput. Phys. 62 (1986) 40):
//! continuity, paper eq. 7, with the velocity that momentum gives.
//!
//! The correction p' acts with the mobility of all cells moving together (SIMPLEC: J. P. Van
//! Doormaal, G. D. Raithby, Numer. Heat Transfer 7 (1984) 147): dt/rho inside the flow however
//! large the viscosity is, so that no relaxation is needed.

use crate::{Flow, Purpose, StepError, settle};
use granflow_base::Value;
use granflow_fv::{Surroundings, div_explicit, laplacian, operators};
use granflow_linsolve::{Solved, Tolerance};

impl Flow {
    /// One pressure correction: flux, pressure and velocity. `b` of the momentum equation without
    /// pressure is in the equation itself.
    pub(crate) fn correct_pressure(&mut self, dt: f64, last: bool) -> Result<Solved, StepError> {
        self.interpolate_flux_of_momentum(dt);
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
            let asked =
                if last && k == correctors { &numerics.p.last } else { &numerics.p.tolerance };
            let share = share_of_correction(exec, n, w, &mut state.p.cells.data);
            let tolerance = Tolerance { abs: asked.abs / share, ..*asked };
            let failed = |source| StepError::Solve { field: "p", time, source };
            numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed)?;
            let p_prime = &mut w.p_prime.cells.data;
            let result = numerics.p.solver.solve(exec, &w.p_eqn.a, &w.p_eqn.b, p_prime, &tolerance);
            let count = &mut w.solves[1];
            let solved = settle(result, p_prime, Purpose::Correction, count).map_err(failed)?;
            let first = if k == 0 { share * solved.first } else { done.first };
            let iterations = done.iterations + solved.iterations;
            done = Solved { iterations, first, last: share * solved.last };
            mesh.halo.update(exec, &mut w.p_prime.cells.data);
            numerics.gradient_p.of(exec, mesh, &w.p_prime, &mut w.grad_p);
            if skewed && k < correctors {
                // What the compact difference left out joins the flux that the next pass corrects.
                self_correct(exec, mesh, w, numerics.non_orthogonal);
            }
        }
        apply_flux(exec, mesh, w, &mut state.phi);
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
        self.fix_pressure_level();
        self.update_conditions();
        Ok(done)
    }

    /// Makes the flux of a coupled step satisfy continuity to a residual of `wanted`, so that what is
    /// transported with it is conserved: a pressure correction of the flux alone. Velocity and
    /// pressure stay what their residuals, of which `net` is that of continuity, were measured of.
    pub(crate) fn project_flux(&mut self, net: f64, wanted: f64) -> Result<(), StepError> {
        let Flow { exec, mesh, state, numerics, work: w, .. } = self;
        let closure = &mut w.p_prime.closure;
        closure.slope.copy_from_slice(&state.p.closure.slope);
        closure.offset.fill(0.0);
        w.p_prime.cells.data.fill(0.0);
        w.phi_star.data.copy_from_slice(&state.phi.data);
        let equation = -laplacian(&w.r_at_f) + div_explicit(&w.phi_star);
        w.p_eqn.assemble(exec, mesh, &w.p_prime, &equation)?;
        let (a, b, x) = (&w.p_eqn.a, &w.p_eqn.b, &mut w.p_prime.cells.data);
        let rel = (0.1 * wanted / net).clamp(1e-10, 0.1);
        let tolerance = Tolerance { abs: 0.0, rel, max_iter: 1000 };
        let solver = &mut numerics.p.solver;
        let result = solver.refresh(exec, a).and_then(|()| solver.solve(exec, a, b, x, &tolerance));
        // A step without convergence is said to be one; it need not fail over its flux.
        if settle(result, x, Purpose::Direction, &mut w.solves[1]).is_ok() {
            mesh.halo.update(exec, &mut w.p_prime.cells.data);
            apply_flux(exec, mesh, w, &mut state.phi);
            self.update_conditions();
        }
        Ok(())
    }

    /// Where no boundary fixes the level of the pressure, the reference cell does.
    pub(crate) fn fix_pressure_level(&mut self) {
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
}

/// Size of the equation for the correction p' over that of the equation for p itself: a tolerance
/// is relative to the pressure, as OpenFOAM's users know it, not to what is left to correct.
pub(crate) fn share_of_correction(
    exec: &granflow_par::Exec,
    n: usize,
    w: &mut crate::work::Work,
    p: &mut [f64],
) -> f64 {
    let (a, b, product) = (&w.p_eqn.a, &w.p_eqn.b, &mut w.tau);
    a.apply(exec, p, product);
    let [sum, cells] = exec.sums(n, |r| [r.clone().map(|c| p[c]).sum(), r.len() as f64]);
    let mean = sum / cells.max(1.0);
    let product = &w.tau;
    let [own, whole] = exec.sums(n, |range| {
        let mut s = [0.0; 2];
        for c in range {
            let row = a.ptr[c] as usize..a.ptr[c + 1] as usize;
            let varies = product[c] - mean * a.val[row].iter().sum::<f64>();
            s[0] += b[c].abs();
            s[1] += varies.abs() + (varies + b[c]).abs();
        }
        s
    });
    if own > 0.0 && whole > own { own / whole } else { 1.0 }
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
    let old = &w.p_scratch.data;
    exec.for_each(&mut w.phi_star.data, |first, out| {
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
    exec.for_each(&mut w.phi_star.data, |first, out| {
        out.iter_mut().enumerate().for_each(|(i, phi)| *phi -= new[first + i]);
    });
}

impl Flow {
    /// Refreshes ghosts and closures of velocity and pressure.
    pub(crate) fn update_conditions(&mut self) {
        let Flow { exec, mesh, state, work: w, gravity, two_phase, frames, sources, .. } = self;
        let grains = two_phase.as_ref().and_then(|t| t.work.grains.as_ref());
        w.friction.press(mesh, &state.p, (&w.rho.data, gravity.hydrostatic), grains);
        let (mut fraction, mut face_fraction) = (&[][..], &[][..]);
        if let Some(alpha) = &state.alpha {
            for f in mesh.n_inner..mesh.n_faces() {
                w.face_fraction[f - mesh.n_inner] = alpha.boundary_value(mesh, f);
            }
            (fraction, face_fraction) = (&alpha.cells.data, &w.face_fraction);
        }
        let around = Surroundings {
            time: state.time,
            fraction,
            face_fraction,
            gravity: gravity.hydrostatic,
            density: &w.rho.data,
            wall_pressure: &w.friction.pressure,
            wall_fluid: &w.friction.rest,
            slid: &w.friction.slid,
            wall_viscosity: &w.eta_f.data[mesh.n_inner..],
            ..Surroundings::default()
        };
        state.u.update(exec, mesh, &around, Some(&state.phi));
        crate::frame::turn_walls(frames.as_deref(), sources, mesh, state.time, &mut state.u);
        let (rho, dynamic) = (&w.rho.data, &mut w.dynamic_pressure);
        for f in mesh.n_inner..mesh.n_faces() {
            let u = state.u.boundary_value(mesh, f);
            w.face_velocity[f - mesh.n_inner] = u;
            dynamic[f - mesh.n_inner] =
                0.5 * rho[mesh.owner[f] as usize] * granflow_base::dot(u, u);
        }
        let flux_gradient = two_phase.as_ref().map_or(&[][..], |t| t.work.wall_gradient());
        let around = Surroundings {
            dynamic_pressure: &w.dynamic_pressure,
            face_velocity: &w.face_velocity,
            flux_gradient,
            ..around
        };
        state.p.update(exec, mesh, &around, Some(&state.phi));
    }
}
