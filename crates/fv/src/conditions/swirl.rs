//! Inlets that turn about an axis.

use super::read::{leave_flux, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView, value_text};
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::Reader;
use std::f64::consts::PI;

/// Where an axis is.
#[derive(Clone, Copy)]
struct Axis {
    origin: Vec3,
    /// Unit vector.
    along: Vec3,
}

impl Axis {
    /// `origin` and `axis` of a dictionary.
    fn read(r: &Reader<'_>) -> Axis {
        let origin = r.vector("origin", Dims::LENGTH);
        Axis { origin, along: r.direction("axis") }
    }
    /// From the axis to `x`.
    fn arm(&self, x: Vec3) -> Vec3 {
        let d = sub(x, self.origin);
        sub(d, scale(self.along, dot(d, self.along)))
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("origin".into(), value_text(self.origin)), ("axis".into(), value_text(self.along))]
    }
}

/// Revolutions per minute to rad/s.
fn radians(rpm: f64) -> f64 {
    rpm * 2.0 * PI / 60.0
}

/// Components along the axis, away from it and around it.
enum Parts {
    /// Against time: m/s, m/s, and revolutions per minute.
    InTime([TimeFunction<f64>; 3]),
    /// Against the distance from the axis (m), all in m/s.
    ByRadius([TimeFunction<f64>; 3]),
}

