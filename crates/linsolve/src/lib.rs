//! Sparse matrices, Krylov solvers, incomplete factorisations and algebraic multigrid, on plain
//! slices: rows and ghosts, not cells and faces.
//!
//! A solver owns its work arrays and returns statistics; it never prints. Results have the same
//! bits for any number of threads. Preconditioners act within a rank: local ghosts (periodic and
//! wedge images) are folded onto the cell they image, couplings to other ranks are left to the
//! Krylov iteration around them.

mod amg;
mod bicgstab;
mod csr;
mod incomplete;
mod iteration;
mod pcg;
mod precond;
mod registry;
mod smooth;
mod solver;
mod start;

pub use csr::{Blocks, Csr};
pub use registry::{ALL, Entry, Kind, SolverSpec, Unknown, build, gamg};
pub use solver::{LinearSolver, SolveError, Solved, Tolerance};
