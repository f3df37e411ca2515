//! A first flux that is free of divergence: fractions move with it before a pressure has been
//! solved for.

use crate::{Flow, StepError};
use granflow_fv::{div_explicit, laplacian};
use granflow_linsolve::Tolerance;

/// Passes at most, how far each is solved, and what of the divergence may be left.
const PASSES: usize = 50;
const REDUCTION: f64 = 1e-6;
const LEFT: f64 = 1e-12;

impl Flow {
    /// Takes the gradient of a potential from the flux that the first velocity has, as far as that
    /// is not free of divergence. Nothing changes on boundaries that give the velocity, nor what
    /// momentum remembers of the first velocity: that is for the pressure to correct. Every rank must
    /// call, after the old flux has been remembered.
    pub(super) fn project_first_flux(&mut self) -> Result<(), StepError> {
        let time = self.state.time;
        let level_fixed = self.level_fixed;
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let Some(two) = two_phase else { return Ok(()) };
        let (phi, open) = (&mut state.phi.data, &two.work.forces.open);
        let boundary = exec
            .sum(mesh.n_faces() - mesh.n_inner, |r| r.map(|b| phi[mesh.n_inner + b]).sum::<f64>());
        let gross = exec.sum(phi.len(), |r| phi[r].iter().map(|q| q.abs()).sum());
        // What a closed box gains or loses no potential can take away.
        if two.frozen || gross == 0.0 || !level_fixed && boundary.abs() > LEFT * gross {
            return Ok(());
        }
        w.r_a_f.data.fill(1.0);
        let closure = &mut w.p_prime.closure;
        closure.offset.fill(0.0);
        for (slope, open) in closure.slope.iter_mut().zip(open) {
            *slope = if *open { 0.0 } else { 1.0 };
        }
        let failed = |source| StepError::Solve { field: "p_rgh", time, source };
        let mut count = crate::SolveCount::default();
        for _ in 0..PASSES {
            w.phi_star.data.copy_from_slice(phi);
            w.p_prime.cells.data.fill(0.0);
            let equation = -laplacian(&w.r_a_f) + div_explicit(&w.phi_star);
            w.p_eqn.assemble(exec, mesh, &w.p_prime, &equation)?;
            let b = &w.p_eqn.b;
            if exec.sum(b.len(), |r| b[r].iter().map(|b| b.abs()).sum()) <= LEFT * gross {
                break;
            }
            numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed)?;
            let tolerance = Tolerance { abs: 0.0, rel: REDUCTION, ..numerics.p.last };
            let x = &mut w.p_prime.cells.data;
            let result = numerics.p.solver.solve(exec, &w.p_eqn.a, b, x, &tolerance);
            let purpose = crate::Purpose::Correction;
            let solved = crate::settle(result, x, purpose, &mut count).map_err(failed)?;
            if solved.iterations == 0 {
                break;
            }
            mesh.halo.update(exec, x);
            let x = &*x;
            exec.for_each(phi, |first, phi| {
                for (i, phi) in phi.iter_mut().enumerate() {
                    let f = first + i;
                    let here = x[mesh.owner[f] as usize];
                    let change = match mesh.neighbour.get(f) {
                        Some(&n) => x[n as usize] - here,
                        None if open[f - mesh.n_inner] => -here,
                        None => continue,
                    };
                    *phi -= mesh.mag_area[f] * mesh.inv_dist[f] * change;
                }
            });
        }
        Ok(())
    }
}
