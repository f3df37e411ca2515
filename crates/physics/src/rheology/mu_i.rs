//! The local granular laws: mu(I) and its regularised form.

use super::limited::limited;
use super::{Entry, LocalLaw, Point};
use granflow_base::Dims;
use granflow_dict::Reader;

/// Where the granular laws would divide by zero. What happens below these has no bearing on a flow:
/// `flow/tests/floors.rs` varies each of them a thousandfold. None is a viscosity in Pa s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floors {
    /// Smallest inertial number that a local law's viscosity is computed for, so that material at rest
    /// has one.
    pub rest: f64,
    /// Pressure below which grains no longer touch, over the weight of one layer of grains.
    pub loose: f64,
    /// Inertial number of material at rest in the fluidity equation.
    pub creep: f64,
    /// The same where no fluidity is known to start from: quasi-static, within a few decades of what
    /// flows.
    pub first_guess: f64,
    /// Least stress ratio in the primitive form: as good as none. Less than `creep` where the
    /// fluidity is next to nothing: a floor on the rate alone would be friction there.
    pub still: f64,
    /// Least fluidity that the primitive form remembers, 1/s: squares of what moves so slowly are
    /// numbers still.
    pub fluidity: f64,
}

impl Floors {
    /// What every run uses.
    pub const DEFAULT: Floors = Floors {
        rest: 1e-9,
        loose: 1e-6,
        creep: 1e-20,
        first_guess: 1e-4,
        still: 1e-9,
        fluidity: 1e-100,
    };
}

/// What grains are made of and how they rub: the parameters that every granular law shares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Granular {
    /// Static friction coefficient, the limit of mu for I -> 0.
    pub mu_s: f64,
    /// Limit of mu for I -> infinity.
    pub mu_2: f64,
    /// Inertial number at which mu is half way.
    pub i0: f64,
    /// Grain diameter, m.
    pub d: f64,
    /// Density of the grains' material, kg/m3.
    pub rho_s: f64,
    /// Guards against divisions by zero.
    pub floors: Floors,
}

impl Granular {
    /// Reads `mus mu2 I0 d rhos`.
    pub fn read(r: &Reader<'_>) -> Self {
        let g = Granular {
            mu_s: r.positive("mus", Dims::NONE),
            mu_2: r.positive("mu2", Dims::NONE),
            i0: r.positive("I0", Dims::NONE),
            d: r.positive("d", Dims::LENGTH),
            rho_s: r.positive("rhos", Dims::DENSITY),
            floors: Floors::DEFAULT,
        };
        if g.mu_2 <= g.mu_s {
            let message = "mu2 must exceed mus: the material cannot weaken with its rate";
            r.error_at_key("mu2", message, format!("mus is {}", g.mu_s), None);
        }
        g
    }
    /// `mu_2 - mu_s`.
    pub fn delta_mu(&self) -> f64 {
        self.mu_2 - self.mu_s
    }
    /// Pressure below which grains no longer touch, Pa ([`Floors::loose`]).
    pub fn loose(&self) -> f64 {
        self.floors.loose * self.rho_s * 9.81 * self.d
    }
    /// `sqrt(P/rho_s)/d`, the rate at which pressure rearranges grains, 1/s.
    pub fn rate(&self, pressure: f64) -> f64 {
        (pressure.max(self.loose()) / self.rho_s).sqrt() / self.d
    }
    /// Inertial number, paper eq. 6.
    pub fn inertial_number(&self, strain_rate: f64, pressure: f64) -> f64 {
        strain_rate / self.rate(pressure)
    }
    /// mu(I), paper eq. 6: `mu_s + (mu_2 - mu_s)/(I0/I + 1)`.
    pub fn mu(&self, i: f64) -> f64 {
        self.mu_s + self.delta_mu() * i / (self.i0 + i)
    }
    /// The viscosity `mu P / strain rate` of a friction coefficient that depends on I.
    fn viscosity(&self, mu: impl Fn(f64) -> f64, at: Point) -> f64 {
        let rate = self.rate(at.pressure);
        let i = (at.strain_rate / rate).max(self.floors.rest);
        mu(i) * at.pressure.max(self.loose()) / (i * rate)
    }
}

