//! The one error of the store: an operation, a path, and what the system said.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// What was being done when the system refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Creating a directory.
    Create,
    /// Writing (or synchronising) a file.
    Write,
    /// Synchronising a directory, so that a rename survives a power failure.
    Sync,
    /// Renaming the finished directory or file onto its final name.
    Rename,
    /// Removing a file or directory.
    Remove,
    /// Reading a file or listing a directory.
    Read,
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Operation::Create => "create",
            Operation::Write => "write",
            Operation::Sync => "synchronise",
            Operation::Rename => "put in place",
            Operation::Remove => "remove",
            Operation::Read => "read",
        })
    }
}

/// The causes a caller or a person acts upon differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// No space left: file system, quota or the limit on the size of one file.
    DiskFull,
    /// No permission, or a read-only file system.
    Permission,
    /// The file or directory is not there.
    NotFound,
    /// The path itself is not usable: a file where a directory is needed, a bad name.
    BadPath,
    /// Any other failure of the system (input/output error, too many open files, ...).
    Other,
}

/// A failed operation on the disk; says what, where and why.
#[derive(Debug, thiserror::Error)]
#[error("cannot {op} {}: {}", crate::files::shown(path), Reason(source))]
pub struct StoreError {
    /// What was being done.
    pub op: Operation,
    /// The path it was done to; for data being written aside, the final path.
    pub path: PathBuf,
    /// The system's answer.
    pub source: io::Error,
}

impl StoreError {
    pub(crate) fn new(op: Operation, path: impl Into<PathBuf>, source: io::Error) -> Self {
        StoreError { op, path: path.into(), source }
    }

    /// The cause, as far as it makes a difference to what to do next.
    pub fn kind(&self) -> Kind {
        kind_of(&self.source)
    }

    /// True when the machine failed rather than the input: disk full, quota, permission,
    /// read-only file system, input/output error. The command exits with code 4 for these.
    pub fn is_machine_failure(&self) -> bool {
        matches!(self.kind(), Kind::DiskFull | Kind::Permission | Kind::Other)
    }
}

fn kind_of(e: &io::Error) -> Kind {
    use io::ErrorKind as E;
    match e.kind() {
        E::StorageFull | E::QuotaExceeded | E::FileTooLarge => Kind::DiskFull,
        E::PermissionDenied | E::ReadOnlyFilesystem => Kind::Permission,
        E::NotFound => Kind::NotFound,
        E::NotADirectory | E::IsADirectory | E::InvalidInput | E::InvalidFilename => Kind::BadPath,
        _ => Kind::Other,
    }
}

struct Reason<'a>(&'a io::Error);

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        match kind_of(e) {
            Kind::DiskFull => write!(f, "disk full ({e})"),
            Kind::Permission => write!(f, "no permission ({e})"),
            Kind::NotFound | Kind::BadPath | Kind::Other => write!(f, "{e}"),
        }
    }
}

/// Attaches operation and path to a result of the standard library.
pub(crate) trait Context<T> {
    fn at(self, op: Operation, path: impl Into<PathBuf>) -> Result<T, StoreError>;
}

impl<T> Context<T> for io::Result<T> {
    fn at(self, op: Operation, path: impl Into<PathBuf>) -> Result<T, StoreError> {
        self.map_err(|e| StoreError::new(op, path, e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_operation_path_and_cause() {
        let full =
            StoreError::new(Operation::Write, "case/0.5/U", io::ErrorKind::StorageFull.into());
        assert_eq!(full.to_string(), "cannot write case/0.5/U: disk full (no storage space)");
        assert_eq!(full.kind(), Kind::DiskFull);
        assert!(full.is_machine_failure());
    }

    #[test]
    fn causes_are_told_apart() {
        let kind = |e: io::ErrorKind| StoreError::new(Operation::Write, "x", e.into());
        assert_eq!(kind(io::ErrorKind::QuotaExceeded).kind(), Kind::DiskFull);
        assert_eq!(kind(io::ErrorKind::ReadOnlyFilesystem).kind(), Kind::Permission);
        assert!(kind(io::ErrorKind::PermissionDenied).is_machine_failure());
        assert!(!kind(io::ErrorKind::NotFound).is_machine_failure());
        assert!(!kind(io::ErrorKind::NotADirectory).is_machine_failure());
        assert!(kind(io::ErrorKind::Other).is_machine_failure());
    }
}
