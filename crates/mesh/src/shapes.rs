//! Small meshes made by rule, for tests and examples all over the workspace.

use crate::polymesh::{CyclicTransform, PatchKind, PolyMesh, PolyPatch};
use granflow_base::Vec3;
use std::collections::HashMap;

/// Names of a box's sides, in the order of its patches: -x, +x, -y, +y, -z, +z.
pub const SIDES: [&str; 6] = ["xMin", "xMax", "yMin", "yMax", "zMin", "zMax"];

/// Cells given by their outward faces, put together into a [`PolyMesh`].
///
/// Inner faces come in upper-triangular order. `patch_of(cell, face points)` chooses the patch of
/// a face that only one cell has; patches without faces stay, with length zero.
///
/// # Panics
/// When more than two cells share a face, or `patch_of` answers out of range: this is for meshes
/// known by construction.
pub fn from_cells(
    points: Vec<Vec3>,
    cells: &[Vec<Vec<u32>>],
    patches: &[(&str, PatchKind)],
    patch_of: impl Fn(usize, &[u32]) -> usize,
) -> PolyMesh {
    let mut sides: HashMap<Vec<u32>, Vec<(usize, usize)>> = HashMap::new();
    for (c, faces) in cells.iter().enumerate() {
        for (i, f) in faces.iter().enumerate() {
            let mut key = f.clone();
            key.sort_unstable();
            sides.entry(key).or_default().push((c, i));
        }
    }
    let mut inner = Vec::new();
    let mut boundary: Vec<Vec<(usize, usize)>> = vec![Vec::new(); patches.len()];
    for (c, faces) in cells.iter().enumerate() {
        for (i, f) in faces.iter().enumerate() {
            let mut key = f.clone();
            key.sort_unstable();
            let pair = &sides[&key];
            assert!(pair.len() <= 2, "more than two cells share a face");
            match pair.iter().find(|x| x.0 != c) {
                Some(&(n, _)) if n > c => inner.push((c, n, i)),
                Some(_) => {}
                None => boundary[patch_of(c, f)].push((c, i)),
            }
        }
    }
    inner.sort_unstable();
    let mut m = PolyMesh { points, face_ptr: vec![0], ..PolyMesh::default() };
    for (c, n, i) in inner {
        m.push_face(&cells[c][i]);
        m.owner.push(c as u32);
        m.neighbour.push(n as u32);
    }
    for ((name, kind), faces) in patches.iter().zip(boundary) {
        let (start, len) = (m.owner.len(), faces.len());
        for (c, i) in faces {
            m.push_face(&cells[c][i]);
            m.owner.push(c as u32);
        }
        let (name, kind) = ((*name).to_owned(), kind.clone());
        m.patches.push(PolyPatch { name, kind, start, len, in_groups: Vec::new() });
    }
    m
}

/// The six outward faces of a hexahedron with its corners in the usual order (bottom turning
/// about the third direction, then top).
pub fn hexahedron(p: [u32; 8]) -> Vec<Vec<u32>> {
    const FACES: [[usize; 4]; 6] =
        [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]];
    FACES.iter().map(|f| f.iter().map(|&i| p[i]).collect()).collect()
}

/// A box of `n[0] * n[1] * n[2]` hexahedra between two corners, patches named after [`SIDES`],
/// points moved by `map`. Cells and points run along x first, then y, then z.
pub fn mapped_box(
    n: [usize; 3],
    lo: Vec3,
    hi: Vec3,
    kinds: [PatchKind; 6],
    map: impl Fn(Vec3) -> Vec3,
) -> PolyMesh {
    let at = |i: usize, d: usize| lo[d] + (hi[d] - lo[d]) * i as f64 / n[d] as f64;
    let mut points = Vec::with_capacity((n[0] + 1) * (n[1] + 1) * (n[2] + 1));
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            points.extend((0..=n[0]).map(|i| map([at(i, 0), at(j, 1), at(k, 2)])));
        }
    }
    let p = |i: usize, j: usize, k: usize| ((k * (n[1] + 1) + j) * (n[0] + 1) + i) as u32;
    let mut cells = Vec::with_capacity(n[0] * n[1] * n[2]);
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                cells.push(hexahedron([
                    p(i, j, k),
                    p(i + 1, j, k),
                    p(i + 1, j + 1, k),
                    p(i, j + 1, k),
                    p(i, j, k + 1),
                    p(i + 1, j, k + 1),
                    p(i + 1, j + 1, k + 1),
                    p(i, j + 1, k + 1),
                ]));
            }
        }
    }
    let side = |_: usize, f: &[u32]| box_side(n, f);
    from_cells(points, &cells, &named(kinds), side)
}

