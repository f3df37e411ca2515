//! Time directories and the tables of functions. Only rank 0 comes here.

use crate::functions::Written;
use crate::store::{Operation, StoreError, write_atomic};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Folder of everything that functions write.
pub const POST: &str = "postProcessing";

/// Writes what functions return below `postProcessing`.
pub(crate) struct Tables {
    root: PathBuf,
    start: String,
    begun: BTreeSet<PathBuf>,
}

impl Tables {
    /// Tables of a run that begins at the time called `start`.
    pub(crate) fn new(case: &Path, start: &str) -> Tables {
        Tables { root: case.join(POST), start: start.into(), begun: BTreeSet::new() }
    }

    /// Puts `written` of function `name` at the time called `time` on the disk.
    pub(crate) fn put(
        &mut self,
        name: &str,
        time: &str,
        written: Vec<Written>,
    ) -> Result<(), StoreError> {
        for w in written {
            match w {
                Written::File { file, text } => {
                    write_atomic(&self.root.join(name).join(time).join(file), text.as_bytes())?;
                }
                Written::Line { file, header, line } => {
                    let path = self.root.join(name).join(&self.start).join(file);
                    // A table begins anew with the run: it belongs to its start time.
                    if self.begun.insert(path.clone()) {
                        write_atomic(&path, format!("{header}\n{line}\n").as_bytes())?;
                    } else {
                        append(&path, &format!("{line}\n"))?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn append(path: &Path, line: &str) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(Operation::Write, path, e);
    let mut file: File = OpenOptions::new().append(true).open(path).map_err(fail)?;
    let end = file.metadata().map_err(fail)?.len();
    file.write_all(line.as_bytes()).map_err(|e| {
        // Never half a line.
        let _ = file.set_len(end);
        fail(e)
    })
}
