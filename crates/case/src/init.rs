//! The initial fields of a case: `0.orig` becomes `0`.

use crate::files;
use crate::store::{DirWriter, Operation, StoreError};
use granflow_dict::{Diag, Severity, Sink};
use std::path::Path;

/// What OpenFOAM would change the fields of `0.orig` with.
const SET_FIELDS: &str = "system/setFieldsDict";

/// Refuses a case whose `0.orig` is meant to go through `setFieldsDict`; says whether it did.
pub fn refuse_set_fields(root: &Path, sink: &Sink) -> bool {
    let refused = files::exists(root, SET_FIELDS);
    if refused {
        let path = root.join(SET_FIELDS).display().to_string();
        let d = Diag::file(path, "setFieldsDict is not supported: 0 cannot be made from 0.orig");
        sink.push(d.help(
            "make `0` with OpenFOAM's setFields, or remove the file and give the fields in 0.orig",
        ));
    }
    refused
}

/// Warns that a start from fields that are there already leaves `setFieldsDict` alone.
pub(crate) fn warn_of_set_fields(root: &Path, dir: &str, sink: &Sink) {
    if files::exists(root, SET_FIELDS) {
        let path = root.join(SET_FIELDS).display().to_string();
        let message = format!("setFieldsDict is not read: the fields in `{dir}` are taken as is");
        let mut d = Diag::file(path, message).help("remove the file if they are what is meant");
        d.severity = Severity::Warning;
        sink.push(d);
    }
}

/// Copies `0.orig` to `0` when there is none, whole or not at all; says whether it did.
///
/// # Errors
/// The disk refuses.
pub fn from_orig(root: &Path) -> Result<bool, StoreError> {
    let (orig, zero) = (root.join("0.orig"), root.join("0"));
    if zero.exists() || !orig.is_dir() {
        return Ok(false);
    }
    let mut dir = DirWriter::begin(&zero)?;
    copy(&orig, Path::new(""), &mut dir)?;
    dir.commit()?;
    Ok(true)
}

fn copy(from: &Path, rel: &Path, to: &mut DirWriter) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(Operation::Read, from, e);
    for entry in std::fs::read_dir(from).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let (path, rel) = (entry.path(), rel.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &rel, to)?;
        } else {
            let bytes = std::fs::read(&path)
                .map_err(|e| StoreError::new(Operation::Read, path.clone(), e))?;
            to.file_plain(&rel, &bytes)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_once() {
        let case = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(case.path().join("0.orig/sub")).unwrap();
        std::fs::write(case.path().join("0.orig/sub/U"), "u").unwrap();
        assert!(from_orig(case.path()).unwrap());
        assert_eq!(std::fs::read_to_string(case.path().join("0/sub/U")).unwrap(), "u");
        assert!(!from_orig(case.path()).unwrap());
    }
}
