//! The solitary wave of third order.

use super::solitary::Crest;
use super::{Entry, Place, Wave};
use granflow_base::Vec3;

pub(super) const ENTRY: Entry = Entry {
    name: "Grimshaw",
    summary: "solitary wave of third order",
    formula: "eta/h = e s - 3/4 e^2 s t^2 + e^3 (5/8 s t^2 - 101/80 s^2 t^2), e = H/h, s = \
              sech^2(a X/h), t = tanh(a X/h), a = sqrt(3 e/4) (1 - 5/8 e + 71/128 e^2)",
    reference: "R. Grimshaw, J. Fluid Mech. 46 (1971) 611",
    ramped: false,
    read: |r, context| Some(Box::new(Grimshaw(Crest::read(r, context)))),
};

pub(super) struct Grimshaw(Crest);

impl Grimshaw {
    /// Speed of the crest, m/s.
    fn celerity(&self) -> f64 {
        let e = self.0.epsilon();
        let square = 1.0 + e - e * e / 20.0 - 3.0 * e.powi(3) / 70.0;
        (self.0.gravity * self.0.depth * square).sqrt()
    }
    /// `sech^2` and `tanh` of the scaled distance from the crest.
    fn shape(&self, at: Place) -> (f64, f64) {
        let e = self.0.epsilon();
        let alpha = (0.75 * e).sqrt() * (1.0 - 0.625 * e + 71.0 / 128.0 * e * e);
        let x = alpha * self.0.ahead(self.celerity(), at) / self.0.depth;
        (x.cosh().powi(-2), x.tanh())
    }
}

impl Wave for Grimshaw {
    fn elevation(&self, at: Place) -> f64 {
        let e = self.0.epsilon();
        let (s, t) = self.shape(at);
        let (s1, t2) = (s, t * t);
        let third = 0.625 * s1 * t2 - 101.0 / 80.0 * s1 * s1 * t2;
        self.0.depth * (e * s1 - 0.75 * e * e * s1 * t2 + e.powi(3) * third)
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let (e, h) = (self.0.epsilon(), self.0.depth);
        let (s, t) = self.shape(at);
        let (s2, s3) = (s * s, s * s * s);
        let y = z / h;
        let (y2, y4) = (y * y, y.powi(4));
        let u2 = -0.25 * s + s2 + y2 * (1.5 * s - 2.25 * s2);
        let u3 = 19.0 / 40.0 * s + 0.2 * s2 - 1.2 * s3
            + y2 * (-1.5 * s - 3.75 * s2 + 7.5 * s3)
            + y4 * (-0.375 * s + 45.0 / 16.0 * (s2 - s3));
        let w2 = 0.375 * s + 2.0 * s2 + y2 * (0.5 * s - 1.5 * s2);
        let w3 = 49.0 / 640.0 * s - 0.85 * s2 - 3.6 * s3
            + y2 * (-13.0 / 16.0 * s - 25.0 / 16.0 * s2 + 7.5 * s3)
            + y4 * (-3.0 / 40.0 * s + 1.125 * s2 - 27.0 / 16.0 * s3);
        let c0 = (self.0.gravity * h).sqrt();
        let along = e * s - e * e * u2 - e.powi(3) * u3;
        let up = (3.0 * e).sqrt() * y * t * (e * s - e * e * w2 - e.powi(3) * w3);
        self.0.turned(c0 * along, c0 * up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::Context;
    use crate::waves::source::tests::{at, bernoulli, divergence};

    const STILL: Context = Context { depth: 0.5, gravity: 9.81 };

    fn wave(height: f64) -> Grimshaw {
        Grimshaw(Crest::new(height, STILL))
    }

    /// Head along the surface and continuity hold up to the fourth order, that of the remainder.
    #[test]
    fn it_is_a_flow_of_third_order_under_a_free_surface() {
        let spread = |height: f64| {
            let w = wave(height);
            let far = 3.5 * 0.5 / (height / 0.5).sqrt();
            let times = |i: f64| at(0.0, 2.0 * far / w.celerity() * i / 64.0);
            bernoulli(&w, w.celerity(), STILL, times)
        };
        let found = (spread(0.1) / spread(0.05)).log2();
        assert!((found - 4.0).abs() < 0.3, "{found}");
        let off = |height: f64| divergence(&wave(height), 0.5, at(0.1, 0.8));
        assert!((off(0.1) / off(0.05)).log2() > 4.0, "{} {}", off(0.1), off(0.05));
    }

    #[test]
    fn the_crest_is_as_high_as_asked() {
        let w = wave(0.2);
        let top = 3.5 * 0.5 / 0.4f64.sqrt() / w.celerity();
        assert!((w.elevation(at(0.0, top)) - 0.2).abs() < 1e-12);
    }
}
