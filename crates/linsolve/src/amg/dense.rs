//! The coarsest level: a dense inverse.

use super::graph::{Graph, fill};

/// A pivot below this part of its diagonal belongs to a null vector: that unknown is pinned.
const NULL: f64 = 1e-12;

/// Dense inverse of a small matrix, by rows.
#[derive(Debug, Default)]
pub(crate) struct Dense {
    n: usize,
    lu: Vec<f64>,
    inv: Vec<f32>,
    column: Vec<f64>,
}

impl Dense {
    /// Makes room for a matrix of `n` rows.
    pub(crate) fn resize(&mut self, n: usize) {
        self.n = n;
        fill(&mut self.lu, n * n, 0.0);
        fill(&mut self.inv, n * n, 0.0);
        fill(&mut self.column, n, 0.0);
    }

    /// Inverts the matrix of `g`. Elimination without exchange of rows, as M-matrices allow; for
    /// a singular one a generalised inverse that leaves one unknown of each null vector at zero.
    pub(crate) fn refresh(&mut self, g: &Graph) {
        let n = self.n;
        let lu = &mut self.lu;
        lu.fill(0.0);
        for i in 0..n {
            lu[i * n + i] = f64::from(g.sum[i]);
            for (j, v) in g.row(i) {
                lu[i * n + j] += f64::from(v);
                lu[i * n + i] -= f64::from(v);
            }
        }
        for k in 0..n {
            let full = f64::from(g.diagonal(k)).abs();
            let p = lu[k * n + k];
            // The diagonal of the factors holds reciprocals; zero pins.
            lu[k * n + k] = if p.abs() > NULL * full && p.is_finite() { 1.0 / p } else { 0.0 };
            let (top, rest) = lu.split_at_mut((k + 1) * n);
            let pivot = &top[k * n..];
            for row in rest.chunks_exact_mut(n) {
                let m = row[k] * pivot[k];
                row[k] = m;
                if m != 0.0 {
                    row[k + 1..].iter_mut().zip(&pivot[k + 1..]).for_each(|(r, p)| *r -= m * p);
                }
            }
        }
        for j in 0..n {
            let x = &mut self.column;
            x.fill(0.0);
            x[j] = 1.0;
            for i in j + 1..n {
                let s: f64 =
                    lu[i * n + j..i * n + i].iter().zip(&x[j..i]).map(|(a, b)| a * b).sum();
                x[i] -= s;
            }
            for i in (0..n).rev() {
                let row = &lu[i * n..(i + 1) * n];
                let s: f64 = row[i + 1..].iter().zip(&x[i + 1..]).map(|(a, b)| a * b).sum();
                x[i] = (x[i] - s) * row[i];
            }
            for (i, x) in x.iter().enumerate() {
                self.inv[i * n + j] = if x.is_finite() { *x as f32 } else { 0.0 };
            }
        }
    }

    /// `x = A^-1 b`.
    pub(crate) fn apply<const N: usize>(&self, b: &[[f32; N]], x: &mut [[f32; N]]) {
        for (x, row) in x.iter_mut().zip(self.inv.chunks_exact(self.n.max(1))) {
            let mut s = [[0.0f32; N]; 8];
            for (a, b) in row.chunks(8).zip(b.chunks(8)) {
                for (s, (a, b)) in s.iter_mut().zip(a.iter().zip(b)) {
                    (0..N).for_each(|c| s[c] += a * b[c]);
                }
            }
            *x = std::array::from_fn(|c| s.iter().map(|s| s[c]).sum());
        }
    }
}
