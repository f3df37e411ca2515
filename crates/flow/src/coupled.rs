//! Momentum (paper eq. 8) and continuity (eq. 7) solved together, viscosity and convecting flux
//! held, by a flexible generalised minimal residual method (Y. Saad, SIAM J. Sci. Comput. 14
//! (1993) 461) on the whole operator: transpose stress, momentum interpolation and all.
//!
//! One sweep of the segregated method is the preconditioner: velocity from the matrix of momentum,
//! the pressure that makes its flux continuous where inertia rules, `-div(dt/rho grad p1)`, and
//! the one that answers compression where viscosity rules, `p2/(2 eta) - div(r grad p2)` (J.
//! Cahouet, J.-P. Chabard, Int. J. Numer. Meth. Fluids 8 (1988) 869). By itself that sweep stalls
//! or diverges where viscosity varies by decades (its transpose part lies outside the matrix, its
//! pressure part knows the viscosity of one cell only); as a preconditioner what it gets wrong
//! costs a direction, not convergence. No relaxation factor is needed.

use crate::interpolation::{Interpolated, Slopes, interpolated_flux};
use crate::krylov::{DIRECTIONS, Hessenberg};
use crate::{Flow, Purpose, SolveCount, StepError, TimeScheme, settle};
use granflow_base::{Dims, Tensor, Value, Vec3, norm};
use granflow_fv::{
    Convection, Equation, FaceField, Unknown, defer_to_upwind, laplacian, operators, sp,
};
use granflow_linsolve::{SolveError, Solved, Tolerance};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// How well the preconditioner's own systems are solved: a direction is worth no more.
const VELOCITY: Tolerance = Tolerance { abs: 0.0, rel: 0.03, max_iter: 200 };
const PRESSURE: Tolerance = Tolerance { abs: 0.0, rel: 0.05, max_iter: 50 };
/// Where viscosity varies wildly, a velocity that leaves little force unbalanced may be wrong
/// everywhere that is soft: a cycle that hardly reduces the residual asks this much more of the
/// next one, in the same step.
const TIGHTEN: f64 = 0.1;
const HARDLY: f64 = 0.3;
const TIGHTEST: f64 = 1e-6;
/// Directions of a cycle where nothing speaks for more, and cells times directions that a gigabyte holds.
const FEW: usize = 24;
const HELD: f64 = 1.6e7;
/// Momentum residual from which on Newton's method is tried, and share of that of a failed pass.
const NEAR: f64 = 0.05;
const FARTHER: f64 = 0.1;
/// Reduction in a pass on what carries itself, whose flux is held.
const CARRIED: f64 = 0.1;
/// Share of a velocity's residual that a solver may leave.
const HOPELESS: f64 = 0.5;

/// Residual or change of momentum and continuity: velocity-like and pressure-like part, with room
/// for ghosts.
struct Pair {
    u: Vec<Vec3>,
    p: Vec<f64>,
}

impl Pair {
    fn new(cells: usize) -> Self {
        Pair { u: vec![[0.0; 3]; cells], p: vec![0.0; cells] }
    }
    fn dot(&self, exec: &Exec, n: usize, other: &Pair) -> f64 {
        exec.dot(&self.u[..n], &other.u[..n]) + exec.dot(&self.p[..n], &other.p[..n])
    }
    /// `self += k other` in the first `n` cells.
    fn add(&mut self, exec: &Exec, n: usize, k: f64, other: &Pair) {
        exec.for_each2(&mut self.u[..n], &mut self.p[..n], |first, u, p| {
            for i in 0..u.len() {
                u[i] = u[i].axpy(k, other.u[first + i]);
                p[i] += k * other.p[first + i];
            }
        });
    }
    fn scale(&mut self, exec: &Exec, n: usize, k: f64) {
        exec.for_each2(&mut self.u[..n], &mut self.p[..n], |_, u, p| {
            for i in 0..u.len() {
                u[i] = u[i].scaled(k);
                p[i] *= k;
            }
        });
    }
}

