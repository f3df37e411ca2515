//! Axes that a dictionary gives: `coordinateSystem`, `e1`, `e2`, `e3`.

use granflow_base::{Dims, Vec3, cross, dot, norm, scale, sub, unit};
use granflow_dict::Reader;

const SPACE: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Origin and axes that stand in `coordinateSystem` or beside it.
pub fn axes_of(r: &Reader<'_>) -> (Vec3, [Vec3; 3]) {
    let origin = r.maybe_vector("origin", Dims::LENGTH);
    if let Some(system) = r.opt_sub("coordinateSystem") {
        let inner = system.maybe_vector("origin", Dims::LENGTH);
        return (origin.or(inner).unwrap_or_default(), axes(r));
    }
    let turned = ["rotation", "coordinateRotation"].iter().any(|k| r.has(k));
    (origin.unwrap_or_default(), if turned { rotated(r, r) } else { SPACE })
}

/// The axes of `coordinateSystem`, or those of space.
pub(super) fn axes(r: &Reader<'_>) -> [Vec3; 3] {
    let Some(system) = r.opt_sub("coordinateSystem") else { return SPACE };
    for key in ["type", "origin"] {
        system.ignore(key);
    }
    let found = rotated(r, &system);
    system.ignore_all();
    found
}

/// The axes `e1` and `e2` (or `e3`) of `system`, perhaps in `rotation`; what is wrong is said of `r`.
fn rotated(r: &Reader<'_>, system: &Reader<'_>) -> [Vec3; 3] {
    let own = SPACE;
    let turned = system.opt_sub("rotation").or_else(|| {
        system.entry("coordinateRotation").and_then(|_| system.opt_sub("coordinateRotation"))
    });
    let of = turned.as_ref().unwrap_or(system);
    let kinds = [("axes", "axes"), ("axesRotation", "axes"), ("none", "none")];
    let kind = match turned {
        Some(_) => of.opt_one_of("type", &kinds, "axes"),
        // Here it may be that of the system: `cartesian`.
        None => of.opt_word("type", "axes"),
    };
    let (e1, e2, e3) = (
        of.maybe_vector("e1", Dims::NONE),
        of.maybe_vector("e2", Dims::NONE),
        of.maybe_vector("e3", Dims::NONE),
    );
    let found = match (e1, e2, e3) {
        _ if kind == "none" => Some(own),
        (None, None, None) if kind == "axes" => Some(own),
        (Some(a), Some(b), _) => right_handed(a, b),
        (None, Some(b), Some(c)) => right_handed(b, c).map(|[b, c, a]| [a, b, c]),
        (Some(a), None, Some(c)) => right_handed(c, a).map(|[c, a, b]| [a, b, c]),
        _ => None,
    };
    if let Some(turned) = &turned {
        turned.ignore_all();
    }
    found.unwrap_or_else(|| {
        let help = Some("give two of them, not along each other: `e1 (1 0 0); e2 (0 1 0);`");
        let given = ["e1", "e2", "e3"].into_iter().find(|key| of.has(key));
        match given {
            Some(key) => of.error_at_key(key, "two axes are needed", "they span no plane", help),
            None => r.error_at_key("coordinateSystem", "the axes are not given", "needs two", help),
        }
        own
    })
}

/// Unit vectors along `a`, along `b` as far as it is perpendicular to `a`, and along `a x b`.
fn right_handed(a: Vec3, b: Vec3) -> Option<[Vec3; 3]> {
    let a = unit(a);
    let b = sub(b, scale(a, dot(a, b)));
    (norm(a) > 0.0 && norm(b) > 0.0).then(|| [a, unit(b), cross(a, unit(b))])
}
