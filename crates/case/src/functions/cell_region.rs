//! Which cells a sum goes over: all, or those of a zone.

use super::Around;
use granflow_dict::{Diag, Reader, Sink, Span, nearest};
use granflow_mesh::Mesh;

/// All cells, or those of a zone or set.
#[derive(Clone)]
pub(super) struct CellRegion {
    /// `cellZone` or `cellSet` with its name; `None` for all cells.
    pub(super) zone: Option<(&'static str, String)>,
    span: Span,
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
        CellRegion { zone, span: r.value_span("name"), cells: Vec::new() }
    }

    /// Finds the cells of the zone.
    pub(super) fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        let Some((kind, name)) = self.zone.as_ref().filter(|z| !z.1.is_empty()) else { return };
        if let Some(cells) = around.zones.get(name) {
            self.cells = cells.to_vec();
            if cells.is_empty() {
                let message = format!("the {kind} `{name}` has no cells");
                sink.push(Diag::error(&self.span, message).label("empty"));
            }
            return;
        }
        let known: Vec<&str> = around.zones.names().collect();
        let help = match (nearest(name, known.iter().copied()), known.is_empty()) {
            (Some(near), _) => format!("did you mean `{near}`?"),
            (None, true) => "give it in constant/polyMesh/cellZones or system/topoSetDict".into(),
            (None, false) => format!("there are {}", known.join(", ")),
        };
        sink.push(
            Diag::error(&self.span, format!("no {kind} `{name}`")).label("not known").help(help),
        );
    }

    /// The cells of `mesh` among them.
    pub(super) fn cells(&self, mesh: &Mesh) -> Vec<usize> {
        let inside = |c: &usize| {
            self.zone.is_none() || self.cells.binary_search(&mesh.global_cell[*c]).is_ok()
        };
        (0..mesh.n_cells).filter(inside).collect()
    }
}
