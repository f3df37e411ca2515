//! The mesh of a case: from `constant/polyMesh`, made from `system/blockMeshDict`, or imported.
//!
//! Inside, cells are numbered for short strides (reverse Cuthill-McKee) where that helps; files
//! always hold the user's numbering. [`Mesh::global_cell`] and [`Mesh::poly_face`] of what
//! [`prepare`] returns say which cell and face of the user's mesh stands behind each.

use crate::store::{Compression, DirWriter};
use crate::{CaseError, files};
use granflow_dict::{Diag, Format, Sink};
use granflow_mesh::import::{self, Imported, Options};
use granflow_mesh::poly_io::{self, CELL_ZONES, FILES, PolyFiles};
use granflow_mesh::{Mesh, MeshError, PolyMesh, block, renumber};
use std::path::Path;

/// Folder of the mesh in a case.
pub const POLY_MESH: &str = "constant/polyMesh";
/// What a mesh is made from.
pub const BLOCK_MESH: &str = "system/blockMeshDict";

/// A mesh in the user's numbering.
pub struct Loaded {
    /// The mesh.
    pub poly: PolyMesh,
    /// Whether it was made from `blockMeshDict` just now and is not on the disk yet.
    pub made: bool,
}

/// Reads `constant/polyMesh`, or makes the mesh from `blockMeshDict` when there is none. Writes
/// nothing.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink, or a file cannot be read.
pub fn load(root: &Path, sink: &Sink) -> Result<Loaded, CaseError> {
    let mut sources = Vec::with_capacity(FILES.len());
    for name in FILES {
        sources.push(files::source(root, format!("{POLY_MESH}/{name}"))?);
    }
    if sources.iter().all(Option::is_none) {
        return Ok(Loaded { poly: from_blocks(root, sink)?, made: true });
    }
    for (name, _) in FILES.iter().zip(&sources).filter(|(_, s)| s.is_none()) {
        let path = root.join(POLY_MESH).join(name).display().to_string();
        let d = Diag::file(path, "this file of the mesh is missing");
        sink.push(d.help("a mesh has the files points, faces, owner, neighbour, boundary"));
    }
    let mut it = sources.into_iter().flatten();
    let (Some(points), Some(faces), Some(owner), Some(neighbour), Some(boundary)) =
        (it.next(), it.next(), it.next(), it.next(), it.next())
    else {
        return Err(CaseError::Invalid);
    };
    match poly_io::read(&PolyFiles { points, faces, owner, neighbour, boundary }) {
        Ok(read) => {
            sink.extend(read.warnings);
            Ok(Loaded { poly: read.mesh, made: false })
        }
        Err(diags) => {
            sink.extend(diags);
            Err(CaseError::Invalid)
        }
    }
}

/// Makes the mesh of `system/blockMeshDict` and writes `constant/polyMesh`, replacing what is
/// there; the files beside the mesh's own stay.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink, or the disk refuses.
pub fn make(root: &Path, sink: &Sink) -> Result<PolyMesh, CaseError> {
    let poly = from_blocks(root, sink)?;
    write(root, &poly, Format::Ascii, Compression::Plain)?;
    Ok(poly)
}

/// Reads a mesh of another program and writes `constant/polyMesh`, as [`make`] does.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink, or the disk refuses.
pub fn import(
    root: &Path,
    file: &Path,
    options: &Options,
    sink: &Sink,
) -> Result<Imported, CaseError> {
    if file.is_dir() {
        let message = "this is a directory, not the file of a mesh";
        let d = Diag::file(file.display().to_string(), message);
        sink.push(d.help("name a .msh or .vtu file"));
        return Err(CaseError::Invalid);
    }
    let Some(src) = files::source(Path::new(""), file)? else {
        let d = Diag::file(file.display().to_string(), "there is no such file");
        sink.push(d);
        return Err(CaseError::Invalid);
    };
    let imported = import::read(&src, options).map_err(|diags| {
        sink.extend(diags);
        CaseError::Invalid
    })?;
    write(root, &imported.mesh, Format::Ascii, Compression::Plain)?;
    Ok(imported)
}

