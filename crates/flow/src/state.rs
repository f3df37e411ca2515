//! What a restart file holds, how to solve, and what a step reports.

use crate::vof::{VofError, VofReport};
use granflow_base::Vec3;
use granflow_fv::{Convection, FaceField, Gradient, GradientLimiter, Unknown};
use granflow_linsolve::{LinearSolver, SolveError, Solved, Tolerance};
use granflow_physics::rheology::Beyond;
use granflow_physics::{Rheology, RheologyError, RheologyInfo};
use std::sync::Arc;

/// Exactly what a restart file holds: nothing here follows from the rest, and what is not here
/// may be garbage between steps. (The rheology's own field, fluidity, is part of it and lives
/// with its model.)
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Steps since time zero.
    pub step: usize,
    /// Velocity, m/s.
    pub u: Unknown<Vec3>,
    /// Velocity one step earlier (backward differences), or what the Crank-Nicolson scheme puts in
    /// its place, m/s.
    pub u_old: Vec<Vec3>,
    /// Length of the last step, s; 0 before the first.
    pub dt_old: f64,
    /// Pressure p, or p_rgh = p - rho G.x where gravity acts, Pa.
    pub p: Unknown<f64>,
    /// Volume flux through the faces, m3/s.
    pub phi: FaceField<f64>,
    /// The same of the volume flux, m3/s.
    pub phi_old: Vec<f64>,
    /// Volume fraction of fluid 1 where there are two.
    pub alpha: Option<Unknown<f64>>,
}

/// The material: one fluid of constant density, the first where there are two.
pub struct Fluid {
    /// Density, kg/m3.
    pub rho: f64,
    /// Its stress.
    pub rheology: Box<dyn Rheology>,
}

/// Forces on the bulk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gravity {
    /// The part of gravity that p_rgh absorbs, m/s2.
    pub hydrostatic: Vec3,
    /// The part along cyclic directions: a body force, m/s2.
    pub driving: Vec3,
}

/// Time scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeScheme {
    /// Implicit Euler, first order.
    Euler,
    /// Backward differences over two steps (Gear 1971), second order.
    Backward,
    /// J. Crank, P. Nicolson, Math. Proc. Camb. Phil. Soc. 43 (1947) 50; the number is OpenFOAM's:
    /// 1 is the trapezoidal rule, second order, 0 is Euler.
    CrankNicolson(f64),
    /// Euler with a step of its own for every cell, towards a steady state.
    Local(LocalSteps),
    /// No time derivative: a step finds the steady state of the conditions at its end.
    Steady,
}

/// Steps of their own for every cell (`localEuler`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSteps {
    /// Courant number of each cell's step.
    pub courant: f64,
    /// The longest, s.
    pub longest: f64,
    /// A step exceeds that of a neighbour by at most this share.
    pub growth: f64,
}

impl TimeScheme {
    /// Whether a step needs the velocity and flux of the step before the last.
    pub fn remembers_two(self) -> bool {
        matches!(self, TimeScheme::Backward | TimeScheme::CrankNicolson(_))
    }
}

/// A system's solver with its tolerances. These end the solves of a single pass (PISO); where momentum
/// and continuity are solved together the solver preconditions, to an accuracy that is fixed.
pub struct Solve<T> {
    /// The solver, with its work arrays.
    pub solver: Box<dyn LinearSolver<T>>,
    /// Tolerance of inner corrections.
    pub tolerance: Tolerance,
    /// Tolerance of the last correction of a step.
    pub last: Tolerance,
}

/// When an outer iteration is converged: residuals of one and the same state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualControl {
    /// Momentum: force imbalance over force.
    pub u: f64,
    /// Continuity: net over gross flux of the cells.
    pub p: f64,
    /// Viscosity: greatest change of its logarithm that one more evaluation would make.
    pub viscosity: f64,
}

impl Default for ResidualControl {
    fn default() -> Self {
        ResidualControl { u: 1e-8, p: 1e-8, viscosity: 1e-7 }
    }
}

/// A normal derivative on faces whose line of centres leans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalDerivative {
    /// What the correction may be of the whole: 1 corrected, 0.5 at most as much as the difference of
    /// the cells, 0 none.
    pub limit: f64,
    /// Whether that difference is over the distance of the centres, and not over its part along the normal.
    pub orthogonal: bool,
}

