//! `granflow mesh`: `system/blockMeshDict` or another program's file becomes `constant/polyMesh`.

use super::need_case;
use crate::args::Mesh;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::{count, place, shown};
use granflow_case::meshing;
use granflow_case::store::CaseLock;
use granflow_mesh::PolyMesh;
use granflow_mesh::check::check;
use granflow_mesh::import::Options;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Mesh) -> Result<(), Failure> {
    need_case(&args.case)?;
    let _lock = CaseLock::take(&args.case)?;
    let poly = match &args.from {
        Some(file) => import(session, args, file)?,
        None => meshing::make(&args.case, &session.sink)?,
    };
    session.speak_up();
    session.out.say(&check(&poly).to_string());
    for zone in &poly.cell_zones {
        session.out.say(&format!("zone {}: {}", zone.name, count(zone.cells.len(), "cell")));
    }
    session.out.say(&format!("written to {}", place(&args.case, meshing::POLY_MESH)));
    if args.from.is_some() {
        session.out.say(&hint(&poly));
    }
    Ok(())
}

fn import(session: &mut Session, args: &Mesh, file: &Path) -> Result<PolyMesh, Failure> {
    let options = Options {
        scale: args.scale,
        thickness: args.thickness,
        feature_angle: args.feature_angle,
        group_array: args.groups.clone(),
    };
    let imported = meshing::import(&args.case, file, &options, &session.sink)?;
    session.out.say(&format!("{}: a mesh of {}", shown(file), imported.format));
    for note in &imported.notes {
        session.out.say(&format!("note: {note}"));
    }
    Ok(imported.mesh)
}

/// What the rest of the case has to say about the patches.
fn hint(poly: &PolyMesh) -> String {
    let patches: Vec<String> =
        poly.patches.iter().map(|p| format!("{} ({})", p.name, p.kind.word())).collect();
    format!(
        "boundaryField of every file in 0 needs: {}\ntypes can be changed in {}/boundary",
        patches.join(", "),
        meshing::POLY_MESH
    )
}
