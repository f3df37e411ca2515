//! Rheologies by OpenFOAM's `transportModel` names.
//!
//! To add a local one: a file with its parameters, `read`, the law and its tests, and one line in
//! [`ALL`]; see `power_law.rs` for the shortest example.

mod beyond;
mod bingham;
mod bird_carreau;
mod casson;
mod cross_power_law;
mod herschel_bulkley;
mod limited;
mod mu_i;
mod newtonian;
mod ngf;
mod power_law;

pub use beyond::Beyond;
pub use bingham::Bingham;
pub use bird_carreau::BirdCarreau;
pub use casson::Casson;
pub use cross_power_law::CrossPowerLaw;
pub use herschel_bulkley::HerschelBulkley;
pub use mu_i::{Floors, Granular, MuI, MuIRegularised};
pub use newtonian::Newtonian;
pub use ngf::{Form, Law, Ngf, NgfNumerics};
pub use power_law::PowerLaw;

use granflow_base::{Dims, Tensor};
use granflow_dict::Reader;
use granflow_fv::{CellField, Condition, DimError, FaceField};
use granflow_linsolve::SolveError;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// One point of a flow.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// `sqrt(2 D:D)`, 1/s.
    pub strain_rate: f64,
    /// Pressure between grains, Pa.
    pub pressure: f64,
    /// Density, kg/m3.
    pub density: f64,
}

/// Relative step of the central differences of a law: their error is its square.
const DIFFERENCE: f64 = 1e-4;

/// Many points of a flow of one density.
pub struct Points<'a> {
    /// `sqrt(2 D:D)`, 1/s.
    pub strain_rate: &'a [f64],
    /// Pressure between grains, Pa.
    pub pressure: &'a [f64],
    /// Density, kg/m3.
    pub density: f64,
}

/// What a local law has at many points.
pub struct LawValues<'a> {
    /// Dynamic viscosity, Pa s.
    pub viscosity: &'a mut [f64],
    /// As [`LocalLaw::slopes`].
    pub slopes: &'a mut [[f64; 2]],
}

/// A law that needs nothing but the point.
pub trait LocalLaw: Send + Sync {
    /// Dynamic viscosity, Pa s; finite and positive for any strain rate, zero included.
    fn viscosity(&self, at: Point) -> f64;
    /// `d ln(viscosity)/d ln(strain rate)`, and `d ln(viscosity)/d pressure` in 1/Pa: central
    /// differences, unless a law knows better.
    fn slopes(&self, at: Point) -> [f64; 2] {
        let ln = |at: Point| self.viscosity(at).ln();
        let step = |k: f64| Point { strain_rate: at.strain_rate * k, ..at };
        let (up, down) = (1.0 + DIFFERENCE, 1.0 - DIFFERENCE);
        let rate = (ln(step(up)) - ln(step(down))) / (up.ln() - down.ln());
        let pressure = if self.reads_pressure() && at.pressure != 0.0 {
            let step = |k: f64| Point { pressure: at.pressure * k, ..at };
            (ln(step(up)) - ln(step(down))) / (2.0 * DIFFERENCE * at.pressure)
        } else {
            0.0
        };
        [rate, pressure]
    }
    /// Whether the viscosity is the same everywhere and always.
    fn is_constant(&self) -> bool {
        false
    }
    /// Whether the law reads the pressure (granular laws do).
    fn reads_pressure(&self) -> bool {
        false
    }
    /// The grains, when the material is made of grains whose friction is bounded by mu_2.
    fn grains(&self) -> Option<Granular> {
        None
    }
    /// Whether the equations of motion are ill-posed there, for a law that is so somewhere; none
    /// where the material does not yield.
    fn is_ill_posed(&self, _at: Point) -> Option<bool> {
        None
    }
}

/// What a rheology may read, spelled out: there is no registry to look fields up in.
#[derive(Clone, Copy)]
pub struct FlowView<'a> {
    /// Threads and ranks.
    pub exec: &'a Exec,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Time at the end of the step, s.
    pub time: f64,
    /// Time step, s; without inertia [`FlowView::FOREVER`] or more.
    pub dt: f64,
    /// Strain rate in the cells, 1/s: the mean stress of the cell over its viscosity where the
    /// model owns a field, the mean over the cell's faces where it is local.
    pub strain_rate: &'a [f64],
    /// Magnitude of the cells' mean viscous stress, Pa, where it is known: not before the first
    /// momentum solve of a step, and not for local laws, which say it themselves.
    pub stress: Option<&'a [f64]>,
    /// Pressure between grains, Pa.
    pub pressure: &'a [f64],
    /// Density, kg/m3.
    pub density: &'a [f64],
    /// Volume flux of the material through the faces, m3/s.
    pub flux: &'a FaceField<f64>,
    /// How much of each cell is this material, where it shares the space with another; else all.
    pub share: Option<Share<'a>>,
}

