//! Some cells of a mesh as a mesh of their own, to be looked at.

use crate::polymesh::{PatchKind, PolyMesh, PolyPatch};

/// The mesh of `cells` (ascending), whose numbers become 0, 1 and so on. Its boundary is one patch,
/// `surface`; it may consist of pieces that do not touch.
pub fn subset(poly: &PolyMesh, cells: &[u32]) -> PolyMesh {
    let new = |c: u32| cells.binary_search(&c).ok().map(|n| n as u32);
    let mut inner = Vec::new();
    let mut outer = Vec::new();
    for f in 0..poly.n_faces() {
        let own = new(poly.owner[f]);
        let other = poly.neighbour.get(f).and_then(|&n| new(n));
        match (own, other) {
            (Some(o), Some(n)) => inner.push((o, n, f)),
            (Some(o), None) => outer.push((o, f, false)),
            (None, Some(n)) => outer.push((n, f, true)),
            (None, None) => {}
        }
    }
    let mut label = vec![None; poly.points.len()];
    let mut out = PolyMesh { face_ptr: vec![0], ..PolyMesh::default() };
    let mut push = |out: &mut PolyMesh, f: usize, back: bool| {
        let mut ring: Vec<u32> = poly
            .face(f)
            .iter()
            .map(|&p| {
                *label[p as usize].get_or_insert_with(|| {
                    out.points.push(poly.points[p as usize]);
                    out.points.len() as u32 - 1
                })
            })
            .collect();
        if back {
            ring.reverse();
        }
        out.push_face(&ring);
    };
    for &(o, n, f) in &inner {
        push(&mut out, f, o > n);
        out.owner.push(o.min(n));
        out.neighbour.push(o.max(n));
    }
    for &(o, f, back) in &outer {
        push(&mut out, f, back);
        out.owner.push(o);
    }
    out.patches.push(PolyPatch {
        name: "surface".into(),
        kind: PatchKind::Patch,
        start: inner.len(),
        len: outer.len(),
        in_groups: Vec::new(),
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, shapes};

    #[test]
    fn cells_keep_their_shape_and_their_order() {
        let poly = shapes::shuffled(&shapes::unit_box([4, 3, 2]), 7);
        let cells = [1, 5, 6, 17, 22];
        let part = subset(&poly, &cells);
        part.validate().unwrap();
        let (whole, g) = (Geometry::new(&poly), Geometry::new(&part));
        assert_eq!(g.volume.len(), 5);
        for (n, &c) in cells.iter().enumerate() {
            assert!((g.volume[n] - whole.volume[c as usize]).abs() < 1e-15);
            let off = granflow_base::sub(g.cell_centre[n], whole.cell_centre[c as usize]);
            assert!(granflow_base::norm(off) < 1e-14);
        }
    }
}