/// P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727.
pub struct MuI(pub Granular);

pub(super) const ENTRY: Entry = Entry {
    name: "muI",
    summary: "dense granular flow, local: friction depends on the inertial number",
    formula: "eta = mu(I) P/rate, mu = mus + (mu2 - mus)/(I0/I + 1), I = rate d sqrt(rhos/P); kept between \
              rho nuMin and rho nuMax where they are given",
    reference: "P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727",
    read: |r, _| limited(r, MuI(Granular::read(r))),
};

impl LocalLaw for MuI {
    fn viscosity(&self, at: Point) -> f64 {
        self.0.viscosity(|i| self.0.mu(i), at)
    }
    fn reads_pressure(&self) -> bool {
        true
    }
    fn grains(&self) -> Option<Granular> {
        Some(self.0)
    }
    fn is_ill_posed(&self, at: Point) -> Option<bool> {
        let i = self.0.inertial_number(at.strain_rate, at.pressure);
        // Below it material is at rest, and in tension it is no material.
        let yields = i > self.0.floors.rest && at.pressure > self.0.loose();
        yields.then(|| ill_posedness(&self.0, i) > 0.0)
    }
}

/// T. Barker, J. M. N. T. Gray, J. Fluid Mech. 828 (2017) 5: mu(I) made well posed at low and at
/// high inertial numbers.
pub struct MuIRegularised {
    /// The grains.
    pub grains: Granular,
    /// Slope of mu at high inertial numbers.
    pub mu_inf: f64,
    /// Shape of the creep branch.
    pub alpha: f64,
    /// Inertial number below which mu(I) is ill-posed.
    i1: f64,
    /// Constant that joins the branches.
    a: f64,
}

pub(super) const ENTRY_REGULARISED: Entry = Entry {
    name: "muIRegularised",
    summary: "mu(I) made well posed: a creep branch below, a linear one above",
    formula: "mu = sqrt(alpha/ln(A/I)) for I <= I1, else (mus I0 + mu2 I + muInf I^2)/(I0 + I); limits as of muI",
    reference: "T. Barker, J. M. N. T. Gray, J. Fluid Mech. 828 (2017) 5",
    read: |r, _| {
        let grains = Granular::read(r);
        let mu_inf = r.opt_non_negative("muInf", Dims::NONE, 0.05);
        let alpha = r.opt_positive("alphaReg", Dims::NONE, 1.9);
        limited(r, MuIRegularised::new(grains, mu_inf, alpha))
    },
};

/// Barker et al.'s criterion: mu(I) is well posed where `C <= 0` (J. Fluid Mech. 779 (2015) 794).
fn ill_posedness(g: &Granular, i: f64) -> f64 {
    let mu = g.mu(i);
    let n = g.delta_mu() * g.i0 * i / ((g.i0 + i).powi(2) * mu);
    4.0 * n * n - 4.0 * n + mu * mu * (1.0 - n / 2.0).powi(2)
}

impl MuIRegularised {
    /// Finds the lower end of the well-posed range and joins the branches there.
    pub fn new(grains: Granular, mu_inf: f64, alpha: f64) -> Self {
        // C is positive at I -> 0 and falls: bisect in ln I for its first root below I0.
        let (mut low, mut high) = (1e-12_f64.ln(), grains.i0.ln());
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if ill_posedness(&grains, middle.exp()) > 0.0 { low = middle } else { high = middle }
        }
        let i1 = high.exp();
        let mut law = MuIRegularised { grains, mu_inf, alpha, i1, a: 1.0 };
        law.a = i1 * (alpha / law.fast(i1).powi(2)).exp();
        law
    }
    fn fast(&self, i: f64) -> f64 {
        let g = &self.grains;
        (g.mu_s * g.i0 + g.mu_2 * i + self.mu_inf * i * i) / (g.i0 + i)
    }
    /// The friction coefficient.
    pub fn mu(&self, i: f64) -> f64 {
        if i > self.i1 { self.fast(i) } else { (self.alpha / (self.a / i).ln()).sqrt() }
    }
}

