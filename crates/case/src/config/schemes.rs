//! `system/fvSchemes`: time scheme, gradients, convection, non-orthogonal correction.
//!
//! Defaults: Euler, Gauss linear, linearUpwind, corrected.

use crate::Notices;
use granflow_dict::{Dict, Reader, Severity, Sink, TokenReader, nearest};
use granflow_flow::TimeScheme;
use granflow_fv::{Convection, LimiterKind};

/// How gradients are computed; the mesh makes an operator of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientKind {
    /// Gauss's theorem with linear interpolation.
    GaussLinear,
    /// Weighted least squares.
    LeastSquares,
}

/// What `fvSchemes` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schemes {
    /// `ddtSchemes`.
    pub ddt: TimeScheme,
    /// `gradSchemes`.
    pub gradient: GradientKind,
    /// `div(phi,U)` of `divSchemes`.
    pub convection: Convection,
    /// `div(phi,alpha)` of `divSchemes`, for algebraic transport of a volume fraction.
    pub alpha: Convection,
    /// `laplacianSchemes`: 1 corrected, 0 uncorrected, between: limited.
    pub non_orthogonal: f64,
}

impl Default for Schemes {
    fn default() -> Self {
        Schemes {
            ddt: TimeScheme::Euler,
            gradient: GradientKind::GaussLinear,
            convection: Convection::LinearUpwind,
            alpha: Convection::Limited(LimiterKind::VanLeer(1.0)),
            non_orthogonal: 1.0,
        }
    }
}

impl Schemes {
    /// Reads the dictionary for one phase or `two`, the first of which may be `grains`; mistakes go to the sink.
    pub(super) fn read(
        dict: &Dict,
        (two, grains): (bool, bool),
        sink: &Sink,
        notices: &Notices,
    ) -> Schemes {
        let r = Reader::new(dict, sink);
        let mut s = Schemes::default();
        if let Some(sub) = r.opt_sub("ddtSchemes") {
            let key = first_of(&sub, &["ddt(U)", "ddt(rho,U)", "ddt(rho*U)", "default"]);
            s.ddt = key.map_or(s.ddt, |k| ddt(&sub, k, (two, grains)));
            leave(&sub, "ddt(");
        }
        if let Some(sub) = r.opt_sub("gradSchemes") {
            let key = first_of(&sub, &["default", "grad(U)", "grad(p)", "grad(p_rgh)"]);
            s.gradient = key.map_or(s.gradient, |k| gradient(&sub, k, notices));
            leave(&sub, "grad(");
        }
        if let Some(sub) = r.opt_sub("divSchemes") {
            s.convection = divergence(&sub, notices);
            if sub.has("div(phi,alpha)") {
                s.alpha = scheme_of(&sub, "div(phi,alpha)", s.alpha, notices);
            }
            leave(&sub, "div(");
        }
        if let Some(sub) = r.opt_sub("laplacianSchemes") {
            let key = first_of(&sub, &["laplacian(nu,U)", "laplacian(mu,U)", "default"]);
            s.non_orthogonal = key.map_or(s.non_orthogonal, |k| laplacian(&sub, k));
            leave(&sub, "laplacian(");
        }
        if let Some(sub) = r.opt_sub("snGradSchemes") {
            sub.ignore_all();
        }
        if let Some(sub) = r.opt_sub("interpolationSchemes") {
            interpolation(&sub, notices);
        }
        for other in ["fluxRequired", "wallDist", "default"] {
            if let Some(sub) = r.entry(other).and_then(|_| r.opt_sub(other)) {
                sub.ignore_all();
            }
        }
        r.finish(Severity::Warning);
        s
    }
}

