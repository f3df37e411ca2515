//! How much the stress ratio varies within a cell.

use granflow_base::{Tensor, Value, Vec3, apply, dot, inverse_symmetric, sub};
use granflow_fv::Differentiable;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Greatest relative spread of mu within a cell; beyond it the cell is coarser than the flow.
const MOST_SPREAD: f64 = 0.5;

/// Gradients from inner neighbours only (least squares): nothing is known of mu on the boundary.
pub(super) struct InnerFit {
    inverse: Vec<Tensor>,
}

impl InnerFit {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let one = |c: usize| {
            let mut m = [0.0; 9];
            for (f, _) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
                let d = mesh.delta[f];
                m = m.axpy(1.0 / dot(d, d), Vec3::dyad(d, d));
            }
            // A direction without neighbours gets no gradient.
            (0..3).for_each(|k| m[4 * k] += 1e-6);
            inverse_symmetric(&m)
        };
        InnerFit { inverse: (0..mesh.n_cells).map(one).collect() }
    }
    fn gradient(&self, mesh: &Mesh, x: &[f64], c: usize) -> Vec3 {
        let mut sum = [0.0; 3];
        for (f, s) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
            let other = if s > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] } as usize;
            let d = mesh.delta[f];
            sum = sum.axpy(s * (x[other] - x[c]) / dot(d, d), d);
        }
        apply(&self.inverse[c], sum)
    }

    /// Standard deviation of `mu` (ghosts fresh) within each cell over its mean:
    /// `sum_f (grad mu . (x_f - x))^2 / 6` is the variance of a linear function over a brick.
    pub(super) fn spread(&self, exec: &Exec, mesh: &Mesh, mu: &[f64], out: &mut [f64]) {
        exec.for_each(out, |first, out| {
            for (i, spread) in out.iter_mut().enumerate() {
                let c = first + i;
                let gradient = self.gradient(mesh, mu, c);
                let mut variance = 0.0;
                for (f, _) in mesh.faces_of(c) {
                    let arm = sub(mesh.face_centre[f], mesh.cell_centre[c]);
                    variance += dot(gradient, arm).powi(2) / 6.0;
                }
                let most = MOST_SPREAD * mu[c];
                *spread = if mu[c] > 0.0 { variance.sqrt().min(most) / mu[c] } else { 0.0 };
            }
        });
    }
}
