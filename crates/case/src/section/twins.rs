//! Points that translational cyclic pairs make one.

use granflow_base::{Vec3, add, dot, norm, scale, sub};
use granflow_mesh::{CyclicTransform, Geometry, PatchKind, PolyMesh, PolyPatch};
use std::collections::{BTreeMap, HashMap};

/// Farthest that twins may be apart, relative to the extent of the mesh.
const NEAR: f64 = 1e-6;

/// For points of translational pairs, their images in other places: point and how far it has to
/// be moved to come to lie here. Rotational pairs and wedges join nothing: components of vectors
/// turn from one side to the other.
pub(super) fn twins(poly: &PolyMesh, g: &Geometry, size: f64) -> BTreeMap<u32, Vec<(u32, Vec3)>> {
    let mut links: BTreeMap<u32, Vec<(u32, Vec3)>> = BTreeMap::new();
    for (i, patch) in poly.patches.iter().enumerate() {
        let PatchKind::Cyclic { neighbour, transform } = &patch.kind else { continue };
        let Some(j) = poly.patch(neighbour).filter(|j| i < *j) else { continue };
        let other = &poly.patches[j];
        let turned = |t: &CyclicTransform| matches!(t, CyclicTransform::Rotational { .. });
        let other_turned =
            matches!(&other.kind, PatchKind::Cyclic { transform, .. } if turned(transform));
        if turned(transform) || other_turned {
            continue;
        }
        let Some((shift, pairs)) = matched(poly, g, patch, other, size) else { continue };
        for (a, b) in pairs {
            links.entry(a).or_default().push((b, scale(shift, -1.0)));
            links.entry(b).or_default().push((a, shift));
        }
    }
    // Along edges where pairs meet, images have images.
    let whole = |p: u32| {
        let mut found: Vec<(u32, Vec3)> = vec![(p, [0.0; 3])];
        let mut next = 0;
        while let Some(&(q, shift)) = found.get(next) {
            next += 1;
            for (r, more) in links.get(&q).into_iter().flatten() {
                if found.iter().all(|f| f.0 != *r) {
                    found.push((*r, add(shift, *more)));
                }
            }
        }
        found.remove(0);
        found
    };
    links.keys().map(|p| (*p, whole(*p))).collect()
}

/// The translation from one patch to the other and the points it joins, if one does.
fn matched(
    poly: &PolyMesh,
    g: &Geometry,
    a: &PolyPatch,
    b: &PolyPatch,
    size: f64,
) -> Option<(Vec3, Vec<(u32, u32)>)> {
    let area = |p: &PolyPatch| p.faces().map(|f| g.area[f]).fold([0.0; 3], add);
    let (out_a, out_b) = (area(a), area(b));
    if norm(add(out_a, out_b)) > 1e-6 * norm(out_a) || dot(out_a, out_b) >= 0.0 {
        return None;
    }
    let points = |p: &PolyPatch| {
        let mut all: Vec<u32> = p.faces().flat_map(|f| poly.face(f).iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (from, to) = (points(a), points(b));
    let at = |p: u32| poly.points[p as usize];
    let middle =
        |all: &[u32]| scale(all.iter().map(|p| at(*p)).fold([0.0; 3], add), 1.0 / all.len() as f64);
    let shift = sub(middle(&to), middle(&from));
    // Twins lie in the same or in a neighbouring box of the tolerance's size.
    let near = NEAR * size;
    let key = |p: Vec3| p.map(|x| (x / near).floor() as i64);
    let mut there: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    to.iter().for_each(|q| there.entry(key(at(*q))).or_default().push(*q));
    let twin = |p: u32| {
        let image = add(at(p), shift);
        let [i, j, k] = key(image);
        (0..27)
            .filter_map(|n| there.get(&[i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1]))
            .flatten()
            .find(|q| norm(sub(at(**q), image)) <= near)
            .copied()
    };
    let pairs: Option<Vec<(u32, u32)>> = from.iter().map(|p| twin(*p).map(|q| (*p, q))).collect();
    Some((shift, pairs?)).filter(|_| from.len() == to.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::shapes;

    #[test]
    fn corners_of_a_doubly_periodic_box_are_one_point() {
        let poly = shapes::periodic_box([3, 4, 2], [true, true, false]);
        let all = twins(&poly, &Geometry::new(&poly), 1.0);
        // Both x ends (5 x 3), both y ends (4 x 3), edges counted once.
        assert_eq!(all.len(), 2 * 15 + 2 * 12 - 4 * 3);
        for (p, images) in &all {
            let here = poly.points[*p as usize];
            let edge = |k: usize| here[k] < 1e-9 || here[k] > 1.0 - 1e-9;
            assert_eq!(images.len(), if edge(0) && edge(1) { 3 } else { 1 });
            for (q, shift) in images {
                assert!(norm(sub(add(poly.points[*q as usize], *shift), here)) < 1e-12);
            }
        }
    }

    #[test]
    fn turned_pairs_join_nothing() {
        for turns in [2, 3, 8] {
            let poly = shapes::annular_sector(1.0, 2.0, [3, 4, 2], turns);
            assert!(twins(&poly, &Geometry::new(&poly), 4.0).is_empty(), "{turns}");
        }
    }
}