/// Scratch of the method.
pub(crate) struct Coupled {
    basis: Vec<Pair>,
    directions: Vec<Pair>,
    /// A change of velocity with the homogeneous form of U's conditions.
    du: Unknown<Vec3>,
    gradient: Vec<Tensor>,
    stress: FaceField<Vec3>,
    flux: FaceField<f64>,
    /// `p2/(2 eta) - div(r grad p2)`.
    viscous: Equation<f64>,
    /// Right-hand side of both pressure equations, and the second one's solution.
    rhs: Vec<f64>,
    second: Vec<f64>,
    /// Accuracy of the preconditioner's velocity, over [`VELOCITY`]'s.
    tightness: f64,
    /// Of the last pass.
    scales: Scales,
    /// Whether central convection stays out of the matrix for the rest of the step, because the
    /// velocity's solver failed on it.
    pub(crate) defer: bool,
    /// How the flux that carries momentum follows the velocity within a pass.
    pub(crate) carrier: Carrier,
}

/// Whether the flux that carries momentum is held within a pass (Picard's iteration) or follows the
/// velocity (Newton's). Held, what is carried fast along walls converges slowly: behind a step at a Reynolds
/// number of 800 by a few per cent a pass. Newton's method is for the neighbourhood of the solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carrier {
    /// Whether it follows in the present pass.
    pub(crate) follows: bool,
    /// The momentum residual below which it does.
    below: f64,
    /// The residual before the last pass.
    last: f64,
}

impl Default for Carrier {
    fn default() -> Self {
        Carrier { follows: false, below: NEAR, last: f64::INFINITY }
    }
}

impl Carrier {
    /// Decides for the pass that begins at the momentum residual `now`: a pass of Newton's that made it
    /// worse has the next ones wait until it is smaller than where that one began.
    pub(crate) fn decide(&mut self, now: f64) {
        if self.follows && now > self.last {
            self.below = FARTHER * self.last;
        }
        self.last = now;
        self.follows = now < self.below;
    }

    /// How far the pass is to reduce momentum and continuity, where convergence needs `needed` and the momentum
    /// residual is `now`: Picard's passes gain a constant factor whatever they are solved to, Newton's
    /// the square.
    pub(crate) fn wanted_reduction(&self, needed: f64, now: f64) -> f64 {
        let gain = if self.follows { (0.3 * now.sqrt()).min(CARRIED) } else { CARRIED };
        if needed.is_nan() { gain } else { needed.clamp(gain, CARRIED) }
    }
}

impl Coupled {
    pub(crate) fn new(exec: &Exec, m: &Mesh) -> Self {
        let cells = m.n_all();
        let conditions = m
            .patches
            .iter()
            .map(|_| Box::new(granflow_fv::conditions::ZeroGradient) as Box<_>)
            .collect();
        Coupled {
            basis: Vec::new(),
            directions: Vec::new(),
            du: Unknown::new(m, "dU", Dims::VELOCITY, [0.0; 3], conditions),
            gradient: vec![[0.0; 9]; cells],
            stress: FaceField::new(m, "stress", Dims::FORCE, [0.0; 3]),
            flux: FaceField::new(m, "phi", Dims::VOLUME_FLUX, 0.0),
            viscous: Equation::new(exec, m),
            rhs: vec![0.0; m.n_cells],
            second: vec![0.0; cells],
            tightness: 1.0,
            scales: Scales { force: 1.0, flux: 1.0 },
            defer: false,
            carrier: Carrier::default(),
        }
    }
    /// Allocates the directions, once: they are most of a flow's memory, and a flow that takes
    /// single passes never needs them.
    fn reserve(&mut self, m: &Mesh, directions: usize) {
        while self.directions.len() < directions {
            self.basis.push(Pair::new(m.n_all()));
            self.directions.push(Pair::new(m.n_all()));
        }
        if self.basis.len() == self.directions.len() {
            self.basis.push(Pair::new(m.n_all()));
        }
    }
    /// To be called as a step begins: nothing is carried over from the one before.
    pub(crate) fn begin_step(&mut self) {
        self.tightness = 1.0;
        self.defer = false;
        self.carrier = Carrier::default();
    }
}

/// What makes residuals of momentum and continuity comparable: the forces and the fluxes at work. Beside
/// that forces count by the density they move: of two fluids, the light one is no less a flow.
#[derive(Clone, Copy)]
struct Scales {
    force: f64,
    flux: f64,
}