/// Which side of a box of points numbered along x, y, z a face lies on.
fn box_side(n: [usize; 3], face: &[u32]) -> usize {
    let index = |p: u32, d: usize| {
        let p = p as usize;
        let (sx, sy) = (n[0] + 1, n[1] + 1);
        [p % sx, p / sx % sy, p / (sx * sy)][d]
    };
    let on = |d: usize, at: usize| face.iter().all(|&p| index(p, d) == at);
    let side = (0..6).find(|&s| on(s / 2, if s % 2 == 0 { 0 } else { n[s / 2] }));
    side.unwrap_or(0)
}

fn named(kinds: [PatchKind; 6]) -> Vec<(&'static str, PatchKind)> {
    SIDES.into_iter().zip(kinds).collect()
}

/// A box of hexahedra between two corners, patches named after [`SIDES`].
pub fn box_mesh(n: [usize; 3], lo: Vec3, hi: Vec3, kinds: [PatchKind; 6]) -> PolyMesh {
    mapped_box(n, lo, hi, kinds, |p| p)
}

/// The unit cube, all sides of kind patch.
pub fn unit_box(n: [usize; 3]) -> PolyMesh {
    box_mesh(n, [0.0; 3], [1.0; 3], all(PatchKind::Patch))
}

/// All six sides of one kind.
pub fn all(kind: PatchKind) -> [PatchKind; 6] {
    std::array::from_fn(|_| kind.clone())
}

/// Kinds of a box periodic along the chosen axes, `other` elsewhere. Pairs are [`SIDES`].
pub fn periodic_kinds(along: [bool; 3], other: PatchKind) -> [PatchKind; 6] {
    std::array::from_fn(|s| {
        if along[s / 2] {
            let (neighbour, transform) = (SIDES[s ^ 1].to_owned(), CyclicTransform::Unknown);
            PatchKind::Cyclic { neighbour, transform }
        } else {
            other.clone()
        }
    })
}

/// The unit cube, periodic along the chosen axes, patches elsewhere.
pub fn periodic_box(n: [usize; 3], along: [bool; 3]) -> PolyMesh {
    box_mesh(n, [0.0; 3], [1.0; 3], periodic_kinds(along, PatchKind::Patch))
}

/// A box of one layer in z between empty patches: a plane mesh of `n[0] * n[1]` cells.
pub fn plane_mesh(n: [usize; 2], lo: [f64; 2], hi: [f64; 2], sides: [PatchKind; 4]) -> PolyMesh {
    let [a, b, c, d] = sides;
    let kinds = [a, b, c, d, PatchKind::Empty, PatchKind::Empty];
    let depth = ((hi[0] - lo[0]) / n[0] as f64).abs();
    box_mesh([n[0], n[1], 1], [lo[0], lo[1], 0.0], [hi[0], hi[1], depth], kinds)
}

