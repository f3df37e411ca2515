//! One time step of an incompressible flow of one fluid: momentum, pressure, viscosity.

mod anderson;
mod momentum;
mod predictor;
mod pressure;
mod state;
mod step;
mod viscosity;
mod work;

pub use anderson::Anderson;
pub use state::{
    Fluid, Gravity, Numerics, Report, ResidualControl, Residuals, Solve, State, StepError,
    TimeScheme,
};
pub use step::{Derived, Flow};

use granflow_linsolve::{SolveError, Solved};

/// As [`settle`] for a matrix that is positive by construction: where conjugate gradients find it
/// is not, they have reached the rounding of a (singular) system, and what they have is kept.
fn settle_definite(result: Result<Solved, SolveError>) -> Result<Solved, SolveError> {
    match settle(result) {
        Err(SolveError::NotPositiveDefinite { iteration }) => {
            Ok(Solved { iterations: iteration, first: 0.0, last: 0.0 })
        }
        other => other,
    }
}

/// A solver that ran out of iterations has still made progress: the residuals of the step judge.
fn settle(result: Result<Solved, SolveError>) -> Result<Solved, SolveError> {
    match result {
        Err(SolveError::NotConverged(solved)) => Ok(solved),
        other => other,
    }
}
