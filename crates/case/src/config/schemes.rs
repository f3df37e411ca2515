//! `system/fvSchemes`: time scheme, gradients, convection, non-orthogonal correction.
//!
//! Defaults: Euler, Gauss linear, linearUpwind, corrected.

use super::{compatible, corrections, gradients};
use crate::Notices;
use granflow_dict::{Dict, Key, Reader, Severity, Sink, TokenReader, Value, nearest};
use granflow_flow::{LocalSteps, NormalDerivative, TimeScheme};
use granflow_fv::{Convection, GradientLimiter, LimiterKind, Shares};

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
    /// The same of the pressure.
    pub gradient_p: GradientKind,
    /// Whether PISO has OpenFOAM's forms in place of ours.
    pub compatible: bool,
    /// Whether isoAdvector has those at periodic sides, too, where they make and lose volume.
    pub sides_apart: bool,
    /// Limiter of `grad(U)` where convection extrapolates with it.
    pub limiter: Option<GradientLimiter>,
    /// `div(phi,U)` of `divSchemes`.
    pub convection: Convection,
    /// `div(phi,alpha)` of `divSchemes`, for algebraic transport of a volume fraction.
    pub alpha: Convection,
    /// Whether the case asks for a compression that is central everywhere (`div(phirb,alpha) Gauss linear`), which it has where it is
    /// `compatible`, or for `interfaceCompression`.
    pub central_compression: Option<bool>,
    /// `laplacianSchemes`: 1 corrected, 0 uncorrected, between: limited.
    pub non_orthogonal: f64,
    /// `snGradSchemes`, if the case has one; of two fluids.
    pub sn_grad: Option<NormalDerivative>,
}

impl Default for Schemes {
    fn default() -> Self {
        Schemes {
            ddt: TimeScheme::Euler,
            gradient: GradientKind::GaussLinear,
            gradient_p: GradientKind::GaussLinear,
            compatible: false,
            sides_apart: false,
            limiter: None,
            convection: Convection::LinearUpwind,
            alpha: Convection::Limited(LimiterKind::VanLeer(1.0)),
            central_compression: None,
            non_orthogonal: 1.0,
            sn_grad: None,
        }
    }
}

impl Schemes {
    /// Reads the dictionary for one phase or two, where the field `alpha` is the first one's fraction, which may be
    /// `grains`; mistakes go to the sink.
    pub(super) fn read(
        dict: &Dict,
        (alpha, grains): (Option<&str>, bool),
        sink: &Sink,
        notices: &Notices,
    ) -> Schemes {
        let two = alpha.is_some();
        let r = Reader::new(dict, sink);
        let mut s = Schemes::default();
        if let Some(sub) = r.opt_sub("ddtSchemes") {
            let key = first_of(&sub, &["ddt(U)", "ddt(rho,U)", "ddt(rho*U)", "default"]);
            s.ddt = key.map_or(s.ddt, |k| ddt(&sub, k, (two, grains)));
            leave(&sub, "ddt(");
        }
        let gradients = r.opt_sub("gradSchemes");
        if let Some(sub) = &gradients {
            let key = first_of(sub, &["grad(U)", "default", "grad(p)", "grad(p_rgh)"]);
            s.gradient = key.map_or(s.gradient, |k| gradients::read(sub, k, notices).0);
            let key = first_of(sub, &["grad(p)", "grad(p_rgh)", "default"]);
            s.gradient_p = key.map_or(s.gradient, |k| gradients::read(sub, k, notices).0);
        }
        if let Some(sub) = r.opt_sub("divSchemes") {
            s.convection = divergence(&sub, notices);
            if sub.has("div(phi,alpha)") {
                s.alpha = scheme_of(&sub, "div(phi,alpha)", s.alpha, notices);
            }
            s.central_compression = compatible::compression(&sub);
            if let Some(grad) = &gradients {
                s.read_limiter(grad, &sub, notices);
            }
            leave(&sub, "div(");
        }
        if let Some(sub) = &gradients {
            leave(sub, "grad(");
        }
        if let Some(sub) = r.opt_sub("laplacianSchemes") {
            let key = first_of(&sub, &["laplacian(nu,U)", "laplacian(mu,U)", "default"]);
            s.non_orthogonal =
                key.map_or(s.non_orthogonal, |k| corrections::laplacian(&sub, k, notices));
            leave(&sub, "laplacian(");
        }
        if let Some(sub) = r.opt_sub("snGradSchemes") {
            s.sn_grad = corrections::sn_grad(&sub, alpha);
            leave(&sub, "snGrad(");
        }
        if let Some(sub) = r.opt_sub("interpolationSchemes") {
            interpolation(&sub, notices);
        }
        // Of `compatible` decides what the case is besides.
        r.ignore(COMPATIBLE);
        for other in ["fluxRequired", "wallDist", "default"] {
            if let Some(sub) = r.entry(other).and_then(|_| r.opt_sub(other)) {
                sub.ignore_all();
            }
        }
        r.finish(Severity::Warning);
        s
    }
}

