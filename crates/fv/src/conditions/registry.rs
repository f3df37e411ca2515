//! The conditions by name: one line each feeds the reader, the message about unknown names,
//! `granflow list conditions` and the book.

use super::basic::Calculated;
use super::read::{field_values, leave_flux, leave_value};
use super::{
    Condition, ConstantAlphaContactAngle, ContactLimit, CoulombFriction, FixedFluxPressure,
    FixedGradient, FixedValue, FlowRate, FlowRateInlet, FlowRateOutlet, InletOutlet, LocalFluidity,
    OfPatchType, PatchContext, PrghPressure, Reason, RotatingWall, Slip, VariableHeightFlowRate,
    VariableHeightFlowRateInlet, WaveAlpha, WaveVelocity, ZeroGradient, expression,
    expression_mixed, freestream, hydrostatic, mapped, mean, mixed, moving_wall, normal_part,
    phase_mean, pressure_inlet, profile, refused, scaled, surface_normal, swirl, total_pressure,
    uniform,
};
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Value, Vec3};
use granflow_dict::{CONSTRAINT_TYPES, Reader};
use granflow_mesh::PatchKind;

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

fn fixed_value<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    Box::new(FixedValue::per_face(field_values(r, "value", c)))
}
fn zero_gradient<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(ZeroGradient)
}
fn fixed_gradient<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(FixedGradient::new(field_values(r, "gradient", c)))
}
fn inlet_outlet<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    leave_flux(r);
    Box::new(InletOutlet::new(field_values(r, "inletValue", c)))
}
fn slip<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Slip)
}
fn prgh_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("rho");
    Box::new(PrghPressure::new(field_values(r, "p", c)))
}
fn fixed_flux_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    for key in ["gradient", "phi", "rho"] {
        r.ignore(key);
    }
    Box::new(FixedFluxPressure::new(c.n_inner))
}
fn contact_angle(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("gradient");
    let theta0 = r.in_range("theta0", Dims::NONE, 0.0..=180.0);
    let limit = r.one_of("limit", &ContactLimit::ALL);
    Box::new(ConstantAlphaContactAngle { theta0, limit, n_inner: c.n_inner })
}
fn calculated<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Calculated("calculated"))
}
fn extrapolated<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Calculated("extrapolatedCalculated"))
}
fn flow_rate_inlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    let extrapolates = r.opt_switch("extrapolateProfile", false);
    Box::new(FlowRateInlet { rate: FlowRate::read(r, c, "rhoInlet"), extrapolates })
}
fn flow_rate_outlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    Box::new(FlowRateOutlet { rate: FlowRate::read(r, c, "rhoOutlet") })
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
fn rotating_wall(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    let origin = r.vector("origin", Dims::LENGTH);
    let axis = r.direction("axis");
    let omega = TimeFunction::read(r, "omega", Dims::RATE, c.case);
    Box::new(RotatingWall { origin, axis, omega })
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
    let rate = TimeFunction::read(r, "flowRate", Dims::VOLUME_FLUX, c.case);
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
    uniform::FIXED_VALUE,
    uniform::FIXED_GRADIENT,
    uniform::INLET_OUTLET,
    mixed::ENTRY,
    profile::ENTRY,
    mapped::ENTRY,
    expression::ENTRY,
    expression_mixed::ENTRY,
    scaled::ENTRY,
    phase_mean::ENTRY,
    mean::FIXED_MEAN,
    mean::OUTLET_INLET,
    normal_part::OUTLET_INLET,
    freestream::EITHER,
    Entry {
        name: "calculated",
        summary: "of a value that follows from others; of a field that is solved for, zero gradient",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(calculated),
        vector: Some(calculated),
    },
    Entry {
        name: "extrapolatedCalculated",
        summary: "zero gradient under another name",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(extrapolated),
        vector: Some(extrapolated),
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
    total_pressure::TOTAL,
    total_pressure::UNIFORM,
    total_pressure::ROTATING,
    hydrostatic::UNIFORM,
    hydrostatic::OF_PHASE,
    freestream::PRESSURE,
    total_pressure::OF_PRESSURE,
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
    pressure_inlet::OUTLET,
    pressure_inlet::NORMAL,
    pressure_inlet::UNIFORM,
    pressure_inlet::DIRECTED,
    pressure_inlet::DIRECTED_OUTLET,
    pressure_inlet::NORMAL_OUTLET,
    pressure_inlet::SLIP,
    pressure_inlet::ROTATING,
    normal_part::FIXED_NORMAL_OUTLET,
    freestream::VELOCITY,
    surface_normal::GIVEN,
    surface_normal::UNIFORM,
    swirl::CYLINDRICAL,
    swirl::BY_RADIUS,
    swirl::FLOW_RATE,
    Entry {
        name: "flowRateInletVelocity",
        summary: "inflow of a given volume (or mass) per second, a function of time: the same speed \
                  along the normal everywhere, or with extrapolateProfile as it arrives",
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: None,
        vector: Some(flow_rate_inlet),
    },
    Entry {
        name: "flowRateOutletVelocity",
        summary: "outflow of a given volume (or mass) per second with the profile that arrives, a \
                  function of time",
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
                  fluid fills, a function of time",
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
    moving_wall::TRANSLATING,
    moving_wall::MOVING,
    normal_part::PARTIAL_SLIP,
    normal_part::FIXED_NORMAL_SLIP,
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
        summary: "no slip on a wall that turns about an axis, omega a function of time",
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
    let word = r.dict().word("type").unwrap_or("");
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
    if let Some(found) = refused(word) {
        r.ignore_all();
        let message = format!("the condition `{word}` is not supported: {}", found.reason.text());
        let help = match (found.remedy, found.reason) {
            ("", _) => None,
            (remedy, Reason::PatchType) => Some(remedy.to_owned()),
            (remedy, _) => Some(format!("in its place: {remedy}")),
        };
        r.error_at_key("type", message, "refused", help.as_deref());
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
