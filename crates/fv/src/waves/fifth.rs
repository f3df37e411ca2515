//! Stokes' wave of fifth order.

use super::progressive::{Progressive, ratios, wave_number};
use super::{Context, Entry, Place, Wave};
use granflow_base::Vec3;
use granflow_dict::Reader;
use std::f64::consts::PI;

pub(super) const ENTRY: Entry = Entry {
    name: "StokesV",
    summary: "waves of fifth order in their steepness, up to about half of the height at which \
              waves break",
    formula: "k eta = sum_{n=1..5} B_n(k h, lambda) cos(n theta), lambda and k from H and T by \
              the relation of dispersion of fifth order",
    reference: "L. Skjelbreia, J. Hendrickson, Proc. 7th Coastal Eng. Conf. (1960) 184; sign of a \
                term in C2 after J. D. Fenton, J. Waterw. Port Coast. Ocean Eng. 111 (1985) 216",
    ramped: true,
    read: |r, context| Some(Box::new(Fifth::read(r, context))),
};

/// Beyond this `k h` water is as good as bottomless.
const DEEP: f64 = 15.0;

pub(super) struct Fifth {
    wave: Progressive,
    /// Depth, m.
    h: f64,
    /// Wave number, 1/m.
    k: f64,
    /// Amplitudes of the five harmonics of the elevation, m.
    elevation: [f64; 5],
    /// Of the velocity, m/s: those of the vertical one at still water.
    velocity: [f64; 5],
}

/// The paper's coefficients of powers of lambda, rows of harmonics.
struct Coefficients {
    /// Of the potential, times `sinh(n k h)`.
    a: [[f64; 3]; 5],
    /// Of the elevation.
    b: [[f64; 3]; 5],
    /// Of the dispersion relation.
    c: [f64; 2],
}

impl Coefficients {
    /// `x = k h`.
    fn new(x: f64) -> Coefficients {
        let x = x.min(DEEP);
        let (s, c) = (x.sinh(), x.cosh());
        let p =
            |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, k| sum * c * c + k);
        let s_to = |n: i32| s.powi(n);
        let six = 6.0 * c * c - 1.0;
        let eight = p(&[3.0, -11.0, 8.0]);
        let a13 = -c * c * p(&[1.0, 5.0]) / (8.0 * s_to(5));
        let a15 = -p(&[18.0, -249.0, 2641.0, -1992.0, -1440.0, 1184.0]) / (1536.0 * s_to(11));
        let a22 = 3.0 / (8.0 * s_to(4));
        let a24 = p(&[-17.0, 480.0, -312.0, -424.0, 192.0]) / (768.0 * s_to(10));
        let a33 = p(&[13.0, -4.0]) / (64.0 * s_to(7));
        let a35 = p(&[107.0, -3154.0, 16704.0, -12808.0, -6800.0, 4224.0, 512.0])
            / (4096.0 * s_to(13) * six);
        let a44 = p(&[-197.0, 1338.0, -816.0, 80.0]) / (1536.0 * s_to(10) * six);
        let a55 = -p(&[-16245.0, 163_470.0, -432_000.0, 324_000.0, -72480.0, 2880.0])
            / (61440.0 * s_to(11) * six * eight);
        let b22 = c * p(&[1.0, 2.0]) / (4.0 * s_to(3));
        let b24 = c * p(&[21.0, 322.0, -192.0, -504.0, 272.0]) / (384.0 * s_to(9));
        let b33 = 3.0 * p(&[1.0, 0.0, 0.0, 8.0]) / (64.0 * s_to(6));
        let b35 = p(&[-81.0, -54.0, 6264.0, -21816.0, 54000.0, 70848.0, -208_224.0, 88128.0])
            / (12288.0 * s_to(12) * six);
        let b44 = c * p(&[-21.0, 106.0, 48.0, -48.0, -448.0, 768.0]) / (384.0 * s_to(9) * six);
        let top = [225.0, -1050.0, -1800.0, 7160.0, -7280.0, 20160.0, 83680.0, -262_720.0];
        let b55 = (p(&top) + 192_000.0 * c.powi(16)) / (12288.0 * s_to(10) * six * eight);
        let c1 = p(&[9.0, -8.0, 8.0]) / (8.0 * s_to(4));
        // The paper has +2592.
        let c2 = p(&[147.0, -1830.0, 5944.0, -1008.0, -2592.0, -4096.0, 3840.0])
            / (512.0 * s_to(10) * six);
        let sinh = [1.0, 2.0, 3.0, 4.0, 5.0].map(|n: f64| (n * x).sinh());
        let a = [
            [1.0 / s, a13, a15],
            [a22, a24, 0.0],
            [a33, a35, 0.0],
            [a44, 0.0, 0.0],
            [a55, 0.0, 0.0],
        ];
        let mut scaled = a;
        for (row, sinh) in scaled.iter_mut().zip(sinh) {
            *row = row.map(|a| a * sinh);
        }
        Coefficients {
            a: scaled,
            b: [
                [1.0, 0.0, 0.0],
                [b22, b24, 0.0],
                [b33, b35, 0.0],
                [b44, 0.0, 0.0],
                [b55, 0.0, 0.0],
            ],
            c: [c1, c2],
        }
    }

    /// Powers of lambda that make half the height times `k`: `lambda + B33 lambda^3 + (B35 + B55)
    /// lambda^5 = k H/2`.
    fn lambda(&self, half: f64) -> f64 {
        let (third, fifth) = (self.b[2][0], self.b[2][1] + self.b[4][0]);
        let mut l = half;
        for _ in 0..50 {
            let off = l + third * l.powi(3) + fifth * l.powi(5) - half;
            let step = off / (1.0 + 3.0 * third * l * l + 5.0 * fifth * l.powi(4));
            l -= step;
            if step.abs() <= 1e-15 * half || l.is_nan() {
                break;
            }
        }
        l
    }
}

