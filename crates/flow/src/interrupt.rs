//! Giving a step up when somebody outside asks for it.

use crate::{Flow, StepError};
use std::sync::atomic::Ordering;

impl Flow {
    /// Takes the step back when [`Flow::stop`] is set on any rank: a step of a hard case may take
    /// minutes, and a machine that is switched off does not wait for it.
    pub(crate) fn give_up_if_asked(&mut self) -> Result<(), StepError> {
        let Some(stop) = &self.stop else { return Ok(()) };
        // Ranks see the flag at different moments: they agree first.
        let mut asked = [f64::from(u8::from(stop.load(Ordering::Relaxed)))];
        self.exec.comm().max(&mut asked);
        if asked[0] == 0.0 {
            return Ok(());
        }
        self.rollback();
        self.update_conditions();
        Err(StepError::Interrupted { time: self.state.time })
    }
}
