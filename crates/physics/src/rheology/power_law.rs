//! Shear-thinning and shear-thickening fluids without a yield stress.

use super::{Entry, LocalLaw, Point, local};
use granflow_base::Dims;

/// Ostwald and de Waele's law between two limits.
pub struct PowerLaw {
    /// Consistency, m2/s (with the strain rate in 1/s).
    pub k: f64,
    /// Exponent.
    pub n: f64,
    /// Lower and upper limit of the kinematic viscosity, m2/s.
    pub nu: [f64; 2],
}

pub(super) const ENTRY: Entry = Entry {
    name: "powerLaw",
    summary: "shear thinning (n < 1) or thickening (n > 1) between two limits",
    formula: "nu = clamp(k rate^(n-1), nuMin, nuMax)",
    reference: "W. Ostwald, Kolloid-Z. 36 (1925) 99",
    read: |r, context| {
        let law = PowerLaw {
            k: r.positive("k", Dims::KINEMATIC_VISCOSITY),
            n: r.positive("n", Dims::NONE),
            nu: [
                r.non_negative("nuMin", Dims::KINEMATIC_VISCOSITY),
                r.positive("nuMax", Dims::KINEMATIC_VISCOSITY),
            ],
        };
        if law.nu[0] > law.nu[1] {
            r.error_at_key("nuMin", "nuMin exceeds nuMax", "the lower limit", None);
        }
        local(Scaled(law, context.density))
    },
};

impl PowerLaw {
    /// Kinematic viscosity, m2/s.
    pub fn nu(&self, rate: f64) -> f64 {
        let nu = self.k * rate.max(f64::MIN_POSITIVE).powf(self.n - 1.0);
        nu.max(self.nu[0]).min(self.nu[1])
    }
}

struct Scaled(PowerLaw, f64);
impl LocalLaw for Scaled {
    fn viscosity(&self, at: Point) -> f64 {
        self.1 * self.0.nu(at.strain_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_power_between_its_limits() {
        let law = PowerLaw { k: 2.0, n: 0.5, nu: [0.1, 10.0] };
        assert!((law.nu(4.0) - 1.0).abs() < 1e-15);
        assert_eq!((law.nu(0.0), law.nu(1e12)), (10.0, 0.1));
    }
}
