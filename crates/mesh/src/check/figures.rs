//! What checkMesh prints of a mesh beside the angles: lengths of edges, flatness of faces, determinants
//! of cells, weights and volume ratios of faces. Each is defined here; that the numbers are the
//! reference tool's is compared in the book.

use super::Worst;
use super::report::{CheckReport, Place, Severity};
use crate::geometry::Geometry;
use crate::polymesh::{PatchKind, PolyMesh};
use granflow_base::{Tensor, Vec3, add, cross, dot, norm, scale, sub, unit};

/// Share of the mesh's diagonal below which an edge is as good as none.
const SHORT: f64 = 1e-6;
/// Determinant below which the faces of a cell hardly span space.
const FLAT: f64 = 1e-3;

/// Least and mean of what is added.
#[derive(Clone, Copy)]
struct Spread {
    least: f64,
    sum: f64,
    n: usize,
}

impl Spread {
    const NONE: Spread = Spread { least: f64::INFINITY, sum: 0.0, n: 0 };
    fn add(&mut self, x: f64) {
        *self = Spread { least: self.least.min(x), sum: self.sum + x, n: self.n + 1 };
    }
    /// 1 and 1 of nothing: what is not there is not bad.
    fn pair(self) -> [f64; 2] {
        if self.n == 0 { [1.0; 2] } else { [self.least, self.sum / self.n as f64] }
    }
}

pub(super) fn check(
    poly: &PolyMesh,
    g: &Geometry,
    (ptr, links): &(Vec<u32>, Vec<u32>),
    report: &mut CheckReport,
) {
    edges(poly, g, report);
    flatness(poly, g, report);
    let partner = partners(poly);
    determinants(poly, g, &partner, (ptr, links), report);
    between(poly, g, &partner, report);
}

/// The face behind each boundary face of a cyclic patch.
fn partners(poly: &PolyMesh) -> Vec<Option<u32>> {
    let mut out = vec![None; poly.n_faces() - poly.n_inner()];
    for p in &poly.patches {
        let PatchKind::Cyclic { neighbour, .. } = &p.kind else { continue };
        let Some(other) = poly.patches.iter().find(|o| o.name == *neighbour) else { continue };
        for (f, o) in p.faces().zip(other.faces()) {
            out[f - poly.n_inner()] = Some(o as u32);
        }
    }
    out
}

fn edges(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let [lo, hi] = report.bounds;
    let most = SHORT * norm(sub(hi, lo));
    let mut range = [f64::INFINITY, 0.0f64];
    let mut short = Worst::new();
    for f in 0..poly.n_faces() {
        let ring = poly.face(f);
        let at = |i: usize| poly.points[ring[i % ring.len()] as usize];
        let mut least = f64::INFINITY;
        for i in 0..ring.len() {
            let length = norm(sub(at(i + 1), at(i)));
            range = [range[0].min(length), range[1].max(length)];
            least = least.min(length);
        }
        if least < most {
            // Worst is greatest.
            short.add(Place::face(g, f, -least), &poly.cells_of(f));
        }
    }
    report.quality.edge = range;
    short.of_least().report(
        report,
        "shortEdge",
        Severity::Warning,
        "faces with an edge shorter than a millionth of the mesh (m)",
        "merge the points at its ends",
    );
}

/// Area of a face over that of its triangles about its middle: 1 of a plane convex face.
fn flatness(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let mut all = Spread::NONE;
    for f in (0..poly.n_faces()).filter(|f| poly.face(*f).len() > 3) {
        let ring = poly.face(f);
        let at = |i: usize| poly.points[ring[i % ring.len()] as usize];
        let sum = (0..ring.len()).map(at).fold([0.0; 3], add);
        let middle = scale(sum, 1.0 / ring.len() as f64);
        let triangle = |i: usize| 0.5 * norm(cross(sub(at(i + 1), at(i)), sub(middle, at(i))));
        let sum: f64 = (0..ring.len()).map(triangle).sum();
        if sum > 0.0 {
            all.add(norm(g.area[f]) / sum);
        }
    }
    report.quality.flatness = all.pair();
}

