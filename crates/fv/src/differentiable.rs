//! Values that have a gradient.

use granflow_base::{Tensor, Value, Vec3, dot, scale};

/// A value whose gradient is again a value: scalars and vectors.
pub trait Differentiable: Value {
    /// Type of the gradient: `d_i phi` or `d_i U_j`.
    type Gradient: Value;
    /// The integrand of Gauss's theorem, `S_i phi` or `S_i U_j`.
    fn dyad(area: Vec3, value: Self) -> Self::Gradient;
    /// The change along `d`: `d_i g_i` or `d_i g_ij`.
    fn along(gradient: Self::Gradient, d: Vec3) -> Self;
    /// The value less its part along the unit vector `n`, weighted by `k`: `v - k (v.n) n`.
    /// A scalar has no direction and stays.
    fn less_normal(self, k: f64, n: Vec3) -> Self;
}

impl Differentiable for f64 {
    type Gradient = Vec3;
    #[inline]
    fn dyad(area: Vec3, value: f64) -> Vec3 {
        scale(area, value)
    }
    #[inline]
    fn along(g: Vec3, d: Vec3) -> f64 {
        dot(g, d)
    }
    #[inline]
    fn less_normal(self, _: f64, _: Vec3) -> f64 {
        self
    }
}

impl Differentiable for Vec3 {
    type Gradient = Tensor;
    #[inline]
    fn dyad(a: Vec3, v: Vec3) -> Tensor {
        [
            a[0] * v[0],
            a[0] * v[1],
            a[0] * v[2],
            a[1] * v[0],
            a[1] * v[1],
            a[1] * v[2],
            a[2] * v[0],
            a[2] * v[1],
            a[2] * v[2],
        ]
    }
    #[inline]
    fn along(g: Tensor, d: Vec3) -> Vec3 {
        [
            d[0] * g[0] + d[1] * g[3] + d[2] * g[6],
            d[0] * g[1] + d[1] * g[4] + d[2] * g[7],
            d[0] * g[2] + d[1] * g[5] + d[2] * g[8],
        ]
    }
    #[inline]
    fn less_normal(self, k: f64, n: Vec3) -> Vec3 {
        self.axpy(-k * dot(self, n), n)
    }
}
