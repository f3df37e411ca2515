//! Why a step failed, in terms of the physics where that is known.

use crate::{Flow, Report, StepError};

impl Flow {
    /// Advances by `dt` seconds.
    ///
    /// # Errors
    /// [`StepError`]; [`Flow::rollback`] then restores the state before the step (which has been
    /// done when it is [`StepError::Interrupted`]).
    pub fn step(&mut self, dt: f64) -> Result<Report, StepError> {
        self.advance(dt).map_err(|e| self.explained(e))
    }

    /// Numbers that ran away are what one sees; stress beyond what grains carry is why.
    fn explained(&self, e: StepError) -> StepError {
        match (&e, self.work.beyond) {
            (StepError::Interrupted { .. } | StepError::Dims(_), _) | (_, None) => e,
            (_, Some(beyond)) => {
                StepError::Beyond { time: self.state.time, beyond, seen: Box::new(e) }
            }
        }
    }
}
