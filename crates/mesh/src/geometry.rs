//! Face areas and centres, cell volumes and centroids.
//!
//! Faces are split into triangles about the average of their points, cells into pyramids about
//! the average of their face centres (Jasak, PhD thesis, Imperial College 1996, section 3.3).
//! Face centres weigh each triangle by its area along the face normal, so warped faces stay
//! consistent with the volume they sweep.

use crate::polymesh::PolyMesh;
use granflow_base::{Vec3, add, cross, dot, norm, scale, sub, unit};

/// Geometry of a [`PolyMesh`], face by face and cell by cell.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Face area vectors, owner to neighbour, m2.
    pub area: Vec<Vec3>,
    /// Face centroids, m.
    pub face_centre: Vec<Vec3>,
    /// Cell volumes, m3 (negative when a cell is inside out).
    pub volume: Vec<f64>,
    /// Cell centroids, m.
    pub cell_centre: Vec<Vec3>,
}

impl Geometry {
    /// Geometry of a mesh whose topology is valid ([`PolyMesh::validate`]).
    pub fn new(poly: &PolyMesh) -> Geometry {
        let mut corners = Vec::with_capacity(8);
        let (face_centre, area): (Vec<_>, Vec<_>) = (0..poly.n_faces())
            .map(|f| {
                corners.clear();
                corners.extend(poly.face(f).iter().map(|&p| poly.points[p as usize]));
                face_geometry(&corners)
            })
            .unzip();
        let (ptr, faces) = poly.cell_faces();
        let (volume, cell_centre) = (0..ptr.len() - 1)
            .map(|c| {
                let links = &faces[ptr[c] as usize..ptr[c + 1] as usize];
                cell_geometry(links, &face_centre, &area)
            })
            .unzip();
        Geometry { area, face_centre, volume, cell_centre }
    }
}

/// Centroid and area vector of a polygon, by triangles about the average of its corners.
pub(crate) fn face_geometry(corners: &[Vec3]) -> (Vec3, Vec3) {
    if let [a, b, c] = *corners {
        let s = scale(cross(sub(b, a), sub(c, a)), 0.5);
        return (scale(add(add(a, b), c), 1.0 / 3.0), s);
    }
    let n = corners.len();
    let mid = scale(corners.iter().copied().fold([0.0; 3], add), 1.0 / n as f64);
    let triangle = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        (a, b, cross(sub(b, a), sub(mid, a)))
    };
    let twice = (0..n).map(|i| triangle(i).2).fold([0.0; 3], add);
    let normal = unit(twice);
    let (mut weight, mut moment) = (0.0, [0.0; 3]);
    for i in 0..n {
        let (a, b, s) = triangle(i);
        let w = dot(s, normal);
        weight += w;
        // Moments about the middle point keep the digits of a small face far from the origin.
        moment = add(moment, scale(add(sub(a, mid), sub(b, mid)), w / 3.0));
    }
    let tiny = f64::MIN_POSITIVE;
    let centre = if weight > tiny { add(mid, scale(moment, 1.0 / weight)) } else { mid };
    (centre, scale(twice, 0.5))
}

/// Volume and centroid of a cell, by pyramids over its faces.
fn cell_geometry(links: &[u32], centre: &[Vec3], area: &[Vec3]) -> (f64, Vec3) {
    let mid = links.iter().map(|&e| centre[(e >> 1) as usize]).fold([0.0; 3], add);
    let mid = scale(mid, 1.0 / links.len() as f64);
    let (mut thrice, mut moment, mut size) = (0.0, [0.0; 3], 0.0);
    for &e in links {
        let f = (e >> 1) as usize;
        let arm = sub(centre[f], mid);
        let v = dot(area[f], arm) * if e & 1 == 0 { 1.0 } else { -1.0 };
        thrice += v;
        size += norm(area[f]) * norm(arm);
        moment = add(moment, scale(arm, 0.75 * v));
    }
    // A flat or inverted cell has no meaningful centroid: keep the average, report it elsewhere.
    let sound = thrice > 1e-12 * size;
    let shift = if sound { scale(moment, 1.0 / thrice) } else { [0.0; 3] };
    (thrice / 3.0, add(mid, shift))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn a_trapezium_has_its_textbook_centroid() {
        // Parallel sides 2 and 1, height 1: centroid at h/3 (b + 2a)/(a + b) above the long one.
        let c = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 1.0, 0.0], [0.5, 1.0, 0.0]];
        let (centre, area) = face_geometry(&c);
        assert!(norm(sub(area, [0.0, 0.0, 1.5])) < 1e-15);
        assert!(norm(sub(centre, [1.0, 4.0 / 9.0, 0.0])) < 1e-15);
    }

    #[test]
    fn volumes_of_known_shapes() {
        let g = Geometry::new(&shapes::unit_box([3, 2, 4]));
        assert!(g.volume.iter().all(|v| (v - 1.0 / 24.0).abs() < 1e-15));
        assert!(norm(sub(g.cell_centre[0], [1.0 / 6.0, 0.25, 0.125])) < 1e-15);
        // A tetrahedron: volume 1/6, centroid at a quarter of each edge.
        let g = Geometry::new(&shapes::tetrahedron());
        assert!((g.volume[0] - 1.0 / 6.0).abs() < 1e-15);
        assert!(norm(sub(g.cell_centre[0], [0.25; 3])) < 1e-15);
        // A flat-sided ring sector between r = 1 and 2 of half angle a: (4 - 1) tan(a) h.
        let a = 2.5f64.to_radians();
        let g = Geometry::new(&shapes::wedge_ring(1.0, 2.0, 0.5, 5, 2, a));
        let v: f64 = g.volume.iter().sum();
        assert!((v / (1.5 * a.tan()) - 1.0).abs() < 1e-13);
        assert!(g.cell_centre.iter().all(|c| c[1].abs() < 1e-15));
    }

    #[test]
    fn a_sliver_far_from_the_origin_keeps_its_centroid() {
        let o = 1e6;
        let c = [[o, o, o], [o + 1.0, o, o], [o + 1.0, o + 1.0, o], [o, o + 1.0, o]];
        let (centre, _) = face_geometry(&c);
        assert!(norm(sub(centre, [o + 0.5, o + 0.5, o])) < 1e-9);
    }
}
