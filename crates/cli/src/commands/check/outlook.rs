//! What drives the flow, how far and how fast: from boundary conditions, gravity and start fields.

use granflow_base::{Dims, Vec3, dot, norm, scale, sub, unit};
use granflow_case::{Case, boundary};
use granflow_flow::Zone;
use granflow_flow::sources::RotatingFrame;
use granflow_fv::{Surroundings, Unknown};
use granflow_mesh::{Mesh, PatchKind};
use granflow_par::Exec;

/// Times of a run at which conditions are looked at, so that tables against time are seen.
const SAMPLES: usize = 33;

/// The speed of a patch whose velocity is given.
pub(super) struct Drive {
    pub(super) patch: String,
    /// Least (but not zero) and greatest speed over faces and times, m/s.
    pub(super) speed: [f64; 2],
    /// Volume of the mesh over the area of the patch: how far the shear can reach, m.
    pub(super) reach: f64,
    /// Width of the cells at the patch, m.
    pub(super) width: f64,
    /// What a Reynolds number is made with: the width of a patch that fluid passes, else `reach`, m.
    pub(super) length: f64,
}

/// What a run may meet.
pub(super) struct Outlook {
    /// Patches that move or let fluid in.
    pub(super) drives: Vec<Drive>,
    /// Greatest mean velocity that a source holds, m/s, and the width of the flow: twice its volume over the
    /// area of its walls, m.
    pub(super) held: Option<[f64; 2]>,
    /// Greatest Courant number of a step of one second at the speeds of patches and start fields, 1/s.
    pub(super) courant: f64,
    /// Least and greatest distance of neighbouring cells, m.
    pub(super) spacing: [f64; 2],
    /// The same among grains, where there is a second phase beside them, and across their surface.
    pub(super) in_grains: Option<[f64; 2]>,
    pub(super) at_surface: Option<[f64; 2]>,
    /// Height of the mesh along gravity, m; 0 without gravity.
    pub(super) height: f64,
    /// Speed after a free fall over that height, where a surface can fall, m/s.
    pub(super) fall: Option<f64>,
    /// Of grains: least, mean and greatest pressure at the start, Pa.
    pub(super) pressure: Option<[f64; 3]>,
}

impl Outlook {
    pub(super) fn of(case: &Case) -> Outlook {
        let (drives, moving) = drives(case);
        let held = held(case);
        let courant = held.map_or(moving, |(_, courant)| moving.max(courant));
        let held = held.map(|h| h.0);
        let gravity = case.config.gravity.unwrap_or_default();
        let height = height(case, gravity);
        let two = case.config.transport.second.is_some();
        // Down a slope without end the surface stays where it is.
        let falls = two && height > 0.0 && norm(case.gravity.driving) == 0.0;
        let fall = falls.then(|| (2.0 * norm(gravity) * height).sqrt());
        let pressures = match two {
            false => pressures(case),
            true => depths(case, gravity),
        };
        let grains = case.config.transport.grains.is_some() && !pressures.is_empty();
        let full = full(case);
        let beside = |keep: fn(bool, bool) -> bool| {
            let full = full.as_ref().filter(|_| grains)?;
            spacing(&case.mesh, |a, b| keep(full[a], full[b]))
        };
        let spacing = spacing(&case.mesh, |_, _| true).unwrap_or_else(|| single(&case.mesh));
        let pressure = grains.then(|| {
            let ends = pressures
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &p| [a.min(p), b.max(p)]);
            [ends[0], pressures.iter().sum::<f64>() / pressures.len() as f64, ends[1]]
        });
        let in_grains = beside(|a, b| a && b);
        let at_surface = beside(|a, b| a != b);
        Outlook { drives, held, courant, spacing, in_grains, at_surface, height, fall, pressure }
    }
    /// Greatest Courant number of a step of one second, falls included, 1/s.
    pub(super) fn rate(&self) -> f64 {
        self.courant.max(self.fall.unwrap_or(0.0) / self.spacing[0])
    }
}

