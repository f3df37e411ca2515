//! Checks of how cells and faces are bent.

use super::Worst;
use super::report::{CheckReport, Place, Severity};
use crate::geometry::Geometry;
use crate::polymesh::{PatchKind, PolyMesh};
use granflow_base::{add, cross, dot, norm, scale, sub, unit};
use std::collections::HashMap;

/// Share of a cell in the distance across a face below which interpolation there is one-sided.
const ONE_SIDED: f64 = 0.05;
/// How far another face may reach beyond a face's plane, relative to its distance from the centre
/// of the cell.
const BENT: f64 = 1e-3;
/// Sine of the angle by which edges may lean against the axis of a plane mesh.
const ALIGNED: f64 = 1e-4;

pub(super) fn check(
    poly: &PolyMesh,
    g: &Geometry,
    (ptr, links): &(Vec<u32>, Vec<u32>),
    report: &mut CheckReport,
) {
    pyramids(poly, g, report);
    doubled(poly, g, report);
    closed(poly, g, report);
    aligned(poly, g, report);
    concave_faces(poly, g, report);
    concave_cells(g, ptr, links, report);
}

/// A cell's centre must lie inside each of its faces, and not almost on one.
fn pyramids(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let (mut outside, mut one_sided) = (Worst::new(), Worst::new());
    for f in 0..poly.n_faces() {
        let normal = unit(g.area[f]);
        let depth = |c: u32, sign: f64| {
            sign * dot(normal, sub(g.face_centre[f], g.cell_centre[c as usize]))
        };
        let own = depth(poly.owner[f], 1.0);
        let other = poly.neighbour.get(f).map(|&n| depth(n, -1.0));
        let least = other.map_or(own, |d| d.min(own));
        let at = |value| Place::face(g, f, value);
        if least.is_nan() || least <= 0.0 {
            let cells = poly.cells_of(f);
            let wrong: Vec<u32> = cells
                .iter()
                .copied()
                .zip([Some(own), other])
                .filter_map(|(c, d)| (!d.is_some_and(|d| d > 0.0)).then_some(c))
                .collect();
            outside.add(at(-least), &wrong);
        } else if let Some(other) = other {
            let share = least / (own + other);
            if share < ONE_SIDED {
                one_sided.add(at(-share), &poly.cells_of(f));
            }
        }
    }
    outside.of_least().report(
        report,
        "facePyramid",
        Severity::Error,
        "faces that the centre of a cell lies beyond (depth, m)",
        "the cell is folded or very concave: move its points or coarsen the mesh there",
    );
    one_sided.of_least().report(
        report,
        "faceWeight",
        Severity::Warning,
        "faces close to the centre of one cell and far from the other (share of the distance)",
        "make neighbouring cells more alike in size across that face",
    );
}

/// No two faces may have the same points.
fn doubled(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let mut seen: HashMap<Vec<u32>, usize> = HashMap::with_capacity(poly.n_faces());
    let mut double = Worst::new();
    for f in 0..poly.n_faces() {
        let mut ring = poly.face(f).to_vec();
        ring.sort_unstable();
        if let Some(first) = seen.insert(ring, f) {
            let place = Place::face(g, f, first as f64);
            let mut cells = poly.cells_of(f);
            cells.extend(poly.cells_of(first));
            double.add(place, &cells);
        }
    }
    double.report(
        report,
        "doubleFace",
        Severity::Warning,
        "faces with the points of another one (its number)",
        "a baffle, or cells that should be joined: make one inner face of the two",
    );
}

/// The boundary must close: its area vectors add up to nothing.
fn closed(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let boundary = poly.n_inner()..poly.n_faces();
    let sum = boundary.clone().map(|f| g.area[f]).fold([0.0; 3], add);
    let surface: f64 = boundary.map(|f| norm(g.area[f])).sum();
    report.quality.boundary_openness = norm(sum) / surface.max(f64::MIN_POSITIVE);
    if report.quality.boundary_openness > 1e-6 {
        report.findings.push(super::Finding::whole(
            Severity::Error,
            format!(
                "the boundary is not closed (sum of its area vectors {:.1e} of its surface)",
                report.quality.boundary_openness
            ),
            "faces are missing or turn the wrong way: make the mesh again",
        ));
    }
}

