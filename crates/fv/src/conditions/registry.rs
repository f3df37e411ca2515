//! The conditions by name: one line each feeds the reader, the message about unknown names,
//! `granflow list conditions` and the book.

use super::basic::Calculated;
use super::read::{field_values, leave_flux, leave_value};
use super::{
    Condition, FixedGradient, FixedValue, InletOutlet, OfPatchType, PatchContext, Reason, Slip,
    ZeroGradient, contact_angle, coulomb_friction, expression, expression_mixed, flow_rate,
    freestream, hydrostatic, local_fluidity, mapped, mean, mixed, moving_wall, normal_part,
    phase_mean, pressure, pressure_inlet, profile, refused, rotating, scaled, surface_normal,
    swirl, total_pressure, uniform, variable_height, wave,
};
use granflow_base::{Value, Vec3};
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
    /// What it makes of the face's value, in the symbols of the chapter on conditions: `phi` a field,
    /// `U` the velocity, `_f` on the face, `_P` in the cell behind it, `h` the distance of that cell's
    /// centre from the face, `n` the outward normal, `S` the area vector, `t` time.
    pub formula: &'static str,
    /// Its entries in the patch's dictionary beside `type`, each with its meaning and unit.
    pub keys: &'static [(&'static str, &'static str)],
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
fn calculated<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Calculated("calculated"))
}
fn extrapolated<T: Value>(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    Box::new(Calculated("extrapolatedCalculated"))
}
fn no_slip(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    Box::new(FixedValue::named("noSlip", [0.0; 3]))
}

/// Every condition, by its OpenFOAM name.
pub const ALL: &[Entry] = &[
    Entry {
        name: "fixedValue",
        summary: "Dirichlet: the value at the face is given",
        formula: "phi_f = value",
        keys: &[("value", "units of the field, `uniform` or one a face")],
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(fixed_value),
        vector: Some(fixed_value),
    },
    Entry {
        name: "zeroGradient",
        summary: "Neumann: the face takes the value of the cell",
        formula: "phi_f = phi_P",
        keys: &[],
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(zero_gradient),
        vector: Some(zero_gradient),
    },
    Entry {
        name: "fixedGradient",
        summary: "Neumann: the outward normal gradient is given",
        formula: "phi_f = phi_P + gradient h",
        keys: &[("gradient", "units of the field a metre, outwards, `uniform` or one a face")],
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4",
        scalar: Some(fixed_gradient),
        vector: Some(fixed_gradient),
    },
    Entry {
        name: "inletOutlet",
        summary: "zero gradient where the flow leaves, a given value where it enters",
        formula: "phi_f = inletValue where flux < 0, else phi_P",
        keys: &[("inletValue", "units of the field, `uniform` or one a face")],
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
        formula: "phi_f = phi_P",
        keys: &[],
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(calculated),
        vector: Some(calculated),
    },
    Entry {
        name: "extrapolatedCalculated",
        summary: "zero gradient under another name",
        formula: "phi_f = phi_P",
        keys: &[],
        reference: "OpenFOAM user guide, boundary conditions",
        scalar: Some(extrapolated),
        vector: Some(extrapolated),
    },
    Entry {
        name: "slip",
        summary: "no flow through the wall and no traction along it",
        formula: "U_f = U_P - (U_P . n) n; of a scalar phi_f = phi_P",
        keys: &[],
        reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 9",
        scalar: Some(slip),
        vector: Some(slip),
    },
    pressure::PRGH,
    pressure::FIXED_FLUX,
    total_pressure::TOTAL,
    total_pressure::UNIFORM,
    total_pressure::ROTATING,
    hydrostatic::UNIFORM,
    hydrostatic::OF_PHASE,
    freestream::PRESSURE,
    total_pressure::OF_PRESSURE,
    contact_angle::ENTRY,
    local_fluidity::ENTRY,
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
    flow_rate::INLET,
    flow_rate::OUTLET,
    variable_height::FRACTION,
    variable_height::VELOCITY,
    wave::ALPHA,
    wave::VELOCITY,
    Entry {
        name: "noSlip",
        summary: "the wall stands and holds what touches it: U = 0",
        formula: "U_f = 0",
        keys: &[],
        reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, 1967, ch. 3.3",
        scalar: None,
        vector: Some(no_slip),
    },
    moving_wall::TRANSLATING,
    moving_wall::MOVING,
    normal_part::PARTIAL_SLIP,
    normal_part::FIXED_NORMAL_SLIP,
    coulomb_friction::ENTRY,
    rotating::ENTRY,
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
