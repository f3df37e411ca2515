//! Removing: what crashed runs left behind, and old time directories.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::dir::{Suffix, hidden_name, parent_of, parse_hidden};
use super::disk::{self, Disk, RealDisk};
use super::error::{Context, Operation, StoreError};
use super::time::{TimeName, list_times};

/// What [`clean_stale`] did with something a crashed run had left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stale {
    /// An unfinished file or directory was removed.
    Removed(PathBuf),
    /// A directory set aside when the run stopped is back under its own name.
    Restored(PathBuf),
}

/// How deep below the case anything of ours is written (`postProcessing/probes/0/U`).
const DEPTH: usize = 4;

/// Removes what crashed runs left in a case, and brings back a directory that was set aside when
/// its replacement did not come to be. What a living process is writing is left alone.
pub fn clean_stale(case: &Path) -> Result<Vec<Stale>, StoreError> {
    let mut done = Vec::new();
    clean(case, DEPTH, &mut done)?;
    Ok(done)
}

fn clean(dir: &Path, depth: usize, done: &mut Vec<Stale>) -> Result<(), StoreError> {
    let mut names = Vec::new();
    for entry in fs::read_dir(dir).at(Operation::Read, dir)? {
        let entry = entry.at(Operation::Read, dir)?;
        // Links are not followed: what is behind them belongs to another case.
        let is_dir = entry.file_type().at(Operation::Read, entry.path())?.is_dir();
        names.push((entry.file_name(), is_dir));
    }
    names.sort();
    for (name, is_dir) in names {
        let path = dir.join(&name);
        let Some((target, pid, suffix)) = parse_hidden(&name) else {
            // A directory we may not read cannot hold anything of ours.
            let hidden = name.to_string_lossy().starts_with('.');
            if is_dir && depth > 0 && !hidden && fs::read_dir(&path).is_ok() {
                clean(&path, depth - 1, done)?;
            }
            continue;
        };
        if in_use(&path, is_dir, pid) {
            continue;
        }
        let target = dir.join(target);
        if suffix == Suffix::Old && fs::symlink_metadata(&target).is_err() {
            fs::rename(&path, &target).at(Operation::Rename, &target)?;
            RealDisk.sync_dir(parent_of(&target)).at(Operation::Sync, &target)?;
            done.push(Stale::Restored(target));
        } else {
            let removed = if is_dir { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            match removed {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {} // another process was faster
                r => r.at(Operation::Remove, &path)?,
            }
            done.push(Stale::Removed(path));
        }
    }
    Ok(())
}

/// A directory says so itself by its lock. A file (or a directory where locks are not to be had)
/// is in use while the process in its name lives.
fn in_use(path: &Path, is_dir: bool, pid: u32) -> bool {
    match is_dir.then(|| disk::held(path)).flatten() {
        Some(held) => held,
        None => disk::alive(pid),
    }
}

/// `purgeWrite`: of the times this run has written, `start < t <= now`, keeps the newest `keep`
/// and removes the others; `keep == 0` keeps all. Start directory, earlier times and times beyond
/// `now` (of another run) are never touched. Returns what was removed.
///
/// `start` and `now` are directory names, so that no rounding can put the start time on the wrong
/// side.
pub fn purge(case: &Path, keep: usize, start: &str, now: &str) -> Result<Vec<PathBuf>, StoreError> {
    let value = |name: &str| {
        TimeName::parse(name).ok_or_else(|| {
            let e = io::Error::new(io::ErrorKind::InvalidInput, "not the name of a time");
            StoreError::new(Operation::Remove, case.join(name), e)
        })
    };
    let (start, now) = (value(start)?, value(now)?);
    if keep == 0 {
        return Ok(Vec::new());
    }
    let mut times = list_times(case)?;
    times.retain(|(t, _)| *t > start && *t <= now);
    let many = times.len().saturating_sub(keep);
    let mut removed = Vec::with_capacity(many);
    for (_, path) in times.drain(..many) {
        if path.is_symlink() {
            fs::remove_file(&path).at(Operation::Remove, &path)?;
        } else {
            // First out of sight in one step: a crash leaves no half time directory.
            let _lock = disk::hold(&path);
            let gone = hidden_name(&path, Suffix::Gone)?;
            fs::rename(&path, &gone).at(Operation::Remove, &path)?;
            fs::remove_dir_all(&gone).at(Operation::Remove, &path)?;
        }
        removed.push(path);
    }
    Ok(removed)
}