impl Flow {
    /// One cycle: velocity, pressure and flux change by the best combination of the directions
    /// found until the residual of the linear problem has fallen by `reduction`. On entry momentum
    /// is assembled and `work.residual` is its residual.
    pub(crate) fn solve_coupled(
        &mut self,
        dt: f64,
        reduction: f64,
    ) -> Result<[Solved; 2], StepError> {
        let directions = self.directions();
        self.work.coupled.reserve(&self.mesh, directions);
        self.work.friction.remember(&self.mesh, &self.state.u);
        self.update_mobility(dt);
        self.interpolate_flux_of_state(dt);
        self.prepare_preconditioner()?;
        let scales = self.scales();
        let n = self.mesh.n_cells;
        self.work.coupled.scales = scales;
        let size = self.imbalance();
        let mut done = [Solved { iterations: 0, first: size, last: size }; 2];
        if size == 0.0 || !size.is_finite() {
            return Ok(done);
        }
        self.work.coupled.basis[0].scale(&self.exec, n, 1.0 / size);
        let mut small = Hessenberg::new(size);
        for j in 0..directions {
            let Some(solved) = self.precondition(j, scales)? else { break };
            done[0].iterations += solved[0];
            done[1].iterations += solved[1];
            self.apply_operator(j, scales);
            let Flow { exec, work: w, .. } = self;
            let (known, next) = w.coupled.basis.split_at_mut(j + 1);
            let next = &mut next[0];
            let mut products = [0.0; DIRECTIONS];
            for (k, v) in products.iter_mut().zip(known.iter()) {
                *k = v.dot(exec, n, next);
                next.add(exec, n, -*k, v);
            }
            let length = next.dot(exec, n, next).sqrt();
            if !small.push(&products[..=j], length)
                || small.residual() <= reduction * size
                || length <= 1e-14
            {
                break;
            }
            next.scale(exec, n, 1.0 / length);
        }
        if small.len() > 0 && small.residual() > reduction.max(HARDLY) * size {
            self.work.coupled.tightness *= TIGHTEN;
        }
        self.take(&small);
        if self.two_phase.is_some() {
            self.fix_level_of_two_phases();
        } else {
            self.fix_pressure_level();
        }
        self.update_conditions();
        self.interpolate_flux_of_state(dt);
        done.iter_mut().for_each(|d| d.last = small.residual());
        Ok(done)
    }

    /// Whether passes are there because the flow carries itself: a steady state at constant viscosity.
    pub(crate) fn carrier_may_follow(&self) -> bool {
        self.numerics.ddt == TimeScheme::Steady
            && self.two_phase.is_none()
            && self.fluid.rheology.is_constant()
    }

    /// Most directions of a cycle. What is carried through many cells takes more than what diffuses, as many
    /// as a gigabyte holds.
    fn directions(&self) -> usize {
        if !self.carrier_may_follow() {
            return FEW;
        }
        let mut cells = [self.mesh.n_cells as f64];
        self.exec.comm().sum(&mut cells);
        ((HELD / cells[0]) as usize).clamp(FEW, DIRECTIONS)
    }

    /// Norm of what momentum and continuity lack, in the units of the last pass; the residuals
    /// themselves are left in the first vector of the basis.
    pub(crate) fn imbalance(&mut self) -> f64 {
        let Flow { exec, mesh, state, work: w, fluid, .. } = self;
        let (n, scales) = (mesh.n_cells, w.coupled.scales);
        let first = &mut w.coupled.basis[0];
        let (residual, phi) = (&w.residual, &state.phi.data);
        let (rho, rho_1) = (&w.rho.data, fluid.rho);
        exec.for_each2(&mut first.u[..n], &mut first.p[..n], |from, u, p| {
            for i in 0..u.len() {
                let c = from + i;
                u[i] = residual[c].scaled(rho_1 / rho[c] / scales.force);
                let net: f64 = mesh.faces_of(c).map(|(f, s)| s * phi[f]).sum();
                p[i] = -net / scales.flux;
            }
        });
        w.coupled.basis[0].dot(exec, n, &w.coupled.basis[0]).sqrt()
    }