/// Share of a material in the cells, from 0 to 1. What lives in the material alone (a fluidity) has
/// no flux through its surface: volumes count by their share, faces by that of both their cells.
#[derive(Clone, Copy, Debug)]
pub struct Share<'a> {
    /// Now, cells and ghosts.
    pub now: &'a [f64],
    /// At the beginning of the step.
    pub old: &'a [f64],
}

impl Share<'_> {
    /// Less of a cell than this is none: what so little material does has no weight in the mixture.
    pub const NONE: f64 = 1e-3;
}

impl FlowView<'_> {
    /// A step of such a length, s, has no inertia: a steady state is looked for.
    pub const FOREVER: f64 = 1e30;

    /// The material's share of cell or ghost `c`.
    #[inline]
    pub fn share(&self, c: usize) -> f64 {
        self.share.map_or(1.0, |s| s.now[c])
    }
    /// Whether there is any of the material in cell or ghost `c`.
    #[inline]
    pub fn has(&self, c: usize) -> bool {
        self.share(c) >= Share::NONE
    }
    /// The flow in cell `c`.
    pub fn point(&self, c: usize) -> Point {
        Point {
            strain_rate: self.strain_rate[c],
            pressure: self.pressure[c],
            density: self.density[c],
        }
    }
}

/// Cells in which the material yields, and those of them where the law makes the equations of motion
/// ill-posed: disturbances grow there without bounds as the mesh is refined. Of all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Posedness {
    /// Cells that yield.
    pub yielded: usize,
    /// Those that are ill-posed.
    pub ill_posed: usize,
}

/// What one evaluation did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RheologyInfo {
    /// Linear solves of the model's own equation.
    pub solves: usize,
    /// Iterations of those solves.
    pub iterations: usize,
    /// Solves that ran out of iterations.
    pub unconverged: usize,
    /// Residual of the model's own equation at the returned state (0 for local laws).
    pub residual: f64,
    /// Cells that asked for more friction than grains have, if any did.
    pub beyond: Option<Beyond>,
    /// Where the law is ill-posed (none of a law that never is).
    pub posedness: Posedness,
}

/// Why a rheology gave no viscosity.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RheologyError {
    /// Its own linear system was not solved.
    #[error("the equation for `{field}` was not solved: {source}")]
    Solve {
        /// The field.
        field: &'static str,
        /// What the solver said.
        source: SolveError,
    },
    /// Its own equation was written wrongly.
    #[error(transparent)]
    Dims(#[from] DimError),
}

/// The viscosity of a flow.
pub trait Rheology: Send {
    /// Viscosity in the cells (own cells; the caller fills ghosts) for the flow as it stands.
    ///
    /// # Errors
    /// [`RheologyError`] when an equation of the model's own is not solved.
    fn update(
        &mut self,
        view: &FlowView<'_>,
        eta: &mut CellField<f64>,
    ) -> Result<RheologyInfo, RheologyError>;
    /// Called when a time step begins: old-time values of the model's own fields are set here.
    fn begin_step(&mut self) {}
    /// To be called before the outcome of a pass is believed: true where the last update followed from the
    /// one before, and not from the flow alone; the next one will not.
    fn doubt(&mut self) -> bool {
        false
    }
    /// Takes the model's own fields back to where [`Self::begin_step`] found them.
    fn rollback(&mut self) {}
    /// Drops what the model's own fields hold as a guess of what comes; history stays.
    fn forget(&mut self) {}
    /// The viscosity that belongs to the model's own fields as they are, without solving; returns
    /// false when the model has none and the flow must be asked.
    fn recall(&mut self, _view: &FlowView<'_>, _eta: &mut CellField<f64>) -> bool {
        false
    }
    /// For a model whose viscosity depends on nothing but the strain rate and the pressure of the
    /// place: that viscosity at any points, faces for example, with the slopes of its logarithm.
    /// False for other models.
    fn at_points(&self, _exec: &Exec, _points: &Points<'_>, _out: LawValues<'_>) -> bool {
        false
    }
    /// Whether [`Self::at_points`] knows.
    fn is_local(&self) -> bool {
        false
    }
    /// Whether the viscosity never changes, so that nothing is iterated for its sake.
    fn is_constant(&self) -> bool {
        false
    }
    /// Whether the viscosity depends on the pressure.
    fn reads_pressure(&self) -> bool {
        false
    }
    /// The model's own field, if it has one: part of the state that a restart needs.
    fn field(&self) -> Option<&CellField<f64>> {
        None
    }
    /// The same, to be filled when a case is loaded.
    fn field_mut(&mut self) -> Option<&mut CellField<f64>> {
        None
    }
    /// Conditions of the model's own field by patch, for its file.
    fn conditions(&self) -> &[Box<dyn Condition<f64>>] {
        &[]
    }
    /// The grains, when the material is made of grains (inertial number, stress ratio).
    fn grains(&self) -> Option<Granular> {
        None
    }
}

