//! `granflow check`: reads and checks everything, says what a run would meet; changes nothing, but puts the
//! cells of a poor mesh into a file of their own.
//!
//! The report has sections, each a file here: what was read, and what is to be expected of it from
//! boundary conditions, gravity and the start fields, before anything is solved.

mod conditions;
mod cost;
mod numerics;
mod outlook;
mod page;
mod phases;
mod regime;
mod resolution;
mod time_step;

use super::init::Initial;
use super::{need_case, need_sound_mesh};
use crate::args::Check;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::{count, place};
use granflow_case::{Case, CaseError, Options, bad_cells, meshing, strays};
use granflow_dict::Sink;
use granflow_mesh::PolyMesh;
use granflow_mesh::check::{CheckReport, check};
use outlook::Outlook;
use page::Page;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Check) -> Result<(), Failure> {
    let root = args.case.as_path();
    need_case(root)?;
    if args.mesh {
        return mesh_alone(session, root);
    }
    // Taken back when this function returns.
    let initial = Initial::prepare(root)?;
    let loaded = Case::load(root, &Options::default(), &session.sink, &session.notices);
    initial.restate(root, &session.sink);
    let case = match loaded {
        Ok(case) => case,
        Err(CaseError::Invalid) => {
            // What is wrong with a mesh is said with all its places, not as the first mistake.
            if let Ok(mesh) = meshing::load(root, &Sink::new()) {
                say_mesh(session, root, &mesh.poly, &check(&mesh.poly))?;
            }
            return Err(CaseError::Invalid.into());
        }
        Err(e) => return Err(e.into()),
    };
    let report = check(&case.poly);
    say_mesh(session, root, &case.poly, &report)?;
    if report.ok() {
        say_all(session, &case, &initial)?;
    } else {
        session.speak_up();
    }
    need_sound_mesh(&report)?;
    session.out.say("the case can be run");
    Ok(())
}

/// `--mesh`: of a case that may have nothing else yet.
fn mesh_alone(session: &mut Session, root: &Path) -> Result<(), Failure> {
    let poly = meshing::load(root, &session.sink)?.poly;
    let report = check(&poly);
    say_mesh(session, root, &poly, &report)?;
    session.speak_up();
    need_sound_mesh(&report)
}

/// The report; the cells it finds fault with go to a file.
fn say_mesh(
    session: &mut Session,
    root: &Path,
    poly: &PolyMesh,
    report: &CheckReport,
) -> Result<(), Failure> {
    session.out.say("== Mesh");
    session.out.say(&report.to_string());
    let n = bad_cells::write(root, poly, report)?;
    if n > 0 {
        let file = place(root, bad_cells::BAD_CELLS);
        session.out.say(&format!("{} written to {file}", count(n, "cell")));
    }
    session.out.say("");
    Ok(())
}

/// The sections behind the mesh, then what else was found in the files.
fn say_all(session: &mut Session, case: &Case, initial: &Initial) -> Result<(), Failure> {
    let (mapped, other): (Vec<String>, Vec<String>) =
        session.notices.take().into_iter().partition(|n| numerics::is_of(n));
    let outlook = Outlook::of(case);
    let mut page = Page::default();
    phases::say(case, &mut page);
    let folder = initial.shown(&case.start.dir);
    conditions::say(case, &outlook, folder, &mut page);
    numerics::say(case, &mapped, &mut page);
    resolution::say(case, &outlook, &mut page);
    regime::say(case, &outlook, &mut page);
    time_step::say(case, &outlook, &mut page);
    cost::say(case, &outlook, &mut page);
    let unread = strays::unread(&case.root, &case.start.dir, &case.config)?;
    let renamed = |f: String| match f.strip_prefix(&format!("{}/", case.start.dir)) {
        Some(rest) => format!("{folder}/{rest}"),
        None => f,
    };
    let unread: Vec<String> = unread.into_iter().map(renamed).collect();
    if !unread.is_empty() || !other.is_empty() {
        page.open("Notes");
        if !unread.is_empty() {
            page.say("not read", unread.join(", "));
        }
        other.iter().for_each(|n| page.say("note", n));
    }
    let found = session.sink.take();
    let warnings = page.warnings() + found.n_warnings();
    session.sink.extend(found);
    for line in page.lines() {
        session.out.say(&line);
    }
    session.out.say("");
    session.speak_up();
    if warnings > 0 {
        session.out.say(&crate::text::count(warnings, "warning"));
    }
    Ok(())
}
