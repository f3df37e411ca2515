//! `constant/fvOptions` (or `system/fvOptions`): forces on the bulk beside gravity.
//!
//! Done are those of [`ALL`]; the others are refused by name. In a case with one fluid the forces are per
//! density, as OpenFOAM's solvers for one fluid have them; with two they are forces.

use crate::{CaseError, Zones, files};
use granflow_base::dot;
use granflow_dict::{Reader, Severity, Sink, nearest};
use granflow_flow::sources::{ALL, Given, Source, Zone};
use granflow_mesh::Mesh;
use std::path::Path;

/// Cosine of the angle between directions that have nothing to do with each other.
const ACROSS: f64 = 1e-6;

/// Where the dictionary may be.
const FILES: [&str; 2] = ["constant/fvOptions", "system/fvOptions"];

/// Whether the case has such a file.
pub(crate) fn present(root: &Path) -> bool {
    FILES.iter().any(|file| files::exists(root, file))
}

/// Reads the sources of a case, their zones in the user's numbering. `rho` is the density that
/// accelerations are multiplied with to make forces, 1 where forces are given, `two` whether there are two phases. Mistakes go to the sink.
///
/// # Errors
/// A file is there and cannot be read.
pub(crate) fn read(
    root: &Path,
    mesh: &Mesh,
    zones: &Zones,
    (rho, two): (f64, bool),
    sink: &Sink,
) -> Result<Vec<Box<dyn Source>>, CaseError> {
    let mut sources = Vec::new();
    let mut found = None;
    for file in FILES {
        // The first that is there, as OpenFOAM has it.
        found = files::dict(root, file, sink)?;
        if found.is_some() {
            break;
        }
    }
    if let Some(dict) = found {
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
            let kind = r.word("type").to_owned();
            // Entries stand beside the type, or in a dictionary of their own.
            let inner = r.opt_sub(&format!("{kind}Coeffs"));
            let of = inner.as_ref().unwrap_or(&r);
            match ALL.iter().find(|e| e.names.contains(&kind.as_str())) {
                Some(entry) => {
                    let zone = zone(of, &r, zones);
                    let of = Given { name, r: of, outer: &r, mesh, zone, rho, two };
                    let new = (entry.read)(&of);
                    warn_of_rivals(&r, &new, &sources);
                    sources.extend(new);
                }
                None if kind.is_empty() => {}
                None => {
                    let known: Vec<&str> = ALL.iter().flat_map(|e| e.names).copied().collect();
                    let near = nearest(&kind, known.iter().copied());
                    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
                    let help = format!("{near}there are {}; or add `active no;`", known.join(", "));
                    let message = format!("the source `{kind}` is not done here");
                    r.error_at_key("type", message, "not available", Some(&help));
                    r.ignore_all();
                    if let Some(inner) = &inner {
                        inner.ignore_all();
                    }
                }
            }
            for key in ["selectionMode", "cellZone", "cellSet", "fields"] {
                r.ignore(key);
            }
            if let Some(inner) = &inner {
                inner.finish(Severity::Error);
            }
            r.finish(Severity::Error);
        }
        all.finish(Severity::Warning);
    }
    Ok(sources)
}

/// Of two held mean velocities in the same cells each takes back what the other does.
fn warn_of_rivals(r: &Reader<'_>, new: &[Box<dyn Source>], before: &[Box<dyn Source>]) {
    for held in new.iter().filter_map(|s| s.held()) {
        for other in before.iter().filter_map(|s| s.held()) {
            // Across each other they get on.
            let along = dot(held.direction, other.direction).abs();
            if along > ACROSS && held.zone.meets(&other.zone) {
                let message = format!(
                    "`{}` and `{}` hold a mean velocity in the same cells: each works against the other",
                    other.name, held.name
                );
                let help = "leave one out, or give them zones without a cell in common";
                r.warn_at_key("type", message, "the second one", Some(help));
            }
        }
    }
}

/// Where a source acts: `selectionMode`, in the dictionary of its type or around it.
fn zone<'d>(inner: &Reader<'d>, outer: &Reader<'d>, zones: &Zones) -> Zone {
    let with = |key: &str| if inner.has(key) { inner } else { outer };
    let r = with("selectionMode");
    let modes = [("all", 0), ("cellZone", 1), ("cellSet", 2), ("points", 3)];
    let key = match r.one_of("selectionMode", &modes) {
        0 => return Zone::All,
        1 => "cellZone",
        2 => "cellSet",
        _ => {
            let help = Some("write `cellZone` and make one with system/topoSetDict");
            r.error_at_key("selectionMode", "`points` is not done here", "set here", help);
            return Zone::All;
        }
    };
    Zone::Cells(zones.filled(with(key), key))
}
