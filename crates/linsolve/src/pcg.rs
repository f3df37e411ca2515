//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952), flexible where the
//! preconditioner asks for it (Notay 2000: each direction is made conjugate to the one before).

use granflow_base::Value;

use crate::iteration::{Method, ROUNDING, Step, System};
use crate::solver::SolveError;

/// Conjugate gradients.
#[derive(Default)]
pub(crate) struct ConjugateGradients<T> {
    z: Vec<T>,
    q: Vec<T>,
    /// Of the step before: `r . z` and `p . A p`.
    rz: f64,
    pq: f64,
}

impl<T: Value> Method<T> for ConjugateGradients<T> {
    const SYMMETRIC: bool = true;

    fn begin(&mut self, n: usize, _: &[T]) {
        self.z.resize(n, T::ZERO);
        self.q.resize(n, T::ZERO);
    }

    fn step(&mut self, it: usize, system: &mut System<'_, T>) -> Result<Step, SolveError> {
        let ConjugateGradients { z, q, .. } = self;
        system.precondition_residual(z);
        let (exec, n) = (system.exec, z.len());
        let r = &*system.r;
        let [rz, zq] = exec.sums(n, |s| {
            let mut d = [0.0; 2];
            for ((r, z), q) in r[s.clone()].iter().zip(&z[s.clone()]).zip(&q[s]) {
                d[0] += r.inner(*z);
                d[1] += z.inner(*q);
            }
            d
        });
        if !rz.is_finite() {
            return Err(SolveError::NotFinite { iteration: it });
        }
        let beta = match it {
            1 => 0.0,
            _ if system.flexible() => -zq / self.pq,
            _ => rz / self.rz,
        };
        exec.for_each(&mut system.p[..n], |first, p| {
            let each = p.iter_mut().zip(&z[first..]);
            each.for_each(|(p, z)| *p = z.axpy(beta, *p));
        });
        let pq = system.a.apply_dot(exec, system.p, q);
        if !pq.is_finite() {
            return Err(SolveError::NotFinite { iteration: it });
        }
        if pq <= 0.0 || rz <= 0.0 {
            return match self.spent(system, rz, pq) {
                true => Ok(Step::Spent),
                false => Err(SolveError::NotPositiveDefinite { iteration: it }),
            };
        }
        (self.rz, self.pq) = (rz, pq);
        Ok(Step::Reached(system.advance(rz / pq, &self.q)))
    }
}

impl<T: Value> ConjugateGradients<T> {
    /// Whether the products' signs are chance: a direction of the null space, or a residual of
    /// nothing but rounding.
    fn spent(&self, system: &System<'_, T>, rz: f64, pq: f64) -> bool {
        let System { exec, a, r, p, .. } = system;
        let [energy, sizes] = exec.sums(self.z.len(), |s| {
            let mut e = [0.0; 2];
            for i in s {
                e[0] += a.val[a.diag[i] as usize].abs() * p[i].inner(p[i]);
                e[1] += (r[i].inner(r[i]) * self.z[i].inner(self.z[i])).sqrt();
            }
            e
        });
        pq.abs() <= ROUNDING * energy || rz.abs() <= ROUNDING * sizes
    }
}
