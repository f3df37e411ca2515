//! A constant viscosity.

use super::{Entry, LocalLaw, Point, local};
use granflow_base::Dims;

/// Newton's law.
pub struct Newtonian {
    /// Dynamic viscosity, Pa s.
    pub eta: f64,
}

pub(super) const ENTRY: Entry = Entry {
    name: "Newtonian",
    summary: "a constant viscosity",
    formula: "eta = rho nu",
    reference: "I. Newton, Principia (1687), book II, section 9",
    read: |r, context| {
        let nu = r.non_negative("nu", Dims::KINEMATIC_VISCOSITY);
        local(Newtonian { eta: nu * context.density })
    },
};

impl LocalLaw for Newtonian {
    fn viscosity(&self, _: Point) -> f64 {
        self.eta
    }
    fn is_constant(&self) -> bool {
        true
    }
}
