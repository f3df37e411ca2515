//! Cells in VTK's terms: hexahedra, wedges, pyramids and tetrahedra where their faces say so, else
//! polyhedra.

use granflow_mesh::PolyMesh;

/// VTK's numbers of the shapes.
const TETRAHEDRON: u8 = 10;
const HEXAHEDRON: u8 = 12;
const WEDGE: u8 = 13;
const PYRAMID: u8 = 14;
const POLYHEDRON: u8 = 42;

/// The arrays of `<Cells>`.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// Points of all cells, one after the other.
    pub(super) connectivity: Vec<i64>,
    /// End of each cell in `connectivity`.
    pub(super) offsets: Vec<i64>,
    /// Shapes.
    pub(super) types: Vec<u8>,
    /// Of polyhedra: number of faces, then of each face the number of its points and the points.
    pub(super) faces: Vec<i64>,
    /// End of each cell in `faces`, -1 where it is no polyhedron; empty when none is.
    pub(super) face_offsets: Vec<i64>,
}

impl Cells {
    pub(super) fn new(poly: &PolyMesh) -> Cells {
        let (ptr, links) = poly.cell_faces();
        let mut out = Cells::default();
        for c in 0..poly.n_cells() {
            // Points of each face, turning counter-clockwise seen from outside the cell.
            let faces: Vec<Vec<u32>> = links[ptr[c] as usize..ptr[c + 1] as usize]
                .iter()
                .map(|&e| {
                    let mut face = poly.face((e >> 1) as usize).to_vec();
                    if e & 1 == 1 {
                        face.reverse();
                    }
                    face
                })
                .collect();
            match known_shape(&faces) {
                Some((shape, points)) => {
                    out.types.push(shape);
                    out.connectivity.extend(points.iter().map(|&p| i64::from(p)));
                    out.face_offsets.push(-1);
                }
                None => out.polyhedron(&faces),
            }
            out.offsets.push(out.connectivity.len() as i64);
        }
        if out.faces.is_empty() {
            out.face_offsets.clear();
        }
        out
    }

    fn polyhedron(&mut self, faces: &[Vec<u32>]) {
        let mut points: Vec<u32> = faces.concat();
        points.sort_unstable();
        points.dedup();
        self.types.push(POLYHEDRON);
        self.connectivity.extend(points.iter().map(|&p| i64::from(p)));
        self.faces.push(faces.len() as i64);
        for f in faces {
            self.faces.push(f.len() as i64);
            self.faces.extend(f.iter().map(|&p| i64::from(p)));
        }
        self.face_offsets.push(self.faces.len() as i64);
    }
}

/// The shape and its points in VTK's order, for cells that are one of the plain shapes.
fn known_shape(faces: &[Vec<u32>]) -> Option<(u8, Vec<u32>)> {
    let of = |n: usize| faces.iter().filter(|f| f.len() == n).count();
    let (shape, base) = match (faces.len(), of(3), of(4)) {
        (4, 4, 0) => (TETRAHEDRON, 3),
        (5, 4, 1) => (PYRAMID, 4),
        (5, 2, 3) => (WEDGE, 3),
        (6, 0, 6) => (HEXAHEDRON, 4),
        _ => return None,
    };
    // The base turns counter-clockwise seen from inside. (Of wedges VTK's drawings say the
    // opposite; its own checks and volumes, of version 9.6, do not.)
    let mut points = faces.iter().find(|f| f.len() == base)?.clone();
    points.reverse();
    let bottom = points.clone();
    match shape {
        TETRAHEDRON | PYRAMID => {
            let mut others = faces.iter().flatten().filter(|p| !bottom.contains(p));
            let apex = *others.next()?;
            if others.any(|p| *p != apex) {
                return None;
            }
            points.push(apex);
        }
        _ => {
            for p in &bottom {
                points.push(above(faces, &bottom, *p)?);
            }
            let mut top = points[base..].to_vec();
            top.sort_unstable();
            top.dedup();
            if top.len() != base {
                return None;
            }
        }
    }
    Some((shape, points))
}

/// The only point outside the base that an edge joins with `p`.
fn above(faces: &[Vec<u32>], base: &[u32], p: u32) -> Option<u32> {
    let mut found = None;
    for face in faces {
        let Some(i) = face.iter().position(|q| *q == p) else { continue };
        let n = face.len();
        for q in [face[(i + 1) % n], face[(i + n - 1) % n]] {
            if base.contains(&q) || found == Some(q) {
                continue;
            }
            if found.is_some() {
                return None;
            }
            found = Some(q);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_base::{Vec3, cross, dot, sub};
    use granflow_mesh::{PatchKind, shapes};

    fn corners(poly: &PolyMesh, cells: &Cells, c: usize) -> Vec<Vec3> {
        let end = cells.offsets[c] as usize;
        let start = if c == 0 { 0 } else { cells.offsets[c - 1] as usize };
        cells.connectivity[start..end].iter().map(|&p| poly.points[p as usize]).collect()
    }

    /// The normal of the first three points, dotted with the way to the last one.
    fn upward(x: &[Vec3]) -> f64 {
        let normal = cross(sub(x[1], x[0]), sub(x[2], x[0]));
        dot(normal, sub(x[x.len() - 1], x[0]))
    }

    #[test]
    fn bricks_are_hexahedra_whose_corners_lie_above_one_another() {
        let poly = shapes::unit_box([3, 2, 2]);
        let cells = Cells::new(&poly);
        assert!(cells.types.iter().all(|t| *t == HEXAHEDRON) && cells.faces.is_empty());
        for c in 0..12 {
            let x = corners(&poly, &cells, c);
            assert!(upward(&x) > 0.0);
            let up = sub(x[4], x[0]);
            assert!((1..4).all(|k| sub(x[k + 4], x[k]) == up), "{x:?}");
        }
    }

    #[test]
    fn prisms_and_tetrahedra_are_oriented_as_vtk_wants_them() {
        let kinds = [const { PatchKind::Wall }; 6];
        let poly = shapes::prism_box([2, 2, 1], [0.0; 3], [1.0; 3], kinds);
        let cells = Cells::new(&poly);
        assert!(cells.types.iter().all(|t| *t == WEDGE));
        assert!((0..poly.n_cells()).all(|c| upward(&corners(&poly, &cells, c)) > 0.0));
        let poly = shapes::tetrahedron();
        let cells = Cells::new(&poly);
        assert_eq!(cells.types, [TETRAHEDRON]);
        assert!(upward(&corners(&poly, &cells, 0)) > 0.0);
    }

    #[test]
    fn anything_else_is_a_polyhedron_with_its_faces() {
        // A cube whose top is split into two triangles.
        let top = [vec![4, 5, 6], vec![4, 6, 7]];
        let mut faces = shapes::hexahedron([0, 1, 2, 3, 4, 5, 6, 7]);
        faces.retain(|f| f.iter().any(|p| *p < 4));
        faces.extend(top);
        let mut cells = Cells::default();
        assert!(known_shape(&faces).is_none());
        cells.polyhedron(&faces);
        assert_eq!((cells.types[0], cells.connectivity.len()), (POLYHEDRON, 8));
        assert_eq!(cells.faces[0], 7);
        assert_eq!(cells.faces.len(), 1 + 7 + 5 * 4 + 2 * 3);
        assert_eq!(cells.face_offsets, [cells.faces.len() as i64]);
    }
}
