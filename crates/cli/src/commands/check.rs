//! `granflow check`: reads and checks everything, says what a run would meet; changes nothing, but
//! puts the cells of a poor mesh into a file of their own.

use super::init::Initial;
use super::{need_case, need_sound_mesh};
use crate::args::Check;
use crate::estimate;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::{count, place};
use granflow_case::{Case, CaseError, Options, bad_cells, meshing};
use granflow_dict::Sink;
use granflow_mesh::PolyMesh;
use granflow_mesh::check::{CheckReport, check};
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
    session.speak_up();
    need_sound_mesh(&report)?;
    for line in estimate::lines(&case) {
        session.out.say(&line);
    }
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
    session.out.say(&report.to_string());
    let n = bad_cells::write(root, poly, report)?;
    if n > 0 {
        let file = place(root, bad_cells::BAD_CELLS);
        session.out.say(&format!("{} written to {file}", count(n, "cell")));
    }
    session.out.say("");
    Ok(())
}
