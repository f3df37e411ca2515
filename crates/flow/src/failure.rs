//! Why a step failed, in terms of the physics where that is known.

use crate::{Flow, Report, Residuals, StepError};
use granflow_physics::rheology::Beyond;

/// Greatest residual of momentum and of continuity at which stress over pressure tells of the
/// material, and not of an iteration that lost its way.
const SOUND: f64 = 1e-2;

/// Whether a state is near enough to a flow to be judged.
pub(crate) fn is_sound(residuals: &Residuals) -> bool {
    residuals.u <= SOUND && residuals.p <= SOUND
}

impl Flow {
    /// Advances by `dt` seconds.
    ///
    /// # Errors
    /// [`StepError`]; [`Flow::rollback`] then restores the state before the step (which has been
    /// done when it is [`StepError::Interrupted`]).
    pub fn step(&mut self, dt: f64) -> Result<Report, StepError> {
        let result = self.advance(dt);
        let (time, w) = (self.state.time, &self.work);
        result.map_err(|e| explained(e, time, w.beyond, w.residuals))
    }
}

/// Numbers that ran away are what one sees; stress beyond what grains carry is why, if the last
/// sound state had it, and else an iteration whose residuals had grown.
fn explained(e: StepError, time: f64, beyond: Option<Beyond>, residuals: Residuals) -> StepError {
    match (&e, beyond) {
        (StepError::Interrupted { .. } | StepError::Dims(_), _) => e,
        (_, Some(beyond)) => StepError::Beyond { time, beyond, seen: Box::new(e) },
        (_, None) if is_sound(&residuals) => e,
        (_, None) => StepError::Diverged { time, residuals, seen: Box::new(e) },
    }
}
