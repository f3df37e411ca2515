//! Boundary conditions. Every condition reduces, per face, to
//!
//! `face value = offset + slope * cell value - normal * (cell value . n) n`,
//!
//! where the last part is there for vectors only: Dirichlet is `(v, 0, 0)`, zero gradient
//! `(0, 1, 0)`, slip `(0, 1, 1)`, partial slip and Robin anything in between. One virtual call
//! per patch and update; the loops over faces see three arrays.
//!
//! To add a condition: one file here with its parameters, its `read`, its `update` and a test on
//! a small patch, and one line in [`ALL`].

mod basic;
mod contact_angle;
mod context;
mod coulomb_friction;
mod expression;
mod expression_mixed;
mod flow_direction;
mod flow_rate;
mod freestream;
mod hydrostatic;
mod local_fluidity;
mod mapped;
mod mean;
mod mixed;
mod moving_wall;
mod normal_part;
mod phase_mean;
mod pressure;
mod pressure_inlet;
mod profile;
mod read;
mod refused;
mod registry;
mod rotating;
mod scaled;
mod slip;
mod surface_normal;
mod swirl;
#[cfg(test)]
mod testing;
mod total_pressure;
mod uniform;
mod variable_height;
mod wave;

pub use basic::{FixedGradient, FixedValue, ZeroGradient};
pub use contact_angle::{ConstantAlphaContactAngle, ContactLimit};
pub use context::{CaseContext, CaseFiles, NoCaseFiles, PatchContext, WavePatch};
pub use coulomb_friction::CoulombFriction;
pub use flow_direction::InletOutlet;
pub use flow_rate::{FlowRate, FlowRateInlet, FlowRateOutlet};
pub use local_fluidity::LocalFluidity;
pub use pressure::{FixedFluxPressure, PrghPressure};
pub use refused::{REFUSED, Reason, Refused, refused};
pub use registry::{ALL, Entry, read_scalar, read_vector};
pub use rotating::RotatingWall;
pub use slip::Slip;
pub use total_pressure::TotalPressure;
pub use uniform::UniformFixedValue;
pub use variable_height::{VariableHeightFlowRate, VariableHeightFlowRateInlet};
pub use wave::{WaveAlpha, WaveVelocity};

pub(crate) use basic::text as value_text;
use granflow_base::{Value, Vec3};
use std::ops::Range;

/// Coefficients of the closure over all boundary faces.
#[derive(Clone, Debug)]
pub struct Affine<T> {
    /// Constant part, units of the field.
    pub offset: Vec<T>,
    /// Share of the cell value, 0 (fixed) to 1 (free).
    pub slope: Vec<f64>,
    /// Share of the cell value's normal part that is taken away (vectors at slip walls).
    pub normal: Vec<f64>,
}

impl<T: Value> Affine<T> {
    /// Zero gradient on `n` faces.
    pub fn zero_gradient(n: usize) -> Self {
        Affine { offset: vec![T::ZERO; n], slope: vec![1.0; n], normal: vec![0.0; n] }
    }
    /// The part over the boundary faces `range`.
    pub fn patch(&mut self, range: Range<usize>) -> PatchClosure<'_, T> {
        PatchClosure {
            offset: &mut self.offset[range.clone()],
            slope: &mut self.slope[range.clone()],
            normal: &mut self.normal[range],
        }
    }
}

/// The closure of one patch, for a condition to fill.
pub struct PatchClosure<'a, T> {
    /// See [`Affine::offset`].
    pub offset: &'a mut [T],
    /// See [`Affine::slope`].
    pub slope: &'a mut [f64],
    /// See [`Affine::normal`].
    pub normal: &'a mut [f64],
}

impl<T: Value> PatchClosure<'_, T> {
    /// `v` on every face.
    pub fn fix(&mut self, v: T) {
        self.offset.fill(v);
        self.slope.fill(0.0);
        self.normal.fill(0.0);
    }
    /// Zero gradient on every face.
    pub fn free(&mut self) {
        self.offset.fill(T::ZERO);
        self.slope.fill(1.0);
        self.normal.fill(0.0);
    }
}