    /// Adds the best combination of the directions to velocity and pressure.
    fn take(&mut self, small: &Hessenberg) {
        let Flow { exec, mesh, state, work: w, .. } = self;
        let (n, y, z) = (mesh.n_cells, small.weights(), &w.coupled.directions[..small.len()]);
        let (u, p) = (&mut state.u.cells.data[..n], &mut state.p.cells.data[..n]);
        exec.for_each2(u, p, |first, u, p| {
            for i in 0..u.len() {
                for (z, y) in z.iter().zip(&y) {
                    u[i] = u[i].axpy(*y, z.u[first + i]);
                    p[i] += y * z.p[first + i];
                }
            }
        });
    }

    fn scales(&self) -> Scales {
        let Flow { exec, mesh, state, work: w, .. } = self;
        let (u, a, residual) = (&state.u.cells.data, &w.u_eqn.a, &w.residual);
        // The velocity of a cell, or the one that its imbalance is about to give it.
        let flux = exec.sum(mesh.n_cells, |range| {
            let mut s = 0.0;
            for c in range {
                let speed = norm(u[c]).max(norm(residual[c]) / a.val[a.diag[c] as usize].abs());
                s += speed * mesh.faces_of(c).map(|(f, _)| mesh.mag_area[f]).sum::<f64>();
            }
            s
        });
        let positive = |x: f64| if x > 0.0 { x } else { 1.0 };
        Scales { force: positive(w.force), flux: positive(flux) }
    }

    /// Matrices of the preconditioner, once for all directions.
    fn prepare_preconditioner(&mut self) -> Result<(), StepError> {
        let time = self.state.time;
        // Of the whole operator, and of the matrix alone where the transpose part vanishes.
        let share = if self.fluid.rheology.is_constant() { 1.0 } else { 0.5 };
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        let n = mesh.n_cells;
        let eta = two_phase.as_ref().and_then(|t| t.viscosity()).unwrap_or(&w.eta.data);
        exec.for_each(&mut w.compliance.data[..n], |first, out| {
            out.iter_mut().enumerate().for_each(|(i, k)| *k = share / eta[first + i]);
        });
        // p' vanishes where p is fixed and has zero gradient elsewhere.
        let closure = &mut w.p_prime.closure;
        closure.slope.copy_from_slice(&state.p.closure.slope);
        closure.offset.fill(0.0);
        w.p_eqn.assemble(exec, mesh, &w.p_prime, &-laplacian(&w.r_at_f))?;
        let viscous = sp(&w.compliance) - laplacian(&w.r_a_f);
        w.coupled.viscous.assemble(exec, mesh, &w.p_prime, &viscous)?;
        let closure = &mut w.coupled.du.closure;
        closure.slope.copy_from_slice(&state.u.closure.slope);
        closure.normal.copy_from_slice(&state.u.closure.normal);
        closure.offset.fill([0.0; 3]);
        let failed = |field| move |source| StepError::Solve { field, time, source };
        numerics.u.solver.refresh(exec, &w.u_eqn.a).map_err(failed("U"))?;
        numerics.p.solver.refresh(exec, &w.p_eqn.a).map_err(failed("p"))?;
        numerics.compression.refresh(exec, &w.coupled.viscous.a).map_err(failed("p"))
    }

