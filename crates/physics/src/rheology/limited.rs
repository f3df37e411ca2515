//! A local law between two limits of the viscosity, for who wants them.

use super::{Granular, LocalLaw, Point, Rheology, local};
use granflow_base::Dims;
use granflow_dict::Reader;

/// A law whose viscosity is kept between limits.
struct Limited<L> {
    law: L,
    /// Least and greatest kinematic viscosity, m2/s.
    nu: [f64; 2],
}

/// `law` between `nuMin` and `nuMax`, where the dictionary has one of them.
pub(super) fn limited<L: LocalLaw + 'static>(r: &Reader<'_>, law: L) -> Box<dyn Rheology> {
    let nu = [
        r.opt_non_negative("nuMin", Dims::KINEMATIC_VISCOSITY, 0.0),
        r.opt_positive("nuMax", Dims::KINEMATIC_VISCOSITY, f64::INFINITY),
    ];
    if nu[0] > nu[1] {
        r.error_at_key("nuMin", "nuMin exceeds nuMax", "the lower limit", None);
    }
    if nu == [0.0, f64::INFINITY] { local(law) } else { local(Limited { law, nu }) }
}

impl<L: LocalLaw> LocalLaw for Limited<L> {
    fn viscosity(&self, at: Point) -> f64 {
        self.law.viscosity(at).max(at.density * self.nu[0]).min(at.density * self.nu[1])
    }
    fn reads_pressure(&self) -> bool {
        self.law.reads_pressure()
    }
    fn grains(&self) -> Option<Granular> {
        self.law.grains()
    }
    fn is_ill_posed(&self, at: Point) -> Option<bool> {
        // A constant viscosity is well posed.
        let free = self.law.viscosity(at) == self.viscosity(at);
        self.law.is_ill_posed(at).map(|ill| ill && free)
    }
}

#[cfg(test)]
mod tests {
    use super::super::MuI;
    use super::*;

    #[test]
    fn a_law_keeps_between_its_limits() {
        let grains = Granular {
            mu_s: 0.32,
            mu_2: 0.6,
            i0: 0.4,
            d: 1.0 / 30.0,
            rho_s: 1.0,
            floors: super::super::Floors::DEFAULT,
        };
        let law = Limited { law: MuI(grains), nu: [0.01, 100.0] };
        let at = |strain_rate, pressure| Point { strain_rate, pressure, density: 2.0 };
        assert_eq!(law.viscosity(at(1.0, 1.0)), MuI(grains).viscosity(at(1.0, 1.0)));
        assert_eq!(law.viscosity(at(1e-9, 1.0)), 200.0);
        assert_eq!(law.viscosity(at(1.0, 1e-9)), 0.02);
        assert_eq!(law.slopes(at(1.0, 1e-9)), [0.0, 0.0]);
    }
}
