//! A paraboloid through planes that know the volume behind them.
//!
//! A plane in a cell leaves the right volume behind it, so the mean height of the interface over the
//! polygon that the cell cuts out of the plane is that of the polygon's centre, but for terms of
//! fourth order. Heights of centres are not: a curve lies above its chord's middle. So the fit is
//! one of means over polygons (Z. Jibben, N. N. Carlson, M. M. Francois, Comput. Math. Appl. 78 (2019)
//! 643), which takes their second moments. Least squares; lengths are scaled by what the fit reaches.

use granflow_base::{Tensor, Value, Vec3, apply, cross, dot, sub, unit};

/// Coefficients of a paraboloid: 1, u, v, u^2, u v, v^2.
const TERMS: usize = 6;
/// What is added to the diagonal of the normal equations, as a share of their trace: the
/// coefficients of directions along which nothing is known are null.
const RIDGE: f64 = 1e-9;

/// Greatest curvature times reach that is made good for: beyond, the mesh does not resolve the surface.
const MOST_BEND: f64 = 0.5;

/// Heights over a plane to which a paraboloid is fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Origin of the frame, m.
    origin: Vec3,
    /// Its axes: two along the plane, and the one heights are measured along.
    axes: [Vec3; 3],
    /// Lengths are divided by this, m.
    size: f64,
    /// Whether nothing varies along the second axis.
    flat: bool,
    matrix: [[f64; TERMS]; TERMS],
    rhs: [f64; TERMS],
}

impl Fit {
    /// Heights along `normal` above the plane through `origin`. Nothing varies along axes that are
    /// not `solved` for: those are `v`, and take no part.
    pub(super) fn new(origin: Vec3, normal: Vec3, solved: [bool; 3], size: f64) -> Fit {
        let flat = (0..3).find(|&k| !solved[k]);
        let mut second = [0.0; 3];
        // Any axis away from the normal will do.
        let least = |a: usize, b: usize| if normal[a].abs() <= normal[b].abs() { a } else { b };
        second[flat.unwrap_or_else(|| least(least(0, 1), 2))] = 1.0;
        let first = unit(cross(second, normal));
        let second = cross(normal, first);
        Fit {
            origin,
            axes: [first, second, normal],
            size,
            flat: flat.is_some(),
            matrix: [[0.0; TERMS]; TERMS],
            rhs: [0.0; TERMS],
        }
    }

    fn row(&mut self, mut row: [f64; TERMS], value: f64, weight: f64) {
        if self.flat {
            [2, 4, 5].into_iter().for_each(|k| row[k] = 0.0);
        }
        for i in 0..TERMS {
            for j in 0..=i {
                self.matrix[i][j] += weight * row[i] * row[j];
            }
            self.rhs[i] += weight * row[i] * value;
        }
    }

    /// The mean height over a polygon around `centre` is the centre's; `spread` is the mean of `d d` over
    /// it, with d from its centre, m2. A ball of curvature `ball` (1/R, 1/m) is no paraboloid: what it
    /// falls below its own is made good.
    pub(super) fn polygon(&mut self, centre: Vec3, spread: &Tensor, ball: f64, weight: f64) {
        let [first, second, normal] = self.axes;
        let arm = sub(centre, self.origin);
        let (u, v) = (dot(first, arm) / self.size, dot(second, arm) / self.size);
        let (along, across) = (apply(spread, first), apply(spread, second));
        let k = self.size.powi(-2);
        let (uu, uv, vv) = (k * dot(first, along), k * dot(first, across), k * dot(second, across));
        let row = [1.0, u, v, u * u + uu, u * v + uv, v * v + vv];
        let bend = (self.size * ball).clamp(-MOST_BEND, MOST_BEND);
        let fall = bend.powi(3) * (row[3] + row[5]).powi(2) / 8.0;
        self.row(row, dot(normal, arm) / self.size + fall, weight);
    }

    /// The surface is normal to `normal` on the wall through `on_wall` with the outward normal
    /// `wall`, where the plane of the frame meets it.
    pub(super) fn normal_at_wall(&mut self, wall: Vec3, on_wall: Vec3, normal: Vec3, weight: f64) {
        let [first, second, up] = self.axes;
        let (a, b) = (dot(wall, first), dot(wall, second));
        let steep = a.hypot(b);
        if steep <= 0.0 {
            return;
        }
        let (a, b) = (a / steep, b / steep);
        let way = dot(wall, sub(on_wall, self.origin)) / (steep * self.size);
        let slope = -(a * dot(normal, first) + b * dot(normal, second)) / dot(normal, up);
        let (u, v) = (a * way, b * way);
        let row = [0.0, a, b, 2.0 * a * u, a * v + b * u, 2.0 * b * v];
        self.row(row, slope, weight);
    }

    /// The unit normal at the origin, and the curvature there, 1/m: positive where the side behind the
    /// surface is convex.
    pub(super) fn solve(mut self) -> (Vec3, f64) {
        let [first, second, up] = self.axes;
        let trace: f64 = (0..TERMS).map(|i| self.matrix[i][i]).sum();
        (0..TERMS).for_each(|i| self.matrix[i][i] += RIDGE * trace);
        let Some(c) = cholesky(&mut self.matrix, self.rhs) else { return (up, 0.0) };
        let (hu, hv, huu, huv, hvv) = (c[1], c[2], 2.0 * c[3], c[4], 2.0 * c[5]);
        let bend = (1.0 + hv * hv) * huu - 2.0 * hu * hv * huv + (1.0 + hu * hu) * hvv;
        let curvature = -bend / (1.0 + hu * hu + hv * hv).powf(1.5) / self.size;
        (unit(up.axpy(-hu, first).axpy(-hv, second)), curvature)
    }
}

/// Solves with the lower half of a positive definite matrix, which it overwrites.
fn cholesky(m: &mut [[f64; TERMS]; TERMS], mut x: [f64; TERMS]) -> Option<[f64; TERMS]> {
    for i in 0..TERMS {
        for j in 0..i {
            let s: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
            m[i][j] = (m[i][j] - s) / m[j][j];
        }
        let s: f64 = (0..i).map(|k| m[i][k] * m[i][k]).sum();
        let pivot = m[i][i] - s;
        if pivot <= 0.0 || !pivot.is_finite() {
            return None;
        }
        m[i][i] = pivot.sqrt();
    }
    for i in 0..TERMS {
        let s: f64 = (0..i).map(|k| m[i][k] * x[k]).sum();
        x[i] = (x[i] - s) / m[i][i];
    }
    for i in (0..TERMS).rev() {
        let s: f64 = (i + 1..TERMS).map(|k| m[k][i] * x[k]).sum();
        x[i] = (x[i] - s) / m[i][i];
    }
    Some(x)
}