    /// `directions[j] = P^-1 basis[j]`; iterations of the velocity and pressure systems. None where
    /// the velocity's solver fails on central convection: the next cycle has another matrix.
    fn precondition(&mut self, j: usize, scales: Scales) -> Result<Option<[usize; 2]>, StepError> {
        let time = self.state.time;
        let failed = |field| move |source| StepError::Solve { field, time, source };
        let Flow { exec, mesh, numerics, work: w, two_phase, fluid, .. } = self;
        let n = mesh.n_cells;
        let (rho, rho_1) = (&w.rho.data, fluid.rho);
        let light = two_phase.as_ref().map_or(1.0, |t| (t.rho_2 / rho_1).min(1.0));
        let Coupled { basis, directions, du, flux, viscous, rhs, second, tightness, defer, .. } =
            &mut w.coupled;
        let (v, z) = (&basis[j], &mut directions[j]);
        // Momentum with the pressure as it is.
        let force = &mut w.hby_a;
        exec.for_each(&mut force[..n], |first, b| {
            for (i, b) in b.iter_mut().enumerate() {
                let c = first + i;
                *b = v.u[c].scaled(scales.force * rho[c] / rho_1);
            }
        });
        z.u.fill([0.0; 3]);
        let solver = &mut numerics.u.solver;
        let tolerance =
            Tolerance { rel: (VELOCITY.rel * *tightness * light).max(TIGHTEST), ..VELOCITY };
        let result = solver.solve(exec, &w.u_eqn.a, &force[..n], &mut z.u, &tolerance);
        if hopeless(&result) && numerics.convection == Convection::Linear && !*defer {
            w.solves[0] += SolveCount { all: 1, unconverged: 1 };
            *defer = true;
            return Ok(None);
        }
        let [of_velocity, of_pressure] = &mut w.solves;
        let of_u =
            settle(result, &mut z.u, Purpose::Direction, of_velocity).map_err(failed("U"))?;
        // What its flux lacks.
        mesh.halo.update(exec, &mut z.u);
        du.cells.data.copy_from_slice(&z.u);
        operators::flux(exec, mesh, du, &du.cells.data, flux);
        let flux = &flux.data;
        exec.for_each(rhs, |first, b| {
            for (i, b) in b.iter_mut().enumerate() {
                let net: f64 = mesh.faces_of(first + i).map(|(f, s)| s * flux[f]).sum();
                *b = scales.flux * v.p[first + i] - net;
            }
        });
        // Where inertia rules,
        let p1 = &mut w.p_prime.cells.data;
        p1.fill(0.0);
        let result = numerics.p.solver.solve(exec, &w.p_eqn.a, rhs, p1, &PRESSURE);
        let of_p1 = settle(result, p1, Purpose::Direction, of_pressure).map_err(failed("p"))?;
        // and where viscosity does.
        second.fill(0.0);
        let result = numerics.compression.solve(exec, &viscous.a, rhs, second, &PRESSURE);
        let of_p2 = settle(result, second, Purpose::Direction, of_pressure).map_err(failed("p"))?;
        mesh.halo.update(exec, &mut w.p_prime.cells.data);
        w.slopes_of_pressure(exec, mesh, numerics, two_phase.as_deref_mut(), Slopes::OfChange);
        let Coupled { directions, second, .. } = &mut w.coupled;
        let z = &mut directions[j];
        let (r_at, grad, p1) = (&w.r_at.data, &w.grad_p, &w.p_prime.cells.data);
        exec.for_each2(&mut z.u[..n], &mut z.p[..n], |first, u, p| {
            for i in 0..u.len() {
                let c = first + i;
                u[i] = u[i].axpy(-r_at[c], grad[c]);
                p[i] = p1[c] + second[c];
            }
        });
        crate::momentum::keep_solved(exec, mesh, &mut z.u);
        Ok(Some([of_u.iterations, of_p1.iterations + of_p2.iterations]))
    }

