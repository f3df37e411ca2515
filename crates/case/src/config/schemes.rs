//! `system/fvSchemes`: time scheme, gradients, convection, non-orthogonal correction.
//!
//! Defaults: Euler, Gauss linear, linearUpwind, corrected.

use super::corrections;
use crate::Notices;
use granflow_dict::{Dict, Reader, Severity, Sink, TokenReader, nearest};
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
    /// Limiter of `grad(U)` where convection extrapolates with it.
    pub limiter: Option<GradientLimiter>,
    /// `div(phi,U)` of `divSchemes`.
    pub convection: Convection,
    /// `div(phi,alpha)` of `divSchemes`, for algebraic transport of a volume fraction.
    pub alpha: Convection,
    /// Whether the compression of `div(phirb,alpha)` is central where the case is `compatible`, and not
    /// `interfaceCompression`.
    pub central_compression: bool,
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
            limiter: None,
            convection: Convection::LinearUpwind,
            alpha: Convection::Limited(LimiterKind::VanLeer(1.0)),
            central_compression: true,
            non_orthogonal: 1.0,
            sn_grad: None,
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
        let gradients = r.opt_sub("gradSchemes");
        if let Some(sub) = &gradients {
            let key = first_of(sub, &["default", "grad(U)", "grad(p)", "grad(p_rgh)"]);
            s.gradient = key.map_or(s.gradient, |k| gradient(sub, k, notices).0);
            let key = first_of(sub, &["grad(p)", "grad(p_rgh)"]);
            s.gradient_p = key.map_or(s.gradient, |k| gradient(sub, k, notices).0);
        }
        if let Some(sub) = r.opt_sub("divSchemes") {
            s.convection = divergence(&sub, notices);
            if sub.has("div(phi,alpha)") {
                s.alpha = scheme_of(&sub, "div(phi,alpha)", s.alpha, notices);
            }
            let compression = sub.raw("div(phirb,alpha)").and_then(|value| value.last()?.word());
            s.central_compression = compression != Some("interfaceCompression");
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
            s.sn_grad = corrections::sn_grad(&sub);
            leave(&sub, "snGrad(");
        }
        if let Some(sub) = r.opt_sub("interpolationSchemes") {
            interpolation(&sub, notices);
        }
        s.compatible = r.opt_switch(COMPATIBLE, false);
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
        self.limiter = gradient(gradients, key, &Notices::default()).1;
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
pub(super) fn first_of<'k>(r: &Reader<'_>, keys: &[&'k str]) -> Option<&'k str> {
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

fn gradient(
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
            Some(other) => {
                notices.say(format!("gradSchemes: `Gauss {other}` is served by `Gauss linear`"));
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
        let k = t.opt_number().unwrap_or(1.0);
        if !(0.0..=1.0).contains(&k) {
            let message = "the number of a gradient limiter lies between 0 (none) and 1 (bounded)";
            t.error_at(&t.last_span(), message, "out of range", None);
        }
        GradientLimiter { limit, k }
    });
    (kind, limiter)
}

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
    if !(0.0..=1.0).contains(&k) {
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
    for key in r.keys() {
        let Some(word) = r.raw(key).and_then(|t| t.first()).and_then(|t| t.word()) else {
            continue;
        };
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
            let schemes = Schemes::read(&dict, (false, false), &sink, &notices);
            assert!(sink.take().is_empty(), "{scheme}");
            schemes.ddt
        };
        for scheme in ["Euler", "backward", "CrankNicolson 0.9", "localEuler", "steadyState"] {
            assert_eq!(read(&format!("bounded {scheme}")), read(scheme));
        }
        assert!(read("bounded Euler") != read("bounded backward"));
    }
}
