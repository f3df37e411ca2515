//! The outside of a mesh and surfaces of equal value.

use super::{CARRIED, Corner, Grid, Piece, VECTOR};
use granflow_base::{Vec3, add, cross, dot, scale, sub, unit};
use std::collections::HashMap;

/// Values at points, then at the middle of faces and of cells: means of what surrounds them.
pub(crate) fn with_centres(grid: &Grid, points: &[f64]) -> Vec<f64> {
    let mean = |v: &mut dyn Iterator<Item = f64>| {
        let (sum, n) = v.fold((0.0, 0.0), |s, x| (s.0 + x, s.1 + 1.0));
        sum / n
    };
    let poly = &grid.poly;
    let mut out = points.to_vec();
    for f in 0..poly.n_faces() {
        out.push(mean(&mut poly.face(f).iter().map(|p| points[*p as usize])));
    }
    let (start, faces) = &grid.cell_faces;
    for c in 0..poly.n_cells() {
        let own = &faces[start[c] as usize..start[c + 1] as usize];
        let first = points.len();
        let v = mean(&mut own.iter().map(|f| out[first + (*f as usize >> 1)]));
        out.push(v);
    }
    out
}

/// Corners of a decomposition into tetrahedra: points, middles of faces, middles of cells.
fn corners(grid: &Grid, values: &[(usize, Vec<f64>)]) -> Vec<Corner> {
    let along: Vec<Vec<f64>> = (0..3)
        .map(|k| with_centres(grid, &grid.poly.points.iter().map(|p| p[k]).collect::<Vec<_>>()))
        .collect();
    let n = along[0].len();
    (0..n)
        .map(|i| {
            let mut v = [0.0; CARRIED];
            values.iter().for_each(|(slot, all)| v[*slot] = all[i]);
            Corner { at: [along[0][i], along[1][i], along[2][i]], v }
        })
        .collect()
}

/// The boundary faces that `keep` wants, as triangles with normals. `values` are the slots and
/// what [`with_centres`] made.
pub(crate) fn outside(grid: &Grid, values: &[(usize, Vec<f64>)], keep: &[bool]) -> Vec<Piece> {
    let poly = &grid.poly;
    let all = corners(grid, values);
    let mut out = Vec::new();
    for f in poly.n_inner()..poly.n_faces() {
        if !keep[f - poly.n_inner()] {
            continue;
        }
        let normal = unit(grid.geometry.area[f]);
        let with = |mut c: Corner| {
            c.v[VECTOR..VECTOR + 3].copy_from_slice(&normal);
            c
        };
        let face = poly.face(f);
        let middle = with(all[poly.points.len() + f]);
        for (i, p) in face.iter().enumerate() {
            let q = face[(i + 1) % face.len()];
            let corners = [middle, with(all[*p as usize]), with(all[q as usize])];
            out.push(Piece { cell: poly.owner[f] as usize, corners });
        }
    }
    out
}

/// The surface on which the values of `slot` are `level`, from tetrahedra between the middles of
/// cells and faces and the edges (Doi & Koide 1991), with normals that vary smoothly.
pub(crate) fn iso(
    grid: &Grid,
    values: &[(usize, Vec<f64>)],
    slot: usize,
    level: f64,
) -> Vec<Piece> {
    let all = corners(grid, values);
    let over = |i: usize| all[i].v[slot] - level;
    let nodes: Vec<f64> = all.iter().map(|c| c.v[slot]).collect();
    let triangles = iso_triangles(grid, &nodes, level);
    // Where the surface passes through a node, all edges from there share their corner.
    let key = |(i, j): (usize, usize)| if over(i) == 0.0 { (i, i) } else { (i, j) };
    let place = |(i, j): (usize, usize)| match key((i, j)) {
        (i, k) if i == k => all[i],
        _ => all[i].towards(&all[j], over(i) / (over(i) - over(j))),
    };
    let mut normals: HashMap<(usize, usize), Vec3> = HashMap::new();
    for (_, t) in &triangles {
        let c = t.map(place);
        let n = cross(sub(c[1].at, c[0].at), sub(c[2].at, c[0].at));
        // Away from the greater values.
        let away = dot(n, sub(all[t[0].1].at, all[t[0].0].at));
        let n = if away < 0.0 { scale(n, -1.0) } else { n };
        for e in t {
            let sum = normals.entry(key(*e)).or_default();
            *sum = add(*sum, n);
        }
    }
    let with = |e: (usize, usize)| {
        let mut c = place(e);
        let n = normals.get(&key(e)).copied().unwrap_or_default();
        c.v[VECTOR..VECTOR + 3].copy_from_slice(&n);
        c
    };
    triangles.into_iter().map(|(cell, t)| Piece { cell, corners: t.map(with) }).collect()
}