    /// `basis[j + 1] = A directions[j]`, momentum and continuity.
    fn apply_operator(&mut self, j: usize, scales: Scales) {
        let deferred = self.defers_convection();
        let Flow { exec, mesh, state, numerics, work: w, fluid, two_phase, sources, .. } = self;
        let n = mesh.n_cells;
        let leaning = mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0;
        let share = two_phase.as_ref().and_then(|t| t.share());
        let Coupled { basis, directions, du, gradient, stress, .. } = &mut w.coupled;
        let (out, z) = (&mut basis[j + 1], &mut directions[j]);
        mesh.halo.update(exec, &mut z.u);
        mesh.halo.update(exec, &mut z.p);
        du.cells.data.copy_from_slice(&z.u);
        w.p_prime.cells.data.copy_from_slice(&z.p);
        let transposed = !fluid.rheology.is_constant();
        // A limited correction of stress is not linear: it waits for the next cycle. The flux knows
        // no limit.
        let corrected = leaning && numerics.non_orthogonal >= 1.0;
        let skewed = mesh.is_skewed();
        // What central differences lack on skewed faces, or in the matrix, is linear in the
        // velocity, flux held. Extrapolation and limited schemes wait for the next cycle.
        let carried = (skewed || deferred) && numerics.convection == Convection::Linear;
        if transposed || corrected || skewed {
            numerics.gradient.of(exec, mesh, du, gradient);
        }
        stress.data.fill([0.0; 3]);
        if transposed {
            operators::transpose_stress_flux(exec, mesh, du, gradient, &w.eta_f, stress);
        }
        if w.newton.active {
            let of = (&*du, &gradient[..]);
            let dp = (&w.p_prime, share);
            w.newton.add_change_of_viscosity(exec, mesh, &w.reconstruction, of, dp, stress);
        }
        if corrected {
            let (eta, all) = (&w.eta_f, numerics.non_orthogonal);
            let extra = &mut w.scratch_f;
            operators::non_orthogonal_flux(exec, mesh, du, gradient, eta, all, extra);
            let extra = &w.scratch_f.data;
            exec.for_each(&mut stress.data, |first, t| {
                t.iter_mut().enumerate().for_each(|(i, t)| *t = t.plus(extra[first + i]));
            });
        }
        if carried {
            // The weights come out as they are in the matrix.
            let (flux, extra) = (&w.rho_phi.data, &mut w.scratch_f);
            if !skewed {
                extra.data[..mesh.n_inner].fill([0.0; 3]);
            }
            numerics.convection.weigh(exec, mesh, du, gradient, flux, &mut w.weights, extra);
            if deferred {
                defer_to_upwind(exec, mesh, du, flux, &mut w.weights, extra);
            }
            let extra = &w.scratch_f.data;
            exec.for_each(&mut stress.data[..mesh.n_inner], |first, t| {
                t.iter_mut().enumerate().for_each(|(i, t)| *t = t.minus(extra[first + i]));
            });
        }
        w.friction.keep_normal(exec, mesh, &state.u, stress);
        w.friction.add_change(exec, mesh, &state.u, (&z.u, &w.p_prime), stress);
        w.u_eqn.a.apply(exec, &mut z.u, &mut out.u);
        for frame in sources.iter().filter_map(|s| s.frame()) {
            let omega = granflow_base::scale(frame.axis, frame.omega.at(state.time));
            let (rho, volume) = (&w.rho.data, &mesh.volume);
            frame.zone.each(n, |c| {
                let turned = granflow_base::cross(omega, z.u[c]);
                out.u[c] = out.u[c].axpy(rho[c] * volume[c], turned);
            });
        }
        let two = two_phase.as_deref_mut();
        w.slopes_of_pressure(exec, mesh, numerics, two, Slopes::OfChange);
        let Coupled { basis, directions, du, gradient, stress, flux, carrier, .. } = &mut w.coupled;
        let (out, z) = (&mut basis[j + 1], &mut directions[j]);
        let of = Interpolated {
            u: du,
            cells: &z.u,
            skewed: skewed.then_some(&gradient[..]),
            grad_p: &w.grad_p,
            dp_dn: &w.dp_dn,
            mobility: &w.r_a_f.data,
            weights: &w.flux_weights,
        };
        interpolated_flux(exec, mesh, &of, flux);
        let (rho, rho_1) = (&w.rho.data, fluid.rho);
        if carrier.follows {
            // What the change of the flux carries.
            let (u, flux) = (&state.u, &flux.data);
            exec.for_each(&mut stress.data, |first, t| {
                for (i, t) in t.iter_mut().enumerate() {
                    let f = first + i;
                    *t = t.axpy(-rho_1 * flux[f], u.face_value(mesh, f));
                }
            });
        }
        let (stress, flux, grad, volume) = (&stress.data, &flux.data, &w.grad_p, &mesh.volume);
        exec.for_each2(&mut out.u[..n], &mut out.p[..n], |first, u, p| {
            for i in 0..u.len() {
                let c = first + i;
                let (mut force, mut net) = (u[i].axpy(volume[c], grad[c]), 0.0);
                for (f, s) in mesh.faces_of(c) {
                    force = force.axpy(-s, stress[f]);
                    net += s * flux[f];
                }
                u[i] = force.scaled(rho_1 / rho[c] / scales.force);
                p[i] = net / scales.flux;
            }
        });
        crate::momentum::keep_solved(exec, mesh, &mut out.u);
    }
}

/// Whether a velocity of the preconditioner is worthless: a matrix far from dominant lets sweeps
/// grow without bounds.
fn hopeless(result: &Result<Solved, SolveError>) -> bool {
    match result {
        Err(SolveError::NotConverged(solved)) => solved.last > HOPELESS * solved.first,
        Err(SolveError::NotFinite { .. }) => true,
        _ => false,
    }
}
