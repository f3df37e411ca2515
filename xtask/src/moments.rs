//! Two programs' answers at one time, cell by cell: how far fractions, surfaces and pressures are apart.

use crate::foam_field as field;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What the comparison needs of the mesh.
pub(crate) struct Cells {
    pub(crate) volume: Vec<f64>,
    centre: [Vec<f64>; 3],
    /// Cells behind faces of walls.
    at_walls: Vec<usize>,
}

/// The fields of one time.
pub(crate) struct Moment {
    pub(crate) alpha: Vec<f64>,
    p: Vec<f64>,
    p_rgh: Vec<f64>,
}

impl Moment {
    pub(crate) fn read(case: &Path, time: f64, n: usize) -> Result<Moment, String> {
        let near = |name: &str| name.parse::<f64>().is_ok_and(|t| (t - time).abs() < 1e-7);
        let mut dirs = fs::read_dir(case).map_err(|e| e.to_string())?.flatten();
        let dir = dirs.find(|d| near(&d.file_name().to_string_lossy()));
        let dir = dir.ok_or(format!("{} has no time {time}", case.display()))?.path();
        let one = |name: &str| field::scalars(&dir.join(name), n);
        Ok(Moment { alpha: one("alpha.water")?, p: one("p")?, p_rgh: one("p_rgh")? })
    }
}

impl Cells {
    pub(crate) fn read(case: &Path) -> Result<Cells, String> {
        let n = field::scalars(&case.join("0/Cx"), 0)?.len();
        let volume = field::scalars(&case.join("0/V"), n)?;
        let centre = |c: &str| field::scalars(&case.join("0").join(c), n);
        let centre = [centre("Cx")?, centre("Cy")?, centre("Cz")?];
        let at_walls = field::cells_at_walls(&case.join("constant/polyMesh"))?;
        Ok(Cells { volume, centre, at_walls })
    }

    /// Volume by which two fractions differ, m3.
    fn apart(&self, a: &[f64], b: &[f64]) -> f64 {
        self.volume.iter().zip(a.iter().zip(b)).map(|(v, (a, b))| v * (a - b).abs()).sum()
    }

    /// How far the surfaces of `a` and `b` are apart, over how far that of `b` is from `first`: water in
    /// columns of cells one above the other.
    pub(crate) fn surfaces(&self, a: &[f64], b: &[f64], first: &[f64]) -> f64 {
        let mut columns: BTreeMap<[i64; 2], [f64; 2]> = BTreeMap::new();
        for (c, v) in self.volume.iter().enumerate() {
            let at = [0, 1].map(|k| (self.centre[k][c] * 1e6).round() as i64);
            let column = columns.entry(at).or_default();
            column[0] += v * (a[c] - b[c]);
            column[1] += v * (b[c] - first[c]);
        }
        let sum = |k: usize| columns.values().map(|c| c[k].abs()).sum::<f64>();
        sum(0) / sum(1)
    }

    /// One line of the table: `a` ours, `b` theirs, `others` ours once more with other forms.
    pub(crate) fn row(
        &self,
        a: &Moment,
        b: &Moment,
        others: &[Option<Moment>],
        axis: usize,
    ) -> String {
        let sum = |f: &dyn Fn(usize) -> f64| -> f64 {
            (0..self.volume.len()).map(|c| self.volume[c] * f(c)).sum()
        };
        let (x, whole) = (&self.centre[axis], sum(&|c| b.alpha[c]));
        let l1 = |a: &Moment| format!("{:.3} %", 100.0 * self.apart(&a.alpha, &b.alpha) / whole);
        let others = others.iter().map(|m| m.as_ref().map_or("-".to_owned(), l1));
        let l1 = [l1(a)].into_iter().chain(others).collect::<Vec<_>>().join(" | ");
        let volume = sum(&|c| a.alpha[c]) / whole - 1.0;
        let extent =
            x.iter().fold(f64::MIN, |m, x| m.max(*x)) - x.iter().fold(f64::MAX, |m, x| m.min(*x));
        let front = |m: &Moment| {
            let wet = (0..x.len()).filter(|&c| m.alpha[c] > 0.5).map(|c| x[c]);
            wet.fold(f64::MIN, f64::max)
        };
        let centroid = |m: &Moment| sum(&|c| m.alpha[c] * x[c]) / sum(&|c| m.alpha[c]);
        // Mean difference beside the range of theirs.
        let apart = |a: &[f64], b: &[f64], cells: &mut dyn Iterator<Item = usize>| {
            let (mut off, mut most, mut least, mut n) = (0.0, f64::MIN, f64::MAX, 0.0f64);
            for c in cells {
                off += (a[c] - b[c]).abs();
                (most, least, n) = (b[c].max(most), b[c].min(least), n + 1.0);
            }
            match n {
                0.0 => "-".to_owned(),
                n => format!("{:.3} of {:.0} Pa", off / n, most - least),
            }
        };
        let p = apart(&a.p, &b.p, &mut self.at_walls.iter().copied());
        let p_rgh = apart(&a.p_rgh, &b.p_rgh, &mut (0..x.len()));
        format!(
            "{l1} | {volume:+.1e} | {:.4}, {:.4} | {:+.3} % | {p} | {p_rgh}",
            front(a),
            front(b),
            100.0 * (centroid(a) - centroid(b)) / extent,
        )
    }
}