impl Schemes {
    /// The limiter of the gradient that convection extrapolates with: that of the name behind the scheme, if
    /// `gradSchemes` has it, else of `grad(U)` or of the default.
    fn read_limiter(&mut self, gradients: &Reader<'_>, divs: &Reader<'_>, notices: &Notices) {
        let named = first_of(divs, &CONVECTION).and_then(|key| divs.raw(key)?.last()?.word());
        let named = named.filter(|name| gradients.has(name));
        let keys: Vec<&str> = named.into_iter().chain(["grad(U)", "default"]).collect();
        let Some(key) = first_of(gradients, &keys) else { return };
        self.limiter = gradients::read(gradients, key, &Notices::default()).1;
        if self.limiter.is_some() && key == "default" {
            notices.say(
                "gradSchemes: the gradient that convection extrapolates with is limited, those of pressure \
                 and stress are plain"
                    .to_owned(),
            );
        }
    }
}

/// The switch that asks for the reference tool's forms.
pub(super) const COMPATIBLE: &str = "compatible";

/// Names of the convection of velocity, the first that is there counts.
const CONVECTION: [&str; 6] = [
    "div(phi,U)",
    "div(rhoPhi,U)",
    "div(rho*phi,U)",
    "div((rho*phi),U)",
    "div(rhophi,U)",
    "default",
];

