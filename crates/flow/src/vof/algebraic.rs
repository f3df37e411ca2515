//! Algebraic transport of the volume fraction: a bounded upwind step, then as much of the flux
//! that a sharper scheme asks for as keeps the fraction within bounds (flux-corrected transport).
//!
//! The sharper flux is `phi alpha_f` with a limited scheme plus the compressive flux of
//! [`super::compression`]. What goes by the keys of OpenFOAM's MULES solver is meant to act alike;
//! the limiter is Zalesak's ([`super::limiter`]).

use super::compression::Compression;
use super::geometric::cell_velocity;
use super::limiter::FluxLimiter;
use super::{Drive, VofError, VofReport, bounds_of, outflow, volume_of};
use granflow_base::{Dims, Vec3, norm};
use granflow_fv::{
    CellField, Convection, Ddt, Equation, FaceField, Gradient, LimiterKind, Unknown, ddt, div,
};
use granflow_linsolve::{LinearSolver, SolverSpec, Tolerance, build};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Parameters of [`Algebraic`]; the keys of `fvSolution` are in brackets.
#[derive(Clone, Debug, PartialEq)]
pub struct AlgebraicParams {
    /// Strength of the compression (`cAlpha`, 1; 0 for none).
    pub c_alpha: f64,
    /// Share of the compression that acts whichever way the flow goes (`icAlpha`, 0).
    pub ic_alpha: f64,
    /// Correctors (`nAlphaCorr`, 1).
    pub n_alpha_corr: usize,
    /// Steps the time step is divided into (`nAlphaSubCycles`, 1).
    pub n_alpha_sub_cycles: usize,
    /// Whether the upwind step is implicit, so that it is bounded at any Courant number
    /// (`MULESCorr`, false). An explicit one is up to 1.
    pub mules_corr: bool,
    /// Whether the compression has the central fraction of the face everywhere, as OpenFOAM's `div(phirb,alpha)
    /// Gauss linear` has, and not only in the middle of the interface (false).
    pub central_compression: bool,
    /// Passes of the limiter (`nLimiterIter`, 3).
    pub n_limiter_iter: usize,
    /// Scheme of `div(phi,alpha)` (vanLeer).
    pub convection: Convection,
    /// Tolerance of the implicit predictor.
    pub tolerance: Tolerance,
}

impl Default for AlgebraicParams {
    fn default() -> Self {
        AlgebraicParams {
            c_alpha: 1.0,
            ic_alpha: 0.0,
            n_alpha_corr: 1,
            n_alpha_sub_cycles: 1,
            mules_corr: false,
            central_compression: false,
            n_limiter_iter: 3,
            convection: Convection::Limited(LimiterKind::VanLeer(1.0)),
            tolerance: Tolerance { abs: 1e-12, rel: 0.0, max_iter: 200 },
        }
    }
}

/// Weight of the sharper flux in correctors after the first: the mean of both ends of the step.
const LATER: f64 = 0.5;

/// Flux-corrected transport with its work arrays.
pub struct Algebraic {
    params: AlgebraicParams,
    limiter: FluxLimiter,
    predictor: Option<Predictor>,
    old: Vec<f64>,
    gradient: Vec<Vec3>,
    speed: Vec<f64>,
    weights: FaceField<f64>,
    scratch: FaceField<f64>,
    correction: FaceField<f64>,
    flux: FaceField<f64>,
    /// Gradient below which there is no interface, 1/m: 1e-8 over the mean cell's size.
    least_gradient: f64,
    /// See [`super::Vof::alpha_phi`].
    pub alpha_phi: FaceField<f64>,
}

/// What the implicit upwind step needs.
struct Predictor {
    equation: Equation<f64>,
    solver: Box<dyn LinearSolver<f64>>,
    one: CellField<f64>,
}

/// Part of a flux that is not worth a limiter's work. Diffusion leaves fractions of 1e-100 everywhere.
const NOTHING: f64 = 1e-15;