/// Moves every point off the boundary by up to `amount` of the local cell size, at random but
/// the same for the same `seed`. Cells stay sound for `amount` up to about 0.25.
pub fn displaced(poly: &PolyMesh, amount: f64, seed: u64) -> PolyMesh {
    let mut shortest = vec![f64::INFINITY; poly.points.len()];
    let mut fixed = vec![false; poly.points.len()];
    for f in 0..poly.n_faces() {
        let ring = poly.face(f);
        for (i, &a) in ring.iter().enumerate() {
            let b = ring[(i + 1) % ring.len()];
            let (a, b) = (a as usize, b as usize);
            let d = granflow_base::norm(granflow_base::sub(poly.points[a], poly.points[b]));
            shortest[a] = shortest[a].min(d);
            shortest[b] = shortest[b].min(d);
            fixed[a] |= f >= poly.n_inner();
        }
    }
    let mut m = poly.clone();
    let mut noise = Noise(seed);
    for (p, point) in m.points.iter_mut().enumerate() {
        let step: Vec3 = std::array::from_fn(|_| noise.next() * amount * shortest[p]);
        if !fixed[p] {
            *point = granflow_base::add(*point, step);
        }
    }
    m
}

/// The same mesh with its cells numbered at random (the same for the same `seed`).
pub fn shuffled(poly: &PolyMesh, seed: u64) -> PolyMesh {
    let n = poly.n_cells();
    let mut noise = Noise(seed);
    let mut new: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        new.swap(i, ((noise.next() * 0.5 + 0.5) * (i + 1) as f64) as usize % (i + 1));
    }
    let (ptr, links) = poly.cell_faces();
    let mut cells = vec![Vec::new(); n];
    let mut patch_of = HashMap::new();
    for c in 0..n {
        for &e in &links[ptr[c] as usize..ptr[c + 1] as usize] {
            let f = (e >> 1) as usize;
            let mut ring = poly.face(f).to_vec();
            if e & 1 == 1 {
                ring[1..].reverse();
            }
            if let Some(p) = poly.patches.iter().position(|p| p.faces().contains(&f)) {
                patch_of.insert(ring.clone(), p);
            }
            cells[new[c] as usize].push(ring);
        }
    }
    let patches: Vec<_> = poly.patches.iter().map(|p| (p.name.as_str(), p.kind.clone())).collect();
    from_cells(poly.points.clone(), &cells, &patches, |_, f| patch_of[f])
}

/// Uniform numbers in -1..1 (Steele, Lea & Flood's SplitMix64, OOPSLA 2014).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// An axisymmetric ring in r and z, one cell thick: corners at `(r, -/+ r tan a, z)`, so cell
/// centres lie in the plane y = 0. Patches `inner`, `outer`, `bottom`, `top`, and the wedges
/// `minus` and `plus`. With `inner = 0` the innermost cells are prisms on the axis and the patch
/// `inner` has no faces.
pub fn wedge_ring(
    inner: f64,
    outer: f64,
    height: f64,
    nr: usize,
    nz: usize,
    half_angle: f64,
) -> PolyMesh {
    let t = half_angle.tan();
    let r = |i: usize| inner + (outer - inner) * i as f64 / nr as f64;
    let mut points = Vec::new();
    let mut index = HashMap::new();
    for k in 0..=nz {
        for i in 0..=nr {
            for s in 0..2 {
                if s == 1 && r(i) == 0.0 {
                    index.insert((i, k, s), points.len() as u32 - 1);
                    continue;
                }
                index.insert((i, k, s), points.len() as u32);
                let y = if s == 0 { -r(i) * t } else { r(i) * t };
                points.push([r(i), y, height * k as f64 / nz as f64]);
            }
        }
    }
    let mut cells = Vec::new();
    let mut sides = HashMap::new();
    for k in 0..nz {
        for i in 0..nr {
            let p = |di: usize, s: usize, dk: usize| index[&(i + di, k + dk, s)];
            let corners = [
                p(0, 0, 0),
                p(1, 0, 0),
                p(1, 1, 0),
                p(0, 1, 0),
                p(0, 0, 1),
                p(1, 0, 1),
                p(1, 1, 1),
                p(0, 1, 1),
            ];
            let mut faces = Vec::new();
            for (side, mut f) in hexahedron(corners).into_iter().enumerate() {
                f.dedup();
                if f.len() > 1 && f[0] == f[f.len() - 1] {
                    f.pop();
                }
                if f.len() > 2 {
                    // Sides of the hexahedron in order: inner, outer, minus, plus, bottom, top.
                    sides.insert(f.clone(), [0, 1, 4, 5, 2, 3][side]);
                    faces.push(f);
                }
            }
            cells.push(faces);
        }
    }
    let patches = [
        ("inner", PatchKind::Wall),
        ("outer", PatchKind::Wall),
        ("bottom", PatchKind::Patch),
        ("top", PatchKind::Patch),
        ("minus", PatchKind::Wedge),
        ("plus", PatchKind::Wedge),
    ];
    from_cells(points, &cells, &patches, |_, f| sides[f])
}