/// How to solve, never what: from `fvSchemes` and `fvSolution`.
pub struct Numerics {
    /// Time scheme.
    pub ddt: TimeScheme,
    /// Convection of velocity.
    pub convection: Convection,
    /// Cell gradients.
    pub gradient: Gradient,
    /// The same of the pressure.
    pub gradient_p: Gradient,
    /// Limiter of the gradient that convection extrapolates with; pressure and stress have theirs
    /// whole.
    pub limiter: Option<GradientLimiter>,
    /// Non-orthogonal correction: 1 corrected, 0.5 limited, 0 none.
    pub non_orthogonal: f64,
    /// Normal derivatives of density and fraction on faces, and in momentum that of the pressure beside
    /// them, where they are not the Laplacian's; of two fluids.
    pub sn_grad: Option<NormalDerivative>,
    /// Whether a single pass has the forms of OpenFOAM's PISO solvers, of two fluids `interFoam`'s, in place of ours.
    pub compatible: bool,
    /// Most outer iterations of a step.
    pub outer: usize,
    /// Pressure corrections of a single pass (PISO).
    pub correctors: usize,
    /// Repetitions of such a correction for non-orthogonality.
    pub non_orthogonal_correctors: usize,
    /// Whether a single pass solves momentum before the pressure (else only corrects).
    pub predictor: bool,
    /// When to stop the outer iterations early.
    pub control: ResidualControl,
    /// Momentum.
    pub u: Solve<Vec3>,
    /// Pressure.
    pub p: Solve<f64>,
    /// The part of the pressure that answers compression where viscosity rules.
    pub compression: Box<dyn LinearSolver<f64>>,
    /// Cell and value of the pressure level where no boundary fixes it; the cell lives on the
    /// rank that has `Some`.
    pub reference: Option<(usize, f64)>,
    /// The level that belongs to `reference`, known on every rank, Pa.
    pub reference_value: f64,
}

/// Residuals of one state: momentum, continuity and viscosity with up-to-date fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// Force imbalance over force.
    pub u: f64,
    /// Net over gross flux of the cells.
    pub p: f64,
    /// Greatest change of ln(viscosity) in one more evaluation of the rheology.
    pub viscosity: f64,
}

impl Residuals {
    /// Whether all are within `control`.
    pub fn within(&self, control: &ResidualControl) -> bool {
        self.u <= control.u && self.p <= control.p && self.viscosity <= control.viscosity
    }
}

/// How many linear systems were solved, and how many of them not to their tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolveCount {
    /// All solves.
    pub all: usize,
    /// Those that ended at `maxIter`.
    pub unconverged: usize,
}

impl std::ops::AddAssign for SolveCount {
    fn add_assign(&mut self, other: SolveCount) {
        self.all += other.all;
        self.unconverged += other.unconverged;
    }
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Time at its end, s.
    pub time: f64,
    /// Its length, s.
    pub dt: f64,
    /// Outer iterations.
    pub outer: usize,
    /// Whether momentum and continuity were solved together: the linear solves are then part of a
    /// preconditioner, and `maxIter` has no say in them.
    pub coupled: bool,
    /// Whether the residuals met the control.
    pub converged: bool,
    /// Whether this is a steady state, found without the time derivative.
    pub steady: bool,
    /// Residuals at its end.
    pub residuals: Residuals,
    /// First and last momentum solve.
    pub u: Option<(Solved, Solved)>,
    /// First and last pressure solve.
    pub p: Option<(Solved, Solved)>,
    /// Iterations of all momentum and of all pressure solves.
    pub iterations: [usize; 2],
    /// Linear solves of momentum and of pressure, and how many ran out of iterations.
    pub solves: [SolveCount; 2],
    /// The rheology's own work, summed over the step.
    pub rheology: RheologyInfo,
    /// Courant numbers, half the flux through a cell's faces times the step over its volume: mean over
    /// the volume, and the greatest.
    pub courant: [f64; 2],
    /// Greatest change of velocity in the step over the greatest velocity.
    pub change: f64,
    /// How the interface moved, where there are two fluids.
    pub vof: Option<VofReport>,
}

