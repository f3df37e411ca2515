//! A yield stress, then a power law.

use super::{Entry, KINEMATIC_STRESS, LocalLaw, Point, local};
use granflow_base::Dims;

/// Rigid below a yield stress, then a power law.
pub struct HerschelBulkley {
    /// Yield stress over density, m2/s2.
    pub tau0: f64,
    /// Consistency, m2/s (with the strain rate in 1/s).
    pub k: f64,
    /// Exponent.
    pub n: f64,
    /// Viscosity of the unyielded material, m2/s: large, the result must not depend on it.
    pub nu0: f64,
    /// Density that turns the kinematic law into a dynamic one, kg/m3.
    pub density: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "HerschelBulkley",
    summary: "rigid below a yield stress, then a power law",
    formula: "nu = min(nu0, (tau0 + k rate^n)/rate)",
    reference: "W. H. Herschel, R. Bulkley, Kolloid-Z. 39 (1926) 291",
    read: |r, context| {
        local(HerschelBulkley {
            tau0: r.non_negative("tau0", KINEMATIC_STRESS),
            k: r.positive("k", Dims::KINEMATIC_VISCOSITY),
            n: r.positive("n", Dims::NONE),
            nu0: r.positive("nu0", Dims::KINEMATIC_VISCOSITY),
            density: context.density,
        })
    },
};

impl LocalLaw for HerschelBulkley {
    fn viscosity(&self, at: Point) -> f64 {
        let rate = at.strain_rate.max(f64::MIN_POSITIVE);
        self.density * ((self.tau0 + self.k * rate.powf(self.n)) / rate).min(self.nu0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_is_yield_plus_power() {
        let law = HerschelBulkley { tau0: 3.0, k: 2.0, n: 0.5, nu0: 1e9, density: 10.0 };
        let at = Point { strain_rate: 4.0, pressure: 0.0, density: 10.0 };
        assert!((law.viscosity(at) * 4.0 - 10.0 * (3.0 + 2.0 * 2.0)).abs() < 1e-12);
    }
}