/// What surrounds a field at the time of an update: explicit inputs in place of a registry.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings<'a> {
    /// Time, s.
    pub time: f64,
    /// Gravity that acts through p_rgh, m/s2.
    pub gravity: Vec3,
    /// Density in the cells, kg/m3; empty where no condition of the field asks for it.
    pub density: &'a [f64],
    /// Normal gradient that makes the flux through a face match the velocity condition, over all
    /// boundary faces (for `fixedFluxPressure`); empty where it does not apply.
    pub flux_gradient: &'a [f64],
    /// Normal gradient of a volume fraction that contact angles ask for, over all boundary faces,
    /// 1/m; empty where there is no interface.
    pub contact_gradient: &'a [f64],
    /// `rho U^2/2` on all boundary faces, Pa (for total pressures); empty where it does not apply.
    pub dynamic_pressure: &'a [f64],
    /// Velocity on all boundary faces, m/s (for pressures that depend on it); empty where it does not
    /// apply.
    pub face_velocity: &'a [Vec3],
    /// Pressure on all boundary faces, Pa (for walls with friction); empty where there are none.
    pub wall_pressure: &'a [f64],
    /// Viscosity there, Pa s.
    pub wall_viscosity: &'a [f64],
    /// Viscosity of a fluid that fills part of a face, times that part, Pa s; empty where none does.
    pub wall_fluid: &'a [f64],
    /// Which way boundary faces slid in the last pass of an iteration (any length; zero: not at
    /// all); empty outside of one.
    pub slid: &'a [Vec3],
    /// Local fluidity over all cells, 1/s (for `localFluidity`).
    pub local_fluidity: &'a [f64],
    /// Volume fraction of fluid 1 in the cells (for waves); empty with one fluid.
    pub fraction: &'a [f64],
    /// The same on all boundary faces; empty with one fluid.
    pub face_fraction: &'a [f64],
}

/// What a condition sees of its patch.
pub struct PatchView<'a, T> {
    /// Faces of the patch in the mesh.
    pub faces: Range<usize>,
    /// 1 / distance of the cell centre from the face plane, 1/m.
    pub inv_dist: &'a [f64],
    /// Outward area vectors, m2.
    pub area: &'a [Vec3],
    /// Outward unit normals.
    pub normal: &'a [Vec3],
    /// Face centres, m.
    pub centre: &'a [Vec3],
    /// The cell behind each face.
    pub owner: &'a [u32],
    /// Centres of all cells, m.
    pub owner_centre: &'a [Vec3],
    /// The field's values in all cells.
    pub cells: &'a [T],
    /// Outward flux through the faces, where the field is transported.
    pub flux: Option<&'a [f64]>,
    /// What [`Condition::totals`] gave, summed over all ranks.
    pub totals: &'a [f64],
    /// Everything else.
    pub around: &'a Surroundings<'a>,
}

impl<T> PatchView<'_, T> {
    /// Index of the patch's first face among the boundary faces.
    pub fn first_boundary(&self, n_inner: usize) -> usize {
        self.faces.start - n_inner
    }
}

/// What an update found at fault: a formula that gave what cannot be.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The entry.
    pub key: &'static str,
    /// The formula, what it gave, where and when.
    pub text: String,
}

/// A boundary condition on one patch.
pub trait Condition<T>: Send + Sync {
    /// The name in the field file.
    fn name(&self) -> &'static str;
    /// How many sums over the faces of the patch [`Self::update`] needs of all ranks together.
    fn n_totals(&self) -> usize {
        0
    }
    /// Adds the sums of this rank to `out`; those of all ranks come back in [`PatchView::totals`].
    fn totals(&self, _: &PatchView<'_, T>, _out: &mut [f64]) {}
    /// Fills the closure of the patch.
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>);
    /// The angle at which an interface meets the wall, through fluid 1, if the condition gives one,
    /// radians.
    fn contact_angle(&self) -> Option<f64> {
        None
    }
    /// The friction coefficient of a wall and its velocity in m/s, if it holds by friction.
    fn friction(&self) -> Option<(f64, Vec3)> {
        None
    }
    /// Whether the condition pins the level of the field (so that no reference cell is needed).
    fn fixes_value(&self) -> bool {
        false
    }
    /// Whether the value is given on all faces at all times, whatever the flow does.
    fn gives_value(&self) -> bool {
        self.fixes_value()
    }
    /// Whether an update may find what the condition was given at fault.
    fn may_fail(&self) -> bool {
        false
    }
    /// What the last update found at fault.
    fn fault(&self) -> Option<&Fault> {
        None
    }
    /// The entries of the patch in the field file, as the user gave them (restart needs them).
    fn entries(&self) -> Vec<(String, String)>;
}

/// The condition on patches without closure of their own (cyclic, wedge, processor, empty,
/// symmetry): named after the patch type, as OpenFOAM's files do.
pub struct OfPatchType {
    /// The patch type.
    pub kind: &'static str,
    /// Whether the normal part of a vector vanishes (symmetry).
    pub symmetric: bool,
}

impl<T: Value> Condition<T> for OfPatchType {
    fn name(&self) -> &'static str {
        self.kind
    }
    fn update(&mut self, _: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        if self.symmetric {
            closure.normal.fill(1.0);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
