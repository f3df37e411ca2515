//! One time step, top to bottom: conditions, then outer iterations of momentum, pressure and
//! viscosity until the residuals of one and the same state are small, then the report.

use crate::failure::{Guess, Hope, is_sound};
use crate::work::Work;
use crate::{Fluid, Gravity, Numerics, Report, Residuals, State, StepError, TimeScheme};
use granflow_base::norm;
use granflow_linsolve::Solved;
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::RheologyInfo;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A flow: what it is, how it is solved, and the scratch to do so.
pub struct Flow {
    /// Threads and ranks.
    pub exec: Exec,
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// What a restart holds.
    pub state: State,
    /// The material.
    pub fluid: Fluid,
    /// Forces on the bulk.
    pub gravity: Gravity,
    /// How to solve.
    pub numerics: Numerics,
    /// The second fluid, where there are two.
    pub two_phase: Option<Box<crate::TwoPhase>>,
    /// Forces on the bulk beside gravity.
    pub sources: Vec<Box<dyn crate::Source>>,
    /// Set from outside: a step that is under way is given up before its next outer pass.
    pub stop: Option<Arc<AtomicBool>>,
    /// Hears of every outer pass.
    pub watch: Option<crate::Watch>,
    /// What turning frames among the sources do to faces.
    pub(crate) frames: Option<Box<crate::frame::Frames>>,
    pub(crate) level_fixed: bool,
    pub(crate) work: Work,
}

impl Flow {
    /// Puts the parts together and allocates what a step needs, but for the directions of coupled
    /// passes and the best of them, which the first ones allocate.
    pub fn new(
        exec: Exec,
        mesh: Arc<Mesh>,
        state: State,
        fluid: Fluid,
        gravity: Gravity,
        numerics: Numerics,
    ) -> Self {
        let local = fluid.rheology.is_local() && !fluid.rheology.is_constant();
        let work =
            Work::new(&exec, &mesh, (fluid.rho, local), gravity.driving, (&state.u, &state.p));
        let fixed = [if state.p.fixes_level(&mesh) { 1.0 } else { 0.0 }];
        let mut any = fixed;
        exec.comm().max(&mut any);
        let level_fixed = any[0] > 0.0;
        let (stop, watch, two_phase) = (None, None, None);
        let mut flow = Flow {
            exec,
            mesh,
            state,
            fluid,
            gravity,
            numerics,
            two_phase,
            sources: Vec::new(),
            stop,
            watch,
            frames: None,
            level_fixed,
            work,
        };
        flow.update_conditions();
        flow
    }

    /// What [`Flow::step`] does, with errors as they come; nothing where the iteration lost its way
    /// and another guess is left.
    pub(crate) fn advance(&mut self, dt: f64, guess: Guess) -> Result<Option<Report>, StepError> {
        if self.two_phase.is_some() {
            return self.advance_two_phases(dt).map(Some);
        }
        self.begin_step(dt);
        self.refuse_faults()?;
        let clock = dt;
        let dt = self.inertial_step(clock);
        if guess == Guess::Rest {
            self.rest();
        }
        self.recall_viscosity(dt)?;
        let mut report = Report { time: self.state.time, dt: clock, ..Report::default() };
        if !self.is_coupled() {
            self.give_up_if_asked()?;
            // PISO: one pass was asked for; a generalised Newtonian viscosity follows the flow one
            // step behind, as users of PISO expect.
            self.assemble_momentum(dt)?;
            report.outer = 1;
            self.correct(dt, 1.0, true, &mut report)?;
            self.move_to_mean_velocity();
            report.converged = true;
            report.residuals.u = report.u.map_or(0.0, |(first, _)| first.first);
            report.residuals.p = self.continuity_residual();
            self.end_step(clock, &mut report)?;
            return Ok(Some(report));
        }
        self.iterate(dt, &mut report)?;
        // Given up before its passes were used up, or ended far from any flow. What a local law comes to
        // is nearer in the next step.
        let nonlocal = !self.fluid.rheology.is_local();
        let gave_up = nonlocal && report.outer < self.numerics.outer.max(1);
        let lost = !report.converged && (gave_up || !is_sound(&report.residuals));
        if lost && guess == Guess::Old && self.may_start_from_rest() {
            return Ok(None);
        }
        self.end_coupled_step(clock, &mut report)?;
        Ok(Some(report))
    }

