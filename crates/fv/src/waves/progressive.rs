//! What all periodic waves have in common: height, period, direction and phase.

use super::{Context, Place};
use granflow_base::{Dims, Vec3};
use granflow_dict::Reader;
use std::f64::consts::{PI, TAU};

/// Three quarters of a turn: the surface at the patch rises from still water, upwards when time
/// has gone half a period.
const PHASE: f64 = 1.5 * PI;

/// Entries that every periodic wave has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progressive {
    /// From trough to crest, m.
    pub(super) height: f64,
    /// Period, s.
    pub(super) period: f64,
    /// Cosine and sine of the direction against x.
    pub(super) direction: [f64; 2],
    /// Phase at the origin and time zero.
    pub(super) phase: f64,
}

impl Progressive {
    /// Reads `waveHeight`, `wavePeriod`, `waveAngle` (degrees) and `wavePhase`.
    pub(super) fn read(r: &Reader<'_>, depth: f64) -> Progressive {
        Progressive {
            height: height(r, depth),
            period: r.positive("wavePeriod", Dims::TIME),
            direction: direction(r),
            phase: r.opt_scalar("wavePhase", Dims::NONE, PHASE),
        }
    }
    /// Angular frequency, 1/s.
    pub(super) fn omega(&self) -> f64 {
        TAU / self.period
    }
    /// Phase where the wave number is `k`, 1/m.
    pub(super) fn theta(&self, k: f64, at: Place) -> f64 {
        let [c, s] = self.direction;
        k * (c * at.x + s * at.y) - self.omega() * at.time + self.phase
    }
    /// `along` in the direction of the wave and `up`.
    pub(super) fn turned(&self, along: f64, up: f64) -> Vec3 {
        turned(self.direction, along, up)
    }
}

/// `along` in a direction and `up`.
pub(super) fn turned([c, s]: [f64; 2], along: f64, up: f64) -> Vec3 {
    [along * c, along * s, up]
}

/// Cosine and sine of `waveAngle`, degrees against the inward normal.
pub(super) fn direction(r: &Reader<'_>) -> [f64; 2] {
    let angle = r.opt_in_range("waveAngle", Dims::NONE, -90.0..=90.0, 0.0).to_radians();
    [angle.cos(), angle.sin()]
}

/// `waveHeight`: no wave is higher than the water is deep.
pub(super) fn height(r: &Reader<'_>, depth: f64) -> f64 {
    let height = r.positive("waveHeight", Dims::LENGTH);
    if height >= depth {
        let label = format!("the water is {depth:.4} m deep");
        r.error_at_key("waveHeight", "the wave is higher than the water is deep", label, None);
    }
    height
}

/// Wave number of a small wave, 1/m: `omega^2 = g k tanh(k h)`, by Newton's method.
pub(super) fn wave_number(period: f64, context: Context) -> f64 {
    let (g, h) = (context.gravity, context.depth);
    let target = (TAU / period).powi(2) * h / g;
    // In x = k h; the guess is that of deep water, or of shallow water where that is greater.
    let mut x = target.max(target.sqrt());
    for _ in 0..50 {
        let t = x.tanh();
        let step = (x * t - target) / (t + x * (1.0 - t * t));
        x -= step;
        if step.abs() <= 1e-15 * x || x.is_nan() {
            break;
        }
    }
    x / h
}

/// `cosh(k z)/sinh(k h)` and `sinh(k z)/sinh(k h)`, for water of any depth.
pub(super) fn ratios(k: f64, z: f64, h: f64) -> [f64; 2] {
    let (rising, falling) = ((k * (z - h)).exp(), (-k * (z + h)).exp());
    let whole = 1.0 - (-2.0 * k * h).exp();
    [(rising + falling) / whole, (rising - falling) / whole]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_those_of_hyperbolic_functions() {
        let [c, s] = ratios(2.0, 0.3, 0.5);
        assert!((c - 0.6f64.cosh() / 1f64.sinh()).abs() < 1e-15);
        assert!((s - 0.6f64.sinh() / 1f64.sinh()).abs() < 1e-15);
        assert_eq!(ratios(1.0, 1000.0, 1000.0), [1.0, 1.0]);
    }

    #[test]
    fn the_dispersion_relation_holds_from_shallow_to_deep_water() {
        for (period, depth) in [(100.0, 0.1), (3.0, 0.6), (1.0, 5.0), (0.5, 100.0)] {
            let context = Context { depth, gravity: 9.81 };
            let k = wave_number(period, context);
            let omega = TAU / period;
            let off = 9.81 * k * (k * depth).tanh() / (omega * omega) - 1.0;
            assert!(off.abs() < 1e-14, "{period} s, {depth} m: {off:e}");
        }
    }
}
