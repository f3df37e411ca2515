//! The conditions by name: one line each feeds the reader, the message about unknown names,
//! `granflow list conditions` and the book.

use super::{
    Condition, ConstantAlphaContactAngle, ContactLimit, CoulombFriction, FixedFluxPressure,
    FixedGradient, FixedValue, FlowRateInlet, FlowRateOutlet, InletOutlet, LocalFluidity,
    OfPatchType, PressureInletOutletVelocity, PrghPressure, RotatingWall, Slip, TimeTable,
    TotalPressure, UniformFixedValue, VariableHeightFlowRate, VariableHeightFlowRateInlet,
    WaveAlpha, WaveVelocity, ZeroGradient,
};
use crate::waves::{Frame, Source};
use granflow_base::{Dims, Value, Vec3, norm, unit};
use granflow_dict::{CONSTRAINT_TYPES, Dict, FieldValue, Reader, Sink};
use granflow_mesh::PatchKind;

/// What reading a condition may depend on.
#[derive(Clone, Copy, Debug)]
pub struct PatchContext<'a> {
    /// Name of the patch.
    pub patch: &'a str,
    /// Its kind in the mesh.
    pub kind: &'a PatchKind,
    /// Its number of faces (on all ranks together for uniform values this does not matter).
    pub n_faces: usize,
    /// Number of inner faces of the mesh.
    pub n_inner: usize,
    /// Dimensions of the field.
    pub dims: Dims,
    /// Waves at the patch; `None` where there are none, or before the depth of the water is known.
    pub wave: Option<WavePatch<'a>>,
}

/// Waves at a patch, checked.
#[derive(Clone, Copy, Debug)]
pub struct WavePatch<'a> {
    /// The patch's entry of `waveProperties`.
    pub entry: &'a Dict,
    /// Directions, extent and still water of the whole patch.
    pub frame: Frame,
    /// Of the patch's faces the lowest and highest point over the patch's lowest, m.
    pub spans: &'a [[f64; 2]],
    /// Their centres, m.
    pub centres: &'a [Vec3],
}

impl WavePatch<'_> {
    /// What the conditions need. Mistakes were reported when the entry was checked.
    fn source(&self) -> Source {
        let silent = Sink::new();
        let r = Reader::new(self.entry, &silent);
        Source::read(&r, self.frame).on(self.spans.to_vec(), self.centres)
    }
}

type ReadScalar = fn(&Reader<'_>, &PatchContext<'_>) -> Box<dyn Condition<f64>>;
type ReadVector = fn(&Reader<'_>, &PatchContext<'_>) -> Box<dyn Condition<Vec3>>;

/// One condition of the registry.
pub struct Entry {
    /// The word behind `type`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// Where the definition comes from.
    pub reference: &'static str,
    /// Reader for scalars, if it applies to them.
    pub scalar: Option<ReadScalar>,
    /// Reader for vectors, if it applies to them.
    pub vector: Option<ReadVector>,
}