impl Algebraic {
    /// The method on `mesh`.
    ///
    /// # Errors
    /// None at present; [`VofError`] for the sake of the other method's signature.
    pub fn new(exec: &Exec, mesh: &Mesh, params: AlgebraicParams) -> Result<Algebraic, VofError> {
        let spec = SolverSpec {
            solver: "PBiCGStab".into(),
            preconditioner: Some("DILU".into()),
            smoother: None,
        };
        let predictor = build(&spec).ok().filter(|_| params.mules_corr).map(|solver| Predictor {
            equation: Equation::new(exec, mesh),
            solver,
            one: CellField::new(mesh, "1", Dims::NONE, 1.0),
        });
        let [volume, cells] =
            exec.sums(mesh.n_cells, |r| [mesh.volume[r.clone()].iter().sum(), r.len() as f64]);
        let face = |name: &str, dims| FaceField::new(mesh, name, dims, 0.0);
        Ok(Algebraic {
            params,
            limiter: FluxLimiter::new(mesh),
            predictor,
            old: vec![0.0; mesh.n_all()],
            gradient: vec![[0.0; 3]; mesh.n_all()],
            speed: vec![0.0; mesh.n_all()],
            weights: face("alphaWeights", Dims::NONE),
            scratch: face("alphaScratch", Dims::VOLUME_FLUX),
            correction: face("alphaCorrection", Dims::VOLUME_FLUX),
            flux: face("alphaFlux", Dims::VOLUME_FLUX),
            least_gradient: 1e-8 / (volume / cells).cbrt(),
            alpha_phi: face("alphaPhi", Dims::VOLUME_FLUX),
        })
    }

    /// See [`super::Vof::advance`].
    ///
    /// # Errors
    /// [`VofError::Solve`], [`VofError::NotFinite`].
    pub fn advance(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        drive: Drive<'_>,
    ) -> Result<VofReport, VofError> {
        let Drive { phi, dt, around } = drive;
        let n = mesh.n_cells;
        let cycles = self.params.n_alpha_sub_cycles.max(1);
        let step = dt / cycles as f64;
        let mut report = VofReport::default();
        let before = volume_of(exec, mesh, &alpha.cells.data);
        self.alpha_phi.data.fill(0.0);
        if self.params.ic_alpha > 0.0 && self.params.c_alpha > 0.0 {
            exec.for_each(&mut self.speed[..n], |first, out| {
                for (i, s) in out.iter_mut().enumerate() {
                    *s = norm(cell_velocity(mesh, phi, first + i));
                }
            });
            mesh.halo.update(exec, &mut self.speed);
        }
        for _ in 0..cycles {
            alpha.update(exec, mesh, around, Some(phi));
            self.old.copy_from_slice(&alpha.cells.data);
            if self.params.mules_corr {
                report.iterations += self.solve_upwind(exec, mesh, alpha, phi, step)?;
                alpha.update(exec, mesh, around, Some(phi));
            }
            for corrector in 0..self.params.n_alpha_corr.max(1) {
                let weight = if corrector == 0 { 1.0 } else { LATER };
                // The explicit upwind step starts from the same fractions as the sharper flux.
                let first_explicit = corrector == 0 && !self.params.mules_corr;
                self.sharper_flux(exec, mesh, alpha, phi);
                if corrector == 0 {
                    self.upwind_flux(exec, mesh, alpha, phi);
                    self.step_with_flux(exec, mesh, &mut alpha.cells.data, step);
                    if first_explicit {
                        alpha.update(exec, mesh, around, Some(phi));
                    }
                }
                let (flux, through) = (&self.flux.data, &phi.data);
                exec.for_each(&mut self.correction.data[..mesh.n_inner], |first, k| {
                    for (i, k) in k.iter_mut().enumerate() {
                        let all = weight * (*k - flux[first + i]);
                        *k = if all.abs() > NOTHING * through[first + i].abs() { all } else { 0.0 };
                    }
                });
                self.limiter.find_bounds(exec, mesh, alpha, &self.old);
                let passes = self.params.n_limiter_iter;
                let Algebraic { limiter, correction, flux, .. } = self;
                limiter.add(exec, mesh, &mut alpha.cells.data, correction, flux, step, passes);
                alpha.update(exec, mesh, around, Some(phi));
            }
            let flux = &self.flux.data;
            exec.for_each(&mut self.alpha_phi.data, |first, q| {
                q.iter_mut().enumerate().for_each(|(i, q)| *q += flux[first + i] * (step / dt));
            });
        }
        self.report(exec, mesh, alpha, phi, dt, before, &mut report);
        if report.min.is_finite() && report.max.is_finite() {
            Ok(report)
        } else {
            Err(VofError::NotFinite)
        }
    }