/// Velocity in cylindrical components.
struct Cylindrical {
    axis: Axis,
    parts: Parts,
}
impl Condition<Vec3> for Cylindrical {
    fn name(&self) -> &'static str {
        match self.parts {
            Parts::InTime(_) => "cylindricalInletVelocity",
            Parts::ByRadius(_) => "swirlInletVelocity",
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let along = self.axis.along;
        for (i, x) in view.centre.iter().enumerate() {
            let arm = self.axis.arm(*x);
            let radius = norm(arm);
            let out = if radius > 0.0 { scale(arm, 1.0 / radius) } else { [0.0; 3] };
            let (axial, radial, around) = match &self.parts {
                Parts::InTime(f) => {
                    let [a, b, rpm] = f.each_ref().map(|f| f.at(view.around.time));
                    (a, b, radians(rpm) * radius)
                }
                Parts::ByRadius(f) => {
                    let [a, b, c] = f.each_ref().map(|f| f.at(radius));
                    (a, b, c)
                }
            };
            let swirl = scale(cross(along, out), around);
            closure.offset[i] = add(add(scale(along, axial), scale(out, radial)), swirl);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let (f, keys) = match &self.parts {
            Parts::InTime(f) => (f, ["axialVelocity", "radialVelocity", "rpm"]),
            Parts::ByRadius(f) => (f, ["axialVelocity", "radialVelocity", "tangentialVelocity"]),
        };
        let mut out = self.axis.entries();
        f.iter().zip(keys).for_each(|(f, key)| out.extend(f.entries(key)));
        out
    }
}

pub(super) const CYLINDRICAL: Entry = Entry {
    name: "cylindricalInletVelocity",
    summary: "Dirichlet: speeds along an axis and away from it and revolutions per minute about it, \
              functions of time",
    formula: "U_f = axialVelocity a + radialVelocity r/|r| + (2 pi rpm/60) a x r; a = \
              axis/|axis|, r = d - (d . a) a, d = x_f - origin",
    keys: &[
        ("origin", "a point of the axis, m"),
        ("axis", "a vector of any length"),
        ("axialVelocity", "m/s, a function of time"),
        ("radialVelocity", "m/s, a function of time"),
        ("rpm", "revolutions a minute, a function of time"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| {
        leave_value(r);
        let speed = |key| TimeFunction::read(r, key, Dims::VELOCITY, c.case);
        let rpm = TimeFunction::read(r, "rpm", Dims::RATE, c.case);
        let parts = Parts::InTime([speed("axialVelocity"), speed("radialVelocity"), rpm]);
        Box::new(Cylindrical { axis: Axis::read(r), parts })
    }),
};
pub(super) const BY_RADIUS: Entry = Entry {
    name: "swirlInletVelocity",
    summary: "Dirichlet: speeds along an axis, away from it and around it, functions of the distance \
              from it",
    formula: "U_f = axialVelocity(|r|) a + radialVelocity(|r|) e + tangentialVelocity(|r|) a x \
              e; a = axis/|axis|, r = d - (d . a) a, d = x_f - origin, e = r/|r|",
    keys: &[
        ("origin", "a point of the axis, m"),
        ("axis", "a vector of any length"),
        (
            "axialVelocity",
            "m/s, written as a function of time is, of the distance from the \
                           axis in m",
        ),
        ("radialVelocity", "likewise"),
        ("tangentialVelocity", "likewise"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(|r, c| {
        leave_value(r);
        let keys = ["axialVelocity", "radialVelocity", "tangentialVelocity"];
        let parts = keys.map(|key| TimeFunction::read(r, key, Dims::VELOCITY, c.case));
        Box::new(Cylindrical { axis: Axis::read(r), parts: Parts::ByRadius(parts) })
    }),
};

/// Inflow of a given volume per second that turns about the middle of the patch.
struct SwirlFlowRate {
    /// m3/s.
    rate: TimeFunction<f64>,
    /// Revolutions per minute.
    rpm: TimeFunction<f64>,
    /// The middle of the patch, where not given.
    origin: Option<Vec3>,
    /// Into the domain, where not given.
    along: Option<Vec3>,
}
impl Condition<Vec3> for SwirlFlowRate {
    fn name(&self) -> &'static str {
        "swirlFlowRateInletVelocity"
    }
    fn n_totals(&self) -> usize {
        7
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        for (s, x) in view.area.iter().zip(view.centre) {
            let area = norm(*s);
            out[0] += area;
            for c in 0..3 {
                out[1 + c] += area * x[c];
                out[4 + c] += s[c];
            }
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let t = view.totals;
        let area = t[0].max(f64::MIN_POSITIVE);
        let middle = [t[1] / area, t[2] / area, t[3] / area];
        let axis = Axis {
            origin: self.origin.unwrap_or(middle),
            along: self.along.unwrap_or_else(|| unit([-t[4], -t[5], -t[6]])),
        };
        let speed = self.rate.at(view.around.time) / area;
        let omega = scale(axis.along, radians(self.rpm.at(view.around.time)));
        for (i, n) in view.normal.iter().enumerate() {
            let swirl = cross(omega, sub(view.centre[i], axis.origin));
            closure.offset[i] = add(swirl, scale(*n, -speed));
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = self.rate.entries("flowRate");
        out.extend(self.rpm.entries("rpm"));
        out.extend(self.origin.map(|v| ("origin".into(), value_text(v))));
        out.extend(self.along.map(|v| ("axis".into(), value_text(v))));
        out
    }
}

pub(super) const FLOW_RATE: Entry = Entry {
    name: "swirlFlowRateInletVelocity",
    summary: "inflow of a given volume per second that turns, rpm revolutions per minute about the \
              middle of the patch (or origin, axis), functions of time",
    formula: "U_f = -(Q/A) n + (2 pi rpm/60) a x (x_f - origin); Q = flowRate(t), A = sum |S|, \
              a = axis/|axis|",
    keys: &[
        ("flowRate", "m3/s, a function of time"),
        ("rpm", "revolutions a minute, a function of time"),
        ("origin", "m, default the middle of the patch"),
        ("axis", "default the mean of -n"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(flow_rate),
};
fn flow_rate(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    leave_flux(r);
    Box::new(SwirlFlowRate {
        rate: TimeFunction::read(r, "flowRate", Dims::VOLUME_FLUX, c.case),
        rpm: TimeFunction::read(r, "rpm", Dims::RATE, c.case),
        origin: r.maybe_vector("origin", Dims::LENGTH),
        along: r.has("axis").then(|| r.direction("axis")),
    })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;
    use granflow_base::{Vec3, norm, sub};

    fn near(found: Vec3, expected: Vec3) -> bool {
        norm(sub(found, expected)) < 1e-12
    }

    #[test]
    fn components_about_an_axis() {
        // Face centres lie at y, z = 1/4, 3/4; the axis runs through y = 1/4, z = 0 along x.
        let text = "type cylindricalInletVelocity; origin (7 0.25 0); axis (2 0 0); \
                    axialVelocity 1; radialVelocity table ((0 0) (2 1)); rpm 30;";
        let found = Probe::of::<Vec3>(text).at(1.0).values([[0.0; 3]; 4]);
        // Above the axis at 1/4 m: outwards is z, around it is -y.
        let turn = std::f64::consts::PI * 0.25;
        assert!(found.iter().any(|u| near(*u, [1.0, -turn, 0.5])), "{found:?}");
        let text = "type swirlInletVelocity; origin (7 0.25 0); axis (2 0 0); \
                    axialVelocity table ((0 1) (0.5 3)); radialVelocity 0.5; \
                    tangentialVelocity polynomial ((8 1));";
        let found = Probe::of::<Vec3>(text).values([[0.0; 3]; 4]);
        assert!(found.iter().any(|u| near(*u, [2.0, -2.0, 0.5])), "{found:?}");
    }

    #[test]
    fn a_rate_that_turns_about_the_middle() {
        let text = "type swirlFlowRateInletVelocity; flowRate 2; rpm constant 60;";
        let found = Probe::of::<Vec3>(text).values([[0.0; 3]; 4]);
        // The middle is at (0 1/2 1/2), the axis into the domain.
        let quarter = std::f64::consts::PI / 2.0;
        assert!(found.iter().any(|u| near(*u, [2.0, quarter, -quarter])), "{found:?}");
        assert!(found.iter().all(|u| (u[0] - 2.0).abs() < 1e-12));
    }
}
