//! A yield stress, then a constant slope.

use super::{Entry, KINEMATIC_STRESS, LocalLaw, Point, local};
use granflow_base::Dims;

/// Rigid below a yield stress, then linear.
pub struct Bingham {
    /// Yield stress over density, m2/s2.
    pub tau0: f64,
    /// Plastic viscosity, m2/s.
    pub nu: f64,
    /// Viscosity of the unyielded material, m2/s: large, the result must not depend on it.
    pub nu0: f64,
    /// Density that turns the kinematic law into a dynamic one, kg/m3.
    pub density: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "Bingham",
    summary: "rigid below a yield stress, then linear",
    formula: "nu = min(nu0, tau0/rate + nu)",
    reference: "E. C. Bingham, Fluidity and Plasticity (1922)",
    read: |r, context| {
        local(Bingham {
            tau0: r.non_negative("tau0", KINEMATIC_STRESS),
            nu: r.positive("nu", Dims::KINEMATIC_VISCOSITY),
            nu0: r.positive("nu0", Dims::KINEMATIC_VISCOSITY),
            density: context.density,
        })
    },
};

impl LocalLaw for Bingham {
    fn viscosity(&self, at: Point) -> f64 {
        let rate = at.strain_rate.max(f64::MIN_POSITIVE);
        self.density * (self.tau0 / rate + self.nu).min(self.nu0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_is_yield_plus_slope() {
        let law = Bingham { tau0: 3.0, nu: 2.0, nu0: 1e9, density: 10.0 };
        let at = Point { strain_rate: 0.5, pressure: 0.0, density: 10.0 };
        assert!((law.viscosity(at) * 0.5 - 10.0 * (3.0 + 2.0 * 0.5)).abs() < 1e-12);
        assert_eq!(law.viscosity(Point { strain_rate: 0.0, ..at }), 1e10);
    }
}
