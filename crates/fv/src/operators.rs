//! Explicit operators. Face loops write faces, cell loops write cells; nothing else is written.

use crate::{Differentiable, FaceField, Unknown};
use granflow_base::{Tensor, Value, Vec3, dot, scale, unit};
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
        return phi.boundary_value(mesh, f).minus(here).scaled(mesh.inv_dist[f]);
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
    exec.for_each(&mut out.data[..mesh.n_inner], |first, out| {
        for (i, q) in out.iter_mut().enumerate() {
            let f = first + i;
            let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
            let w = mesh.weight[f];
            let at_face = gradient[o].scaled(w).axpy(1.0 - w, gradient[n]);
            let mut part = T::along(at_face, mesh.nonorth[f]);
            if limit < 1.0 {
                let compact = phi.cells.data[n].minus(phi.cells.data[o]).scaled(mesh.inv_dist[f]);
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
            let o = mesh.owner[f] as usize;
            let at_face = match mesh.neighbour.get(f) {
                Some(&n) => {
                    let w = mesh.weight[f];
                    gradient[o].scaled(w).axpy(1.0 - w, gradient[n as usize])
                }
                None => gradient[o],
            };
            let n = unit(mesh.area[f]);
            let dudn = normal_derivative(mesh, u, Some(gradient), f);
            let jump = dot(dudn.minus(Vec3::along(at_face, n)), mesh.area[f]);
            let transposed = granflow_base::apply(&at_face, mesh.area[f]);
            *t = scale(transposed.axpy(jump, n), eta.data[f]);
        }
    });
}

/// Weights that rebuild a cell gradient from normal derivatives on its faces:
/// `G = (sum_f |S| n n)^-1 . sum_f |S| n (x) q_f`.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    inverse: Vec<Tensor>,
}

impl Reconstruction {
    /// Precomputes the inverses of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let one = |c: usize| {
            let mut m = [0.0; 9];
            for (f, _) in mesh.faces_of(c) {
                m = m.axpy(1.0 / mesh.mag_area[f], Vec3::dyad(mesh.area[f], mesh.area[f]));
            }
            crate::gradient::inverse_symmetric(&m)
        };
        Reconstruction { inverse: (0..mesh.n_cells).map(one).collect() }
    }

    /// The mean viscous stress of each cell from what its faces carry: the tensor
    /// `H_ij = eta d_i U_j` rebuilt from the compact normal derivatives `eta_f dU/dn`, then
    /// `tau = H + H^T`. Averaging stresses, which are smooth, in place of strain rates, which fall
    /// by a decade every few grains, is what makes four cells a grain enough.
    pub fn viscous_stress(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        gradient: Option<&[Tensor]>,
        eta: &FaceField<f64>,
        out: &mut [Tensor],
    ) {
        exec.for_each(&mut out[..mesh.n_cells], |first, out| {
            for (i, tau) in out.iter_mut().enumerate() {
                let c = first + i;
                let mut sum = [0.0; 9];
                for (f, _) in mesh.faces_of(c) {
                    let q = normal_derivative(mesh, u, gradient, f);
                    sum = sum.axpy(eta.data[f], Vec3::dyad(mesh.area[f], q));
                }
                let mut h = [0.0; 9];
                for r in 0..3 {
                    for k in 0..3 {
                        h[3 * r + k] = (0..3).map(|m| self.inverse[c][3 * r + m] * sum[3 * m + k]).sum();
                    }
                }
                *tau = h.plus(granflow_base::transpose(&h));
            }
        });
    }
}