/// Why a step failed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StepError {
    /// An equation was written wrongly.
    #[error(transparent)]
    Dims(#[from] granflow_fv::DimError),
    /// A linear system was not solved.
    #[error("{field}: {source} at time {time}")]
    Solve {
        /// The unknown.
        field: &'static str,
        /// Time, s.
        time: f64,
        /// What the solver said.
        source: SolveError,
    },
    /// The rheology gave no viscosity.
    #[error("viscosity at time {time}: {source}")]
    Rheology {
        /// Time, s.
        time: f64,
        /// What the model said.
        source: RheologyError,
    },
    /// The volume fraction could not be moved.
    #[error("volume fraction at time {time}: {source}")]
    Interface {
        /// Time, s.
        time: f64,
        /// What the method said.
        source: Arc<VofError>,
    },
    /// Friction is used up somewhere, and the computation failed over it.
    #[error(
        "the friction of the grains is used up at time {time}: mu = {:.4} (I = {:.3}) in cell {} at \
         ({}, {}, {}), and mu_2 = {} is all they have, so that no steady flow exists there \
         (cells like it: {}); it showed as: {seen}",
        beyond.mu, beyond.inertial, beyond.cell, beyond.place[0], beyond.place[1],
        beyond.place[2], beyond.mu_2, beyond.cells
    )]
    Beyond {
        /// Time, s.
        time: f64,
        /// Where, and by how much.
        beyond: Beyond,
        /// What was seen of it.
        seen: Box<StepError>,
    },
    /// The outer iteration ended in a state that is no flow.
    #[error(
        "the outer iteration ended at time {time} in what is no flow: its forces are out of balance by {:.1} \
         times their size, and a pass changes the viscosity by a factor of {:.1e}",
        residuals.u, residuals.viscosity.min(700.0).exp()
    )]
    NoFlow {
        /// Time, s.
        time: f64,
        /// Of the state it ended in.
        residuals: Residuals,
    },
    /// No steady state was found.
    #[error(
        "no steady state was found at time {time}, neither directly nor by relaxation in pseudo-time (the nearest: \
         momentum {:.1e}, continuity {:.1e}, viscosity {:.1e}); the flow may have none: march in time \
         (`ddtSchemes {{ default Euler; }}`) to see what it does",
        residuals.u, residuals.p, residuals.viscosity
    )]
    NoSteadyState {
        /// Time, s.
        time: f64,
        /// Of the state that came nearest.
        residuals: Residuals,
    },
    /// The equations of the cells have a solution, but walls with friction beside them ask for more.
    #[error(
        "a solution of the cells' equations (momentum {:.1e}) whose grains slide along a wall with more stress \
         than they carry: a finer mesh would not have it",
        residuals.u
    )]
    AtWalls {
        /// Time, s.
        time: f64,
        /// Of that solution.
        residuals: Residuals,
    },
    /// The outer iteration ran away from the flow.
    #[error(
        "the outer iteration diverged at time {time} (residuals: momentum {:.1e}, continuity {:.1e}): start \
         from a field nearer to the flow, or with shorter steps; it showed as: {seen}",
        residuals.u, residuals.p
    )]
    Diverged {
        /// Time, s.
        time: f64,
        /// Of the last state before numbers ran out.
        residuals: Residuals,
        /// What was seen of it.
        seen: Box<StepError>,
    },
    /// A condition was given what cannot be.
    #[error("{field} on patch `{patch}`: {fault}")]
    Condition {
        /// The field.
        field: &'static str,
        /// The patch.
        patch: String,
        /// The formula, what it gave and where.
        fault: String,
        /// Time, s.
        time: f64,
    },
    /// The flow was asked to stop; the state is that before the step.
    #[error("stopped on request at time {time}")]
    Interrupted {
        /// Time before the step, s.
        time: f64,
    },
    /// A field is no longer a number on another rank.
    #[error("a field is no longer finite on another rank, time {time}")]
    Elsewhere {
        /// Time, s.
        time: f64,
    },
    /// A field is no longer a number.
    #[error(
        "{field} is no longer finite in cell {cell} at ({}, {}, {}), time {time}: {cause}",
        place[0], place[1], place[2]
    )]
    NotFinite {
        /// The field.
        field: &'static str,
        /// Cell of the undecomposed mesh.
        cell: usize,
        /// Its centre, m.
        place: Vec3,
        /// Time, s.
        time: f64,
        /// The likely cause.
        cause: &'static str,
    },
}
