//! The local part of the fluidity equation: paper eq. 4 and 5, and the primitive form.

use crate::rheology::Granular;

/// Which equation the fluidity obeys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Paper eq. 3: the steady state's linearisation about the flowing root.
    Steady,
    /// Henann & Kamrin (2014), with its relaxation time t0 in seconds.
    Primitive {
        /// Relaxation time, s.
        t0: f64,
    },
}

/// The parameters of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The grains.
    pub grains: Granular,
    /// Nonlocal amplitude.
    pub a: f64,
    /// Form of the equation.
    pub form: Form,
}

impl Granular {
    /// `R = sqrt(P/rho_s)/d` of a cell in which the pressure varies by `+- reach`, so that 1/R is the
    /// mean of the cell: `int dP/sqrt(P) = 2 sqrt(P)`. Below a free surface, where P falls to zero,
    /// 1/sqrt(P) at the centre is 29 % less than the mean.
    pub(super) fn mean_rate(&self, pressure: f64, reach: f64) -> f64 {
        // The lower end may be the surface itself, and a floor there would show in the mean.
        let low = ((pressure - reach).max(0.0) / self.rho_s).sqrt() / self.d;
        0.5 * (self.rate(pressure + reach) + low)
    }
}

/// The local part of the equation in one cell: `k(g)` per volume, its derivative, and the size of
/// the terms it is made of.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Local {
    /// The sum of the terms.
    pub(super) k: f64,
    /// Its derivative with respect to g at frozen strain rate.
    pub(super) slope: f64,
    /// The sum of their magnitudes.
    pub(super) size: f64,
    /// Imbalance of the whole equation over the size of its terms.
    pub(super) imbalance: f64,
}

impl Local {
    /// Where there are no grains: an equation whose solution does not matter.
    pub(super) const NOTHING: Local = Local { k: 0.0, slope: 1.0, size: 1.0, imbalance: 0.0 };

    /// The terms of this share of a cell.
    pub(super) fn scaled(self, share: f64) -> Local {
        Local {
            k: share * self.k,
            slope: share * self.slope,
            size: share * self.size,
            imbalance: self.imbalance,
        }
    }
}

impl Law {
    /// Local fluidity, paper eq. 4 with `r = sqrt(P/rho_s)/d`, 1/s.
    pub fn g_loc(&self, mu: f64, r: f64) -> f64 {
        let Granular { mu_s, mu_2, i0, .. } = self.grains;
        // The local law has no state at mu_2 or beyond.
        let mu = mu.min(mu_2 * (1.0 - 1e-9));
        if mu > mu_s { r * i0 * (mu - mu_s) / (mu * (mu_2 - mu)) } else { 0.0 }
    }
    /// Cooperativity length, paper eq. 5, m; infinite at mu_s.
    pub fn xi(&self, mu: f64) -> f64 {
        let Granular { mu_s, mu_2, d, .. } = self.grains;
        self.a * d * ((mu_2 - mu).max(0.0) / ((mu_2 - mu_s) * (mu - mu_s).abs())).sqrt()
    }

    /// The mean of the local part over a cell in which mu varies by `mu (1 +- sqrt(3) spread)`: two
    /// Gauss points. Point values would be 1 % wrong with four cells a grain where yield starts,
    /// since the source grows like (mu - mu_s)^2.
    pub(super) fn cell_mean(
        &self,
        g: f64,
        g_old: f64,
        rate: f64,
        spread: f64,
        r: f64,
        dt: f64,
    ) -> Local {
        if spread == 0.0 {
            return self.local_terms(g, g_old, rate, r, dt);
        }
        let low = self.local_terms(g, g_old, rate * (1.0 - spread), r, dt);
        let high = self.local_terms(g, g_old, rate * (1.0 + spread), r, dt);
        Local {
            k: 0.5 * (low.k + high.k),
            slope: 0.5 * (low.slope + high.slope),
            size: 0.5 * (low.size + high.size),
            imbalance: 0.0,
        }
    }

