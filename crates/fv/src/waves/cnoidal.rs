//! Cnoidal waves: long periodic waves of finite height.

use super::elliptic::{complete, functions};
use super::progressive::Progressive;
use super::{Context, Entry, Place, Wave};
use granflow_base::Vec3;
use granflow_dict::Reader;
use std::f64::consts::{PI, TAU};

pub(super) const ENTRY: Entry = Entry {
    name: "cnoidal",
    summary: "long periodic waves: sharp crests far apart, no net flow of water",
    formula: "eta = ((1 - E/K)/m - 1) H + H cn^2(K theta/pi, m), L = c T; K, E: complete \
              elliptic integrals of m",
    reference: "I. A. Svendsen, Introduction to Nearshore Hydrodynamics, 2006, ch. 9",
    ramped: true,
    read: |r, context| Some(Box::new(Cnoidal::read(r, context))),
};

pub(super) struct Cnoidal {
    wave: Progressive,
    /// Depth, m.
    h: f64,
    /// Wave number, 1/m.
    k: f64,
    /// One less the parameter of the elliptic functions.
    m1: f64,
    /// Complete integral of the first kind.
    kk: f64,
    /// Elevation of the troughs, m.
    trough: f64,
}

impl Cnoidal {
    fn read(r: &Reader<'_>, context: Context) -> Cnoidal {
        let mut wave = Progressive::read(r, context.depth);
        if !r.has("wavePhase") {
            // A crest at time zero.
            wave.phase = 0.0;
        }
        let found = Cnoidal::new(wave, context);
        if found.is_none() && wave.height < context.depth && wave.period > 0.0 {
            let message = "the water is too deep for a cnoidal wave of this period";
            let help = Some("the waves `StokesII` and `StokesV` hold in deep water");
            r.error_at_key("wavePeriod", message, "too short", help);
        }
        let (h, k) = (context.depth, 1.0);
        found.unwrap_or(Cnoidal { wave, h, k, m1: 0.5, kk: 1.0, trough: 0.0 })
    }

    /// The longest wave for which `c T = L`, none where there is none.
    fn new(wave: Progressive, context: Context) -> Option<Cnoidal> {
        let (h, g, height) = (context.depth, context.gravity, wave.height);
        let length = |m1: f64| {
            let (kk, _) = complete(m1);
            (16.0 / 3.0 * (1.0 - m1) * h.powi(3) / height).sqrt() * kk
        };
        let off = |digits: f64| {
            let m1 = (-digits).exp();
            let (m, (kk, e)) = (1.0 - m1, complete(m1));
            let square = g * h * (1.0 + height / (m * h) * (2.0 - m - 3.0 * e / kk));
            length(m1) - square.max(0.0).sqrt() * wave.period
        };
        // From the solitary wave down.
        const STEPS: usize = 4000;
        let at = |i: usize| 600.0 * (1.0 - i as f64 / STEPS as f64);
        let below = (1..STEPS).find(|&i| off(at(i)) < 0.0)?;
        let (mut low, mut high) = (at(below), at(below - 1));
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if off(middle) < 0.0 { low = middle } else { high = middle }
        }
        let m1 = (-0.5 * (low + high)).exp();
        let (m, (kk, e)) = (1.0 - m1, complete(m1));
        // The mean elevation is zero.
        let trough = ((1.0 - e / kk) / m - 1.0) * height;
        Some(Cnoidal { wave, h, k: TAU / length(m1), m1, kk, trough })
    }

    /// The elevation and its first three derivatives along the wave.
    fn profile(&self, at: Place) -> [f64; 4] {
        let theta = self.wave.theta(self.k, at);
        let turn = theta - TAU * (theta / TAU).round();
        let [s, c, d] = functions(turn * self.kk / PI, self.m1);
        let (a, m, height) = (self.kk * self.k / PI, 1.0 - self.m1, self.wave.height);
        let s2 = s * s;
        [
            self.trough + height * c * c,
            -2.0 * height * a * s * c * d,
            2.0 * height * a * a * (2.0 * (1.0 + m) * s2 - 3.0 * m * s2 * s2 - 1.0),
            8.0 * height * a.powi(3) * s * c * d * (1.0 + m - 3.0 * m * s2),
        ]
    }

    fn celerity(&self) -> f64 {
        self.wave.omega() / self.k
    }
}

impl Wave for Cnoidal {
    fn elevation(&self, at: Place) -> f64 {
        self.profile(at)[0]
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let h = self.h;
        let [e, e1, e2, e3] = self.profile(at);
        let (y, y2) = (z / h, (z / h).powi(2));
        let along = e / h * (1.0 - e / h) + 0.5 * h * (1.0 / 3.0 - y2) * e2;
        let up = -y * ((1.0 - 2.0 * e / h) * e1 + h * h / 6.0 * (1.0 - y2) * e3);
        let c = self.celerity();
        self.wave.turned(c * along, c * up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::source::tests::{at, divergence, flux};

    const STILL: Context = Context { depth: 0.4, gravity: 9.81 };

    fn wave(height: f64, period: f64) -> Option<Cnoidal> {
        let wave = Progressive { height, period, direction: [1.0, 0.0], phase: 0.0 };
        Cnoidal::new(wave, STILL)
    }

    /// Heights from trough to crest, no mean elevation, and water neither made nor carried along.
    #[test]
    fn it_is_periodic_and_carries_nothing() {
        let w = wave(0.1, 4.0).unwrap();
        let (crest, trough) = (w.elevation(at(0.0, 0.0)), w.elevation(at(0.0, 2.0)));
        assert!((crest - trough - 0.1).abs() < 1e-12);
        let mean =
            |f: &dyn Fn(f64) -> f64| (0..400).map(|i| f(0.01 * f64::from(i))).sum::<f64>() / 400.0;
        assert!(mean(&|t| w.elevation(at(0.0, t))).abs() < 1e-12);
        assert!(divergence(&w, 0.4, at(0.3, 0.7)) < 1e-7);
        // A mean velocity of the size of mean(eta^2)/h^2 would carry 2 % of c H.
        let net = mean(&|t| flux(&w, 0.4, at(0.0, t))) / (w.celerity() * 0.1);
        assert!(net.abs() < 1e-3, "{net}");
    }

    /// Long ones are solitary waves: the profile of a crest is `H sech^2(sqrt(3 H/(4 h^3)) x)`, and
    /// so is its speed over the still water of its troughs.
    #[test]
    fn a_long_wave_is_a_row_of_solitary_ones() {
        let w = wave(0.04, 40.0).unwrap();
        let k = (0.75f64 * 0.04 / 0.4f64.powi(3)).sqrt();
        for i in 0..10 {
            let x = 0.2 * f64::from(i);
            let solitary = 0.04 * (k * x).cosh().powi(-2);
            let risen = w.elevation(at(x, 0.0)) - w.trough;
            assert!((risen - solitary).abs() < 1e-6, "{x}: {risen} {solitary}");
        }
        let c = (9.81f64 * 0.4 * 1.1).sqrt();
        assert!((w.celerity() / c - 1.0).abs() < 0.02, "{} {c}", w.celerity());
    }

    #[test]
    fn there_is_none_in_deep_water() {
        assert!(wave(0.01, 0.5).is_none());
    }
}