/// Patches that drive the flow, and the greatest Courant number of a step of one second.
fn drives(case: &Case) -> (Vec<Drive>, f64) {
    let mesh = &*case.mesh;
    let exec = Exec::serial();
    let conditions = boundary::conditions::<Vec3>(
        &case.start.u.boundary,
        mesh,
        case.patches(),
        ("U", Dims::VELOCITY),
        1.0,
    );
    let mut u = Unknown::new(mesh, "U", Dims::VELOCITY, [0.0; 3], conditions);
    for (c, &user) in mesh.global_cell.iter().enumerate() {
        u.cells.data[c] = case.start.u.cells[user as usize];
    }
    let mut courant: f64 =
        (0..mesh.n_cells).map(|c| cell_courant(mesh, c, u.cells.data[c])).fold(0.0, f64::max);
    let turning = turning(case, &u);
    let mut speeds = vec![[f64::INFINITY, 0.0_f64]; mesh.patches.len()];
    let mut passes = vec![false; mesh.patches.len()];
    for k in 0..SAMPLES {
        let share = k as f64 / (SAMPLES - 1) as f64;
        let time = case.start.time + share * (case.end - case.start.time);
        u.update(&exec, mesh, &Surroundings { time, ..Surroundings::default() }, None);
        for Turning { frame, cells, walls } in &turning {
            let omega = frame.omega.at(time);
            for f in walls {
                let v = scale(frame.arm(mesh.face_centre[*f]), omega);
                u.closure.offset[f - mesh.n_inner] = v;
            }
            // What counts in a zone is the flux relative to the frame.
            for c in cells {
                let v = u.cells.data[*c];
                let through = |f: usize| {
                    let frame = scale(frame.arm(mesh.face_centre[f]), omega);
                    dot(sub(v, frame), mesh.area[f]).abs()
                };
                let out: f64 = mesh.faces_of(*c).map(|(f, _)| through(f)).sum();
                courant = courant.max(0.5 * out / mesh.volume[*c]);
            }
        }
        let each = mesh.patches.iter().zip(&mut speeds).zip(&mut passes);
        for ((patch, [least, most]), passes) in each {
            for f in patch.faces.clone() {
                // Only where the velocity is given, whatever the flow does.
                if u.closure.slope[f - mesh.n_inner] == 0.0 {
                    let v = u.closure.offset[f - mesh.n_inner];
                    let speed = norm(v);
                    *most = most.max(speed);
                    *passes |= dot(v, mesh.area[f]).abs() > 0.1 * speed * mesh.mag_area[f];
                    if speed > 0.0 {
                        *least = least.min(speed);
                        courant = courant.max(cell_courant(mesh, mesh.owner[f] as usize, v));
                    }
                }
            }
        }
    }
    let total: f64 = mesh.volume[..mesh.n_cells].iter().sum();
    let patches = mesh.patches.iter().zip(speeds).zip(passes).filter(|((_, s), _)| s[1] > 0.0);
    let driven = patches.map(|((patch, speed), passes)| {
        let area: f64 = patch.faces.clone().map(|f| mesh.mag_area[f]).sum();
        let widths = patch.faces.clone().map(|f| 2.0 / mesh.inv_dist[f]);
        Drive {
            patch: patch.name.clone(),
            speed,
            reach: total / area.max(f64::MIN_POSITIVE),
            length: match (passes, thickness(case)) {
                (false, _) => total / area.max(f64::MIN_POSITIVE),
                (true, Some(thickness)) => area / thickness,
                (true, None) => area.sqrt(),
            },
            width: widths.fold(0.0, f64::max),
        }
    });
    (driven.collect(), courant)
}

/// How thick a plane mesh is, m.
fn thickness(case: &Case) -> Option<f64> {
    let flat = (0..3).find(|k| !case.mesh.solved_dirs[*k])?;
    let along = case.poly.points.iter().map(|x| x[flat]);
    let [a, b] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
    Some(b - a)
}

/// The greatest mean velocity that is held with the width of the flow (m/s, m), and what it makes of the
/// Courant number of a step of one second.
fn held(case: &Case) -> Option<([f64; 2], f64)> {
    let held = case.sources.iter().filter_map(|s| s.held());
    let means = held.map(|m| scale(m.direction, m.mean));
    let mean = means.max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
    let mesh = &case.mesh;
    let walls = mesh.patches.iter().filter(|p| p.kind == PatchKind::Wall);
    let area: f64 = walls.flat_map(|p| p.faces.clone()).map(|f| mesh.mag_area[f]).sum();
    let total: f64 = mesh.volume[..mesh.n_cells].iter().sum();
    // Without walls the whole mesh.
    let width = if area > 0.0 { 2.0 * total / area } else { total.cbrt() };
    let courant = (0..mesh.n_cells).map(|c| cell_courant(mesh, c, mean)).fold(0.0, f64::max);
    Some(([norm(mean), width], courant))
}

/// What turns with a frame.
struct Turning<'a> {
    frame: &'a RotatingFrame,
    cells: Vec<usize>,
    /// Faces of walls whose velocity is given.
    walls: Vec<usize>,
}