fn values<T: Value>(r: &Reader<'_>, key: &str, n: usize) -> Vec<T> {
    match r.field::<T>(key, n) {
        FieldValue::Uniform(v) => vec![v],
        FieldValue::NonUniform(v) if v.is_empty() => vec![T::ZERO],
        FieldValue::NonUniform(v) => v,
    }
}
/// Entries that OpenFOAM's own output carries along without meaning for the condition.
fn leave_value(r: &Reader<'_>) {
    r.ignore("value");
}
fn fixed_value<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    Box::new(FixedValue::per_face(values(r, "value", c.n_faces)))
}
fn zero_gradient<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(ZeroGradient)
}
fn fixed_gradient<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(FixedGradient::new(values(r, "gradient", c.n_faces)))
}
fn inlet_outlet<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    r.ignore("phi");
    Box::new(InletOutlet::new(values(r, "inletValue", c.n_faces)))
}
fn uniform_fixed_value<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(UniformFixedValue { value: TimeTable::read(r, "uniformValue", c.dims) })
}
fn slip<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Slip)
}
fn prgh_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("rho");
    Box::new(PrghPressure::new(values(r, "p", c.n_faces)))
}
fn fixed_flux_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    for key in ["gradient", "phi", "rho"] {
        r.ignore(key);
    }
    Box::new(FixedFluxPressure::new(c.n_inner))
}
fn total_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    constant_of_total_pressure(r);
    Box::new(TotalPressure::new(values(r, "p0", c.n_faces), c.n_inner))
}
fn prgh_total_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    constant_of_total_pressure(r);
    Box::new(TotalPressure::with_weight(values(r, "p0", c.n_faces), c.n_inner))
}
/// Names of fields, which are what they are called here, and what only gases have.
fn constant_of_total_pressure(r: &Reader<'_>) {
    for key in ["U", "phi", "rho", "psi", "gamma"] {
        r.ignore(key);
    }
}
fn contact_angle(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("gradient");
    let theta0 = r.in_range("theta0", Dims::NONE, 0.0..=180.0);
    let limit = r.one_of("limit", &ContactLimit::ALL);
    Box::new(ConstantAlphaContactAngle { theta0, limit, n_inner: c.n_inner })
}
fn pressure_inlet_outlet(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    r.ignore("phi");
    if r.has("tangentialVelocity") {
        r.error_at_key(
            "tangentialVelocity",
            "a tangential velocity is not supported",
            "set here",
            None,
        );
    }
    Box::new(PressureInletOutletVelocity)
}
/// `volumetricFlowRate`, the one form whose meaning does not depend on a density.
fn flow_rate(r: &Reader<'_>) -> TimeTable<f64> {
    leave_value(r);
    for key in ["rho", "rhoInlet", "rhoOutlet"] {
        r.ignore(key);
    }
    if r.has("massFlowRate") {
        let help = "give the volume per second: `volumetricFlowRate`";
        r.error_at_key("massFlowRate", "a mass flow rate is not supported", "set here", Some(help));
    }
    if r.opt_switch("extrapolateProfile", false) {
        let message = "a flow rate with an extrapolated profile is not supported";
        r.error_at_key("extrapolateProfile", message, "set here", None);
    }
    TimeTable::read(r, "volumetricFlowRate", Dims::VOLUME_FLUX)
}
fn flow_rate_inlet(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    Box::new(FlowRateInlet { rate: flow_rate(r) })
}
fn flow_rate_outlet(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    Box::new(FlowRateOutlet { rate: flow_rate(r) })
}
fn local_fluidity(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    Box::new(LocalFluidity)
}
fn no_slip(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    Box::new(FixedValue::named("noSlip", [0.0; 3]))
}
fn coulomb_friction(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let mu = r.non_negative("mu", Dims::NONE);
    let wall_velocity = r.vector("wallVelocity", c.dims);
    Box::new(CoulombFriction { mu, wall_velocity, n_inner: c.n_inner })
}
fn rotating_wall(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let origin = r.vector("origin", Dims::LENGTH);
    let axis = r.vector("axis", Dims::NONE);
    if norm(axis) == 0.0 {
        r.error_at_key("axis", "the axis of rotation has no direction", "zero vector", None);
    }
    let omega = TimeTable::read(r, "omega", Dims::RATE);
    Box::new(RotatingWall { origin, axis: unit(axis), omega })
}
fn wave_alpha(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_wave(r);
    Box::new(WaveAlpha { source: c.wave.map(|w| w.source()) })
}
fn wave_velocity(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_wave(r);
    Box::new(WaveVelocity { source: c.wave.map(|w| w.source()) })
}
/// What waves are is in `constant/waveProperties`, whatever the condition's name for that is.
fn leave_wave(r: &Reader<'_>) {
    leave_value(r);
    if r.opt_word("waveDictName", "waveProperties") != "waveProperties" {
        let message = "waves are read from `constant/waveProperties` only";
        r.error_at_key("waveDictName", message, "another file", None);
    }
}
fn variable_height(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("phi");
    let lower = r.in_range("lowerBound", Dims::NONE, 0.0..=1.0);
    let upper = r.in_range("upperBound", Dims::NONE, 0.0..=1.0);
    if lower > upper {
        let message = "the lower bound is above the upper one";
        r.error_at_key("lowerBound", message, "above `upperBound`", None);
    }
    Box::new(VariableHeightFlowRate { lower, upper })
}
fn variable_height_inlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    // The name of the volume fraction, of which there is one.
    r.ignore("alpha");
    let rate = TimeTable::read(r, "flowRate", Dims::VOLUME_FLUX);
    Box::new(VariableHeightFlowRateInlet { rate, n_inner: c.n_inner })
}

