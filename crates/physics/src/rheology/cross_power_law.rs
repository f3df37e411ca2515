//! From one plateau of viscosity to another.

use super::{Entry, LocalLaw, Point, local};
use granflow_base::Dims;

/// Shear thinning between two plateaus.
pub struct CrossPowerLaw {
    /// Viscosity at rest, m2/s.
    pub nu0: f64,
    /// Viscosity at high rates, m2/s.
    pub nu_inf: f64,
    /// Time constant, s.
    pub m: f64,
    /// Exponent.
    pub n: f64,
    /// Density that turns the kinematic law into a dynamic one, kg/m3.
    pub density: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "CrossPowerLaw",
    summary: "shear thinning between two plateaus",
    formula: "nu = nuInf + (nu0 - nuInf)/(1 + (m rate)^n)",
    reference: "M. M. Cross, J. Colloid Sci. 20 (1965) 417",
    read: |r, context| {
        local(CrossPowerLaw {
            nu0: r.positive("nu0", Dims::KINEMATIC_VISCOSITY),
            nu_inf: r.non_negative("nuInf", Dims::KINEMATIC_VISCOSITY),
            m: r.non_negative("m", Dims::TIME),
            n: r.positive("n", Dims::NONE),
            density: context.density,
        })
    },
};

impl LocalLaw for CrossPowerLaw {
    fn viscosity(&self, at: Point) -> f64 {
        let drop = 1.0 + (self.m * at.strain_rate).powf(self.n);
        self.density * (self.nu_inf + (self.nu0 - self.nu_inf) / drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_way_where_m_rate_is_one() {
        let law = CrossPowerLaw { nu0: 3.0, nu_inf: 1.0, m: 0.5, n: 0.7, density: 1.0 };
        let at = Point { strain_rate: 2.0, pressure: 0.0, density: 1.0 };
        assert!((law.viscosity(at) - 2.0).abs() < 1e-12);
        assert!((law.viscosity(Point { strain_rate: 0.0, ..at }) - 3.0).abs() < 1e-12);
    }
}
