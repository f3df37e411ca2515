//! Convection schemes: the value a flux carries through a face.
//!
//! A scheme gives every inner face the weight of its owner (implicit, so that `linear` is truly
//! central) and, where it reads gradients or goes to the centre of a skewed face, an explicit
//! correction.

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
    /// The same, kept along the change over the face and no longer than the central scheme's part.
    LinearUpwindV,
    /// A sum of unlimited schemes in fixed shares: `cubic`, `LUST`, `blended`, `fixedBlended`.
    Mixed(Shares),
    /// Central limited towards upwind; see [`LimiterKind`].
    Limited(LimiterKind),
}

/// Shares of the unlimited schemes in a mixture; their sum is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// First order.
    pub upwind: f64,
    /// Central.
    pub linear: f64,
    /// Extrapolation from the upwind cell.
    pub linear_upwind: f64,
    /// The cubic through both cells' values and gradients (Ch. Hermite, J. reine angew. Math. 84
    /// (1878) 70): fourth order at the face of a regular mesh.
    pub cubic: f64,
}

impl Shares {
    /// The cubic alone.
    pub const CUBIC: Shares = Shares { upwind: 0.0, linear: 0.0, linear_upwind: 0.0, cubic: 1.0 };
    /// A quarter of `linearUpwind`, the rest central (H. Weller, Mon. Weather Rev. 140 (2012) 3220).
    pub const LUST: Shares = Shares { upwind: 0.0, linear: 0.75, linear_upwind: 0.25, cubic: 0.0 };
    /// `k` of `a` and the rest of `b`.
    pub fn blend(k: f64, a: Shares, b: Shares) -> Shares {
        let of = |a: f64, b: f64| k * a + (1.0 - k) * b;
        Shares {
            upwind: of(a.upwind, b.upwind),
            linear: of(a.linear, b.linear),
            linear_upwind: of(a.linear_upwind, b.linear_upwind),
            cubic: of(a.cubic, b.cubic),
        }
    }
}

impl Convection {
    /// The scheme as a mixture, if it is one.
    pub fn shares(self) -> Option<Shares> {
        match self {
            Convection::Upwind => Some(Shares { upwind: 1.0, ..Shares::default() }),
            Convection::Linear => Some(Shares { linear: 1.0, ..Shares::default() }),
            Convection::LinearUpwind => Some(Shares { linear_upwind: 1.0, ..Shares::default() }),
            Convection::Mixed(shares) => Some(shares),
            Convection::LinearUpwindV | Convection::Limited(_) => None,
        }
    }
    /// The name in `fvSchemes`.
    pub fn name(self) -> &'static str {
        match self {
            Convection::Upwind => "upwind",
            Convection::Linear => "linear",
            Convection::LinearUpwind => "linearUpwind",
            Convection::LinearUpwindV => "linearUpwindV",
            Convection::Mixed(Shares::CUBIC) => "cubic",
            Convection::Mixed(Shares::LUST) => "LUST",
            Convection::Mixed(_) => "fixedBlended",
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
            Convection::LinearUpwind | Convection::LinearUpwindV | Convection::Mixed(_) => true,
            Convection::Linear | Convection::Limited(_) => mesh.is_skewed(),
            Convection::Upwind => false,
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
                        *c = extrapolated::<T>(mesh, gradient, k + i, flux[k + i] >= 0.0)
                            .scaled(flux[k + i]);
                    }
                });
            }
            Convection::LinearUpwindV => {
                exec.for_each(w, |k, w| (0..w.len()).for_each(|i| w[i] = upwind(k + i)));
                let phi = &phi.cells.data;
                let skewed = mesh.is_skewed();
                exec.for_each(&mut correction.data[..inner], |k, out| {
                    for (i, c) in out.iter_mut().enumerate() {
                        let f = k + i;
                        let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                        let downstream = flux[f] >= 0.0;
                        let beyond = extrapolated::<T>(mesh, gradient, f, downstream);
                        let mut most = if downstream {
                            phi[n].minus(phi[o]).scaled(1.0 - mesh.weight[f])
                        } else {
                            phi[o].minus(phi[n]).scaled(mesh.weight[f])
                        };
                        if skewed {
                            most = most.plus(skew_part::<T>(mesh, gradient, f));
                        }
                        let (along, all) = (beyond.inner(most), most.inner(most));
                        let kept = if along <= 0.0 { 0.0 } else { (all / along).min(1.0) };
                        *c = beyond.scaled(kept * flux[f]);
                    }
                });
            }
            Convection::Mixed(shares) => {
                let central = shares.linear + shares.cubic;
                exec.for_each(w, |k, w| {
                    for (i, w) in w.iter_mut().enumerate() {
                        let f = k + i;
                        *w = central * mesh.weight[f] + (1.0 - central) * upwind(f);
                    }
                });
                let skewed = mesh.is_skewed();
                exec.for_each(&mut correction.data[..inner], |k, out| {
                    for (i, c) in out.iter_mut().enumerate() {
                        let f = k + i;
                        let beyond = extrapolated::<T>(mesh, gradient, f, flux[f] >= 0.0);
                        let mut sum = beyond.scaled(shares.linear_upwind);
                        if shares.cubic != 0.0 {
                            sum = sum.axpy(shares.cubic, bend(mesh, phi, gradient, f));
                        }
                        if skewed {
                            sum = sum.axpy(central, skew_part::<T>(mesh, gradient, f));
                        }
                        *c = sum.scaled(flux[f]);
                    }
                });
            }
            Convection::Limited(limiter) => {
                limiter.run(Weigh { exec, mesh, phi, gradient, flux, weights: w, correction });
            }
        }
    }
}

