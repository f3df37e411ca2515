//! From values in cells and on boundary faces to values at the points of the mesh.

use super::twins::twins;
use granflow_base::{Tensor, Vec3, add, apply, dot, norm, scale, sub};
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
    /// Whether a value counts at the points around. Where none of a point's does, all of its
    /// cells do.
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
        let mut near: Vec<(Vec3, f64)> = Vec::new();
        (0..self.poly.points.len())
            .map(|p| {
                let at = self.poly.points[p];
                let images = self.twins.get(&(p as u32)).filter(|_| field.periodic);
                let places = || {
                    let others = images.into_iter().flatten();
                    std::iter::once((p, [0.0; 3])).chain(others.map(|(q, d)| (*q as usize, *d)))
                };
                let mut gather = |wanted: &dyn Fn(usize) -> bool| {
                    for (q, shift) in places() {
                        let own = &samples[start[q] as usize..start[q + 1] as usize];
                        let own = own.iter().map(|s| *s as usize).filter(|s| wanted(*s));
                        near.extend(
                            own.map(|s| (sub(add(self.place(s), shift), at), field.values[s])),
                        );
                    }
                    !near.is_empty()
                };
                if !gather(&|s| field.known[s]) {
                    gather(&|s| s < n);
                }
                let value = fit(&near);
                near.clear();
                value
            })
            .collect()
    }
}

/// The value at the origin of the linear function through samples. It stays within their range:
/// beside a jump a linear function goes too far.
fn fit(near: &[(Vec3, f64)]) -> f64 {
    let far = near.iter().map(|s| norm(s.0)).fold(0.0, f64::max);
    let (lo, hi) =
        near.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, s| (e.0.min(s.1), e.1.max(s.1)));
    if near.is_empty() || far == 0.0 || lo == hi {
        return if near.is_empty() { f64::NAN } else { lo };
    }
    let weighted = || near.iter().map(|(d, v)| ((norm(*d) / far).max(1e-3).powi(-2), *d, v - lo));
    let (mut sum, mut middle, mut mean) = (0.0, [0.0; 3], 0.0);
    for (w, d, v) in weighted() {
        (sum, middle, mean) = (sum + w, add(middle, scale(d, w)), mean + w * v);
    }
    let (middle, mean) = (scale(middle, 1.0 / sum), mean / sum);
    let (mut spread, mut slope): (Tensor, Vec3) = ([0.0; 9], [0.0; 3]);
    for (w, d, v) in weighted() {
        let d = sub(d, middle);
        for i in 0..3 {
            slope[i] += w * d[i] * (v - mean);
            (0..3).for_each(|j| spread[3 * i + j] += w * d[i] * d[j]);
        }
    }
    let v = lo + mean - dot(smallest(&spread, slope), middle);
    if v.is_finite() { v.clamp(lo, hi) } else { lo + mean }
}

/// The smallest solution of `m x = b` for a symmetric semi-definite `m`, by conjugate gradients
/// from zero: what `m` leaves open (across one layer of cells) stays zero.
fn smallest(m: &Tensor, b: Vec3) -> Vec3 {
    let (mut x, mut rest, mut along) = ([0.0; 3], b, b);
    let mut square = dot(b, b);
    let enough = 1e-26 * square;
    // Three would do without rounding.
    for _ in 0..12 {
        let change = apply(m, along);
        let curvature = dot(along, change);
        if square <= enough || curvature <= 0.0 {
            break;
        }
        let step = square / curvature;
        x = add(x, scale(along, step));
        rest = sub(rest, scale(change, step));
        let left = dot(rest, rest);
        along = add(rest, scale(along, left / square));
        square = left;
    }
    x
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
                assert!((v - f(*p)).abs() < 1e-12, "{p:?}: {v} {}", f(*p));
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
            assert!((v - twin.1).abs() < 1e-12, "{p:?} {v} {}", twin.1);
            // The wave goes through zero here; one side alone would leave sin(pi/8).
            if p[1] > 0.1 && p[1] < 0.9 {
                assert!((v - p[1]).abs() < 1e-12, "{p:?} {v}");
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
        assert!(there.iter().all(|v| (v - 0.5).abs() < 1e-12), "{there:?}");
    }
}
