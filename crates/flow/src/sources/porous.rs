//! Drag of a porous body: `-(eta D + rho |U|/2 F) U`, with `D` and `F` diagonal along given axes
//! (H. Darcy, Les fontaines publiques de la ville de Dijon, 1856; P. Forchheimer, Z. Ver. Dtsch. Ing. 45
//! (1901) 1782).

use super::axes::axes;
use super::{Entry, Given, Seen, Source, Zone, three};
use granflow_base::{Dims, Value, Vec3, dot, norm};
use granflow_dict::Severity;

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

pub(super) const ENTRY: Entry = Entry {
    names: &["explicitPorositySource"],
    summary: "a porous body: the drag of Darcy and Forchheimer along three axes",
    formula: "f = -(eta d + rho |U|/2 f) . U, d and f along the axes of coordinateSystem",
    reference: "P. Forchheimer, Z. Ver. Dtsch. Ing. 45 (1901) 1782",
    read,
};

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
