//! The quality of an aggregate, see [`super::aggregate`].

use super::graph::{Graph, NONE, clear, fill};

/// Tells whether a small set of rows makes a good aggregate.
#[derive(Debug, Default)]
pub(crate) struct Quality {
    rows: Vec<u32>,
    /// Place of each row of the level in the set.
    place: Vec<u32>,
    /// `worst A_G - D (1 - mean)`, by rows, its lower half.
    z: Vec<f64>,
}

impl Quality {
    /// For a level of `n` rows.
    pub(crate) fn begin(&mut self, n: usize) {
        fill(&mut self.place, n, NONE);
        clear(&mut self.rows, 64);
        clear(&mut self.z, 64 * 64);
    }
    /// Begins a new set.
    pub(crate) fn clear(&mut self) {
        self.rows.clear();
    }
    /// Adds a row to it.
    pub(crate) fn add(&mut self, row: u32) {
        self.rows.push(row);
    }
    /// Rows added.
    pub(crate) fn size(&self) -> usize {
        self.rows.len()
    }

    /// Whether the quality of the set is `worst` or better: whether `worst A_G - D (1 - mean)` is
    /// positive semidefinite.
    pub(crate) fn within(&mut self, g: &Graph, worst: f32) -> bool {
        let Quality { rows, place, z } = self;
        let (n, worst) = (rows.len(), f64::from(worst));
        z.clear();
        z.resize(n * n + n, 0.0);
        let (z, d) = z.split_at_mut(n * n);
        rows.iter().enumerate().for_each(|(k, &i)| place[i as usize] = k as u32);
        for (k, &i) in rows.iter().enumerate() {
            z[k * n + k] += worst * f64::from(g.sum[i as usize].max(0.0));
            d[k] = f64::from(g.diagonal(i as usize));
            for (j, v) in g.row(i as usize) {
                let j = place[j] as usize;
                if j < n {
                    // Half of each of the two entries: the symmetric part.
                    let v = 0.5 * worst * f64::from(v);
                    z[k.max(j) * n + k.min(j)] += v;
                    z[k * n + k] -= v;
                    z[j * n + j] -= v;
                }
            }
        }
        rows.iter().for_each(|&i| place[i as usize] = NONE);
        let all: f64 = d.iter().sum();
        for k in 0..n {
            for j in 0..=k {
                z[k * n + j] += d[k] * d[j] / all;
            }
            z[k * n + k] -= d[k];
        }
        // Cholesky; constants are a null vector when nothing but couplings holds the rows.
        for k in 0..n {
            let (above, row) = z.split_at_mut(k * n);
            for j in 0..k {
                let other = &above[j * n..j * n + j];
                let s: f64 = other.iter().zip(&row[..j]).map(|(a, b)| a * b).sum();
                row[j] = (row[j] - s) / above[j * n + j];
            }
            let p = row[k] - row[..k].iter().map(|r| r * r).sum::<f64>();
            let rounding = 1e-6 * d[k];
            if k + 1 == n {
                return p > -rounding;
            }
            if p.is_nan() || p <= rounding {
                return false;
            }
            row[k] = p.sqrt();
        }
        true
    }
}
