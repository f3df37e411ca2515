//! Which cells a sum goes over: all, or those of a zone.

use super::Around;
use granflow_dict::{Dict, Reader, Sink};
use granflow_mesh::Mesh;

/// All cells, or those of a zone or set.
#[derive(Clone)]
pub(super) struct CellRegion {
    /// `cellZone` or `cellSet` with its name; `None` for all cells.
    pub(super) zone: Option<(&'static str, String)>,
    /// The function's dictionary, for complaints once the mesh is known.
    dict: Dict,
    /// The zone's cells in the user's numbering, ascending.
    cells: Vec<u32>,
}

impl CellRegion {
    /// Reads `regionType` and `name`.
    pub(super) fn read(r: &Reader<'_>) -> CellRegion {
        let kinds = [("all", None), ("cellZone", Some("cellZone")), ("cellSet", Some("cellSet"))];
        let zone =
            r.opt_one_of("regionType", &kinds, None).map(|kind| (kind, r.word("name").to_owned()));
        if zone.is_none() {
            r.ignore("name");
        }
        CellRegion { zone, dict: r.dict().clone(), cells: Vec::new() }
    }

    /// Finds the cells of the zone.
    pub(super) fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        if self.zone.as_ref().is_some_and(|z| !z.1.is_empty()) {
            self.cells = around.zones.filled(&Reader::new(&self.dict, sink), "name");
        }
    }

    /// The cells of `mesh` among them.
    pub(super) fn cells(&self, mesh: &Mesh) -> Vec<usize> {
        let inside = |c: &usize| {
            self.zone.is_none() || self.cells.binary_search(&mesh.global_cell[*c]).is_ok()
        };
        (0..mesh.n_cells).filter(inside).collect()
    }
}
