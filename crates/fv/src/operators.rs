//! Explicit operators. Face loops write faces, cell loops write cells; nothing else is written.

use crate::{Differentiable, FaceField, Unknown};
use granflow_base::{Tensor, Value, Vec3, dot, scale};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Linear interpolation of cell values (ghosts included) to inner faces; boundary faces take the
/// value of their cell.
pub fn to_faces<T: Value>(exec: &Exec, mesh: &Mesh, x: &[T], out: &mut FaceField<T>) {
    exec.for_each(&mut out.data, |first, out| {
        for (i, v) in out.iter_mut().enumerate() {
            let f = first + i;
            let o = x[mesh.owner[f] as usize];
            *v = match mesh.neighbour.get(f) {
                Some(&n) => o.scaled(mesh.weight[f]).axpy(1.0 - mesh.weight[f], x[n as usize]),
                None => o,
            };
        }
    });
}

/// `S . u_f` of a cell vector field (ghosts included) on inner faces; boundary faces take the
/// velocity condition of `u`.
pub fn flux(exec: &Exec, mesh: &Mesh, u: &Unknown<Vec3>, cells: &[Vec3], out: &mut FaceField<f64>) {
    exec.for_each(&mut out.data, |first, out| {
        for (i, v) in out.iter_mut().enumerate() {
            let f = first + i;
            *v = match mesh.neighbour.get(f) {
                Some(&n) => {
                    let (o, w) = (cells[mesh.owner[f] as usize], mesh.weight[f]);
                    dot(o.scaled(w).axpy(1.0 - w, cells[n as usize]), mesh.area[f])
                }
                None => dot(u.boundary_value(mesh, f), mesh.area[f]),
            };
        }
    });
}

/// Adds to a flux `k` times what the interpolated velocity lacks on inner faces whose centre is
/// not on the line between the cells: `S . (skew . grad U)_f`, the gradient in cells and ghosts.
///
/// Without it the divergence is wrong by the gradient times the skewness over the cell size, which
/// does not fade as cells shrink, and the pressure answers for it.
pub fn add_skew_flux(
    exec: &Exec,
    mesh: &Mesh,
    k: f64,
    gradient: &[Tensor],
    out: &mut FaceField<f64>,
) {
    exec.for_each(&mut out.data[..mesh.n_inner], |first, out| {
        for (i, v) in out.iter_mut().enumerate() {
            let f = first + i;
            *v += k * dot(skew_part::<Vec3>(mesh, gradient, f), mesh.area[f]);
        }
    });
}

/// What linear interpolation lacks on inner face `f`: it hits the point where the line of centres
/// pierces the face, `mesh.skew` before the face's centre.
#[inline]
pub fn skew_part<T: Differentiable>(mesh: &Mesh, gradient: &[T::Gradient], f: usize) -> T {
    let (o, n, w) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize, mesh.weight[f]);
    T::along(gradient[o].scaled(w).axpy(1.0 - w, gradient[n]), mesh.skew[f])
}

/// `sum_f F / V` of a flux, into the cells.
pub fn divergence(exec: &Exec, mesh: &Mesh, flux: &FaceField<f64>, out: &mut [f64]) {
    exec.for_each(&mut out[..mesh.n_cells], |first, out| {
        for (i, d) in out.iter_mut().enumerate() {
            let c = first + i;
            *d = mesh.faces_of(c).map(|(f, s)| s * flux.data[f]).sum::<f64>() / mesh.volume[c];
        }
    });
}

/// The normal derivative on face `f`: compact along the line of centres, plus the correction for
/// non-orthogonality from the cell gradients when they are given.
#[inline]
pub fn normal_derivative<T: Differentiable>(
    mesh: &Mesh,
    phi: &Unknown<T>,
    gradient: Option<&[T::Gradient]>,
    f: usize,
) -> T {
    let o = mesh.owner[f] as usize;
    let here = phi.cells.data[o];
    let Some(&n) = mesh.neighbour.get(f) else {
        let compact = phi.boundary_value(mesh, f).minus(here).scaled(mesh.inv_dist[f]);
        // Where the value is given, the line to the face's centre may lean; a given gradient is
        // the normal one as it is.
        let fixed = 1.0 - phi.closure.slope[f - mesh.n_inner];
        return match gradient {
            None => compact,
            Some(g) => compact.axpy(fixed, T::along(g[o], mesh.nonorth[f])),
        };
    };
    let n = n as usize;
    let compact = phi.cells.data[n].minus(here).scaled(mesh.inv_dist[f]);
    match gradient {
        None => compact,
        Some(g) => {
            let w = mesh.weight[f];
            let at_face = g[o].scaled(w).axpy(1.0 - w, g[n]);
            compact.plus(T::along(at_face, mesh.nonorth[f]))
        }
    }
}

