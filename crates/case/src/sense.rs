//! Boundary conditions that are fine one by one and make no sense together: more flows in than
//! out, both or neither of velocity and pressure given, flow through a wall.

use crate::{Case, boundary};
use granflow_base::{Dims, Vec3, dot, norm};
use granflow_dict::{Diag, Dict, Severity, Sink, Span, number};
use granflow_fv::{Condition, Surroundings, Unknown};
use granflow_mesh::PatchKind;
use granflow_par::Exec;

/// What flows in and not out, over what moves at the boundary, beyond which the flow cannot be
/// that of an incompressible fluid.
const BALANCE: f64 = 1e-4;
/// Flow through a patch over the speed on it, below which a moving wall of flat faces may be meant.
const THROUGH: f64 = 1e-2;

/// What the conditions of one patch amount to.
struct Side<'a> {
    name: &'a str,
    kind: &'a PatchKind,
    /// The patch's entry of U, and of the pressure.
    u: &'a Dict,
    p: &'a Dict,
    /// Whether the flow through it is given, and can be worked out before there is a flow.
    given: Flow,
    /// Whether the pressure on it is given, and whether at least in part.
    pressure_given: bool,
    pressure_fixed: bool,
    /// What enters and what leaves where the flow is given, m3/s.
    inward: f64,
    outward: f64,
    /// Speed times area there, m3/s.
    motion: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Flow {
    Given,
    Free,
    /// It depends on waves or levels, or on what flows: of a mixed condition the value is a share.
    Unknown,
}

/// Says what makes no sense at the start of the case.
pub(crate) fn check(case: &Case, sink: &Sink) {
    if case.start.u.boundary.len() != case.mesh.patches.len() || case.config.solution.frozen {
        return;
    }
    weight(case, sink);
    let sides = sides(case);
    balance(&sides, sink);
    for side in &sides {
        one(case, side, sink);
    }
}

/// Two densities and no gravity are likelier a missing file.
fn weight(case: &Case, sink: &Sink) {
    if case.config.gravity.is_some() || case.config.transport.second.is_none() {
        return;
    }
    let path = case.root.join("constant/g").display().to_string();
    let d = Diag::file(path, "two phases without gravity: this file is missing");
    let help =
        "write it (dimensions [0 1 -2 0 0 0 0]; value (0 -9.81 0);), with (0 0 0) if none is meant";
    sink.push(Diag { severity: Severity::Warning, ..d }.help(help));
}

fn sides(case: &Case) -> Vec<Side<'_>> {
    let mesh = &*case.mesh;
    let (u_entries, p_entries) = (&case.start.u.boundary, &case.start.p.boundary);
    let conditions =
        boundary::conditions::<Vec3>(u_entries, mesh, case.patches(), ("U", Dims::VELOCITY), 1.0);
    let pressures = boundary::conditions::<f64>(
        p_entries,
        mesh,
        case.patches(),
        (case.config.pressure(), case.start.p.dims),
        1.0,
    );
    let kinds: Vec<Flow> = conditions.iter().map(|c| flow_of(&**c)).collect();
    let mut u = Unknown::new(mesh, "U", Dims::VELOCITY, [0.0; 3], conditions);
    for (c, &user) in mesh.global_cell.iter().enumerate() {
        u.cells.data[c] = case.start.u.cells[user as usize];
    }
    let around = Surroundings { time: case.start.time, ..Surroundings::default() };
    u.update(&Exec::serial(), mesh, &around, None);
    let mut out = Vec::new();
    for (i, patch) in mesh.patches.iter().enumerate() {
        let open = matches!(patch.kind, PatchKind::Patch | PatchKind::Wall);
        if !open || patch.faces.is_empty() {
            continue;
        }
        let mut side = Side {
            name: &patch.name,
            kind: &patch.kind,
            u: &u_entries[i],
            p: &p_entries[i],
            given: kinds[i],
            pressure_given: pressures[i].gives_value(),
            pressure_fixed: pressures[i].fixes_value(),
            inward: 0.0,
            outward: 0.0,
            motion: 0.0,
        };
        for f in patch.faces.clone().filter(|_| side.given == Flow::Given) {
            let b = f - mesh.n_inner;
            // Faces of slip keep nothing of the normal part.
            if u.closure.slope[b] != 0.0 {
                continue;
            }
            let (v, flux) = (u.closure.offset[b], dot(u.closure.offset[b], mesh.area[f]));
            side.inward += (-flux).max(0.0);
            side.outward += flux.max(0.0);
            side.motion += norm(v) * mesh.mag_area[f];
        }
        out.push(side);
    }
    out
}

