//! Is a mesh sound, and how good is it?

mod figures;
mod quality;
mod report;
mod shape;
mod topology;

pub use report::{CellShapes, CheckReport, Finding, PatchSummary, Place, Quality, Severity};

use crate::geometry::Geometry;
use crate::mesh::Mesh;
use crate::polymesh::{MeshError, PolyMesh};

/// Of a place whose cells [`Worst::add`] fills in, or that is a cell itself.
const NO_CELLS: (Option<u32>, Option<u32>) = (None, None);

/// How many places a finding lists.
const LISTED: usize = 5;

/// Checks topology, then geometry, and reports every finding with its worst places.
pub fn check(poly: &PolyMesh) -> CheckReport {
    let mut report = CheckReport::default();
    // Without sound indices nothing else can be worked out.
    if let Err(e) = poly.validate() {
        report.findings.push(Finding::whole(
            Severity::Error,
            e.to_string(),
            "the polyMesh files do not belong together or are damaged: make the mesh again",
        ));
        return report;
    }
    let g = Geometry::new(poly);
    let links = poly.cell_faces();
    topology::check(poly, &g, &links, &mut report);
    quality::check(poly, &g, &links, &mut report);
    shape::check(poly, &g, &links, &mut report);
    figures::check(poly, &g, &links, &mut report);
    if let Err(e) = Mesh::new(poly) {
        let remedy = match e {
            // Already reported with all their places.
            MeshError::Volume { .. } | MeshError::Area { .. } => return report,
            MeshError::Empty { .. }
                if report.findings.iter().any(|f| f.message.contains("empty")) =>
            {
                return report;
            }
            MeshError::CyclicPair { .. } | MeshError::CyclicMatch { .. } => {
                "periodic patches must match face by face, by a translation or a rotation"
            }
            MeshError::Wedge { .. } => {
                "make the wedge one cell thick between two planes that meet in the axis"
            }
            MeshError::Empty { .. } => "align the plane of a two-dimensional mesh with x, y or z",
            _ => "make the mesh again",
        };
        report.findings.push(Finding::whole(Severity::Error, e.to_string(), remedy));
    }
    report
}

/// Collects the worst places of one kind of fault.
struct Worst {
    count: usize,
    places: Vec<Place>,
    cells: Vec<u32>,
}

impl Worst {
    fn new() -> Worst {
        Worst { count: 0, places: Vec::new(), cells: Vec::new() }
    }
    /// Keeps the greatest values, and all the cells that have the fault.
    fn add(&mut self, mut place: Place, cells: &[u32]) {
        if place.what == "face" {
            place.cells = (cells.first().copied(), cells.get(1).copied());
        }
        self.count += 1;
        self.cells.extend_from_slice(cells);
        let at = self.places.partition_point(|p| p.value >= place.value);
        if at < LISTED {
            self.places.insert(at, place);
            self.places.truncate(LISTED);
        }
    }
    /// Of places that were added with their values negated, so that the least are listed.
    fn of_least(mut self) -> Worst {
        self.places.iter_mut().for_each(|p| p.value = -p.value);
        self
    }
    fn report(
        mut self,
        report: &mut CheckReport,
        name: &'static str,
        severity: Severity,
        what: &str,
        remedy: &str,
    ) {
        self.cells.sort_unstable();
        self.cells.dedup();
        if self.count > 0 {
            report.findings.push(Finding {
                name,
                severity,
                message: format!("{what}: {}", self.count),
                count: self.count,
                places: self.places,
                cells: self.cells,
                remedy: remedy.into(),
            });
        }
    }
}
