//! The steady state, found directly: a step without inertia, iterated until momentum, continuity, viscosity and
//! the friction of walls balance, from the flow as it is and else from rest.
//!
//! The interface between two fluids is held. Where the iteration does not converge the flow is relaxed in
//! pseudo-time: steps of implicit Euler whose length grows as long as their forces come near to balance
//! (W. A. Mulder, B. van Leer, J. Comput. Phys. 59 (1985) 232; convergence: C. T. Kelley, D. E. Keyes, SIAM J. Numer.
//! Anal. 35 (1998) 508), until one without end converges.

use crate::failure::Guess;
use crate::{Flow, Report, Residuals, StepError, TimeScheme};
use granflow_base::norm;
use granflow_physics::rheology::FlowView;

/// A step of such a length, s, has no inertia.
pub(crate) const FOREVER: f64 = FlowView::FOREVER;
/// Steps of pseudo-time at most.
const MOST_STEPS: usize = 60;
/// Passes of all of them together, and of each but an endless one.
const MOST_PASSES: usize = 1500;
const PASSES: usize = 40;
/// Growth of the step after one that came to an end ([`RELAXED`]), and what is left of one that did not.
const GROWTH: f64 = 4.0;
const CUT: f64 = 0.1;
/// Steps, over the first, from which on one without end is tried, and below which there is no hope.
const LONG: f64 = 1e3;
const SHORT: f64 = 1e-4;

/// Steps ahead whose conditions are looked at.
const MOST_LOOKED_AT: f64 = 1e4;

/// The state of a flow, set aside.
struct Snapshot {
    u: Vec<granflow_base::Vec3>,
    p: Vec<f64>,
    phi: Vec<f64>,
    field: Option<Vec<f64>>,
    /// Velocity and flux one step earlier, and the length of that step.
    older: (Vec<granflow_base::Vec3>, Vec<f64>, f64),
    clock: (f64, usize),
    sources: Vec<Box<dyn crate::Source>>,
}

impl Flow {
    /// Residuals of the state as it stands, taken as a steady state (no inertia between steps);
    /// nothing is changed. This is what tells a solution from a velocity that merely stands still:
    /// all three are measured with each other's present fields.
    ///
    /// # Errors
    /// [`StepError`] when the rheology gives no viscosity.
    pub fn residuals(&mut self) -> Result<Residuals, StepError> {
        let Flow { state, work: w, fluid, .. } = self;
        w.u_start.copy_from_slice(&state.u.cells.data);
        w.p_start.copy_from_slice(&state.p.cells.data);
        w.phi_start.copy_from_slice(&state.phi.data);
        w.clock_start = (state.time, state.step);
        fluid.rheology.begin_step();
        w.friction.forget();
        self.begin_sources();
        self.update_conditions();
        let measured = self.measured_without_inertia(FOREVER);
        self.rollback();
        measured
    }

    fn measured_without_inertia(&mut self, forever: f64) -> Result<Residuals, StepError> {
        self.recall_viscosity(forever)?;
        self.assemble_momentum(forever)?;
        let mut residuals = Residuals {
            u: self.momentum_residual(),
            p: self.continuity_residual(),
            viscosity: 0.0,
        };
        if !self.fluid.rheology.is_constant() {
            self.evaluate_rheology(forever)?;
            residuals.viscosity = self.viscosity_residual();
        }
        Ok(residuals)
    }

    /// The length of a step as inertia sees it, s.
    pub(crate) fn inertial_step(&self, clock: f64) -> f64 {
        match self.numerics.ddt {
            TimeScheme::Steady => self.work.pseudo_step.unwrap_or(FOREVER),
            _ => clock,
        }
    }

