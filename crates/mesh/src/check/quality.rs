//! Checks of volumes, areas and angles.

use super::Worst;
use super::report::{CheckReport, Place, Severity};
use crate::geometry::Geometry;
use crate::polymesh::{PatchKind, PolyMesh};
use granflow_base::{Vec3, add, dot, norm, scale, sub, unit};

/// Angle beyond which the explicit correction of gradients gets weak, degrees.
const STEEP: f64 = 70.0;
/// Skewness beyond which face values are poor.
const SKEW: f64 = 4.0;
/// Aspect ratio beyond which linear solvers slow down.
const THIN: f64 = 1000.0;
/// Volume ratio of neighbours beyond which second order is lost.
const JUMP: f64 = 10.0;

pub(super) fn check(
    poly: &PolyMesh,
    g: &Geometry,
    (ptr, links): &(Vec<u32>, Vec<u32>),
    report: &mut CheckReport,
) {
    bounds(poly, report);
    cells(poly, g, ptr, links, report);
    faces(poly, g, report);
}

fn bounds(poly: &PolyMesh, report: &mut CheckReport) {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &poly.points {
        for d in 0..3 {
            lo[d] = lo[d].min(p[d]);
            hi[d] = hi[d].max(p[d]);
        }
    }
    report.bounds = [lo, hi];
}

fn cells(poly: &PolyMesh, g: &Geometry, ptr: &[u32], links: &[u32], report: &mut CheckReport) {
    let place = |c: usize, value: f64| Place::cell(g, c, value);
    // Directions that an empty patch takes out do not count towards the aspect ratio.
    let mut flat = [0.0; 3];
    for f in poly.patches.iter().filter(|p| p.kind == PatchKind::Empty).flat_map(|p| p.faces()) {
        (0..3).for_each(|d| flat[d] += g.area[f][d].abs());
    }
    let most = flat.iter().copied().fold(0.0, f64::max);
    let solved = flat.map(|x| most == 0.0 || x < 1e-3 * most);
    let q = &mut report.quality;
    let least = g.volume.iter().copied().fold(f64::INFINITY, f64::min);
    q.volume = [least, g.volume.iter().copied().fold(f64::NEG_INFINITY, f64::max)];
    q.total_volume = g.volume.iter().sum();
    let (mut inverted, mut open, mut thin) = (Worst::new(), Worst::new(), Worst::new());
    for c in 0..g.volume.len() {
        let (mut sum, mut sides): (Vec3, Vec3) = ([0.0; 3], [0.0; 3]);
        let mut surface = 0.0;
        for &e in &links[ptr[c] as usize..ptr[c + 1] as usize] {
            let a = g.area[(e >> 1) as usize];
            sum = add(sum, scale(a, if e & 1 == 0 { 1.0 } else { -1.0 }));
            sides = add(sides, a.map(f64::abs));
            surface += norm(a);
        }
        let v = g.volume[c];
        if v.is_nan() || v <= 0.0 {
            // Worst is greatest: the most negative comes first.
            inverted.add(place(c, -v), &[c as u32]);
        }
        let openness = norm(sum) / surface.max(f64::MIN_POSITIVE);
        q.max_openness = q.max_openness.max(openness);
        if openness > 1e-6 {
            open.add(place(c, openness), &[c as u32]);
        }
        let used = || (0..3).filter(|&d| solved[d]).map(|d| sides[d]);
        let (lo, hi) = (used().fold(f64::INFINITY, f64::min), used().fold(0.0, f64::max));
        // A cell's projections see extents along the axes, its surface those across them.
        let mut aspect = hi / lo.max(f64::MIN_POSITIVE);
        if solved == [true; 3] && v > 0.0 {
            aspect = aspect.max(surface / 6.0 / v.powf(2.0 / 3.0));
        }
        q.max_aspect = q.max_aspect.max(aspect);
        if aspect > THIN {
            thin.add(place(c, aspect), &[c as u32]);
        }
    }
    inverted.of_least().report(
        report,
        "volume",
        Severity::Error,
        "cells of no or negative volume (m3)",
        "the block or its vertices are inside out, or points have crossed over",
    );
    open.report(
        report,
        "openCell",
        Severity::Error,
        "cells with an open surface (sum of area vectors relative to the surface)",
        "faces are missing or turn the wrong way: make the mesh again",
    );
    thin.report(
        report,
        "aspectRatio",
        Severity::Warning,
        "very elongated cells (aspect ratio)",
        "fewer cells or a weaker grading along the short direction",
    );
}

