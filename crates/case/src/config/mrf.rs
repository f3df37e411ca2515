//! `constant/MRFProperties`: zones of cells in frames that turn.

use crate::{CaseError, Zones, files};
use granflow_base::{Dims, cross, dot, norm};
use granflow_dict::{Reader, Severity, Sink, Value, nearest};
use granflow_flow::sources::{RotatingFrame, Source, Zone};
use granflow_fv::TimeFunction;
use granflow_fv::conditions::CaseContext;
use granflow_mesh::{Mesh, PatchKind};
use std::path::Path;

const FILE: &str = "constant/MRFProperties";

/// Whether the case has such a file.
pub(crate) fn present(root: &Path) -> bool {
    files::exists(root, FILE)
}

/// Reads the frames of a case, their zones in the user's numbering. Mistakes go to the sink.
///
/// # Errors
/// The file is there and cannot be read.
pub(crate) fn read(
    root: &Path,
    mesh: &Mesh,
    zones: &Zones,
    case: CaseContext<'_>,
    sink: &Sink,
) -> Result<Vec<Box<dyn Source>>, CaseError> {
    let mut frames: Vec<Box<dyn Source>> = Vec::new();
    let Some(dict) = files::dict(root, FILE, sink)? else { return Ok(frames) };
    let all = Reader::new(&dict, sink);
    all.ignore("FoamFile");
    for (name, r) in all.subs() {
        if name == "FoamFile" {
            continue;
        }
        if !r.opt_switch("active", true) {
            r.ignore_all();
            continue;
        }
        let frame = frame(name, &r, mesh, zones, case);
        refuse_open_patches(&r, &frame, mesh);
        warn_of_edges(&r, &frame, mesh);
        frames.push(Box::new(frame));
        r.finish(Severity::Error);
    }
    refuse_bare(&all);
    all.finish(Severity::Warning);
    Ok(frames)
}

/// Entries of a frame that stand in no dictionary of their own turn nothing.
fn refuse_bare(all: &Reader<'_>) {
    const OF_A_FRAME: [&str; 6] =
        ["cellZone", "active", "nonRotatingPatches", "origin", "axis", "omega"];
    let bare = all.dict().entries.iter();
    // What a macro stands for is there for others.
    let bare = bare.filter(|e| OF_A_FRAME.contains(&e.key.text()) && !e.referenced);
    let mut told = false;
    for entry in bare.filter(|e| matches!(e.value, Value::Stream(_))) {
        all.take(entry);
        if !std::mem::replace(&mut told, true) {
            let message =
                format!("`{}` stands outside of the dictionary of a zone", entry.key.text());
            let help = "every zone has one, under any name: `rotor { cellZone rotor; origin (0 0 0); axis (0 0 1); \
                        omega 10; }`";
            all.error_at(&entry.key_span, message, "expected `<name> {` before this", Some(help));
        }
    }
}

fn frame(
    name: &str,
    r: &Reader<'_>,
    mesh: &Mesh,
    zones: &Zones,
    case: CaseContext<'_>,
) -> RotatingFrame {
    let cells = zones.filled(r, "cellZone");
    let origin = r.vector("origin", Dims::LENGTH);
    let axis = r.direction("axis");
    let empty = (0..3).filter(|k| !mesh.solved_dirs[*k]);
    let across = empty.map(|k| {
        let mut e = [0.0; 3];
        e[k] = 1.0;
        norm(cross(axis, e))
    });
    if across.fold(0.0, f64::max) > 1e-6 {
        let help = Some("of a plane mesh the axis is the direction without cells side by side");
        r.error_at_key("axis", "the frame turns out of the plane", "not across the mesh", help);
    }
    let still = patches(r, mesh);
    let omega = TimeFunction::read(r, "omega", Dims::RATE, case);
    let (name, zone) = (name.to_owned(), Zone::Cells(cells));
    RotatingFrame { name, zone, origin, axis, omega, still }
}

/// `nonRotatingPatches`.
fn patches(r: &Reader<'_>, mesh: &Mesh) -> Vec<String> {
    let named = r.maybe_words("nonRotatingPatches").unwrap_or_default();
    let known = || mesh.patches.iter().map(|p| p.name.as_str());
    for name in &named {
        if !known().any(|k| k == *name) {
            let help = nearest(name, known()).map(|n| format!("did you mean `{n}`?"));
            let message = format!("there is no patch `{name}`");
            r.error_at_key("nonRotatingPatches", message, "not known", help.as_deref());
        }
    }
    named.into_iter().map(str::to_owned).collect()
}

/// Sine of the angle between the frame's velocity and the zone's surface from which on it is told.
const EDGE: f64 = 0.02;

/// Where the zone ends the frame must not pass through its surface: what does is flux that the cells outside
/// lack.
fn warn_of_edges(r: &Reader<'_>, frame: &RotatingFrame, mesh: &Mesh) {
    let Zone::Cells(cells) = &frame.zone else { return };
    let mut here = vec![false; mesh.n_cells];
    cells.iter().for_each(|c| here[*c as usize] = true);
    // Ghosts are images of cells.
    let inside = |c: u32| here[mesh.global_cell[c as usize] as usize];
    let mut most = 0.0f64;
    for f in (0..mesh.n_inner).filter(|f| (mesh.neighbour[*f] as usize) < mesh.n_cells) {
        if inside(mesh.owner[f]) != inside(mesh.neighbour[f]) {
            let arm = frame.arm(mesh.face_centre[f]);
            let size = norm(arm) * mesh.mag_area[f];
            most = most.max(dot(arm, mesh.area[f]).abs() / size.max(f64::MIN_POSITIVE));
        }
    }
    if most > EDGE {
        let message = format!(
            "the zone `{}` is not round about its axis: the frame passes through its surface",
            r.word("cellZone")
        );
        let label = format!("by up to {:.0} % of its speed", 100.0 * most);
        let help = Some("end the zone on faces that lie around the axis");
        r.warn_at_key("cellZone", message, label, help);
    }
}

/// What is no wall does not turn: it has to be said, as in the reference tool it would become a wall.
fn refuse_open_patches(r: &Reader<'_>, frame: &RotatingFrame, mesh: &Mesh) {
    let Zone::Cells(cells) = &frame.zone else { return };
    let mut here = vec![false; mesh.n_cells];
    cells.iter().for_each(|c| here[*c as usize] = true);
    let inside = |f: usize| here[mesh.global_cell[mesh.owner[f] as usize] as usize];
    for p in mesh.patches.iter().filter(|p| p.kind == PatchKind::Patch) {
        if !frame.still.contains(&p.name) && p.faces.clone().any(inside) {
            let message = format!("the patch `{}` lies in the zone and is no wall", p.name);
            let help = format!("write `nonRotatingPatches ({});`, or make it a wall", p.name);
            r.error_at_key("cellZone", message, "turns with its walls", Some(&help));
        }
    }
}
