//! Whose forms a single pass has: ours, or those of OpenFOAM's solvers of one and of two fluids where a case is made for one of
//! these or `compatible yes;` asks for them.

use super::schemes::{COMPATIBLE, unknown};
use crate::Notices;
use granflow_dict::{Dict, Reader, Sink};
use granflow_flow::TimeScheme;

/// Applications whose cases have OpenFOAM's forms by themselves, where viscosities are constant. With one that follows
/// the flow they may be unstable: `offsetCylinder`, the tutorial of `nonNewtonianIcoFoam`, lives there on its solvers' loose tolerance.
const PEERS: &[&str] = &["icoFoam", "pisoFoam"];
/// Applications whose cases with two fluids of constant viscosity have OpenFOAM's forms by themselves.
const PEERS_OF_TWO: &[&str] = &["interFoam", "interIsoFoam"];

/// Whose forms a case has.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Forms {
    Ours,
    /// OpenFOAM's, since the case is one of its applications', but for what makes and loses volume.
    Theirs,
    /// OpenFOAM's, since `compatible yes;` asks for them: all of them.
    AskedFor,
}

/// What decides.
pub(super) struct Kind {
    pub(super) two: bool,
    pub(super) grains: bool,
    pub(super) newtonian: bool,
    /// Outer iterations.
    pub(super) outer: usize,
    pub(super) ddt: TimeScheme,
}

/// Whose the forms are; to ask for OpenFOAM's where they do not exist is a mistake, and where a case of two fluids does not
/// have them for what else it says, it is told.
pub(super) fn decide(
    schemes: Option<&Dict>,
    application: &str,
    kind: &Kind,
    (sink, notices): (&Sink, &Notices),
) -> Forms {
    let why_not = why_not(kind);
    let Some(dict) = schemes.filter(|d| d.get(COMPATIBLE).is_some()) else {
        let peers = if kind.two { PEERS_OF_TWO } else { PEERS };
        let of_a_peer = peers.contains(&application);
        if let Some((why, _)) = why_not.filter(|_| of_a_peer && kind.two && !kind.grains) {
            notices.say(format!("fvSchemes: not the forms of {application} but our own, as {why}"));
        }
        let theirs = why_not.is_none() && kind.newtonian && of_a_peer;
        return if theirs { Forms::Theirs } else { Forms::Ours };
    };
    let r = Reader::new(dict, sink);
    let asked = r.opt_switch(COMPATIBLE, false);
    if let Some((message, help)) = why_not.filter(|_| asked) {
        r.error_at_key(COMPATIBLE, message, "not available", Some(help));
    }
    if asked { Forms::AskedFor } else { Forms::Ours }
}

/// What keeps the forms of OpenFOAM from being there, and what to do about it.
fn why_not(kind: &Kind) -> Option<(&'static str, &'static str)> {
    Some(if kind.two && !kind.newtonian {
        (
            "`compatible` with two fluids is for constant viscosities",
            "leave it out: our forms hold then",
        )
    } else if kind.ddt != TimeScheme::Euler {
        ("`compatible` goes with the time scheme Euler", "write `ddtSchemes { default Euler; }`")
    } else if kind.outer > 1 || kind.grains {
        (
            "`compatible` is for PISO, a single pass",
            "leave it out: outer iterations solve momentum and continuity together",
        )
    } else {
        return None;
    })
}

/// Whether `div(phirb,alpha)` asks for a compression that is central everywhere, if it is there.
pub(super) fn compression(r: &Reader<'_>) -> Option<bool> {
    const KEY: &str = "div(phirb,alpha)";
    let mut t = r.has(KEY).then(|| r.tokens(KEY)).flatten()?;
    let mut at = t.here();
    let mut word = t.word("the scheme of the compression");
    if word == "Gauss" {
        at = t.here();
        word = t.word("the scheme of the compression");
    }
    match word {
        "linear" => Some(true),
        // With the limiter of the convection behind it, perhaps.
        "interfaceCompression" => Some(false),
        "" | "none" => None,
        _ => {
            unknown(&t, &at, "compression", word, &["linear", "interfaceCompression"]);
            None
        }
    }
}