/// The first key that is there and is not `none`.
/// Of names before `default` those that are written out come before those that a pattern stands for.
pub(super) fn first_of<'k>(r: &Reader<'_>, keys: &[&'k str]) -> Option<&'k str> {
    let given =
        |k: &&&str| r.raw(k).is_some_and(|t| t.first().and_then(|t| t.word()) != Some("none"));
    let literal = |k: &&&str| matches!(r.dict().find(k).map(|e| &e.key), Some(Key::Word(_)));
    let names = keys.iter().position(|k| *k == "default").unwrap_or(keys.len());
    let literals = keys[..names].iter().filter(literal);
    literals.chain(keys).find(given).copied()
}

/// Takes the entries of terms that this program does not have; `of` is what their names begin with.
fn leave(r: &Reader<'_>, of: &str) {
    for entry in &r.dict().entries {
        let left = match &entry.key {
            Key::Word(key) => key.starts_with(of) || key == "default",
            // `"grad\(.*\)"`, `"(grad|div).*"`, `".*"`.
            Key::Regex(p) => {
                let text = p.text.replace('\\', "");
                let of = of.trim_end_matches('(');
                text.starts_with(of) || !text.starts_with(|c: char| c.is_ascii_alphabetic())
            }
        };
        if left {
            r.take(entry);
        }
    }
}

/// The time schemes by name.
const TIME: [&str; 6] =
    ["Euler", "backward", "CrankNicolson", "localEuler", "steadyState", "bounded"];

fn ddt(r: &Reader<'_>, key: &str, (two, grains): (bool, bool)) -> TimeScheme {
    let Some(mut t) = r.tokens(key) else { return TimeScheme::Euler };
    let mut at = t.here();
    let mut word = t.word("the time scheme");
    if word == "bounded" {
        // What it takes out is the divergence of the flux, which there is none of.
        at = t.here();
        word = t.word("the time scheme");
    }
    let refuse = |t: &TokenReader<'_>, message: &str, help: &str| {
        t.error_at(&at, message, "not available", Some(help));
        TimeScheme::Euler
    };
    let scheme = match word {
        "Euler" | "" => TimeScheme::Euler,
        "backward" if two => {
            let message = "two phases do not move by backward differences";
            return refuse(&t, message, "write `Euler` or `CrankNicolson 0.9`");
        }
        "backward" => TimeScheme::Backward,
        "CrankNicolson" => {
            let psi = t.opt_number().unwrap_or(1.0);
            if !(0.0..=1.0).contains(&psi) {
                let message = "the number behind CrankNicolson lies between 0 (Euler) and 1";
                t.error_at(&t.last_span(), message, "out of range", Some("0.9 is usual"));
            }
            if psi == 1.0 && two {
                let message = "with two fluids `CrankNicolson 1` damps nothing: what oscillates from step to step at \
                               the interface can grow until the run fails";
                let help = "`CrankNicolson 0.9` is nearly as exact and damps";
                r.warn_at_key(key, message, "without damping", Some(help));
            }
            TimeScheme::CrankNicolson(psi)
        }
        "localEuler" if two => {
            let message = "steps of their own for every cell are for one fluid";
            return refuse(&t, message, "march in time: write `Euler`");
        }
        "localEuler" => TimeScheme::Local(LOCAL),
        "steadyState" if two && !grains => {
            let message = "the steady solver is for one fluid, or for grains beside one";
            let help = "march in time (`Euler`), with steps as long as the interface allows";
            return refuse(&t, message, help);
        }
        "steadyState" => TimeScheme::Steady,
        "CoEuler" | "SLTS" => {
            let message = format!("the time scheme `{word}` is not supported");
            return refuse(&t, &message, "`localEuler` gives every cell a step of its own");
        }
        _ => {
            unknown(&t, &at, "time scheme", word, &TIME);
            return TimeScheme::Euler;
        }
    };
    t.finish();
    scheme
}

/// Steps of `localEuler` where `fvSolution` says nothing.
pub(super) const LOCAL: LocalSteps = LocalSteps { courant: 0.9, longest: 1e30, growth: 0.1 };

pub(super) fn unknown(
    t: &TokenReader<'_>,
    at: &granflow_dict::Span,
    what: &str,
    word: &str,
    known: &[&str],
) {
    let near = nearest(word, known.iter().copied());
    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
    let help = format!("{near}known are {}", known.join(", "));
    t.error_at(at, format!("unknown {what} `{word}`"), "not known", Some(&help));
}

