//! Blood, chocolate: the roots of the stresses add.

use super::{Entry, KINEMATIC_STRESS, LocalLaw, Point, local};
use granflow_base::Dims;

/// The square roots of yield stress and viscous stress add.
pub struct Casson {
    /// Viscosity at high rates, m2/s.
    pub m: f64,
    /// Yield stress over density, m2/s2.
    pub tau0: f64,
    /// Lower limit, m2/s.
    pub nu_min: f64,
    /// Upper limit, m2/s.
    pub nu_max: f64,
    /// Density that turns the kinematic law into a dynamic one, kg/m3.
    pub density: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "Casson",
    summary: "the square roots of yield stress and viscous stress add",
    formula: "nu = clamp((sqrt(tau0/rate) + sqrt(m))^2, nuMin, nuMax)",
    reference: "N. Casson, in Rheology of Disperse Systems (1959) 84",
    read: |r, context| {
        local(Casson {
            m: r.positive("m", Dims::KINEMATIC_VISCOSITY),
            tau0: r.non_negative("tau0", KINEMATIC_STRESS),
            nu_min: r.non_negative("nuMin", Dims::KINEMATIC_VISCOSITY),
            nu_max: r.positive("nuMax", Dims::KINEMATIC_VISCOSITY),
            density: context.density,
        })
    },
};

impl LocalLaw for Casson {
    fn viscosity(&self, at: Point) -> f64 {
        let rate = at.strain_rate.max(f64::MIN_POSITIVE);
        let root = (self.tau0 / rate).sqrt() + self.m.sqrt();
        self.density * (root * root).max(self.nu_min).min(self.nu_max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_stresses_add() {
        let law = Casson { m: 4.0, tau0: 9.0, nu_min: 0.0, nu_max: 1e9, density: 1.0 };
        let at = Point { strain_rate: 1.0, pressure: 0.0, density: 1.0 };
        assert!((law.viscosity(at) - 25.0).abs() < 1e-12);
    }
}
