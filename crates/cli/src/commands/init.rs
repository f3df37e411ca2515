//! `granflow init`: `0.orig` becomes `0`.

use super::need_case;
use crate::args::Place;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::place;
use granflow_case::init::from_orig;
use granflow_case::set_fields;
use granflow_case::store::{CaseLock, list_times};
use granflow_dict::{Sink, Source};
use std::fs;
use std::path::{Path, PathBuf};

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Place) -> Result<(), Failure> {
    let root = &args.case;
    need_case(root)?;
    let _lock = CaseLock::take(root)?;
    if !root.join(ORIG).is_dir() {
        let message = format!("the case has no directory `{ORIG}` to make `0` of");
        return Err(Failure::refused(message, "write the fields to `0` directly"));
    }
    if root.join("0").exists() {
        let message = "`0` exists already: nothing was changed";
        return Err(Failure::refused(message, format!("remove it to make it anew from `{ORIG}`")));
    }
    from_orig(root)?;
    let mut set = Vec::new();
    if set_fields::present(root) {
        // Where to write and what the fields are is known of a whole case only.
        let made = set_fields::write(root, &session.sink, &session.notices);
        if made.is_err() {
            // As it was: what cannot be removed is what this command would have made.
            let _ = fs::remove_dir_all(root.join("0"));
        }
        set = made?;
    }
    let set = if set.is_empty() { String::new() } else { format!(", {} set", set.join(", ")) };
    session.out.say(&format!("{} made from {ORIG}{set}", place(root, "0")));
    Ok(())
}

const ORIG: &str = "0.orig";

/// `0`, made for a case that has no time directory; taken back unless it is [kept](Self::keep).
/// So a case with mistakes is left as it was.
pub(crate) struct Initial {
    made: Option<PathBuf>,
}

impl Initial {
    /// Makes `0` from `0.orig` where the case has that and no time directory.
    ///
    /// # Errors
    /// The disk refuses, or the case needs more than a copy.
    pub(crate) fn prepare(root: &Path) -> Result<Initial, Failure> {
        if !root.join(ORIG).is_dir() || !list_times(root)?.is_empty() {
            return Ok(Initial { made: None });
        }
        let made = from_orig(root)?.then(|| root.join("0"));
        Ok(Initial { made })
    }
    /// Lets findings about the files of `0`, which goes away again, name those of `0.orig`.
    pub(crate) fn restate(&self, root: &Path, sink: &Sink) {
        let Some(made) = &self.made else { return };
        let restated = sink.take().into_iter().map(|mut d| {
            // Paths of the current directory are shown without its `./`.
            let path = Path::new(&d.src.path);
            let inside = [made.as_path(), made.strip_prefix(".").unwrap_or(made)];
            if let Some(rel) = inside.iter().find_map(|dir| path.strip_prefix(dir).ok()) {
                let path = place(root, &Path::new(ORIG).join(rel).display().to_string());
                d.src = Source::new(path, d.src.text.clone());
            }
            d
        });
        sink.extend(restated.collect::<Vec<_>>());
    }
    /// The directory that a person knows a start directory by.
    pub(crate) fn shown<'d>(&self, dir: &'d str) -> &'d str {
        if self.made.is_some() && dir == "0" { ORIG } else { dir }
    }
    /// The case is sound: `0` stays. Says whether it was made.
    pub(crate) fn keep(mut self) -> bool {
        self.made.take().is_some()
    }
}

impl Drop for Initial {
    fn drop(&mut self) {
        if let Some(dir) = self.made.take() {
            // What cannot be removed is what `granflow init` would have made.
            let _ = fs::remove_dir_all(dir);
        }
    }
}