/// Of the area of faces to other cells: less than that along an axis is rounding.
const NOTHING: f64 = 1e-6;

/// The axes along which no cell has a neighbour: where a mesh is one cell thick.
fn single(g: &Geometry, faces: impl Iterator<Item = usize>) -> [bool; 3] {
    let mut sum = [0.0f64; 3];
    for f in faces {
        (0..3).for_each(|k| sum[k] += g.area[f][k].abs());
    }
    let most = sum.iter().fold(0.0f64, |m, s| m.max(*s));
    sum.map(|s| s <= NOTHING * most)
}

/// `det(sum S S/A^2)/8` over the faces to other cells, `A` their mean area: 1 of a cube among cubes, and 0
/// where these faces do not span space. An axis along which no cell has a neighbour counts as 1.
fn determinants(
    poly: &PolyMesh,
    g: &Geometry,
    partner: &[Option<u32>],
    (ptr, links): (&[u32], &[u32]),
    report: &mut CheckReport,
) {
    let joins = |f: usize| f < poly.n_inner() || partner[f - poly.n_inner()].is_some();
    let single = single(g, (0..poly.n_faces()).filter(|f| joins(*f)));
    let (mut all, mut poor) = (Spread::NONE, Worst::new());
    for c in 0..g.volume.len() {
        let faces = links[ptr[c] as usize..ptr[c + 1] as usize].iter().map(|e| (e >> 1) as usize);
        let areas: Vec<Vec3> = faces.filter(|f| joins(*f)).map(|f| g.area[f]).collect();
        let mean = areas.iter().map(|s| norm(*s)).sum::<f64>() / areas.len().max(1) as f64;
        let mut m: Tensor = [0.0; 9];
        for s in &areas {
            let s = scale(*s, 1.0 / mean.max(f64::MIN_POSITIVE));
            (0..9).for_each(|k| m[k] += s[k / 3] * s[k % 3]);
        }
        for axis in (0..3).filter(|k| single[*k]) {
            (0..3).for_each(|k| (m[3 * axis + k], m[3 * k + axis]) = (0.0, 0.0));
            m[4 * axis] = 1.0;
        }
        let row = |k: usize| [m[3 * k], m[3 * k + 1], m[3 * k + 2]];
        let determinant = dot(row(0), cross(row(1), row(2))).abs() / 8.0;
        all.add(determinant);
        if determinant < FLAT {
            poor.add(Place::cell(g, c, -determinant), &[c as u32]);
        }
    }
    report.quality.determinant = all.pair();
    poor.of_least().report(
        report,
        "determinant",
        Severity::Note,
        "cells whose faces to other cells hardly span space (determinant)",
        "a cell in a corner with one or two neighbours: its gradient rests on boundary values",
    );
}

/// Weights of interpolation and ratios of volumes across faces between cells.
fn between(poly: &PolyMesh, g: &Geometry, partner: &[Option<u32>], report: &mut CheckReport) {
    let depth = |f: usize, c: u32| {
        let normal = unit(g.area[f]);
        dot(normal, sub(g.face_centre[f], g.cell_centre[c as usize])).abs()
    };
    let (mut weights, mut ratios) = (Spread::NONE, Spread::NONE);
    let mut add = |(f, a): (usize, u32), (o, b): (usize, u32)| {
        let (own, other) = (depth(f, a), depth(o, b));
        weights.add(own.min(other) / (own + other).max(f64::MIN_POSITIVE));
        let [v, w] = [a, b].map(|c| g.volume[c as usize]);
        ratios.add(v.min(w) / v.max(w).max(f64::MIN_POSITIVE));
    };
    for f in 0..poly.n_inner() {
        add((f, poly.owner[f]), (f, poly.neighbour[f]));
    }
    for (i, other) in partner.iter().enumerate() {
        let (f, Some(o)) = (poly.n_inner() + i, other) else { continue };
        // Each pair once.
        if f < *o as usize {
            add((f, poly.owner[f]), (*o as usize, poly.owner[*o as usize]));
        }
    }
    report.quality.weight = weights.pair();
    report.quality.volume_ratio = ratios.pair();
}
