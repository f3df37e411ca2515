//! From one plateau of viscosity to another, with a sharpness.

use super::{Entry, LocalLaw, Point, local};
use granflow_base::Dims;

/// Shear thinning between two plateaus, with the sharpness a.
pub struct BirdCarreau {
    /// Viscosity at rest, m2/s.
    pub nu0: f64,
    /// Viscosity at high rates, m2/s.
    pub nu_inf: f64,
    /// Time constant, s.
    pub k: f64,
    /// Exponent.
    pub n: f64,
    /// Sharpness of the transition.
    pub a: f64,
    /// Density that turns the kinematic law into a dynamic one, kg/m3.
    pub density: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "BirdCarreau",
    summary: "shear thinning between two plateaus, with the sharpness a",
    formula: "nu = nuInf + (nu0 - nuInf)(1 + (k rate)^a)^((n-1)/a)",
    reference: "K. Yasuda, R. C. Armstrong, R. E. Cohen, Rheol. Acta 20 (1981) 163",
    read: |r, context| {
        local(BirdCarreau {
            nu0: r.positive("nu0", Dims::KINEMATIC_VISCOSITY),
            nu_inf: r.non_negative("nuInf", Dims::KINEMATIC_VISCOSITY),
            k: r.non_negative("k", Dims::TIME),
            n: r.positive("n", Dims::NONE),
            a: r.opt_positive("a", Dims::NONE, 2.0),
            density: context.density,
        })
    },
};

impl LocalLaw for BirdCarreau {
    fn viscosity(&self, at: Point) -> f64 {
        let base = 1.0 + (self.k * at.strain_rate).powf(self.a);
        let drop = base.powf((self.n - 1.0) / self.a);
        self.density * (self.nu_inf + (self.nu0 - self.nu_inf) * drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thins_with_its_exponent() {
        let law = BirdCarreau { nu0: 1.0, nu_inf: 0.0, k: 1.0, n: 0.5, a: 2.0, density: 1.0 };
        let nu = |rate| law.viscosity(Point { strain_rate: rate, pressure: 0.0, density: 1.0 });
        assert!(((nu(1e8) / nu(1e6)).log10() + 1.0).abs() < 1e-6);
    }
}
