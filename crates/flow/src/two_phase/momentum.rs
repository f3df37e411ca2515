//! Momentum of two fluids (paper eq. 8 with a density that moves):
//!
//! `d(rho U)/dt + div(rho phi U) - div(eta (grad U + grad U^T)) = faces' forces + rho G'`

use super::TwoPhase;
use super::convected::Carried;
use crate::momentum::add_faces;
use crate::{Flow, StepError, TimeScheme};
use granflow_base::Value;
use granflow_fv::{Ddt, ddt, div, div_explicit, laplacian, operators, source, sp};

impl Flow {
    /// Assembles momentum without the forces on faces, with the fields as they stand. `again`: in a later
    /// pass of the same step.
    pub(crate) fn assemble_two_phase_momentum(
        &mut self,
        dt: f64,
        again: bool,
    ) -> Result<(), StepError> {
        let c = self.ddt_coefficients(dt);
        self.apply_sources();
        let sinks = self.has_sources();
        let Flow { exec, mesh, state, numerics, work: w, two_phase, gravity, .. } = self;
        let Some(two) = two_phase else { return Ok(()) };
        let leaning = mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0;
        let u = &state.u;
        numerics.gradient.of(exec, mesh, u, &mut w.grad_u);
        operators::transpose_stress_flux(exec, mesh, u, &w.grad_u, &w.eta_f, &mut w.explicit);
        if leaning {
            let (grad, limit) = (&w.grad_u, numerics.non_orthogonal);
            let out = &mut w.scratch_f;
            operators::non_orthogonal_flux(exec, mesh, u, grad, &w.eta_f, limit, out);
            add_faces(exec, mesh.n_faces(), 1.0, &w.scratch_f.data, &mut w.explicit.data);
        }
        let convection = numerics.convection;
        w.limit_gradient(exec, mesh, numerics, u);
        let (flux, out) = (&w.rho_phi.data, &mut w.scratch_f);
        let gradient = w.limited.as_deref().unwrap_or(&w.grad_u);
        convection.weigh(exec, mesh, u, gradient, flux, &mut w.weights, out);
        if convection.corrects(mesh) {
            add_faces(exec, mesh.n_inner, -1.0, &w.scratch_f.data, &mut w.explicit.data);
        }
        if matches!(numerics.ddt, TimeScheme::CrankNicolson(_)) {
            let carried = Carried {
                flux: &w.rho_phi.data,
                weights: &w.weights.data,
                correction: convection.corrects(mesh).then_some(&w.scratch_f.data[..]),
            };
            let old = (!again).then_some(&w.u_start[..]);
            let explicit = &mut w.explicit.data;
            two.work.convected.hold(exec, mesh, u, (&carried, old, c[0] - 1.0), explicit);
        }
        w.friction.keep_normal(exec, mesh, &state.u, &mut w.explicit);
        let inertia = Ddt {
            rho: &w.rho,
            rho_old: &two.work.rho_old,
            old: &w.u_start,
            older: &state.u_old,
            dt,
            c,
        };
        let mut momentum = ddt(inertia) + div(&w.rho_phi, &w.weights)
            - laplacian(&w.eta_f)
            - div_explicit(&w.explicit);
        if gravity.driving != [0.0; 3] || sinks {
            momentum = momentum - source(&w.body);
        }
        if sinks {
            momentum = momentum + sp(&w.sink);
        }
        w.u_eqn.assemble(exec, mesh, u, &momentum)?;
        Ok(())
    }

    /// The right-hand side of the momentum predictor: with the forces on faces.
    pub(crate) fn push_two_phase_momentum(&mut self) {
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let TwoPhase { work: t, .. } = &mut **two;
        t.forces.balance(exec, mesh, &state.p, numerics.slanted_in_momentum());
        let (b, forces, volume) = (&w.u_eqn.b, &t.forces, &mesh.volume);
        exec.for_each(&mut w.b, |first, out| {
            for (i, rhs) in out.iter_mut().enumerate() {
                let c = first + i;
                *rhs = b[c].axpy(-volume[c], forces.in_cell(mesh, c));
            }
        });
        crate::momentum::keep_solved(exec, mesh, &mut w.b);
    }
}
