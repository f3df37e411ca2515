//! Block-structured meshes as OpenFOAM's `blockMeshDict` describes them.
//!
//! [`read`] turns a dictionary into a [`BlockMesh`], [`BlockMesh::generate`] makes the
//! [`PolyMesh`], with points, cells and faces in the order in which OpenFOAM's own tool numbers
//! them, so that fields and face sets written for the one fit the other.

mod curve;
mod generate;
mod grading;
mod merge;
mod names;
mod points;
mod read;
mod read_edges;
mod read_patches;
mod topology;

pub use curve::Curve;
pub use grading::{Section, divide};
pub use read::read;

use crate::polymesh::{PatchKind, PolyMesh};
use granflow_base::Vec3;
use granflow_dict::{Diag, Span};

/// A mesh of hexahedral blocks, not yet divided into cells.
#[derive(Clone)]
pub struct BlockMesh {
    /// Corners of the blocks, m.
    pub vertices: Vec<Vec3>,
    /// The blocks.
    pub blocks: Vec<Block>,
    /// Curved edges between vertices.
    pub edges: Vec<Edge>,
    /// Boundary patches in their order.
    pub patches: Vec<BlockPatch>,
    /// Name and kind of the patch of all faces that no patch names.
    pub default_patch: (String, PatchKind),
    /// Pairs of patches to be merged into inner faces, in their order.
    pub merges: Vec<Merge>,
    /// Where the dictionary ends; diagnostics that concern the whole mesh point here.
    pub whole: Span,
    /// What is odd but does no harm.
    pub warnings: Vec<Diag>,
}

/// What to do instead of a projection.
const HELP_PROJECT: &str = "projection onto surfaces is not supported: use arc, polyLine, spline or \
                            BSpline edges, or import the mesh (`granflow mesh --from FILE`)";

/// Two patches whose faces lie on each other without matching one to one.
#[derive(Clone)]
pub struct Merge {
    /// Number of the patch whose points and edges count where both have some.
    pub first: usize,
    /// Number of the patch that is fitted to it.
    pub second: usize,
    /// Where the pair was written.
    pub span: Span,
}

/// One block: a hexahedron divided into `cells[0] * cells[1] * cells[2]` cells.
#[derive(Clone)]
pub struct Block {
    /// Its corners: four about the third direction, then the four above them. Corners may
    /// coincide: the block is then a wedge or a prism.
    pub vertices: [u32; 8],
    /// Number of cells along its three directions.
    pub cells: [usize; 3],
    /// Grading of the twelve edges, in the order of [`EDGES`].
    pub grading: [Vec<Section>; 12],
    /// Name of the cell zone.
    pub zone: Option<String>,
    /// Where it was written.
    pub span: Span,
}

/// The twelve edges of a block, each along its direction: four along the first direction, four
/// along the second, four along the third.
pub const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [3, 2],
    [7, 6],
    [4, 5],
    [0, 3],
    [1, 2],
    [5, 6],
    [4, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// The six faces of a block as corners, turning counter-clockwise seen from outside: low and
/// high side of the first, second and third direction.
pub const FACES: [[usize; 4]; 6] =
    [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]];

/// Corner `v` of a block in index space: 0 or 1 along each direction.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// A curved edge from vertex `ends[0]` to `ends[1]`.
#[derive(Clone)]
pub struct Edge {
    /// Its vertices.
    pub ends: [u32; 2],
    /// Its course between them.
    pub curve: Curve,
    /// Where it was written.
    pub span: Span,
}

/// A patch and the block faces it covers.
#[derive(Clone)]
pub struct BlockPatch {
    /// Name.
    pub name: String,
    /// Geometric kind.
    pub kind: PatchKind,
    /// Block faces by their vertices, and where each was written.
    pub faces: Vec<([u32; 4], Span)>,
    /// Groups the patch belongs to.
    pub in_groups: Vec<String>,
    /// Where it was written.
    pub span: Span,
}

impl BlockMesh {
    /// Divides the blocks into cells and puts them together.
    ///
    /// # Errors
    /// Everything that is wrong with the blocks: corners that do not exist, inverted blocks, faces
    /// that do not fit each other, patches on faces inside the mesh.
    pub fn generate(&self) -> Result<PolyMesh, Vec<Diag>> {
        let topology = topology::connect(self)?;
        merge::merge(self, generate::generate(self, &topology)?)
    }
}

impl Block {
    /// Points along each direction.
    fn n_points(&self) -> [usize; 3] {
        self.cells.map(|n| n + 1)
    }
    /// Index of point `(i, j, k)` among the block's points.
    fn point(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.n_points();
        (k * ny + j) * nx + i
    }
    /// Index of cell `(i, j, k)` among the block's cells.
    fn cell(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.cells[1] + j) * self.cells[0] + i
    }
    fn n_cells(&self) -> usize {
        self.cells.iter().product()
    }
    /// Vertices of side `s`, in the order of [`FACES`].
    fn side(&self, s: usize) -> [u32; 4] {
        FACES[s].map(|v| self.vertices[v])
    }
}
