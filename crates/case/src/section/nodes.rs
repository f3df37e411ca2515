//! From values in cells and on boundary faces to values at the points of the mesh.

use super::twins::twins;
use granflow_base::{Vec3, add, norm, sub};
use granflow_mesh::{Geometry, PolyMesh};
use std::collections::BTreeMap;

/// A mesh with what figures need of it.
pub(crate) struct Grid {
    pub(crate) poly: PolyMesh,
    pub(crate) geometry: Geometry,
    /// Faces of every cell: starts and `face << 1 | 1 for the neighbour`.
    pub(crate) cell_faces: (Vec<u32>, Vec<u32>),
    /// Samples around every point: starts and samples.
    around: (Vec<u32>, Vec<u32>),
    /// Points of cyclic pairs: their images and how far those are moved to lie here.
    twins: BTreeMap<u32, Vec<(u32, Vec3)>>,
    /// Greatest extent, m.
    pub(crate) size: f64,
}

/// A field where it is known: in all cells, then on all boundary faces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    pub(crate) values: Vec<f64>,
    /// Whether the value of a boundary face is known; always so in cells.
    pub(crate) known: Vec<bool>,
    /// Whether the field goes on across cyclic pairs; coordinates do not.
    pub(crate) periodic: bool,
}

impl Grid {
    pub(crate) fn new(poly: PolyMesh) -> Grid {
        let geometry = Geometry::new(&poly);
        let (n, inner) = (poly.n_cells(), poly.n_inner());
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for f in 0..poly.n_faces() {
            for p in poly.face(f) {
                pairs.push((*p, poly.owner[f]));
                match poly.neighbour.get(f) {
                    Some(cell) => pairs.push((*p, *cell)),
                    None => pairs.push((*p, (n + f - inner) as u32)),
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
        let twins = twins(&poly, &geometry, size);
        Grid { poly, geometry, cell_faces, around, twins, size }
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

    /// Values at the points: a linear function through the samples around each, by least
    /// squares with the inverse square of distances for weights, kept within their range. Exact
    /// for linear fields inside and, where boundary values are known, on the boundary but for
    /// edges of the mesh; across a mesh one cell thick nothing is known and nothing changes.
    pub(crate) fn at_points(&self, field: &Samples) -> Vec<f64> {
        let (start, samples) = &self.around;
        let n = self.poly.n_cells();
        let known = |s: &&u32| (**s as usize) < n || field.known[**s as usize];
        let mut near: Vec<(Vec3, f64)> = Vec::new();
        (0..self.poly.points.len())
            .map(|p| {
                let at = self.poly.points[p];
                let mut gather = |q: usize, shift: Vec3| {
                    let own = &samples[start[q] as usize..start[q + 1] as usize];
                    near.extend(own.iter().filter(known).map(|s| {
                        let s = *s as usize;
                        (sub(add(self.place(s), shift), at), field.values[s])
                    }));
                };
                gather(p, [0.0; 3]);
                if field.periodic {
                    let images = self.twins.get(&(p as u32)).into_iter().flatten();
                    images.for_each(|(q, shift)| gather(*q as usize, *shift));
                }
                let value = fit(&near);
                near.clear();
                value
            })
            .collect()
    }
}

/// The value at the origin of the plane through samples. It stays within their range: beside a
/// jump a plane goes too far.
fn fit(near: &[(Vec3, f64)]) -> f64 {
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
    if v.is_finite() { v.clamp(lo, hi) } else { 0.5 * (lo + hi) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::shapes;

    /// A field in cells and, where `known`, on boundary faces.
    fn sampled(grid: &Grid, f: impl Fn(Vec3) -> f64, known: bool) -> Samples {
        let n = grid.n_samples();
        let values = (0..n).map(|s| f(grid.place(s))).collect();
        let known = (0..n).map(|s| known || s < grid.poly.n_cells()).collect();
        Samples { values, known, periodic: true }
    }

    #[test]
    fn linear_fields_are_exact_on_any_mesh() {
        let prisms = shapes::prism_box(
            [4, 4, 4],
            [0.0; 3],
            [1.0; 3],
            shapes::all(granflow_mesh::PatchKind::Wall),
        );
        let thin = shapes::unit_box([4, 5, 1]);
        for (poly, known) in [
            (shapes::displaced(&shapes::unit_box([4, 5, 3]), 0.2, 7), true),
            (shapes::displaced(&thin, 0.2, 7), false),
            (prisms, true),
        ] {
            let grid = Grid::new(poly);
            // Across one cell nothing is known.
            let f = |p: Vec3| 1.0 + 2.0 * p[0] - 3.0 * p[1] + if known { p[2] } else { 0.0 };
            let at = grid.at_points(&sampled(&grid, f, known));
            let mut seen = 0;
            for (p, v) in grid.poly.points.iter().zip(at) {
                let ends = p.iter().take(if known { 3 } else { 2 });
                let on = ends.filter(|x| **x < 1e-9 || **x > 1.0 - 1e-9).count();
                // Edges of the mesh lie beyond all samples, as its faces do where none is known.
                if on > usize::from(known) {
                    continue;
                }
                seen += 1;
                assert!((v - f(*p)).abs() < 1e-6, "{p:?}: {v} {}", f(*p));
            }
            assert!(seen >= 24, "{seen}");
        }
    }

    #[test]
    fn cyclic_pairs_are_joined() {
        let grid = Grid::new(shapes::periodic_box([8, 3, 3], [true, false, false]));
        let wave = |p: Vec3| (std::f64::consts::TAU * p[0]).sin() + p[1];
        let at = grid.at_points(&sampled(&grid, wave, false));
        let ends: Vec<(Vec3, f64)> = grid
            .poly
            .points
            .iter()
            .zip(&at)
            .filter(|(p, _)| p[0] < 1e-9 || p[0] > 1.0 - 1e-9)
            .map(|(p, v)| (*p, *v))
            .collect();
        assert_eq!(ends.len(), 32);
        for (p, v) in &ends {
            let twin = ends.iter().find(|(q, _)| q[0] != p[0] && q[1..] == p[1..]).unwrap();
            assert_eq!(*v, twin.1, "{p:?}");
            // The wave goes through zero here; one side alone would leave sin(pi/8).
            if p[1] > 0.1 && p[1] < 0.9 {
                assert!((v - p[1]).abs() < 1e-9, "{p:?} {v}");
            }
        }
        // A coordinate starts anew at the other end.
        let x = Samples { periodic: false, ..sampled(&grid, |p| p[0], true) };
        for (p, v) in grid.poly.points.iter().zip(grid.at_points(&x)) {
            assert!((v - p[0]).abs() < 1e-9 + 0.5 / 8.0, "{p:?} {v}");
        }
    }

    #[test]
    fn a_jump_makes_no_value_beyond_it() {
        let grid = Grid::new(shapes::unit_box([6, 6, 6]));
        let at = grid.at_points(&sampled(&grid, |p| f64::from(u8::from(p[2] < 0.5)), true));
        assert!(at.iter().all(|v| (0.0..=1.0).contains(v)));
        let middle = |p: &Vec3| {
            (p[2] - 0.5).abs() < 1e-9 && p[0] > 0.01 && p[0] < 0.99 && p[1] > 0.01 && p[1] < 0.99
        };
        let there: Vec<f64> =
            grid.poly.points.iter().zip(&at).filter(|(p, _)| middle(p)).map(|x| *x.1).collect();
        assert_eq!(there.len(), 25);
        assert!(there.iter().all(|v| (v - 0.5).abs() < 1e-9), "{there:?}");
    }
}