    /// The implicit upwind step, `(alpha - alpha_old)/dt + div(phi alpha_upwind) = 0`, into
    /// `alpha`. How well it is solved decides about bounds only: the fractions are recomputed
    /// from the fluxes.
    fn solve_upwind(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        phi: &FaceField<f64>,
        dt: f64,
    ) -> Result<usize, VofError> {
        let Algebraic { predictor, weights, scratch, gradient, old, params, .. } = self;
        let Some(Predictor { equation, solver, one }) = predictor else { return Ok(0) };
        Convection::Upwind.weigh(exec, mesh, alpha, gradient, &phi.data, weights, scratch);
        let c = [1.0, 1.0, 0.0];
        let inertia = Ddt { rho: one, rho_old: one, old, older: old, dt, c };
        equation.assemble(exec, mesh, alpha, &(ddt(inertia) + div(phi, weights)))?;
        solver.refresh(exec, &equation.a)?;
        let x = &mut alpha.cells.data;
        let solved = solver.solve(exec, &equation.a, &equation.b, x, &params.tolerance);
        let mut count = crate::SolveCount::default();
        Ok(crate::settle(solved, x, crate::Purpose::Values, &mut count)?.iterations)
    }

    /// `phi alpha_upwind`, into `self.flux`; on the boundary the condition's value.
    fn upwind_flux(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
        phi: &FaceField<f64>,
    ) {
        exec.for_each(&mut self.flux.data, |first, out| {
            for (i, q) in out.iter_mut().enumerate() {
                let f = first + i;
                let carried = match mesh.neighbour.get(f) {
                    Some(_) if phi.data[f] >= 0.0 => alpha.cells.data[mesh.owner[f] as usize],
                    Some(&n) => alpha.cells.data[n as usize],
                    None => alpha.boundary_value(mesh, f),
                };
                *q = phi.data[f] * carried;
            }
        });
    }

    /// `alpha = alpha_old - dt/V div(flux)`.
    fn step_with_flux(&self, exec: &Exec, mesh: &Mesh, alpha: &mut [f64], dt: f64) {
        let (old, flux) = (&self.old, &self.flux.data);
        exec.for_each(&mut alpha[..mesh.n_cells], |first, alpha| {
            for (i, a) in alpha.iter_mut().enumerate() {
                let c = first + i;
                let net: f64 = mesh.faces_of(c).map(|(f, s)| s * flux[f]).sum();
                *a = old[c] - dt / mesh.volume[c] * net;
            }
        });
        mesh.halo.update(exec, alpha);
    }

    /// The flux one would like, `phi alpha_f` by the chosen scheme and the compression, on inner
    /// faces, into `self.correction`.
    fn sharper_flux(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
        phi: &FaceField<f64>,
    ) {
        let Algebraic { params, gradient, weights, scratch, correction, speed, .. } = self;
        Gradient::GaussLinear.of(exec, mesh, alpha, gradient);
        scratch.data.fill(0.0);
        params.convection.weigh(exec, mesh, alpha, gradient, &phi.data, weights, scratch);
        let compression = Compression {
            c_alpha: params.c_alpha,
            ic_alpha: params.ic_alpha,
            gradient,
            speed,
            least_gradient: self.least_gradient,
            least_centrality: if params.central_compression { 1.0 } else { 0.0 },
        };
        let a = &alpha.cells.data;
        exec.for_each(&mut correction.data[..mesh.n_inner], |first, out| {
            for (i, q) in out.iter_mut().enumerate() {
                let f = first + i;
                let (o, n, w) =
                    (mesh.owner[f] as usize, mesh.neighbour[f] as usize, weights.data[f]);
                let phi = phi.data[f];
                let carried = w * a[o] + (1.0 - w) * a[n];
                *q = phi * carried + scratch.data[f] + compression.flux(mesh, a, phi, f);
            }
        });
    }

    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of one kernel, spelled out")]
    fn report(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
        phi: &FaceField<f64>,
        dt: f64,
        before: f64,
        report: &mut VofReport,
    ) {
        let a = &alpha.cells.data[..mesh.n_cells];
        (report.min, report.max) = bounds_of(exec, a);
        report.volume = volume_of(exec, mesh, a);
        report.volume_error = report.volume - before + dt * outflow(exec, mesh, &self.alpha_phi);
        let mixed = |c: usize| a[c] > 0.01 && a[c] < 0.99;
        let courant = |c: usize| {
            let out: f64 = mesh.faces_of(c).map(|(f, s)| (s * phi.data[f]).max(0.0)).sum();
            dt * out / mesh.volume[c]
        };
        let most = exec.max(a.len(), |r| r.filter(|&c| mixed(c)).map(courant).fold(0.0, f64::max));
        report.interface_courant = most.max(0.0);
        let count = exec.sum(a.len(), |r| r.filter(|&c| mixed(c)).count() as f64);
        report.mixed_cells = count as usize;
    }
}
