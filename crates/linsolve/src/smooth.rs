//! Stationary iteration `x += M (b - A x)`: enough for a diagonally dominant momentum matrix.
//!
//! With `M` a symmetric Gauss-Seidel sweep from zero this is symmetric Gauss-Seidel; ghosts of
//! other ranks lag by one sweep.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape};
use crate::solver::{LinearSolver, SolveError, Solved, Tolerance};
use crate::start::{Judge, one_norm};

/// Sweeps of some preconditioner.
pub(crate) struct Smooth<T: Value> {
    name: &'static str,
    precond: Box<dyn Precond<T>>,
    shape: Shape,
    r: Vec<T>,
    z: Vec<T>,
}

impl<T: Value> Smooth<T> {
    pub(crate) fn new(name: &'static str, precond: Box<dyn Precond<T>>) -> Self {
        Smooth { name, precond, shape: Shape::default(), r: Vec::new(), z: Vec::new() }
    }
}

impl<T: Value> LinearSolver<T> for Smooth<T> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        self.shape = Shape::default();
        self.precond.refresh(exec, a)?;
        self.shape = Shape::of(a);
        Ok(())
    }

    fn solve(
        &mut self,
        exec: &Exec,
        a: &Csr,
        b: &[T],
        x: &mut [T],
        tol: &Tolerance,
    ) -> Result<Solved, SolveError> {
        if self.shape != Shape::of(a) {
            self.refresh(exec, a)?;
        }
        let n = a.rows();
        let Smooth { precond, r, z, .. } = self;
        r.resize(n, T::ZERO);
        z.resize(a.cols(), T::ZERO);
        let mut judge = Judge::begin(exec, a, b, x, r, z, tol)?;
        if judge.done_at_start() {
            return Ok(judge.solved);
        }
        let numbers = exec.sum(n, |r| r.len() as f64) * T::N as f64;
        let mut size = exec.sum(n, |s| r[s].iter().map(|r| one_norm(*r)).sum());
        for it in 1..=tol.max_iter {
            precond.apply(exec, a, r, z, size / numbers);
            let zz = &*z;
            exec.for_each(&mut x[..n], |first, x| {
                x.iter_mut().zip(&zz[first..]).for_each(|(x, z)| *x = x.plus(*z));
            });
            a.halo.update(exec, x);
            let xx = &*x;
            [size] = exec.for_each_sums(r, |first, r| {
                let mut s = 0.0;
                for (i, r) in r.iter_mut().enumerate() {
                    *r = b[first + i].minus(a.row_times(first + i, xx));
                    s += one_norm(*r);
                }
                [s]
            });
            if judge.record(it, size)? {
                precond.took(it, judge.decades());
                return judge.finish();
            }
        }
        Err(SolveError::NotConverged(judge.solved))
    }
}
