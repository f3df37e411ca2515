//! Stationary iteration `x += M (b - A x)`: enough for a diagonally dominant momentum matrix.
//!
//! With `M` a symmetric Gauss-Seidel sweep from zero this is symmetric Gauss-Seidel; ghosts of
//! other ranks lag by one sweep.

use granflow_base::Value;

use crate::iteration::{Method, Step, System};
use crate::solver::SolveError;
use crate::start::one_norm;

/// Sweeps of the preconditioner.
#[derive(Default)]
pub(crate) struct Sweeps;

impl<T: Value> Method<T> for Sweeps {
    const SYMMETRIC: bool = true;

    fn begin(&mut self, _: usize, _: &[T]) {}

    fn step(&mut self, _: usize, system: &mut System<'_, T>) -> Result<Step, SolveError> {
        system.residual_direction();
        let System { exec, a, b, x, r, p, .. } = system;
        let p = &**p;
        exec.for_each(&mut x[..r.len()], |first, x| {
            x.iter_mut().zip(&p[first..]).for_each(|(x, p)| *x = x.plus(*p));
        });
        a.halo.update(exec, x);
        let x = &**x;
        let [size] = exec.for_each_sums(r, |first, r| {
            let mut s = 0.0;
            for (i, r) in r.iter_mut().enumerate() {
                *r = b[first + i].minus(a.row_times(first + i, x));
                s += one_norm(*r);
            }
            [s]
        });
        Ok(Step::Reached(size))
    }
}
