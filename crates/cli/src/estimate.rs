//! What a run of a case would meet: speeds, Courant number, grains a cell, inertial numbers, disk.
//!
//! Everything here is an estimate from the boundary conditions and the start fields, before
//! anything is solved.

use crate::text::{bytes, count, number, rounded};
use granflow_base::{Dims, Vec3, dot, norm};
use granflow_case::config::WriteControl;
use granflow_case::store::Compression;
use granflow_case::{Case, boundary};
use granflow_dict::Format;
use granflow_fv::{Surroundings, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::Granular;

/// Times of a run at which conditions are looked at, so that tables against time are seen.
const SAMPLES: usize = 33;
/// Width in grains of the layer that shears when it localises at a wall.
const LAYER: f64 = 5.0;

/// The speed of a patch whose velocity is given.
struct Drive {
    patch: String,
    /// Least (but not zero) and greatest speed over faces and times, m/s.
    speed: [f64; 2],
    /// Volume of the mesh over the area of the patch: how far the shear can reach, m.
    reach: f64,
    /// Width of the cells at the patch, m.
    width: f64,
}

/// The estimates, one a line.
pub(crate) fn lines(case: &Case) -> Vec<String> {
    let mut out = Vec::new();
    let mut say = |key: &str, text: String| out.push(format!("{key:<18} {text}"));
    say(
        "model",
        format!("{}, rho {} kg/m3", case.config.transport.model, case.config.transport.rho),
    );
    let (from, to) = (case.start.time, case.end);
    let dt = case.config.control.dt;
    say(
        "time",
        format!("{} to {} s from directory {}", rounded(from, 6), rounded(to, 6), case.start.dir),
    );
    let (drives, courant) = drives(case);
    for d in &drives {
        let [least, most] = d.speed.map(number);
        let speed = if least == most { most } else { format!("{least} to {most}") };
        say("speed", format!("{speed} m/s at patch {}", d.patch));
    }
    let steps = ((to - from) / dt).max(0.0).ceil();
    if courant > 0.0 {
        let one = number(1.0 / courant);
        let text = format!(
            "deltaT {} s is a Courant number of about {}; a Courant number of 1 needs {one} s",
            number(dt),
            number(courant * dt)
        );
        say("time step", text);
    }
    match &case.config.control.adjust {
        Some(a) => say("steps", format!("adjusted to a Courant number of {}", number(a.max_co))),
        None => say("steps", rounded(steps, 6)),
    }
    if let Some(grains) = &case.config.transport.grains {
        granular(case, grains, &drives, &mut say);
    }
    let (writes, each) = disk(case, steps);
    let total = bytes(writes * each);
    say("disk", format!("about {total}: {} of {}", count(writes as usize, "time"), bytes(each)));
    out
}

fn granular(case: &Case, grains: &Granular, drives: &[Drive], say: &mut impl FnMut(&str, String)) {
    let [finest, coarsest] = spacing(&case.mesh);
    say(
        "cells a grain",
        format!(
            "{} at the finest, {} at the coarsest",
            number(grains.d / finest),
            number(grains.d / coarsest)
        ),
    );
    for d in drives {
        let cells = grains.d / d.width;
        say("", format!("{} at patch {}", number(cells), d.patch));
        if cells < 2.0 {
            say(
                "warning",
                format!(
                    "the shear at {} decays over a few grains: 2 cells a grain resolve it to about \
                     a percent, 4 to 4e-4",
                    d.patch
                ),
            );
        }
    }
    if let Some(xi) = case.config.transport.cooperativity {
        let cells = xi / coarsest;
        let verdict = if cells < 2.0 { "not resolved" } else { "resolved" };
        let text = format!(
            "{} grains or more below yield: {} cells at the coarsest ({verdict})",
            number(xi / grains.d),
            number(cells)
        );
        say("xi", text);
    }
    let pressures = pressures(case);
    let (low, high) =
        pressures.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(*p), b.max(*p)));
    if low <= 0.0 {
        say(
            "warning",
            "the pressure at the start is not positive everywhere: grains fall apart there".into(),
        );
    }
    if high <= 0.0 {
        return;
    }
    let same = high - low <= 1e-9 * high;
    let range = if same { number(high) } else { format!("{} to {}", number(low), number(high)) };
    say("pressure", format!("{range} Pa at the start"));
    let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
    let inertial = |rate: f64| grains.inertial_number(rate, mean);
    let ranges = drives.iter().map(|d| {
        let layer = (LAYER * grains.d).min(d.reach);
        [inertial(d.speed[0] / d.reach), inertial(d.speed[1] / layer)]
    });
    let none = [f64::INFINITY, 0.0];
    let [a, b] = ranges.fold(none, |[a, b], [c, d]| [a.min(c), b.max(d)]);
    if b > 0.0 {
        let regime = match b {
            b if b < 1e-3 => "quasi-static: the nonlocal part decides",
            b if b < 0.3 => "dense flow",
            _ => "fast: beyond what mu(I) was measured for (I up to about 0.3)",
        };
        let text =
            format!("I about {} to {} at the driven patches ({regime})", number(a), number(b));
        say("inertial number", text);
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
    let mut speeds = vec![[f64::INFINITY, 0.0_f64]; mesh.patches.len()];
    for k in 0..SAMPLES {
        let share = k as f64 / (SAMPLES - 1) as f64;
        let time = case.start.time + share * (case.end - case.start.time);
        u.update(&exec, mesh, &Surroundings { time, ..Surroundings::default() }, None);
        for (patch, [least, most]) in mesh.patches.iter().zip(&mut speeds) {
            for f in patch.faces.clone() {
                // Only where the velocity is given, whatever the flow does.
                if u.closure.slope[f - mesh.n_inner] == 0.0 {
                    let v = u.closure.offset[f - mesh.n_inner];
                    let speed = norm(v);
                    *most = most.max(speed);
                    if speed > 0.0 {
                        *least = least.min(speed);
                        courant = courant.max(cell_courant(mesh, mesh.owner[f] as usize, v));
                    }
                }
            }
        }
    }
    let total: f64 = mesh.volume[..mesh.n_cells].iter().sum();
    let patches = mesh.patches.iter().zip(speeds).filter(|(_, s)| s[1] > 0.0);
    let driven = patches.map(|(patch, speed)| {
        let area: f64 = patch.faces.clone().map(|f| mesh.mag_area[f]).sum();
        let widths = patch.faces.clone().map(|f| 2.0 / mesh.inv_dist[f]);
        Drive {
            patch: patch.name.clone(),
            speed,
            reach: total / area.max(f64::MIN_POSITIVE),
            width: widths.fold(0.0, f64::max),
        }
    });
    (driven.collect(), courant)
}

