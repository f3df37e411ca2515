//! Patch types as `boundary` lists and `blockMeshDict` write them.

use crate::polymesh::{CyclicTransform, PatchKind};
use granflow_base::Dims;
use granflow_dict::{Reader, nearest};

/// Every type a patch may have.
const KNOWN: [&str; 7] = ["patch", "wall", "empty", "symmetry", "symmetryPlane", "wedge", "cyclic"];

/// The kind named by a word, if it needs no further entries.
pub(crate) fn simple_kind(word: &str) -> Option<PatchKind> {
    Some(match word {
        "patch" => PatchKind::Patch,
        "wall" => PatchKind::Wall,
        "empty" => PatchKind::Empty,
        "symmetry" => PatchKind::Symmetry,
        "symmetryPlane" => PatchKind::SymmetryPlane,
        "wedge" => PatchKind::Wedge,
        _ => return None,
    })
}

/// Reads `type` and what belongs to it; errors go to the reader's sink.
pub(crate) fn read_kind(r: &Reader<'_>) -> PatchKind {
    let word = r.word("type");
    if let Some(kind) = simple_kind(word) {
        return kind;
    }
    if word == "cyclic" {
        return read_cyclic(r);
    }
    if !word.is_empty() {
        let help = refusal(word);
        r.error_at(
            &r.value_span("type"),
            format!("patches of type `{word}` are not supported"),
            "unknown patch type",
            Some(&help),
        );
    }
    // Entries of a type we refuse are not to be reported a second time.
    r.ignore_all();
    PatchKind::Patch
}

/// Why a type is refused, or what may have been meant.
pub(crate) fn refusal(word: &str) -> String {
    match word {
        "processor" | "processorCyclic" => {
            "this is one part of a decomposed mesh: give the whole mesh, it is cut when the run \
             starts"
                .into()
        }
        "cyclicAMI" | "cyclicACMI" | "cyclicSlip" => {
            "use `cyclic` with faces that match one to one".into()
        }
        "mappedPatch" => "use `patch`".into(),
        "mappedWall" => "use `wall`".into(),
        _ => {
            let all = KNOWN.join(", ");
            nearest(word, KNOWN).map_or_else(
                || format!("known types are {all}"),
                |n| format!("did you mean `{n}`? known types are {all}"),
            )
        }
    }
}

fn read_cyclic(r: &Reader<'_>) -> PatchKind {
    let neighbour = r.word("neighbourPatch").to_owned();
    let word = r.opt_word("transform", "unknown");
    r.ignore("matchTolerance");
    let separation = r.maybe_vector("separationVector", Dims::LENGTH);
    let axis = r.maybe_vector("rotationAxis", Dims::NONE);
    let centre = r.maybe_vector("rotationCentre", Dims::LENGTH);
    let angle = r.maybe_scalar("rotationAngle", Dims::NONE).map(f64::to_radians);
    let missing = |key: &str| {
        r.error_at(
            &r.value_span("transform"),
            format!("a {word} cyclic patch needs `{key}`"),
            "asked for here",
            None,
        );
    };
    let transform = match word {
        "unknown" | "noOrdering" | "coincidentFullMatch" => CyclicTransform::Unknown,
        "translational" => match separation {
            Some(s) => CyclicTransform::Translational(s),
            None => {
                missing("separationVector");
                CyclicTransform::Unknown
            }
        },
        "rotational" => match (axis, centre) {
            (Some(axis), Some(origin)) => CyclicTransform::Rotational { axis, origin, angle },
            (None, _) => {
                missing("rotationAxis");
                CyclicTransform::Unknown
            }
            (_, None) => {
                missing("rotationCentre");
                CyclicTransform::Unknown
            }
        },
        _ => {
            r.error_at(
                &r.value_span("transform"),
                format!("unknown transform `{word}`"),
                "not a transform of cyclic patches",
                Some("known are unknown, translational, rotational"),
            );
            CyclicTransform::Unknown
        }
    };
    PatchKind::Cyclic { neighbour, transform }
}
