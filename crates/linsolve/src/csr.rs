//! The sparse matrix.

use std::sync::Arc;

use granflow_base::{Tensor, Value};
use granflow_par::{Exec, Halo};

/// A square matrix by rows. Columns at or beyond [`Csr::rows`] are ghosts, whose values the halo
/// provides. The pattern is built once per mesh, the values are refilled.
#[derive(Clone, Debug)]
pub struct Csr {
    /// Entries `ptr[i]..ptr[i + 1]` belong to row `i`.
    pub ptr: Vec<u32>,
    /// Column of each entry.
    pub col: Vec<u32>,
    /// Value of each entry.
    pub val: Vec<f64>,
    /// Entry that holds the diagonal of each row.
    pub diag: Vec<u32>,
    /// Where ghosts get their values.
    pub halo: Arc<Halo>,
    /// For each ghost the row it images, `u32::MAX` when it lives on another rank
    /// ([`Halo::local_image`]).
    pub image: Arc<Vec<u32>>,
    /// Extra diagonal blocks that act on vectors only (slip walls hold back the normal component),
    /// left out by every preconditioner; scalars do not see them.
    pub blocks: Blocks,
}

/// Sparse 3 x 3 blocks on the diagonal.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// The blocks.
    pub tensors: Vec<Tensor>,
    /// Block of each row, `u32::MAX` for none; empty when there are no blocks at all.
    pub of_row: Vec<u32>,
}

impl Blocks {
    /// Takes all blocks away; keeps the memory.
    pub fn clear(&mut self) {
        self.tensors.clear();
        self.of_row.fill(u32::MAX);
    }
    /// Adds `block` to row `row` of a matrix of `rows` rows.
    pub fn add(&mut self, rows: usize, row: usize, block: &Tensor) {
        self.of_row.resize(rows, u32::MAX);
        match self.of_row[row] {
            u32::MAX => {
                self.of_row[row] = self.tensors.len() as u32;
                self.tensors.push(*block);
            }
            k => {
                let t = &mut self.tensors[k as usize];
                *t = t.plus(*block);
            }
        }
    }
    /// The block of a row times `x`, where there is one.
    #[inline]
    pub fn times<T: Value>(&self, row: usize, x: T) -> Option<T> {
        let k = *self.of_row.get(row)?;
        // Seen as a linear map, a block is what a rotation is: T -> B T.
        (T::N == 3 && k != u32::MAX).then(|| x.rotated(&self.tensors[k as usize]))
    }
}

impl Csr {
    /// A matrix without ghosts.
    pub fn scalar(ptr: Vec<u32>, col: Vec<u32>, val: Vec<f64>, diag: Vec<u32>) -> Csr {
        let (halo, image) = (Arc::new(Halo::none()), Arc::new(Vec::new()));
        Csr { ptr, col, val, diag, halo, image, blocks: Blocks::default() }
    }
    /// Number of rows of this rank.
    pub fn rows(&self) -> usize {
        self.diag.len()
    }
    /// Rows and ghosts: the length of a vector that the matrix multiplies.
    pub fn cols(&self) -> usize {
        self.diag.len() + self.image.len()
    }
    /// The entries of row `i`.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let r = self.ptr[i] as usize..self.ptr[i + 1] as usize;
        (&self.col[r.clone()], &self.val[r])
    }
    /// The own row a column stands for: itself, the image of a local ghost, or `None` for a
    /// ghost of another rank.
    #[inline]
    pub(crate) fn folded(&self, c: u32) -> Option<usize> {
        let c = c as usize;
        match c.checked_sub(self.rows()) {
            None => Some(c),
            Some(g) => Some(self.image[g]).filter(|&i| i != u32::MAX).map(|i| i as usize),
        }
    }
    /// Row `i` times `x`.
    #[inline]
    pub(crate) fn row_times<T: Value>(&self, i: usize, x: &[T]) -> T {
        let (col, val) = self.row(i);
        let s = col.iter().zip(val).fold(T::ZERO, |s, (&c, &a)| s.axpy(a, x[c as usize]));
        match self.blocks.times(i, x[i]) {
            None => s,
            Some(t) => s.plus(t),
        }
    }
    /// `y = A x`; refreshes the ghosts of `x` first, so that no caller can forget.
    ///
    /// # Panics
    /// When `x` is shorter than [`Csr::cols`] or `y` than [`Csr::rows`].
    pub fn apply<T: Value>(&self, exec: &Exec, x: &mut [T], y: &mut [T]) {
        self.halo.update(exec, x);
        let x = &*x;
        exec.for_each(&mut y[..self.rows()], |first, y| {
            y.iter_mut().enumerate().for_each(|(i, y)| *y = self.row_times(first + i, x));
        });
    }
    /// `r = b - A x`; refreshes the ghosts of `x` first.
    ///
    /// # Panics
    /// As [`Csr::apply`].
    pub fn residual<T: Value>(&self, exec: &Exec, b: &[T], x: &mut [T], r: &mut [T]) {
        self.halo.update(exec, x);
        let x = &*x;
        exec.for_each(&mut r[..self.rows()], |first, r| {
            let each = r.iter_mut().enumerate();
            each.for_each(|(i, r)| *r = b[first + i].minus(self.row_times(first + i, x)));
        });
    }
    /// `y = A x` and the scalar product of `x` and `y` in one pass.
    pub(crate) fn apply_dot<T: Value>(&self, exec: &Exec, x: &mut [T], y: &mut [T]) -> f64 {
        self.halo.update(exec, x);
        let x = &*x;
        let [s] = exec.for_each_sums(&mut y[..self.rows()], |first, y| {
            let mut s = 0.0;
            for (i, y) in y.iter_mut().enumerate() {
                *y = self.row_times(first + i, x);
                s += y.inner(x[first + i]);
            }
            [s]
        });
        s
    }
    /// Whether the matrix is symmetric over all ranks, judged by `u.Av = v.Au` of two scattered
    /// vectors; asymmetry that this misses is too small to disturb conjugate gradients.
    pub(crate) fn is_symmetric(&self, exec: &Exec, u: &mut Vec<f64>, v: &mut Vec<f64>) -> bool {
        let n = self.rows();
        let seed = exec.rank() as u64;
        for (w, salt) in [(&mut *u, 1), (&mut *v, 2)] {
            w.resize(self.cols(), 0.0);
            exec.for_each(&mut w[..n], |first, w| {
                let each = w.iter_mut().enumerate();
                each.for_each(|(i, w)| *w = scattered((first + i) as u64, 4 * seed + salt));
            });
            self.halo.update(exec, w);
        }
        let (u, v) = (&*u, &*v);
        let [uav, vau, all] = exec.sums(n, |r| {
            let mut s = [0.0; 3];
            for i in r {
                let (col, val) = self.row(i);
                let (mut au, mut av, mut m) = (0.0, 0.0, 0.0);
                for (&c, &a) in col.iter().zip(val) {
                    au += a * u[c as usize];
                    av += a * v[c as usize];
                    m += a.abs();
                }
                s[0] += u[i] * av;
                s[1] += v[i] * au;
                s[2] += m;
            }
            s
        });
        (uav - vau).abs() <= 1e-11 * all
    }
}

/// A number in -1..1 without pattern (the finaliser of splitmix64; Steele, Lea and Flood 2014).
fn scattered(i: u64, salt: u64) -> f64 {
    let mut z = i.wrapping_add(salt.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_add(1);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