    /// The steady state of the conditions `dt` seconds from now, to which the clock moves.
    ///
    /// # Errors
    /// As [`Flow::step`]; [`StepError::Beyond`] and [`StepError::NoSteadyState`] where none was found.
    pub(crate) fn find_steady_state(&mut self, dt: f64) -> Result<Report, StepError> {
        let before = self.snapshot();
        let direct = self.try_step(dt);
        let nearest = match &direct {
            Ok(report) if report.converged => return self.believe(*report),
            // All but there: relaxation would come no nearer.
            Ok(report) if self.stalled(&report.residuals) => {
                return Ok(Report { steady: true, ..*report });
            }
            Ok(report) => report.residuals,
            Err(StepError::Interrupted { .. } | StepError::Condition { .. }) => return direct,
            Err(_) => self.work.residuals,
        };
        let beyond = match direct {
            // Stress that an iteration that went astray has asked for says nothing yet.
            Err(StepError::Beyond { beyond, .. }) => Some(beyond),
            _ => self.work.beyond,
        };
        self.restore(&before);
        let spent = direct.as_ref().map_or(0, |r| r.outer);
        let relaxed = self.relax(dt, &before, (nearest, spent));
        self.work.pseudo_step = None;
        if let Err(StepError::NoSteadyState { time, residuals }) = relaxed
            && let Some(beyond) = self.work.beyond.or(beyond)
        {
            let seen = Box::new(StepError::NoSteadyState { time, residuals });
            return Err(StepError::Beyond { time, beyond, seen });
        }
        relaxed
    }

    /// Whether forces and fluxes balance and only the viscosity keeps a little noise.
    fn stalled(&self, now: &Residuals) -> bool {
        let control = &self.numerics.control;
        now.u <= control.u && now.p <= control.p && now.viscosity <= NOISE
    }

    /// A converged state, but where walls ask for more stress than grains carry: cells beside them, whose mean is less,
    /// may still have a solution.
    fn believe(&self, report: Report) -> Result<Report, StepError> {
        match self.beyond_at_walls() {
            None => Ok(Report { steady: true, ..report }),
            Some(beyond) => {
                let (time, residuals) = (report.time, report.residuals);
                let seen = Box::new(StepError::AtWalls { time, residuals });
                Err(StepError::Beyond { time, beyond, seen })
            }
        }
    }

    /// Whether velocity and pressure at the boundary ask the same at every step of `dt` seconds until `end`, on
    /// all ranks; false where that is too many steps to look at. (Conditions of the fluidity are not looked at.)
    pub fn conditions_stay(&mut self, dt: f64, end: f64) -> bool {
        let of = |f: &Flow| (f.state.u.closure.clone(), f.state.p.closure.clone());
        let (now, here) = (self.state.time, of(self));
        let left = ((end - now) / dt + 0.5).floor().max(0.0);
        if left > MOST_LOOKED_AT || !self.sources_stay(end) {
            // Nobody looks so far ahead: they may change.
            return false;
        }
        let stays = (1..=left as usize).all(|k| {
            self.state.time = now + k as f64 * dt;
            self.update_conditions();
            let there = of(self);
            let same = here.0.offset == there.0.offset
                && here.0.slope == there.0.slope
                && here.1.offset == there.1.offset
                && here.1.slope == there.1.slope;
            // Conditions may add up over ranks: all look at the same steps.
            let mut differs = [f64::from(u8::from(!same))];
            self.exec.comm().max(&mut differs);
            differs[0] == 0.0
        });
        self.state.time = now;
        self.update_conditions();
        stays
    }

