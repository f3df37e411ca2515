//! One file a command: `command(session, arguments)` does it.

pub(crate) mod check;
pub(crate) mod export;
pub(crate) mod fit;
pub(crate) mod init;
pub(crate) mod list;
pub(crate) mod mesh;
pub(crate) mod new;
pub(crate) mod plot;
pub(crate) mod run;
mod schemes;
pub(crate) mod sweep;
pub(crate) mod validate;

use crate::failure::Failure;
use crate::output::complain;
use crate::session::Session;
use crate::text::{count, shown};
use granflow_mesh::check::{CheckReport, Severity};
use std::path::Path;

/// Refuses a case directory that is none, before every file in it is reported as missing.
fn need_case(root: &Path) -> Result<(), Failure> {
    let shown = root.display();
    let help = "a case is a directory with `system`, `constant` and `0`; `granflow new NAME` \
                writes one";
    if !root.exists() {
        return Err(Failure::refused(format!("there is no directory `{shown}`"), help));
    }
    if !root.is_dir() {
        return Err(Failure::refused(format!("`{shown}` is a file, not a case directory"), help));
    }
    if !root.join("system").is_dir() {
        return Err(Failure::refused(format!("`{shown}` is no case: it has no `system`"), help));
    }
    Ok(())
}

/// Says where an earlier study was put.
fn set_aside(session: &mut Session, to: Option<&Path>) {
    if let Some(to) = to {
        session
            .out
            .say(&format!("note: what an earlier study left was set aside in {}", shown(to)));
    }
}

/// Refuses a mesh that cannot be computed on; its faults are said with their places.
fn need_sound_mesh(report: &CheckReport) -> Result<(), Failure> {
    if report.ok() {
        return Ok(());
    }
    let errors = report.findings.iter().filter(|f| f.severity == Severity::Error);
    let mut n = 0;
    for finding in errors {
        complain(&format!("{finding}\n"));
        n += 1;
    }
    let message = format!("the mesh cannot be used ({})", count(n, "fault"));
    Err(Failure::refused(message, "`granflow check` says all about it"))
}
