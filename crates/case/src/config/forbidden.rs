//! What OpenFOAM can do and this program cannot: refused by name, never ignored.

use crate::{CaseError, files};
use granflow_dict::{Dict, Reader, Sink, Value};
use std::path::Path;

/// Files whose mere content would change the physics.
const SOURCES: &[(&str, &str)] = &[
    ("constant/fvModels", "source terms (fvModels)"),
    ("system/fvModels", "source terms (fvModels)"),
    ("constant/fvConstraints", "constraints (fvConstraints)"),
    ("system/fvConstraints", "constraints (fvConstraints)"),
    ("constant/SRFProperties", "rotating frames (SRF)"),
];

/// Of laminar models only the plain one: viscosity is the business of `transportProperties`.
fn refuse_laminar_model(r: &Reader<'_>) {
    let Some(laminar) = r.entry("laminar").and_then(|_| r.opt_sub("laminar")) else { return };
    let key = if laminar.has("laminarModel") { "laminarModel" } else { "model" };
    let model = laminar.opt_word(key, "Stokes");
    if !matches!(model, "Stokes" | "Newtonian") {
        let help =
            "write `laminarModel Stokes;`; fluids whose viscosity varies are a `transportModel`";
        let message = format!("the laminar model `{model}` is not supported");
        laminar.error_at_key(key, message, "only `Stokes`", Some(help));
    }
    laminar.ignore_all();
}

/// Refuses turbulence, moving meshes and source terms.
///
/// # Errors
/// A file is there and cannot be read.
pub(super) fn refuse(root: &Path, sink: &Sink) -> Result<(), CaseError> {
    for file in ["constant/turbulenceProperties", "constant/momentumTransport"] {
        let Some(dict) = files::dict(root, file, sink)? else { continue };
        let r = Reader::new(&dict, sink);
        let kind = r.opt_word("simulationType", "laminar");
        if kind != "laminar" {
            r.error_at_key(
                "simulationType",
                format!("turbulence models are not supported: `simulationType {kind}`"),
                "only `laminar`",
                Some("write `simulationType laminar;`"),
            );
        }
        refuse_laminar_model(&r);
    }
    if let Some(dict) = files::dict(root, "constant/dynamicMeshDict", sink)? {
        let r = Reader::new(&dict, sink);
        let kind = r.opt_word("dynamicFvMesh", "staticFvMesh");
        if kind != "staticFvMesh" || r.has("mover") || r.has("topoChanger") {
            let key = if kind == "staticFvMesh" { "mover" } else { "dynamicFvMesh" };
            r.error_at_key(
                key,
                "moving meshes are not supported",
                "asked for here",
                Some("remove constant/dynamicMeshDict, or write `dynamicFvMesh staticFvMesh;`"),
            );
        }
    }
    for (file, what) in SOURCES {
        let Some(dict) = files::dict(root, file, sink)? else { continue };
        let r = Reader::new(&dict, sink);
        let active = |d: &Dict| !matches!(d.word("active"), Some("no" | "off" | "false"));
        for e in &dict.entries {
            if let Value::Dict(d) = &e.value
                && e.key.text() != "FoamFile"
                && active(d)
            {
                r.error_at(
                    &e.key_span,
                    format!("{what} are not supported: `{}`", e.key.text()),
                    "would act on the flow",
                    Some("remove it or add `active no;`"),
                );
            }
        }
    }
    Ok(())
}
