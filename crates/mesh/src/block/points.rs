//! Points of one block from its twelve edges.
//!
//! An inner point is a weighted mean of what the four edges along each direction say, plus the
//! departures of curved edges from straight ones, with the same weights. The weight of an edge
//! fades with the graded distance from it, so that all gradings and curves are met exactly.

use super::curve::Course;
use super::grading::{divide, reversed};
use super::{BlockMesh, CORNERS, EDGES};
use granflow_base::{Vec3, add, scale, sub};
use granflow_dict::Diag;

/// One divided edge: graded fractions, and by how much each point leaves the straight line.
struct Divided {
    fraction: Vec<f64>,
    departure: Option<Vec<Vec3>>,
}

/// Points of block `b`, the first direction running fastest, m.
///
/// # Errors
/// A diagnostic for a curve that cannot be drawn.
pub(super) fn points(mesh: &BlockMesh, b: usize) -> Result<Vec<Vec3>, Diag> {
    let block = &mesh.blocks[b];
    let corner = block.vertices.map(|v| mesh.vertices[v as usize]);
    let mut edges = Vec::with_capacity(12);
    for e in 0..12 {
        edges.push(divided(mesh, b, e)?);
    }
    let [nx, ny, nz] = block.n_points();
    let mut out = Vec::with_capacity(nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                out.push(inner_point(&edges, &corner, [i, j, k], block.cells));
            }
        }
    }
    Ok(out)
}

/// Edge `e` of block `b`, divided.
fn divided(mesh: &BlockMesh, b: usize, e: usize) -> Result<Divided, Diag> {
    let block = &mesh.blocks[b];
    let n = block.cells[e / 4];
    let ends = EDGES[e].map(|v| block.vertices[v]);
    let [from, to] = ends.map(|v| mesh.vertices[v as usize]);
    let sections = &block.grading[e];
    // The first edge written counts, as with every other look-up by vertices.
    let written = mesh
        .edges
        .iter()
        .find(|c| c.ends == ends || (c.ends == [ends[1], ends[0]] && ends[0] != ends[1]));
    let Some(curve) = written else {
        return Ok(Divided { fraction: divide(n, sections), departure: None });
    };
    let [first, last] = curve.ends.map(|v| mesh.vertices[v as usize]);
    let course = Course::new(&curve.curve, first, last)
        .map_err(|label| Diag::error(&curve.span, "this edge cannot be drawn").label(label))?;
    let forward = curve.ends == ends;
    let fraction = if forward {
        divide(n, sections)
    } else {
        divide(n, &reversed(sections)).iter().rev().map(|t| 1.0 - t).collect()
    };
    let line = Course::line(from, to);
    let departure = fraction
        .iter()
        .enumerate()
        .map(|(i, &t)| match i {
            0 => [0.0; 3],
            _ if i == n => [0.0; 3],
            _ => sub(course.at(if forward { t } else { 1.0 - t }), line.at(t)),
        })
        .collect();
    Ok(Divided { fraction, departure: Some(departure) })
}

fn inner_point(edges: &[Divided], corner: &[Vec3; 8], at: [usize; 3], cells: [usize; 3]) -> Vec3 {
    // Corners and edges are met to the last bit, not just to rounding.
    if let Some(v) = (0..8).find(|&v| (0..3).all(|d| at[d] == CORNERS[v][d] * cells[d])) {
        return corner[v];
    }
    let (mut sum, mut departure) = ([0.0; 3], [0.0; 3]);
    for d in 0..3 {
        let mut share = [0.0; 4];
        for (e, share) in share.iter_mut().enumerate() {
            let along = edges[4 * d + e].fraction[at[d]];
            let [a, b] = EDGES[4 * d + e];
            *share = (1.0 - along) * nearness(edges, a, d, at) + along * nearness(edges, b, d, at);
        }
        let total: f64 = share.iter().sum();
        for (e, share) in share.iter().enumerate() {
            let weight = share / total;
            let edge = &edges[4 * d + e];
            let [a, b] = EDGES[4 * d + e].map(|v| corner[v]);
            sum = add(sum, scale(Course::line(a, b).at(edge.fraction[at[d]]), weight));
            if let Some(away) = &edge.departure {
                departure = add(departure, scale(away[at[d]], weight));
            }
        }
    }
    add(scale(sum, 1.0 / 3.0), departure)
}

/// How near point `at` is to corner `v` across direction `d`, by the gradings of the edges that
/// meet in that corner: 1 at the corner, 0 at the far sides.
fn nearness(edges: &[Divided], v: usize, d: usize, at: [usize; 3]) -> f64 {
    let mut product = 1.0;
    for other in (0..3).filter(|&o| o != d) {
        let high = CORNERS[v][other] == 1;
        let e = (4 * other..4 * other + 4).find(|&e| EDGES[e].contains(&v)).unwrap_or(0);
        let x = edges[e].fraction[at[other]];
        product *= if high { x } else { 1.0 - x };
    }
    product
}
