//! Directories and single files that appear whole or not at all.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::disk::{self, Disk, RealDisk};
use super::error::{Context, Operation, StoreError};

/// Whether files are written as they are or with gzip (`writeCompression` of `controlDict`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// As they are.
    #[default]
    Plain,
    /// With gzip, under the name with `.gz` added.
    Gzip,
}

/// Writes a directory aside and puts it in place in one step.
///
/// Until [`commit`](DirWriter::commit) returns `Ok`, the target is what it was before (absent, or
/// the earlier directory). A writer dropped without a commit removes what it wrote; a process
/// killed before the commit leaves a hidden directory that [`clean_stale`](super::clean_stale)
/// recognises.
pub struct DirWriter {
    disk: Arc<dyn Disk>,
    target: PathBuf,
    aside: PathBuf,
    compression: Compression,
    made: BTreeSet<PathBuf>,
    /// Tells other processes that the hidden directory is in use.
    _lock: Option<File>,
}

impl DirWriter {
    /// Starts writing the directory `target`; its parents are created when missing.
    pub fn begin(target: &Path) -> Result<Self, StoreError> {
        Self::on(Arc::new(RealDisk), target)
    }

    /// The same on a given disk; for tests that let it fail.
    pub fn on(disk: Arc<dyn Disk>, target: &Path) -> Result<Self, StoreError> {
        let target = through_link(target);
        if let Ok(meta) = fs::symlink_metadata(&target)
            && meta.is_file()
        {
            let e = io::Error::from(io::ErrorKind::NotADirectory);
            return Err(StoreError::new(Operation::Create, target, e));
        }
        let parent = parent_of(&target);
        create_dirs(disk.as_ref(), parent)?;
        let aside = hidden_name(&target, Suffix::New)?;
        disk.create_dir(&aside).at(Operation::Create, &target)?;
        let lock = disk::hold(&aside);
        Ok(DirWriter {
            disk,
            target,
            aside,
            compression: Compression::Plain,
            made: BTreeSet::new(),
            _lock: lock,
        })
    }

    /// Sets how [`file`](DirWriter::file) writes from now on.
    #[must_use]
    pub fn compressed(mut self, compression: Compression) -> Self {
        self.compression = compression;
        self
    }

    /// Takes over everything the target holds now, so that the files written replace or add to it
    /// (a field added to `0`, the mesh beside other files of `constant/polyMesh`).
    pub fn keep_existing(mut self) -> Result<Self, StoreError> {
        if self.target.is_dir() {
            let target = self.target.clone();
            self.take_over(&target, Path::new(""))?;
        }
        Ok(self)
    }

    /// Writes one file; `rel` is relative to the directory and may be nested (`uniform/time`).
    /// The bytes are on the disk when this returns: a full disk is reported here.
    pub fn file(&mut self, rel: impl AsRef<Path>, bytes: &[u8]) -> Result<(), StoreError> {
        match self.compression {
            Compression::Plain => self.file_plain(rel, bytes),
            Compression::Gzip => {
                let rel = rel.as_ref();
                // The same file under its other name would leave a reader two to choose from.
                self.forget(rel)?;
                let packed = gzip(bytes).at(Operation::Write, self.target.join(rel))?;
                self.put(&with_gz(rel), &packed)
            }
        }
    }

    /// Writes one file without compression, whatever was set (`boundary`, `uniform/time`).
    pub fn file_plain(&mut self, rel: impl AsRef<Path>, bytes: &[u8]) -> Result<(), StoreError> {
        let rel = rel.as_ref();
        self.forget(&with_gz(rel))?;
        self.put(rel, bytes)
    }

    /// Leaves a file out that was taken over, packed or not; that there is none is fine.
    pub fn remove(&mut self, rel: impl AsRef<Path>) -> Result<(), StoreError> {
        let rel = rel.as_ref();
        self.forget(rel)?;
        self.forget(&with_gz(rel))
    }

