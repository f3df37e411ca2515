//! Two fluids with an interface between them: what a step of one fluid does not have.
//!
//! The volume fraction `alpha` of fluid 1 moves with the flux ([`crate::vof`]); the same flux of
//! fluid 1 moves the density in momentum, `rho phi = (rho_1 - rho_2) alphaPhi + rho_2 phi`, so
//! that mass and momentum travel together. Gravity and surface tension act on the faces, where the
//! gradient of `p_rgh` is compact too, and reach the cells together with it (balanced forces: M.
//! M. Francois et al., J. Comput. Phys. 213 (2006) 141; S. Popinet, J. Comput. Phys. 190 (2003)
//! 572). So what balances on the faces moves no cell, on any mesh.

mod convected;
mod face_forces;
mod first_flux;
mod grains;
mod level;
mod mixing;
mod mixture;
mod momentum;
mod pore;
mod prescribed;
mod pressure;
mod step;
mod surface_tension;

pub use mixing::Mixing;
pub use pore::Pores;
pub use prescribed::Prescribed;

use crate::vof::{Corners, Vof, VofReport};
pub(crate) use convected::{Carried, Convected};
use face_forces::FaceForces;
pub use grains::Stiffest;
pub(crate) use grains::{Grains, sparse};
use granflow_base::{Dims, Vec3};
use granflow_fv::{CellField, FaceField, Unknown};
use granflow_linsolve::LinearSolver;
use granflow_mesh::{Mesh, PolyMesh};
use granflow_par::Exec;
use granflow_physics::Rheology;
use level::Levels;
use surface_tension::SurfaceTension;

/// The second fluid, what acts between the two, and how the interface moves.
pub struct TwoPhase {
    /// Density of fluid 2, kg/m3.
    pub rho_2: f64,
    /// The stress of fluid 2.
    pub rheology_2: Box<dyn Rheology>,
    /// Surface tension, N/m.
    pub sigma: f64,
    /// Whether velocity and pressure are left as they are (`frozenFlow`).
    pub frozen: bool,
    /// The total pressure in the reference cell where no boundary fixes its level, Pa.
    pub reference_pressure: f64,
    /// How the volume fraction moves.
    pub vof: Vof,
    /// How viscosities mix.
    pub mixing: Mixing,
    /// What is between the grains, where fluid 1 is made of them.
    pub pores: Pores,
    /// Solver for the pressure there.
    pub pore_solver: Option<Box<dyn LinearSolver<f64>>>,
    /// The greatest viscosity of grains that momentum feels.
    pub stiffest: Stiffest,
    /// The flow, where it is given (and frozen otherwise).
    pub prescribed: Option<Prescribed>,
    pub(crate) work: TwoPhaseWork,
}

/// Scratch of a step with two fluids.
pub(crate) struct TwoPhaseWork {
    pub(crate) alpha_start: Vec<f64>,
    pub(crate) rho_old: CellField<f64>,
    pub(crate) forces: FaceForces,
    pub(crate) levels: Levels,
    pub(crate) tension: SurfaceTension,
    /// Flux of the velocity that momentum gives without pressure and forces on faces, m3/s.
    pub(crate) base: FaceField<f64>,
    pub(crate) vof: VofReport,
    /// The volume flux that moved the interface, m3/s.
    pub(crate) carrier: FaceField<f64>,
    pub(crate) convected: Convected,
    /// Where fluid 1 is made of grains.
    pub(crate) grains: Option<Grains>,
}

impl TwoPhaseWork {
    /// Normal gradient of p_rgh at walls that balances weight and surface tension there, over all
    /// boundary faces, Pa/m.
    pub(crate) fn wall_gradient(&self) -> &[f64] {
        &self.forces.wall_gradient
    }
}

/// What a [`TwoPhase`] is made of.
pub struct TwoPhaseParts {
    /// See [`TwoPhase::rho_2`].
    pub rho_2: f64,
    /// See [`TwoPhase::rheology_2`].
    pub rheology_2: Box<dyn Rheology>,
    /// See [`TwoPhase::sigma`].
    pub sigma: f64,
    /// See [`TwoPhase::frozen`].
    pub frozen: bool,
    /// See [`TwoPhase::reference_pressure`].
    pub reference_pressure: f64,
    /// See [`TwoPhase::vof`].
    pub vof: Vof,
    /// See [`TwoPhase::mixing`].
    pub mixing: Mixing,
    /// See [`TwoPhase::pores`].
    pub pores: Pores,
    /// See [`TwoPhase::pore_solver`]; without one, fluid 1 must not be granular.
    pub pore_solver: Option<Box<dyn LinearSolver<f64>>>,
}

impl TwoPhase {
    /// With the scratch for `mesh`, which was made from `poly` or is a part of it; `p` is the
    /// pressure, `gravity` what it absorbs.
    pub fn new(
        exec: &Exec,
        poly: &PolyMesh,
        mesh: &Mesh,
        p: &Unknown<f64>,
        gravity: Vec3,
        parts: TwoPhaseParts,
    ) -> TwoPhase {
        let TwoPhaseParts { rho_2, rheology_2, sigma, frozen, reference_pressure, vof, .. } = parts;
        let (mixing, pores, pore_solver) = (parts.mixing, parts.pores, parts.pore_solver);
        let work = TwoPhaseWork {
            alpha_start: vec![0.0; mesh.n_all()],
            rho_old: CellField::new(mesh, "rho", Dims::DENSITY, 0.0),
            forces: FaceForces::new(mesh, p),
            levels: Levels::new(exec, Corners::new(poly, mesh), mesh, gravity),
            tension: SurfaceTension::new(exec, mesh),
            base: FaceField::new(mesh, "phiHbyA", Dims::VOLUME_FLUX, 0.0),
            vof: VofReport::default(),
            carrier: FaceField::new(mesh, "carrier", Dims::VOLUME_FLUX, 0.0),
            convected: Convected::default(),
            grains: None,
        };
        TwoPhase {
            rho_2,
            rheology_2,
            sigma,
            frozen,
            reference_pressure,
            vof,
            mixing,
            pores,
            pore_solver,
            stiffest: Stiffest::DEFAULT,
            prescribed: None,
            work,
        }
    }
}
