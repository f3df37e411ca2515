//! One at a time: who changes a case holds a lock on it.
//!
//! The lock is the system's own, on an open file, so that it ends with the process however that
//! ends: a run that was killed leaves a file behind and blocks nobody.

use super::error::{Operation, StoreError};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The file in the case that is locked; it holds the number of the process.
pub const LOCK_NAME: &str = ".granflow.lock";

/// The right to change a case, until dropped.
#[derive(Debug)]
pub struct CaseLock {
    /// Open as long as the lock is held.
    file: File,
    path: PathBuf,
}

/// Why there is no lock.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process changes the case.
    #[error("the case is in use by {}: it holds {}", who(*pid), crate::files::shown(path))]
    Held {
        /// The locked file.
        path: PathBuf,
        /// The process, where it has said so.
        pid: Option<u32>,
    },
    /// The disk refused.
    #[error(transparent)]
    Store(#[from] StoreError),
}

fn who(pid: Option<u32>) -> String {
    pid.map_or("another granflow".to_owned(), |pid| format!("granflow (process {pid})"))
}

impl CaseLock {
    /// Takes the lock of a case, or says who has it.
    ///
    /// # Errors
    /// [`LockError`].
    pub fn take(case: &Path) -> Result<CaseLock, LockError> {
        let path = case.join(LOCK_NAME);
        let failed = |e| StoreError::new(Operation::Create, &path, e);
        loop {
            // Not emptied: the number of the process that holds it is in it.
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let mut file = options.open(&path).map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut text = String::new();
                    let _ = file.read_to_string(&mut text);
                    return Err(LockError::Held { path, pid: text.trim().parse().ok() });
                }
                // A file system without locks: nobody can be kept out, and nobody is.
                Err(TryLockError::Error(_)) => return Ok(CaseLock { file, path }),
            }
            // Its last owner may have removed it between our opening and locking it.
            if !is_at(&file, &path) {
                continue;
            }
            let mut sign = || -> io::Result<()> {
                file.set_len(0)?;
                file.rewind()?;
                writeln!(file, "{}", std::process::id())
            };
            // Without the number others are kept out all the same.
            let _ = sign();
            return Ok(CaseLock { file, path });
        }
    }
}

impl Drop for CaseLock {
    fn drop(&mut self) {
        // Before it is released, so that nobody can have locked a file that goes away.
        if is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Whether `path` names the open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_leftovers_block_nobody() {
        let case = tempfile::tempdir().unwrap();
        let file = case.path().join(LOCK_NAME);
        // What a killed run leaves behind.
        fs::write(&file, "1\n").unwrap();
        let lock = CaseLock::take(case.path()).unwrap();
        match CaseLock::take(case.path()) {
            Err(LockError::Held { path, pid }) => {
                assert_eq!((path, pid), (file.clone(), Some(std::process::id())));
            }
            other => panic!("{other:?}"),
        }
        drop(lock);
        assert!(!file.exists(), "nothing is left");
        drop(CaseLock::take(case.path()).unwrap());
    }
}
