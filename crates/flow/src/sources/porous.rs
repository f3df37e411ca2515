//! Drag of a porous body: `-(eta D + rho |U|/2 F) U`, with `D` and `F` diagonal along given axes
//! (H. Darcy, Les fontaines publiques de la ville de Dijon, 1856; P. Forchheimer, Z. Ver. Dtsch. Ing. 45
//! (1901) 1782).

use super::{Entry, Given, Seen, Source, Zone, three};
use granflow_base::{Dims, Value, Vec3, cross, dot, norm, scale, sub, unit};
use granflow_dict::{Reader, Severity};

/// A porous body.
#[derive(Clone, Debug)]
pub struct Porous {
    /// The name of the entry.
    pub name: String,
    /// Where.
    pub zone: Zone,
    /// The viscous coefficients along the axes, 1/m2.
    pub darcy: Vec3,
    /// The coefficients of the square, 1/m.
    pub forchheimer: Vec3,
    /// The axes: unit vectors, perpendicular to each other.
    pub axes: [Vec3; 3],
}

impl Source for Porous {
    fn name(&self) -> &str {
        &self.name
    }
    fn kind(&self) -> &'static str {
        ENTRY.names[0]
    }
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn says(&self, number: &dyn Fn(f64) -> String) -> String {
        let [d, f] = [self.darcy, self.forchheimer].map(|v| three(v, number));
        format!("a porous body, d {d} 1/m2, f {f} 1/m")
    }
    /// The greatest of the three drags is implicit, what the others are short of it is not: with it on
    /// the diagonal nothing overshoots. What is `compatible` has the sum of the three there.
    fn add(&self, seen: &Seen<'_>, n: usize, body: &mut [Vec3], sink: &mut [f64]) {
        self.zone.each(n, |c| {
            let u = seen.u[c];
            let dynamic = 0.5 * seen.rho[c] * norm(u);
            let drag = |k: usize| seen.eta[c] * self.darcy[k] + dynamic * self.forchheimer[k];
            let drags = [drag(0), drag(1), drag(2)];
            let implicit = match seen.compatible {
                true => drags.iter().sum(),
                false => drags.iter().copied().fold(0.0, f64::max),
            };
            sink[c] += implicit;
            for (axis, drag) in self.axes.iter().zip(drags) {
                body[c] = body[c].axpy((implicit - drag) * dot(u, *axis), *axis);
            }
        });
    }
    fn boxed(&self) -> Box<dyn Source> {
        Box::new(self.clone())
    }
}

pub(super) const ENTRY: Entry =
    Entry { names: &["explicitPorositySource"], summary: "drag of a porous body", read };

fn read(of: &Given<'_, '_>) -> Vec<Box<dyn Source>> {
    of.always();
    let r = of.r;
    let model = if r.has("type") { r.word("type") } else { "DarcyForchheimer" };
    if !matches!(model, "DarcyForchheimer" | "explicitPorositySource") {
        let help = Some("there is `DarcyForchheimer`");
        let message = format!("the porous body `{model}` is not done here");
        r.error_at_key("type", message, "not available", help);
        r.ignore_all();
        return Vec::new();
    }
    let inner = r.opt_sub("DarcyForchheimerCoeffs");
    let inside = inner.as_ref().unwrap_or(r);
    let darcy = positive(inside.vector("d", Dims::LENGTH.mul(Dims::LENGTH).inv()));
    let forchheimer = positive(inside.vector("f", Dims::LENGTH.inv()));
    for key in ["mu", "rho", "nu", "U"] {
        inside.ignore(key);
    }
    let axes = axes(inside);
    if let Some(inner) = &inner {
        inner.finish(Severity::Error);
    }
    let (name, zone) = (of.name.to_owned(), of.zone.clone());
    vec![Box::new(Porous { name, zone, darcy, forchheimer, axes })]
}

/// A negative coefficient is that many times the greatest.
fn positive(v: Vec3) -> Vec3 {
    let most = v.iter().copied().fold(0.0, f64::max);
    v.map(|x| if x < 0.0 { -x * most } else { x })
}

/// The axes of `coordinateSystem`: `e1` and `e2` (or `e3`), perhaps in `rotation`, or those of space.
fn axes(r: &Reader<'_>) -> [Vec3; 3] {
    let own = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let Some(system) = r.opt_sub("coordinateSystem") else { return own };
    for key in ["type", "origin"] {
        system.ignore(key);
    }
    let turned = system.opt_sub("rotation").or_else(|| {
        system.entry("coordinateRotation").and_then(|_| system.opt_sub("coordinateRotation"))
    });
    let of = turned.as_ref().unwrap_or(&system);
    let kind = of.opt_word("type", "axes");
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
    of.ignore_all();
    system.ignore_all();
    found.unwrap_or_else(|| {
        let help = Some(
            "give two of them: `coordinateSystem { origin (0 0 0); e1 (1 0 0); e2 (0 1 0); }`",
        );
        r.error_at_key("coordinateSystem", "the axes are not given", "needs two axes", help);
        own
    })
}

/// Unit vectors along `a`, along `b` as far as it is perpendicular to `a`, and along `a x b`.
fn right_handed(a: Vec3, b: Vec3) -> Option<[Vec3; 3]> {
    let a = unit(a);
    let b = sub(b, scale(a, dot(a, b)));
    (norm(a) > 0.0 && norm(b) > 0.0).then(|| [a, unit(b), cross(a, unit(b))])
}
