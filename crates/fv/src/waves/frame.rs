//! The patch that waves come through: its directions, its extent and the water before it.

use granflow_base::{Vec3, add, dot, norm, scale, sub, unit};

/// Directions, extent and still water of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Horizontal, into the domain.
    pub x: Vec3,
    /// Horizontal, along the patch.
    pub y: Vec3,
    /// Against gravity.
    pub up: Vec3,
    /// Where the patch stands along `x`, m.
    pub stands: f64,
    /// Extent along `y`, m.
    pub side: [f64; 2],
    /// Lowest and highest point along `up`, m.
    pub height: [f64; 2],
    /// Gravity, m/s2.
    pub gravity: f64,
    /// Depth of still water over the lowest point, m.
    pub depth: f64,
}

impl Frame {
    /// The frame of a patch of the outward area vector `area` around `centre` with the corners
    /// `points`; no water yet. `None` without gravity or where the patch does not stand upright.
    pub fn new(
        gravity: Vec3,
        area: Vec3,
        centre: Vec3,
        points: impl Iterator<Item = Vec3>,
    ) -> Option<Frame> {
        let g = norm(gravity);
        let up = scale(unit(gravity), -1.0);
        let inward = scale(unit(area), -1.0);
        let level = sub(inward, scale(up, dot(inward, up)));
        if g == 0.0 || norm(level) < 0.1 {
            return None;
        }
        let x = unit(level);
        let y =
            [up[1] * x[2] - up[2] * x[1], up[2] * x[0] - up[0] * x[2], up[0] * x[1] - up[1] * x[0]];
        let (mut side, mut height) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
        for p in points {
            for (range, v) in [(&mut side, dot(y, p)), (&mut height, dot(up, p))] {
                *range = [range[0].min(v), range[1].max(v)];
            }
        }
        Some(Frame { x, y, up, stands: dot(x, centre), side, height, gravity: g, depth: 0.0 })
    }

    /// A vector of this frame as the mesh has it.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        add(add(scale(self.x, v[0]), scale(self.y, v[1])), scale(self.up, v[2]))
    }

    /// Depth of water that fills the share `wet` of the patch, m.
    pub fn level(&self, wet: f64) -> f64 {
        wet * (self.height[1] - self.height[0])
    }

    /// Lowest and highest of `points` over the patch's lowest point, m.
    pub fn span(&self, points: impl Iterator<Item = Vec3>) -> [f64; 2] {
        let range = points.map(|p| dot(self.up, p) - self.height[0]);
        range.fold([f64::MAX, f64::MIN], |[low, high], z| [low.min(z), high.max(z)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_that_faces_back_sees_its_waves_come_towards_it() {
        let corners = [[20.0, 1.0, 2.0], [20.0, 3.0, 2.0], [20.0, 3.0, 5.0], [20.0, 1.0, 5.0]];
        let g = [0.0, 0.0, -9.81];
        let f = Frame::new(g, [6.0, 0.0, 0.0], [20.0, 2.0, 3.5], corners.into_iter()).unwrap();
        assert_eq!((f.x, f.y, f.up), ([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]));
        assert_eq!((f.side, f.height, f.stands), ([-3.0, -1.0], [2.0, 5.0], -20.0));
        assert_eq!(f.span(corners.into_iter()), [0.0, 3.0]);
        assert!((f.level(0.5) - 1.5).abs() < 1e-15);
        // One that lies lets no wave in.
        assert!(Frame::new(g, [0.0, 0.1, -6.0], [0.0; 3], corners.into_iter()).is_none());
    }
}
