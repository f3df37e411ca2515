//! The door of this room: what a linear solver is and returns.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;

/// When to stop: at a normalised residual below `abs` or below `rel` times the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Bound of the normalised residual.
    pub abs: f64,
    /// Bound of its reduction; zero to ask for `abs` alone.
    pub rel: f64,
    /// Iterations after which to give up.
    pub max_iter: usize,
}

impl Default for Tolerance {
    fn default() -> Self {
        Tolerance { abs: 1e-10, rel: 0.0, max_iter: 1000 }
    }
}

/// Statistics of a solve. Residuals are `|b - A x|` over `|A x - A m| + |b - A m|` with `m` the
/// mean of the first guess, sums of magnitudes over all rows and components; zero when nothing but
/// rounding noise is left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solved {
    /// Iterations done.
    pub iterations: usize,
    /// Residual before.
    pub first: f64,
    /// Residual after.
    pub last: f64,
}

/// Why a system was not solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The matrix (or its preconditioner) is not positive definite.
    #[error("the matrix is not symmetric positive definite (seen in iteration {iteration})")]
    NotPositiveDefinite {
        /// Where it showed.
        iteration: usize,
    },
    /// Infinity or NaN in the matrix, the right-hand side, the guess or an iterate.
    #[error("a number that is not finite turned up in iteration {iteration}")]
    NotFinite {
        /// Where it showed; 0 means in the system itself.
        iteration: usize,
    },
    /// Too many iterations; the best solution found is left in place.
    #[error("no convergence in {} iterations: residual {:.3e}, at first {:.3e}",
        .0.iterations, .0.last, .0.first)]
    NotConverged(Solved),
    /// The curvature along the next direction, or the residual itself, is nothing but rounding:
    /// all is gained that can be, and the best solution found is left in place.
    #[error("nothing but rounding is left after {} iterations: residual {:.3e}, at first {:.3e}",
        .0.iterations, .0.last, .0.first)]
    Spent(Solved),
    /// A row has no diagonal to divide by.
    #[error("row {row} has a zero diagonal")]
    ZeroDiagonal {
        /// The row, on the rank that found it.
        row: usize,
    },
}

/// An iterative solver of `A x = b`. Object-safe; owns its work arrays, so that repeated solves
/// of one size allocate nothing. All calls are collective over the ranks.
pub trait LinearSolver<T: Value>: Send {
    /// The name of the method.
    fn name(&self) -> &'static str;
    /// Solves from the guess `x` ([`Csr::cols`] long, ghosts fresh on return). The first call sets
    /// up; later ones trust that the values are those of the last [`LinearSolver::refresh`].
    ///
    /// # Errors
    /// [`SolveError`]; `x` then holds the best approximation, or the guess if there is none.
    ///
    /// # Panics
    /// When `x` is shorter than [`Csr::cols`] or `b` than [`Csr::rows`].
    fn solve(
        &mut self,
        exec: &Exec,
        a: &Csr,
        b: &[T],
        x: &mut [T],
        tol: &Tolerance,
    ) -> Result<Solved, SolveError>;
    /// To be called when the values of the matrix have changed.
    ///
    /// # Errors
    /// [`SolveError::ZeroDiagonal`], [`SolveError::NotFinite`].
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError>;
}
