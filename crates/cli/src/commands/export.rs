//! `granflow export`: the times of a case as VTK files.

use super::need_case;
use crate::args::Place;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::{count, place};
use granflow_case::export::{COLLECTION, export};

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Place) -> Result<(), Failure> {
    need_case(&args.case)?;
    let done = export(&args.case, &session.sink)?;
    session.speak_up();
    session.out.say(&format!(
        "{}: {} of {}",
        place(&args.case, COLLECTION),
        count(done.times.len(), "time"),
        if done.fields.is_empty() { "the mesh alone".to_owned() } else { done.fields.join(", ") },
    ));
    Ok(())
}
