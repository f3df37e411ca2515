//! Where the text of a case comes from: the only reads of case files.

use crate::store::{Operation, StoreError};
use granflow_dict::{Dict, Files, Sink, Source, decompress, parse};
use granflow_fv::conditions::CaseFiles;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files of a case on disk; `x.gz` stands in for a missing `x`.
#[derive(Clone, Debug)]
pub struct DiskFiles {
    root: PathBuf,
}

impl DiskFiles {
    /// The case in `root`.
    pub fn new(root: &Path) -> DiskFiles {
        DiskFiles { root: root.to_owned() }
    }
}

impl Files for DiskFiles {
    fn load(&mut self, path: &str) -> io::Result<Vec<u8>> {
        read(Path::new(path))
    }
    fn case_root(&self) -> String {
        self.root.display().to_string()
    }
    fn variable(&self, name: &str) -> Option<String> {
        std::env::var(name).ok()
    }
}

impl CaseFiles for DiskFiles {
    fn load(&self, path: &str) -> io::Result<Vec<u8>> {
        read(&self.root.join(path))
    }
    fn folders(&self, path: &str) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(self.root.join(path))? {
            let entry = entry?;
            if entry.path().is_dir() {
                names.extend(entry.file_name().into_string());
            }
        }
        Ok(names)
    }
}

/// The bytes of `path`, or of `path.gz` when only that exists, unpacked.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let bytes = match std::fs::read(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let mut packed = path.as_os_str().to_owned();
            packed.push(".gz");
            std::fs::read(packed)
                .map_err(|inner| if inner.kind() == io::ErrorKind::NotFound { e } else { inner })?
        }
        other => other?,
    };
    decompress(bytes)
}

/// The source `rel` of the case, `None` when there is no such file.
///
/// # Errors
/// The file is there and cannot be read.
pub fn source(root: &Path, rel: impl AsRef<Path>) -> Result<Option<Arc<Source>>, StoreError> {
    let path = root.join(rel);
    match read(&path) {
        Ok(bytes) => Ok(Some(Source::new(shown(&path), bytes))),
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            Ok(None)
        }
        Err(e) => Err(StoreError::new(Operation::Read, path, e)),
    }
}

/// A path as messages show it: without the `./` of the current directory.
pub(crate) fn shown(path: &Path) -> String {
    path.strip_prefix(".").unwrap_or(path).display().to_string()
}

/// The dictionary `rel` of the case with its includes, `None` when there is no such file.
/// Mistakes go to the sink.
///
/// # Errors
/// The file is there and cannot be read.
pub fn dict(root: &Path, rel: impl AsRef<Path>, sink: &Sink) -> Result<Option<Dict>, StoreError> {
    let Some(src) = source(root, rel)? else { return Ok(None) };
    let (dict, diags) = parse(src, &mut DiskFiles::new(root));
    sink.extend(diags);
    Ok(Some(dict))
}

/// Whether the case has the file `rel`, packed or not.
pub fn exists(root: &Path, rel: &str) -> bool {
    root.join(rel).is_file() || root.join(format!("{rel}.gz")).is_file()
}
