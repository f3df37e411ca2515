//! Meshes of other programs.
//!
//! A reader turns a file into elements: volumes, surfaces and lines by their points, in named groups.
//! From there all formats go the same way. Faces of volumes find each other by their points; what
//! is left over is the boundary, which surfaces of a group make a patch. A mesh without volumes is
//! made one cell thick first.

mod assemble;
mod elements;
mod extrude;
mod fluent;
mod gmsh;
mod patches;
mod vtu;

use crate::polymesh::PolyMesh;
use elements::Elements;
use granflow_dict::{Diag, Source, Span};
use std::sync::Arc;

/// What the user decides about an import.
#[derive(Clone, Debug)]
pub struct Options {
    /// Factor on all coordinates, for files that are not in metres.
    pub scale: f64,
    /// Thickness of a mesh made from a plane one, m; a tenth of its greatest extent by default.
    pub thickness: Option<f64>,
    /// Boundary faces that no group names are one patch; with an angle, degrees, they are split
    /// along edges where their normals turn by more.
    pub feature_angle: Option<f64>,
    /// Array of whole numbers on the cells of a VTU file that tells patches and zones apart.
    pub group_array: Option<String>,
}

impl Default for Options {
    fn default() -> Options {
        Options { scale: 1.0, thickness: None, feature_angle: None, group_array: None }
    }
}

/// A mesh that was read.
#[derive(Clone)]
pub struct Imported {
    /// The mesh; its topology is valid.
    pub mesh: PolyMesh,
    /// Name of the format.
    pub format: &'static str,
    /// What the user ought to know about it.
    pub notes: Vec<String>,
}

/// A format that can be read.
pub struct Importer {
    /// Its name.
    pub name: &'static str,
    /// Whether a file is of this format, by its first bytes.
    claims: fn(&[u8]) -> bool,
    read: fn(&Arc<Source>, &Options) -> Result<Elements, Vec<Diag>>,
}

/// The formats, in the order in which they are asked.
pub const ALL: &[Importer] = &[gmsh::IMPORTER, fluent::IMPORTER, vtu::IMPORTER];

/// Reads a mesh of any known format.
///
/// # Errors
/// What is wrong with the file, with its place.
pub fn read(src: &Arc<Source>, options: &Options) -> Result<Imported, Vec<Diag>> {
    let Some(importer) = ALL.iter().find(|i| (i.claims)(&src.text)) else {
        let known: Vec<&str> = ALL.iter().map(|i| i.name).collect();
        let d = Diag::error(&Span::new(src, 0..0), "this is no mesh of a known format");
        return Err(vec![d.help(format!("known formats are {}", known.join(", ")))]);
    };
    let mut elements = (importer.read)(src, options)?;
    let fault = |what: String| vec![Diag::error(&Span::new(src, 0..0), what)];
    elements.scale(options.scale);
    elements.check().map_err(fault)?;
    let mut notes = std::mem::take(&mut elements.notes);
    if elements.volumes.is_empty() {
        notes.push(extrude::extrude(&mut elements, options.thickness).map_err(fault)?);
    }
    let mesh = assemble::assemble(elements, options.feature_angle, &mut notes).map_err(fault)?;
    mesh.validate().map_err(|e| fault(e.to_string()))?;
    Ok(Imported { mesh, format: importer.name, notes })
}
