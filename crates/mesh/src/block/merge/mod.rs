//! Patches whose faces lie on each other become inner faces: `mergePatchPairs`.
//!
//! Points of the second patch that lie near one of the first move onto it. Then the faces of both
//! are cut by one another ([`overlay`]): what two faces have in common is an inner face, and points
//! that come to lie on an edge are added to every face with that edge, so that cells stay closed.
//! A face must be covered as a whole or not at all.

mod overlay;

use super::{BlockMesh, Merge};
use crate::polymesh::{PolyMesh, PolyPatch, place};
use granflow_base::{Vec3, norm, sub};
use granflow_dict::Diag;
use overlay::{Face, Overlay};
use std::collections::HashMap;

/// Points are one when they are this close, relative to the shortest edge of both patches.
const NEAR: f64 = 0.01;
/// How much of a face may remain uncovered before it counts as partly covered.
const COVERED: f64 = 1e-3;

/// One face of the mesh while it is put together.
struct Open {
    ring: Vec<u32>,
    owner: u32,
    beyond: Beyond,
}

#[derive(Clone, Copy, PartialEq)]
enum Beyond {
    Cell(u32),
    Patch(usize),
    /// Replaced by its parts.
    Gone,
}

/// Merges the pairs of patches in turn.
pub(super) fn merge(mesh: &BlockMesh, poly: PolyMesh) -> Result<PolyMesh, Vec<Diag>> {
    if mesh.merges.is_empty() {
        return Ok(poly);
    }
    let mut points = poly.points.clone();
    let mut faces = opened(&poly);
    let mut faults = Vec::new();
    for pair in &mesh.merges {
        if let Err(d) = merge_pair(mesh, pair, &mut points, &mut faces) {
            faults.push(d);
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let merged = |p: usize| mesh.merges.iter().any(|m| m.first == p || m.second == p);
    let cell_zones = poly.cell_zones.clone();
    Ok(PolyMesh { cell_zones, ..closed(points, faces, &poly.patches, merged) })
}

fn opened(poly: &PolyMesh) -> Vec<Open> {
    let mut faces: Vec<Open> = (0..poly.n_faces())
        .map(|f| Open {
            ring: poly.face(f).to_vec(),
            owner: poly.owner[f],
            beyond: poly.neighbour.get(f).map_or(Beyond::Gone, |&n| Beyond::Cell(n)),
        })
        .collect();
    for (p, patch) in poly.patches.iter().enumerate() {
        patch.faces().for_each(|f| faces[f].beyond = Beyond::Patch(p));
    }
    faces
}

fn merge_pair(
    mesh: &BlockMesh,
    pair: &Merge,
    points: &mut Vec<Vec3>,
    faces: &mut Vec<Open>,
) -> Result<(), Diag> {
    let of = |faces: &[Open], p: usize| -> Vec<usize> {
        (0..faces.len()).filter(|&f| faces[f].beyond == Beyond::Patch(p)).collect()
    };
    let (first, second) = (of(faces, pair.first), of(faces, pair.second));
    let near = NEAR * shortest(points, faces, &first).min(shortest(points, faces, &second));
    snap(points, faces, &first, &second, near);

    let shape = |f: &usize| Face::new(&faces[*f].ring, points);
    let a: Vec<Face> = first.iter().map(shape).collect();
    let b: Vec<Face> = second.iter().map(shape).collect();
    let overlay = Overlay::new(&a, &b, points, near);
    let mut covered = [vec![0.0; a.len()], vec![0.0; b.len()]];
    for part in &overlay.parts {
        covered[0][part.first] += part.area;
        covered[1][part.second] += part.area;
    }
    for (shapes, covered) in [&a, &b].into_iter().zip(&covered) {
        for (face, &area) in shapes.iter().zip(covered) {
            let share = area / face.area;
            if share > COVERED && (share - 1.0).abs() > COVERED {
                let [p, q] = [pair.first, pair.second].map(|p| &mesh.patches[p].name);
                let what = format!("the patches `{p}` and `{q}` do not fit each other");
                let label = format!(
                    "{:.1} % of the face at {} is covered",
                    100.0 * share,
                    place(face.centre)
                );
                return Err(Diag::error(&pair.span, what).label(label).help(
                    "let faces begin and end where the smaller patch does: every face must be \
                     covered as a whole or not at all",
                ));
            }
        }
    }
    if overlay.parts.is_empty() {
        let [p, q] = [pair.first, pair.second].map(|p| &mesh.patches[p].name);
        let what = format!("the patches `{p}` and `{q}` have no place in common");
        return Err(Diag::error(&pair.span, what).label("nothing to merge"));
    }
    points.extend(&overlay.new_points);
    for part in overlay.parts {
        let (f, g) = (first[part.first], second[part.second]);
        faces[f].beyond = Beyond::Gone;
        faces[g].beyond = Beyond::Gone;
        let (owner, other) = (faces[f].owner, faces[g].owner);
        faces.push(Open { ring: part.ring, owner, beyond: Beyond::Cell(other) });
    }
    for face in faces.iter_mut().filter(|f| f.beyond != Beyond::Gone) {
        face.ring = with_points_on_edges(&face.ring, &overlay.on_edge, points);
    }
    Ok(())
}

fn shortest(points: &[Vec3], faces: &[Open], of: &[usize]) -> f64 {
    let edges = of.iter().flat_map(|&f| {
        let ring = &faces[f].ring;
        (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))
    });
    edges
        .map(|(p, q)| norm(sub(points[p as usize], points[q as usize])))
        .fold(f64::INFINITY, f64::min)
}

/// Moves points of the second faces onto near ones of the first.
fn snap(points: &[Vec3], faces: &mut [Open], first: &[usize], second: &[usize], near: f64) {
    let home = |p: Vec3| p.map(|x| (x / (2.0 * near)).floor() as i64);
    let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut known: Vec<u32> = first.iter().flat_map(|&f| faces[f].ring.clone()).collect();
    known.sort_unstable();
    known.dedup();
    for &p in &known {
        boxes.entry(home(points[p as usize])).or_default().push(p);
    }
    let mut to: HashMap<u32, u32> = HashMap::new();
    for p in second.iter().flat_map(|&f| &faces[f].ring) {
        let (x, h) = (points[*p as usize], home(points[*p as usize]));
        for k in 0..27 {
            let at = [h[0] + k % 3 - 1, h[1] + k / 3 % 3 - 1, h[2] + k / 9 - 1];
            let hit = |q: &&u32| norm(sub(points[**q as usize], x)) <= near;
            if let Some(&q) = boxes.get(&at).and_then(|l| l.iter().find(hit)) {
                to.insert(*p, q);
                break;
            }
        }
    }
    for p in faces.iter_mut().flat_map(|f| f.ring.iter_mut()) {
        *p = to.get(p).copied().unwrap_or(*p);
    }
}

/// `ring` with the points that lie on its edges.
fn with_points_on_edges(
    ring: &[u32],
    on_edge: &HashMap<(u32, u32), Vec<u32>>,
    points: &[Vec3],
) -> Vec<u32> {
    let mut out = Vec::with_capacity(ring.len());
    for (i, &p) in ring.iter().enumerate() {
        out.push(p);
        let q = ring[(i + 1) % ring.len()];
        if let Some(between) = on_edge.get(&(p.min(q), p.max(q))) {
            let from = |x: &u32| norm(sub(points[*x as usize], points[p as usize]));
            let mut between: Vec<u32> =
                between.iter().copied().filter(|x| !ring.contains(x)).collect();
            between.sort_by(|x, y| from(x).total_cmp(&from(y)));
            between.dedup();
            out.extend(between);
        }
    }
    out
}

/// Sorts the faces and leaves out what is not used any more.
fn closed(
    points: Vec<Vec3>,
    faces: Vec<Open>,
    patches: &[PolyPatch],
    merged: impl Fn(usize) -> bool,
) -> PolyMesh {
    let mut used = vec![false; points.len()];
    let kept = || faces.iter().filter(|f| f.beyond != Beyond::Gone);
    kept().flat_map(|f| &f.ring).for_each(|&p| used[p as usize] = true);
    let mut label = vec![0u32; points.len()];
    let mut poly = PolyMesh { face_ptr: vec![0], ..PolyMesh::default() };
    for (p, x) in points.into_iter().enumerate().filter(|(p, _)| used[*p]) {
        label[p] = poly.points.len() as u32;
        poly.points.push(x);
    }
    let ring = |f: &Open, back: bool| -> Vec<u32> {
        let mut ring: Vec<u32> = f.ring.iter().map(|&p| label[p as usize]).collect();
        if back {
            ring[1..].reverse();
        }
        ring
    };
    let mut inner: Vec<(u32, u32, &Open)> = kept()
        .filter_map(|f| match f.beyond {
            Beyond::Cell(n) => Some((f.owner.min(n), f.owner.max(n), f)),
            _ => None,
        })
        .collect();
    inner.sort_by_key(|&(o, n, _)| (o, n));
    for (o, n, f) in inner {
        poly.push_face(&ring(f, o != f.owner));
        poly.owner.push(o);
        poly.neighbour.push(n);
    }
    for (p, patch) in patches.iter().enumerate() {
        let start = poly.owner.len();
        for f in kept().filter(|f| f.beyond == Beyond::Patch(p)) {
            poly.push_face(&ring(f, false));
            poly.owner.push(f.owner);
        }
        let len = poly.owner.len() - start;
        if len > 0 || !merged(p) {
            poly.patches.push(PolyPatch { start, len, ..patch.clone() });
        }
    }
    poly
}