/// Of the rows of harmonics: `sum_j row[j] lambda^(n + 2 j)`.
fn summed(rows: [[f64; 3]; 5], lambda: f64) -> [f64; 5] {
    std::array::from_fn(|n| {
        let [first, second, third] = rows[n];
        lambda.powi(n as i32 + 1) * (first + lambda * lambda * (second + lambda * lambda * third))
    })
}

impl Fifth {
    fn read(r: &Reader<'_>, context: Context) -> Fifth {
        let wave = Progressive::read(r, context.depth);
        let found = Fifth::new(wave, context);
        if found.is_none() && wave.height < context.depth && wave.period > 0.0 {
            let message = "Stokes' theory of fifth order has no wave of this height and period in \
                           water of this depth";
            let help = "long waves in shallow water are `cnoidal`; waves close to breaking need \
                        `streamFunction`";
            r.error_at_key("waveHeight", message, "too high", Some(help));
        }
        let h = context.depth;
        found.unwrap_or(Fifth { wave, h, k: 1.0, elevation: [0.0; 5], velocity: [0.0; 5] })
    }

    /// Elevation at a phase, m.
    fn profile(&self, theta: f64) -> f64 {
        (0..5).map(|n| self.elevation[n] * ((n + 1) as f64 * theta).cos()).sum()
    }

    /// Solves the dispersion relation of the wave together with its height, from the wave number of
    /// a small wave down to half of it.
    fn new(wave: Progressive, context: Context) -> Option<Fifth> {
        let h = context.depth;
        let target = wave.omega().powi(2) * h / context.gravity;
        let off = |k: f64| {
            let all = Coefficients::new(k * h);
            let l2 = all.lambda(0.5 * k * wave.height).powi(2);
            k * h * (k * h).tanh() * (1.0 + all.c[0] * l2 + all.c[1] * l2 * l2) - target
        };
        let small = wave_number(wave.period, context);
        const STEPS: usize = 200;
        let at = |i: usize| small * (1.0 + 1e-9 - 0.5 * i as f64 / STEPS as f64);
        let below = (1..=STEPS).find(|&i| off(at(i)) < 0.0)?;
        let (mut low, mut high) = (at(below), at(below - 1));
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if off(middle) < 0.0 { low = middle } else { high = middle }
        }
        let k = 0.5 * (low + high);
        let all = Coefficients::new(k * h);
        let lambda = all.lambda(0.5 * k * wave.height);
        let elevation = summed(all.b, lambda).map(|b| b / k);
        let potential = summed(all.a, lambda);
        let celerity = wave.omega() / k;
        let velocity = std::array::from_fn(|n| celerity * (n + 1) as f64 * potential[n]);
        let found = Fifth { wave, h, k, elevation, velocity };
        // Where the series fails its profile has more than one crest.
        const PARTS: u32 = 64;
        let profile = |i: u32| found.profile(PI * f64::from(i) / f64::from(PARTS));
        let falls = (0..PARTS).all(|i| profile(i + 1) < profile(i));
        falls.then_some(found)
    }
}

