//! Scratch of a step: allocated once, and any of it may be garbage between steps.

use crate::coupled::Coupled;
use crate::friction::Friction;
use crate::newton::Newton;
use crate::{Anderson, Residuals, SolveCount};
use granflow_base::{Dims, Tensor, Vec3};
use granflow_fv::{CellField, Equation, FaceField, Reconstruction, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::Beyond;

pub(crate) struct Work {
    pub(crate) u_eqn: Equation<Vec3>,
    pub(crate) p_eqn: Equation<f64>,
    /// Density, as a field: the equations are written for a density that varies.
    pub(crate) rho: CellField<f64>,
    pub(crate) rho_phi: FaceField<f64>,
    pub(crate) phi_start: Vec<f64>,
    /// What the old fluxes are ahead of the flux of the old velocities.
    pub(crate) ahead: FaceField<f64>,
    pub(crate) u_start: Vec<Vec3>,
    pub(crate) p_start: Vec<f64>,
    /// Time and number of the step before the present one.
    pub(crate) clock_start: (f64, usize),
    /// Length of a step of pseudo-time on the way to a steady state, s; none: without end.
    pub(crate) pseudo_step: Option<f64>,
    /// Linear solves of the present step: momentum, pressure.
    pub(crate) solves: [SolveCount; 2],
    /// Where the last sound state of this step had too much stress.
    pub(crate) beyond: Option<Beyond>,
    /// Residuals of the last state of this step.
    pub(crate) residuals: Residuals,
    /// Whether `eta` is the viscosity that the last step accepted.
    pub(crate) fresh: bool,
    /// ln(viscosity) of the outer iteration and what the rheology made of it.
    pub(crate) y: Vec<f64>,
    pub(crate) g_of_y: Vec<f64>,
    pub(crate) anderson: Anderson,
    pub(crate) eta: CellField<f64>,
    pub(crate) eta_new: CellField<f64>,
    pub(crate) eta_f: FaceField<f64>,
    /// Explicit momentum flux: transpose stress, non-orthogonal and convective corrections.
    pub(crate) explicit: FaceField<Vec3>,
    pub(crate) scratch_f: FaceField<Vec3>,
    pub(crate) weights: FaceField<f64>,
    pub(crate) grad_u: Vec<Tensor>,
    /// The same, limited, where convection extrapolates with that.
    pub(crate) limited: Option<Vec<Tensor>>,
    /// Density over a cell's own step, times the step, where cells have steps of their own; scratch.
    pub(crate) local: crate::time::Local,
    pub(crate) grad_p: Vec<Vec3>,
    /// Normal derivative of the pressure on faces.
    pub(crate) dp_dn: Vec<f64>,
    pub(crate) stress: Vec<Tensor>,
    pub(crate) strain_rate: Vec<f64>,
    /// Least strain rate that a local law sees, over that of a free fall through the cell, 1/s: zero but
    /// for the first guess of what is about to move.
    pub(crate) slowest: f64,
    /// Magnitude of `stress`.
    pub(crate) tau: Vec<f64>,
    pub(crate) pressure: Vec<f64>,
    pub(crate) body: CellField<Vec3>,
    /// Drag of sources per volume and velocity, kg/(m3 s); zero where there are none.
    pub(crate) sink: CellField<f64>,
    pub(crate) b: Vec<Vec3>,
    pub(crate) residual: Vec<Vec3>,
    pub(crate) hby_a: Vec<Vec3>,
    /// V/a_P, the velocity per unit pressure gradient of one cell alone.
    pub(crate) r_a: CellField<f64>,
    /// V/(row sum): of all cells together (SIMPLEC).
    pub(crate) r_at: CellField<f64>,
    pub(crate) r_a_f: FaceField<f64>,
    pub(crate) r_at_f: FaceField<f64>,
    /// Weights of the owners' velocities in the flux, where grains end; else empty.
    pub(crate) flux_weights: Vec<f64>,
    pub(crate) phi_star: FaceField<f64>,
    pub(crate) p_prime: Unknown<f64>,
    pub(crate) p_scratch: FaceField<f64>,
    /// 1/(2 eta), the pressure's answer to compression where viscosity rules.
    pub(crate) compliance: CellField<f64>,
    /// `rho U^2/2` on boundary faces, Pa.
    pub(crate) dynamic_pressure: Vec<f64>,
    /// Volume fraction of fluid 1 there, where there are two.
    pub(crate) face_fraction: Vec<f64>,
    /// Velocity on boundary faces, m/s.
    pub(crate) face_velocity: Vec<Vec3>,
    /// The part of it that conditions give at the present time, m/s.
    pub(crate) boundary_now: Vec<Vec3>,
    pub(crate) reconstruction: Reconstruction,
    /// Sum of the forces at work, from the last momentum residual, N.
    pub(crate) force: f64,
    pub(crate) coupled: Coupled,
    pub(crate) newton: Newton,
    pub(crate) friction: Friction,
    pub(crate) patience: crate::step::Patience,
    pub(crate) best: crate::best::Best,
}

impl Work {
    pub(crate) fn new(
        exec: &Exec,
        m: &Mesh,
        (rho, local): (f64, bool),
        driving: Vec3,
        (u, p): (&Unknown<Vec3>, &Unknown<f64>),
    ) -> Self {
        let cells = m.n_cells + m.n_ghosts;
        let mobility = Dims::TIME.div(Dims::DENSITY);
        let conditions = m
            .patches
            .iter()
            .map(|_| Box::new(granflow_fv::conditions::ZeroGradient) as Box<_>)
            .collect();
        let force = granflow_base::scale(driving, rho);
        Work {
            u_eqn: Equation::new(exec, m),
            p_eqn: Equation::new(exec, m),
            rho: CellField::new(m, "rho", Dims::DENSITY, rho),
            rho_phi: FaceField::new(m, "rhoPhi", Dims::MASS_FLUX, 0.0),
            phi_start: vec![0.0; m.n_faces()],
            ahead: FaceField::new(m, "phi", Dims::VOLUME_FLUX, 0.0),
            u_start: vec![[0.0; 3]; cells],
            p_start: vec![0.0; cells],
            clock_start: (0.0, 0),
            limited: None,
            local: None,
            pseudo_step: None,
            solves: Default::default(),
            beyond: None,
            slowest: 0.0,
            residuals: Residuals::default(),
            fresh: false,
            y: vec![0.0; m.n_cells],
            g_of_y: vec![0.0; m.n_cells],
            anderson: Anderson::new(m.n_cells, 10),
            eta: CellField::new(m, "eta", Dims::VISCOSITY, 0.0),
            eta_new: CellField::new(m, "eta", Dims::VISCOSITY, 0.0),
            eta_f: FaceField::new(m, "eta", Dims::VISCOSITY, 0.0),
            explicit: FaceField::new(m, "explicitStress", Dims::FORCE, [0.0; 3]),
            scratch_f: FaceField::new(m, "scratch", Dims::FORCE, [0.0; 3]),
            weights: FaceField::new(m, "weights", Dims::NONE, 0.0),
            grad_u: vec![[0.0; 9]; cells],
            grad_p: vec![[0.0; 3]; cells],
            dp_dn: vec![0.0; m.n_faces()],
            stress: vec![[0.0; 9]; cells],
            strain_rate: vec![0.0; cells],
            tau: vec![0.0; cells],
            pressure: vec![0.0; cells],
            sink: CellField::new(m, "sink", Dims::DENSITY.div(Dims::TIME), 0.0),
            body: CellField::new(m, "rhoG", Dims::DENSITY.mul(Dims::ACCELERATION), force),
            b: vec![[0.0; 3]; m.n_cells],
            residual: vec![[0.0; 3]; m.n_cells],
            hby_a: vec![[0.0; 3]; cells],
            r_a: CellField::new(m, "rA", mobility, 0.0),
            r_at: CellField::new(m, "rAt", mobility, 0.0),
            r_a_f: FaceField::new(m, "rA", mobility, 0.0),
            r_at_f: FaceField::new(m, "rAt", mobility, 0.0),
            flux_weights: Vec::new(),
            phi_star: FaceField::new(m, "phi", Dims::VOLUME_FLUX, 0.0),
            p_prime: Unknown::new(m, "p'", p.cells.dims, 0.0, conditions),
            p_scratch: FaceField::new(m, "phi'", Dims::VOLUME_FLUX, 0.0),
            compliance: CellField::new(m, "1/(2 eta)", Dims::VISCOSITY.inv(), 0.0),
            dynamic_pressure: vec![0.0; m.n_faces() - m.n_inner],
            face_fraction: vec![0.0; m.n_faces() - m.n_inner],
            face_velocity: vec![[0.0; 3]; m.n_faces() - m.n_inner],
            boundary_now: vec![[0.0; 3]; m.n_faces() - m.n_inner],
            reconstruction: Reconstruction::new(m),
            force: 0.0,
            coupled: Coupled::new(exec, m),
            newton: Newton::new(m, local),
            friction: Friction::new(m, u),
            patience: crate::step::Patience::default(),
            best: crate::best::Best::default(),
        }
    }
}
