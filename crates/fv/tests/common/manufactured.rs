//! A scalar and a vector with everything that operators make of them.

use granflow_base::Vec3;

/// The manufactured scalar, its gradient and its Laplacian.
pub fn f([x, y, z]: Vec3) -> f64 {
    (2.0 * x + 0.3).sin() * (1.5 * y).cos() * (0.7 * z).exp()
}
pub fn grad_f([x, y, z]: Vec3) -> Vec3 {
    let (a, b, c) = (2.0 * x + 0.3, 1.5 * y, (0.7 * z).exp());
    [2.0 * a.cos() * b.cos() * c, -1.5 * a.sin() * b.sin() * c, 0.7 * a.sin() * b.cos() * c]
}
pub fn lap_f(p: Vec3) -> f64 {
    (-4.0 - 2.25 + 0.49) * f(p)
}
/// A manufactured vector and its divergence.
pub fn v(p: Vec3) -> Vec3 {
    [f(p), f([p[1], p[2], p[0]]), p[0] * p[2] - p[1] * p[1]]
}
pub fn div_v(p: Vec3) -> f64 {
    grad_f(p)[0] + grad_f([p[1], p[2], p[0]])[0] + p[0]
}
