//! Order of the faces of cyclic pairs.

use crate::polymesh::PolyMesh;

/// Brings the faces of the second half of every cyclic pair into the order of the first.
pub(super) fn order_cyclics(_poly: &mut PolyMesh) {}
