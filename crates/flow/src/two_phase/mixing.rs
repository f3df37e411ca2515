//! How the viscosities of two fluids that share a cell or a face make one.

/// The rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mixing {
    /// `1/(alpha/eta_1 + (1 - alpha)/eta_2)`, paper eq. 11: both bear the same stress. A cell with one
    /// per cent of air in it has a hundred times the air's viscosity, whichever way it is sheared.
    Harmonic,
    /// `alpha eta_1 + (1 - alpha) eta_2`: both are sheared at the same rate.
    #[default]
    Arithmetic,
    /// Each where it belongs (A. V. Coward, Y. Y. Renardy, M. Renardy, J. R. Richards, J. Comput. Phys. 132
    /// (1997) 346): harmonic through faces that look across the interface, with the part of the way between
    /// the cells that lies in fluid 1; arithmetic through faces that look along it.
    FaceDirection,
}

impl Mixing {
    /// Every rule by its name in `transportProperties`.
    pub const ALL: &'static [(&'static str, Mixing)] = &[
        ("harmonic", Mixing::Harmonic),
        ("arithmetic", Mixing::Arithmetic),
        ("faceDirection", Mixing::FaceDirection),
    ];

    /// Viscosity of a cell with the share `a` of fluid 1, Pa s.
    #[inline]
    pub(crate) fn in_cell(self, a: f64, eta_1: f64, eta_2: f64) -> f64 {
        match self {
            Mixing::Harmonic => series(a, eta_1, eta_2),
            Mixing::Arithmetic | Mixing::FaceDirection => parallel(a, eta_1, eta_2),
        }
    }
}

/// Same stress in both.
#[inline]
pub(crate) fn series(a: f64, eta_1: f64, eta_2: f64) -> f64 {
    if a <= 0.0 {
        eta_2
    } else if a >= 1.0 {
        eta_1
    } else {
        eta_1 * eta_2 / (a * eta_2 + (1.0 - a) * eta_1)
    }
}

/// Same strain rate in both.
#[inline]
pub(crate) fn parallel(a: f64, eta_1: f64, eta_2: f64) -> f64 {
    if a <= 0.0 {
        eta_2
    } else if a >= 1.0 {
        eta_1
    } else {
        a * eta_1 + (1.0 - a) * eta_2
    }
}

/// On a face with the share `a` of fluid 1, were it to look across the interface and along it. Across, fluid 1
/// takes up the part of the way between the cells that lies in it.
#[inline]
pub(crate) fn by_direction(a: f64, eta_1: f64, eta_2: f64) -> [f64; 2] {
    let way = (2.0 * a - 0.5).clamp(0.0, 1.0);
    [series(way, eta_1, eta_2), parallel(a, eta_1, eta_2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pure_cells_have_their_own_viscosity_and_mixed_ones_what_the_rule_says() {
        for (_, rule) in Mixing::ALL {
            assert_eq!(rule.in_cell(1.0, 3.0, 2.0), 3.0);
            assert_eq!(rule.in_cell(0.0, 0.0, 2.0), 2.0);
        }
        // model.md: one per cent of air, a hundred times the air's viscosity.
        let eta = Mixing::Harmonic.in_cell(0.99, 1e6, 1e-3);
        assert!((eta / 0.1 - 1.0).abs() < 1e-6, "{eta}");
        let eta = Mixing::Arithmetic.in_cell(0.99, 1e6, 1e-3);
        assert!((eta / 0.99e6 - 1.0).abs() < 1e-9, "{eta}");
    }
}