    /// Outer passes on momentum, continuity and viscosity until the residuals of one and the same
    /// state are small, or there is no hope. The viscosity has been recalled.
    pub(crate) fn iterate(&mut self, dt: f64, report: &mut Report) -> Result<(), StepError> {
        self.work.anderson.reset();
        self.guess_mean_gradient(dt);
        let constant = self.fluid.rheology.is_constant();
        let outer = self.numerics.outer.max(1);
        report.coupled = true;
        let mut hope = Hope::default();
        // Beside another fluid single cells may come in and out of contact for ever.
        let keeps = self.has_grains_in_fluid() && !self.fluid.rheology.is_local();
        for k in 0..=outer {
            self.give_up_if_asked()?;
            // In the first pass nothing has moved yet, but the walls and the clock.
            let settled = if k == 0 {
                if self.has_newton() {
                    self.evaluate_rheology(dt)?;
                    self.accept_viscosity();
                }
                self.assemble_momentum(dt)?;
                report.residuals.u = self.momentum_residual();
                report.residuals.p = self.continuity_residual();
                // A guessed viscosity says nothing of how it follows the flow.
                if std::mem::take(&mut self.work.slowest) > 0.0 || outer == 1 {
                    self.work.newton.refused = true;
                }
                constant
            } else {
                self.measure(dt, constant, k == outer, report)?
            };
            if k > 0 && self.answer_mean_velocity(dt, &report.residuals) {
                self.assemble_momentum(dt)?;
                report.residuals.u = self.momentum_residual();
            }
            self.check_residuals(&report.residuals)?;
            self.work.residuals = report.residuals;
            if let Some(crate::Watch(watch)) = &self.watch {
                watch(k, &report.residuals);
            }
            report.converged = k > 0 && settled && report.residuals.within(&self.numerics.control);
            if report.converged || k == outer {
                break;
            }
            if k > 0 && !hope.is_left(&report.residuals, &self.numerics.control) {
                // As a last pass does: what is left behind is the rheology's own.
                if !constant {
                    self.accept_viscosity();
                }
                break;
            }
            if k > 0 && keeps {
                self.keep_if_best(&report.residuals);
            }
            report.outer = k + 1;
            if self.carrier_may_follow() {
                self.work.coupled.carrier.decide(report.residuals.u);
            }
            let wanted = self.wanted_reduction(settled, &report.residuals);
            self.correct(dt, wanted, k + 1 == outer, report)?;
        }
        if !report.converged && keeps && self.return_to_best(&report.residuals)? {
            // The model's field is that of this state; the viscosity stays the one that momentum balances with.
            add(&mut report.rheology, self.evaluate_rheology(dt)?);
            self.assemble_momentum(dt)?;
            report.residuals = Residuals {
                u: self.momentum_residual(),
                p: self.continuity_residual(),
                viscosity: self.viscosity_residual(),
            };
            self.work.residuals = report.residuals;
        }
        Ok(())
    }

    /// What carries is conserved, converged or not; what is no flow is refused.
    pub(crate) fn end_coupled_step(
        &mut self,
        dt: f64,
        report: &mut Report,
    ) -> Result<(), StepError> {
        let last = &report.residuals;
        let nothing =
            last.u >= NO_FLOW || last.viscosity >= NO_VISCOSITY && last.u >= FAR_FROM_BALANCE;
        if !report.converged && nothing {
            let (time, residuals) = (self.state.time, report.residuals);
            return Err(StepError::NoFlow { time, residuals });
        }
        let moves = self.two_phase.is_some() && !self.holds_interface();
        let wanted = if moves { CONSERVES } else { self.numerics.control.p };
        if report.residuals.p > wanted {
            self.project_flux(report.residuals.p, wanted)?;
        }
        self.end_step(dt, report)
    }