fn divergence(r: &Reader<'_>, notices: &Notices) -> Convection {
    let Some(key) = first_of(r, &CONVECTION) else {
        if r.dict().entries.is_empty() {
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
    let scheme = convection(&mut t, &at, name, notices);
    t.finish();
    scheme
}

/// Convection schemes that are no limiters, by name.
pub const PLAIN: [&str; 8] = [
    "upwind",
    "linear",
    "linearUpwind",
    "linearUpwindV",
    "cubic",
    "LUST",
    "blended",
    "fixedBlended",
];

/// Names whose scheme is another one's here.
const SERVED: &[(&str, &str)] = &[
    ("midPoint", "linear"),
    ("pointLinear", "linear"),
    ("linearFit", "linear"),
    ("biLinearFit", "linear"),
    ("quadraticLinearFit", "linear"),
    ("quadraticFit", "cubic"),
    ("cubicUpwindFit", "linearUpwind"),
    ("linearPureUpwindFit", "linearUpwind"),
    ("quadraticUpwindFit", "linearUpwind"),
    ("quadraticLinearUpwindFit", "linearUpwind"),
    ("filteredLinear", "limitedLinear"),
    ("filteredLinear2", "limitedLinear"),
    ("filteredLinear3", "limitedLinear"),
    ("clippedLinear", "limitedLinear"),
    ("limitedCubic", "MUSCL"),
    ("SFCD", "Gamma"),
];

/// Names of the reference tool that have no like here.
const REFUSED: &[&str] = &[
    "CoBlended",
    "cellCoBlended",
    "localBlended",
    "limiterBlended",
    "limitWith",
    "localMax",
    "localMin",
    "downwind",
    "reverseLinear",
    "weighted",
    "weightedFlux",
    "Phi",
];

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
        "linearUpwind" | "linearUpwindV" => {
            // The name of a gradient: see `read_limiter`.
            t.opt_word();
            return match name {
                "linearUpwind" => Convection::LinearUpwind,
                _ => Convection::LinearUpwindV,
            };
        }
        "cubic" => return Convection::Mixed(Shares::CUBIC),
        "LUST" => {
            t.opt_word();
            return Convection::Mixed(Shares::LUST);
        }
        "blended" => {
            let linear = Shares { linear: 1.0, ..Shares::default() };
            let upwind = Shares { upwind: 1.0, ..Shares::default() };
            return Convection::Mixed(Shares::blend(share(t), linear, upwind));
        }
        "fixedBlended" => {
            let k = share(t);
            let [a, b] = [(); 2].map(|()| part(t, notices));
            return Convection::Mixed(Shares::blend(k, a, b));
        }
        // What is behind them is corrected, or deferred, anyway.
        "skewCorrected" | "deferredCorrection" | "outletStabilised" => {
            let at = t.here();
            let name = t.word("the convection scheme");
            return convection(t, &at, name, notices);
        }
        _ => {}
    }
    let base = name.strip_suffix('V').filter(|b| is_known(b)).unwrap_or(name);
    if let Some((_, ours)) = SERVED.iter().find(|(theirs, _)| *theirs == base) {
        notices.say(format!("divSchemes: `{name}` is served by `{ours}`"));
        while t.opt_number().is_some() {}
        t.opt_word();
        return match LimiterKind::parse(ours, 1.0) {
            Some(limiter) => Convection::Limited(limiter),
            None => convection(t, at, ours, notices),
        };
    }
    let k = t.opt_number().unwrap_or(1.0);
    if let Some(limiter) = LimiterKind::parse(base, k) {
        if !(0.0..=1.0).contains(&k) {
            let message = "the number of a limiter lies between 0 and 1";
            t.error_at(&t.last_span(), message, "out of range", None);
        }
        if base == name {
            notices.say(format!(
                "divSchemes: `{name}` limits a vector along its own change, as `{name}V` does"
            ));
        }
        return Convection::Limited(limiter);
    }
    let mut known = PLAIN.to_vec();
    known.extend(LimiterKind::NAMES);
    if REFUSED.contains(&base) {
        let help = format!("there are {}", known.join(", "));
        let message = format!("the convection scheme `{name}` is not done here");
        t.error_at(at, message, "not available", Some(&help));
    } else {
        unknown(t, at, "convection scheme", name, &known);
    }
    Convection::LinearUpwind
}

fn is_known(base: &str) -> bool {
    LimiterKind::NAMES.contains(&base) || SERVED.iter().any(|(theirs, _)| *theirs == base)
}

/// A number from 0 to 1 behind the name of a scheme.
fn share(t: &mut TokenReader<'_>) -> f64 {
    let k = t.number("the share of the first scheme");
    if !(0.0..=1.0).contains(&k) && !k.is_nan() {
        t.error_at(&t.last_span(), "a share lies between 0 and 1", "out of range", None);
    }
    k
}

/// One of the two schemes behind `fixedBlended`.
fn part(t: &mut TokenReader<'_>, notices: &Notices) -> Shares {
    let at = t.here();
    if t.peek().is_some_and(|t| t.word() == Some("Gauss")) {
        t.next();
    }
    let name = t.word("the convection scheme");
    let scheme = match name {
        // Behind these stands the name of a gradient, and another scheme may follow.
        "linearUpwind" => {
            t.opt_word();
            Convection::LinearUpwind
        }
        "LUST" => {
            t.opt_word();
            Convection::Mixed(Shares::LUST)
        }
        _ => convection(t, &at, name, notices),
    };
    scheme.shares().unwrap_or_else(|| {
        let message =
            format!("`{name}` is limited and cannot be part of a mixture in fixed shares");
        let help = "there are upwind, linear, linearUpwind, cubic, LUST";
        t.error_at(&at, message, "not a fixed share", Some(help));
        Shares { linear_upwind: 1.0, ..Shares::default() }
    })
}