/// A sector of a ring in r, theta, z with `turns`-fold rotational periodicity: patches `inner`,
/// `outer`, `start` and `end` (cyclic about the z axis), `bottom`, `top`.
pub fn annular_sector(inner: f64, outer: f64, n: [usize; 3], turns: usize) -> PolyMesh {
    let angle = std::f64::consts::TAU / turns as f64;
    let cyclic = |other: &str| PatchKind::Cyclic {
        neighbour: other.to_owned(),
        transform: CyclicTransform::Unknown,
    };
    let kinds = [
        PatchKind::Wall,
        PatchKind::Wall,
        cyclic("end"),
        cyclic("start"),
        PatchKind::Patch,
        PatchKind::Patch,
    ];
    let map = |[r, t, z]: Vec3| [r * (t * angle).cos(), r * (t * angle).sin(), z];
    let mut m = mapped_box(n, [inner, 0.0, 0.0], [outer, 1.0, 1.0], kinds, map);
    for (p, name) in m.patches.iter_mut().zip(["inner", "outer", "start", "end", "bottom", "top"]) {
        name.clone_into(&mut p.name);
    }
    m
}

/// A box whose hexahedra are split into prisms with triangles in the x-y plane, diagonals
/// alternating; patches named after [`SIDES`].
pub fn prism_box(n: [usize; 3], lo: Vec3, hi: Vec3, kinds: [PatchKind; 6]) -> PolyMesh {
    let hexes = box_mesh(n, lo, hi, kinds.clone());
    let p = |i: usize, j: usize, k: usize| ((k * (n[1] + 1) + j) * (n[0] + 1) + i) as u32;
    let mut cells = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                let q = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let halves =
                    if (i + j) % 2 == 0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
                for t in halves {
                    let low = t.map(|v: usize| p(q[v].0, q[v].1, k));
                    let high = t.map(|v: usize| p(q[v].0, q[v].1, k + 1));
                    let mut faces =
                        vec![vec![low[0], low[2], low[1]], vec![high[0], high[1], high[2]]];
                    for v in 0..3 {
                        let w = (v + 1) % 3;
                        faces.push(vec![low[v], low[w], high[w], high[v]]);
                    }
                    cells.push(faces);
                }
            }
        }
    }
    from_cells(hexes.points, &cells, &named(kinds), |_, f| box_side(n, f))
}