/// The first key that is there and is not `none`.
fn first_of<'k>(r: &Reader<'_>, keys: &[&'k str]) -> Option<&'k str> {
    let given =
        |k: &&&str| r.raw(k).is_some_and(|t| t.first().and_then(|t| t.word()) != Some("none"));
    keys.iter().find(given).copied()
}

/// Takes the entries of terms that this program does not have.
fn leave(r: &Reader<'_>, of: &str) {
    for key in r.keys() {
        if key.starts_with(of) || key == "default" {
            r.ignore(key);
        }
    }
}

fn ddt(r: &Reader<'_>, key: &str, (two, grains): (bool, bool)) -> TimeScheme {
    let Some(mut t) = r.tokens(key) else { return TimeScheme::Euler };
    let at = t.here();
    let word = t.word("the time scheme");
    let refuse = |message: &str, help: &str| t.error_at(&at, message, "not available", Some(help));
    let known_schemes = match two {
        true => "write `Euler` (first order)",
        false => {
            "write `Euler` (first order), `backward` (second order) or `steadyState` (no time)"
        }
    };
    match word {
        "Euler" => {}
        "backward" if !two => return TimeScheme::Backward,
        "steadyState" if !two || grains => return TimeScheme::Steady,
        "backward" => {
            refuse("two phases move by the Euler scheme only", "write `Euler`");
            return TimeScheme::Euler;
        }
        "steadyState" => {
            refuse(
                "the steady solver is for one fluid, or for grains beside one",
                "march in time (`Euler`), with steps as long as the interface allows",
            );
            return TimeScheme::Euler;
        }
        "CrankNicolson" | "CoEuler" | "localEuler" | "SLTS" | "bounded" => {
            refuse(&format!("the time scheme `{word}` is not supported"), known_schemes);
            return TimeScheme::Euler;
        }
        "" => return TimeScheme::Euler,
        _ => {
            let known = ["Euler", "backward", "steadyState"];
            let near =
                nearest(word, known).map_or(String::new(), |n| format!("did you mean `{n}`? "));
            refuse(
                &format!("unknown time scheme `{word}`"),
                &format!("{near}known schemes are Euler, backward, steadyState"),
            );
            return TimeScheme::Euler;
        }
    }
    t.finish();
    TimeScheme::Euler
}

fn gradient(r: &Reader<'_>, key: &str, notices: &Notices) -> GradientKind {
    let Some(mut t) = r.tokens(key) else { return GradientKind::GaussLinear };
    let mut at = t.here();
    let mut word = t.word("the gradient scheme");
    if matches!(word, "cellLimited" | "cellMDLimited" | "faceLimited" | "faceMDLimited") {
        notices.say(format!("gradSchemes: the limiter `{word}` is left out, gradients are plain"));
        at = t.here();
        word = t.word("the gradient scheme");
    }
    match word {
        "Gauss" => match t.opt_word() {
            None | Some("linear") => GradientKind::GaussLinear,
            Some(other) => {
                notices.say(format!("gradSchemes: `Gauss {other}` is served by `Gauss linear`"));
                GradientKind::GaussLinear
            }
        },
        "leastSquares" => GradientKind::LeastSquares,
        "pointCellsLeastSquares" | "edgeCellsLeastSquares" | "fourth" => {
            notices.say(format!("gradSchemes: `{word}` is served by `leastSquares`"));
            GradientKind::LeastSquares
        }
        "" => GradientKind::GaussLinear,
        _ => {
            unknown(&t, &at, "gradient scheme", word, &["Gauss", "leastSquares", "cellLimited"]);
            GradientKind::GaussLinear
        }
    }
}

fn unknown(t: &TokenReader<'_>, at: &granflow_dict::Span, what: &str, word: &str, known: &[&str]) {
    let near = nearest(word, known.iter().copied());
    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
    let help = format!("{near}known are {}", known.join(", "));
    t.error_at(at, format!("unknown {what} `{word}`"), "not known", Some(&help));
}

fn divergence(r: &Reader<'_>, notices: &Notices) -> Convection {
    let keys = [
        "div(phi,U)",
        "div(rhoPhi,U)",
        "div(rho*phi,U)",
        "div((rho*phi),U)",
        "div(rhophi,U)",
        "default",
    ];
    let Some(key) = first_of(r, &keys) else {
        if r.keys().is_empty() {
            return Schemes::default().convection;
        }
        let near = nearest("div(phi,U)", r.keys());
        let help = near.filter(|n| *n != "default").map_or_else(
            || "add `div(phi,U) Gauss linearUpwind grad(U);`".to_owned(),
            |n| format!("`{n}` is there; did you mean `div(phi,U)`?"),
        );
        r.error_here("no scheme for the convection of U", "`div(phi,U)` is missing", Some(&help));
        return Convection::LinearUpwind;
    };
    // `div(phi,u)` beside a default would be passed over in silence.
    let alike = |k: &&str| k.eq_ignore_ascii_case("div(phi,U)") && *k != "div(phi,U)";
    if let Some(other) = r.keys().into_iter().find(alike).filter(|_| key == "default") {
        let message = format!("`{other}` is not the convection of U: the default is used");
        r.warn_at_key(other, message, "nothing reads this", Some("did you mean `div(phi,U)`?"));
    }
    scheme_of(r, key, Convection::LinearUpwind, notices)
}

/// The scheme behind `key`.
fn scheme_of(r: &Reader<'_>, key: &str, default: Convection, notices: &Notices) -> Convection {
    let Some(mut t) = r.tokens(key) else { return default };
    let mut word = t.word("the scheme");
    if word == "bounded" {
        word = t.word("the scheme");
    }
    if word == "Gauss" {
        word = "";
    } else if !word.is_empty() {
        t.error_at(
            &t.last_span(),
            format!("a convection scheme starts with `Gauss`, found `{word}`"),
            "expected `Gauss`",
            Some(&format!("write `{key} Gauss {word};`")),
        );
        return Convection::LinearUpwind;
    }
    let _ = word;
    let at = t.here();
    let name = t.word("the convection scheme");
    convection(&mut t, &at, name, notices)
}

fn convection(
    t: &mut TokenReader<'_>,
    at: &granflow_dict::Span,
    name: &str,
    notices: &Notices,
) -> Convection {
    match name {
        "" => return Convection::LinearUpwind,
        "upwind" => return Convection::Upwind,
        "linear" => return Convection::Linear,
        "linearUpwind" | "linearUpwindV" => return Convection::LinearUpwind,
        "midPoint" | "cubic" | "skewCorrected" => {
            notices.say(format!("divSchemes: `{name}` is served by `linear`"));
            return Convection::Linear;
        }
        _ => {}
    }
    let base = name.strip_suffix('V').filter(|b| LimiterKind::NAMES.contains(b)).unwrap_or(name);
    let k = t.opt_number().unwrap_or(1.0);
    match LimiterKind::parse(base, k) {
        Some(limiter) => {
            if base == name {
                notices.say(format!(
                    "divSchemes: `{name}` limits a vector along its own change, as `{name}V` does"
                ));
            }
            Convection::Limited(limiter)
        }
        None => {
            let mut known = vec!["upwind", "linear", "linearUpwind"];
            known.extend(LimiterKind::NAMES);
            unknown(t, at, "convection scheme", name, &known);
            Convection::LinearUpwind
        }
    }
}

fn laplacian(r: &Reader<'_>, key: &str) -> f64 {
    let Some(mut t) = r.tokens(key) else { return 1.0 };
    let mut word = t.word("the scheme");
    if word == "Gauss" {
        t.word("the interpolation scheme");
        word = t.word("the correction");
    }
    let at = t.last_span();
    match word {
        "corrected" | "" => 1.0,
        "uncorrected" | "orthogonal" => 0.0,
        "limited" => {
            if t.peek().is_some_and(|t| t.word() == Some("corrected")) {
                t.next();
            }
            let k = t.number("the limit");
            if !(0.0..=1.0).contains(&k) {
                t.error_at(&t.last_span(), "the limit lies between 0 and 1", "out of range", None);
            }
            k
        }
        _ => {
            let known = ["corrected", "uncorrected", "limited", "orthogonal"];
            unknown(&t, &at, "non-orthogonal correction", word, &known);
            1.0
        }
    }
}

fn interpolation(r: &Reader<'_>, notices: &Notices) {
    for key in r.keys() {
        let Some(word) = r.raw(key).and_then(|t| t.first()).and_then(|t| t.word()) else {
            continue;
        };
        if word != "linear" && word != "none" {
            notices.say(format!("interpolationSchemes: `{word}` is served by `linear`"));
        }
    }
}
