//! A run that begins before the end of an earlier one: what the earlier one wrote is set aside.
//!
//! OpenFOAM writes over it as it goes and leaves the rest, so that two runs lie mixed in one case
//! and `latestTime` may belong to either. Here the case holds one run at any time, and nothing is
//! lost: the earlier run's times are renamed into `superseded/1`, `superseded/2` and so on.

use crate::jsonl::LOG_NAME;
use crate::output::POST;
use crate::store::{Operation, StoreError, TimeName, list_times};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of what earlier runs wrote.
pub const SUPERSEDED: &str = "superseded";

/// What was set aside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetAside {
    /// Where to.
    pub dir: PathBuf,
    /// The time directories, in order.
    pub times: Vec<String>,
}

/// Sets aside the times behind `start` (s), what functions wrote from there on, and the log when
/// the new run is `fresh`, that is begins a new one. `None` when there are no such times.
pub(crate) fn set_aside(
    root: &Path,
    start: f64,
    fresh: bool,
) -> Result<Option<SetAside>, StoreError> {
    // The start's own directory may be rounded either way.
    let behind = |t: f64| t - start > 1e-9 * t.abs().max(start.abs());
    let later: Vec<PathBuf> =
        list_times(root)?.into_iter().filter(|x| behind(x.0)).map(|x| x.1).collect();
    if later.is_empty() {
        return Ok(None);
    }
    let all = root.join(SUPERSEDED);
    let number = (1..).find(|n| !all.join(n.to_string()).exists()).unwrap_or(1);
    let dir = all.join(number.to_string());
    let names = |p: &PathBuf| p.file_name().map(|n| n.to_string_lossy().into_owned());
    let times = later.iter().filter_map(names).collect();
    for path in &later {
        put_into(&dir, root, path)?;
    }
    // Tables are named by the time their run began at, profiles by their own.
    let time = |at: &PathBuf| at.file_name().and_then(|n| TimeName::parse(n.to_str()?));
    for function in folders(&root.join(POST)) {
        for at in folders(&function) {
            // Stream lines have a folder of their own below `sets`.
            let deeper = if time(&at).is_none() { folders(&at) } else { vec![at] };
            for at in deeper {
                if time(&at).is_some_and(|t| t >= start || behind(t)) {
                    put_into(&dir, root, &at)?;
                }
            }
        }
    }
    let log = root.join(LOG_NAME);
    if fresh && log.is_file() {
        put_into(&dir, root, &log)?;
    }
    Ok(Some(SetAside { dir, times }))
}

/// Renames `path` from below `root` to the same place below `dir`.
fn put_into(dir: &Path, root: &Path, path: &Path) -> Result<(), StoreError> {
    let to = dir.join(path.strip_prefix(root).unwrap_or(path));
    let parent = to.parent().unwrap_or(dir);
    fs::create_dir_all(parent).map_err(|e| StoreError::new(Operation::Create, parent, e))?;
    fs::rename(path, &to).map_err(|e| StoreError::new(Operation::Rename, to, e))
}

/// Directories in a directory; none where it cannot be read.
fn folders(dir: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    let mut all: Vec<PathBuf> = entries.map(|e| e.path()).filter(|p| p.is_dir()).collect();
    all.sort();
    all
}