    /// Evaluates the rheology at the flow as it stands, assembles momentum with what comes out,
    /// and says whether the viscosity is settled. All residuals belong to one state: velocity,
    /// pressure and flux as they are, viscosity from them.
    fn measure(
        &mut self,
        dt: f64,
        constant: bool,
        last: bool,
        report: &mut Report,
    ) -> Result<bool, StepError> {
        let (mut settled, mut beyond) = (true, None);
        if !constant {
            for once_more in [true, false] {
                let info = self.evaluate_rheology(dt)?;
                beyond = info.beyond;
                add(&mut report.rheology, info);
                report.residuals.viscosity = self.viscosity_residual();
                settled = report.residuals.viscosity <= self.numerics.control.viscosity
                    && info.residual <= RHEOLOGY_SOLVED;
                // What followed from the pass before may be another root than the flow's.
                let ends = once_more && (settled || last);
                if !(ends && self.fluid.rheology.doubt()) {
                    break;
                }
            }
            self.work.patience.note(report.residuals.viscosity);
            if self.rests() {
                // Times rounding, another one would be a force.
            } else if settled || last || self.has_newton() {
                self.accept_viscosity();
            } else {
                self.mix_viscosity();
            }
        }
        self.assemble_momentum(dt)?;
        report.residuals.u = self.momentum_residual();
        report.residuals.p = self.continuity_residual();
        // Stress in a state that is far from a flow says nothing of the grains.
        if is_sound(&report.residuals) {
            self.work.beyond = beyond;
        }
        report.rheology.beyond = self.work.beyond;
        Ok(settled)
    }

    /// How far the next pass is to reduce momentum and continuity: a little more than convergence
    /// needs, and not much while the viscosity is still on its way.
    fn wanted_reduction(&self, settled: bool, now: &Residuals) -> f64 {
        let control = &self.numerics.control;
        let needed = 0.1 * (control.u / now.u).min(control.p / now.p);
        let (least, mut most) = if settled { SETTLED } else { MOVING };
        if self.has_grains_in_fluid() && !self.has_newton() {
            most = most.min(MOVING_BESIDE);
        }
        let care = if settled { 1.0 } else { self.work.patience.care };
        if self.carrier_may_follow() {
            return self.work.coupled.carrier.wanted_reduction(needed, now.u);
        }
        if needed.is_nan() { most } else { needed.clamp(least, most) * care }
    }

    /// Whether momentum and pressure are solved together, until their residuals are small: always
    /// where the viscosity follows the pressure, and where more than one outer pass was asked for.
    pub(crate) fn is_coupled(&self) -> bool {
        self.numerics.outer > 1
            || self.fluid.rheology.reads_pressure()
            || self.numerics.ddt == TimeScheme::Steady
    }

    /// One outer pass at the present viscosity. `wanted` is the reduction of the residuals that
    /// convergence needs.
    fn correct(
        &mut self,
        dt: f64,
        wanted: f64,
        last: bool,
        report: &mut Report,
    ) -> Result<(), StepError> {
        if self.is_coupled() {
            let [u, p] = if self.has_newton() {
                self.newton_pass(dt, wanted)?
            } else {
                self.solve_coupled(dt, wanted)?
            };
            note(&mut report.u, &mut report.iterations[0], u);
            note(&mut report.p, &mut report.iterations[1], p);
            return Ok(());
        }
        if self.numerics.predictor {
            let solved = self.predict_velocity(last)?;
            note(&mut report.u, &mut report.iterations[0], solved);
        }
        self.update_mobility(dt);
        for i in 0..self.numerics.correctors {
            let solved = self.correct_pressure(dt, last && i + 1 == self.numerics.correctors)?;
            note(&mut report.p, &mut report.iterations[1], solved);
        }
        Ok(())
    }