fn faces(poly: &PolyMesh, g: &Geometry, report: &mut CheckReport) {
    let place = |f: usize, value: f64| Place::face(g, f, value);
    let n_inner = poly.n_inner();
    let q = &mut report.quality;
    q.area = [f64::INFINITY, 0.0];
    let (mut null, mut warped) = (Worst::new(), Worst::new());
    let (mut backward, mut steep, mut skewed, mut jump) =
        (Worst::new(), Worst::new(), Worst::new(), Worst::new());
    let mut total_cosine = 0.0;
    for f in 0..poly.n_faces() {
        let (area, centre) = (g.area[f], g.face_centre[f]);
        let (mag, normal) = (norm(area), unit(area));
        q.area = [q.area[0].min(mag), q.area[1].max(mag)];
        let reach = |v: Vec3| {
            let along = |&p: &u32| dot(v, sub(poly.points[p as usize], centre)).abs();
            poly.face(f).iter().map(along).fold(0.0, f64::max)
        };
        let size = poly.face(f).iter().map(|&p| norm(sub(poly.points[p as usize], centre)));
        let size = size.fold(0.0, f64::max);
        if mag.is_nan() || mag <= 1e-12 * size * size {
            null.add(place(f, mag), &poly.cells_of(f));
            continue;
        }
        let bulge = reach(normal) / size;
        if bulge > 0.3 {
            warped.add(place(f, bulge), &poly.cells_of(f));
        }
        let o = g.cell_centre[poly.owner[f] as usize];
        let delta = match poly.neighbour.get(f) {
            Some(&n) => sub(g.cell_centre[n as usize], o),
            None => scale(normal, dot(normal, sub(centre, o))),
        };
        let across = dot(normal, delta);
        if f < n_inner {
            let angle = (across / norm(delta)).clamp(-1.0, 1.0).acos().to_degrees();
            total_cosine += across / norm(delta);
            q.max_nonorth_deg = q.max_nonorth_deg.max(angle);
            if angle.is_nan() || angle >= 90.0 {
                backward.add(place(f, angle), &poly.cells_of(f));
            } else if angle > STEEP {
                steep.add(place(f, angle), &poly.cells_of(f));
            }
            let v = [poly.owner[f], poly.neighbour[f]].map(|c| g.volume[c as usize]);
            let ratio = v[0].max(v[1]) / v[0].min(v[1]).max(f64::MIN_POSITIVE);
            if v[0] > 0.0 && v[1] > 0.0 {
                q.max_volume_ratio = q.max_volume_ratio.max(ratio);
                if ratio > JUMP {
                    jump.add(place(f, ratio), &poly.cells_of(f));
                }
            }
        }
        if across > 0.0 {
            let pierced = add(o, scale(delta, dot(normal, sub(centre, o)) / across));
            let off = sub(centre, pierced);
            // Across the boundary lies the cell's mirror image.
            let span = if f < n_inner { norm(delta) } else { 2.0 * norm(delta) };
            let scale_of = (0.2 * span).max(reach(unit(off)));
            let skewness = norm(off) / scale_of;
            q.max_skewness = q.max_skewness.max(skewness);
            if skewness > SKEW {
                skewed.add(place(f, skewness), &poly.cells_of(f));
            }
        }
    }
    let cosine = if n_inner == 0 { 1.0 } else { total_cosine / n_inner as f64 };
    q.mean_nonorth_deg = cosine.clamp(-1.0, 1.0).acos().to_degrees();
    null.report(
        report,
        "faceArea",
        Severity::Error,
        "faces without area (m2)",
        "merge their points",
    );
    backward.report(
        report,
        "overlap",
        Severity::Error,
        "faces that do not separate the centres of their cells (angle, degrees)",
        "cells overlap or are badly distorted there: smooth or coarsen the mesh",
    );
    steep.report(
        report,
        "nonOrthogonality",
        Severity::Warning,
        "steeply non-orthogonal faces (angle, degrees)",
        "use `limited 0.5` for snGradSchemes and laplacianSchemes, and 1 or 2 nNonOrthogonalCorrectors",
    );
    skewed.report(
        report,
        "skewness",
        Severity::Warning,
        "badly skewed faces (distance off the line of centres, in face sizes)",
        "make neighbouring cells more alike; accuracy suffers there",
    );
    jump.report(
        report,
        "volumeRatio",
        Severity::Warning,
        "faces between cells of very different size (ratio of volumes)",
        "a gentler grading: neighbours should not differ by more than 20 %",
    );
    warped.report(
        report,
        "warpage",
        Severity::Warning,
        "warped faces (departure from their plane, relative to their size)",
        "straighten the edges or split the faces",
    );
}