/// A local law as a rheology.
pub struct Local<L: ?Sized>(pub Box<L>);

impl<L: LocalLaw + ?Sized> Rheology for Local<L> {
    fn update(
        &mut self,
        v: &FlowView<'_>,
        eta: &mut CellField<f64>,
    ) -> Result<RheologyInfo, RheologyError> {
        v.exec.for_each(&mut eta.data[..v.mesh.n_cells], |first, out| {
            for (i, eta) in out.iter_mut().enumerate() {
                *eta = self.0.viscosity(v.point(first + i));
            }
        });
        let grains = self.0.grains();
        let beyond = grains.and_then(|g| beyond::beyond(v, &g));
        let mut posedness = Posedness::default();
        if grains.is_some() {
            let of = |c| match self.0.is_ill_posed(v.point(c)) {
                Some(ill) => [1.0, f64::from(u8::from(ill))],
                None => [0.0; 2],
            };
            let [yielded, ill_posed] = v.exec.sums(v.mesh.n_cells, |r| {
                r.map(of).fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y])
            });
            posedness = Posedness { yielded: yielded as usize, ill_posed: ill_posed as usize };
        }
        Ok(RheologyInfo { beyond, posedness, ..RheologyInfo::default() })
    }
    fn at_points(&self, exec: &Exec, points: &Points<'_>, out: LawValues<'_>) -> bool {
        let LawValues { viscosity, slopes } = out;
        exec.for_each2(viscosity, slopes, |first, viscosity, slopes| {
            for i in 0..viscosity.len() {
                let at = Point {
                    strain_rate: points.strain_rate[first + i],
                    pressure: points.pressure[first + i],
                    density: points.density,
                };
                (viscosity[i], slopes[i]) = (self.0.viscosity(at), self.0.slopes(at));
            }
        });
        true
    }
    fn is_local(&self) -> bool {
        true
    }
    fn is_constant(&self) -> bool {
        self.0.is_constant()
    }
    fn reads_pressure(&self) -> bool {
        self.0.reads_pressure()
    }
    fn grains(&self) -> Option<Granular> {
        self.0.grains()
    }
}

/// What reading a rheology may depend on.
pub struct FluidContext<'a> {
    /// Density of the fluid, kg/m3 (1 where the case is kinematic).
    pub density: f64,
    /// Threads and ranks.
    pub exec: &'a Exec,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Conditions of `fluidity`, one per patch; taken by the model that has the field.
    pub fluidity_conditions: Vec<Box<dyn Condition<f64>>>,
    /// How the fluidity equation is solved.
    pub numerics: NgfNumerics,
}

/// One rheology of the registry.
pub struct Entry {
    /// The word behind `transportModel`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// The law, as a reader would write it.
    pub formula: &'static str,
    /// Source.
    pub reference: &'static str,
    /// Reads `<name>Coeffs` (or the surrounding dictionary where there is none).
    pub read: fn(&Reader<'_>, FluidContext<'_>) -> Box<dyn Rheology>,
}

/// Every rheology.
pub const ALL: &[Entry] = &[
    newtonian::ENTRY,
    power_law::ENTRY,
    bingham::ENTRY,
    herschel_bulkley::ENTRY,
    casson::ENTRY,
    cross_power_law::ENTRY,
    bird_carreau::ENTRY,
    mu_i::ENTRY,
    mu_i::ENTRY_REGULARISED,
    ngf::ENTRY,
];

/// Reads the fluid's `transportModel` and its coefficients from `phase`.
pub fn read(phase: &Reader<'_>, context: FluidContext<'_>) -> Box<dyn Rheology> {
    let known: Vec<(&str, &Entry)> = ALL.iter().map(|e| (e.name, e)).collect();
    let entry = phase.one_of("transportModel", &known);
    // OpenFOAM's cases carry the coefficients of models that are not in use.
    for other in ALL.iter().filter(|e| e.name != entry.name) {
        phase.ignore(&format!("{}Coeffs", other.name));
    }
    match phase.opt_sub(&format!("{}Coeffs", entry.name)) {
        Some(coeffs) => (entry.read)(&coeffs, context),
        None => (entry.read)(phase, context),
    }
}

/// Dynamic from kinematic: OpenFOAM's generalised Newtonian laws are written in m2/s.
fn local<L: LocalLaw + 'static>(law: L) -> Box<dyn Rheology> {
    Box::new(Local(Box::new(law)))
}

/// tau0 in OpenFOAM's kinematic stress, m2/s2.
const KINEMATIC_STRESS: Dims = Dims::KINEMATIC_PRESSURE;

/// `sqrt(tau:tau/2)` of a symmetric tensor.
#[inline]
pub fn magnitude(tau: &Tensor) -> f64 {
    (0.5 * granflow_base::double_dot(tau, tau)).sqrt()
}
