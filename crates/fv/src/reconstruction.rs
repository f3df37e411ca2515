//! Cell means of stress and strain rate, rebuilt from what the faces have.

use crate::operators::{normal_derivative, transpose_derivative};
use crate::{Differentiable, FaceField, Unknown};
use granflow_base::{Tensor, Value, Vec3};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Weights that rebuild a cell gradient from normal derivatives on its faces:
/// `G = (sum_f |S| n n)^-1 . sum_f |S| n (x) q_f`.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    inverse: Vec<Tensor>,
}

/// Entries off the diagonal of a symmetric tensor, seen from two sets of faces.
const PAIRS: [(usize, usize); 3] = [(1, 3), (2, 6), (5, 7)];

impl Reconstruction {
    /// Precomputes the inverses of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let one = |c: usize| {
            let mut m = [0.0; 9];
            for (f, _) in mesh.faces_of(c) {
                m = m.axpy(1.0 / mesh.mag_area[f], Vec3::dyad(mesh.area[f], mesh.area[f]));
            }
            granflow_base::inverse_symmetric(&mesh.fit_to_invert(m))
        };
        Reconstruction { inverse: (0..mesh.n_cells).map(one).collect() }
    }

    /// The vector in cell `c` for which `sum` is the sum of its normal parts on the faces times their
    /// area vectors.
    #[inline]
    pub fn vector(&self, c: usize, sum: Vec3) -> Vec3 {
        granflow_base::apply(&self.inverse[c], sum)
    }

    /// The mean viscous stress of each cell, rebuilt from the tractions of its faces as momentum
    /// has them. Averaging stresses, which are smooth, in place of strain rates, which fall by a
    /// decade every few grains, is what makes four cells a grain enough.
    ///
    /// With `H_ij = eta d_i U_j` from compact normal derivatives on the faces that look along i,
    /// and `T` from the whole tractions (transpose part included), the diagonal is `2 H_ii`. Off
    /// the diagonal T_ij and T_ji are the same stress seen from two sets of faces; each counts by
    /// the share that its compact part has in it, since the other part comes from wide differences.
    pub fn viscous_stress(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        gradient: &[Tensor],
        eta: &FaceField<f64>,
        out: &mut [Tensor],
    ) {
        exec.for_each(&mut out[..mesh.n_cells], |first, out| {
            for (i, tau) in out.iter_mut().enumerate() {
                let (h, t) = self.rebuilt(mesh, u, gradient, |f| eta.data[f], first + i);
                *tau = combined(&h, &t, &shares_of(&h));
            }
        });
    }

    /// Twice the strain rate of each cell, `grad U + grad U^T`, 1/s, as [`Self::viscous_stress`]
    /// has it for a viscosity of one; `shares` takes the share of the first set of faces in each
    /// entry off the diagonal (xy, xz, yz).
    pub fn twice_strain(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        gradient: &[Tensor],
        shares: &mut [[f64; 3]],
        out: &mut [Tensor],
    ) {
        let n = mesh.n_cells;
        exec.for_each2(&mut out[..n], &mut shares[..n], |first, out, shares| {
            for (i, strain) in out.iter_mut().enumerate() {
                let (h, t) = self.rebuilt(mesh, u, gradient, |_| 1.0, first + i);
                shares[i] = shares_of(&h);
                *strain = combined(&h, &t, &shares[i]);
            }
        });
    }

    /// The change of [`Self::twice_strain`] with a change `u` of the velocity, shares held:
    /// linear in `u`.
    pub fn change_of_strain(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        gradient: &[Tensor],
        shares: &[[f64; 3]],
        out: &mut [Tensor],
    ) {
        exec.for_each(&mut out[..mesh.n_cells], |first, out| {
            for (i, strain) in out.iter_mut().enumerate() {
                let (h, t) = self.rebuilt(mesh, u, gradient, |_| 1.0, first + i);
                *strain = combined(&h, &t, &shares[first + i]);
            }
        });
    }

    /// `H` and `T` of cell `c`.
    #[inline]
    fn rebuilt(
        &self,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        gradient: &[Tensor],
        eta: impl Fn(usize) -> f64,
        c: usize,
    ) -> (Tensor, Tensor) {
        let non_orthogonal = (mesh.max_nonorth_deg > 0.1).then_some(gradient);
        let (mut compact, mut whole) = ([0.0; 9], [0.0; 9]);
        for (f, _) in mesh.faces_of(c) {
            let dudn = normal_derivative(mesh, u, non_orthogonal, f);
            let both = dudn.plus(transpose_derivative(mesh, gradient, f, dudn));
            compact = compact.axpy(eta(f), Vec3::dyad(mesh.area[f], dudn));
            whole = whole.axpy(eta(f), Vec3::dyad(mesh.area[f], both));
        }
        (product(&self.inverse[c], &compact), product(&self.inverse[c], &whole))
    }
}

/// Share of the first set of faces in each entry off the diagonal.
#[inline]
fn shares_of(h: &Tensor) -> [f64; 3] {
    PAIRS.map(|(a, b)| {
        let (p, q) = (h[a] * h[a], h[b] * h[b]);
        if p + q > 0.0 { p / (p + q) } else { 0.5 }
    })
}

#[inline]
fn combined(h: &Tensor, t: &Tensor, shares: &[f64; 3]) -> Tensor {
    let mut s = [0.0; 9];
    (s[0], s[4], s[8]) = (2.0 * h[0], 2.0 * h[4], 2.0 * h[8]);
    for ((a, b), share) in PAIRS.into_iter().zip(shares) {
        let x = share * t[a] + (1.0 - share) * t[b];
        (s[a], s[b]) = (x, x);
    }
    s
}

/// `(a . b)_ij = a_ik b_kj`.
#[inline]
fn product(a: &Tensor, b: &Tensor) -> Tensor {
    let mut c = [0.0; 9];
    for i in 0..3 {
        for j in 0..3 {
            c[3 * i + j] = (0..3).map(|k| a[3 * i + k] * b[3 * k + j]).sum();
        }
    }
    c
}
