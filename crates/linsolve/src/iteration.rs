//! What every iterative solver does around its own steps: set-up, the first residual, the verdict
//! after each step, and how a solve ends.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape};
use crate::solver::{LinearSolver, SolveError, Solved, Tolerance};
use crate::start::{Judge, one_norm};

/// Products below this part of what their factors allow are rounding, not information.
pub(crate) const ROUNDING: f64 = 1e-12;

/// What one step of a method came to.
pub(crate) enum Step {
    /// The sum of magnitudes of the new residual.
    Reached(f64),
    /// Nothing: the recurrences have broken down and begin anew with the next step.
    Anew,
    /// Nothing: what is left of the residual is rounding, all is gained that can be.
    Spent,
}

/// A system on its way to its solution.
pub(crate) struct System<'a, T: Value> {
    pub(crate) exec: &'a Exec,
    pub(crate) a: &'a Csr,
    pub(crate) b: &'a [T],
    pub(crate) x: &'a mut [T],
    /// `b - A x` on own rows.
    pub(crate) r: &'a mut [T],
    /// A vector with ghosts, for the method to multiply; zero before the first step.
    pub(crate) p: &'a mut [T],
    precond: &'a mut dyn Precond<T>,
    judge: Judge,
    /// Mean magnitude of a component of the residual.
    size: f64,
}

impl<T: Value> System<'_, T> {
    /// `z = M r`.
    pub(crate) fn precondition_residual(&mut self, z: &mut [T]) {
        self.precond.apply(self.exec, self.a, self.r, z, self.size);
    }
    /// `p = M v`.
    pub(crate) fn direction(&mut self, v: &[T]) {
        self.precond.apply(self.exec, self.a, v, self.p, self.size);
    }
    /// `p = M r`.
    pub(crate) fn residual_direction(&mut self) {
        self.precond.apply(self.exec, self.a, self.r, self.p, self.size);
    }
    /// `x += k p` and `r -= k q` with `q = A p`; the sum of magnitudes of the new residual.
    pub(crate) fn advance(&mut self, k: f64, q: &[T]) -> f64 {
        let p = &*self.p;
        let x = &mut self.x[..self.r.len()];
        let [size] = self.exec.for_each2_sums(x, self.r, |first, x, r| {
            let mut s = 0.0;
            let along = p[first..].iter().zip(&q[first..]);
            for ((x, r), (p, q)) in x.iter_mut().zip(r.iter_mut()).zip(along) {
                *x = x.axpy(k, *p);
                *r = r.axpy(-k, *q);
                s += one_norm(*r);
            }
            [s]
        });
        size
    }
    /// Whether the preconditioner may change from one application to the next.
    pub(crate) fn flexible(&self) -> bool {
        self.precond.flexible()
    }
    /// Whether a residual of this sum of magnitudes is small enough.
    pub(crate) fn done_at(&self, size: f64) -> bool {
        self.judge.done_at(size)
    }
}

/// The steps of a method; owns its work arrays.
pub(crate) trait Method<T: Value>: Default + Send {
    /// Whether it relies on a symmetric matrix.
    const SYMMETRIC: bool;
    /// Makes room for `n` rows and forgets the solve before.
    fn begin(&mut self, n: usize, x: &[T]);
    /// Step number `it` (from 1): improves `x` and keeps `r` its residual.
    fn step(&mut self, it: usize, system: &mut System<'_, T>) -> Result<Step, SolveError>;
    /// The guess, for a method that may leave it for something worse.
    fn guess(&self) -> Option<&[T]> {
        None
    }
}

/// A method with some preconditioner.
pub(crate) struct Iteration<T: Value, M> {
    name: &'static str,
    precond: Box<dyn Precond<T>>,
    shape: Shape,
    r: Vec<T>,
    p: Vec<T>,
    method: M,
}

impl<T: Value, M: Method<T>> Iteration<T, M> {
    pub(crate) fn new(name: &'static str, precond: Box<dyn Precond<T>>) -> Self {
        let (shape, r, p, method) = Default::default();
        Iteration { name, precond, shape, r, p, method }
    }
}

impl<T: Value, M: Method<T>> LinearSolver<T> for Iteration<T, M> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        self.shape = Shape::default();
        self.precond.set_symmetric(M::SYMMETRIC);
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
        let Iteration { precond, r, p, method, .. } = self;
        r.resize(a.rows(), T::ZERO);
        p.resize(a.cols(), T::ZERO);
        let judge = Judge::begin(exec, a, b, x, r, p, tol)?;
        if judge.done_at_start() {
            return Ok(judge.solved);
        }
        p.fill(T::ZERO);
        method.begin(a.rows(), x);
        let mut system = System { exec, a, b, x, r, p, precond: &mut **precond, judge, size: 0.0 };
        let ended = iterate(method, &mut system, tol.max_iter);
        let System { judge, x, .. } = system;
        a.halo.update(exec, x);
        ended.and_then(|end| match end {
            End::Converged => judge.finish(),
            End::Exhausted => Err(SolveError::NotConverged(judge.solved)),
            End::Spent => Err(SolveError::Spent(judge.solved)),
        })
    }
}

/// How a run of steps ended.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Converged,
    Exhausted,
    Spent,
}

/// Steps until the residual is small enough, or no step can make it so.
fn iterate<T: Value, M: Method<T>>(
    method: &mut M,
    system: &mut System<'_, T>,
    most: usize,
) -> Result<End, SolveError> {
    let (exec, n) = (system.exec, system.r.len());
    let numbers = exec.sum(n, |r| r.len() as f64) * T::N as f64;
    let mut size = exec.sum(n, |s| system.r[s].iter().map(|r| one_norm(*r)).sum());
    let mut steps = || {
        for it in 1..=most {
            system.size = size / numbers;
            match method.step(it, system)? {
                Step::Reached(new) => size = new,
                Step::Anew => continue,
                Step::Spent => return Ok(End::Spent),
            }
            if system.judge.record(it, size)? {
                return Ok(End::Converged);
            }
        }
        Ok(End::Exhausted)
    };
    let end = steps();
    let Solved { iterations, first, last } = system.judge.solved;
    if let Some(guess) = method.guess().filter(|_| end.is_err() || last > first) {
        system.x[..n].copy_from_slice(guess);
        system.judge.solved.last = first;
    }
    // Rounding is not the fault of the preconditioner.
    match end {
        Ok(End::Converged | End::Exhausted) => {
            system.precond.took(iterations, system.judge.decades());
        }
        Ok(End::Spent) => {}
        Err(_) => system.precond.failed(),
    }
    end
}