impl Wave for Fifth {
    fn elevation(&self, at: Place) -> f64 {
        self.profile(self.wave.theta(self.k, at))
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let theta = self.wave.theta(self.k, at);
        let (mut along, mut up) = (0.0, 0.0);
        for (n, u) in self.velocity.iter().enumerate() {
            let j = (n + 1) as f64;
            let [cosh, sinh] = ratios(j * self.k, z, self.h);
            let (s, c) = (j * theta).sin_cos();
            along += u * cosh * c;
            up += u * sinh * s;
        }
        self.wave.turned(along, up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::source::tests::{at, bernoulli, flux};
    use crate::waves::stokes::Stokes;
    use std::f64::consts::TAU;

    const STILL: Context = Context { depth: 0.4, gravity: 9.81 };

    fn wave(height: f64) -> Progressive {
        Progressive { height, period: 1.2, direction: [1.0, 0.0], phase: 0.0 }
    }

    /// The head along the surface is uniform up to the sixth power of the height, which fails with a
    /// wrong digit in any coefficient; and so is the flux in the frame of the crest.
    #[test]
    fn the_surface_is_free_to_sixth_order() {
        let spread = |height: f64| {
            let w = Fifth::new(wave(height), STILL).unwrap();
            let c = w.wave.omega() / w.k;
            let head = bernoulli(&w, c, STILL, |i| at(0.0, 1.2 * i / 64.0));
            let steady = (0..32).map(|i| {
                let p = at(0.0, 1.2 / 32.0 * f64::from(i));
                flux(&w, 0.4, p) - c * w.elevation(p)
            });
            let (low, high) = steady.fold((f64::MAX, f64::MIN), |(l, h), q| (q.min(l), q.max(h)));
            [head, high - low]
        };
        let (large, small) = (spread(0.04), spread(0.02));
        for i in 0..2 {
            let found = (large[i] / small[i]).log2();
            assert!((found - 6.0).abs() < 0.4, "{i}: {found}, {} {}", large[i], small[i]);
        }
    }

    #[test]
    fn it_is_as_high_as_asked_and_longer_than_a_small_wave() {
        let w = Fifth::new(Progressive { period: 2.0, ..wave(0.1) }, STILL).unwrap();
        let crest = w.elevation(at(0.0, 0.0)) - w.elevation(at(0.0, 1.0));
        assert!((crest - 0.1).abs() < 1e-14, "{crest}");
        let longer = wave_number(2.0, STILL) / w.k;
        assert!(longer > 1.02 && longer < 1.05, "{} m", TAU / w.k);
    }

    /// What the second order leaves out is of third order.
    #[test]
    fn low_waves_are_those_of_second_order() {
        let off = |height: f64| {
            let five = Fifth::new(wave(height), STILL).unwrap();
            let two = Stokes::new(wave(height), STILL, true);
            let mut worst = [0.0f64; 2];
            for i in 0..8 {
                let p = at(0.0, 0.15 * f64::from(i));
                let (u, v) = (five.velocity(p, 0.3), two.velocity(p, 0.3));
                worst[0] = worst[0].max((five.elevation(p) - two.elevation(p)).abs());
                worst[1] = worst[1].max((u[0] - v[0]).abs().max((u[2] - v[2]).abs()));
            }
            worst
        };
        let (large, small) = (off(0.01), off(0.005));
        for i in 0..2 {
            let found = (large[i] / small[i]).log2();
            assert!((found - 3.0).abs() < 0.1, "{i}: {found}, {} {}", large[i], small[i]);
        }
    }

    #[test]
    fn deep_water_has_no_bottom_and_long_waves_are_refused() {
        let deep = |depth| Fifth::new(wave(0.05), Context { depth, ..STILL }).unwrap();
        assert!((deep(20.0).k / deep(400.0).k - 1.0).abs() < 1e-12);
        assert!(Fifth::new(Progressive { period: 12.0, ..wave(0.2) }, STILL).is_none());
    }
}
