//! Momentum, paper eq. 8:
//!
//! `d(rho U)/dt + div(rho phi U) - div(eta (grad U + grad U^T)) = -grad p + rho G`
//!
//! with the transpose part in conservative form: explicit in the equation, part of the operator
//! where momentum and continuity are solved together.

use crate::interpolation::Slopes;
use crate::steady::FOREVER;
use crate::time;
use crate::work::Work;
use crate::{Flow, Numerics, StepError, TimeScheme};
use granflow_base::{Tensor, Value, Vec3};
use granflow_fv::{
    Convection, Ddt, Unknown, ddt, defer_to_upwind, div, div_explicit, laplacian, operators,
    source, sp,
};
use granflow_mesh::Mesh;

/// Of a sum of neighbours' forces, each with half a unit in the last place of its velocity, and as
/// much again of the sum.
const ROUNDING: f64 = 2.0 * f64::EPSILON;
/// Speed over that of a free fall through a cell that solvers leave of grains at rest.
const STANDING: f64 = 1e-13;

impl Flow {
    /// Coefficients of the time scheme for this step.
    pub(crate) fn ddt_coefficients(&self, dt: f64) -> [f64; 3] {
        match self.numerics.ddt {
            // The step is endless, or one of pseudo-time.
            TimeScheme::Steady => [1.0, 1.0, 0.0],
            // Nor has an endless step anything to remember.
            _ if dt >= FOREVER => [1.0, 1.0, 0.0],
            TimeScheme::Backward if self.state.dt_old > 0.0 => {
                // Backward differences on unequal steps, r = dt/dt_old.
                let r = dt / self.state.dt_old;
                [1.0 + r / (1.0 + r), 1.0 + r, r * r / (1.0 + r)]
            }
            TimeScheme::CrankNicolson(psi) if self.state.dt_old > 0.0 => {
                let r = dt / self.state.dt_old;
                [1.0 + psi, 1.0 + psi + psi * r, psi * r]
            }
            _ => [1.0, 1.0, 0.0],
        }
    }

    /// Assembles the momentum equation with the fields as they stand, and its right-hand side
    /// with the pressure gradient into `work.b`.
    pub(crate) fn assemble_momentum(&mut self, dt: f64) -> Result<(), StepError> {
        let c = self.ddt_coefficients(dt);
        self.explicit_momentum_flux();
        self.apply_sources();
        if self.has_compatible_viscosity() {
            self.add_transposed_stress();
        }
        let sinks = self.has_sources();
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let rho = time::inertia(&w.rho, &w.local);
        let rho_old = two_phase.as_ref().map_or(rho, |t| &t.work.rho_old);
        let inertia = Ddt { rho, rho_old, old: &w.u_start, older: &state.u_old, dt, c };
        let mut momentum = ddt(inertia) + div(&w.rho_phi, &w.weights)
            - laplacian(&w.eta_f)
            - div_explicit(&w.explicit)
            - source(&w.body);
        if sinks {
            momentum = momentum + sp(&w.sink);
        }
        w.u_eqn.assemble(exec, mesh, &state.u, &momentum)?;
        let two = two_phase.as_deref_mut();
        w.slopes_of_pressure(exec, mesh, numerics, two, Slopes::Of(&state.p));
        let (b, grad_p, volume) = (&w.u_eqn.b, &w.grad_p, &mesh.volume);
        exec.for_each(&mut w.b, |first, out| {
            for (i, rhs) in out.iter_mut().enumerate() {
                let c = first + i;
                *rhs = b[c].axpy(-volume[c], grad_p[c]);
            }
        });
        Ok(())
    }

    /// Whether the matrix of momentum has upwind convection, and the scheme's own part is explicit:
    /// where outer iterations make up for it and the matrix of the scheme would not do. Limited
    /// schemes have weights that jump from one pass to the next; central ones may leave the matrix
    /// so far from dominant that its solver fails.
    pub(crate) fn defers_convection(&self) -> bool {
        self.is_coupled()
            && match self.numerics.convection {
                Convection::Limited(_) | Convection::Mixed(_) => true,
                Convection::Linear => self.work.coupled.defer,
                Convection::Upwind | Convection::LinearUpwind | Convection::LinearUpwindV => false,
            }
    }

    /// Everything of the momentum flux that is not in the matrix, into `work.explicit`.
    fn explicit_momentum_flux(&mut self) {
        if self.holds_interface() {
            self.carry_with_the_flow();
        }
        let deferred = self.defers_convection();
        let Flow { exec, mesh, state, numerics, work: w, fluid, two_phase, .. } = self;
        let leaning = mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0;
        if !fluid.rheology.is_constant() || leaning || numerics.convection.needs_gradient(mesh) {
            numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
        }
        if two_phase.is_none() {
            let rho = fluid.rho;
            let phi = &state.phi.data;
            exec.for_each(&mut w.rho_phi.data, |first, out| {
                out.iter_mut().enumerate().for_each(|(i, m)| *m = rho * phi[first + i]);
            });
        }
        if fluid.rheology.is_constant() || numerics.compatible {
            // div(eta (grad U)^T) = eta grad(div U) = 0: leaving it out keeps its rounding out too. Where forms are to be
            // OpenFOAM's what is left of it with a viscosity that varies is a force on cells.
            w.explicit.data.fill([0.0; 3]);
        } else {
            let (u, grad_u) = (&state.u, &w.grad_u);
            operators::transpose_stress_flux(exec, mesh, u, grad_u, &w.eta_f, &mut w.explicit);
        }
        if leaning {
            operators::non_orthogonal_flux(
                exec,
                mesh,
                &state.u,
                &w.grad_u,
                &w.eta_f,
                numerics.non_orthogonal,
                &mut w.scratch_f,
            );
            add_faces(exec, mesh.n_faces(), 1.0, &w.scratch_f.data, &mut w.explicit.data);
        }
        w.limit_gradient(exec, mesh, numerics, &state.u);
        numerics.convection.weigh(
            exec,
            mesh,
            &state.u,
            w.limited.as_deref().unwrap_or(&w.grad_u),
            &w.rho_phi.data,
            &mut w.weights,
            &mut w.scratch_f,
        );
        let corrects = numerics.convection.corrects(mesh);
        if deferred {
            if !corrects {
                w.scratch_f.data[..mesh.n_inner].fill([0.0; 3]);
            }
            let (u, flux) = (&state.u, &w.rho_phi.data);
            defer_to_upwind(exec, mesh, u, flux, &mut w.weights, &mut w.scratch_f);
        }
        if corrects || deferred {
            add_faces(exec, mesh.n_inner, -1.0, &w.scratch_f.data, &mut w.explicit.data);
        }
        w.friction.keep_normal(exec, mesh, &state.u, &mut w.explicit);
    }

