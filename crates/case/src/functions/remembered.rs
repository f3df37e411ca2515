//! What functions keep over a restart: their fields, and `functionObjectProperties`.

use super::{Planned, Remembered, Values, Whole, field};
use crate::store::StoreError;
use crate::{Notices, files};
use granflow_dict::{Header, Sink, Writer};
use granflow_mesh::{Mesh, PolyMesh};
use std::path::Path;

/// The file in a time directory.
pub(crate) const PROPERTIES: &str = "uniform/functionObjects/functionObjectProperties";

/// Reads what the time directory `dir` knows of each function; `None` for those that begin anew.
///
/// # Errors
/// A file is there and cannot be read.
pub(crate) fn read(
    root: &Path,
    dir: &str,
    functions: &[Planned],
    poly: &PolyMesh,
    notices: &Notices,
) -> Result<Vec<Option<Remembered>>, StoreError> {
    let mut out: Vec<Option<Remembered>> = functions.iter().map(|_| None).collect();
    if !functions.iter().any(|f| f.plan.remembers()) {
        return Ok(out);
    }
    // OpenFOAM's functions leave there what is theirs.
    let aside = Sink::new();
    let Some(properties) = files::dict(root, Path::new(dir).join(PROPERTIES), &aside)? else {
        return Ok(out);
    };
    for (f, out) in functions.iter().zip(&mut out).filter(|(f, _)| f.plan.remembers()) {
        let Some(memory) = properties.sub(&f.name) else { continue };
        let mut fields = Vec::new();
        for info in f.plan.makes() {
            let dict = files::dict(root, Path::new(dir).join(&info.name), &aside)?;
            match dict.and_then(|d| field::parse(&info, &d, poly)) {
                Some(whole) => fields.push(whole),
                None => {
                    notices.say(format!(
                        "`{}` begins anew: {dir}/{} is missing or holds something else",
                        f.name, info.name
                    ));
                    break;
                }
            }
        }
        if fields.len() == f.plan.makes().len() {
            *out = Some(Remembered { fields, memory: memory.clone() });
        }
    }
    Ok(out)
}

/// What is kept of one function: its name and its entries.
pub(crate) type Memory = (String, Vec<(String, Vec<(&'static str, String)>)>);

/// The text of the file.
pub(crate) fn properties(time: &str, memories: &[Memory]) -> Vec<u8> {
    let header = Header::new("dictionary", "functionObjectProperties");
    let mut w = Writer::new(&header.location(format!("{time}/uniform/functionObjects")));
    for (name, entries) in memories {
        w.open(name);
        for (key, values) in entries {
            w.open(key);
            values.iter().for_each(|(key, value)| w.entry(key, value));
            w.close();
        }
        w.close();
    }
    w.finish()
}

/// Puts the rank's part of a whole field into `out`. Ghosts stay.
pub(super) fn spread(mesh: &Mesh, whole: &Whole, out: &mut Values) {
    let n = out.n;
    for (c, &user) in mesh.global_cell.iter().enumerate().take(mesh.n_cells) {
        let from = n * user as usize;
        out.cells[n * c..n * (c + 1)].copy_from_slice(&whole.cells[from..from + n]);
    }
    for i in 0..out.faces.len() / n {
        let from = n * (mesh.poly_face[mesh.n_inner + i] >> 1) as usize;
        out.faces[n * i..n * (i + 1)].copy_from_slice(&whole.faces[from..from + n]);
    }
}