/// The part of `gamma |S| dphi/dn` that the compact difference leaves out on non-orthogonal
/// faces, limited so that it never exceeds `limit/(1 - limit)` times the compact part
/// (`limit` 1: `corrected`; 0.5: `limited 0.5`; 0: none).
pub fn non_orthogonal_flux<T: Differentiable>(
    exec: &Exec,
    mesh: &Mesh,
    phi: &Unknown<T>,
    gradient: &[T::Gradient],
    gamma: &FaceField<f64>,
    limit: f64,
    out: &mut FaceField<T>,
) {
    exec.for_each(&mut out.data, |first, out| {
        for (i, q) in out.iter_mut().enumerate() {
            let f = first + i;
            let o = mesh.owner[f] as usize;
            let mut part = match mesh.neighbour.get(f) {
                Some(&n) => {
                    let w = mesh.weight[f];
                    let at_face = gradient[o].scaled(w).axpy(1.0 - w, gradient[n as usize]);
                    T::along(at_face, mesh.nonorth[f])
                }
                None => T::along(gradient[o], mesh.nonorth[f])
                    .scaled(1.0 - phi.closure.slope[f - mesh.n_inner]),
            };
            if limit < 1.0 {
                let compact = normal_derivative(mesh, phi, None, f);
                let (size, most) = (part.inner(part).sqrt(), compact.inner(compact).sqrt());
                let cap = limit * most / ((1.0 - limit) * size).max(f64::MIN_POSITIVE);
                part = part.scaled(cap.min(1.0));
            }
            *q = part.scaled(gamma.data[f] * mesh.mag_area[f]);
        }
    });
}

/// The transpose part of the viscous force on faces, `eta S . (grad U)^T`, in conservative form
/// (paper eq. 8 writes `(grad U) . grad eta`, which holds only where div U = 0 discretely). The
/// face gradient has the compact normal derivative.
pub fn transpose_stress_flux(
    exec: &Exec,
    mesh: &Mesh,
    u: &Unknown<Vec3>,
    gradient: &[Tensor],
    eta: &FaceField<f64>,
    out: &mut FaceField<Vec3>,
) {
    exec.for_each(&mut out.data, |first, out| {
        for (i, t) in out.iter_mut().enumerate() {
            let f = first + i;
            let dudn = normal_derivative(mesh, u, Some(gradient), f);
            *t = scale(
                transpose_derivative(mesh, gradient, f, dudn),
                eta.data[f] * mesh.mag_area[f],
            );
        }
    });
}

/// `n . (grad U)^T = grad (U . n)` on face `f`: interpolated cell gradients whose normal part is
/// replaced by the compact normal derivative `dudn`. Units of the strain rate.
#[inline]
pub fn transpose_derivative(mesh: &Mesh, gradient: &[Tensor], f: usize, dudn: Vec3) -> Vec3 {
    let at_face = interpolated(mesh, gradient, f);
    let n = scale(mesh.area[f], 1.0 / mesh.mag_area[f]);
    let jump = dot(dudn.minus(Vec3::along(at_face, n)), n);
    granflow_base::apply(&at_face, n).axpy(jump, n)
}

/// The gradient on face `f`, `G_ij = d_i U_j`: interpolated cell gradients whose normal part is
/// the compact normal derivative, corrected for non-orthogonality where `corrected`.
#[inline]
pub fn face_gradient(
    mesh: &Mesh,
    u: &Unknown<Vec3>,
    gradient: &[Tensor],
    corrected: bool,
    f: usize,
) -> Tensor {
    let dudn = normal_derivative(mesh, u, corrected.then_some(gradient), f);
    let at_face = interpolated(mesh, gradient, f);
    let n = scale(mesh.area[f], 1.0 / mesh.mag_area[f]);
    at_face.plus(Vec3::dyad(n, dudn.minus(Vec3::along(at_face, n))))
}

/// Cell gradients interpolated to face `f`; the cell's own at the boundary.
#[inline]
fn interpolated(mesh: &Mesh, gradient: &[Tensor], f: usize) -> Tensor {
    let o = mesh.owner[f] as usize;
    match mesh.neighbour.get(f) {
        Some(&n) => {
            let w = mesh.weight[f];
            gradient[o].scaled(w).axpy(1.0 - w, gradient[n as usize])
        }
        None => gradient[o],
    }
}
