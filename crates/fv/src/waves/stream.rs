//! Waves by a stream function whose coefficients the case gives.

use super::progressive::{Progressive, ratios};
use super::{Context, Entry, Place, Wave};
use granflow_base::{Dims, Vec3};
use granflow_dict::Reader;
use std::f64::consts::TAU;

pub(super) const ENTRY: Entry = Entry {
    name: "streamFunction",
    summary: "periodic waves of any height by Fourier coefficients of the stream function, `Bjs`, \
              and of the surface, `Ejs`, from another program",
    formula: "k eta = sum_j Ejs_j cos(j theta), u = omega/k - uMean + sum_j j Bjs_j sqrt(g/k) \
              cosh(j k z)/cosh(j k h) cos(j theta)",
    reference: "M. M. Rienecker, J. D. Fenton, J. Fluid Mech. 104 (1981) 119; J. D. Fenton, \
                Computers and Geosciences 14 (1988) 357",
    ramped: true,
    read: |r, context| Some(Box::new(Stream::read(r, context))),
};

/// One harmonic.
struct Harmonic {
    /// Number.
    j: f64,
    /// Of the elevation, m.
    elevation: f64,
    /// Of the velocity, m/s: `j B_j sqrt(g/k) tanh(j k h)`.
    velocity: f64,
}

struct Stream {
    wave: Progressive,
    h: f64,
    k: f64,
    /// Celerity less the mean velocity under the crest's frame: a current, m/s.
    current: f64,
    harmonics: Vec<Harmonic>,
}

impl Stream {
    fn read(r: &Reader<'_>, context: Context) -> Stream {
        let Context { depth: h, gravity } = context;
        let wave = Progressive::read(r, h);
        let k = TAU / r.positive("waveLength", Dims::LENGTH);
        let mean = r.scalar("uMean", Dims::VELOCITY);
        let (b, e) = (r.scalars("Bjs"), r.scalars("Ejs"));
        if b.len() != e.len() {
            let message = "`Bjs` and `Ejs` need the same number of coefficients";
            let label = format!("{} here, {} in `Bjs`", e.len(), b.len());
            r.error_at_key("Ejs", message, label, None);
        }
        let harmonic = |(i, (b, e)): (usize, (&f64, &f64))| {
            let j = (i + 1) as f64;
            let velocity = j * b * (gravity / k).sqrt() * (j * k * h).tanh();
            Harmonic { j, elevation: e / k, velocity }
        };
        let harmonics = b.iter().zip(&e).enumerate().map(harmonic).collect();
        Stream { wave, h, k, current: wave.omega() / k - mean, harmonics }
    }
}

impl Wave for Stream {
    fn elevation(&self, at: Place) -> f64 {
        let theta = self.wave.theta(self.k, at);
        self.harmonics.iter().map(|w| w.elevation * (w.j * theta).cos()).sum()
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let theta = self.wave.theta(self.k, at);
        let (mut along, mut up) = (self.current, 0.0);
        for w in &self.harmonics {
            let [cosh, sinh] = ratios(w.j * self.k, z, self.h);
            let (s, c) = (w.j * theta).sin_cos();
            along += w.velocity * cosh * c;
            up += w.velocity * sinh * s;
        }
        self.wave.turned(along, up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::source::tests::{at, bernoulli, divergence, flux};
    use granflow_dict::{Sink, parse_str};

    /// 0.1517 m high, 6.2832 m long and 3.017 s of period on 0.4 m, computed by Fenton's method with
    /// ten harmonics.
    const TEXT: &str = "waveHeight 0.1517; wavePeriod 3.017; wavePhase 0; uMean 2.0825; \
        waveLength 6.2832; \
        Bjs (8.6669014e-2 2.4849799e-2 7.744685e-3 2.335542e-3 6.4497731e-4 1.5205114e-4 \
        2.5433769e-5 -2.2045436e-7 -2.8711504e-6 -1.2287334e-6); \
        Ejs (5.6009609e-2 3.1638171e-2 1.5375952e-2 7.1743178e-3 3.3737077e-3 1.632488e-3 \
        8.233198e-4 4.4403497e-4 2.7580059e-4 2.2810557e-4);";

    #[test]
    fn coefficients_of_an_exact_wave_make_one() {
        let (dict, _) = parse_str(TEXT);
        let (sink, still) = (Sink::new(), Context { depth: 0.4, gravity: 9.81 });
        let w = Stream::read(&Reader::new(&dict, &sink), still);
        assert!(!sink.has_errors());
        let (crest, trough) = (w.elevation(at(0.0, 0.0)), w.elevation(at(0.0, 1.5085)));
        // The last harmonic counts half in such a series.
        assert!((crest - trough - 0.1517).abs() < 4e-4, "{}", crest - trough);
        assert!(divergence(&w, 0.4, at(0.3, 0.7)) < 1e-8);
        // The head along the surface, m, and the flux under it less what it carries along.
        let c = w.wave.omega() / w.k;
        let head = bernoulli(&w, c, still, |i| at(0.0, 3.017 * i / 64.0));
        assert!(head < 0.01 * 0.1517, "{head}");
        let steady = (0..16).map(|i| {
            let p = at(0.0, 3.017 / 16.0 * f64::from(i));
            flux(&w, 0.4, p) - c * w.elevation(p)
        });
        let (low, high) = steady.fold((f64::MAX, f64::MIN), |(l, h), q| (q.min(l), q.max(h)));
        assert!(high - low < 0.01 * c * 0.1517, "{low} {high}");
    }
}
