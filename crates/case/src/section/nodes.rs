//! From values in cells and on boundary faces to values at the points of the mesh.

use granflow_base::{Vec3, norm, sub};
use granflow_mesh::{Geometry, PatchKind, PolyMesh};

/// A mesh with what figures need of it.
pub(crate) struct Grid {
    pub(crate) poly: PolyMesh,
    pub(crate) geometry: Geometry,
    /// Faces of every cell: starts and `face << 1 | 1 for the neighbour`.
    pub(crate) cell_faces: (Vec<u32>, Vec<u32>),
    /// Samples around every point: starts and samples.
    around: (Vec<u32>, Vec<u32>),
    /// Whether a point lies on the boundary.
    rim: Vec<bool>,
    /// Greatest extent, m.
    pub(crate) size: f64,
}

/// A field where it is known: in all cells, then on all boundary faces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    pub(crate) values: Vec<f64>,
    /// Whether the value of a boundary face is known; always so in cells.
    pub(crate) known: Vec<bool>,
}

impl Grid {
    pub(crate) fn new(poly: PolyMesh) -> Grid {
        let geometry = Geometry::new(&poly);
        let (n, inner) = (poly.n_cells(), poly.n_inner());
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        let mut rim = vec![false; poly.points.len()];
        for f in 0..poly.n_faces() {
            for p in poly.face(f) {
                pairs.push((*p, poly.owner[f]));
                match poly.neighbour.get(f) {
                    Some(cell) => pairs.push((*p, *cell)),
                    None => {
                        rim[*p as usize] = true;
                        pairs.push((*p, (n + f - inner) as u32));
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut start = vec![0u32; poly.points.len() + 1];
        pairs.iter().for_each(|(p, _)| start[*p as usize + 1] += 1);
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let around = (start, pairs.into_iter().map(|(_, s)| s).collect());
        let span = |k: usize| {
            let all = || poly.points.iter().map(|p| p[k]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let size = span(0).max(span(1)).max(span(2));
        let cell_faces = poly.cell_faces();
        Grid { poly, geometry, cell_faces, around, rim, size }
    }

    /// Where sample `s` is.
    pub(crate) fn place(&self, s: usize) -> Vec3 {
        let n = self.poly.n_cells();
        if s < n {
            self.geometry.cell_centre[s]
        } else {
            self.geometry.face_centre[s - n + self.poly.n_inner()]
        }
    }

    /// Number of samples.
    pub(crate) fn n_samples(&self) -> usize {
        self.poly.n_cells() + self.poly.n_faces() - self.poly.n_inner()
    }

    /// The kind of patch a boundary face belongs to, for all of them.
    pub(crate) fn kinds(&self) -> Vec<&PatchKind> {
        self.poly.patches.iter().flat_map(|p| std::iter::repeat_n(&p.kind, p.len)).collect()
    }

    /// Values at the points: a linear function through the samples around each, by least
    /// squares with the inverse square of distances for weights. Exact for linear fields, also in
    /// a mesh one cell thick, across which nothing is known.
    pub(crate) fn at_points(&self, field: &Samples) -> Vec<f64> {
        let (start, samples) = &self.around;
        let n = self.poly.n_cells();
        let known = |s: &&u32| (**s as usize) < n || field.known[**s as usize];
        (0..self.poly.points.len())
            .map(|p| {
                let own = &samples[start[p] as usize..start[p + 1] as usize];
                let at = self.poly.points[p];
                let near: Vec<(Vec3, f64)> = own
                    .iter()
                    .filter(known)
                    .map(|s| (sub(self.place(*s as usize), at), field.values[*s as usize]))
                    .collect();
                fit(&near, self.rim[p])
            })
            .collect()
    }
}

/// The value at the origin of the plane through samples. It stays within their range, on the
/// `rim` of the mesh within twice their range: beside a jump a plane goes too far.
fn fit(near: &[(Vec3, f64)], rim: bool) -> f64 {
    let far = near.iter().map(|s| norm(s.0)).fold(0.0, f64::max);
    let (lo, hi) =
        near.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, s| (e.0.min(s.1), e.1.max(s.1)));
    if near.is_empty() || far == 0.0 || lo == hi {
        return if near.is_empty() { f64::NAN } else { lo };
    }
    // Normal equations; what the samples leave open is taken as level.
    const LEVEL: f64 = 1e-9;
    let mut a = [[0.0; 5]; 4];
    for (d, v) in near {
        let row = [1.0, d[0] / far, d[1] / far, d[2] / far, v - lo];
        let w = 1.0 / (norm(*d) / far).max(1e-3).powi(2);
        for i in 0..4 {
            for j in 0..5 {
                a[i][j] += w * row[i] * row[j];
            }
        }
    }
    let trace = a[0][0];
    (1..4).for_each(|i| a[i][i] += LEVEL * trace);
    // The value comes last in the elimination, and so out first.
    for i in (1..4).rev() {
        for r in 0..i {
            let k = a[r][i] / a[i][i];
            for c in 0..5 {
                a[r][c] -= k * a[i][c];
            }
        }
    }
    let v = if a[0][0] > 0.0 { lo + a[0][4] / a[0][0] } else { 0.5 * (lo + hi) };
    let room = if rim { 0.5 * (hi - lo) } else { 0.0 };
    if v.is_finite() { v.clamp(lo - room, hi + room) } else { 0.5 * (lo + hi) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::shapes;

    #[test]
    fn linear_fields_are_exact_on_any_mesh() {
        for n in [[4, 5, 3], [4, 5, 1]] {
            let grid = Grid::new(shapes::displaced(&shapes::unit_box(n), 0.2, 7));
            // Across one cell nothing is known.
            let f = |p: Vec3| 1.0 + 2.0 * p[0] - 3.0 * p[1] + if n[2] > 1 { p[2] } else { 0.0 };
            let values = (0..grid.n_samples()).map(|s| f(grid.place(s))).collect();
            let known = (0..grid.n_samples()).map(|s| s < grid.poly.n_cells()).collect();
            let at = grid.at_points(&Samples { values, known });
            for (p, v) in grid.poly.points.iter().zip(at).filter(|(p, _)| {
                // At the rim the range holds them; see `fit`.
                p[0] > 0.0 && p[0] < 1.0 && p[1] > 0.0 && p[1] < 1.0
            }) {
                assert!((v - f(*p)).abs() < 1e-6, "{p:?}: {v} {}", f(*p));
            }
        }
    }

    #[test]
    fn a_jump_makes_no_value_beyond_it() {
        let grid = Grid::new(shapes::unit_box([6, 6, 6]));
        let cell = |s: usize| f64::from(u8::from(grid.place(s)[2] < 0.5));
        let n = grid.n_samples();
        let at =
            grid.at_points(&Samples { values: (0..n).map(cell).collect(), known: vec![true; n] });
        assert!(at.iter().all(|v| (-0.5..=1.5).contains(v)));
        let middle = |p: &Vec3| {
            (p[2] - 0.5).abs() < 1e-9 && p[0] > 0.01 && p[0] < 0.99 && p[1] > 0.01 && p[1] < 0.99
        };
        let there: Vec<f64> =
            grid.poly.points.iter().zip(&at).filter(|(p, _)| middle(p)).map(|x| *x.1).collect();
        assert_eq!(there.len(), 25);
        assert!(there.iter().all(|v| (v - 0.5).abs() < 1e-9), "{there:?}");
    }
}
