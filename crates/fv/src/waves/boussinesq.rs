//! The solitary wave of Boussinesq.

use super::solitary::Crest;
use super::{Entry, Place, Wave};
use granflow_base::Vec3;

pub(super) const ENTRY: Entry = Entry {
    name: "Boussinesq",
    summary: "solitary wave of first order: eta = H sech^2(sqrt(3 H/(4 h^3)) x)",
    formula: "eta = H sech^2(sqrt(3 H/(4 h^3)) X), X = x - c t, c = sqrt(g (h + H))",
    reference: "J. Boussinesq, C. R. Acad. Sci. Paris 72 (1871) 755; J. J. Lee, J. E. Skjelbreia, \
                F. Raichlen, J. Waterw. Port Coast. Ocean Div. 108 (1982) 200",
    ramped: false,
    read: |r, context| Some(Box::new(Boussinesq(Crest::read(r, context)))),
};

pub(super) struct Boussinesq(Crest);

impl Boussinesq {
    /// Speed of the crest, m/s.
    fn celerity(&self) -> f64 {
        (self.0.gravity * (self.0.depth + self.0.height)).sqrt()
    }
    /// The elevation and its first three derivatives along the wave.
    fn profile(&self, at: Place) -> [f64; 4] {
        let Crest { height, depth, .. } = self.0;
        let k = (0.75 * height / depth.powi(3)).sqrt();
        let x = k * self.0.ahead(self.celerity(), at);
        let (s, t) = (x.cosh().powi(-2), x.tanh());
        [
            height * s,
            -2.0 * k * height * s * t,
            k * k * height * s * (4.0 - 6.0 * s),
            k.powi(3) * height * s * t * (24.0 * s - 8.0),
        ]
    }
}

impl Wave for Boussinesq {
    fn elevation(&self, at: Place) -> f64 {
        self.profile(at)[0]
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let h = self.0.depth;
        let [e, e1, e2, e3] = self.profile(at);
        let y2 = (z / h).powi(2);
        let c0 = (self.0.gravity * h).sqrt();
        let along = e / h * (1.0 - 0.25 * e / h) + h / 3.0 * (1.0 - 1.5 * y2) * e2;
        let up = -z / h * ((1.0 - 0.5 * e / h) * e1 + h * h / 3.0 * (1.0 - 0.5 * y2) * e3);
        self.0.turned(c0 * along, c0 * up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::Context;
    use crate::waves::source::tests::{at, bernoulli, divergence, flux};

    fn wave(height: f64) -> Boussinesq {
        Boussinesq(Crest::new(height, Context { depth: 0.7, gravity: 9.81 }))
    }

    /// What crosses a section is what the crest carries along, `c eta`, to second order.
    #[test]
    fn the_flux_is_that_of_the_crest() {
        let off = |height: f64| {
            let w = wave(height);
            let c = w.celerity();
            let worst = (0..40).map(|i| {
                let p = at(0.0, 0.1 * f64::from(i));
                (flux(&w, 0.7, p) - c * w.elevation(p)).abs()
            });
            worst.fold(0.0, f64::max) / (c * height)
        };
        let (large, small) = (off(0.04), off(0.02));
        assert!(large < 0.01 && (large / small).log2() > 1.8, "{large} {small}");
    }

    #[test]
    fn it_is_a_flow_of_water_under_a_free_surface() {
        let context = Context { depth: 0.7, gravity: 9.81 };
        for height in [0.3, 0.02] {
            let w = wave(height);
            assert!(divergence(&w, 0.7, at(0.2, 1.0)) < 1e-8);
        }
        let spread = |height: f64| {
            let w = wave(height);
            let far = 3.5 * 0.7 / (height / 0.7).sqrt();
            let times = |i: f64| at(0.0, 2.0 * far / w.celerity() * i / 64.0);
            bernoulli(&w, w.celerity(), context, times) / height
        };
        let (large, small) = (spread(0.02), spread(0.01));
        assert!(large < 0.02 && (large / small).log2() > 0.8, "{large} {small}");
    }
}