fn flow_of(c: &dyn Condition<Vec3>) -> Flow {
    match c.name() {
        name if name.starts_with("wave") || name.starts_with("variableHeight") => Flow::Unknown,
        "slip" | "flowRateInletVelocity" | "flowRateOutletVelocity" => Flow::Given,
        _ if c.gives_value() || c.friction().is_some() => Flow::Given,
        _ if c.fixes_value() => Flow::Unknown,
        _ => Flow::Free,
    }
}

/// Where the entry is written, for messages.
fn place(entry: &Dict) -> Span {
    entry.find("type").map_or_else(|| entry.open.clone(), |e| e.key_span.clone())
}

fn type_of(entry: &Dict) -> &str {
    entry.word("type").unwrap_or("")
}

/// A fluid that keeps its volume leaves as fast as it enters.
fn balance(sides: &[Side<'_>], sink: &Sink) {
    if sides.iter().any(|s| s.given != Flow::Given) {
        return;
    }
    let sum = |of: fn(&Side<'_>) -> f64| sides.iter().map(of).sum::<f64>();
    let (inward, outward) = (sum(|s| s.inward), sum(|s| s.outward));
    if (inward - outward).abs() <= BALANCE * sum(|s| s.motion) {
        return;
    }
    let most = sides.iter().max_by(|a, b| a.through().total_cmp(&b.through()));
    let Some(most) = most else { return };
    let three = |x: f64| format!("{x:.2e}").parse().map_or_else(|_| x.to_string(), number);
    let message = format!(
        "the velocity is given on every patch, with {} m3/s in and {} m3/s out",
        three(inward),
        three(outward)
    );
    let help = "a fluid that keeps its volume cannot do that: leave the velocity free on one patch \
                (`zeroGradient` or `inletOutlet`, with a fixed pressure), or make both equal";
    let label = format!("most flows through `{}`", most.name);
    sink.push(Diag::error(&place(most.u), message).label(label).help(help));
}

impl Side<'_> {
    fn through(&self) -> f64 {
        (self.inward - self.outward).abs()
    }
}

fn one(case: &Case, side: &Side<'_>, sink: &Sink) {
    let (name, p) = (side.name, case.config.pressure());
    let flows = side.through() > THROUGH * side.motion && side.motion > 0.0;
    let (of_u, of_p) = (type_of(side.u), type_of(side.p));
    if flows && side.pressure_given {
        let message = format!("patch `{name}`: both the velocity and the pressure are given");
        let label = format!("`{of_p}`, and `{of_u}` for U");
        let help = format!(
            "give `{p}` the condition `zeroGradient` where U is given (or `fixedFluxPressure` \
             under gravity)"
        );
        sink.push(Diag::warning(&place(side.p), message).label(label).help(help));
    }
    if flows && *side.kind == PatchKind::Wall {
        let message = format!("fluid passes through the wall `{name}`");
        let help = "a velocity along a wall moves it; where fluid enters or leaves, the mesh \
                    should have the type `patch`";
        let label = "has a part normal to the wall";
        sink.push(Diag::warning(&place(side.u), message).label(label).help(help));
    }
    if side.given == Flow::Free && !side.pressure_fixed {
        let message = format!("patch `{name}`: neither the velocity nor the pressure is given");
        let label = format!("`{of_p}`, and `{of_u}` for U");
        let help = format!(
            "nothing says how much flows there: give `{p}` a value (`fixedValue`, \
             `totalPressure`, `prghPressure`), or U"
        );
        sink.push(Diag::warning(&place(side.p), message).label(label).help(help));
    }
}
