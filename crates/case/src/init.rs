//! The initial fields of a case: `0.orig` becomes `0`.

use crate::store::{DirWriter, Operation, StoreError};
use std::path::Path;

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
    copy_tree(&orig, Path::new(""), &mut dir)?;
    dir.commit()?;
    Ok(true)
}

/// Copies what is below `from` to `rel` of what is being written.
pub(crate) fn copy_tree(from: &Path, rel: &Path, to: &mut DirWriter) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(Operation::Read, from, e);
    for entry in std::fs::read_dir(from).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let (path, rel) = (entry.path(), rel.join(entry.file_name()));
        if path.is_dir() {
            copy_tree(&path, &rel, to)?;
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
