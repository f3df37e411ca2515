//! Points of sets that are not those of a line: lattices, circles, centres of cells, points on
//! patches.

use super::Around;
use super::patches::Patches;
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub};
use granflow_dict::{Diag, Reader, Sink, Span};
use granflow_flow::sources::axes_of;
use granflow_mesh::PolyMesh;

/// A point with its order and the cell that it has its values from, in the user's numbering.
pub(super) type InCell = (f64, Vec3, u32);

/// What is looked for in the mesh.
#[derive(Clone, Debug)]
pub(super) enum Wanted {
    /// Centres of all cells, or of those in a box.
    Centres(Option<[Vec3; 2]>),
    /// The points of patches next to given ones, no farther than this.
    Nearest { patches: Patches, points: Vec<Vec3>, most: f64 },
    /// So many faces of patches.
    Seeds { patches: Patches, most: usize },
}

/// Most points of a set.
const MOST: f64 = 1e7;

/// Points of a box with its corner in `origin` and its edges along `e1`, `e2` and their normal,
/// evenly in its inside; the first direction runs first.
pub(super) fn lattice(r: &Reader<'_>) -> Vec<Vec3> {
    let (origin, axes) = axes_of(r);
    let n = r.vector("pointsDensity", Dims::NONE);
    let span = r.vector("spanBox", Dims::LENGTH);
    if n.iter().chain(&span).any(|x| x.is_nan()) {
        return Vec::new();
    }
    if n.iter().any(|n| *n < 1.0 || n.fract() != 0.0) || n.iter().product::<f64>() > MOST {
        let message = "`pointsDensity` is three whole numbers of points";
        r.error_at_key("pointsDensity", message, "from 1 on, together up to 10 million", None);
        return Vec::new();
    }
    let [nx, ny, nz] = n.map(|n| n as usize);
    let mut out = Vec::with_capacity(nx * ny * nz);
    for k in 1..=nz {
        for j in 1..=ny {
            for i in 1..=nx {
                let part = [i, j, k];
                let along = |d: usize| scale(axes[d], span[d] * part[d] as f64 / (n[d] + 1.0));
                out.push(add(origin, add(along(0), add(along(1), along(2)))));
            }
        }
    }
    out
}

/// Points on a circle, one every `dTheta` degrees, and the length of the arc between them, m.
pub(super) fn circle(r: &Reader<'_>) -> (Vec<Vec3>, f64) {
    let (origin, start) = (r.vector("origin", Dims::LENGTH), r.vector("startPoint", Dims::LENGTH));
    let axis = r.direction("circleAxis");
    let step = r.in_range("dTheta", Dims::NONE, 360.0 / MOST..=360.0);
    let arm = sub(start, origin);
    let round = sub(arm, scale(axis, dot(arm, axis)));
    if norm(round) == 0.0 {
        let message = "`startPoint` lies on the axis of the circle";
        r.error_at_key("startPoint", message, "no circle", None);
        return (Vec::new(), 1.0);
    }
    // Clockwise, seen against the axis, as the reference tool goes.
    let side = cross(round, axis);
    let n = ((360.0 / step - 1e-9).floor() as usize + 1).max(1);
    let at = |i: usize| {
        let (s, c) = (i as f64 * step).to_radians().sin_cos();
        add(start, add(scale(round, c - 1.0), scale(side, s)))
    };
    ((0..n).map(at).collect(), step.to_radians() * norm(round))
}