    pub(crate) fn begin_step(&mut self, dt: f64) {
        self.work.friction.forget();
        self.remember_flux(self.inertial_step(dt));
        self.set_local_steps(dt);
        self.begin_sources();
        let Flow { state, work: w, fluid, two_phase, .. } = self;
        w.u_start.copy_from_slice(&state.u.cells.data);
        w.p_start.copy_from_slice(&state.p.cells.data);
        w.phi_start.copy_from_slice(&state.phi.data);
        fluid.rheology.begin_step();
        w.clock_start = (state.time, state.step);
        w.fresh = false;
        w.coupled.begin_step();
        w.newton.begin_step(two_phase.is_some());
        w.best.forget();
        w.patience = Patience::default();
        w.solves = Default::default();
        w.beyond = None;
        w.slowest = 0.0;
        w.residuals = Residuals::default();
        state.time += dt;
        state.step += 1;
        self.update_conditions();
        self.start_at_mean_velocity();
    }

    pub(crate) fn end_step(&mut self, dt: f64, report: &mut Report) -> Result<(), StepError> {
        self.check_finite()?;
        let Flow { exec, mesh, state, numerics, work: w, .. } = &mut *self;
        let (u, old) = (&state.u.cells.data, &w.u_start);
        let [change, most] =
            max2(exec, mesh.n_cells, |c| [norm(granflow_base::sub(u[c], old[c])), norm(u[c])]);
        report.change = if most > 0.0 { change / most } else { 0.0 };
        let phi = &state.phi.data;
        let crossing =
            |c: usize| 0.5 * dt * mesh.faces_of(c).map(|(f, _)| phi[f].abs()).sum::<f64>();
        let n = mesh.n_cells;
        let of = |c: usize| [crossing(c), mesh.volume[c]];
        let [crossed, volume] =
            exec.sums(n, |r| r.map(of).fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]));
        let greatest = exec.max(n, |r| r.map(|c| crossing(c) / mesh.volume[c]).fold(0.0, f64::max));
        if numerics.ddt != TimeScheme::Steady {
            report.courant = [crossed / volume, greatest];
        }
        report.solves = w.solves;
        self.remember_old(dt);
        self.state.dt_old = dt;
        self.work.fresh = true;
        Ok(())
    }

    /// Restores the state before the step that failed.
    pub fn rollback(&mut self) {
        self.rollback_sources();
        let Flow { state, work: w, fluid, two_phase, .. } = self;
        (state.time, state.step) = w.clock_start;
        w.fresh = false;
        w.slowest = 0.0;
        state.u.cells.data.copy_from_slice(&w.u_start);
        state.p.cells.data.copy_from_slice(&w.p_start);
        state.phi.data.copy_from_slice(&w.phi_start);
        if let (Some(two), Some(alpha)) = (two_phase, &mut state.alpha) {
            alpha.cells.data.copy_from_slice(&two.work.alpha_start);
            if let Some(grains) = &mut two.work.grains {
                grains.share.copy_from_slice(&grains.share_old);
            }
        }
        fluid.rheology.rollback();
    }

    /// Net over gross flux of the cells. Grains under a fluid may rest altogether: they count as moving
    /// at [`STILL`].
    pub(crate) fn continuity_residual(&self) -> f64 {
        let (mesh, phi) = (&self.mesh, &self.state.phi.data);
        let fall = self.free_fall();
        let still = |c: usize| STILL * fall.speed(mesh.cell_size(c));
        let [net, gross] = self.exec.sums(mesh.n_cells, |range| {
            let mut s = [0.0; 2];
            for c in range {
                let (mut net, mut gross) = (0.0, 0.0);
                for (f, sign) in mesh.faces_of(c) {
                    net += sign * phi[f];
                    gross += phi[f].abs();
                    if fall.g > 0.0 {
                        gross += still(c) * mesh.mag_area[f];
                    }
                }
                s[0] += f64::abs(net);
                s[1] += gross;
            }
            s
        });
        if gross == 0.0 { 0.0 } else { net / gross }
    }

    /// A residual that is no number stops the step: fields that are still finite may be worthless.
    /// The residuals are those of all ranks, which therefore stop together.
    fn check_residuals(&self, now: &Residuals) -> Result<(), StepError> {
        if now.u.is_finite() && now.p.is_finite() {
            return Ok(());
        }
        self.check_finite()?;
        let (u, r, time) = (&self.state.u.cells.data, &self.work.residual, self.state.time);
        let worst = |c: &usize| if norm(r[*c]).is_finite() { norm(u[*c]) } else { f64::INFINITY };
        let cell = (0..self.mesh.n_cells).max_by(|a, b| worst(a).total_cmp(&worst(b)));
        let Some(cell) = cell else { return Err(StepError::Elsewhere { time }) };
        Err(StepError::NotFinite {
            field: "the residual of U",
            cell: self.mesh.global_cell[cell] as usize,
            place: self.mesh.cell_centre[cell],
            time,
            cause: "the outer iteration diverged: start from a field nearer to the flow, or with \
                    shorter steps",
        })
    }

    fn check_finite(&self) -> Result<(), StepError> {
        let (u, p) = (&self.state.u.cells.data, &self.state.p.cells.data);
        // Over all ranks first: one that stops alone would leave the others waiting.
        let sound = |c: usize| u[c].iter().all(|x| x.is_finite()) && p[c].is_finite();
        let bad = |r: std::ops::Range<usize>| r.map(|c| f64::from(u8::from(!sound(c))));
        if self.exec.max(self.mesh.n_cells, |r| bad(r).fold(0.0, f64::max)) == 0.0 {
            return Ok(());
        }
        let (u, p) = (&self.state.u.cells.data, &self.state.p.cells.data);
        let bad = |field, finite: &dyn Fn(usize) -> bool| {
            let cell = (0..self.mesh.n_cells).find(|&c| !finite(c))?;
            Some(StepError::NotFinite {
                field,
                cell: self.mesh.global_cell[cell] as usize,
                place: self.mesh.cell_centre[cell],
                time: self.state.time,
                cause: "the time step is too long for the explicit terms, or a boundary \
                        condition leaves the flow undetermined",
            })
        };
        Err(bad("U", &|c| u[c].iter().all(|x| x.is_finite()))
            .or_else(|| bad("p", &|c| p[c].is_finite()))
            .unwrap_or(StepError::Elsewhere { time: self.state.time }))
    }

    /// Strain rate, stress ratio and viscosity of the state, for output: 1/s, -, Pa s.
    ///
    /// # Errors
    /// [`StepError`] when the rheology gives no viscosity.
    pub fn derived(&mut self) -> Result<Derived<'_>, StepError> {
        self.update_conditions();
        if self.two_phase.is_some() && !self.has_grains_in_fluid() {
            self.mix_viscosity_of_fluids(self.state.dt_old.max(f64::MIN_POSITIVE))?;
        } else if self.work.fresh {
            self.total_pressure()?;
        } else {
            self.recall_viscosity(self.state.dt_old.max(f64::MIN_POSITIVE))?;
        }
        self.numerics.gradient.of(&self.exec, &self.mesh, &self.state.u, &mut self.work.grad_u);
        self.strain_rate_of_state();
        let Flow { mesh, work: w, two_phase, .. } = self;
        let eta = two_phase.as_ref().and_then(|t| t.viscosity()).unwrap_or(&w.eta.data);
        Ok(Derived {
            strain_rate: &w.strain_rate[..mesh.n_cells],
            viscosity: &eta[..mesh.n_cells],
            viscosity_f: &w.eta_f.data,
            pressure: &w.pressure[..mesh.n_cells],
            gradient_u: &w.grad_u,
        })
    }
}