    /// The directory as it will be called.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Puts the directory in place and returns its path. On an error the target is what it was
    /// before.
    pub fn commit(self) -> Result<PathBuf, StoreError> {
        for dir in self.made.iter().rev() {
            self.disk.sync_dir(&self.aside.join(dir)).at(Operation::Sync, self.target.join(dir))?;
        }
        self.disk.sync_dir(&self.aside).at(Operation::Sync, &self.target)?;
        if fs::symlink_metadata(&self.target).is_ok() {
            self.replace()?;
        } else {
            self.disk.rename(&self.aside, &self.target).at(Operation::Rename, &self.target)?;
            if let Err(e) = self.sync_parent() {
                // Take it back, so that an error means "not written" (drop removes it).
                let _ = self.disk.rename(&self.target, &self.aside);
                return Err(e);
            }
        }
        Ok(self.target.clone())
    }

    /// Swaps the new directory with the existing one; drop then removes the old one, which is
    /// called what the new one was called.
    fn replace(&self) -> Result<(), StoreError> {
        match self.disk.exchange(&self.aside, &self.target) {
            Ok(()) => {
                if let Err(e) = self.sync_parent() {
                    let _ = self.disk.exchange(&self.aside, &self.target);
                    return Err(e);
                }
                Ok(())
            }
            Err(e) if e.kind() == io::ErrorKind::Unsupported => self.replace_in_two_steps(),
            Err(e) => Err(StoreError::new(Operation::Rename, &self.target, e)),
        }
    }

    /// Without an atomic exchange there is a moment when only the set-aside old directory exists;
    /// `clean_stale` brings it back if the machine stops just then.
    fn replace_in_two_steps(&self) -> Result<(), StoreError> {
        let old = hidden_name(&self.target, Suffix::Old)?;
        let _lock = disk::hold(&self.target);
        self.disk.rename(&self.target, &old).at(Operation::Rename, &self.target)?;
        let placed = self
            .disk
            .rename(&self.aside, &self.target)
            .at(Operation::Rename, &self.target)
            .and_then(|()| {
                self.sync_parent().inspect_err(|_| {
                    let _ = self.disk.rename(&self.target, &self.aside);
                })
            });
        if let Err(e) = placed {
            let _ = self.disk.rename(&old, &self.target);
            return Err(e);
        }
        // The new directory is in place: what is left of the old one is rubbish, not a failure.
        discard(self.disk.as_ref(), &self.target, &old);
        Ok(())
    }

    fn sync_parent(&self) -> Result<(), StoreError> {
        let parent = parent_of(&self.target);
        self.disk.sync_dir(parent).at(Operation::Sync, parent)
    }

    fn put(&mut self, rel: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        let inside = rel.components().all(|c| matches!(c, Component::Normal(_)));
        if !inside || rel.as_os_str().is_empty() {
            let e = io::Error::new(io::ErrorKind::InvalidInput, "not a path inside the directory");
            return Err(StoreError::new(Operation::Write, self.target.join(rel), e));
        }
        if let Some(parent) = rel.parent() {
            self.make_dirs(parent)?;
        }
        self.forget(rel)?;
        let path = self.aside.join(rel);
        if let Err(e) = self.disk.write_new(&path, bytes) {
            let _ = self.disk.remove_file(&path); // never half a file, even if one goes on
            return Err(StoreError::new(Operation::Write, self.target.join(rel), e));
        }
        Ok(())
    }

    /// Removes a file taken over or written before. Never overwritten in place: the file may be
    /// a second name of the one in the target.
    fn forget(&self, rel: &Path) -> Result<(), StoreError> {
        match self.disk.remove_file(&self.aside.join(rel)) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => {
                Err(StoreError::new(Operation::Write, self.target.join(rel), e))
            }
            _ => Ok(()),
        }
    }

    fn make_dirs(&mut self, rel: &Path) -> Result<(), StoreError> {
        let mut path = PathBuf::new();
        for part in rel.components() {
            path.push(part);
            if self.made.contains(&path) {
                continue;
            }
            self.disk
                .create_dir(&self.aside.join(&path))
                .at(Operation::Create, self.target.join(&path))?;
            self.made.insert(path.clone());
        }
        Ok(())
    }

    fn take_over(&mut self, from: &Path, rel: &Path) -> Result<(), StoreError> {
        for entry in fs::read_dir(from).at(Operation::Read, from)? {
            let entry = entry.at(Operation::Read, from)?;
            let (path, rel) = (entry.path(), rel.join(entry.file_name()));
            if parse_hidden(&entry.file_name()).is_some() {
                continue; // left by a crashed run
            }
            // Follows links: the new directory holds what the old one showed.
            let meta = fs::metadata(&path).at(Operation::Read, &path)?;
            if meta.is_dir() {
                self.make_dirs(&rel)?;
                self.take_over(&path, &rel)?;
            } else {
                let source = fs::canonicalize(&path).at(Operation::Read, &path)?;
                self.disk.link(&source, &self.aside.join(&rel)).at(Operation::Write, &path)?;
            }
        }
        Ok(())
    }
}

