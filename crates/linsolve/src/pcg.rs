//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952), flexible where the
//! preconditioner asks for it (Notay 2000: each direction is made conjugate to the one before).

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape};
use crate::solver::{LinearSolver, SolveError, Solved, Tolerance};
use crate::start::{Judge, one_norm};

/// Conjugate gradients with some preconditioner.
pub(crate) struct Pcg<T: Value> {
    name: &'static str,
    precond: Box<dyn Precond<T>>,
    shape: Shape,
    pub(crate) r: Vec<T>,
    z: Vec<T>,
    p: Vec<T>,
    q: Vec<T>,
}

impl<T: Value> Pcg<T> {
    pub(crate) fn new(name: &'static str, precond: Box<dyn Precond<T>>) -> Self {
        let (r, z, p, q) = Default::default();
        Pcg { name, precond, shape: Shape::default(), r, z, p, q }
    }
}

impl<T: Value> LinearSolver<T> for Pcg<T> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        self.shape = Shape::default();
        self.precond.set_symmetric(true);
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
        let Pcg { precond, r, z, p, q, .. } = self;
        for v in [&mut *r, &mut *z, &mut *q] {
            v.resize(n, T::ZERO);
        }
        p.resize(a.cols(), T::ZERO);
        let mut judge = Judge::begin(exec, a, b, x, r, p, tol)?;
        if judge.done_at_start() {
            return Ok(judge.solved);
        }
        let numbers = exec.sum(n, |r| r.len() as f64) * T::N as f64;
        let mut size = exec.sum(n, |s| r[s].iter().map(|r| one_norm(*r)).sum());
        let (mut rz, mut pq) = (0.0, 1.0);
        for it in 1..=tol.max_iter {
            precond.apply(exec, a, r, z, size / numbers);
            let [new, zq] = exec.sums(n, |s| {
                let mut d = [0.0; 2];
                for ((r, z), q) in r[s.clone()].iter().zip(&z[s.clone()]).zip(&q[s]) {
                    d[0] += r.inner(*z);
                    d[1] += z.inner(*q);
                }
                d
            });
            if !new.is_finite() {
                return Err(SolveError::NotFinite { iteration: it });
            }
            let beta = match it {
                1 => 0.0,
                _ if precond.flexible() => -zq / pq,
                _ => new / rz,
            };
            rz = new;
            exec.for_each(&mut p[..n], |first, p| {
                let each = p.iter_mut().zip(&z[first..]);
                each.for_each(|(p, z)| *p = z.axpy(beta, *p));
            });
            pq = a.apply_dot(exec, p, q);
            if !pq.is_finite() {
                return Err(SolveError::NotFinite { iteration: it });
            }
            if pq <= 0.0 || rz <= 0.0 {
                a.halo.update(exec, x);
                return Err(SolveError::NotPositiveDefinite { iteration: it });
            }
            let alpha = rz / pq;
            let (pp, qq) = (&*p, &*q);
            [size] = exec.for_each2_sums(&mut x[..n], r, |first, x, r| {
                let mut s = 0.0;
                let dirs = pp[first..].iter().zip(&qq[first..]);
                for ((x, r), (p, q)) in x.iter_mut().zip(r.iter_mut()).zip(dirs) {
                    *x = x.axpy(alpha, *p);
                    *r = r.axpy(-alpha, *q);
                    s += one_norm(*r);
                }
                [s]
            });
            if judge.record(it, size)? {
                a.halo.update(exec, x);
                precond.took(it, judge.decades());
                return judge.finish();
            }
        }
        a.halo.update(exec, x);
        precond.took(tol.max_iter, judge.decades());
        Err(SolveError::NotConverged(judge.solved))
    }
}