    /// The local part of the equation divided by (A d)^2 at frozen strain rate, where mu = rate/g:
    ///
    /// steady:    `k = q (g - g_loc)`
    /// primitive: `k = [t0 (g - g_old)/dt + dmu (mu_s - mu)/(mu_2 - mu) g + b mu g^2/R]/(A d)^2`
    ///
    /// with `R = sqrt(P/rho_s)/d`.
    pub(super) fn local_terms(&self, g: f64, g_old: f64, rate: f64, r: f64, dt: f64) -> Local {
        let Granular { mu_s, mu_2, i0, d, .. } = self.grains;
        let dmu = mu_2 - mu_s;
        let scale = 1.0 / (self.a * d).powi(2);
        let mu = rate / g;
        // Iterates keep mu below mu_2; the floor only guards the last digits there.
        let w = (mu_2 - mu).max(1e-12 * mu_2);
        let x = mu - mu_s;
        let (k, slope, size) = match self.form {
            Form::Steady => {
                let sink = dmu * x.abs() * g / w;
                let sink_of_rate = dmu * g * mu * (x.signum() / w + x.abs() / (w * w));
                let xp = x.max(0.0);
                let h = xp * xp / (mu * w * w);
                let h_slope = 2.0 * xp / (mu * w * w) - h / mu + 2.0 * h / w;
                let source = dmu * i0 * r * h;
                let of_rate = sink_of_rate - dmu * i0 * r * h_slope * mu;
                (sink - source, (sink - of_rate) / g, sink + source)
            }
            Form::Primitive { t0 } => {
                let memory = t0 / dt;
                let growth = dmu * x * g / w;
                let growth_of_rate = dmu * g * mu * (1.0 / w + x / (w * w));
                let damping = dmu / i0 * rate / r;
                (
                    memory * (g - g_old) - growth + damping * g,
                    memory - (growth - growth_of_rate) / g + damping,
                    memory * (g + g_old) + growth.abs() + damping * g,
                )
            }
        };
        let [k, slope, size] = [k, slope, size].map(|term| scale * term);
        Local { k, slope, size, imbalance: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rheology::Floors;
    use proptest::prelude::*;

    const LAW: Law = Law {
        grains: Granular {
            mu_s: 0.3819,
            mu_2: 0.6435,
            i0: 0.279,
            d: 0.75e-3,
            rho_s: 2450.0,
            floors: Floors::DEFAULT,
        },
        a: 0.48,
        form: Form::Steady,
    };

    /// What the code solves is paper eq. 3 divided by xi^2: `k = (g - g_loc)/xi^2`.
    #[test]
    fn steady_terms_are_the_paper_s() {
        let r = 233.0;
        for (g, rate) in [(1.0, 0.45), (0.3, 0.1), (10.0, 5.0), (2.0, 0.5)] {
            let mu = rate / g;
            let paper = (g - LAW.g_loc(mu, r)) / LAW.xi(mu).powi(2);
            let k = LAW.local_terms(g, 0.0, rate, r, 1.0).k;
            assert!((k - paper).abs() <= 1e-12 * paper.abs(), "{g} {rate}: {k} {paper}");
        }
    }

    /// The uniform steady state obeys mu(I), in both forms (paper eq. 6).
    #[test]
    fn uniform_flow_is_local() {
        let r = 233.0;
        for i in [1e-3, 1e-2, 0.1] {
            let rate = i * r;
            let g = rate / LAW.grains.mu(i);
            for form in [Form::Steady, Form::Primitive { t0: 1e-3 }] {
                let t = Law { form, ..LAW }.local_terms(g, g, rate, r, 1e9);
                assert!(t.k.abs() < 1e-9 * t.size, "{form:?} at I = {i}: {}", t.k / t.size);
            }
        }
    }

    /// The mean of 1/R over a cell, against 20000 midpoints.
    #[test]
    fn rates_are_cell_means() {
        for (p, reach) in [(10.0, 10.0), (10.0, 9.0), (10.0, 1.0), (10.0, 0.0)] {
            let n = 20_000;
            let at = |k: i32| p + reach * ((2 * k + 1) as f64 / n as f64 - 1.0);
            let sum: f64 = (0..n).map(|k| 1.0 / LAW.grains.rate(at(k))).sum();
            let off = LAW.grains.mean_rate(p, reach) * sum / n as f64 - 1.0;
            assert!(off.abs() < 4e-3, "{p} +- {reach}: {off}");
        }
    }

    proptest! {
        /// The slope is the derivative with respect to g.
        #[test]
        fn slope_is_derivative(
            mu in 0.05f64..0.62, rate in 1e-4f64..10.0, primitive in any::<bool>()
        ) {
            prop_assume!((mu - LAW.grains.mu_s).abs() > 1e-3);
            let form = if primitive { Form::Primitive { t0: 1e-3 } } else { Form::Steady };
            let law = Law { form, ..LAW };
            let (g, r, dt) = (rate / mu, 233.0, 1e-3);
            let k = |g| law.local_terms(g, 1.0, rate, r, dt);
            let h = 1e-6 * g;
            let slope = (k(g + h).k - k(g - h).k) / (2.0 * h);
            let t = k(g);
            prop_assert!((slope - t.slope).abs() < 1e-5 * (t.slope.abs() + t.size / g));
        }
    }
}
