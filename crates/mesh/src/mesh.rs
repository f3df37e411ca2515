//! The numerics' view of a mesh.

use crate::polymesh::PatchKind;
use granflow_base::{Tensor, Vec3};
use granflow_par::Halo;
use std::ops::Range;
use std::sync::Arc;

/// Skewness, over the distance between cells, that is worth a correction: what is left out below
/// is a thousandth of the difference between neighbours.
const SKEWED: f64 = 1e-3;

/// Topology and geometry as plain contiguous arrays.
///
/// Faces: inner faces first, then boundary faces, contiguous per patch. An inner face has two
/// cells; behind a coupled face (cyclic, wedge, processor) the neighbour is a ghost, numbered
/// from `n_cells` on. Ghost values are filled by `halo`; ghosts have no faces of their own. Faces of
/// empty patches are not there at all: nothing passes them, and of the six faces of a cell they are two.
#[derive(Clone)]
pub struct Mesh {
    /// Number of cells this rank owns.
    pub n_cells: usize,
    /// Number of ghost cells, at the tail of every cell array.
    pub n_ghosts: usize,
    /// Number of inner faces, coupled ones included.
    pub n_inner: usize,
    /// Cell each face's area vector leaves; always an owned cell.
    pub owner: Vec<u32>,
    /// Cell each inner face's area vector enters; a ghost if `>= n_cells`. Length `n_inner`.
    pub neighbour: Vec<u32>,
    /// Area vectors, from owner to neighbour or outwards, m2.
    pub area: Vec<Vec3>,
    /// Lengths of `area`, m2.
    pub mag_area: Vec<f64>,
    /// Face centroids, m.
    pub face_centre: Vec<Vec3>,
    /// Inner: owner centre to neighbour centre, a ghost's taken as the image beside the face.
    /// Boundary: owner centre to face centre. m.
    pub delta: Vec<Vec3>,
    /// `1/(n . delta)`, 1/m; `n . delta` is kept above 5 % of the length of `delta`.
    pub inv_dist: Vec<f64>,
    /// Linear interpolation weight of the owner, inner faces only.
    pub weight: Vec<f64>,
    /// `n - delta * inv_dist`, the non-orthogonal correction vector; null on boundary faces.
    pub nonorth: Vec<Vec3>,
    /// Face centre minus the point where `delta` pierces the face plane, inner faces only, m.
    pub skew: Vec<Vec3>,
    /// Cell centroids, ghosts included (at their image position), m.
    pub cell_centre: Vec<Vec3>,
    /// Cell volumes, ghosts included, m3.
    pub volume: Vec<f64>,
    /// All patches of the undecomposed mesh, in its order, perhaps without faces on this rank.
    pub patches: Vec<Patch>,
    /// Fills the ghosts of a cell array.
    pub halo: Arc<Halo>,
    /// Start of every owned cell in `cell_faces`, and the end of the last one.
    pub cell_ptr: Vec<u32>,
    /// Faces of the cells: `face << 1`, plus 1 when the cell is the face's neighbour.
    pub cell_faces: Vec<u32>,
    /// Face of the undecomposed `PolyMesh` behind each face: `face << 1`, plus 1 when flipped.
    pub poly_face: Vec<u32>,
    /// Cell of the undecomposed mesh behind each owned cell.
    pub global_cell: Vec<u32>,
    /// False along an axis that empty patches take out of the problem.
    pub solved_dirs: [bool; 3],
    /// Where the mesh begins and ends along those axes, m; without end along the others.
    pub extent: [[f64; 2]; 3],
    /// Greatest angle between `delta` and the normal of an inner face of the whole mesh, degrees.
    pub max_nonorth_deg: f64,
    /// Greatest length of `skew` over the distance between the cells, of the inner faces of the
    /// whole mesh that are not on a wedge.
    pub max_skew: f64,
}

/// A boundary patch of a [`Mesh`].
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Name, as boundary conditions refer to it.
    pub name: String,
    /// Geometric kind.
    pub kind: PatchKind,
    /// Its boundary faces; none for coupled and empty patches.
    pub faces: Range<usize>,
    /// Its inner faces, in patch order, when it is coupled; else empty.
    pub coupled_faces: Vec<u32>,
    /// Groups the patch belongs to.
    pub in_groups: Vec<String>,
}

impl Mesh {
    /// Number of faces.
    pub fn n_faces(&self) -> usize {
        self.owner.len()
    }
    /// Faces of an owned cell, with +1 where the area vector leaves the cell, else -1.
    #[inline]
    pub fn faces_of(&self, c: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.cell_faces[self.cell_ptr[c] as usize..self.cell_ptr[c + 1] as usize]
            .iter()
            .map(|&e| ((e >> 1) as usize, if e & 1 == 0 { 1.0 } else { -1.0 }))
    }
    /// Index of the patch called `name`.
    pub fn patch(&self, name: &str) -> Option<usize> {
        self.patches.iter().position(|p| p.name == name)
    }
    /// Unit normal of a face, from owner to neighbour or outwards.
    #[inline]
    pub fn normal(&self, f: usize) -> Vec3 {
        let k = 1.0 / self.mag_area[f];
        self.area[f].map(|a| a * k)
    }
    /// Whether faces lie so far off the lines of centres that interpolation to them needs a
    /// gradient. A property of the whole mesh: all ranks agree.
    pub fn is_skewed(&self) -> bool {
        self.max_skew > SKEWED
    }
    /// The same mesh as if every inner face's centre lay on the line between its cells, and every boundary
    /// face's on the normal from its cell.
    #[must_use]
    pub fn without_skewness(&self) -> Mesh {
        let mut mesh = self.clone();
        mesh.skew.fill([0.0; 3]);
        mesh.max_skew = 0.0;
        mesh.nonorth[self.n_inner..].fill([0.0; 3]);
        mesh
    }
    /// A sum of dyads of the faces of a cell, with 1 along the axes that are not solved for, where
    /// there are no faces: fit to be inverted.
    #[must_use]
    pub fn fit_to_invert(&self, mut sum: Tensor) -> Tensor {
        (0..3).filter(|&k| !self.solved_dirs[k]).for_each(|k| sum[4 * k] += 1.0);
        sum
    }
    /// Side of the cube as large as a cell, of the square where one direction is not solved for, m.
    pub fn cell_size(&self, c: usize) -> f64 {
        let flat = self.extent.iter().filter(|[lo, _]| lo.is_finite());
        let (taken, thickness) = flat.fold((0, 1.0), |(n, t), [lo, hi]| (n + 1, t * (hi - lo)));
        let measure = self.volume[c] / thickness;
        match taken {
            0 => measure.cbrt(),
            1 => measure.sqrt(),
            _ => measure,
        }
    }
    /// Length of a cell array with ghosts.
    pub fn n_all(&self) -> usize {
        self.n_cells + self.n_ghosts
    }
}