fn turning<'a>(case: &'a Case, u: &Unknown<Vec3>) -> Vec<Turning<'a>> {
    let mesh = &*case.mesh;
    let of = |frame: &'a RotatingFrame| {
        let mut within = vec![matches!(frame.zone, Zone::All); mesh.n_cells];
        if let Zone::Cells(users) = &frame.zone {
            users.iter().for_each(|c| within[*c as usize] = true);
        }
        let turns = |c: usize| within[mesh.global_cell[c] as usize];
        let walls = mesh.patches.iter().zip(&u.conditions).filter(|(p, c)| {
            p.kind == PatchKind::Wall && !frame.still.contains(&p.name) && c.fixes_value()
        });
        let faces = walls.flat_map(|(p, _)| p.faces.clone());
        let walls = faces.filter(|f| turns(mesh.owner[*f] as usize)).collect();
        Turning { frame, cells: (0..mesh.n_cells).filter(|c| turns(*c)).collect(), walls }
    };
    case.sources.iter().filter_map(|s| s.frame()).map(of).collect()
}

/// Courant number of a step of one second in a cell that moves with `v`.
fn cell_courant(mesh: &Mesh, c: usize, v: Vec3) -> f64 {
    let out: f64 = mesh.faces_of(c).map(|(f, _)| dot(v, mesh.area[f]).abs()).sum();
    0.5 * out / mesh.volume[c]
}

/// Least and greatest distance of those neighbouring cells that are kept, m, if there are any;
/// images behind periodic patches do not count.
fn spacing(mesh: &Mesh, keep: impl Fn(usize, usize) -> bool) -> Option<[f64; 2]> {
    let cells = |f: usize| (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
    let kept = |&f: &usize| {
        let (a, b) = cells(f);
        b < mesh.n_cells && keep(a, b)
    };
    let all = (0..mesh.n_inner).filter(kept).map(|f| norm(mesh.delta[f]));
    let [a, b] = all.fold([f64::INFINITY, 0.0], |[a, b], d| [a.min(d), b.max(d)]);
    (b > 0.0).then_some([a, b])
}

/// The size of the only cell, m.
fn single(mesh: &Mesh) -> [f64; 2] {
    let side = if mesh.n_cells > 0 { mesh.cell_size(0) } else { 1.0 };
    [side, side]
}

fn height(case: &Case, gravity: Vec3) -> f64 {
    if norm(gravity) == 0.0 {
        return 0.0;
    }
    let up = scale(unit(gravity), -1.0);
    let levels = case.poly.points.iter().map(|x| dot(*x, up));
    let [a, b] = levels.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], h| [a.min(h), b.max(h)]);
    (b - a).max(0.0)
}

/// Pressure in the cells at the start, Pa, the weight of the fluid included.
fn pressures(case: &Case) -> Vec<f64> {
    let (mesh, k, rho) = (&case.mesh, case.pressure_factor(), case.config.transport.rho);
    let at = |(c, &user): (usize, &u32)| {
        let weight = rho * dot(case.gravity.hydrostatic, mesh.cell_centre[c]);
        k * case.start.p.cells[user as usize] + weight
    };
    mesh.global_cell.iter().enumerate().map(at).collect()
}

/// Weight of the grains above each of their cells, Pa, as if they lay level.
fn depths(case: &Case, gravity: Vec3) -> Vec<f64> {
    let (Some(full), Some(second)) = (full(case), &case.config.transport.second) else {
        return Vec::new();
    };
    let mesh = &case.mesh;
    // Along gravity without what drives grains along cyclic patches.
    let gravity = if norm(case.gravity.driving) > 0.0 { case.gravity.hydrostatic } else { gravity };
    let down = |c: usize| dot(mesh.cell_centre[c], gravity);
    let cells = || (0..mesh.n_cells).filter(|&c| full[c]);
    let top = cells().map(down).fold(f64::INFINITY, f64::min);
    // The uppermost cells carry half of themselves.
    let half =
        cells().map(|c| 0.5 * norm(gravity) * mesh.cell_size(c)).fold(f64::INFINITY, f64::min);
    let weight = case.config.transport.rho - second.transport.rho;
    cells().map(|c| weight * (down(c) - top + half)).collect()
}

/// Which cells hold the first phase, where there are two.
fn full(case: &Case) -> Option<Vec<bool>> {
    let alpha = case.start.alpha.as_ref()?;
    Some(case.mesh.global_cell.iter().map(|&user| alpha.cells[user as usize] > 0.5).collect())
}