/// The triangles of the surface on which the values at the nodes are `level`: the cell of each, and for each
/// corner the nodes on either side, the one with the greater value first. `nodes` is what
/// [`with_centres`] made.
pub(crate) fn iso_triangles(grid: &Grid, nodes: &[f64], level: f64) -> Vec<Triangle> {
    let poly = &grid.poly;
    let over = |i: usize| nodes[i] - level;
    let (start, faces) = &grid.cell_faces;
    let mut triangles: Vec<Triangle> = Vec::new();
    for cell in 0..poly.n_cells() {
        let own = &faces[start[cell] as usize..start[cell + 1] as usize];
        let points = || own.iter().flat_map(|f| poly.face(*f as usize >> 1));
        let inside = points().any(|p| over(*p as usize) >= 0.0);
        if !(inside && points().any(|p| over(*p as usize) < 0.0)) {
            continue;
        }
        let centre = poly.points.len() + poly.n_faces() + cell;
        for f in own.iter().map(|f| *f as usize >> 1) {
            let face = poly.face(f);
            for (i, p) in face.iter().enumerate() {
                let q = face[(i + 1) % face.len()];
                let tet = [centre, poly.points.len() + f, *p as usize, q as usize];
                let (inn, out): (Vec<usize>, Vec<usize>) =
                    tet.into_iter().partition(|n| over(*n) >= 0.0);
                let e = |i: usize, j: usize| (inn[i], out[j]);
                match inn.len() {
                    1 => triangles.push((cell, [e(0, 0), e(0, 1), e(0, 2)])),
                    3 => triangles.push((cell, [e(0, 0), e(1, 0), e(2, 0)])),
                    2 => {
                        triangles.push((cell, [e(0, 0), e(0, 1), e(1, 1)]));
                        triangles.push((cell, [e(0, 0), e(1, 1), e(1, 0)]));
                    }
                    _ => {}
                }
            }
        }
    }
    // Where the surface passes through a node, triangles may shrink to nothing.
    let key = |(i, j): (usize, usize)| if over(i) == 0.0 { (i, i) } else { (i, j) };
    triangles.retain(|(_, t)| {
        let [a, b, c] = t.map(key);
        a != b && b != c && c != a
    });
    triangles
}

/// A cell, and for each corner the nodes on either side.
pub(crate) type Triangle = (usize, [(usize, usize); 3]);