/// Courant number of a step of one second in a cell that moves with `v`.
fn cell_courant(mesh: &Mesh, c: usize, v: Vec3) -> f64 {
    let out: f64 = mesh.faces_of(c).map(|(f, _)| dot(v, mesh.area[f]).abs()).sum();
    0.5 * out / mesh.volume[c]
}

/// Least and greatest distance of neighbouring cells, m; images behind periodic patches do not
/// count.
fn spacing(mesh: &Mesh) -> [f64; 2] {
    let inner = (0..mesh.n_inner).filter(|&f| (mesh.neighbour[f] as usize) < mesh.n_cells);
    let all = inner.map(|f| norm(mesh.delta[f]));
    let [a, b] = all.fold([f64::INFINITY, 0.0], |[a, b], d| [a.min(d), b.max(d)]);
    if b > 0.0 {
        return [a, b];
    }
    // A single cell.
    let side = if mesh.n_cells > 0 { mesh.cell_size(0) } else { 1.0 };
    [side, side]
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

/// Number of time directories and the size of one, bytes.
fn disk(case: &Case, steps: f64) -> (f64, f64) {
    let control = &case.config.control;
    let span = (case.end - case.start.time).max(0.0);
    let writes = match control.write {
        WriteControl::Steps(n) => (steps / n as f64).ceil(),
        WriteControl::Time(every) | WriteControl::Adjustable(every) => (span / every).ceil(),
        WriteControl::Never => 1.0,
    };
    let kept = if control.purge > 0 { writes.min(control.purge as f64) } else { writes };
    // U, p, strain rate, viscosity; of grains fluidity, I and mu as well; phi on faces.
    let fields = if case.config.transport.grains.is_some() { 9.0 } else { 6.0 };
    let numbers = fields * case.mesh.n_cells as f64 + case.mesh.n_faces() as f64;
    let size = match (control.format, control.compression) {
        (Format::Ascii, Compression::Plain) => 20.0,
        (Format::Ascii, Compression::Gzip) => 9.0,
        (Format::Binary, Compression::Plain) => 8.0,
        (Format::Binary, Compression::Gzip) => 7.5,
    };
    (kept.max(1.0), numbers * size + 8e3)
}
