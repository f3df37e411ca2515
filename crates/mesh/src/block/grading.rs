//! Spacing of points along an edge.

/// A stretch of an edge with cells growing in geometric progression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Share of the edge's length (any scale: shares are divided by their sum).
    pub length: f64,
    /// Share of the edge's cells (any scale).
    pub cells: f64,
    /// Size of the last cell over that of the first.
    pub ratio: f64,
}

impl Section {
    /// A whole edge with one expansion ratio.
    pub fn simple(ratio: f64) -> Vec<Section> {
        vec![Section { length: 1.0, cells: 1.0, ratio }]
    }
}

/// The sections seen from the other end.
pub(super) fn reversed(sections: &[Section]) -> Vec<Section> {
    sections.iter().rev().map(|s| Section { ratio: 1.0 / s.ratio, ..*s }).collect()
}

/// Fractions `0 = x[0] < .. < x[n] = 1` of an edge at which its `n` cells meet.
///
/// Within a section of `m` cells the sizes grow by the factor `ratio^(1/(m-1))`. Cells are shared
/// out to the nearest whole numbers; the section with most cells makes up for what is missing.
pub fn divide(n: usize, sections: &[Section]) -> Vec<f64> {
    let mut x = Vec::with_capacity(n + 1);
    x.push(0.0);
    let total: f64 = sections.iter().map(|s| s.length).sum();
    let shares = shares(n, sections);
    let mut from = 0.0;
    for (i, s) in sections.iter().enumerate() {
        let left = n + 1 - x.len();
        let m = if i + 1 == sections.len() { left } else { shares[i].min(left) };
        let length = s.length / total;
        let growth = if m > 1 { s.ratio.powf(1.0 / (m as f64 - 1.0)) } else { 1.0 };
        for j in 1..=m {
            let t = if (growth - 1.0).abs() < 1e-12 {
                j as f64 / m as f64
            } else {
                (1.0 - growth.powi(j as i32)) / (1.0 - growth.powi(m as i32))
            };
            x.push(from + length * t);
        }
        from += length;
    }
    if let Some(last) = x.last_mut().filter(|_| n > 0) {
        *last = 1.0;
    }
    x
}

/// Cells of every section.
fn shares(n: usize, sections: &[Section]) -> Vec<usize> {
    let total: f64 = sections.iter().map(|s| s.cells).sum();
    let mut shares: Vec<usize> =
        sections.iter().map(|s| (s.cells / total * n as f64).round() as usize).collect();
    let sum: usize = shares.iter().sum();
    // The first of several largest, hence the reversal: `max_by_key` finds the last.
    if let Some(largest) = shares.iter_mut().rev().max_by_key(|m| **m) {
        *largest = (*largest + n).saturating_sub(sum);
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(x: &[f64]) -> Vec<f64> {
        x.windows(2).map(|w| w[1] - w[0]).collect()
    }

    #[test]
    fn the_last_cell_is_ratio_times_the_first() {
        for ratio in [1.0, 5.0, 0.2, 40.0, 1.0 + 1e-13, 1.001] {
            let h = sizes(&divide(17, &Section::simple(ratio)));
            assert!((h[16] / h[0] / ratio - 1.0).abs() < 1e-9, "{ratio}");
            let growth = h[1] / h[0];
            assert!(h.windows(2).all(|w| (w[1] / w[0] / growth - 1.0).abs() < 1e-9));
            assert!((h.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
        assert_eq!(divide(1, &Section::simple(7.0)), [0.0, 1.0]);
    }

    #[test]
    fn sections_share_length_and_cells() {
        // The shares need not add up to one.
        let s = [
            Section { length: 20.0, cells: 3.0, ratio: 4.0 },
            Section { length: 60.0, cells: 4.0, ratio: 1.0 },
            Section { length: 20.0, cells: 3.0, ratio: 0.25 },
        ];
        let x = divide(10, &s);
        assert!((x[3] - 0.2).abs() < 1e-15 && (x[7] - 0.8).abs() < 1e-15);
        let h = sizes(&x);
        assert!((h[2] / h[0] - 4.0).abs() < 1e-12 && (h[9] / h[7] - 0.25).abs() < 1e-12);
        assert!((h[4] / h[3] - 1.0).abs() < 1e-12);
        // 30.55 + 3.9 + 30.55 of 65 cells round to 66: the first of the largest gives one back.
        let [a, b, c] = [0.47, 0.06, 0.47].map(|cells| Section { length: 1.0, cells, ratio: 1.0 });
        assert_eq!(shares(65, &[a, b, c]), [30, 4, 31]);
        assert_eq!(divide(2, &[a, b, c]).len(), 3);
        let mirror: Vec<f64> = divide(10, &reversed(&s)).iter().rev().map(|t| 1.0 - t).collect();
        assert!(x.iter().zip(&mirror).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
