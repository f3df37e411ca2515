//! Gradients of `gradSchemes`: how they are taken, and what limits them for convection.

use super::schemes::{GradientKind, unknown};
use crate::Notices;
use granflow_dict::Reader;
use granflow_fv::GradientLimiter;

/// Interpolations to faces that `Gauss linear` stands for.
const INTERPOLATIONS: &[&str] =
    &["linear", "pointLinear", "midPoint", "skewCorrected", "cubic", "harmonic", "reverseLinear"];

/// The scheme under `key`, and its limiter if it has one.
pub(super) fn read(
    r: &Reader<'_>,
    key: &str,
    notices: &Notices,
) -> (GradientKind, Option<GradientLimiter>) {
    let Some(mut t) = r.tokens(key) else { return (GradientKind::GaussLinear, None) };
    let mut at = t.here();
    let mut word = t.word("the gradient scheme");
    let limit = GradientLimiter::NAMES.iter().find(|(name, _)| *name == word).map(|(_, l)| *l);
    if limit.is_some() {
        at = t.here();
        word = t.word("the gradient scheme");
    }
    let kind = match word {
        "Gauss" => match t.opt_word() {
            None | Some("linear") => GradientKind::GaussLinear,
            Some(other) if INTERPOLATIONS.contains(&other) => {
                notices.say(format!("gradSchemes: `Gauss {other}` is served by `Gauss linear`"));
                GradientKind::GaussLinear
            }
            Some(other) => {
                unknown(&t, &t.last_span(), "interpolation", other, INTERPOLATIONS);
                GradientKind::GaussLinear
            }
        },
        "leastSquares" => GradientKind::LeastSquares,
        "pointCellsLeastSquares" | "edgeCellsLeastSquares" | "fourth" | "iterativeGauss" => {
            notices.say(format!("gradSchemes: `{word}` is served by `leastSquares`"));
            GradientKind::LeastSquares
        }
        "" => GradientKind::GaussLinear,
        _ => {
            let mut known = vec!["Gauss", "leastSquares"];
            known.extend(GradientLimiter::NAMES.map(|(name, _)| name));
            unknown(&t, &at, "gradient scheme", word, &known);
            GradientKind::GaussLinear
        }
    };
    let limiter = limit.map(|limit| {
        let given = t.opt_number();
        if given.is_none() {
            let help = "write it behind: `cellLimited Gauss linear 1`, 1 limits most, 0 not at all";
            t.error_at(
                &t.last_span(),
                "a gradient limiter needs its number",
                "no number",
                Some(help),
            );
        }
        let k = given.unwrap_or(1.0);
        if !(0.0..=1.0).contains(&k) {
            let message = "the number of a gradient limiter lies between 0 (none) and 1 (bounded)";
            t.error_at(&t.last_span(), message, "out of range", None);
        }
        GradientLimiter { limit, k }
    });
    (kind, limiter)
}