/// Every condition, by its OpenFOAM name.
pub const ALL: &[Entry] = &[
    Entry {
        name: "fixedValue",
        summary: "Dirichlet: the value at the face is given",
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(fixed_value),
        vector: Some(fixed_value),
    },
    Entry {
        name: "zeroGradient",
        summary: "Neumann: the face takes the value of the cell",
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(zero_gradient),
        vector: Some(zero_gradient),
    },
    Entry {
        name: "fixedGradient",
        summary: "Neumann: the outward normal gradient is given",
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(fixed_gradient),
        vector: Some(fixed_gradient),
    },
    Entry {
        name: "inletOutlet",
        summary: "zero gradient where the flow leaves, a given value where it enters",
        reference: "H. Jasak, PhD thesis, Imperial College 1996, ch. 3.3",
        scalar: Some(inlet_outlet),
        vector: Some(inlet_outlet),
    },
    Entry {
        name: "uniformFixedValue",
        summary: "Dirichlet: one value for the patch, constant or a table against time",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(uniform_fixed_value),
        vector: Some(uniform_fixed_value),
    },
    Entry {
        name: "slip",
        summary: "no flow through the wall and no traction along it",
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 9",
        scalar: Some(slip),
        vector: Some(slip),
    },
    Entry {
        name: "prghPressure",
        summary: "the pressure p is given; p_rgh = p - rho G.x follows",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(prgh_pressure),
        vector: None,
    },
    Entry {
        name: "fixedFluxPressure",
        summary: "the normal gradient of pressure that makes the flux match the velocity condition",
        reference: "P. M. Gresho, R. L. Sani, Int. J. Numer. Meth. Fluids 7 (1987) 1111",
        scalar: Some(fixed_flux_pressure),
        vector: None,
    },
    Entry {
        name: "totalPressure",
        summary: "the pressure less rho U^2/2 where the flow enters, as it is where it leaves",
        reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.5",
        scalar: Some(total_pressure),
        vector: None,
    },
    Entry {
        name: "prghTotalPressure",
        summary: "totalPressure of p where the field is p_rgh = p - rho G.x",
        reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.5",
        scalar: Some(prgh_total_pressure),
        vector: None,
    },
    Entry {
        name: "constantAlphaContactAngle",
        summary: "of a volume fraction: the interface meets the wall at the angle theta0 (degrees, \
                  through the first fluid)",
        reference: "J. U. Brackbill, D. B. Kothe, C. Zemach, J. Comput. Phys. 100 (1992) 335",
        scalar: Some(contact_angle),
        vector: None,
    },
    Entry {
        name: "localFluidity",
        summary: "of the fluidity: a wall where grains flow as the local law says, g = g_loc",
        reference: "D. L. Henann, K. Kamrin, PNAS 110 (2013) 6730, supporting information",
        scalar: Some(local_fluidity),
        vector: None,
    },
    Entry {
        name: "pressureInletOutletVelocity",
        summary: "where the pressure is given: free where the flow leaves, along the normal where it \
                  enters",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: None,
        vector: Some(pressure_inlet_outlet),
    },
    Entry {
        name: "flowRateInletVelocity",
        summary: "inflow of a given volume per second, the same speed along the normal everywhere, \
                  constant or a table against time",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: None,
        vector: Some(flow_rate_inlet),
    },
    Entry {
        name: "flowRateOutletVelocity",
        summary: "outflow of a given volume per second with the profile that arrives, constant or a \
                  table against time",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: None,
        vector: Some(flow_rate_outlet),
    },
    Entry {
        name: "variableHeightFlowRate",
        summary: "of a volume fraction: the value of the cell, kept within bounds, so that the level at \
                  the patch is that of the water behind it",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(variable_height),
        vector: None,
    },
    Entry {
        name: "variableHeightFlowRateInletVelocity",
        summary: "inflow of a given volume per second through the part of the patch that the first \
                  fluid fills, constant or a table against time",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: None,
        vector: Some(variable_height_inlet),
    },
    Entry {
        name: "waveAlpha",
        summary: "of a volume fraction: the share of each face under the surface of the wave that \
                  `constant/waveProperties` gives for the patch",
        reference: "P. Higuera, J. L. Lara, I. J. Losada, Coastal Eng. 71 (2013) 102",
        scalar: Some(wave_alpha),
        vector: None,
    },
    Entry {
        name: "waveVelocity",
        summary: "the velocity of the wave that `constant/waveProperties` gives for the patch, and \
                  absorption of what arrives",
        reference: "P. Higuera, J. L. Lara, I. J. Losada, Coastal Eng. 71 (2013) 102",
        scalar: None,
        vector: Some(wave_velocity),
    },
    Entry {
        name: "noSlip",
        summary: "the wall stands and holds what touches it: U = 0",
        reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.3",
        scalar: None,
        vector: Some(no_slip),
    },
    Entry {
        name: "coulombFriction",
        summary: "a wall that holds up to the traction mu P; beyond it the material slides and \
                  mu P drags it (no regularisation)",
        reference: "G. Duvaut, J.-L. Lions, Inequalities in Mechanics and Physics, 1976, ch. 3.5",
        scalar: None,
        vector: Some(coulomb_friction),
    },
    Entry {
        name: "rotatingWallVelocity",
        summary: "no slip on a wall that turns about an axis, omega constant or a table against time",
        reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 4.5",
        scalar: None,
        vector: Some(rotating_wall),
    },
];