/// Passes without progress of the viscosity before its noise is suspected.
const PATIENCE: usize = 4;
/// Change of ln(viscosity) above which it is on its way, and more than noise.
const ROUGH: f64 = 0.1;
/// A viscosity that stalls is noisy: near yield it depends so steeply on the stress that what
/// momentum leaves unbalanced shows. Then momentum is solved more exactly until it makes progress again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    best: f64,
    since: usize,
    /// Factor on the reduction asked of momentum and continuity.
    care: f64,
}

impl Default for Patience {
    fn default() -> Self {
        Patience { best: f64::INFINITY, since: 0, care: 1.0 }
    }
}

impl Patience {
    fn note(&mut self, residual: f64) {
        if residual < 0.5 * self.best {
            (self.best, self.since) = (residual, 0);
            self.care = (10.0 * self.care).min(1.0);
            return;
        }
        self.since += 1;
        if self.since >= PATIENCE {
            let least = if residual > ROUGH { 1e-1 } else { 1e-4 };
            (self.since, self.care) = (0, (0.1 * self.care).max(least));
        }
    }
}

/// Least and greatest reduction of momentum and continuity in one outer pass, with the viscosity
/// settled and on its way.
const SETTLED: (f64, f64) = (1e-6, 1e-1);
const MOVING: (f64, f64) = (1e-2, 1e-1);
/// The greatest beside another fluid, where what the pressure lacks decides who is in contact.
const MOVING_BESIDE: f64 = 1e-2;

