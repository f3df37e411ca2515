//! Stabilised bi-conjugate gradients (van der Vorst 1992), preconditioned from the right.

use granflow_base::Value;
use granflow_par::Exec;

use crate::iteration::{Method, ROUNDING, Step, System};
use crate::solver::SolveError;

/// BiCGStab.
#[derive(Default)]
pub(crate) struct BiCgStab<T> {
    r0: Vec<T>,
    p: Vec<T>,
    v: Vec<T>,
    t: Vec<T>,
    guess: Vec<T>,
    rho: f64,
    alpha: f64,
    omega: f64,
    /// A start of the recurrences: at first and after a breakdown.
    fresh: bool,
}

impl<T: Value> Method<T> for BiCgStab<T> {
    const SYMMETRIC: bool = false;

    fn begin(&mut self, n: usize, x: &[T]) {
        let BiCgStab { r0, p, v, t, guess, .. } = self;
        for w in [r0, p, v, t, &mut *guess] {
            w.resize(n, T::ZERO);
        }
        guess.copy_from_slice(&x[..n]);
        self.fresh = true;
    }

    fn step(&mut self, it: usize, system: &mut System<'_, T>) -> Result<Step, SolveError> {
        let BiCgStab { r0, p, v, t, rho, alpha, omega, .. } = self;
        let (exec, a) = (system.exec, system.a);
        if self.fresh {
            r0.copy_from_slice(system.r);
            p.fill(T::ZERO);
            v.fill(T::ZERO);
        }
        let [new, rr] = products(exec, system.r, r0);
        if !new.is_finite() {
            return Err(SolveError::NotFinite { iteration: it });
        }
        if !self.fresh && new.abs() < ROUNDING * rr {
            self.fresh = true;
            return Ok(Step::Anew);
        }
        let beta = if self.fresh { 0.0 } else { new / *rho * (*alpha / *omega) };
        *rho = new;
        let r = &*system.r;
        exec.for_each(p, |first, p| {
            for (i, p) in p.iter_mut().enumerate() {
                *p = r[first + i].axpy(beta, p.axpy(-*omega, v[first + i]));
            }
        });
        system.direction(p);
        a.apply(exec, system.p, v);
        let [r0v, vv] = products(exec, v, r0);
        // As small a product as rounding gives: dividing by it would throw the solution away.
        if r0v * r0v <= (ROUNDING * vv) * (ROUNDING * exec.dot(r0, r0)) {
            let spent = std::mem::replace(&mut self.fresh, true);
            return Ok(if spent { Step::Spent } else { Step::Anew });
        }
        *alpha = *rho / r0v;
        let size = system.advance(*alpha, v);
        if system.done_at(size) || !size.is_finite() {
            return Ok(Step::Reached(size));
        }
        system.residual_direction();
        a.apply(exec, system.p, t);
        let [tr, tt] = products(exec, t, system.r);
        *omega = if tt > 0.0 { tr / tt } else { 0.0 };
        self.fresh = *omega == 0.0;
        Ok(Step::Reached(system.advance(*omega, &self.t)))
    }

    fn guess(&self) -> Option<&[T]> {
        Some(&self.guess)
    }
}

/// `a . b` and `a . a`.
fn products<T: Value>(exec: &Exec, a: &[T], b: &[T]) -> [f64; 2] {
    exec.sums(a.len(), |s| {
        let mut d = [0.0; 2];
        for (a, b) in a[s.clone()].iter().zip(&b[s]) {
            d[0] += a.inner(*b);
            d[1] += a.inner(*a);
        }
        d
    })
}
