//! The cells that a mesh check found fault with, as a file to be looked at.

use crate::CaseError;
use crate::export::mesh_file;
use crate::store::DirWriter;
use granflow_mesh::check::{CheckReport, Severity};
use granflow_mesh::{PolyMesh, subset};
use std::path::Path;

/// Folder of the file.
const FOLDER: &str = "postProcessing/checkMesh";
/// The file.
pub const BAD_CELLS: &str = "postProcessing/checkMesh/badCells.vtu";

/// Writes [`BAD_CELLS`]: the cells that warnings and errors name, with an array `cell` of their
/// numbers and one for each finding, 1 where it holds. Without such cells nothing is written, and
/// what an earlier check left is taken away. Returns the number of cells.
///
/// # Errors
/// The disk refuses.
pub fn write(root: &Path, poly: &PolyMesh, report: &CheckReport) -> Result<usize, CaseError> {
    let cells = report.bad_cells();
    if cells.is_empty() {
        if root.join(BAD_CELLS).is_file() {
            let mut dir = DirWriter::begin(&root.join(FOLDER))?.keep_existing()?;
            dir.remove("badCells.vtu")?;
            dir.commit()?;
        }
        return Ok(0);
    }
    let mut arrays = vec![("cell".to_owned(), cells.iter().map(|&c| f64::from(c)).collect())];
    for finding in &report.findings {
        if finding.severity >= Severity::Warning && !finding.cells.is_empty() {
            let has = |c: &u32| f64::from(u8::from(finding.cells.binary_search(c).is_ok()));
            arrays.push((finding.name.to_owned(), cells.iter().map(has).collect()));
        }
    }
    let mut dir = DirWriter::begin(&root.join(FOLDER))?.keep_existing()?;
    dir.file_plain("badCells.vtu", &mesh_file(&subset(poly, &cells), arrays))?;
    dir.commit()?;
    Ok(cells.len())
}
