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
/// out to the nearest whole number, the last section takes what remains.
pub fn divide(n: usize, sections: &[Section]) -> Vec<f64> {
    let mut x = Vec::with_capacity(n + 1);
    x.push(0.0);
    let total: f64 = sections.iter().map(|s| s.length).sum();
    let total_cells: f64 = sections.iter().map(|s| s.cells).sum();
    let mut from = 0.0;
    for (i, s) in sections.iter().enumerate() {
        let left = n + 1 - x.len();
        let share = (s.cells / total_cells * n as f64).round() as usize;
        let m = if i + 1 == sections.len() { left } else { share.min(left) };
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
        let mirror: Vec<f64> = divide(10, &reversed(&s)).iter().rev().map(|t| 1.0 - t).collect();
        assert!(x.iter().zip(&mirror).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
