//! How fast things fall through a cell: the measure of motion where grains may stand still altogether.

use crate::Flow;
use granflow_base::norm;

/// Free fall where grains lie beside another fluid; none elsewhere, where flows have scales of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeFall {
    /// Gravity, m/s2; 0 where nothing is to be measured by it.
    pub g: f64,
}

impl FreeFall {
    /// Speed after a fall through `size`, m/s.
    #[inline]
    pub(crate) fn speed(self, size: f64) -> f64 {
        (self.g * size).sqrt()
    }

    /// That speed over `size`, 1/s.
    #[inline]
    pub(crate) fn rate(self, size: f64) -> f64 {
        (self.g / size).sqrt()
    }
}

impl Flow {
    pub(crate) fn free_fall(&self) -> FreeFall {
        FreeFall { g: self.grains().map_or(0.0, |_| norm(self.gravity.hydrostatic)) }
    }
}