/// The unit square, 0.1 thick, in `n` rows of bricks, every other of which is half a brick further: cells
/// with up to eight faces, whose neighbours do not lie opposite each other. Smoothly bent. Patches `sides`
/// and, empty, `frontAndBack`.
pub fn brick_plane(n: usize) -> PolyMesh {
    let ends = |row: usize| -> Vec<usize> {
        if row.is_multiple_of(2) {
            (0..=n).map(|i| 2 * i).collect()
        } else {
            let mut all = vec![0];
            all.extend((0..n).map(|i| 2 * i + 1));
            all.push(2 * n);
            all
        }
    };
    let (mut points, mut ids) = (Vec::new(), HashMap::new());
    let mut id = |k: usize, j: usize, layer: usize| {
        *ids.entry((k, j, layer)).or_insert_with(|| {
            let (x, y) = (k as f64 / (2 * n) as f64, j as f64 / n as f64);
            let bend = 0.05 * (std::f64::consts::PI * x).sin() * (std::f64::consts::PI * y).sin();
            points.push([x + bend, y + bend, 0.1 * layer as f64]);
            points.len() as u32 - 1
        })
    };
    let mut cells = Vec::new();
    for row in 0..n {
        let mine = ends(row);
        // What the row meets below and above.
        let line = |j: usize| -> Vec<usize> {
            let mut all = mine.clone();
            if (1..n).contains(&j) {
                all.extend(ends(if j == row { row - 1 } else { row + 1 }));
            }
            all.sort_unstable();
            all.dedup();
            all
        };
        let (below, above) = (line(row), line(row + 1));
        for pair in mine.windows(2) {
            let inside = |k: &&usize| (pair[0]..=pair[1]).contains(*k);
            let mut ring: Vec<(usize, usize)> =
                below.iter().filter(inside).map(|k| (*k, row)).collect();
            ring.extend(above.iter().rev().filter(inside).map(|k| (*k, row + 1)));
            let low: Vec<u32> = ring.iter().map(|(k, j)| id(*k, *j, 0)).collect();
            let high: Vec<u32> = ring.iter().map(|(k, j)| id(*k, *j, 1)).collect();
            let mut faces = vec![low.iter().rev().copied().collect(), high.clone()];
            for v in 0..low.len() {
                let w = (v + 1) % low.len();
                faces.push(vec![low[v], low[w], high[w], high[v]]);
            }
            cells.push(faces);
        }
    }
    let patches = [("sides", PatchKind::Patch), ("frontAndBack", PatchKind::Empty)];
    let flat = points.iter().map(|p| p[2]).collect::<Vec<f64>>();
    from_cells(points, &cells, &patches, |_, face| {
        usize::from(face.iter().all(|p| flat[*p as usize] == flat[face[0] as usize]))
    })
}

/// The unit cube in `n` cubes a side, each of six tetrahedra about its diagonal (H. W. Kuhn, IBM
/// J. Res. Dev. 4 (1960) 518). One patch, `sides`.
pub fn tetrahedra(n: usize) -> PolyMesh {
    let id = |[i, j, k]: [usize; 3]| ((k * (n + 1) + j) * (n + 1) + i) as u32;
    let mut points = Vec::new();
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                points.push([i, j, k].map(|x| x as f64 / n as f64));
            }
        }
    }
    let turns = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
    let mut cells = Vec::new();
    for cube in 0..n * n * n {
        let corner = [cube % n, cube / n % n, cube / (n * n)];
        for (turn, axes) in turns.iter().enumerate() {
            let mut at = corner;
            let mut v = [id(at); 4];
            for (step, axis) in axes.iter().enumerate() {
                at[*axis] += 1;
                v[step + 1] = id(at);
            }
            if turn >= 3 {
                v.swap(1, 2);
            }
            let [a, b, c, d] = v;
            cells.push(vec![vec![a, c, b], vec![a, b, d], vec![a, d, c], vec![b, c, d]]);
        }
    }
    from_cells(points, &cells, &[("sides", PatchKind::Patch)], |_, _| 0)
}

/// One tetrahedron on the unit axes.
pub fn tetrahedron() -> PolyMesh {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let cell = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|f| f.to_vec()).to_vec();
    from_cells(points, &[cell], &[("surface", PatchKind::Wall)], |_, _| 0)
}

/// Two unit boxes that do not touch, as one mesh.
pub fn two_boxes(n: [usize; 3]) -> PolyMesh {
    let one = unit_box(n);
    let (ptr, links) = one.cell_faces();
    let mut points = one.points.clone();
    points.extend(one.points.iter().map(|p| [p[0] + 2.0, p[1], p[2]]));
    let mut cells = Vec::new();
    for shift in [0, one.points.len() as u32] {
        for c in 0..one.n_cells() {
            let faces = links[ptr[c] as usize..ptr[c + 1] as usize].iter().map(|&e| {
                let mut ring: Vec<u32> =
                    one.face((e >> 1) as usize).iter().map(|p| p + shift).collect();
                if e & 1 == 1 {
                    ring.reverse();
                }
                ring
            });
            cells.push(faces.collect());
        }
    }
    from_cells(points, &cells, &[("surface", PatchKind::Wall)], |_, _| 0)
}
