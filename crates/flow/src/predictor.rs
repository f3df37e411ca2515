//! The momentum predictor: velocity from momentum with the pressure as it is.
//!
//! The matrix holds `div(eta grad U)` only. Its transpose `div(eta (grad U)^T)`, taken from the
//! last iterate, would diverge where flow is squeezed (there it doubles the viscous force) and
//! stall where material turns as one piece (there it cancels it), the more so the more eta
//! varies. So the whole operator is inverted by a flexible generalised minimal residual method
//! (Y. Saad, SIAM J. Sci. Comput. 14 (1993) 461) with the matrix as preconditioner: the spectrum
//! lies within 0..2 whatever the contrast of eta, and 1 for plain shear.

use crate::{Flow, StepError};
use granflow_base::{Dims, Tensor, Value, Vec3};
use granflow_fv::{FaceField, Unknown, operators};
use granflow_linsolve::Solved;
use granflow_mesh::Mesh;

/// Directions before a restart.
const DIRECTIONS: usize = 12;
/// Restarts of one solve.
const RESTARTS: usize = 4;

/// Scratch of the method.
pub(crate) struct Krylov {
    basis: Vec<Vec<Vec3>>,
    preconditioned: Vec<Vec<Vec3>>,
    /// A velocity with the homogeneous form of U's conditions.
    change: Unknown<Vec3>,
    gradient: Vec<Tensor>,
    transpose: FaceField<Vec3>,
}

impl Krylov {
    pub(crate) fn new(m: &Mesh) -> Self {
        let zero = || vec![[0.0; 3]; m.n_cells + m.n_ghosts];
        let conditions = m
            .patches
            .iter()
            .map(|_| Box::new(granflow_fv::conditions::ZeroGradient) as Box<_>)
            .collect();
        Krylov {
            basis: (0..=DIRECTIONS).map(|_| zero()).collect(),
            preconditioned: (0..DIRECTIONS).map(|_| zero()).collect(),
            change: Unknown::new(m, "dU", Dims::VELOCITY, [0.0; 3], conditions),
            gradient: vec![[0.0; 9]; m.n_cells + m.n_ghosts],
            transpose: FaceField::new(m, "transposeStress", Dims::FORCE, [0.0; 3]),
        }
    }
}

impl Flow {
    /// Solves momentum for the velocity; the equation is assembled with the fields as they stand
    /// before and after.
    pub(crate) fn predict_velocity(&mut self, dt: f64, last: bool) -> Result<Solved, StepError> {
        let time = self.state.time;
        let failed = |source| StepError::Solve { field: "U", time, source };
        {
            let Flow { exec, state, numerics, work: w, .. } = self;
            let solve = &mut numerics.u;
            solve.solver.refresh(exec, &w.u_eqn.a).map_err(failed)?;
            if numerics.outer == 1 {
                let tolerance = if last { &solve.last } else { &solve.tolerance };
                let (a, b, u) = (&w.u_eqn.a, &w.b, &mut state.u.cells.data);
                let result = solve.solver.solve(exec, a, b, u, tolerance);
                let solved = crate::settle(result, &mut w.solves[0]).map_err(failed)?;
                self.update_conditions();
                return Ok(solved);
            }
            let closure = &mut w.krylov.change.closure;
            closure.slope.copy_from_slice(&state.u.closure.slope);
            closure.normal.copy_from_slice(&state.u.closure.normal);
            closure.offset.fill([0.0; 3]);
        }
        let goal = 0.01 * self.numerics.control.u;
        let first = self.momentum_residual();
        let mut done = Solved { iterations: 0, first, last: first };
        for _ in 0..RESTARTS {
            if done.last <= goal {
                break;
            }
            done.iterations += self.minimise_residual(0.1 * goal / done.last).map_err(failed)?;
            self.update_conditions();
            self.assemble_momentum(dt)?;
            let residual = self.momentum_residual();
            let stalled = residual > 0.5 * done.last;
            done.last = residual;
            if stalled {
                break;
            }
        }
        Ok(done)
    }

