//! `granflow mesh`: `system/blockMeshDict` becomes `constant/polyMesh`.

use super::need_case;
use crate::args::Place;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::place;
use granflow_case::meshing;
use granflow_case::store::CaseLock;
use granflow_mesh::check::check;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Place) -> Result<(), Failure> {
    need_case(&args.case)?;
    let _lock = CaseLock::take(&args.case)?;
    let poly = meshing::make(&args.case, &session.sink)?;
    session.speak_up();
    session.out.say(&check(&poly).to_string());
    session.out.say(&format!("written to {}", place(&args.case, meshing::POLY_MESH)));
    Ok(())
}
