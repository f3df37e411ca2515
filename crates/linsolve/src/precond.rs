//! What a preconditioner is, and the two trivial ones.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::solver::SolveError;

/// An approximate inverse `z = M r`, acting within a rank.
pub(crate) trait Precond<T: Value>: Send {
    /// Takes up new values (and, the first time or for a new pattern, the pattern).
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError>;
    /// `z = M r` on own rows. `size` is the mean magnitude of a component of `r`.
    fn apply(&mut self, exec: &Exec, a: &Csr, r: &[T], z: &mut [T], size: f64);
    /// Whether `M` may change from one application to the next, or be unsymmetric.
    fn flexible(&self) -> bool {
        false
    }
    /// Tells how many iterations reduced the residual by how many powers of ten.
    fn took(&mut self, _iterations: usize, _decades: f64) {}
    /// Tells that the solver broke down over it.
    fn failed(&mut self) {}
    /// Whether the matrix it is made for is symmetric.
    fn set_symmetric(&mut self, _symmetric: bool) {}
}

/// Notices a new pattern.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shape(usize, usize, usize);

impl Shape {
    pub(crate) fn of(a: &Csr) -> Shape {
        Shape(a.rows() + 1, a.col.len(), a.image.len())
    }
}

/// Fails on every rank when a row of any has a diagonal that is zero or not finite.
pub(crate) fn check_diagonal(exec: &Exec, a: &Csr) -> Result<(), SolveError> {
    let entry = |i: usize| a.val[a.diag[i] as usize];
    let bad = exec.max(a.rows(), |r| {
        let mut worst = -1.0f64;
        for i in r {
            let d = entry(i);
            if !d.is_finite() {
                return f64::INFINITY;
            }
            if d == 0.0 {
                worst = worst.max(i as f64);
            }
        }
        worst
    });
    match bad {
        f64::INFINITY => Err(SolveError::NotFinite { iteration: 0 }),
        row if row >= 0.0 => Err(SolveError::ZeroDiagonal { row: row as usize }),
        _ => Ok(()),
    }
}

/// No preconditioning.
#[derive(Debug, Default)]
pub(crate) struct Identity;

impl<T: Value> Precond<T> for Identity {
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        check_diagonal(exec, a)
    }
    fn apply(&mut self, exec: &Exec, a: &Csr, r: &[T], z: &mut [T], _: f64) {
        exec.for_each(&mut z[..a.rows()], |first, z| {
            z.copy_from_slice(&r[first..first + z.len()]);
        });
    }
}

/// Division by the diagonal (Jacobi).
#[derive(Debug, Default)]
pub(crate) struct Diagonal {
    inv: Vec<f64>,
}

impl<T: Value> Precond<T> for Diagonal {
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        check_diagonal(exec, a)?;
        self.inv.resize(a.rows(), 0.0);
        exec.for_each(&mut self.inv, |first, inv| {
            let each = inv.iter_mut().enumerate();
            each.for_each(|(i, d)| *d = 1.0 / folded_diagonal(a, first + i));
        });
        Ok(())
    }
    fn apply(&mut self, exec: &Exec, a: &Csr, r: &[T], z: &mut [T], _: f64) {
        exec.for_each(&mut z[..a.rows()], |first, z| {
            let each = z.iter_mut().enumerate();
            each.for_each(|(i, z)| *z = r[first + i].scaled(self.inv[first + i]));
        });
    }
}

/// The diagonal with the couplings of a row to its own image added, unless that cancels it.
pub(crate) fn folded_diagonal(a: &Csr, i: usize) -> f64 {
    let d = a.val[a.diag[i] as usize];
    if a.image.is_empty() {
        return d;
    }
    let (col, val) = a.row(i);
    let ghosts = col.iter().zip(val).filter(|(c, _)| **c as usize >= a.rows());
    let own: f64 = ghosts.filter(|(c, _)| a.folded(**c) == Some(i)).map(|(_, v)| v).sum();
    if (d + own) * d > 1e-12 * d * d { d + own } else { d }
}
