//! Functions of OpenFOAM that are refused by name, each with the reason.

use granflow_dict::Reader;

const TURBULENCE: &str = "the flow is laminar: there is no turbulence model to ask";
const SCALARS: &str = "no further equation is solved beside the flow's";
const MOVING: &str = "meshes do not move";

/// Names and reasons.
pub(super) const ALL: &[(&str, &str)] = &[
    ("yPlus", TURBULENCE),
    ("turbulenceFields", TURBULENCE),
    ("DESModelRegions", TURBULENCE),
    ("energySpectrum", TURBULENCE),
    ("scalarTransport", SCALARS),
    ("energyTransport", SCALARS),
    ("extractEulerianParticles", "there are no particles beside the fluids"),
    ("sixDoFRigidBodyState", MOVING),
    ("pointHistory", MOVING),
    ("mapFields", "a case is mapped onto no other"),
    ("Curle", "sound is not computed"),
    ("lambVector", "`vorticity` and `U` give it: U x vorticity is made in ParaView"),
    ("columnAverage", "average along a direction in ParaView"),
    ("patchProbes", "use `probes` at points on the patch"),
    ("wallHeatFlux", "there is no temperature"),
    ("coded", "granflow does not compile C++"),
];

/// Refuses `#includeFunc` of what has no dictionary.
pub(super) fn packaged(r: &Reader<'_>, name: &str) {
    let known: Vec<&str> = granflow_dict::PACKAGED_FUNCTIONS.iter().map(|f| f.0).collect();
    let short = name.split('(').next().unwrap_or(name);
    let near = granflow_dict::nearest(short, known.iter().copied());
    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
    let help = format!(
        "{near}write system/{short} with the function's dictionary, or one of {}",
        known.join(", ")
    );
    let message = format!("there is no function `{name}` to include");
    r.error_at_key("includeFunc", message, "not found in `system` nor built in", Some(&help));
}
