//! Stabilised bi-conjugate gradients (van der Vorst 1992), preconditioned from the right.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape};
use crate::solver::{LinearSolver, SolveError, Solved, Tolerance};
use crate::start::{Judge, one_norm};

/// BiCGStab with some preconditioner.
pub(crate) struct BiCgStab<T: Value> {
    name: &'static str,
    precond: Box<dyn Precond<T>>,
    shape: Shape,
    r: Vec<T>,
    r0: Vec<T>,
    p: Vec<T>,
    v: Vec<T>,
    t: Vec<T>,
    y: Vec<T>,
    guess: Vec<T>,
}

impl<T: Value> BiCgStab<T> {
    pub(crate) fn new(name: &'static str, precond: Box<dyn Precond<T>>) -> Self {
        let (r, r0, p, v, t, y, guess) = Default::default();
        BiCgStab { name, precond, shape: Shape::default(), r, r0, p, v, t, y, guess }
    }
}

impl<T: Value> LinearSolver<T> for BiCgStab<T> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        self.shape = Shape::default();
        self.precond.set_symmetric(false);
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
        let BiCgStab { precond, r, r0, p, v, t, y, guess, .. } = self;
        for w in [&mut *r, &mut *r0, &mut *p, &mut *v, &mut *t, &mut *guess] {
            w.resize(n, T::ZERO);
        }
        y.resize(a.cols(), T::ZERO);
        let mut judge = Judge::begin(exec, a, b, x, r, y, tol)?;
        if judge.done_at_start() {
            return Ok(judge.solved);
        }
        let numbers = exec.sum(n, |r| r.len() as f64) * T::N as f64;
        let mut size = exec.sum(n, |s| r[s].iter().map(|r| one_norm(*r)).sum());
        guess.copy_from_slice(&x[..n]);
        let (mut rho, mut alpha, mut omega) = (0.0, 1.0, 1.0);
        // A fresh start of the recurrences, at first and after a breakdown.
        let mut fresh = true;
        for it in 1..=tol.max_iter {
            if fresh {
                r0.copy_from_slice(r);
                p.fill(T::ZERO);
                v.fill(T::ZERO);
            }
            let [new, rr] = exec.sums(n, |s| {
                let mut d = [0.0; 2];
                for (r0, r) in r0[s.clone()].iter().zip(&r[s]) {
                    d[0] += r0.inner(*r);
                    d[1] += r.inner(*r);
                }
                d
            });
            if !new.is_finite() {
                x[..n].copy_from_slice(guess);
                return Err(SolveError::NotFinite { iteration: it });
            }
            if !fresh && new.abs() < 1e-12 * rr {
                fresh = true;
                continue;
            }
            let beta = if fresh { 0.0 } else { new / rho * (alpha / omega) };
            rho = new;
            exec.for_each(p, |first, p| {
                for (i, p) in p.iter_mut().enumerate() {
                    *p = r[first + i].axpy(beta, p.axpy(-omega, v[first + i]));
                }
            });
            precond.apply(exec, a, p, y, size / numbers);
            a.apply(exec, y, v);
            let r0v = exec.dot(r0, v);
            if r0v == 0.0 {
                fresh = true;
                continue;
            }
            alpha = rho / r0v;
            let (yy, vv) = (&*y, &*v);
            [size] = exec.for_each2_sums(&mut x[..n], r, |first, x, r| {
                let mut s = 0.0;
                let dirs = yy[first..].iter().zip(&vv[first..]);
                for ((x, r), (y, v)) in x.iter_mut().zip(r.iter_mut()).zip(dirs) {
                    *x = x.axpy(alpha, *y);
                    *r = r.axpy(-alpha, *v);
                    s += one_norm(*r);
                }
                [s]
            });
            if judge.record(it, size)? {
                a.halo.update(exec, x);
                precond.took(it, judge.decades());
                return judge.finish();
            }
            precond.apply(exec, a, r, y, size / numbers);
            a.apply(exec, y, t);
            let [ts, tt] = exec.sums(n, |s| {
                let mut d = [0.0; 2];
                for (t, r) in t[s.clone()].iter().zip(&r[s]) {
                    d[0] += t.inner(*r);
                    d[1] += t.inner(*t);
                }
                d
            });
            omega = if tt > 0.0 { ts / tt } else { 0.0 };
            let (yy, tt) = (&*y, &*t);
            [size] = exec.for_each2_sums(&mut x[..n], r, |first, x, r| {
                let mut s = 0.0;
                let dirs = yy[first..].iter().zip(&tt[first..]);
                for ((x, r), (y, t)) in x.iter_mut().zip(r.iter_mut()).zip(dirs) {
                    *x = x.axpy(omega, *y);
                    *r = r.axpy(-omega, *t);
                    s += one_norm(*r);
                }
                [s]
            });
            match judge.record(it, size) {
                Ok(false) => fresh = omega == 0.0,
                Ok(true) => {
                    a.halo.update(exec, x);
                    precond.took(it, judge.decades());
                    return judge.finish();
                }
                Err(e) => {
                    x[..n].copy_from_slice(guess);
                    return Err(e);
                }
            }
        }
        if judge.solved.last > judge.solved.first {
            x[..n].copy_from_slice(guess);
            judge.solved.last = judge.solved.first;
        }
        a.halo.update(exec, x);
        precond.took(tol.max_iter, judge.decades());
        Err(SolveError::NotConverged(judge.solved))
    }
}