    /// One cycle: `work.residual` is `b - A u` on entry; u changes by the best combination of the
    /// directions found until the residual has fallen by `reduction`.
    fn minimise_residual(
        &mut self,
        reduction: f64,
    ) -> Result<usize, granflow_linsolve::SolveError> {
        let Flow { exec, mesh, state, numerics, work: w, fluid, .. } = self;
        let whole = !fluid.rheology.is_constant();
        let (exec, mesh, n) = (&*exec, &**mesh, mesh.n_cells);
        let Krylov { basis, preconditioned, change, gradient, transpose } = &mut w.krylov;
        let size = exec.dot(&w.residual, &w.residual).sqrt();
        if size == 0.0 {
            return Ok(0);
        }
        let residual = &w.residual;
        exec.for_each(&mut basis[0][..n], |first, v| {
            let each = v.iter_mut().enumerate();
            each.for_each(|(i, v)| *v = residual[first + i].scaled(1.0 / size));
        });
        // Hessenberg matrix made triangular by rotations as it grows.
        let mut h = [[0.0; DIRECTIONS]; DIRECTIONS + 1];
        let (mut cs, mut sn) = ([0.0; DIRECTIONS], [0.0; DIRECTIONS]);
        let mut rhs = [0.0; DIRECTIONS + 1];
        rhs[0] = size;
        let (mut used, mut iterations) = (0, 0);
        for j in 0..DIRECTIONS {
            let z = &mut preconditioned[j];
            z.fill([0.0; 3]);
            let tolerance = &numerics.u.tolerance;
            let solver = &mut numerics.u.solver;
            let result = solver.solve(exec, &w.u_eqn.a, &basis[j], z, tolerance);
            let solved = crate::settle(result, &mut w.solves[0])?;
            iterations += solved.iterations;
            // w = A z - div(eta (grad z)^T)
            if whole {
                change.cells.data.copy_from_slice(z);
                mesh.halo.update(exec, &mut change.cells.data);
                numerics.gradient.of(exec, mesh, change, gradient);
                operators::transpose_stress_flux(exec, mesh, change, gradient, &w.eta_f, transpose);
            }
            let (known, next) = basis.split_at_mut(j + 1);
            let next = &mut next[0];
            w.u_eqn.a.apply(exec, z, next);
            let transpose = &transpose.data;
            exec.for_each(&mut next[..n], |first, v| {
                for (i, v) in v.iter_mut().enumerate() {
                    for (f, s) in mesh.faces_of(first + i) {
                        *v = v.axpy(-s, transpose[f]);
                    }
                }
            });
            for (i, v) in known.iter().enumerate() {
                let k = exec.dot(&v[..n], &next[..n]);
                h[i][j] = k;
                exec.for_each(&mut next[..n], |first, w| {
                    w.iter_mut().enumerate().for_each(|(i, w)| *w = w.axpy(-k, v[first + i]));
                });
            }
            let length = exec.dot(&next[..n], &next[..n]).sqrt();
            for i in 0..j {
                let (a, b) = (h[i][j], h[i + 1][j]);
                (h[i][j], h[i + 1][j]) = (cs[i] * a + sn[i] * b, cs[i] * b - sn[i] * a);
            }
            let d = h[j][j].hypot(length);
            if d.is_nan() || d <= 0.0 || d.is_infinite() {
                break;
            }
            (cs[j], sn[j]) = (h[j][j] / d, length / d);
            h[j][j] = d;
            rhs[j + 1] = -sn[j] * rhs[j];
            rhs[j] *= cs[j];
            used = j + 1;
            if rhs[j + 1].abs() <= reduction * size || length <= 1e-14 * d {
                break;
            }
            exec.for_each(&mut next[..n], |_, w| {
                w.iter_mut().for_each(|w| *w = w.scaled(1.0 / length));
            });
        }
        let mut y = [0.0; DIRECTIONS];
        for i in (0..used).rev() {
            let s: f64 = (i + 1..used).map(|k| h[i][k] * y[k]).sum();
            y[i] = (rhs[i] - s) / h[i][i];
        }
        let z = &*preconditioned;
        exec.for_each(&mut state.u.cells.data[..n], |first, u| {
            for (i, u) in u.iter_mut().enumerate() {
                for k in 0..used {
                    *u = u.axpy(y[k], z[k][first + i]);
                }
            }
        });
        Ok(iterations)
    }
}