/// Edges where boundary faces meet at more than 30 degrees, or where the shown part ends.
pub(crate) fn edges(grid: &Grid, keep: &[bool]) -> Vec<(Vec3, Vec3)> {
    let poly = &grid.poly;
    let mut sides: Vec<(u32, u32, usize)> = Vec::new();
    for f in (poly.n_inner()..poly.n_faces()).filter(|f| keep[f - poly.n_inner()]) {
        let face = poly.face(f);
        for (i, p) in face.iter().enumerate() {
            let q = face[(i + 1) % face.len()];
            sides.push((*p.min(&q), *p.max(&q), f));
        }
    }
    sides.sort_unstable();
    let n = |f: usize| unit(grid.geometry.area[f]);
    sides
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .filter(|c| c.len() != 2 || dot(n(c[0].2), n(c[1].2)) < 0.866)
        .map(|c| (poly.points[c[0].0 as usize], poly.points[c[0].1 as usize]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_base::norm;
    use granflow_mesh::shapes;

    fn area(pieces: &[Piece]) -> f64 {
        let of = |p: &Piece| {
            let [a, b, c] = p.corners.map(|c| c.at);
            0.5 * norm(cross(sub(b, a), sub(c, a)))
        };
        pieces.iter().map(of).sum()
    }

    #[test]
    fn a_plane_of_equal_value_is_a_plane() {
        let grid = Grid::new(shapes::unit_box([4, 4, 4]));
        let level: Vec<f64> = grid.poly.points.iter().map(|p| p[0] + p[1] + p[2]).collect();
        let pieces = iso(&grid, &[(4, with_centres(&grid, &level))], 4, 1.5);
        // Across the cube's diagonal: a hexagon.
        assert!((area(&pieces) - 0.75 * 3f64.sqrt()).abs() < 1e-12, "{}", area(&pieces));
        for c in pieces.iter().flat_map(|p| p.corners) {
            let n = unit([c.v[1], c.v[2], c.v[3]]);
            assert!(n.iter().all(|v| (v + 3f64.sqrt().recip()).abs() < 1e-9), "{n:?}");
        }
    }

    /// Area vector of a closed surface and the volume in it (divergence theorem), with sides
    /// told apart by the normals that corners carry.
    fn enclosed(pieces: &[Piece]) -> (Vec3, f64) {
        let (mut out, mut volume) = ([0.0; 3], 0.0);
        for p in pieces {
            let [a, b, c] = p.corners.map(|c| c.at);
            let n = scale(cross(sub(b, a), sub(c, a)), 0.5);
            let v = &p.corners[0].v;
            let towards = dot(n, [v[VECTOR], v[VECTOR + 1], v[VECTOR + 2]]);
            let n = if towards < 0.0 { scale(n, -1.0) } else { n };
            out = add(out, n);
            volume += dot(n, add(add(a, b), c)) / 9.0;
        }
        (out, volume)
    }

    fn meshes() -> [granflow_mesh::PolyMesh; 3] {
        let wall = shapes::all(granflow_mesh::PatchKind::Wall);
        [
            shapes::unit_box([3, 4, 5]),
            shapes::displaced(&shapes::unit_box([4, 4, 4]), 0.2, 3),
            shapes::prism_box([4, 3, 4], [0.0; 3], [1.0; 3], wall),
        ]
    }

    #[test]
    fn a_phase_is_closed_and_holds_its_volume() {
        for poly in meshes() {
            let grid = Grid::new(poly);
            let keep = vec![true; grid.poly.n_faces() - grid.poly.n_inner()];
            let phase = |f: fn(Vec3) -> f64, level: f64| {
                let at: Vec<f64> = grid.poly.points.iter().map(|p| f(*p)).collect();
                let slots = [(4, with_centres(&grid, &at))];
                let mut pieces = super::super::clip(outside(&grid, &slots, &keep), 4, level, 1.0);
                pieces.extend(iso(&grid, &slots, 4, level));
                enclosed(&pieces)
            };
            let (out, whole) = phase(|p| p[0], -1.0);
            assert!(norm(out) < 1e-12 && (whole - 1.0).abs() < 1e-12, "{out:?} {whole}");
            // x + y + z beyond 2.25: a corner of legs 0.75.
            let (out, corner) = phase(|p| p[0] + p[1] + p[2], 2.25);
            assert!(norm(out) < 1e-12, "{out:?}");
            assert!((corner - 0.75f64.powi(3) / 6.0).abs() < 1e-12, "{corner}");
            // Any field makes a closed surface.
            let wild = |p: Vec3| (9.0 * p[0]).sin() * (7.0 * p[1]).cos() + (5.0 * p[2]).sin();
            let (out, some) = phase(wild, 0.3);
            assert!(norm(out) < 1e-12 && some > 0.1 && some < 0.9, "{out:?} {some}");
        }
    }

    #[test]
    fn the_outside_is_closed_and_has_twelve_edges() {
        let grid = Grid::new(shapes::unit_box([2, 3, 4]));
        let keep = vec![true; grid.poly.n_faces() - grid.poly.n_inner()];
        assert!((area(&outside(&grid, &[], &keep)) - 6.0).abs() < 1e-12);
        let long: f64 = edges(&grid, &keep).iter().map(|(a, b)| norm(sub(*a, *b))).sum();
        assert!((long - 12.0).abs() < 1e-12);
    }
}