/// Edges of a plane mesh run along its axis or across it.
fn aligned(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let empty = poly.patches.iter().filter(|p| p.kind == PatchKind::Empty && p.len > 0);
    let mut axes: Vec<usize> = Vec::new();
    for p in empty {
        let n = unit(g.area[p.start]);
        axes.extend((0..3).find(|&k| n[k].abs() > 0.99).filter(|k| !axes.contains(k)));
    }
    let mut leaning = Worst::new();
    for f in (0..poly.n_faces()).filter(|_| !axes.is_empty()) {
        let ring = poly.face(f);
        let worst = (0..ring.len())
            .flat_map(|i| {
                let ends = [ring[i], ring[(i + 1) % ring.len()]];
                let e = unit(sub(poly.points[ends[1] as usize], poly.points[ends[0] as usize]));
                axes.iter().map(move |&k| e[k].abs().min((1.0 - e[k] * e[k]).max(0.0).sqrt()))
            })
            .fold(0.0, f64::max);
        if worst > ALIGNED {
            let place = Place::face(g, f, worst);
            leaning.add(place, &poly.cells_of(f));
        }
    }
    leaning.report(
        report,
        "edgeAlignment",
        Severity::Error,
        "faces with edges neither along nor across the axis of the plane mesh (sine of the angle)",
        "front and back must be copies of each other, moved along the axis",
    );
}

fn concave_faces(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let mut concave = Worst::new();
    for f in (0..poly.n_faces()).filter(|&f| poly.face(f).len() > 3) {
        let (ring, normal) = (poly.face(f), unit(g.area[f]));
        let at = |i: usize| poly.points[ring[i % ring.len()] as usize];
        let turn = (0..ring.len())
            .map(|i| {
                let (a, b) = (unit(sub(at(i + 1), at(i))), unit(sub(at(i + 2), at(i + 1))));
                dot(normal, cross(a, b))
            })
            .fold(0.0, f64::min);
        // The sine of 10 degrees: what is less is a point on an edge.
        if turn < -0.17 {
            let angle = (-turn).min(1.0).asin().to_degrees();
            let place = Place::face(g, f, angle);
            concave.add(place, &poly.cells_of(f));
        }
    }
    concave.report(
        report,
        "concaveFace",
        Severity::Note,
        "concave faces (angle, degrees)",
        "they do no harm as long as no other finding names them",
    );
}

fn concave_cells(g: &Geometry, ptr: &[u32], links: &[u32], report: &mut CheckReport) {
    let mut concave = Worst::new();
    for c in 0..g.volume.len() {
        let faces = &links[ptr[c] as usize..ptr[c + 1] as usize];
        let mut most = 0.0f64;
        for &e in faces {
            let f = (e >> 1) as usize;
            let out = scale(unit(g.area[f]), if e & 1 == 0 { 1.0 } else { -1.0 });
            let depth = dot(out, sub(g.face_centre[f], g.cell_centre[c]));
            for &other in faces.iter().filter(|&&o| o != e) {
                let beyond = dot(out, sub(g.face_centre[(other >> 1) as usize], g.face_centre[f]));
                most = most.max(beyond / depth.abs().max(f64::MIN_POSITIVE));
            }
        }
        if most > BENT {
            let place = Place::cell(g, c, most);
            concave.add(place, &[c as u32]);
        }
    }
    concave.report(
        report,
        "concaveCell",
        Severity::Note,
        "concave cells (how far a face lies beyond another's plane, in distances from the centre)",
        "they do no harm as long as no other finding names them",
    );
}
