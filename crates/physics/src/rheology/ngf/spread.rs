//! How much a quantity, the stress ratio or the pressure, varies within a cell.

use super::FlowView;
use granflow_base::{Tensor, Value, Vec3, apply, dot, inverse_symmetric, sub};
use granflow_fv::Differentiable;
use granflow_mesh::Mesh;

/// Greatest relative spread of mu within a cell; beyond it the cell is coarser than the flow.
const MOST_SPREAD: f64 = 0.5;

/// Gradients from inner neighbours only (least squares): nothing is known of mu on the boundary.
pub(super) struct InnerFit {
    inverse: Vec<Tensor>,
}

impl InnerFit {
    pub(super) fn new(mesh: &Mesh) -> Self {
        InnerFit { inverse: (0..mesh.n_cells).map(|c| inverse(mesh, c, |_| true)).collect() }
    }

    /// The gradient of `x` in cell `c` from the neighbours that have grains.
    fn gradient(&self, v: &FlowView<'_>, x: &[f64], c: usize) -> Vec3 {
        let (mesh, mut sum, mut all) = (v.mesh, [0.0; 3], true);
        for (f, s) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
            let other = if s > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] } as usize;
            if !v.has(other) {
                all = false;
                continue;
            }
            let d = mesh.delta[f];
            sum = sum.axpy(s * (x[other] - x[c]) / dot(d, d), d);
        }
        match all {
            true => apply(&self.inverse[c], sum),
            false => apply(&inverse(mesh, c, |other| v.has(other)), sum),
        }
    }

    /// Standard deviation of `x` (ghosts fresh) within cell `c`:
    /// `sum_f (grad x . (x_f - x))^2 / 6` is the variance of a linear function over a brick.
    pub(super) fn deviation(&self, v: &FlowView<'_>, x: &[f64], c: usize) -> f64 {
        let (mesh, gradient) = (v.mesh, self.gradient(v, x, c));
        let mut variance = 0.0;
        for (f, _) in mesh.faces_of(c) {
            let arm = sub(mesh.face_centre[f], mesh.cell_centre[c]);
            variance += dot(gradient, arm).powi(2) / 6.0;
        }
        variance.sqrt()
    }

    /// Standard deviation of `mu` (ghosts fresh) within each cell over its mean.
    pub(super) fn spread(&self, v: &FlowView<'_>, mu: &[f64], out: &mut [f64]) {
        v.exec.for_each(out, |first, out| {
            for (i, spread) in out.iter_mut().enumerate() {
                let c = first + i;
                *spread = 0.0;
                if mu[c] > 0.0 && v.has(c) {
                    *spread = self.deviation(v, mu, c).min(MOST_SPREAD * mu[c]) / mu[c];
                }
            }
        });
    }
}

/// `(sum d d^T/|d|^2)^-1` over the inner neighbours of cell `c` that count.
fn inverse(mesh: &Mesh, c: usize, counts: impl Fn(usize) -> bool) -> Tensor {
    let mut m = [0.0; 9];
    for (f, s) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
        let other = if s > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] } as usize;
        if counts(other) {
            let d = mesh.delta[f];
            m = m.axpy(1.0 / dot(d, d), Vec3::dyad(d, d));
        }
    }
    // A direction without neighbours gets no gradient.
    (0..3).for_each(|k| m[4 * k] += 1e-6);
    inverse_symmetric(&m)
}