    /// Steps of pseudo-time, longer and longer. What the last of them would take back is all of them.
    fn relax(
        &mut self,
        dt: f64,
        before: &Snapshot,
        (mut nearest, spent): (Residuals, usize),
    ) -> Result<Report, StepError> {
        let first = self.time_of_a_cell();
        let mut tau = first;
        let mut passes = spent;
        let outer = self.numerics.outer;
        let time = before.clock.0 + dt;
        for _ in 0..MOST_STEPS {
            if passes > MOST_PASSES {
                break;
            }
            let endless = tau > LONG * first;
            self.work.pseudo_step = if endless { None } else { Some(tau) };
            self.state.time = before.clock.0;
            let last = self.snapshot();
            self.numerics.outer = if endless { outer } else { outer.min(PASSES) };
            let step = self.advance(dt, Guess::Old);
            self.numerics.outer = outer;
            let step = match step {
                Ok(step) => step,
                Err(e @ (StepError::Interrupted { .. } | StepError::Condition { .. })) => {
                    self.restore(before);
                    return Err(e);
                }
                Err(_) => None,
            };
            // One that failed has used up what it may.
            passes += step.map_or(PASSES, |r| r.outer);
            if let Some(report) = step.filter(|_| endless) {
                if report.residuals.u < nearest.u {
                    nearest = report.residuals;
                }
                if report.converged || self.stalled(&report.residuals) {
                    let verdict = self.believe(Report { outer: passes, steady: true, ..report });
                    if verdict.is_err() {
                        self.restore(before);
                    }
                    self.remember_start(before);
                    self.state.step = before.clock.1 + usize::from(verdict.is_ok());
                    return verdict;
                }
            }
            if step.is_some_and(|r| r.converged || !endless && r.residuals.u < RELAXED) {
                tau *= GROWTH;
            } else {
                self.restore(&last);
                tau *= CUT;
                if tau < SHORT * first {
                    break;
                }
            }
        }
        // Whoever takes the step back takes back all of it.
        self.restore(before);
        self.remember_start(before);
        Err(StepError::NoSteadyState { time, residuals: nearest })
    }

    /// The time in which the flow crosses a cell, or falls through it, s: the first step of pseudo-time.
    fn time_of_a_cell(&self) -> f64 {
        let (mesh, state) = (&self.mesh, &self.state);
        let size =
            self.exec.max(mesh.n_cells, |r| r.map(|c| 1.0 / mesh.cell_size(c)).fold(0.0, f64::max));
        let size = 1.0 / size;
        let inside = |c: usize| norm(state.u.cells.data[c]);
        let moving = self.exec.max(mesh.n_cells, |r| r.map(inside).fold(0.0, f64::max));
        let n = mesh.n_faces() - mesh.n_inner;
        let wall = |b: usize| norm(state.u.boundary_value(mesh, mesh.n_inner + b));
        let walls = self.exec.max(n, |r| r.map(wall).fold(0.0, f64::max));
        let falling = (norm(self.gravity.driving) * size).sqrt();
        let speed = moving.max(walls).max(falling);
        if speed > 0.0 { size / speed } else { 1.0 }
    }

    fn snapshot(&self) -> Snapshot {
        let s = &self.state;
        Snapshot {
            u: s.u.cells.data.clone(),
            p: s.p.cells.data.clone(),
            phi: s.phi.data.clone(),
            field: self.fluid.rheology.field().map(|f| f.data.clone()),
            older: (s.u_old.clone(), s.phi_old.clone(), s.dt_old),
            clock: (s.time, s.step),
            sources: self.sources.clone(),
        }
    }

    fn restore(&mut self, to: &Snapshot) {
        self.rollback();
        self.sources.clone_from(&to.sources);
        let s = &mut self.state;
        s.u.cells.data.copy_from_slice(&to.u);
        s.p.cells.data.copy_from_slice(&to.p);
        s.phi.data.copy_from_slice(&to.phi);
        s.u_old.copy_from_slice(&to.older.0);
        s.phi_old.copy_from_slice(&to.older.1);
        s.dt_old = to.older.2;
        (s.time, s.step) = to.clock;
        if let (Some(field), Some(kept)) = (self.fluid.rheology.field_mut(), &to.field) {
            field.data.copy_from_slice(kept);
        }
        // What is remembered of old times is that of the snapshot too.
        self.fluid.rheology.begin_step();
        self.update_conditions();
    }

    /// The start of the step is that of all its pseudo-time.
    fn remember_start(&mut self, before: &Snapshot) {
        let w = &mut self.work;
        w.u_start.copy_from_slice(&before.u);
        w.p_start.copy_from_slice(&before.p);
        w.phi_start.copy_from_slice(&before.phi);
        w.clock_start = before.clock;
        self.remember_sources(&before.sources);
    }
}

/// Change of ln(viscosity) that counts as noise.
const NOISE: f64 = 1e-4;
/// Residual of momentum of a step in pseudo-time that is good enough to go on from.
const RELAXED: f64 = 1e-3;
