//! One time step of an incompressible flow of one fluid: momentum, pressure, viscosity.

mod anderson;
mod coupled;
mod failure;
mod interpolation;
mod interrupt;
mod krylov;
mod momentum;
mod newton;
mod predictor;
mod pressure;
mod state;
mod step;
mod viscosity;
pub mod vof;
mod work;

pub use anderson::Anderson;
pub use state::{
    Fluid, Gravity, Numerics, Report, ResidualControl, Residuals, Solve, SolveCount, State,
    StepError, TimeScheme,
};
pub use step::{Derived, Flow};

use granflow_linsolve::{SolveError, Solved};

/// As [`settle`] for a correction `x`: where only rounding is left to correct, there is nothing to
/// correct.
fn settle_correction(
    result: Result<Solved, SolveError>,
    x: &mut [f64],
    count: &mut SolveCount,
) -> Result<Solved, SolveError> {
    match result {
        Err(SolveError::Spent(solved)) => {
            x.fill(0.0);
            Ok(Solved { iterations: solved.iterations, first: 0.0, last: 0.0 })
        }
        other => settle(other, count),
    }
}

/// A solver that ran out of iterations has still made progress: the residuals of the step judge,
/// and `count` remembers.
fn settle(
    result: Result<Solved, SolveError>,
    count: &mut SolveCount,
) -> Result<Solved, SolveError> {
    count.all += 1;
    match result {
        Err(SolveError::NotConverged(solved)) => {
            count.unconverged += 1;
            Ok(solved)
        }
        Err(SolveError::Spent(solved)) => Ok(solved),
        other => other,
    }
}
