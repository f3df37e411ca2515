//! The few operations on a disk that writing needs, as a trait so that tests can make each fail.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// What the writers ask of a file system. [`RealDisk`] is the one in use; a test wraps it to
/// fail, or to fill up, at a chosen operation.
pub trait Disk: Send + Sync {
    /// Creates a directory whose parent exists.
    fn create_dir(&self, path: &Path) -> io::Result<()>;
    /// Creates `path` (which must not exist), writes all bytes and synchronises them to the disk.
    fn write_new(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;
    /// Synchronises a directory: the names in it.
    fn sync_dir(&self, path: &Path) -> io::Result<()>;
    /// POSIX `rename`.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;
    /// Exchanges two existing names in one step; `Unsupported` where the system cannot.
    fn exchange(&self, a: &Path, b: &Path) -> io::Result<()>;
    /// Gives `from` (a file) the second name `to`, or copies it.
    fn link(&self, from: &Path, to: &Path) -> io::Result<()>;
    /// Removes a file.
    fn remove_file(&self, path: &Path) -> io::Result<()>;
    /// Removes a directory and all it holds.
    fn remove_dir_all(&self, path: &Path) -> io::Result<()>;
}

/// The file system of the machine.
#[derive(Debug, Clone, Copy, Default)]
pub struct RealDisk;

impl Disk for RealDisk {
    fn create_dir(&self, path: &Path) -> io::Result<()> {
        fs::create_dir(path)
    }

    fn write_new(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        file.write_all(bytes)?;
        // Network file systems and delayed allocation report a full disk only here.
        file.sync_all()
    }

    fn sync_dir(&self, path: &Path) -> io::Result<()> {
        if cfg!(not(unix)) {
            return Ok(()); // a directory cannot be opened, nor need it be synchronised
        }
        match File::open(path)?.sync_all() {
            // Some network and FUSE file systems do not know the call for directories.
            Err(e) if matches!(e.kind(), io::ErrorKind::InvalidInput) || unsupported(&e) => Ok(()),
            r => r,
        }
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    #[cfg(target_os = "linux")]
    fn exchange(&self, a: &Path, b: &Path) -> io::Result<()> {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE).map_err(|e| match e {
            // Old kernels, and file systems without the flag (NFS, some FUSE).
            rustix::io::Errno::NOSYS | rustix::io::Errno::INVAL | rustix::io::Errno::OPNOTSUPP => {
                io::ErrorKind::Unsupported.into()
            }
            e => e.into(),
        })
    }

    #[cfg(not(target_os = "linux"))]
    fn exchange(&self, _a: &Path, _b: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        if fs::hard_link(from, to).is_ok() {
            return Ok(());
        }
        fs::copy(from, to)?;
        File::open(to)?.sync_all()
    }

    fn remove_file(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn remove_dir_all(&self, path: &Path) -> io::Result<()> {
        fs::remove_dir_all(path)
    }
}

fn unsupported(e: &io::Error) -> bool {
    e.kind() == io::ErrorKind::Unsupported
}

/// Marks a directory as in use by this process until the handle is dropped or the process ends,
/// however it ends. `None` where the file system has no locks.
pub(crate) fn hold(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

/// Whether a directory is marked by [`hold`] in a living process; `None` when that is unknown.
pub(crate) fn held(path: &Path) -> Option<bool> {
    let file = File::open(path).ok()?;
    match file.try_lock() {
        Ok(()) => Some(false),
        Err(fs::TryLockError::WouldBlock) => Some(true),
        Err(fs::TryLockError::Error(_)) => None,
    }
}

/// Whether a process of this machine other than ours has this number.
#[cfg(unix)]
pub(crate) fn alive(pid: u32) -> bool {
    let Some(raw) = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw) else {
        return false;
    };
    // "No permission to signal it" means that it lives.
    pid != std::process::id()
        && !matches!(rustix::process::test_kill_process(raw), Err(rustix::io::Errno::SRCH))
}

#[cfg(not(unix))]
pub(crate) fn alive(_pid: u32) -> bool {
    false
}