    /// Residual of momentum with the matrix as assembled: force imbalance over force, both by the density
    /// they move where there are two fluids. What the
    /// rounding of the velocity alone can make of forces is no imbalance: where a plug is a hundred
    /// thousand times stiffer than what shears beside it, that can be more than is asked for.
    pub(crate) fn momentum_residual(&mut self) -> f64 {
        // With two fluids what balances on the faces does not show in the cells: where nothing moves the
        // weight is the force at work.
        let free_fall = self.free_fall();
        let Flow { exec, mesh, state, work: w, fluid, .. } = self;
        let (rho, rho_1) = (&w.rho.data, fluid.rho);
        // The speed that rounding is measured by, where nothing moves.
        let fall = |c: usize| free_fall.speed(mesh.cell_size(c));
        w.u_eqn.a.residual(exec, &w.b, &mut state.u.cells.data, &mut w.residual);
        let n = mesh.n_cells;
        keep_solved(exec, mesh, &mut w.residual);
        let (a, b, r, u) = (&w.u_eqn.a, &w.b, &w.residual, &state.u.cells.data);
        // Forces: what walls, neighbours in relative motion, inertia and sources exert.
        let [imbalance, force] = exec.sums(n, |range| {
            let mut s = [0.0; 2];
            for c in range {
                let sum = w.u_eqn.row_sum[c];
                let mut own = u[c].scaled(sum);
                let light = rho_1 / rho[c];
                let mut pulls = rho[c] * mesh.volume[c] * free_fall.g;
                for k in a.ptr[c] as usize..a.ptr[c + 1] as usize {
                    let other = a.col[k] as usize;
                    let pull = u[other].minus(u[c]).scaled(a.val[k]);
                    pulls += 0.5 * pull.inner(pull).sqrt();
                }
                let wall = a.val[a.diag[c] as usize] + off_diagonal(a, c) - sum;
                own = own.axpy(wall, u[c]);
                let diagonal = a.val[a.diag[c] as usize].abs();
                let speed = u[c].inner(u[c]).sqrt();
                let rounding = diagonal * (ROUNDING * speed).max(STANDING * fall(c));
                s[0] += light * (r[c].inner(r[c]).sqrt() - rounding).max(0.0);
                s[1] += light * (pulls + own.inner(own).sqrt() + b[c].inner(b[c]).sqrt());
            }
            s
        });
        w.force = force;
        if force == 0.0 { 0.0 } else { imbalance / force }
    }
}

impl Work {
    /// The gradient that convection extrapolates with into `limited`, where it is not the whole one, `grad_u`.
    pub(crate) fn limit_gradient(
        &mut self,
        exec: &granflow_par::Exec,
        mesh: &Mesh,
        numerics: &Numerics,
        u: &Unknown<Vec3>,
    ) {
        let Some(limiter) = numerics.limiter else { return };
        if !numerics.convection.needs_gradient(mesh) {
            return;
        }
        let limited = self.limited.get_or_insert_with(|| vec![Tensor::default(); mesh.n_all()]);
        limited.copy_from_slice(&self.grad_u);
        limiter.apply(exec, mesh, u, limited);
    }
}

/// Forces out of the plane of a plane mesh: nothing moves there, and what rounding leaves of them
/// must not make it move.
pub(crate) fn keep_solved(exec: &granflow_par::Exec, mesh: &Mesh, force: &mut [Vec3]) {
    if mesh.solved_dirs == [true; 3] {
        return;
    }
    let keep = mesh.solved_dirs.map(|solved| if solved { 1.0 } else { 0.0 });
    exec.for_each(&mut force[..mesh.n_cells], |_, force| {
        force.iter_mut().for_each(|f| (0..3).for_each(|k| f[k] *= keep[k]));
    });
}

/// Sum of the off-diagonal entries of a row.
fn off_diagonal(a: &granflow_linsolve::Csr, row: usize) -> f64 {
    let all: f64 = a.val[a.ptr[row] as usize..a.ptr[row + 1] as usize].iter().sum();
    all - a.val[a.diag[row] as usize]
}

/// `to += k from` on the first `faces` faces.
pub(crate) fn add_faces<T: Value>(
    exec: &granflow_par::Exec,
    faces: usize,
    k: f64,
    from: &[T],
    to: &mut [T],
) {
    exec.for_each(&mut to[..faces], |first, to| {
        to.iter_mut().enumerate().for_each(|(i, t)| *t = t.axpy(k, from[first + i]));
    });
}