impl LocalLaw for MuIRegularised {
    fn viscosity(&self, at: Point) -> f64 {
        self.grains.viscosity(|i| self.mu(i), at)
    }
    fn reads_pressure(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BEADS: Granular = Granular {
        mu_s: 0.3819,
        mu_2: 0.6435,
        i0: 0.279,
        d: 0.75e-3,
        rho_s: 2450.0,
        floors: Floors::DEFAULT,
    };

    /// model.md section 5: mu(I) is ill-posed for I < 0.0194 and I > 0.852 with these beads.
    #[test]
    fn mu_of_i_is_ill_posed_at_low_and_at_high_rates() {
        let at =
            |i: f64| Point { strain_rate: i * BEADS.rate(1e3), pressure: 1e3, density: 1519.0 };
        for (i, ill) in [(1e-6, true), (0.0192, true), (0.0196, false), (0.1, false)] {
            assert_eq!(MuI(BEADS).is_ill_posed(at(i)), Some(ill), "{i}");
        }
        for (i, ill) in [(0.845, false), (0.86, true), (10.0, true)] {
            assert_eq!(MuI(BEADS).is_ill_posed(at(i)), Some(ill), "{i}");
        }
        assert_eq!(MuI(BEADS).is_ill_posed(at(1e-12)), None, "at rest");
        assert_eq!(MuIRegularised::new(BEADS, 0.05, 1.9).is_ill_posed(at(1e-3)), None);
    }

    proptest! {
        /// Stress over pressure stays between mu_s and mu_2 and is what the definition says.
        #[test]
        fn stress_ratio_is_mu_of_i(rate in 1e-5f64..1e4, pressure in 1e-2f64..1e6) {
            let at = Point { strain_rate: rate, pressure, density: 1519.0 };
            let ratio = MuI(BEADS).viscosity(at) * rate / pressure;
            prop_assert!((BEADS.mu_s..=BEADS.mu_2).contains(&ratio));
            let i = rate * BEADS.d / (pressure / BEADS.rho_s).sqrt();
            prop_assert!((ratio - BEADS.mu(i)).abs() < 1e-12);
        }
        /// Only the ratio of rate and sqrt(P) counts: the law has no other scale.
        #[test]
        fn scales_with_units(rate in 1e-3f64..1e3, pressure in 1.0f64..1e5, k in 0.1f64..10.0) {
            let eta = |rate, pressure| {
                MuI(BEADS).viscosity(Point { strain_rate: rate, pressure, density: 1519.0 })
            };
            let scaled = eta(k * rate, k * k * pressure);
            prop_assert!((scaled / (k * eta(rate, pressure)) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn regularised_law_meets_the_known_bound_and_is_continuous() {
        let law = MuIRegularised::new(BEADS, 0.05, 1.9);
        // model.md: ill-posed below 0.0194 with these beads.
        assert!((law.i1 - 0.0194).abs() < 2e-4, "{}", law.i1);
        let jump = law.mu(law.i1 * (1.0 - 1e-9)) - law.mu(law.i1 * (1.0 + 1e-9));
        assert!(jump.abs() < 1e-8);
        // The creep branch falls towards zero, if slowly.
        let branch = [1e-12, 1e-6, 1e-3, law.i1].map(|i| law.mu(i));
        assert!(branch.is_sorted() && branch[0] < 0.6 * branch[3], "{branch:?}");
    }

    #[test]
    fn material_at_rest_has_a_finite_viscosity() {
        let at = Point { strain_rate: 0.0, pressure: 75.0, density: 1519.0 };
        let eta = MuI(BEADS).viscosity(at);
        assert!(eta.is_finite() && eta > 1e6);
    }
}
