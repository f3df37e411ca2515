//! A zone in a frame that turns (multiple reference frames: J. Y. Luo, R. I. Issa, A. D. Gosman, Inst. Chem.
//! Eng. Symp. Ser. 136 (1994) 549): with the absolute velocity as unknown, carried by the relative flux, the
//! frame's acceleration is `omega x U`.
//!
//! That is the force here; fluxes and walls are [`crate::frame`]'s.

use super::{Seen, Source, Zone, three};
use granflow_base::{Value, Vec3, cross, scale, sub};
use granflow_fv::TimeFunction;

/// Times at which it is seen whether a frame turns steadily.
const LOOKS: usize = 1000;

/// A zone of cells in a turning frame.
#[derive(Clone)]
pub struct RotatingFrame {
    /// The name of the entry.
    pub name: String,
    /// The cells.
    pub zone: Zone,
    /// A point of the axis, m.
    pub origin: Vec3,
    /// Unit vector along it.
    pub axis: Vec3,
    /// Angular velocity in rad/s against time.
    pub omega: TimeFunction<f64>,
    /// Names of patches whose faces in the zone do not turn.
    pub still: Vec<String>,
}

impl RotatingFrame {
    /// Velocity of the frame per unit of angular velocity at a point, m.
    pub fn arm(&self, x: Vec3) -> Vec3 {
        cross(self.axis, sub(x, self.origin))
    }
}

impl Source for RotatingFrame {
    fn name(&self) -> &str {
        &self.name
    }
    fn kind(&self) -> &'static str {
        "MRF"
    }
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn says(&self, number: &dyn Fn(f64) -> String) -> String {
        let omega = number(self.omega.at(0.0));
        let [axis, origin] = [self.axis, self.origin].map(|v| three(v, number));
        format!("a frame that turns by {omega} rad/s at first, about {axis} through {origin}")
    }
    fn add(&self, seen: &Seen<'_>, n: usize, body: &mut [Vec3], _: &mut [f64]) {
        let omega = scale(self.axis, self.omega.at(seen.time));
        self.zone.each(n, |c| body[c] = body[c].axpy(-seen.rho[c], cross(omega, seen.u[c])));
    }
    fn stays(&self, from: f64, to: f64) -> bool {
        let at = |k: usize| self.omega.at(from + (to - from) * k as f64 / LOOKS as f64);
        (1..=LOOKS).all(|k| at(k) == at(0))
    }
    fn frame(&self) -> Option<&RotatingFrame> {
        Some(self)
    }
    fn boxed(&self) -> Box<dyn Source> {
        Box::new(self.clone())
    }
}
