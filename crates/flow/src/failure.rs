//! Why a step failed, in terms of the physics where that is known.

use crate::{Flow, Report, ResidualControl, Residuals, StepError, TimeScheme};
use granflow_physics::rheology::Beyond;

/// Greatest residual of momentum and of continuity at which stress over pressure tells of the
/// material, and not of an iteration that lost its way; beyond it another guess is worth a try.
const SOUND: f64 = 1e-2;

/// Whether a state is near enough to a flow to be judged.
pub(crate) fn is_sound(residuals: &Residuals) -> bool {
    residuals.u <= SOUND && residuals.p <= SOUND
}

/// Growth of the residuals over their best after which passes are given up, and passes without a
/// new best.
const LOST: f64 = 1e6;
const TIRED: usize = 40;

/// Whether more outer passes may help.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hope {
    best: f64,
    since: usize,
}

impl Default for Hope {
    fn default() -> Self {
        Hope { best: f64::INFINITY, since: 0 }
    }
}

impl Hope {
    /// To be asked once a pass, with the residuals it came to.
    pub(crate) fn is_left(&mut self, now: &Residuals, control: &ResidualControl) -> bool {
        let over =
            (now.u / control.u).max(now.p / control.p).max(now.viscosity / control.viscosity);
        if over < self.best {
            *self = Hope { best: over, since: 0 };
        } else {
            self.since += 1;
        }
        self.since < TIRED && over <= LOST * self.best
    }
}

/// What a step iterates from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Guess {
    /// The flow at its beginning.
    Old,
    /// Material at rest.
    Rest,
    /// The flow at its beginning, whatever comes of it.
    OldAfterAll,
}

impl Flow {
    /// Whether the old flow was a guess only: nothing in the step is explicit.
    pub(crate) fn may_start_from_rest(&self) -> bool {
        self.is_coupled() && self.two_phase.is_none() && !self.fluid.rheology.is_constant()
    }

    /// Puts the guess in place of the old flow, which the time derivative keeps.
    pub(crate) fn rest(&mut self) {
        self.state.u.cells.data.fill([0.0; 3]);
        self.state.phi.data.fill(0.0);
        self.fluid.rheology.forget();
        self.update_conditions();
    }

    /// Advances by `dt` seconds.
    ///
    /// # Errors
    /// [`StepError`]; [`Flow::rollback`] then restores the state before the step (which has been
    /// done when it is [`StepError::Interrupted`]).
    ///
    /// A step whose iteration loses its way or gives up is taken once more, iterating from material at
    /// rest in place of the old flow, which may be far from anything that this material can do. Where
    /// that comes no nearer, what the old flow led to stands.
    pub fn step(&mut self, dt: f64) -> Result<Report, StepError> {
        match self.numerics.ddt {
            TimeScheme::Steady => self.find_steady_state(dt),
            _ => self.try_step(dt),
        }
    }

    /// A step of the length that inertia sees.
    pub(crate) fn try_step(&mut self, dt: f64) -> Result<Report, StepError> {
        let mut result = self.advance(dt, Guess::Old);
        // What one rank reports as `NotFinite` the others do as `Elsewhere`: all must agree.
        let lost = match &result {
            Ok(whole) => whole.is_none(),
            Err(e) => matches!(
                e,
                StepError::NotFinite { .. } | StepError::Elsewhere { .. } | StepError::Solve { .. }
            ),
        };
        let mut beyond = self.work.beyond;
        if lost && self.may_start_from_rest() {
            let first = self.work.residuals;
            let near = matches!(result, Ok(None)) && is_sound(&first);
            self.rollback();
            result = self.advance(dt, Guess::Rest);
            beyond = self.work.beyond.or(beyond);
            let worse = match &result {
                Ok(report) => report.is_some_and(|r| !r.converged && r.residuals.u >= first.u),
                Err(_) => true,
            };
            if near && worse {
                self.rollback();
                result = self.advance(dt, Guess::OldAfterAll);
            }
        }
        let time = self.state.time;
        match result {
            Ok(Some(report)) => Ok(report),
            Ok(None) => Err(StepError::Elsewhere { time }),
            Err(e) => Err(explained(e, time, beyond, self.work.residuals)),
        }
    }
}

/// Numbers that ran away are what one sees; stress beyond what grains carry is why, if the last
/// sound state of either try had it, and else an iteration whose residuals had grown.
fn explained(e: StepError, time: f64, beyond: Option<Beyond>, residuals: Residuals) -> StepError {
    match (&e, beyond) {
        (StepError::Interrupted { .. } | StepError::Condition { .. } | StepError::Dims(_), _) => e,
        (_, Some(beyond)) => StepError::Beyond { time, beyond, seen: Box::new(e) },
        (StepError::NoFlow { .. }, None) => e,
        (_, None) if is_sound(&residuals) => e,
        (_, None) => StepError::Diverged { time, residuals, seen: Box::new(e) },
    }
}
