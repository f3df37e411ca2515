//! McCowan's solitary wave.

use super::solitary::Crest;
use super::{Entry, Place, Wave};
use granflow_base::Vec3;
use granflow_dict::Reader;

pub(super) const ENTRY: Entry = Entry {
    name: "McCowan",
    summary: "solitary wave with an exact profile of its flow",
    formula: "eta/h = (N/M) sin(M (1 + eta/h))/(cos(M (1 + eta/h)) + cosh(M X/h)); H/h = (N/M) \
              tan(M (1 + H/h)/2), N = 2/3 sin^2(M (1 + 2/3 H/h))",
    reference: "J. McCowan, Phil. Mag. 32 (1891) 45",
    ramped: false,
    read: |r, context| {
        let crest = Crest::read(r, context);
        Some(Box::new(McCowan::read(r, crest)))
    },
};

pub(super) struct McCowan {
    crest: Crest,
    m: f64,
    n: f64,
}

impl McCowan {
    fn read(r: &Reader<'_>, crest: Crest) -> McCowan {
        let found = McCowan::new(crest);
        if found.is_none() && crest.height < crest.depth {
            let label = format!("{:.4} of the depth", crest.epsilon());
            let message = "McCowan's theory has no wave as high as this";
            r.error_at_key("waveHeight", message, label, None);
        }
        found.unwrap_or(McCowan { crest, m: 1.0, n: 1.0 })
    }

    /// M and N from `H/h = N/M tan(M (1 + H/h)/2)` with `N = 2/3 sin^2(M (1 + 2/3 H/h))`: the least
    /// M, which is the one that becomes `sqrt(3 H/h)` for low waves; none where there is none.
    fn new(crest: Crest) -> Option<McCowan> {
        let e = crest.epsilon();
        let n = |m: f64| 2.0 / 3.0 * (m * (1.0 + 2.0 / 3.0 * e)).sin().powi(2);
        let off = |m: f64| n(m) * (0.5 * m * (1.0 + e)).tan() - e * m;
        const STEPS: usize = 1000;
        let most = std::f64::consts::PI / (1.0 + e);
        let at = |i: usize| most * i as f64 / STEPS as f64;
        let above = (1..STEPS).find(|&i| off(at(i)) > 0.0)?;
        let (mut low, mut high) = (at(above - 1), at(above));
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if off(middle) > 0.0 { high = middle } else { low = middle }
        }
        let m = 0.5 * (low + high);
        Some(McCowan { crest, m, n: n(m) })
    }

    /// Speed of the crest, m/s.
    fn celerity(&self) -> f64 {
        (self.crest.gravity * self.crest.depth * self.m.tan() / self.m).sqrt()
    }
    /// Scaled distance from the crest.
    fn distance(&self, at: Place) -> f64 {
        self.m * self.crest.ahead(self.celerity(), at) / self.crest.depth
    }
}

impl Wave for McCowan {
    fn elevation(&self, at: Place) -> f64 {
        let McCowan { crest, m, n } = *self;
        let far = self.distance(at).cosh();
        if !far.is_finite() {
            return 0.0;
        }
        // eta/h = N/M sin(M(1 + eta/h)) / (cos(M(1 + eta/h)) + cosh(M x/h)), between 0 and H/h.
        let off = |e: f64| {
            let (s, c) = (m * (1.0 + e)).sin_cos();
            e - n / m * s / (c + far)
        };
        let (mut low, mut high) = (0.0, crest.epsilon());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if off(middle) > 0.0 { high = middle } else { low = middle }
        }
        0.5 * (low + high) * crest.depth
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let x = self.distance(at);
        let (s, c) = (self.m * z / self.crest.depth).sin_cos();
        let (sh, ch) = (x.sinh(), x.cosh());
        let below = (c + ch) * (c + ch);
        if !below.is_finite() {
            return [0.0; 3];
        }
        let k = self.celerity() * self.n / below;
        self.crest.turned(k * (1.0 + c * ch), k * s * sh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::Context;
    use crate::waves::source::tests::{at, bernoulli, divergence, flux};

    const STILL: Context = Context { depth: 0.2, gravity: 9.81 };

    /// Its surface is a stream line exactly: what crosses a section is `c eta`.
    #[test]
    fn the_surface_is_a_stream_line() {
        let w = McCowan::new(Crest::new(0.06, STILL)).unwrap();
        for i in 0..30 {
            let p = at(0.0, 0.05 * f64::from(i));
            let (q, carried) = (flux(&w, 0.2, p), w.celerity() * w.elevation(p));
            assert!((q - carried).abs() < 1e-9, "{q} {carried}");
        }
        assert!(divergence(&w, 0.2, at(0.1, 0.4)) < 1e-7);
    }

    #[test]
    fn low_waves_are_those_of_boussinesq() {
        let low = McCowan::new(Crest::new(2e-4, STILL)).unwrap();
        assert!((low.m / 3e-3f64.sqrt() - 1.0).abs() < 2e-3, "{}", low.m);
        assert!((low.celerity() / (9.81f64 * 0.2 * 1.001).sqrt() - 1.0).abs() < 1e-5);
        let spread = |height: f64| {
            let w = McCowan::new(Crest::new(height, STILL)).unwrap();
            let far = 3.5 * 0.2 / (height / 0.2).sqrt();
            bernoulli(&w, w.celerity(), STILL, |i| at(0.0, 2.0 * far / w.celerity() * i / 64.0))
                / height
        };
        assert!(spread(0.02) < 0.02, "{}", spread(0.02));
    }
}