/// The condition that a patch kind dictates, if it does.
fn of_patch_kind(kind: &PatchKind) -> Option<OfPatchType> {
    let (kind, symmetric) = match kind {
        PatchKind::Empty => ("empty", false),
        PatchKind::Symmetry => ("symmetry", true),
        PatchKind::SymmetryPlane => ("symmetryPlane", true),
        PatchKind::Wedge => ("wedge", false),
        PatchKind::Cyclic { .. } => ("cyclic", false),
        _ => return None,
    };
    Some(OfPatchType { kind, symmetric })
}

/// Reads `type` and hands over to the reader that `select` finds in an entry.
fn read<T: Value, F: Copy>(
    r: &Reader<'_>,
    context: &PatchContext<'_>,
    select: impl Fn(&Entry) -> Option<F>,
    call: impl Fn(F) -> Box<dyn Condition<T>>,
) -> Box<dyn Condition<T>> {
    if let Some(dictated) = of_patch_kind(context.kind) {
        let word = r.word("type");
        r.ignore("value");
        if !word.is_empty() && word != dictated.kind {
            let message = format!(
                "patch `{}` is of type {}: so must be its condition",
                context.patch, dictated.kind
            );
            let help = format!("write `type {};`", dictated.kind);
            r.error_at_key("type", &message, format!("found `{word}`"), Some(&help));
        }
        return Box::new(dictated);
    }
    let word = r.raw("type").and_then(|t| t.first()).and_then(|t| t.word()).unwrap_or("");
    if CONSTRAINT_TYPES.contains(&word) {
        let (patch, kind) = (context.patch, context.kind.word());
        let message =
            format!("`{word}` is the condition of patches of that type: `{patch}` is a {kind}");
        let help = format!(
            "give the patch the type `{word}` in the mesh (blockMeshDict, constant/polyMesh/boundary), \
             or choose a condition (`granflow list conditions`)"
        );
        r.error_at_key("type", message, format!("the mesh says {kind}"), Some(&help));
        r.ignore_all();
        return Box::new(ZeroGradient);
    }
    let known: Vec<(&str, Option<F>)> =
        ALL.iter().filter_map(|e| Some((e.name, Some(select(e)?)))).collect();
    let chosen = match r.has("type") {
        true => r.opt_one_of("type", &known, None),
        false => {
            r.one_of("type", &known);
            None
        }
    };
    match chosen {
        Some(reader) => call(reader),
        None => {
            // The entries belong to a condition that is not known: nothing can be said of them.
            r.ignore_all();
            Box::new(ZeroGradient)
        }
    }
}

/// Reads the condition of a scalar on one patch; mistakes go to the reader's sink.
pub fn read_scalar(r: &Reader<'_>, context: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    read(r, context, |e| e.scalar, |f| f(r, context))
}

/// Reads the condition of a vector on one patch; mistakes go to the reader's sink.
pub fn read_vector(r: &Reader<'_>, context: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    read(r, context, |e| e.vector, |f| f(r, context))
}
