//! Algebraic multigrid by aggregation, as a preconditioner.
//!
//! Aggregates stay while the values of the matrix change (only the sums are formed anew), until
//! the iterations show that they no longer fit.

mod aggregate;
mod cycle;
mod dense;
mod graph;
mod hierarchy;
mod layout;
mod level;
mod quality;
mod sell;

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape, check_diagonal};
use crate::solver::SolveError;
use hierarchy::{Hierarchy, Params};

/// Aggregates are made anew when the iterations per decade have grown by this factor.
const STALE: f64 = 2.0;

/// A hierarchy for `N` components; any [`Value`] of as many can use it.
struct Amg<const N: usize> {
    hierarchy: Hierarchy<N>,
    params: Params,
    shape: Shape,
    symmetric: bool,
    /// 1 / the largest diagonal: single precision works on numbers around one.
    scale: f64,
    /// Iterations per decade, at best since the aggregates were made.
    usual: Option<f64>,
    stale: bool,
}

/// A multigrid preconditioner, or with one level a symmetric Gauss-Seidel sweep.
fn boxed<T: Value>(params: Params) -> Box<dyn Precond<T>> {
    match T::N {
        1 => Box::new(Amg::<1>::new(params)),
        3 => Box::new(Amg::<3>::new(params)),
        _ => Box::new(Amg::<9>::new(params)),
    }
}
/// Multigrid.
pub(crate) fn multigrid<T: Value>() -> Box<dyn Precond<T>> {
    boxed(Params { levels: 30, passes: 3 })
}
/// One symmetric Gauss-Seidel sweep from zero.
pub(crate) fn gauss_seidel<T: Value>() -> Box<dyn Precond<T>> {
    boxed(Params { levels: 1, passes: 0 })
}

impl<const N: usize> Amg<N> {
    fn new(params: Params) -> Self {
        Amg {
            hierarchy: Hierarchy::default(),
            params,
            shape: Shape::default(),
            symmetric: true,
            scale: 1.0,
            usual: None,
            stale: false,
        }
    }
}

impl<T: Value, const N: usize> Precond<T> for Amg<N> {
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        check_diagonal(exec, a)?;
        let largest =
            exec.max(a.rows(), |r| r.map(|i| a.val[a.diag[i] as usize].abs()).fold(0.0, f64::max));
        self.scale = 1.0 / largest;
        if self.shape == Shape::of(a) && !self.stale {
            self.hierarchy.refresh(exec, a, self.scale);
        } else {
            self.hierarchy.build(exec, a, self.scale, self.params);
            self.shape = Shape::of(a);
            self.usual = None;
            self.stale = false;
        }
        Ok(())
    }

    fn apply(&mut self, exec: &Exec, a: &Csr, r: &[T], z: &mut [T], size: f64) {
        let k = 1.0 / size;
        let narrow = |r: &T| std::array::from_fn(|c| (r.comp(c) * k) as f32);
        let (b, row) = self.hierarchy.input();
        exec.for_each(b, |first, b| {
            for (b, &i) in b.iter_mut().zip(&row[first..]) {
                *b = if i == graph::NONE { [0.0; N] } else { narrow(&r[i as usize]) };
            }
        });
        self.hierarchy.cycle(exec, self.symmetric);
        let k = size * self.scale;
        let (x, slot) = self.hierarchy.output();
        exec.for_each(&mut z[..a.rows()], |first, z| {
            for (i, z) in z.iter_mut().enumerate() {
                let x = &x[slot[first + i] as usize];
                (0..N).for_each(|c| z.set_comp(c, f64::from(x[c]) * k));
            }
        });
    }

    fn flexible(&self) -> bool {
        true
    }
    fn took(&mut self, iterations: usize, decades: f64) {
        if self.params.levels == 1 || iterations < 8 || decades < 1.0 {
            return;
        }
        let rate = iterations as f64 / decades;
        let usual = *self.usual.get_or_insert(rate);
        self.usual = Some(usual.min(rate));
        self.stale = rate > STALE * usual;
    }
    fn failed(&mut self) {
        self.stale = true;
    }
    fn set_symmetric(&mut self, symmetric: bool) {
        self.symmetric = symmetric;
    }
}
