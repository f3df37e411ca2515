//! A step that fails is taken again, shorter, where the case leaves its length to the program
//! (`adjustTimeStep yes`): inertia holds the more of a flow the shorter a step is.

use super::{Run, object};
use crate::CaseConfig;
use crate::worker::{Answer, Order};
use granflow_flow::{Report, StepError, TimeScheme};
use serde_json::json;

/// How much shorter, and how often.
const SHORTER: f64 = 0.25;
const TRIES: usize = 4;

/// A step that failed and was taken again.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortened {
    /// Its length, s.
    pub dt: f64,
    /// Why it failed.
    pub why: String,
}

impl Run {
    /// A step of `dt` seconds, or of less where that failed; with what was shortened. The length of the steps
    /// to come grows from that again.
    pub(super) fn step(&mut self, mut dt: f64) -> Result<(Report, f64, Vec<Shortened>), StepError> {
        let CaseConfig { control, schemes, .. } = &self.case.config;
        // A steady state has no inertia.
        let adjusts = control.adjust.is_some() && schemes.ddt != TimeScheme::Steady;
        let mut failed = Vec::new();
        loop {
            let e = match self.crew.worker.order(Order::Step(dt)) {
                Ok(Answer::Stepped(report)) => return Ok((*report, dt, failed)),
                Ok(_) => return Ok((Report::default(), dt, failed)),
                Err(e) => e,
            };
            if !adjusts || failed.len() == TRIES || !inertia_may_help(&e) {
                return Err(e);
            }
            self.crew.worker.order(Order::Rollback)?;
            let why = e.to_string();
            let event =
                json!({"time": self.time(), "message": &why, "dt": dt, "again": SHORTER * dt});
            // A log that cannot be written says so at the end of the step.
            let _ = self.log.event("warning", &object(event));
            failed.push(Shortened { dt, why });
            dt *= SHORTER;
            self.dt = dt;
        }
    }
}

/// Whether it was the computation that failed, and not somebody who stopped it or an entry that is wrong.
fn inertia_may_help(e: &StepError) -> bool {
    !matches!(e, StepError::Interrupted { .. } | StepError::Condition { .. } | StepError::Dims(_))
}
