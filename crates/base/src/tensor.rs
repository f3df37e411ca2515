//! Vectors and second-order tensors of three-dimensional space, as plain arrays.
//!
//! A tensor is stored by rows, `t[3 * i + j]`. The gradient of a vector field follows the
//! convention of OpenFOAM's users: `(grad U)_ij = d U_j / d x_i`, so that a face area `S` gives
//! the surface integral `S_i U_j`.

/// A vector in Cartesian components, SI units.
pub type Vec3 = [f64; 3];
/// A second-order tensor by rows.
pub type Tensor = [f64; 9];

/// The unit tensor.
pub const IDENTITY: Tensor = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// Scalar product.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
/// Vector product.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
/// Sum.
#[inline]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
/// Difference `a - b`.
#[inline]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
/// Product with a number.
#[inline]
pub fn scale(a: Vec3, k: f64) -> Vec3 {
    [k * a[0], k * a[1], k * a[2]]
}
/// Euclidean length.
#[inline]
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}
/// The vector of length one along `a`; the null vector stays null.
#[inline]
pub fn unit(a: Vec3) -> Vec3 {
    let n = norm(a);
    if n > 0.0 { scale(a, 1.0 / n) } else { a }
}
/// `t . v`, components `t_ij v_j`.
#[inline]
pub fn apply(t: &Tensor, v: Vec3) -> Vec3 {
    [
        t[0] * v[0] + t[1] * v[1] + t[2] * v[2],
        t[3] * v[0] + t[4] * v[1] + t[5] * v[2],
        t[6] * v[0] + t[7] * v[1] + t[8] * v[2],
    ]
}
/// Transpose.
#[inline]
pub fn transpose(t: &Tensor) -> Tensor {
    [t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]]
}
/// Trace.
#[inline]
pub fn trace(t: &Tensor) -> f64 {
    t[0] + t[4] + t[8]
}
/// Symmetric part `(t + t^T)/2`.
#[inline]
pub fn symm(t: &Tensor) -> Tensor {
    let (xy, xz, yz) = (0.5 * (t[1] + t[3]), 0.5 * (t[2] + t[6]), 0.5 * (t[5] + t[7]));
    [t[0], xy, xz, xy, t[4], yz, xz, yz, t[8]]
}
/// Double contraction `a_ij b_ij`.
#[inline]
pub fn double_dot(a: &Tensor, b: &Tensor) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
/// `D_ij D_ij` of the symmetric part `D` of `t`.
#[inline]
pub fn double_dot_sym(t: &Tensor) -> f64 {
    let d = symm(t);
    double_dot(&d, &d)
}
/// `R t R^T`: the tensor `t` seen in a frame turned by `r`.
#[inline]
pub fn rotate_tensor(r: &Tensor, t: &Tensor) -> Tensor {
    let mut rt = [0.0; 9];
    let mut out = [0.0; 9];
    for i in 0..3 {
        for j in 0..3 {
            rt[3 * i + j] = (0..3).map(|k| r[3 * i + k] * t[3 * k + j]).sum();
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            out[3 * i + j] = (0..3).map(|k| rt[3 * i + k] * r[3 * j + k]).sum();
        }
    }
    out
}
/// Inverse of a symmetric tensor by cofactors; the null tensor when it has none.
pub fn inverse_symmetric(m: &Tensor) -> Tensor {
    let c = [
        m[4] * m[8] - m[5] * m[5],
        m[2] * m[5] - m[1] * m[8],
        m[1] * m[5] - m[2] * m[4],
        m[0] * m[8] - m[2] * m[2],
        m[1] * m[2] - m[0] * m[5],
        m[0] * m[4] - m[1] * m[1],
    ];
    let det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
    let k = if det.abs() > f64::MIN_POSITIVE { 1.0 / det } else { 0.0 };
    [c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]].map(|x| k * x)
}
/// Rotation by `angle` (radians, right-handed) about the unit vector `axis` (Rodrigues).
pub fn rotation_about(axis: Vec3, angle: f64) -> Tensor {
    let (s, c) = angle.sin_cos();
    let [x, y, z] = axis;
    let k = 1.0 - c;
    [
        c + k * x * x,
        k * x * y - s * z,
        k * x * z + s * y,
        k * x * y + s * z,
        c + k * y * y,
        k * y * z - s * x,
        k * x * z - s * y,
        k * y * z + s * x,
        c + k * z * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let r = rotation_about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        let y = apply(&r, [1.0, 0.0, 0.0]);
        assert!(norm(sub(y, [0.0, 1.0, 0.0])) < 1e-15);
    }

    #[test]
    fn rotating_a_dyad_rotates_its_vectors() {
        let r = rotation_about(unit([1.0, 2.0, -1.0]), 0.7);
        let (a, b) = ([1.0, -2.0, 0.5], [0.3, 0.1, 2.0]);
        let dyad = |a: Vec3, b: Vec3| {
            let mut t = [0.0; 9];
            (0..9).for_each(|k| t[k] = a[k / 3] * b[k % 3]);
            t
        };
        let (left, right) = (rotate_tensor(&r, &dyad(a, b)), dyad(apply(&r, a), apply(&r, b)));
        assert!(left.iter().zip(&right).all(|(x, y)| (x - y).abs() < 1e-14));
    }
}
