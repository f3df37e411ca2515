//! The small least-squares problem of the generalised minimal residual method (Y. Saad, M. H.
//! Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856): a Hessenberg matrix that rotations make
//! triangular as it grows.

/// Most directions before a restart.
pub(crate) const DIRECTIONS: usize = 80;

/// The Hessenberg matrix, its rotations and the right-hand side they turn.
pub(crate) struct Hessenberg {
    h: [[f64; DIRECTIONS]; DIRECTIONS + 1],
    cosine: [f64; DIRECTIONS],
    sine: [f64; DIRECTIONS],
    rhs: [f64; DIRECTIONS + 1],
    used: usize,
}

impl Hessenberg {
    /// For a first residual of norm `size`.
    pub(crate) fn new(size: f64) -> Self {
        let mut rhs = [0.0; DIRECTIONS + 1];
        rhs[0] = size;
        Hessenberg {
            h: [[0.0; DIRECTIONS]; DIRECTIONS + 1],
            cosine: [0.0; DIRECTIONS],
            sine: [0.0; DIRECTIONS],
            rhs,
            used: 0,
        }
    }

    /// Adds a column: the products of the new vector with the basis, and the length of what is
    /// left. False when the column adds nothing (it is then left out).
    pub(crate) fn push(&mut self, products: &[f64], length: f64) -> bool {
        let j = products.len() - 1;
        for (i, k) in products.iter().enumerate() {
            self.h[i][j] = *k;
        }
        for i in 0..j {
            let (c, s, a, b) = (self.cosine[i], self.sine[i], self.h[i][j], self.h[i + 1][j]);
            (self.h[i][j], self.h[i + 1][j]) = (c * a + s * b, c * b - s * a);
        }
        let d = self.h[j][j].hypot(length);
        if !(d > 0.0 && d.is_finite()) {
            return false;
        }
        (self.cosine[j], self.sine[j]) = (self.h[j][j] / d, length / d);
        self.h[j][j] = d;
        self.rhs[j + 1] = -self.sine[j] * self.rhs[j];
        self.rhs[j] *= self.cosine[j];
        self.used = j + 1;
        true
    }

    /// Norm of the residual with the columns so far.
    pub(crate) fn residual(&self) -> f64 {
        self.rhs[self.used].abs()
    }

    /// Columns so far.
    pub(crate) fn len(&self) -> usize {
        self.used
    }

    /// Weights of the directions that make the residual least.
    pub(crate) fn weights(&self) -> [f64; DIRECTIONS] {
        let mut y = [0.0; DIRECTIONS];
        for i in (0..self.used).rev() {
            let s: f64 = (i + 1..self.used).map(|k| self.h[i][k] * y[k]).sum();
            y[i] = (self.rhs[i] - s) / self.h[i][i];
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arnoldi by hand on a 3 x 3 matrix: three directions solve it.
    #[test]
    fn three_directions_solve_three_equations() {
        let a = [[4.0, 1.0, 0.0], [-2.0, 3.0, 1.0], [0.5, 0.0, -1.0]];
        let b = [1.0, 2.0, -3.0_f64];
        let dot = |x: &[f64; 3], y: &[f64; 3]| (0..3).map(|i| x[i] * y[i]).sum::<f64>();
        let size = dot(&b, &b).sqrt();
        let mut small = Hessenberg::new(size);
        let mut basis = vec![b.map(|x| x / size)];
        for j in 0..3 {
            let v = basis[j];
            let mut w = [0, 1, 2].map(|i| dot(&a[i], &v));
            let products: Vec<f64> = basis
                .iter()
                .map(|q| {
                    let k = dot(q, &w);
                    (0..3).for_each(|i| w[i] -= k * q[i]);
                    k
                })
                .collect();
            let length = dot(&w, &w).sqrt();
            assert!(small.push(&products, length));
            basis.push(w.map(|x| x / length));
        }
        let y = small.weights();
        let x = [0, 1, 2].map(|i| (0..3).map(|k| y[k] * basis[k][i]).sum::<f64>());
        for i in 0..3 {
            assert!((dot(&a[i], &x) - b[i]).abs() < 1e-12, "{x:?}");
        }
        assert!(small.residual() < 1e-12 * size);
    }
}
