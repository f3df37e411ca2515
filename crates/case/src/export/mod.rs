//! Times of a case as VTK files: one `.vtu` a time with the fields on cells, and a `.pvd` that
//! lists them.

mod arrays;
mod cells;
pub(crate) mod poly_data;
mod vtu;

use crate::functions::field_values;
use crate::store::{DirWriter, Operation, StoreError, list_times};
use crate::{CaseError, files, meshing};
use arrays::Array;
use granflow_base::{Tensor, Value, Vec3};
use granflow_dict::{Diag, Dict, Reader, Sink};
use granflow_mesh::PolyMesh;
use std::fs;
use std::path::{Path, PathBuf};
use vtu::Grid;

/// Folder of the exported files in a case.
pub const VTK: &str = "VTK";
/// The file that lists the times.
pub const COLLECTION: &str = "VTK/case.pvd";

/// What was exported.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Names of the times, in order.
    pub times: Vec<String>,
    /// Names of the fields that are in any of them.
    pub fields: Vec<String>,
}

/// Writes `VTK/<time>.vtu` for every time directory and `VTK/case.pvd`: all of them, or nothing.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink, or the disk refuses.
pub fn export(root: &Path, sink: &Sink) -> Result<Exported, CaseError> {
    let loaded = meshing::load(root, sink)?;
    let poly = loaded.poly;
    if let Err(e) = poly.validate() {
        let path = root.join(meshing::POLY_MESH).display().to_string();
        sink.push(Diag::file(path, e.to_string()).help("`granflow check` says more"));
        return Err(CaseError::Invalid);
    }
    let times = list_times(root)?;
    if times.is_empty() {
        let d = Diag::file(root.join("0").display().to_string(), "the case has no time directory");
        sink.push(d.help("`granflow run` writes them"));
        return Err(CaseError::Invalid);
    }
    let grid = Grid::new(&poly);
    // What is in the folder and not of these names is somebody else's.
    let mut dir = DirWriter::begin(&root.join(VTK))?.keep_existing()?;
    let mut out = Exported::default();
    let mut listed = Vec::new();
    for (time, path) in &times {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut arrays = Vec::new();
        for field in names_in(path)? {
            arrays.extend(read(root, &name, &field, &poly, sink)?);
        }
        if sink.has_errors() {
            return Err(CaseError::Invalid);
        }
        for a in &arrays {
            if !out.fields.contains(&a.name) {
                out.fields.push(a.name.clone());
            }
        }
        dir.file_plain(format!("{name}.vtu"), &vtu::file(&grid, *time, &arrays))?;
        listed.push((*time, format!("{name}.vtu")));
        out.times.push(name);
    }
    dir.file_plain("case.pvd", vtu::collection(&listed).as_bytes())?;
    dir.commit()?;
    Ok(out)
}

/// A mesh with numbers on its cells as a VTU file: name and values of each array.
pub(crate) fn mesh_file(poly: &PolyMesh, arrays: Vec<(String, Vec<f64>)>) -> Vec<u8> {
    let array = |(name, data)| Array { name, components: 1, data };
    vtu::file(&Grid::new(poly), 0.0, &arrays.into_iter().map(array).collect::<Vec<_>>())
}

/// Names of the files in a time directory, without `.gz`, in order.
pub(crate) fn names_in(dir: &Path) -> Result<Vec<String>, StoreError> {
    let fail = |e| StoreError::new(Operation::Read, dir, e);
    let mut names = Vec::new();
    for entry in fs::read_dir(dir).map_err(fail)? {
        let path: PathBuf = entry.map_err(fail)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_file() && !name.starts_with('.') {
            names.push(name.strip_suffix(".gz").unwrap_or(&name).to_owned());
        }
    }
    names.sort();
    names.dedup();
    Ok(names)
}

/// The values of a field on cells; `None` for files that hold something else.
fn read(
    root: &Path,
    time: &str,
    name: &str,
    poly: &PolyMesh,
    sink: &Sink,
) -> Result<Option<Array>, StoreError> {
    // What is no dictionary at all is somebody else's file.
    let aside = Sink::new();
    let Some(dict) = files::dict(root, Path::new(time).join(name), &aside)? else {
        return Ok(None);
    };
    let class = dict.header().and_then(|h| h.word("class")).unwrap_or("").to_owned();
    let n = poly.n_cells();
    let (components, data) = match class.as_str() {
        "volScalarField" => (1, values::<f64>(&dict, n, &aside)),
        "volVectorField" => (3, values::<Vec3>(&dict, n, &aside)),
        "volTensorField" => (9, values::<Tensor>(&dict, n, &aside)),
        "volSphericalTensorField" => (1, values::<f64>(&dict, n, &aside)),
        "volSymmTensorField" => (6, symmetric(&dict, n, &aside)),
        _ => return Ok(None),
    };
    sink.extend(aside.take());
    Ok(Some(Array { name: name.to_owned(), components, data }))
}

/// Symmetric tensors in VTK's order, xx yy zz xy yz xz; the file has xx xy xz yy yz zz.
fn symmetric(dict: &Dict, n: usize, sink: &Sink) -> Vec<f64> {
    const ORDER: [usize; 6] = [0, 3, 5, 1, 4, 2];
    let found = dict.stream("internalField").and_then(|t| field_values(t, n, 6));
    let Some(all) = found else {
        let r = Reader::new(dict, sink);
        let message = format!("`internalField` must be {n} symmetric tensors, or one for all");
        r.error_at_key("internalField", message, "six numbers each", None);
        return vec![0.0; 6 * n];
    };
    all.chunks_exact(6).flat_map(|v| ORDER.map(|k| v[k])).collect()
}

fn values<T: Value>(dict: &Dict, n: usize, sink: &Sink) -> Vec<f64> {
    let cells = Reader::new(dict, sink).field::<T>("internalField", n).into_vec(n);
    cells.iter().flat_map(|v| (0..T::N).map(|k| v.comp(k))).collect()
}
