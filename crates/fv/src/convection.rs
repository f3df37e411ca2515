//! Convection schemes: the value a flux carries through a face.
//!
//! A scheme gives every inner face the weight of its owner (implicit, so that `linear` is truly
//! central) and, where it extrapolates from the upwind cell or to the centre of a skewed face, an
//! explicit correction. Limited schemes have none: their value lies between those of the cells.

use crate::operators::skew_part;
use crate::{Differentiable, FaceField, Limiter, LimiterKind, LimiterVisitor, Unknown};
use granflow_base::{scale, sub};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// A convection scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Convection {
    /// First order, bounded.
    Upwind,
    /// Central, second order.
    Linear,
    /// Upwind with the upwind cell's gradient (Warming & Beam 1976), second order.
    LinearUpwind,
    /// Central limited towards upwind; see [`LimiterKind`].
    Limited(LimiterKind),
}

impl Convection {
    /// The name in `fvSchemes`.
    pub fn name(self) -> &'static str {
        match self {
            Convection::Upwind => "upwind",
            Convection::Linear => "linear",
            Convection::LinearUpwind => "linearUpwind",
            Convection::Limited(l) => l.name(),
        }
    }
    /// Whether the scheme reads the gradient of the field.
    pub fn needs_gradient(self, mesh: &Mesh) -> bool {
        matches!(self, Convection::Limited(_)) || self.corrects(mesh)
    }
    /// Whether the scheme has an explicit correction.
    pub fn corrects(self, mesh: &Mesh) -> bool {
        match self {
            Convection::LinearUpwind => true,
            Convection::Linear => mesh.is_skewed(),
            Convection::Upwind | Convection::Limited(_) => false,
        }
    }
    /// Owner weights of the inner faces for the flux `flux`, into `weights`, and the explicit
    /// correction times the flux into `correction` (untouched unless [`Self::corrects`]).
    /// `gradient` holds the cell gradients (ghosts included) if [`Self::needs_gradient`].
    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of one kernel, spelled out")]
    pub fn weigh<T: Differentiable>(
        self,
        exec: &Exec,
        mesh: &Mesh,
        phi: &Unknown<T>,
        gradient: &[T::Gradient],
        flux: &[f64],
        weights: &mut FaceField<f64>,
        correction: &mut FaceField<T>,
    ) {
        let inner = mesh.n_inner;
        let w = &mut weights.data[..inner];
        let upwind = |f: usize| if flux[f] >= 0.0 { 1.0 } else { 0.0 };
        match self {
            Convection::Upwind => {
                exec.for_each(w, |k, w| (0..w.len()).for_each(|i| w[i] = upwind(k + i)));
            }
            Convection::Linear => {
                exec.for_each(w, |k, w| w.copy_from_slice(&mesh.weight[k..k + w.len()]));
                if self.corrects(mesh) {
                    exec.for_each(&mut correction.data[..inner], |k, out| {
                        for (i, c) in out.iter_mut().enumerate() {
                            *c = skew_part::<T>(mesh, gradient, k + i).scaled(flux[k + i]);
                        }
                    });
                }
            }
            Convection::LinearUpwind => {
                exec.for_each(w, |k, w| (0..w.len()).for_each(|i| w[i] = upwind(k + i)));
                exec.for_each(&mut correction.data[..inner], |k, out| {
                    for (i, c) in out.iter_mut().enumerate() {
                        let f = k + i;
                        let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                        let owner_to_face = sub(mesh.face_centre[f], mesh.cell_centre[o]);
                        *c = if flux[f] >= 0.0 {
                            T::along(gradient[o], owner_to_face)
                        } else {
                            T::along(gradient[n], sub(owner_to_face, mesh.delta[f]))
                        }
                        .scaled(flux[f]);
                    }
                });
            }
            Convection::Limited(limiter) => {
                limiter.run(Weigh { exec, mesh, phi, gradient, flux, weights: w });
            }
        }
    }
}

/// Leaves upwind in the weights of the inner faces and adds to `correction` what they carried beyond
/// it, times the flux (P. K. Khosla, S. G. Rubin, Comput. Fluids 2 (1974) 207). The sum of both is
/// what it was; the matrix is diagonally dominant, and a limiter that follows the field enters as a
/// flux, which is continuous in the field where a weight is not.
pub fn defer_to_upwind<T: Differentiable>(
    exec: &Exec,
    mesh: &Mesh,
    phi: &Unknown<T>,
    flux: &[f64],
    weights: &mut FaceField<f64>,
    correction: &mut FaceField<T>,
) {
    let (inner, cells) = (mesh.n_inner, &phi.cells.data);
    let upwind = |f: usize| if flux[f] >= 0.0 { 1.0 } else { 0.0 };
    let w = &weights.data;
    exec.for_each(&mut correction.data[..inner], |k, out| {
        for (i, c) in out.iter_mut().enumerate() {
            let f = k + i;
            let change = cells[mesh.owner[f] as usize].minus(cells[mesh.neighbour[f] as usize]);
            *c = c.axpy(flux[f] * (w[f] - upwind(f)), change);
        }
    });
    let w = &mut weights.data[..inner];
    exec.for_each(w, |k, w| (0..w.len()).for_each(|i| w[i] = upwind(k + i)));
}

struct Weigh<'a, T: Differentiable> {
    exec: &'a Exec,
    mesh: &'a Mesh,
    phi: &'a Unknown<T>,
    gradient: &'a [T::Gradient],
    flux: &'a [f64],
    weights: &'a mut [f64],
}

impl<T: Differentiable> LimiterVisitor for Weigh<'_, T> {
    type Out = ();
    /// `w = psi(r) w_linear + (1 - psi(r)) w_upwind`, with
    /// `r = 2 d.grad(phi)_C / (phi_D - phi_C) - 1` (Darwish & Moukalled 2003). Vectors are limited
    /// along the direction of their own change over the face.
    fn with<L: Limiter>(self, limiter: L) {
        let Weigh { exec, mesh, phi, gradient, flux, weights } = self;
        let phi = &phi.cells.data;
        exec.for_each(weights, |k, out| {
            for (i, w) in out.iter_mut().enumerate() {
                let f = k + i;
                let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                let (c, upwind, change, d) = if flux[f] >= 0.0 {
                    (o, 1.0, phi[n].minus(phi[o]), mesh.delta[f])
                } else {
                    (n, 0.0, phi[o].minus(phi[n]), scale(mesh.delta[f], -1.0))
                };
                let size = change.inner(change);
                let ahead = change.inner(T::along(gradient[c], d));
                let r = if size > f64::MIN_POSITIVE { 2.0 * ahead / size - 1.0 } else { 1.0 };
                let psi = limiter.psi(r);
                *w = psi * mesh.weight[f] + (1.0 - psi) * upwind;
            }
        });
    }
}
