//! One time step of an incompressible flow of one fluid: momentum, pressure, viscosity.

mod anderson;
mod momentum;
mod predictor;
mod pressure;
mod state;
mod step;
mod viscosity;
pub mod vof;
mod work;

pub use anderson::Anderson;
pub use state::{
    Fluid, Gravity, Numerics, Report, ResidualControl, Residuals, Solve, State, StepError,
    TimeScheme,
};
pub use step::{Derived, Flow};

use granflow_linsolve::{SolveError, Solved};

/// As [`settle`] for a correction `x` whose matrix is positive by construction: where conjugate
/// gradients find that it is not, the right-hand side of a singular system is nothing but
/// rounding, and there is nothing to correct.
fn settle_correction(
    result: Result<Solved, SolveError>,
    x: &mut [f64],
) -> Result<Solved, SolveError> {
    match settle(result) {
        Err(SolveError::NotPositiveDefinite { iteration }) => {
            x.fill(0.0);
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
