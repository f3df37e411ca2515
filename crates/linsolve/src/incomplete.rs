//! Incomplete factorisations that keep the off-diagonals and adapt the diagonal only: DIC for
//! symmetric, DILU for general matrices (D-ILU of Pommerell 1992; Barrett et al., Templates for
//! the Solution of Linear Systems, 1994, section 3.4).
//!
//! `M = (D + L) D^-1 (D + U)` with `d_i = a_ii - sum_{j<i} a_ij a_ji / d_j`. Rows are factored in
//! fixed blocks, couplings between blocks dropped: the result does not depend on the number of
//! threads, and a problem of one block is factored as a whole.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::precond::{Precond, Shape, check_diagonal, folded_diagonal};
use crate::solver::SolveError;

/// Rows per block.
const ROWS: usize = 16384;
const NONE: u32 = u32::MAX;

/// DIC and DILU: the same thing for a symmetric matrix.
#[derive(Debug, Default)]
pub(crate) struct Incomplete {
    shape: Shape,
    lower: Half,
    upper: Half,
    inv: Vec<f64>,
}

/// Couplings to earlier or to later rows of the block.
#[derive(Debug, Default)]
struct Half {
    ptr: Vec<u32>,
    /// Column, counted from the beginning of the block.
    col: Vec<u32>,
    /// Entry of the matrix and of its transpose (lower half only, `NONE` if there is none).
    src: Vec<(u32, u32)>,
    val: Vec<f64>,
}

impl Half {
    fn build(a: &Csr, keep: impl Fn(usize, usize) -> bool, transpose: bool) -> Half {
        let mut h = Half { ptr: vec![0], ..Half::default() };
        for i in 0..a.rows() {
            let start = i / ROWS * ROWS;
            for k in a.ptr[i]..a.ptr[i + 1] {
                let Some(j) = a.folded(a.col[k as usize]) else {
                    continue;
                };
                if j < start || j >= start + ROWS || !keep(j, i) {
                    continue;
                }
                let mirrored = || {
                    (a.ptr[j]..a.ptr[j + 1])
                        .find(|&m| a.folded(a.col[m as usize]) == Some(i))
                        .unwrap_or(NONE)
                };
                h.col.push((j - start) as u32);
                h.src.push((k, if transpose { mirrored() } else { NONE }));
            }
            h.ptr.push(h.col.len() as u32);
        }
        h.val.resize(h.col.len(), 0.0);
        h
    }
    fn refresh(&mut self, exec: &Exec, a: &Csr) {
        let src = &self.src;
        exec.for_each(&mut self.val, |first, val| {
            let each = val.iter_mut().zip(&src[first..]);
            each.for_each(|(v, s)| *v = a.val[s.0 as usize]);
        });
    }
    #[inline]
    fn times<T: Value>(&self, i: usize, x: &[T]) -> T {
        let r = self.ptr[i] as usize..self.ptr[i + 1] as usize;
        let each = self.val[r.clone()].iter().zip(&self.col[r]);
        each.fold(T::ZERO, |s, (&v, &c)| s.axpy(v, x[c as usize]))
    }
}

impl<T: Value> Precond<T> for Incomplete {
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        check_diagonal(exec, a)?;
        if self.shape != Shape::of(a) {
            self.lower = Half::build(a, |j, i| j < i, true);
            self.upper = Half::build(a, |j, i| j > i, false);
            self.inv = vec![0.0; a.rows()];
            self.shape = Shape::of(a);
        }
        self.lower.refresh(exec, a);
        self.upper.refresh(exec, a);
        let lower = &self.lower;
        exec.for_each_block(&mut self.inv, ROWS, |first, inv| {
            for i in 0..inv.len() {
                let d = folded_diagonal(a, first + i);
                let mut p = d;
                for k in lower.ptr[first + i] as usize..lower.ptr[first + i + 1] as usize {
                    let (own, mirrored) = lower.src[k];
                    if mirrored != NONE {
                        let product = a.val[own as usize] * a.val[mirrored as usize];
                        p -= product * inv[lower.col[k] as usize];
                    }
                }
                // A pivot lost to rounding (a singular system) or to indefiniteness.
                inv[i] = if p * d > 1e-8 * d * d { 1.0 / p } else { 1.0 / d };
            }
        });
        Ok(())
    }

    fn apply(&mut self, exec: &Exec, a: &Csr, r: &[T], z: &mut [T], _: f64) {
        let (lower, upper, inv) = (&self.lower, &self.upper, &self.inv);
        exec.for_each_block(&mut z[..a.rows()], ROWS, |first, z| {
            for i in 0..z.len() {
                let s = lower.times(first + i, z);
                z[i] = r[first + i].minus(s).scaled(inv[first + i]);
            }
            for i in (0..z.len()).rev() {
                let s = upper.times(first + i, z);
                z[i] = z[i].axpy(-inv[first + i], s);
            }
        });
    }
}
