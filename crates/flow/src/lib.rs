//! One time step of an incompressible flow of one fluid or two: interface, momentum, pressure,
//! viscosity.

mod anderson;
mod best;
mod coarse_cells;
mod compatible;
mod coupled;
mod failure;
mod faults;
mod frame;
mod free_fall;
mod friction;
mod interpolation;
mod interrupt;
mod krylov;
mod momentum;
mod newton;
mod predictor;
mod pressure;
pub mod sources;
mod state;
mod steady;
mod step;
mod time;
mod two_phase;
mod viscosity;
pub mod vof;
mod watch;
mod work;

pub use anderson::Anderson;
pub use sources::{MeanVelocity, Porous, SemiImplicit, Source, Zone};
pub use state::{
    Fluid, Gravity, LocalSteps, NormalDerivative, Numerics, Report, ResidualControl, Residuals,
    Solve, SolveCount, State, StepError, TimeScheme,
};
pub use step::{Derived, Flow};
pub use two_phase::{Mixing, Pores, Prescribed, Stiffest, TwoPhase, TwoPhaseParts};
pub use watch::Watch;

use granflow_base::Value;
use granflow_linsolve::{SolveError, Solved};

/// What a linear system is solved for, which decides what a bad solution is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// The new values of a field.
    Values,
    /// A correction of them: where only rounding is left to correct, there is nothing to correct.
    Correction,
    /// A direction to look for the solution in: none is as good as a bad one.
    Direction,
}

/// What a solve of `x` came to. A solver that ran out of iterations has still made progress: the
/// residuals of the step judge, and `count` remembers. Matrices of the preconditioner need not be
/// positive definite for a step to succeed; those that give values must.
fn settle<T: Value>(
    result: Result<Solved, SolveError>,
    x: &mut [T],
    purpose: Purpose,
    count: &mut SolveCount,
) -> Result<Solved, SolveError> {
    let nothing = |iterations| Solved { iterations, first: 0.0, last: 0.0 };
    count.all += 1;
    match result {
        Err(SolveError::NotConverged(solved)) => {
            count.unconverged += 1;
            Ok(solved)
        }
        Err(SolveError::Spent(solved)) if purpose == Purpose::Correction => {
            x.fill(T::ZERO);
            Ok(nothing(solved.iterations))
        }
        Err(SolveError::Spent(solved)) => Ok(solved),
        // Of numbers that were finite at first: what a preconditioner of other values made of them.
        Err(
            SolveError::NotPositiveDefinite { iteration } | SolveError::NotFinite { iteration },
        ) if iteration > 0 && purpose == Purpose::Direction => {
            count.unconverged += 1;
            x.fill(T::ZERO);
            Ok(nothing(iteration))
        }
        other => other,
    }
}
