//! Transport of the volume fraction alpha of the first of two fluids,
//! `d alpha/dt + div(U alpha) = 0` (model, eq. 9), with the interface kept sharp.
//!
//! Two ways, chosen when the case is loaded ([`Params`]):
//! - [`Algebraic`]: bounded flux-corrected transport with an added flux that compresses the
//!   interface;
//! - [`Geometric`]: the interface is a plane in every mixed cell, and the fluid that crosses a
//!   face in a step is the time integral of the part of the face behind it (isoAdvector).
//!
//! Both return the volume flux of fluid 1, `alphaPhi`, that moves density in momentum.

mod algebraic;
mod body;
mod compression;
mod corners;
mod curvature;
mod face_integral;
mod fill;
mod geometric;
mod limiter;
mod paraboloid;
mod reconstruct;
mod stencil;

pub use algebraic::{Algebraic, AlgebraicParams};
pub use body::{Body, Section};
pub use corners::Corners;
pub use fill::{Round, Shape, fill};
pub use geometric::{Geometric, GeometricParams};
pub use reconstruct::{Interface, Reconstruct, Reconstructor};
pub use stencil::Stencil;

use granflow_fv::{DimError, FaceField, Surroundings, Unknown};
use granflow_linsolve::SolveError;
use granflow_mesh::{Mesh, MeshError, PolyMesh};
use granflow_par::Exec;

/// Parameters of either method.
#[derive(Clone, Debug, PartialEq)]
pub enum Params {
    /// Flux-corrected transport with interface compression.
    Algebraic(AlgebraicParams),
    /// isoAdvector.
    Geometric(GeometricParams),
}

/// A method with its work arrays. The choice is made once; loops are inside the methods.
pub enum Vof {
    /// Flux-corrected transport with interface compression.
    Algebraic(Box<Algebraic>),
    /// isoAdvector.
    Geometric(Box<Geometric>),
}

/// What carries a fraction in a step.
#[derive(Clone, Copy)]
pub struct Drive<'a> {
    /// Volume fluxes, m3/s, which hold for the whole step and are free of divergence.
    pub phi: &'a FaceField<f64>,
    /// Length of the step, s.
    pub dt: f64,
    /// What conditions of the fraction see.
    pub around: &'a Surroundings<'a>,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VofReport {
    /// Least volume fraction.
    pub min: f64,
    /// Greatest volume fraction.
    pub max: f64,
    /// Volume of fluid 1, m3.
    pub volume: f64,
    /// What its change differs by from what crossed the boundary, m3: rounding, snapping and
    /// clipping.
    pub volume_error: f64,
    /// Greatest share of a cell's volume that leaves it in the step, over mixed cells and all
    /// sub-cycles' whole: the Courant number at the interface.
    pub interface_courant: f64,
    /// Cells that hold both fluids (geometric) or are between 0.01 and 0.99 (algebraic).
    pub mixed_cells: usize,
    /// Iterations of the reconstruction (geometric) or of the linear solver (algebraic).
    pub iterations: usize,
    /// Passes that redistributed over- and undershoots (geometric).
    pub bound_passes: usize,
}

/// Why a step of the volume fraction failed.
#[derive(Debug, thiserror::Error)]
pub enum VofError {
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The implicit predictor's solver failed.
    #[error("the volume fraction's solver failed: {0}")]
    Solve(#[from] SolveError),
    /// Terms that do not fit together.
    #[error(transparent)]
    Dims(#[from] DimError),
    /// A fraction that is no number.
    #[error("the volume fraction is no longer finite")]
    NotFinite,
}

impl Vof {
    /// The method of `params` on `mesh`, which was made from `poly` (or is a part of it). Every
    /// rank must call.
    ///
    /// # Errors
    /// [`VofError::Mesh`].
    pub fn new(
        exec: &Exec,
        poly: &PolyMesh,
        mesh: &Mesh,
        params: &Params,
    ) -> Result<Vof, VofError> {
        Ok(match params {
            Params::Algebraic(p) => {
                Vof::Algebraic(Box::new(Algebraic::new(exec, mesh, p.clone())?))
            }
            Params::Geometric(p) => {
                Vof::Geometric(Box::new(Geometric::new(exec, poly, mesh, p.clone())?))
            }
        })
    }

    /// Moves `alpha` by a step. Ghosts and conditions of `alpha` are up to date on return.
    ///
    /// # Errors
    /// [`VofError`]; `alpha` is then of no use.
    pub fn advance(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        drive: Drive<'_>,
    ) -> Result<VofReport, VofError> {
        match self {
            Vof::Algebraic(a) => a.advance(exec, mesh, alpha, drive),
            Vof::Geometric(g) => g.advance(exec, mesh, alpha, drive),
        }
    }

    /// Leaves `alpha` where it is; its flux is that of the upwind cells.
    pub(crate) fn hold(&mut self, exec: &Exec, mesh: &Mesh, alpha: &Unknown<f64>, phi: &[f64]) {
        let alpha_phi = match self {
            Vof::Algebraic(a) => &mut a.alpha_phi,
            Vof::Geometric(g) => &mut g.alpha_phi,
        };
        let a = &alpha.cells.data;
        exec.for_each(&mut alpha_phi.data, |first, out| {
            for (i, q) in out.iter_mut().enumerate() {
                let f = first + i;
                let here = a[mesh.owner[f] as usize];
                let there = match mesh.neighbour.get(f) {
                    Some(&n) => a[n as usize],
                    None => alpha.boundary_value(mesh, f),
                };
                *q = phi[f] * if phi[f] >= 0.0 { here } else { there };
            }
        });
    }

    /// Volume flux of fluid 1 through every face, averaged over the last step, m3/s.
    pub fn alpha_phi(&self) -> &FaceField<f64> {
        match self {
            Vof::Algebraic(a) => &a.alpha_phi,
            Vof::Geometric(g) => &g.alpha_phi,
        }
    }
}

/// Volume of fluid 1 in the own cells of all ranks, m3, with its rounding kept apart from the
/// number of cells: pairs of sums by Knuth's two-sum.
pub(crate) fn volume_of(exec: &Exec, mesh: &Mesh, alpha: &[f64]) -> f64 {
    let [sum, lost] = exec.sums(mesh.n_cells, |range| {
        let (mut s, mut e) = (0.0, 0.0);
        for c in range {
            let x = mesh.volume[c] * alpha[c];
            let t: f64 = s + x;
            let back = t - s;
            e += (s - (t - back)) + (x - back);
            s = t;
        }
        [s, e]
    });
    sum + lost
}

/// Net flux through the boundary of all ranks, outwards; coupled patches are no boundary.
pub(crate) fn outflow(exec: &Exec, mesh: &Mesh, flux: &FaceField<f64>) -> f64 {
    let boundary = &flux.data[mesh.n_inner..];
    exec.sum(boundary.len(), |r| boundary[r].iter().sum())
}

/// Least and greatest value of all ranks; NaN when any is NaN.
pub(crate) fn bounds_of(exec: &Exec, alpha: &[f64]) -> (f64, f64) {
    let worse = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
    let fold = |sign: f64| {
        exec.max(alpha.len(), |r| {
            alpha[r].iter().fold(f64::NEG_INFINITY, |m, &a| worse(m, sign * a))
        })
    };
    (-fold(-1.0), fold(1.0))
}
