//! A flow that is given: OpenFOAM's `setFlow`, for tests of the interface alone (with `frozenFlow`).

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written};
use crate::CaseConfig;
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::{Diag, Reader, Sink, Span, Value};
use granflow_flow::Prescribed;
use granflow_mesh::{Mesh, PolyMesh};
use granflow_par::Exec;
use std::f64::consts::{PI, TAU};

pub(super) const ENTRY: Entry = Entry {
    name: "setFlow",
    summary: "with frozenFlow: a given flow, `mode` rotation, vortex2D or vortex3D, times `scale`",
    formula: "rotation: U = omega x (x - origin); vortex2D: psi = sin^2(pi x) sin^2(pi z)/pi; \
              vortex3D: U = (2 sin^2(pi x) sin(2 pi y) sin(2 pi z), -sin(2 pi x) sin^2(pi y) \
              sin(2 pi z), -sin(2 pi x) sin(2 pi y) sin^2(pi z)); all times scale(t)",
    reference: "R. J. LeVeque, SIAM J. Numer. Anal. 33 (1996) 627",
    read: |r, _| Box::new(SetFlow::read(r)),
    schedule: Schedule::always(Every::Writes(1)),
};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Rotation,
    Vortex2D,
    Vortex3D,
}

/// `level + scale amplitude sin(2 pi frequency (t - t0))`.
#[derive(Clone, Copy, Debug)]
struct Sine {
    amplitude: f64,
    frequency: f64,
    t0: f64,
    scale: f64,
    level: f64,
}

/// What the dictionary says.
#[derive(Clone)]
pub struct SetFlow {
    span: Span,
    mode: Mode,
    origin: Vec3,
    /// Local axes: `refDir`, `axis`, `refDir x axis`.
    axes: [Vec3; 3],
    /// 1/s.
    omega: f64,
    /// Factor: constant, or
    constant: f64,
    /// a sine.
    sine: Option<Sine>,
    /// Time after which the flow runs backwards, s.
    reverse: Option<f64>,
}

impl SetFlow {
    fn read(r: &Reader<'_>) -> SetFlow {
        let modes = [
            ("rotation", Mode::Rotation),
            ("vortex2D", Mode::Vortex2D),
            ("vortex3D", Mode::Vortex3D),
        ];
        let mode = r.one_of("mode", &modes);
        for key in ["U", "rho", "phi"] {
            r.ignore(key);
        }
        let omega = if mode == Mode::Rotation { r.scalar("omega", Dims::NONE) } else { 0.0 };
        let origin = r.opt_vector("origin", Dims::LENGTH, [0.0; 3]);
        let x = r.opt_vector("refDir", Dims::NONE, [1.0, 0.0, 0.0]);
        let y = r.opt_vector("axis", Dims::NONE, [0.0, 1.0, 0.0]);
        if norm(cross(x, y)) == 0.0 {
            r.error_at_key("axis", "`axis` and `refDir` are parallel", "no plane", None);
        }
        let y = unit(y);
        let x = unit(sub(x, scale(y, dot(x, y))));
        let (constant, sine) = factor(r);
        SetFlow {
            span: r.key_span("type"),
            mode,
            origin,
            axes: [x, y, cross(x, y)],
            omega,
            constant,
            sine,
            reverse: r.maybe_scalar("reverseTime", Dims::TIME).filter(|t| *t > 0.0),
        }
    }

    /// The vector potential at `at`, m3/s per metre.
    fn potential(&self, at: Vec3) -> Vec3 {
        let d = sub(at, self.origin);
        let [x, y, z] = self.axes.map(|e| dot(e, d));
        let s2 = |t: f64| (PI * t).sin().powi(2);
        let (s, c) = (|t: f64| (TAU * t).sin(), |t: f64| (TAU * t).cos());
        let a = match self.mode {
            Mode::Rotation => [0.0, 0.5 * self.omega * (x * x + z * z), 0.0],
            Mode::Vortex2D => [0.0, s2(x) * s2(z) / PI, 0.0],
            Mode::Vortex3D => {
                let k = 1.0 / TAU;
                [0.0, k * c(x) * s(y) * s2(z), -k * (c(x) * s2(y) * s(z) + c(y) * s(z))]
            }
        };
        let parts = [0, 1, 2].map(|k| scale(self.axes[k], a[k]));
        add(add(parts[0], parts[1]), parts[2])
    }

    /// The flow on a mesh.
    pub fn on(&self, poly: &PolyMesh, mesh: &Mesh) -> Prescribed {
        let flux = Prescribed::flux_of(poly, mesh, |x| self.potential(x));
        let (constant, sine, reverse) = (self.constant, self.sine, self.reverse);
        let factor = move |t: f64| {
            let scaled = sine.map_or(constant, |s| {
                s.level + s.scale * s.amplitude * (TAU * s.frequency * (t - s.t0)).sin()
            });
            if reverse.is_some_and(|at| t > at) { -scaled } else { scaled }
        };
        Prescribed { flux, factor: Box::new(factor) }
    }
}

/// `scale 1;` or `scale sine; scaleCoeffs { .. }` (or the coefficients in a dictionary `scale`).
fn factor(r: &Reader<'_>) -> (f64, Option<Sine>) {
    let sub = match r.entry("scale").map(|e| &e.value) {
        None => return (1.0, None),
        Some(Value::Dict(_)) => r.opt_sub("scale"),
        Some(Value::Stream(t)) if t.first().is_some_and(|t| t.word().is_some()) => {
            let word = r.one_of("scale", &[("sine", true), ("constant", false)]);
            if !word {
                let value = r.raw("scale").and_then(|t| t.last()?.number());
                return (value.unwrap_or(1.0), None);
            }
            r.sub("scaleCoeffs")
        }
        Some(Value::Stream(_)) => return (r.scalar("scale", Dims::NONE), None),
    };
    let Some(c) = sub else { return (1.0, None) };
    c.ignore("type");
    let sine = Sine {
        amplitude: c.opt_scalar("amplitude", Dims::NONE, 1.0),
        frequency: c.scalar("frequency", Dims::NONE),
        t0: c.opt_scalar("t0", Dims::NONE, 0.0),
        scale: c.opt_scalar("scale", Dims::NONE, 1.0),
        level: c.opt_scalar("level", Dims::NONE, 0.0),
    };
    (1.0, Some(sine))
}

impl Plan for SetFlow {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        if config.transport.second.is_none() || !config.solution.frozen {
            let message = "setFlow needs two phases and `frozenFlow yes;` in PIMPLE";
            sink.push(Diag::error(&self.span, message).label("would be overwritten by the solver"));
        }
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Nothing)
    }
    fn prescribes(&self) -> Option<&SetFlow> {
        Some(self)
    }
}

/// It acts within the step; there is nothing to sample.
struct Nothing;

impl Function for Nothing {
    fn sample(&mut self, _: &View<'_>) -> Vec<Written> {
        Vec::new()
    }
}
