//! Geometry of field figures: values at the points of a mesh, cells cut by a plane, the outside
//! of a mesh, surfaces of equal value.

mod chain;
mod nodes;
mod plane;
mod surface;
mod twins;

pub(crate) use chain::{chain, level_segments};
pub(crate) use nodes::{Grid, Samples};
pub(crate) use plane::{OnEdge, Polygon, cut};
pub(crate) use surface::{edges, iso, iso_triangles, outside, with_centres};

use granflow_base::{Vec3, add, scale};

/// Values that a corner carries: of the field, of a vector or a normal, of other fields.
pub(crate) const CARRIED: usize = 8;
/// Where the three components of the vector start.
pub(crate) const VECTOR: usize = 1;
/// Where other fields start.
pub(crate) const OTHERS: usize = 4;

/// A corner of a triangle with what is known there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Corner {
    pub(crate) at: Vec3,
    pub(crate) v: [f64; CARRIED],
}

impl Corner {
    /// The corner at `t` of the way to another one.
    pub(crate) fn towards(&self, o: &Corner, t: f64) -> Corner {
        let mut v = self.v;
        v.iter_mut().zip(o.v).for_each(|(a, b)| *a += t * (b - *a));
        Corner { at: add(scale(self.at, 1.0 - t), scale(o.at, t)), v }
    }
}

/// A triangle and the cell it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) cell: usize,
    pub(crate) corners: [Corner; 3],
}

/// The parts of triangles where `v[slot]` is at least `bound`, or at most for a `sign` of -1.
pub(crate) fn clip(pieces: Vec<Piece>, slot: usize, bound: f64, sign: f64) -> Vec<Piece> {
    let mut out = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let over = piece.corners.map(|c| sign * (c.v[slot] - bound));
        if over.iter().all(|o| *o >= 0.0) {
            out.push(piece);
            continue;
        }
        let mut polygon: Vec<Corner> = Vec::with_capacity(4);
        for i in 0..3 {
            let j = (i + 1) % 3;
            if over[i] >= 0.0 {
                polygon.push(piece.corners[i]);
            }
            if (over[i] >= 0.0) != (over[j] >= 0.0) {
                polygon.push(crossing(&piece.corners[i], &piece.corners[j], over[i], over[j]));
            }
        }
        for k in 2..polygon.len() {
            let corners = [polygon[0], polygon[k - 1], polygon[k]];
            out.push(Piece { cell: piece.cell, corners });
        }
    }
    out
}

/// Where the excess over a bound vanishes; the same from both ends.
fn crossing(a: &Corner, b: &Corner, over_a: f64, over_b: f64) -> Corner {
    if over_a >= 0.0 {
        a.towards(b, over_a / (over_a - over_b))
    } else {
        b.towards(a, over_b / (over_b - over_a))
    }
}
