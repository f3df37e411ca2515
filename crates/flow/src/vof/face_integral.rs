//! The fluid that crosses a face while a plane sweeps over it.
//!
//! With the interface `n . (x - x0) = U0 t` the area of the face behind it is, between the times
//! at which it passes corners, a quadratic of time (Roenby, Bredmose & Jasak, R. Soc. Open Sci. 3
//! (2016) 160405, section 3.2). Gauss's two points integrate each stretch exactly and never fall
//! on a corner, where the area may jump.

use super::body::{Fan, clip};
use super::corners::Corners;
use granflow_base::{Vec3, dot, norm, sub};

/// Work space of one thread.
#[derive(Default)]
pub(super) struct FaceWork {
    points: Vec<Vec3>,
    ring: Vec<u32>,
    levels: Vec<f64>,
    sorted: Vec<f64>,
}

/// A plane on the move: `normal . (x - point) = speed t`, fluid 1 behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Front {
    pub(super) normal: Vec3,
    pub(super) point: Vec3,
    /// Speed along the normal, m/s.
    pub(super) speed: f64,
}

impl FaceWork {
    pub(super) fn reserve(&mut self, most: usize) {
        self.points.reserve(most.saturating_sub(self.points.len()));
        self.ring.reserve(most.saturating_sub(self.ring.len()));
        self.levels.reserve(most.saturating_sub(self.levels.len()));
        self.sorted.reserve((most + 2).saturating_sub(self.sorted.len()));
    }

    /// Average over the times `0..dt` of the share of face `f` that lies behind the front.
    pub(super) fn mean_share(
        &mut self,
        corners: &Corners,
        f: usize,
        front: &Front,
        dt: f64,
    ) -> f64 {
        let reach = front.speed * dt;
        let (mut behind, mut whole) = (0.0, 0.0);
        for k in corners.facets_of(f) {
            self.points.clear();
            self.points.extend(corners.facet(k).iter().map(|&p| corners.points[p as usize]));
            let area = self.area();
            whole += area;
            behind += area * self.facet_share(area, front, reach);
        }
        if whole > 0.0 { behind / whole } else { 0.0 }
    }

    fn area(&self) -> f64 {
        let mut fan = Fan::default();
        self.points.iter().for_each(|&p| fan.push(p));
        0.5 * norm(fan.twice)
    }

    fn facet_share(&mut self, area: f64, front: &Front, reach: f64) -> f64 {
        let FaceWork { points, ring, levels, sorted } = self;
        levels.clear();
        levels.extend(points.iter().map(|&p| dot(front.normal, sub(p, front.point))));
        let (from, to) = (reach.min(0.0), reach.max(0.0));
        let lowest = levels.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if highest <= from {
            return 1.0;
        }
        if lowest >= to {
            return 0.0;
        }
        ring.clear();
        ring.extend(0..points.len() as u32);
        let behind = |level: f64| {
            let mut fan = Fan::default();
            clip(ring, points, levels, level, |p| fan.push(p), |_, _| {});
            (0.5 * norm(fan.twice) / area).min(1.0)
        };
        if to - from <= 1e-13 * (highest - lowest) {
            return behind(0.5 * (from + to));
        }
        sorted.clear();
        sorted.extend(levels.iter().copied().filter(|&l| l > from && l < to));
        sorted.push(to);
        sorted.sort_unstable_by(f64::total_cmp);
        let (mut sum, mut a) = (0.0, from);
        for &b in sorted.iter() {
            let (mid, half) = (0.5 * (a + b), 0.5 * (b - a));
            if half > 0.0 {
                let off = half / 3f64.sqrt();
                sum += half * (behind(mid - off) + behind(mid + off));
            }
            a = b;
        }
        sum / (to - from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_base::unit;
    use granflow_mesh::{Mesh, shapes};

    #[test]
    fn the_integral_is_what_many_small_steps_add_up_to() {
        let poly = shapes::displaced(&shapes::unit_box([3, 3, 3]), 0.2, 3);
        let mesh = Mesh::new(&poly).expect("a sound mesh");
        let corners = Corners::new(&poly, &mesh);
        let mut w = FaceWork::default();
        for (i, normal) in [[1.0, 0.4, 0.2], [0.0, 0.0, 1.0], [-0.3, 0.5, -0.9]].iter().enumerate()
        {
            for speed in [0.5, -0.7] {
                let front = Front { normal: unit(*normal), point: [0.45, 0.52, 0.48], speed };
                for f in 0..mesh.n_faces() {
                    let whole = w.mean_share(&corners, f, &front, 0.6);
                    let (n, mut sum) = (2000, 0.0);
                    for k in 0..n {
                        let t = 0.6 * (f64::from(k) + 0.5) / f64::from(n);
                        let at = std::array::from_fn(|d| {
                            front.point[d] + front.normal[d] * front.speed * t
                        });
                        sum += w.mean_share(
                            &corners,
                            f,
                            &Front { point: at, speed: 0.0, ..front },
                            1e-300,
                        );
                    }
                    let error = (whole - sum / f64::from(n)).abs();
                    assert!(error < 1e-3, "normal {i}, face {f}: {error}");
                }
            }
        }
    }
}
