//! The best pass of a step, for a step whose passes do not converge.

use crate::step::FAR_FROM_BALANCE;
use crate::{Flow, Residuals, StepError};
use granflow_base::Vec3;

/// The state after the pass that left momentum and continuity nearest to balance. Allocated by the first
/// pass that needs it.
#[derive(Default)]
pub(crate) struct Best {
    /// Residuals over what was asked for; infinite as a step begins.
    score: f64,
    u: Vec<Vec3>,
    p: Vec<f64>,
    phi: Vec<f64>,
    eta: Vec<f64>,
}

/// How much better than the last pass, whose viscosity is the rheology's own, the best must be to be worth
/// returning to; where the last one is no flow, any better one will do.
const BETTER: f64 = 0.5;

impl Best {
    /// To be called as a step begins.
    pub(crate) fn forget(&mut self) {
        self.score = f64::INFINITY;
    }
}

impl Flow {
    fn score(&self, now: &Residuals) -> f64 {
        let control = &self.numerics.control;
        (now.u / control.u).max(now.p / control.p)
    }

    /// Keeps the state if no pass of this step came nearer. Its viscosity is that of the pass to come.
    pub(crate) fn keep_if_best(&mut self, now: &Residuals) {
        let score = self.score(now);
        let Flow { state, work: w, .. } = self;
        let best = &mut w.best;
        if score < best.score {
            best.score = score;
            best.u.clone_from(&state.u.cells.data);
            best.p.clone_from(&state.p.cells.data);
            best.phi.clone_from(&state.phi.data);
            best.eta.clone_from(&w.eta.data);
        }
    }

    /// Takes the state of the best pass where that is worth it; residuals and the rheology are then to be
    /// evaluated anew.
    ///
    /// # Errors
    /// [`StepError`] when the pressure between grains cannot be found.
    pub(crate) fn return_to_best(&mut self, now: &Residuals) -> Result<bool, StepError> {
        let (score, best) = (self.score(now), self.work.best.score);
        let fair = BETTER * score <= best && now.u < FAR_FROM_BALANCE;
        if best == f64::INFINITY || best >= score || fair {
            return Ok(false);
        }
        let Flow { state, work: w, .. } = self;
        state.u.cells.data.copy_from_slice(&w.best.u);
        state.p.cells.data.copy_from_slice(&w.best.p);
        state.phi.data.copy_from_slice(&w.best.phi);
        w.eta.data.copy_from_slice(&w.best.eta);
        self.update_conditions();
        // Faces have the viscosity of the pressure beside them.
        self.total_pressure()?;
        self.spread_viscosity();
        Ok(true)
    }
}
