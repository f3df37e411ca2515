//! `granflow check`: reads and checks everything, says what a run would meet; changes nothing.

use super::init::Initial;
use super::{need_case, need_sound_mesh};
use crate::args::Check;
use crate::estimate;
use crate::failure::Failure;
use crate::session::Session;
use granflow_case::{Case, CaseError, Options, meshing};
use granflow_dict::Sink;
use granflow_mesh::check::{CheckReport, check};

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Check) -> Result<(), Failure> {
    let root = args.case.as_path();
    need_case(root)?;
    // Taken back when this function returns.
    let initial = Initial::prepare(root)?;
    let loaded = Case::load(root, &Options::default(), &session.sink, &session.notices);
    initial.restate(root, &session.sink);
    let case = match loaded {
        Ok(case) => case,
        Err(CaseError::Invalid) => {
            // What is wrong with a mesh is said with all its places, not as the first mistake.
            if let Ok(mesh) = meshing::load(root, &Sink::new()) {
                say_mesh(session, &check(&mesh.poly));
            }
            return Err(CaseError::Invalid.into());
        }
        Err(e) => return Err(e.into()),
    };
    let report = check(&case.poly);
    say_mesh(session, &report);
    session.speak_up();
    need_sound_mesh(&report)?;
    for line in estimate::lines(&case) {
        session.out.say(&line);
    }
    session.out.say("the case can be run");
    Ok(())
}

fn say_mesh(session: &mut Session, report: &CheckReport) {
    session.out.say(&report.to_string());
    session.out.say("");
}
