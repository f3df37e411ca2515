//! What normal derivatives on faces lack where the line of centres leans: `laplacianSchemes` and
//! `snGradSchemes`.

use super::schemes::{first_of, unknown};
use crate::Notices;
use granflow_dict::{Reader, TokenReader};
use granflow_flow::NormalDerivative;

const KNOWN: [&str; 4] = ["corrected", "uncorrected", "limited", "orthogonal"];

/// `laplacianSchemes`: 1 corrected, 0 uncorrected, between: limited.
pub(super) fn laplacian(r: &Reader<'_>, key: &str, notices: &Notices) -> f64 {
    let Some(mut t) = r.tokens(key) else { return 1.0 };
    if t.peek().is_some_and(|t| t.word() == Some("Gauss")) {
        t.next();
        t.word("the interpolation scheme");
    }
    let read = correction(&mut t);
    if read.orthogonal {
        notices.say("laplacianSchemes: `orthogonal` is served by `uncorrected`".to_owned());
    }
    read.limit
}

/// `snGradSchemes`: one choice for pressure, density and fraction.
pub(super) fn sn_grad(r: &Reader<'_>, alpha: Option<&str>) -> Option<NormalDerivative> {
    // What is written out, and what a pattern stands for.
    let mut fields: Vec<&str> =
        r.keys().into_iter().filter(|k| k.starts_with("snGrad(") && is_of_two_fluids(k)).collect();
    let of_alpha = alpha.map(|alpha| format!("snGrad({alpha})"));
    let names = ["snGrad(p_rgh)", "snGrad(rho)"].into_iter().chain(of_alpha.as_deref());
    let names: Vec<&str> = names.collect();
    let by_pattern = |k: &&&str| !fields.contains(*k) && first_of(r, &[**k]).is_some();
    let by_pattern: Vec<&str> = names.iter().filter(by_pattern).copied().collect();
    fields.extend(by_pattern);
    // Where every field has its own, the default is for others.
    let all_have = alpha.is_some() && names.iter().all(|k| fields.contains(k));
    let default = first_of(r, &["default"]).filter(|_| !all_have);
    let mut seen = Vec::new();
    let mut chosen = None;
    for key in fields.into_iter().chain(default) {
        // A pattern stands for several.
        let at = r.key_span(key);
        if seen.contains(&at) {
            continue;
        }
        seen.push(at);
        let Some(mut t) = r.tokens(key) else { continue };
        let read = correction(&mut t);
        if chosen.is_some_and(|c| c != read) {
            let message = format!("`{key}` is not that of the other gradients on faces");
            let help = "pressure, density and fraction balance on faces: give them one scheme";
            r.error_at_key(key, message, "another scheme", Some(help));
        }
        chosen = chosen.or(Some(read));
    }
    chosen
}

/// Whether the gradient on faces of this key is one of those that two fluids have.
fn is_of_two_fluids(key: &str) -> bool {
    ["snGrad(p_rgh)", "snGrad(rho)"].contains(&key) || key.starts_with("snGrad(alpha")
}

fn correction(t: &mut TokenReader<'_>) -> NormalDerivative {
    let at = t.here();
    let word = t.word("the correction");
    let plain = |limit| NormalDerivative { limit, orthogonal: false };
    let read = match word {
        "corrected" | "" => plain(1.0),
        "uncorrected" => plain(0.0),
        "orthogonal" => NormalDerivative { limit: 0.0, orthogonal: true },
        "limited" => {
            if t.peek().is_some_and(|t| t.word() == Some("corrected")) {
                t.next();
            }
            if t.is_empty() {
                let message =
                    "`limited` needs the share of the correction, from 0 (none) to 1 (all of it)";
                let help = "write `limited corrected 0.5`, or `corrected`, which is all of it";
                t.error(message, "expected a number", Some(help));
                return plain(1.0);
            }
            let k = t.number("the limit");
            if !(0.0..=1.0).contains(&k) && !k.is_nan() {
                t.error_at(&t.last_span(), "the limit lies between 0 and 1", "out of range", None);
            }
            plain(k)
        }
        "faceCorrected" => {
            let message =
                "the correction `faceCorrected` is not done here: it takes values at points";
            let help = "`corrected` takes the gradients of the two cells";
            t.error_at(&at, message, "not available", Some(help));
            return plain(1.0);
        }
        _ => {
            unknown(t, &at, "non-orthogonal correction", word, &KNOWN);
            return plain(1.0);
        }
    };
    t.finish();
    read
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_dict::{Sink, parse_str};

    fn read(text: &str) -> (Option<NormalDerivative>, String) {
        let (dict, found) = parse_str(text);
        assert!(found.is_empty(), "{found:?}");
        let sink = Sink::new();
        let r = Reader::new(&dict, &sink);
        let read = sn_grad(&r, Some("alpha.water"));
        (read, sink.take().to_string())
    }

    #[test]
    fn gradients_on_faces_have_a_choice_of_their_own() {
        let how = |limit, orthogonal| Some(NormalDerivative { limit, orthogonal });
        for (text, wanted) in [
            ("default corrected;", how(1.0, false)),
            ("default uncorrected;", how(0.0, false)),
            ("default limited 0.5;", how(0.5, false)),
            ("default limited corrected 0.33;", how(0.33, false)),
            ("default orthogonal;", how(0.0, true)),
            ("default none; snGrad(rho) limited 0.2;", how(0.2, false)),
            ("default none;", None),
            ("", None),
            // The last pattern that matches, names before patterns, the default where nothing else is.
            ("default corrected; \"snGrad(.*)\" uncorrected;", how(0.0, false)),
            ("\"snGrad.*\" corrected; \"snGrad\\(.*\\)\" limited 0.5;", how(0.5, false)),
            ("\"snGrad\\(.*\\)\" limited 0.5; \"snGrad.*\" corrected;", how(1.0, false)),
            (
                "default corrected; \"snGrad.*\" uncorrected; \"snGrad\\(rho\\)\" limited 0;",
                how(0.0, false),
            ),
            ("default none; \".*rho.*\" limited 0.2;", how(0.2, false)),
        ] {
            assert_eq!(read(text), (wanted, String::new()), "{text}");
        }
        let said = |text: &str| read(text).1;
        assert!(said("default faceCorrected;").contains("`faceCorrected` is not done here"));
        assert!(said("default corected;").contains("did you mean `corrected`?"));
        assert!(said("default limited 2;").contains("between 0 and 1"));
        let two = said("default corrected; snGrad(p_rgh) uncorrected;");
        assert!(two.contains("give them one scheme"), "{two}");
        let pattern = said("default corrected; \"snGrad\\(alpha.*\\)\" uncorrected;");
        assert!(pattern.contains("give them one scheme"), "{pattern}");
        let bare = said("default limited;");
        assert_eq!(bare.matches("error:").count(), 1, "{bare}");
        assert!(
            bare.contains("expected a number") && bare.contains("limited corrected 0.5"),
            "{bare}"
        );
    }

    #[test]
    fn an_orthogonal_laplacian_is_served_by_uncorrected() {
        let (dict, _) = parse_str("default Gauss linear orthogonal;");
        let (sink, notices) = (Sink::new(), Notices::new());
        assert_eq!(laplacian(&Reader::new(&dict, &sink), "default", &notices), 0.0);
        assert!(notices.take()[0].contains("served by `uncorrected`"));
    }
}