/// Writes `constant/polyMesh`, whole or not at all.
///
/// # Errors
/// The disk refuses.
pub fn write(
    root: &Path,
    poly: &PolyMesh,
    format: Format,
    compression: Compression,
) -> Result<(), CaseError> {
    let target = root.join(POLY_MESH);
    let mut dir = DirWriter::begin(&target)?.keep_existing()?.compressed(compression);
    // Sets of the mesh before, and addresses that tools keep, fit this one no more.
    for stale in [CELL_ZONES, "faceZones", "pointZones", "meshModifiers", "cellLevel", "pointLevel"]
    {
        dir.remove(stale)?;
    }
    for (name, bytes) in poly_io::write(poly, format) {
        match name {
            "boundary" | CELL_ZONES => dir.file_plain(name, &bytes)?,
            _ => dir.file(name, &bytes)?,
        }
    }
    dir.commit()?;
    Ok(())
}

/// The mesh of `blockMeshDict`.
fn from_blocks(root: &Path, sink: &Sink) -> Result<PolyMesh, CaseError> {
    let own = Sink::new();
    let made = blocks_of(root, &own);
    // A dictionary that lacks an include may still look complete.
    let broken = own.has_errors();
    sink.extend(own.take());
    if broken { Err(CaseError::Invalid) } else { made }
}

fn blocks_of(root: &Path, sink: &Sink) -> Result<PolyMesh, CaseError> {
    let mut found = files::dict(root, BLOCK_MESH, sink)?;
    if found.is_none() {
        found = files::dict(root, "constant/polyMesh/blockMeshDict", sink)?;
    }
    let Some(dict) = found else {
        let path = root.join(POLY_MESH).display().to_string();
        let d = Diag::file(path, "the case has no mesh");
        sink.push(d.help("add system/blockMeshDict, or the files of a mesh in constant/polyMesh"));
        return Err(CaseError::Invalid);
    };
    let report = |diags: Vec<Diag>| {
        sink.extend(diags);
        CaseError::Invalid
    };
    let mut blocks = block::read(&dict).map_err(report)?;
    sink.extend(std::mem::take(&mut blocks.warnings));
    blocks.generate().map_err(report)
}

/// The numerics' view of a mesh, its cells renumbered where that shortens strides.
///
/// # Errors
/// As [`Mesh::new`].
pub fn prepare(poly: &PolyMesh) -> Result<Mesh, MeshError> {
    poly.validate()?;
    let (tidy, map) = renumber(poly);
    if stride(&tidy) >= stride(poly) {
        return Mesh::new(poly);
    }
    let mut mesh = Mesh::new(&tidy)?;
    for cell in &mut mesh.global_cell {
        *cell = map.cells[*cell as usize];
    }
    for face in &mut mesh.poly_face {
        *face = map.faces[(*face >> 1) as usize] ^ (*face & 1);
    }
    Ok(mesh)
}

/// Greatest, then total distance in memory between neighbours.
fn stride(poly: &PolyMesh) -> (u32, u64) {
    let jumps = poly.neighbour.iter().zip(&poly.owner).map(|(n, o)| n.abs_diff(*o));
    jumps.fold((0, 0), |(most, sum), j| (most.max(j), sum + u64::from(j)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::{Geometry, shapes};

    #[test]
    fn renumbered_meshes_remember_the_users_numbers() {
        let messy = shapes::shuffled(&shapes::unit_box([6, 5, 4]), 3);
        let mesh = prepare(&messy).unwrap();
        assert_ne!(mesh.global_cell, (0..120).collect::<Vec<u32>>(), "it was worth renumbering");
        let g = Geometry::new(&messy);
        for (c, &user) in mesh.global_cell.iter().enumerate() {
            let off = granflow_base::sub(mesh.cell_centre[c], g.cell_centre[user as usize]);
            assert!(granflow_base::norm(off) < 1e-14);
        }
        for (f, &e) in mesh.poly_face.iter().enumerate() {
            let sign = if e & 1 == 0 { 1.0 } else { -1.0 };
            let user = g.area[(e >> 1) as usize];
            assert!((0..3).all(|k| (mesh.area[f][k] - sign * user[k]).abs() < 1e-14));
        }
        let tidy = prepare(&shapes::unit_box([20, 1, 1])).unwrap();
        assert!(tidy.global_cell.is_sorted(), "a good numbering is left alone");
    }
}