impl Drop for DirWriter {
    fn drop(&mut self) {
        // Not committed: the unfinished directory. Committed over an existing one: the old one.
        // Failure is not an error of the run; clean_stale of the next one tries again.
        if fs::symlink_metadata(&self.aside).is_ok() {
            let _ = self.disk.remove_dir_all(&self.aside);
        }
    }
}

/// Writes one time directory of a case; see [`DirWriter`] for the guarantees.
pub struct TimeWriter(DirWriter);

impl TimeWriter {
    /// Starts writing the time directory `name` (see [`TimeName`](super::TimeName)) of `case`.
    pub fn begin(case: &Path, name: &str) -> Result<Self, StoreError> {
        DirWriter::begin(&case.join(name)).map(TimeWriter)
    }

    /// The same on a given disk; for tests that let it fail.
    pub fn on(disk: Arc<dyn Disk>, case: &Path, name: &str) -> Result<Self, StoreError> {
        DirWriter::on(disk, &case.join(name)).map(TimeWriter)
    }

    /// See [`DirWriter::compressed`].
    #[must_use]
    pub fn compressed(self, compression: Compression) -> Self {
        TimeWriter(self.0.compressed(compression))
    }

    /// See [`DirWriter::keep_existing`].
    pub fn keep_existing(self) -> Result<Self, StoreError> {
        self.0.keep_existing().map(TimeWriter)
    }

    /// See [`DirWriter::file`].
    pub fn file(&mut self, rel: impl AsRef<Path>, bytes: &[u8]) -> Result<(), StoreError> {
        self.0.file(rel, bytes)
    }

    /// See [`DirWriter::file_plain`].
    pub fn file_plain(&mut self, rel: impl AsRef<Path>, bytes: &[u8]) -> Result<(), StoreError> {
        self.0.file_plain(rel, bytes)
    }

    /// The directory as it will be called.
    pub fn target(&self) -> &Path {
        self.0.target()
    }

    /// See [`DirWriter::commit`].
    pub fn commit(self) -> Result<PathBuf, StoreError> {
        self.0.commit()
    }
}

/// Writes a single file (a figure, a table): aside, synchronised, renamed. Missing parents are
/// created. On an error the file is as it was before, except when the last step alone failed
/// ([`Operation::Sync`]): then it is the whole new one, which a power failure might still undo.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    write_atomic_on(&RealDisk, path, bytes)
}

/// The same on a given disk; for tests that let it fail.
pub fn write_atomic_on(disk: &dyn Disk, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    put_aside_first(disk, path, bytes, true)
}

/// Writes a single file aside and renames it: whoever reads finds all of it or none. A power failure may
/// undo it or leave it short. For samples of every step, which waiting for the disk would make costly.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    put_aside_first(&RealDisk, path, bytes, false)
}

fn put_aside_first(
    disk: &dyn Disk,
    path: &Path,
    bytes: &[u8],
    safe: bool,
) -> Result<(), StoreError> {
    let path = through_link(path);
    let parent = parent_of(&path);
    create_dirs(disk, parent)?;
    let aside = hidden_name(&path, Suffix::New)?;
    let written = if safe { disk.write_new(&aside, bytes) } else { std::fs::write(&aside, bytes) };
    let done = written
        .at(Operation::Write, &path)
        .and_then(|()| disk.rename(&aside, &path).at(Operation::Rename, &path));
    if let Err(e) = done {
        let _ = disk.remove_file(&aside);
        return Err(e);
    }
    if safe { disk.sync_dir(parent).at(Operation::Sync, parent) } else { Ok(()) }
}

/// What a hidden name of ours says about the entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Suffix {
    /// Unfinished, or replaced: to be removed.
    New,
    /// An earlier directory set aside: to be brought back if its target is missing.
    Old,
    /// Given up: to be removed.
    Gone,
}