/// A speed that counts as none, over that of a free fall through a cell.
const STILL: f64 = 1e-6;

/// Greatest imbalance of the rheology's own equation, over its terms, in a converged state: its
/// Newton iterations end far below, unless they stall.
const RHEOLOGY_SOLVED: f64 = 1e-6;

/// Residual of momentum, force imbalance over force, that no flow has: where an iteration that did
/// not converge ends with it, the step has failed.
const NO_FLOW: f64 = 1.0;
/// Residual of continuity of the flux that moves an interface: what it lacks stays in the volume fraction.
const CONSERVES: f64 = 1e-10;
/// Change of the logarithm of viscosity in a pass from which on it is no viscosity of that flow.
const NO_VISCOSITY: f64 = 10.0;
/// Residual of momentum that goes with it: single cells in a flow in balance may change that much.
pub(crate) const FAR_FROM_BALANCE: f64 = 0.1;

/// Fields that follow from the state.
pub struct Derived<'a> {
    /// `sqrt(2 D:D)`, 1/s.
    pub strain_rate: &'a [f64],
    /// Dynamic viscosity, Pa s.
    pub viscosity: &'a [f64],
    /// The same on faces.
    pub viscosity_f: &'a [f64],
    /// Pressure between grains, Pa.
    pub pressure: &'a [f64],
    /// Velocity gradient in cells and ghosts, 1/s.
    pub gradient_u: &'a [granflow_base::Tensor],
}

fn max2(exec: &Exec, n: usize, f: impl Fn(usize) -> [f64; 2] + Sync) -> [f64; 2] {
    [0, 1].map(|k| exec.max(n, |r| r.map(|c| f(c)[k]).fold(0.0, f64::max)))
}

pub(crate) fn note(kept: &mut Option<(Solved, Solved)>, iterations: &mut usize, solved: Solved) {
    *iterations += solved.iterations;
    let first = kept.map_or(solved, |(first, _)| first);
    *kept = Some((first, solved));
}

fn add(total: &mut RheologyInfo, one: RheologyInfo) {
    total.solves += one.solves;
    total.iterations += one.iterations;
    total.unconverged += one.unconverged;
    total.residual = one.residual;
    total.posedness = one.posedness;
}
