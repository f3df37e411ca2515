//! Stokes' waves of first and second order.

use super::progressive::{Progressive, ratios, wave_number};
use super::{Context, Entry, Place, Wave};
use granflow_base::Vec3;
use granflow_dict::Reader;

/// Small waves, and the second harmonic that their height brings.
pub(super) struct Stokes {
    wave: Progressive,
    /// Wave number, 1/m.
    k: f64,
    /// Depth, m.
    h: f64,
    /// Above this the velocity is what it is here, m: expansions about still water say nothing of
    /// what is above it.
    cap: f64,
    /// Amplitudes of elevation of both harmonics, m.
    a: [f64; 2],
    /// Amplitudes of velocity, m/s: those of the vertical one at still water.
    u: [f64; 2],
}

pub(super) const FIRST: Entry = Entry {
    name: "StokesI",
    summary: "small waves in water of any depth",
    formula: "eta = (H/2) cos(theta), theta = k (x cos a + y sin a) - omega t + phase, omega^2 \
              = g k tanh(k h)",
    reference: "R. G. Dean, R. A. Dalrymple, Water Wave Mechanics for Engineers and Scientists, \
                1991, ch. 3",
    ramped: true,
    read: |r, context| Some(Box::new(Stokes::read(r, context, false))),
};

pub(super) const SECOND: Entry = Entry {
    name: "StokesII",
    summary: "waves of second order in their steepness: higher crests, flatter troughs",
    formula: "eta = a cos(theta) + (k a^2/4) c (3 c^2 - 1) cos(2 theta), a = H/2, c = coth(k \
              h)",
    reference: "R. G. Dean, R. A. Dalrymple, Water Wave Mechanics for Engineers and Scientists, \
                1991, ch. 11",
    ramped: true,
    read: |r, context| Some(Box::new(Stokes::read(r, context, true))),
};

impl Stokes {
    fn read(r: &Reader<'_>, context: Context, second: bool) -> Stokes {
        Stokes::new(Progressive::read(r, context.depth), context, second)
    }
    pub(super) fn new(wave: Progressive, context: Context, second: bool) -> Stokes {
        let k = wave_number(wave.period, context);
        let (h, a, omega) = (context.depth, 0.5 * wave.height, wave.omega());
        let (s, ct) = ((k * h).sinh(), 1.0 / (k * h).tanh());
        // 3/4 a^2 omega k sinh(2 k h)/sinh^4(k h) in water of any depth.
        let (a2, u2) = match second {
            true => (
                0.25 * k * a * a * ct * (3.0 * ct * ct - 1.0),
                1.5 * a * a * omega * k * ct / (s * s),
            ),
            false => (0.0, 0.0),
        };
        Stokes { wave, k, h, cap: h, a: [a, a2], u: [a * omega, u2] }
    }
}

impl Wave for Stokes {
    fn elevation(&self, at: Place) -> f64 {
        let theta = self.wave.theta(self.k, at);
        self.a[0] * theta.cos() + self.a[1] * (2.0 * theta).cos()
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let theta = self.wave.theta(self.k, at);
        let z = z.min(self.cap);
        let [[c1, s1], [c2, s2]] = [1.0, 2.0].map(|n| ratios(n * self.k, z, self.h));
        let [u1, u2] = self.u;
        let along = u1 * c1 * theta.cos() + u2 * c2 * (2.0 * theta).cos();
        let up = u1 * s1 * theta.sin() + u2 * s2 * (2.0 * theta).sin();
        self.wave.turned(along, up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::source::tests::{at, bernoulli};

    fn wave(height: f64) -> Progressive {
        Progressive { height, period: 3.0, direction: [1.0, 0.0], phase: 0.0 }
    }

    /// The head along the surface of a steady frame is uniform up to the next order of the height.
    #[test]
    fn the_surface_is_free_to_the_order_of_the_theory() {
        let context = Context { depth: 0.4, gravity: 9.81 };
        for (second, order) in [(false, 2.0), (true, 3.0)] {
            let spread = |height| {
                let w = Stokes::new(wave(height), context, second);
                // No cap: the surface of the crest is above still water.
                let w = Stokes { cap: 1.0, ..w };
                bernoulli(&w, w.wave.omega() / w.k, context, |i| at(0.0, 3.0 * i / 64.0))
            };
            let (large, small) = (spread(2e-3), spread(1e-3));
            let found = (large / small).log2();
            assert!((found - order).abs() < 0.1, "order {order}: {found}");
        }
    }

    #[test]
    fn a_low_wave_of_second_order_is_one_of_first() {
        let context = Context { depth: 0.4, gravity: 9.81 };
        let [one, two] = [false, true].map(|second| Stokes::new(wave(1e-6), context, second));
        for i in 0..8 {
            let p = at(0.3, 0.4 * f64::from(i));
            let off = (one.elevation(p) - two.elevation(p)).abs();
            assert!(off < 1e-11, "{off}");
        }
    }
}