const PREFIX: &str = ".granflow-";

impl Suffix {
    const ALL: [(Suffix, &str); 3] =
        [(Suffix::New, "new"), (Suffix::Old, "old"), (Suffix::Gone, "gone")];
}

/// A hidden name beside `target`, unique in this process: `.granflow-0.5-4711-0.new`.
pub(crate) fn hidden_name(target: &Path, suffix: Suffix) -> Result<PathBuf, StoreError> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let Some(name) = target.file_name() else {
        let e = io::Error::new(io::ErrorKind::InvalidInput, "not a name for a file or directory");
        return Err(StoreError::new(Operation::Create, target, e));
    };
    let end = Suffix::ALL.iter().find(|(s, _)| *s == suffix).map_or("new", |(_, e)| e);
    loop {
        let mut hidden = OsString::from(PREFIX);
        hidden.push(name);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        hidden.push(format!("-{}-{n}.{end}", std::process::id()));
        let path = parent_of(target).join(hidden);
        // A crashed process of the same number (usual in containers) may have left this name.
        if fs::symlink_metadata(&path).is_err() {
            return Ok(path);
        }
    }
}

/// Takes a hidden name apart: the name of its target, the process, what it is.
pub(crate) fn parse_hidden(name: &OsStr) -> Option<(String, u32, Suffix)> {
    let (rest, end) = name.to_str()?.strip_prefix(PREFIX)?.rsplit_once('.')?;
    let suffix = Suffix::ALL.iter().find(|(_, e)| *e == end)?.0;
    let (rest, count) = rest.rsplit_once('-')?;
    let (target, pid) = rest.rsplit_once('-')?;
    count.parse::<u64>().ok()?;
    Some((target.to_owned(), pid.parse().ok()?, suffix))
}

/// Removes `path`, a directory that was called `target`, so that a crash on the way leaves no
/// half-removed directory that looks like a whole one.
pub(crate) fn discard(disk: &dyn Disk, target: &Path, path: &Path) {
    if let Ok(gone) = hidden_name(target, Suffix::Gone)
        && disk.rename(path, &gone).is_ok()
    {
        let _ = disk.remove_dir_all(&gone);
    }
}

pub(crate) fn parent_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where a symbolic link leads; any other path unchanged. So that a linked mesh or time directory
/// is replaced where it lives, and the link stays.
fn through_link(path: &Path) -> PathBuf {
    if path.is_symlink()
        && let Ok(real) = fs::canonicalize(path)
    {
        return real;
    }
    path.to_owned()
}

fn create_dirs(disk: &dyn Disk, path: &Path) -> Result<(), StoreError> {
    if path.is_dir() {
        return Ok(());
    }
    let parent = parent_of(path);
    if parent != path {
        create_dirs(disk, parent)?;
    }
    match disk.create_dir(path) {
        // Another rank or thread was faster.
        Err(e) if e.kind() != io::ErrorKind::AlreadyExists || !path.is_dir() => {
            Err(StoreError::new(Operation::Create, path, e))
        }
        _ => Ok(()),
    }
}

fn with_gz(rel: &Path) -> PathBuf {
    let mut name = rel.as_os_str().to_owned();
    name.push(".gz");
    PathBuf::from(name)
}

fn gzip(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_names_read_back() {
        let path = hidden_name(Path::new("case/1e-05"), Suffix::Old).unwrap();
        assert_eq!(path.parent(), Some(Path::new("case")));
        let parsed = parse_hidden(path.file_name().unwrap());
        assert_eq!(parsed, Some(("1e-05".to_owned(), std::process::id(), Suffix::Old)));
        for other in ["0.5", ".granflow-0.5", ".granflow-0.5-x-1.new", ".granflow-a-1-2.txt"] {
            assert_eq!(parse_hidden(OsStr::new(other)), None, "{other}");
        }
    }

    #[test]
    fn gzip_is_reproducible() {
        let (a, b) =
            (gzip(b"internalField uniform 0;").unwrap(), gzip(b"internalField uniform 0;"));
        assert_eq!(a, b.unwrap());
        assert_eq!(a[..2], [0x1f, 0x8b]);
        assert_eq!(a[4..8], [0; 4], "no time stamp");
    }
}
