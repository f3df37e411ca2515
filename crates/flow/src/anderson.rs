//! Anderson acceleration of a fixed-point iteration y <- G(y) (D. G. Anderson, J. ACM 12 (1965)
//! 547; as a nonlinear GMRES: H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715).

use granflow_par::Exec;

/// Pairs of iterate and residual, and the least-squares problem over their differences.
pub struct Anderson {
    depth: usize,
    /// Differences of successive iterates and of successive residuals, newest last.
    dy: Vec<Vec<f64>>,
    df: Vec<Vec<f64>>,
    y_last: Vec<f64>,
    f_last: Vec<f64>,
    stored: usize,
    started: bool,
    best: f64,
}

/// A residual that grows by this factor means that the history leads astray: it is dropped.
const ASTRAY: f64 = 2.0;
/// Longest step of one entry. The unknowns are logarithms: a factor of 20 at most.
const LONGEST: f64 = 3.0;
/// Columns whose part orthogonal to the others (squared) falls below this share are left out.
const DEPENDENT: f64 = 1e-13;

impl Anderson {
    /// For `n` unknowns with a memory of `depth` iterations.
    pub fn new(n: usize, depth: usize) -> Self {
        let zero = || vec![0.0; n];
        Anderson {
            depth,
            dy: (0..depth).map(|_| zero()).collect(),
            df: (0..depth).map(|_| zero()).collect(),
            y_last: zero(),
            f_last: zero(),
            stored: 0,
            started: false,
            best: f64::INFINITY,
        }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.stored = 0;
        self.started = false;
        self.best = f64::INFINITY;
    }

    /// Replaces `y` by the next iterate; `g` holds `G(y)`.
    pub fn mix(&mut self, exec: &Exec, y: &mut [f64], g: &[f64]) {
        let n = y.len();
        let size = exec.sum(n, |r| r.map(|i| (g[i] - y[i]).powi(2)).sum()).sqrt();
        if self.started && size > ASTRAY * self.best {
            self.reset();
        }
        self.best = self.best.min(size);
        if self.started {
            if self.stored == self.depth {
                self.dy.rotate_left(1);
                self.df.rotate_left(1);
                self.stored -= 1;
            }
            let k = self.stored;
            let (y_last, f_last) = (&self.y_last, &self.f_last);
            let y_now = &*y;
            exec.for_each2(&mut self.dy[k], &mut self.df[k], |first, dy, df| {
                for i in 0..dy.len() {
                    let c = first + i;
                    dy[i] = y_now[c] - y_last[c];
                    df[i] = (g[c] - y_now[c]) - f_last[c];
                }
            });
            self.stored += 1;
        }
        self.started = true;
        let y_now = &*y;
        exec.for_each2(&mut self.y_last, &mut self.f_last, |first, yl, fl| {
            for i in 0..yl.len() {
                (yl[i], fl[i]) = (y_now[first + i], g[first + i] - y_now[first + i]);
            }
        });
        let weights = self.least_squares(exec, n);
        let (dy, df, f, stored) = (&self.dy, &self.df, &self.f_last, self.stored);
        let step = |i: usize| {
            let mut s = f[i];
            for (k, w) in weights.iter().enumerate().take(stored) {
                s -= w * (dy[k][i] + df[k][i]);
            }
            s
        };
        // What is too long is shortened as a whole.
        let longest = exec.max(n, |r| r.map(|i| step(i).abs()).fold(0.0, f64::max));
        let damp = (LONGEST / longest).min(1.0);
        exec.for_each(y, |first, y| {
            y.iter_mut().enumerate().for_each(|(i, y)| *y += damp * step(first + i));
        });
    }

    /// Weights that bring `f - sum w_k df_k` nearest to zero: normal equations, factored with the
    /// newest columns first so that what is dropped as dependent is old.
    fn least_squares(&self, exec: &Exec, n: usize) -> [f64; MOST] {
        let m = self.stored.min(MOST);
        let mut gram = [[0.0; MOST]; MOST];
        let mut rhs = [0.0; MOST];
        for i in 0..m {
            for (j, other) in self.df.iter().enumerate().take(i + 1) {
                let product = exec.dot(&self.df[i][..n], &other[..n]);
                (gram[i][j], gram[j][i]) = (product, product);
            }
            rhs[i] = exec.dot(&self.df[i][..n], &self.f_last[..n]);
        }
        solve_gram(&gram, &rhs, m)
    }
}

/// Most columns the small system holds.
const MOST: usize = 16;

/// Cholesky from the last column to the first; dependent columns get weight zero.
fn solve_gram(gram: &[[f64; MOST]; MOST], rhs: &[f64; MOST], m: usize) -> [f64; MOST] {
    let mut w = [0.0; MOST];
    let mut l = [[0.0; MOST]; MOST];
    let mut z = [0.0; MOST];
    let mut kept = [0usize; MOST];
    let mut n_kept = 0;
    for column in (0..m).rev() {
        let mut row = [0.0; MOST];
        let mut pivot = gram[column][column];
        for (j, &k) in kept[..n_kept].iter().enumerate() {
            let s: f64 = (0..j).map(|i| row[i] * l[j][i]).sum();
            row[j] = (gram[column][k] - s) / l[j][j];
            pivot -= row[j] * row[j];
        }
        if !(pivot > DEPENDENT * gram[column][column] && pivot > 0.0) {
            continue;
        }
        row[n_kept] = pivot.sqrt();
        let s: f64 = (0..n_kept).map(|i| row[i] * z[i]).sum();
        z[n_kept] = (rhs[column] - s) / row[n_kept];
        l[n_kept] = row;
        kept[n_kept] = column;
        n_kept += 1;
    }
    for i in (0..n_kept).rev() {
        let s: f64 = (i + 1..n_kept).map(|j| l[j][i] * w[kept[j]]).sum();
        w[kept[i]] = (z[i] - s) / l[i][i];
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear map with eigenvalues from -33 (as the friction loop has) to 0.95.
    #[test]
    fn finds_the_fixed_point_where_plain_iteration_diverges() {
        let exec = Exec::serial();
        let eig = [-33.0, 0.95, 0.5, -0.3, 0.8, 0.1];
        let fixed = [1.0, -2.0, 0.5, 3.0, 0.2, -1.0];
        let mut anderson = Anderson::new(6, 8);
        let mut y = vec![0.0; 6];
        let map = |y: &[f64]| -> Vec<f64> {
            (0..6).map(|i| fixed[i] + eig[i] * (y[i] - fixed[i])).collect()
        };
        for _ in 0..40 {
            let g = map(&y);
            anderson.mix(&exec, &mut y, &g);
        }
        assert!(y.iter().zip(&fixed).all(|(a, b)| (a - b).abs() < 1e-8), "{y:?}");
    }
}
