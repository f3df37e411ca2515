//! Checks that need no coordinates (they only say where).

use super::report::{CellShapes, CheckReport, Finding, PatchSummary, Place, Severity};
use super::{NO_CELLS, Worst};
use crate::geometry::Geometry;
use crate::polymesh::{PatchKind, PolyMesh};
use granflow_base::norm;

pub(super) fn check(
    poly: &PolyMesh,
    g: &Geometry,
    (ptr, links): &(Vec<u32>, Vec<u32>),
    report: &mut CheckReport,
) {
    report.points = poly.points.len();
    report.faces = poly.n_faces();
    report.inner_faces = poly.n_inner();
    report.cells = poly.n_cells();
    report.patches = poly
        .patches
        .iter()
        .map(|p| PatchSummary {
            name: p.name.clone(),
            kind: p.kind.word(),
            faces: p.len,
            area: p.faces().map(|f| norm(g.area[f])).sum(),
        })
        .collect();
    let cell = |c: usize| &links[ptr[c] as usize..ptr[c + 1] as usize];
    let at_cell = |c: usize, value: f64| Place::cell(g, c, value);
    let at_face = |f: usize, value: f64| Place::face(g, f, value);

    let (mut few, mut open) = (Worst::new(), Worst::new());
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for c in 0..report.cells {
        count_shape(poly, cell(c), &mut report.shapes);
        if cell(c).len() < 4 {
            few.add(at_cell(c, cell(c).len() as f64), &[c as u32]);
        }
        // In a closed surface whose faces all turn outwards every edge runs once each way.
        edges.clear();
        for &e in cell(c) {
            let ring = poly.face((e >> 1) as usize);
            for (i, &a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                edges.push(if e & 1 == 0 { (a, b) } else { (b, a) });
            }
        }
        edges.sort_unstable();
        let lonely = edges.iter().filter(|&&(a, b)| edges.binary_search(&(b, a)).is_err()).count();
        let double = edges.windows(2).filter(|w| w[0] == w[1]).count();
        if lonely + double > 0 {
            open.add(at_cell(c, (lonely + double) as f64), &[c as u32]);
        }
    }
    few.report(
        report,
        "fewFaces",
        Severity::Error,
        "cells with fewer than 4 faces",
        "make the mesh again",
    );
    open.report(
        report,
        "notClosed",
        Severity::Error,
        "cells that are not closed, or have faces that turn the wrong way (edges that do not pair up)",
        "the points of a face must turn counter-clockwise seen from the neighbour or from outside",
    );

    let mut repeated = Worst::new();
    for f in 0..poly.n_faces() {
        let mut ring = poly.face(f).to_vec();
        ring.sort_unstable();
        let n = ring.windows(2).filter(|w| w[0] == w[1]).count();
        if n > 0 {
            repeated.add(at_face(f, n as f64), &poly.cells_of(f));
        }
    }
    repeated.report(
        report,
        "repeatedPoint",
        Severity::Error,
        "faces that use a point twice",
        "make the mesh again",
    );

    let mut used = vec![false; poly.points.len()];
    poly.face_points.iter().for_each(|&p| used[p as usize] = true);
    let mut unused = Worst::new();
    for p in (0..used.len()).filter(|&p| !used[p]) {
        unused.add(
            Place { what: "point", index: p, at: poly.points[p], value: 0.0, cells: NO_CELLS },
            &[],
        );
    }
    unused.report(
        report,
        "unusedPoint",
        Severity::Note,
        "points that belong to no face",
        "they do no harm",
    );

    order(poly, report);
    empty_patches(poly, report);
    let pieces = pieces(poly, report.cells);
    if pieces > 1 {
        report.findings.push(Finding::whole(
            Severity::Warning,
            format!("the mesh consists of {pieces} pieces that do not touch"),
            "each piece needs a pressure reference of its own; were blocks meant to share vertices?",
        ));
    }
}

fn count_shape(poly: &PolyMesh, links: &[u32], shapes: &mut CellShapes) {
    let corners = |n| links.iter().filter(|&&e| poly.face((e >> 1) as usize).len() == n).count();
    let slot = match (links.len(), corners(3), corners(4)) {
        (6, 0, 6) => &mut shapes.hexahedra,
        (5, 2, 3) => &mut shapes.prisms,
        (5, 4, 1) => &mut shapes.pyramids,
        (4, 4, 0) => &mut shapes.tetrahedra,
        _ => &mut shapes.polyhedra,
    };
    *slot += 1;
}

fn order(poly: &PolyMesh, report: &mut CheckReport) {
    let turned = poly.owner.iter().zip(&poly.neighbour).filter(|(o, n)| o > n).count();
    let pairs = poly.owner.iter().zip(&poly.neighbour);
    if turned > 0 || !pairs.is_sorted() {
        report.findings.push(Finding::whole(
            Severity::Note,
            "the inner faces are not in upper-triangular order".into(),
            "granflow renumbers the mesh when it loads it; other programs may refuse it",
        ));
    }
}

fn empty_patches(poly: &PolyMesh, report: &mut CheckReport) {
    let faces: usize =
        poly.patches.iter().filter(|p| p.kind == PatchKind::Empty).map(|p| p.len).sum();
    if !faces.is_multiple_of(2 * report.cells) {
        report.findings.push(Finding::whole(
            Severity::Error,
            format!("{} cells have {faces} faces on empty patches", report.cells),
            "a two-dimensional mesh is one cell thick: two empty faces a cell. Use another patch \
             type where the mesh is three-dimensional",
        ));
    }
}

/// Number of connected pieces.
fn pieces(poly: &PolyMesh, n_cells: usize) -> usize {
    let mut up: Vec<u32> = (0..n_cells as u32).collect();
    fn root(up: &mut [u32], mut c: u32) -> u32 {
        while up[c as usize] != c {
            up[c as usize] = up[up[c as usize] as usize];
            c = up[c as usize];
        }
        c
    }
    let mut n = n_cells;
    for (&a, &b) in poly.owner.iter().zip(&poly.neighbour) {
        let (a, b) = (root(&mut up, a), root(&mut up, b));
        if a != b {
            up[a.max(b) as usize] = a.min(b);
            n -= 1;
        }
    }
    n
}
