//! `granflow plot`: the figures of `system/plotDict`.

use super::need_case;
use crate::args::Place;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::shown;
use granflow_case::figures;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Place) -> Result<(), Failure> {
    need_case(&args.case)?;
    let files = figures::draw(&args.case, &session.sink)?;
    session.speak_up();
    if files.is_empty() {
        session.out.say("no figures: the case has no system/plotDict, or no figure in it");
    }
    for file in files {
        session.out.say(&format!("figure  {}", shown(&file)));
    }
    Ok(())
}
