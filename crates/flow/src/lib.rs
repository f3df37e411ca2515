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

/// A solver that ran out of iterations has still made progress: the residuals of the step judge.
fn settle(result: Result<Solved, SolveError>) -> Result<Solved, SolveError> {
    match result {
        Err(SolveError::NotConverged(solved)) => Ok(solved),
        other => other,
    }
}
