//! What all solitary waves have in common: height, direction and where they start.

use super::progressive::{direction, height, turned};
use super::{Context, Place};
use granflow_base::Vec3;
use granflow_dict::Reader;

/// Height over depth of the highest solitary wave (J. K. Hunter, J.-M. Vanden-Broeck, J. Fluid Mech. 136
/// (1983) 63).
const HIGHEST: f64 = 0.833;

/// A crest alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crest {
    /// Over still water, m.
    pub(super) height: f64,
    /// Depth of still water, m.
    pub(super) depth: f64,
    /// Gravity, m/s2.
    pub(super) gravity: f64,
    /// Cosine and sine of the direction against x.
    direction: [f64; 2],
}

impl Crest {
    /// Reads `waveHeight` and `waveAngle`.
    pub(super) fn read(r: &Reader<'_>, context: Context) -> Crest {
        let Context { depth, gravity } = context;
        // Given beside solitary waves, which have none.
        r.ignore("wavePeriod");
        let crest = Crest { height: height(r, depth), depth, gravity, direction: direction(r) };
        if crest.epsilon() > HIGHEST && crest.epsilon() < 1.0 {
            let label = format!("{:.4} of the depth", crest.epsilon());
            let help = format!("solitary waves break at {HIGHEST} of the depth");
            r.error_at_key("waveHeight", "the wave would break", label, Some(&help));
        }
        crest
    }
    #[cfg(test)]
    pub(super) fn new(height: f64, context: Context) -> Crest {
        let Context { depth, gravity } = context;
        Crest { height, depth, gravity, direction: [1.0, 0.0] }
    }
    /// Height over depth.
    pub(super) fn epsilon(&self) -> f64 {
        self.height / self.depth
    }
    /// How far `at` is ahead of the crest, m, which begins `3.5 h / sqrt(H/h)` before the patch:
    /// its surface is then 0.5 % of its height above still water.
    pub(super) fn ahead(&self, celerity: f64, at: Place) -> f64 {
        let [c, s] = self.direction;
        let start = 3.5 * self.depth / self.epsilon().sqrt();
        c * at.inside + s * at.y - celerity * at.time + start
    }
    /// `along` in the direction of the wave and `up`.
    pub(super) fn turned(&self, along: f64, up: f64) -> Vec3 {
        turned(self.direction, along, up)
    }
}
