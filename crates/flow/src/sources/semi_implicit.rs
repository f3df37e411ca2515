//! A given force per volume, perhaps less a drag (`vectorSemiImplicitSource`).

use super::{Seen, Zone};
use granflow_base::{Value, Vec3};

/// `force - drag U` in some cells, for some time.
#[derive(Clone, Debug)]
pub struct SemiImplicit {
    /// Where.
    pub zone: Zone,
    /// Force per volume, N/m3.
    pub force: Vec3,
    /// Drag per volume and velocity, kg/(m3 s).
    pub drag: f64,
    /// First and last time, s.
    pub window: [f64; 2],
}

impl SemiImplicit {
    pub(super) fn add(&self, seen: &Seen<'_>, n: usize, body: &mut [Vec3], sink: &mut [f64]) {
        if !(self.window[0]..=self.window[1]).contains(&seen.time) {
            return;
        }
        self.zone.each(n, |c| {
            body[c] = body[c].plus(self.force);
            sink[c] += self.drag;
        });
    }
}