fn interpolation(r: &Reader<'_>, notices: &Notices) {
    for entry in &r.dict().entries {
        r.take(entry);
        let Value::Stream(tokens) = &entry.value else { continue };
        let Some(word) = tokens.first().and_then(|t| t.word()) else { continue };
        if word != "linear" && word != "none" {
            notices.say(format!("interpolationSchemes: `{word}` is served by `linear`"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_dict::parse_str;

    /// There is no divergence of the flux to take out.
    #[test]
    fn a_bounded_time_scheme_is_the_one_behind_it() {
        let read = |scheme: &str| {
            let (dict, _) = parse_str(&format!("ddtSchemes {{ default {scheme}; }}"));
            let (sink, notices) = (Sink::new(), Notices::new());
            let schemes = Schemes::read(&dict, (None, false), &sink, &notices);
            assert!(sink.take().is_empty(), "{scheme}");
            schemes.ddt
        };
        for scheme in ["Euler", "backward", "CrankNicolson 0.9", "localEuler", "steadyState"] {
            assert_eq!(read(&format!("bounded {scheme}")), read(scheme));
        }
        assert!(read("bounded Euler") != read("bounded backward"));
    }

    fn said(text: &str) -> (Schemes, String) {
        let (dict, found) = parse_str(text);
        assert!(found.is_empty(), "{found:?}");
        let (sink, notices) = (Sink::new(), Notices::new());
        let schemes = Schemes::read(&dict, (Some("alpha.water"), false), &sink, &notices);
        (schemes, sink.take().to_string() + &notices.take().join("\n"))
    }

    #[test]
    fn patterns_stand_for_terms_that_are_not_written_out() {
        let (schemes, said) = said(
            r#"ddtSchemes { default Euler; "ddt\(.*" CrankNicolson 0.9; }
            gradSchemes { default leastSquares; "grad\(p.*\)" Gauss linear; "grad\(T\)" nonsense; }
            divSchemes { default none; "div\(.*U\)" Gauss linear; div(rhoPhi,U) Gauss upwind;
                "div\(phi,alpha.*" Gauss MUSCL; "div\(phirb,.*" Gauss linear; }
            laplacianSchemes { default Gauss linear corrected; "laplacian\(.*\)" Gauss linear limited 0.5; }
            interpolationSchemes { ".*" cubic; }
            snGradSchemes { default corrected; "snGrad(.*)" limited 0.5; }"#,
        );
        assert_eq!(schemes.ddt, TimeScheme::CrankNicolson(0.9));
        assert_eq!(schemes.gradient, GradientKind::LeastSquares);
        assert_eq!(schemes.gradient_p, GradientKind::GaussLinear);
        assert_eq!(schemes.convection, Convection::Upwind);
        assert_eq!(schemes.alpha, Convection::Limited(LimiterKind::Muscl(1.0)));
        assert_eq!(schemes.non_orthogonal, 0.5);
        assert_eq!(schemes.sn_grad, Some(NormalDerivative { limit: 0.5, orthogonal: false }));
        assert!(said.starts_with("divSchemes: `MUSCL`") || said.contains("`cubic`"), "{said}");
        assert!(!said.contains("nothing reads this"), "{said}");
    }

    #[test]
    fn a_wrong_pattern_is_told() {
        let (_, said) = said(r#"gradSchemes { default Gauss linear; "gard\(.*\)" leastSquares; }"#);
        assert!(said.contains("unused entry `gard"), "{said}");
    }

    #[test]
    fn crank_nicolson_of_two_fluids_wants_some_damping() {
        for (scheme, warned) in [("1", true), ("", true), ("0.9", false)] {
            let (_, said) = said(&format!("ddtSchemes {{ default CrankNicolson {scheme}; }}"));
            assert_eq!(said.contains("`CrankNicolson 0.9` is nearly"), warned, "{said}");
        }
    }
}