impl Wanted {
    /// The points in the mesh. What is not there is said.
    pub(super) fn find(
        &self,
        around: &Around<'_>,
        name: &str,
        span: &Span,
        sink: &Sink,
    ) -> Vec<InCell> {
        let (poly, mesh) = (around.poly, around.mesh);
        match self {
            Wanted::Centres(bounds) => {
                let inside = |x: Vec3| {
                    bounds.is_none_or(|[lo, hi]| (0..3).all(|k| lo[k] <= x[k] && x[k] <= hi[k]))
                };
                let all = (0..mesh.n_cells).map(|c| (mesh.global_cell[c], mesh.cell_centre[c]));
                let mut found: Vec<InCell> =
                    all.filter(|(_, x)| inside(*x)).map(|(c, x)| (f64::from(c), x, c)).collect();
                found.sort_by(|a, b| a.0.total_cmp(&b.0));
                found
            }
            Wanted::Nearest { patches, points, most } => {
                patches.check_named(mesh, sink);
                let faces: Vec<usize> = faces_of(poly, &patches.indices(mesh));
                let near = |(i, x): (usize, &Vec3)| {
                    let on = |f: &usize| (nearest_on(poly, *f, *x), *f);
                    let far = |p: &(Vec3, usize)| norm(sub(p.0, *x));
                    let found = faces.iter().map(on).min_by(|a, b| far(a).total_cmp(&far(b)));
                    match found.filter(|p| far(p) <= *most) {
                        Some((at, f)) => Some((i as f64, at, poly.owner[f])),
                        None => {
                            let [x, y, z] = x;
                            let message = format!(
                                "the point ({x} {y} {z}) of `{name}` is not near its patches"
                            );
                            sink.push(Diag::warning(span, message).label("left out"));
                            None
                        }
                    }
                };
                points.iter().enumerate().filter_map(near).collect()
            }
            Wanted::Seeds { patches, most } => {
                patches.check_named(mesh, sink);
                let faces: Vec<usize> = faces_of(poly, &patches.indices(mesh));
                let n = faces.len().min(*most);
                let centre = |f: usize| {
                    let own = mesh.poly_face.iter().position(|e| (e >> 1) as usize == f);
                    own.map(|own| {
                        (mesh.face_centre[own], mesh.cell_centre[mesh.owner[own] as usize])
                    })
                };
                let seed = |i: usize| {
                    let f = faces[(2 * i + 1) * faces.len() / (2 * n)];
                    // A little inside, so that the point lies in the cell.
                    let (face, cell) = centre(f)?;
                    Some((i as f64, add(face, scale(sub(cell, face), 0.1)), poly.owner[f]))
                };
                (0..n).filter_map(seed).collect()
            }
        }
    }
}

fn faces_of(poly: &PolyMesh, patches: &[usize]) -> Vec<usize> {
    patches.iter().flat_map(|p| poly.patches[*p].faces()).collect()
}

/// The point of face `f` nearest to `x`: of the triangles between its edges and the mean of its points.
fn nearest_on(poly: &PolyMesh, f: usize, x: Vec3) -> Vec3 {
    let at = |p: &u32| poly.points[*p as usize];
    let points: Vec<Vec3> = poly.face(f).iter().map(at).collect();
    let sum = points.iter().fold([0.0; 3], |s, p| add(s, *p));
    let middle = scale(sum, 1.0 / points.len() as f64);
    let edge = |i: usize| [points[i], points[(i + 1) % points.len()], middle];
    let far = |p: &Vec3| norm(sub(*p, x));
    let near = (0..points.len()).map(|i| nearest_in(edge(i), x));
    near.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(middle)
}

/// The point of a triangle nearest to `x` (C. Ericson, Real-Time Collision Detection, 2005, ch. 5.1).
fn nearest_in([a, b, c]: [Vec3; 3], x: Vec3) -> Vec3 {
    let (ab, ac, ax) = (sub(b, a), sub(c, a), sub(x, a));
    let normal = cross(ab, ac);
    let area = dot(normal, normal);
    if area > 0.0 {
        // Barycentric coordinates of the point's projection.
        let v = dot(cross(ax, ac), normal) / area;
        let w = dot(cross(ab, ax), normal) / area;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return add(a, add(scale(ab, v), scale(ac, w)));
        }
    }
    let on_edge = |p: Vec3, q: Vec3| {
        let d = sub(q, p);
        let t = dot(sub(x, p), d) / dot(d, d).max(f64::MIN_POSITIVE);
        add(p, scale(d, t.clamp(0.0, 1.0)))
    };
    let far = |p: &Vec3| norm(sub(*p, x));
    let edges = [on_edge(a, b), on_edge(b, c), on_edge(c, a)];
    edges.into_iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle() {
        let t = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let near = |x| nearest_in(t, x);
        assert_eq!(near([0.25, 0.25, 3.0]), [0.25, 0.25, 0.0]);
        assert_eq!(near([0.5, -1.0, 1.0]), [0.5, 0.0, 0.0]);
        assert_eq!(near([-1.0, -1.0, 0.0]), [0.0, 0.0, 0.0]);
        assert_eq!(near([1.0, 1.0, 0.0]), [0.5, 0.5, 0.0]);
        assert_eq!(near([3.0, -1.0, 0.0]), [1.0, 0.0, 0.0]);
    }
}
