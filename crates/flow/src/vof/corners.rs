//! Points and flat facets of a mesh's faces: what geometric methods need beyond [`Mesh`].

use granflow_base::{Vec3, add, cross, dot, norm, scale, sub};
use granflow_mesh::{Mesh, PatchKind, PolyMesh};
use std::ops::Range;

/// A face counts as flat when no corner leaves its plane by more than this share of its size.
const FLAT: f64 = 1e-9;

/// The corners of every face. A face that is not flat is split into triangles about the average
/// of its corners, as [`granflow_mesh::Geometry`] does.
#[derive(Clone, Debug)]
pub struct Corners {
    /// Points of the undecomposed mesh, then the middle points of warped faces, m.
    pub points: Vec<Vec3>,
    /// First facet of every face, and one past the last.
    face_facets: Vec<u32>,
    /// Start of every facet in `facet_points`, and the end of the last one.
    facet_start: Vec<u32>,
    facet_points: Vec<u32>,
    /// Start of every cell in the faces that lie on empty patches, which follow those of the mesh.
    empty_start: Vec<u32>,
    /// Most points, facet corners and facets of one cell.
    pub(crate) largest_cell: [usize; 3],
}

impl Corners {
    /// The corners of `mesh`, which was made from `poly` (or is a part of that mesh).
    pub fn new(poly: &PolyMesh, mesh: &Mesh) -> Corners {
        let mut corners = Corners {
            points: poly.points.clone(),
            face_facets: vec![0],
            facet_start: vec![0],
            facet_points: Vec::new(),
            empty_start: Vec::new(),
            largest_cell: [0; 3],
        };
        let mut ring = Vec::new();
        for &e in &mesh.poly_face {
            ring.clear();
            ring.extend_from_slice(poly.face((e >> 1) as usize));
            if e & 1 == 1 {
                ring.reverse();
            }
            corners.push_face(&ring);
        }
        for faces in &empty_faces(poly, mesh) {
            corners.empty_start.push(corners.face_facets.len() as u32 - 1);
            faces.iter().for_each(|&f| corners.push_face(poly.face(f as usize)));
        }
        corners.empty_start.push(corners.face_facets.len() as u32 - 1);
        for c in 0..mesh.n_cells {
            let (mut n_ring, mut n_facets) = (0, 0);
            for (f, _) in corners.faces_of(mesh, c) {
                n_facets += corners.facets_of(f).len();
                n_ring += corners.facets_of(f).map(|k| corners.facet(k).len()).sum::<usize>();
            }
            // Every edge has two facets: there are no more points than half the facet corners.
            let most = [n_ring.div_ceil(2) + 1, n_ring, n_facets];
            (0..3).for_each(|i| corners.largest_cell[i] = corners.largest_cell[i].max(most[i]));
        }
        corners
    }

    fn push_face(&mut self, ring: &[u32]) {
        let at = |i: usize| self.points[ring[i % ring.len()] as usize];
        let n = ring.len();
        let mid = scale((0..n).map(at).fold([0.0; 3], add), 1.0 / n as f64);
        let spoke = |i: usize| sub(at(i), mid);
        let area = (0..n).map(|i| cross(spoke(i), spoke(i + 1))).fold([0.0; 3], add);
        let size = (0..n).map(|i| norm(spoke(i))).fold(0.0, f64::max);
        let off = (0..n).map(|i| dot(spoke(i), area).abs()).fold(0.0, f64::max);
        if n == 3 || off <= FLAT * size * norm(area) {
            self.push_facet(ring);
        } else {
            let middle = self.points.len() as u32;
            self.points.push(mid);
            (0..n).for_each(|i| self.push_facet(&[ring[i], ring[(i + 1) % n], middle]));
        }
        self.face_facets.push(self.facet_start.len() as u32 - 1);
    }

    fn push_facet(&mut self, ring: &[u32]) {
        self.facet_points.extend_from_slice(ring);
        self.facet_start.push(self.facet_points.len() as u32);
    }

    /// All faces of a cell as [`Mesh::faces_of`], and those on empty patches after them.
    pub fn faces_of<'a>(
        &self,
        mesh: &'a Mesh,
        c: usize,
    ) -> impl Iterator<Item = (usize, f64)> + use<'a> {
        let empty = self.empty_start[c] as usize..self.empty_start[c + 1] as usize;
        mesh.faces_of(c).chain(empty.map(|f| (f, 1.0)))
    }
    /// Facets of face `f` of [`Self::faces_of`].
    #[inline]
    pub fn facets_of(&self, f: usize) -> Range<usize> {
        self.face_facets[f] as usize..self.face_facets[f + 1] as usize
    }
    /// Points of facet `k`, turning so that its area vector leaves the face's owner.
    #[inline]
    pub fn facet(&self, k: usize) -> &[u32] {
        &self.facet_points[self.facet_start[k] as usize..self.facet_start[k + 1] as usize]
    }
}

/// Faces of `poly` on empty patches, for each cell of `mesh`.
fn empty_faces(poly: &PolyMesh, mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut of_cell = vec![Vec::new(); mesh.n_cells];
    let mut here = vec![u32::MAX; poly.n_cells()];
    for (c, &whole) in mesh.global_cell.iter().enumerate() {
        here[whole as usize] = c as u32;
    }
    for p in poly.patches.iter().filter(|p| p.kind == PatchKind::Empty) {
        for f in p.faces() {
            if let Some(faces) = of_cell.get_mut(here[poly.owner[f] as usize] as usize) {
                faces.push(f as u32);
            }
        }
    }
    of_cell
}