/// From the centre of the upwind cell to that of face `f`, along the cell's gradient.
#[inline]
fn extrapolated<T: Differentiable>(
    mesh: &Mesh,
    gradient: &[T::Gradient],
    f: usize,
    from_owner: bool,
) -> T {
    let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
    let owner_to_face = sub(mesh.face_centre[f], mesh.cell_centre[o]);
    if from_owner {
        T::along(gradient[o], owner_to_face)
    } else {
        T::along(gradient[n], sub(owner_to_face, mesh.delta[f]))
    }
}

/// What the cubic through values and gradients of the two cells is ahead of the straight line,
/// where it meets face `f`.
#[inline]
fn bend<T: Differentiable>(mesh: &Mesh, phi: &Unknown<T>, gradient: &[T::Gradient], f: usize) -> T {
    let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
    let t = 1.0 - mesh.weight[f];
    let change = phi.cells.data[n].minus(phi.cells.data[o]);
    let at_owner = T::along(gradient[o], mesh.delta[f]);
    let at_neighbour = T::along(gradient[n], mesh.delta[f]);
    let s = t * (1.0 - t);
    change.scaled(s * (2.0 * t - 1.0)).axpy(s * (1.0 - t), at_owner).axpy(-s * t, at_neighbour)
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
    correction: &'a mut FaceField<T>,
}

impl<T: Differentiable> LimiterVisitor for Weigh<'_, T> {
    type Out = ();
    /// `w = psi(r) w_linear + (1 - psi(r)) w_upwind`, with
    /// `r = 2 d.grad(phi)_C / (phi_D - phi_C) - 1` (Darwish & Moukalled 2003). On skewed faces both are
    /// taken to the face's centre: where cells hardly differ, what the face has beside the line between them is
    /// limited as well, or the flux would jump with `r`. Vectors are limited along the direction of their own
    /// change over the face.
    fn with<L: Limiter>(self, limiter: L) {
        let Weigh { exec, mesh, phi, gradient, flux, weights, correction } = self;
        let phi = &phi.cells.data;
        let skewed = mesh.is_skewed();
        // How much of the central scheme's part face `f` takes, and the upwind weight.
        let share = |f: usize| {
            let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
            let (c, upwind, change, d) = if flux[f] >= 0.0 {
                (o, 1.0, phi[n].minus(phi[o]), mesh.delta[f])
            } else {
                (n, 0.0, phi[o].minus(phi[n]), scale(mesh.delta[f], -1.0))
            };
            let (change, half) = if skewed {
                // What central differences and the cell's gradient say of the face itself.
                let part = (mesh.weight[f] - upwind).abs();
                let change = change.scaled(part).plus(skew_part::<T>(mesh, gradient, f));
                (change, extrapolated::<T>(mesh, gradient, f, flux[f] >= 0.0))
            } else {
                (change, T::along(gradient[c], d))
            };
            let (size, ahead) = (change.inner(change), change.inner(half));
            let r = if size > f64::MIN_POSITIVE { 2.0 * ahead / size - 1.0 } else { 1.0 };
            (limiter.psi(r), upwind)
        };
        exec.for_each(weights, |k, out| {
            for (i, w) in out.iter_mut().enumerate() {
                let (psi, upwind) = share(k + i);
                *w = psi * mesh.weight[k + i] + (1.0 - psi) * upwind;
            }
        });
        if skewed {
            exec.for_each(&mut correction.data[..mesh.n_inner], |k, out| {
                for (i, c) in out.iter_mut().enumerate() {
                    let (psi, f) = (share(k + i).0, k + i);
                    *c = skew_part::<T>(mesh, gradient, f).scaled(psi * flux[f]);
                }
            });
        }
    }
}
