//! Sparse matrices, Krylov solvers, incomplete factorisations and algebraic multigrid.
