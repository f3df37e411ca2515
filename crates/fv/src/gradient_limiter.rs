//! Limited gradients: what a cell's gradient says at its faces stays within the values around it.
//!
//! T. J. Barth, D. C. Jespersen, AIAA 89-0366 (1989) scale the whole gradient (`cellLimited`); the
//! multidimensional form takes away only what points at the face that is exceeded (`cellMDLimited`).
//! `faceLimited` and `faceMDLimited` ask the same of every face with the values of its two cells
//! alone. With the number behind the name at 1 nothing may be exceeded, at 0 everything.

use crate::{Differentiable, Unknown};
use granflow_base::{Value, Vec3, dot, sub};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// What the bounds are taken from and how they are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientLimit {
    /// All neighbours; the whole gradient is scaled.
    Cell,
    /// All neighbours; only the part along the way to the face is cut.
    CellMd,
    /// The two cells of a face; the whole gradient is scaled.
    Face,
    /// The two cells of a face; only the part along the way to the face is cut.
    FaceMd,
}

/// A limiter of gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientLimiter {
    /// Which.
    pub limit: GradientLimit,
    /// 1: bounded, 0: not limited at all; between, bounds are widened by `1/k - 1` of their
    /// distance.
    pub k: f64,
}

impl GradientLimiter {
    /// The limiters by their names in `fvSchemes`.
    pub const NAMES: [(&str, GradientLimit); 4] = [
        ("cellLimited", GradientLimit::Cell),
        ("cellMDLimited", GradientLimit::CellMd),
        ("faceLimited", GradientLimit::Face),
        ("faceMDLimited", GradientLimit::FaceMd),
    ];

    /// Limits `gradient` (own cells, then ghosts), the gradient of `phi`, whose closure and ghosts
    /// are up to date. Every component by itself.
    pub fn apply<T: Differentiable>(
        self,
        exec: &Exec,
        mesh: &Mesh,
        phi: &Unknown<T>,
        gradient: &mut [T::Gradient],
    ) {
        if self.k <= 0.0 {
            return;
        }
        exec.for_each(&mut gradient[..mesh.n_cells], |first, out| {
            for (i, g) in out.iter_mut().enumerate() {
                for component in 0..T::N {
                    *g = self.limited(mesh, phi, first + i, component, *g);
                }
            }
        });
        mesh.halo.update(exec, gradient);
    }

    /// The gradient `g` of cell `c` with its part of one component within bounds.
    fn limited<T: Differentiable>(
        self,
        mesh: &Mesh,
        phi: &Unknown<T>,
        c: usize,
        component: usize,
        mut g: T::Gradient,
    ) -> T::Gradient {
        let here = phi.cells.data[c].comp(component);
        let there = |f: usize, s: f64| {
            let value = if f >= mesh.n_inner {
                phi.boundary_value(mesh, f)
            } else if s > 0.0 {
                phi.cells.data[mesh.neighbour[f] as usize]
            } else {
                phi.cells.data[mesh.owner[f] as usize]
            };
            value.comp(component)
        };
        let widened = |[low, high]: [f64; 2]| {
            let more = (1.0 / self.k - 1.0) * (high - low);
            [low - here - more, high - here + more]
        };
        let around = match self.limit {
            GradientLimit::Cell | GradientLimit::CellMd => {
                let mut all = [here; 2];
                for (f, s) in mesh.faces_of(c) {
                    let value = there(f, s);
                    all = [all[0].min(value), all[1].max(value)];
                }
                Some(widened(all))
            }
            GradientLimit::Face | GradientLimit::FaceMd => None,
        };
        let bounds = |f: usize, s: f64| {
            around.unwrap_or_else(|| {
                let value = there(f, s);
                widened([here.min(value), here.max(value)])
            })
        };
        let piecewise = matches!(self.limit, GradientLimit::CellMd | GradientLimit::FaceMd);
        let mut kept = 1.0f64;
        for (f, s) in mesh.faces_of(c) {
            let arm = arm_of(mesh, c, f, s);
            let change = T::along(g, arm).comp(component);
            let [low, high] = bounds(f, s);
            if change > high || change < low {
                let most = if change > high { high } else { low };
                if piecewise {
                    let mut excess = T::ZERO;
                    excess.set_comp(component, (most - change) / dot(arm, arm));
                    g = g.plus(T::dyad(arm, excess));
                } else {
                    kept = kept.min(most / change);
                }
            }
        }
        if kept < 1.0 {
            for k in 0..3 {
                let mut along = [0.0; 3];
                along[k] = 1.0;
                let mut part = T::ZERO;
                part.set_comp(component, T::along(g, along).comp(component));
                g = g.axpy(kept - 1.0, T::dyad(along, part));
            }
        }
        g
    }
}

/// From the centre of cell `c` to that of its face `f`, which it owns if `s > 0`.
#[inline]
fn arm_of(mesh: &Mesh, c: usize, f: usize, s: f64) -> Vec3 {
    if s > 0.0 || f >= mesh.n_inner {
        return sub(mesh.face_centre[f], mesh.cell_centre[c]);
    }
    // By way of the owner: across cyclic faces the neighbour is elsewhere.
    let owner = mesh.owner[f] as usize;
    sub(sub(mesh.face_centre[f], mesh.cell_centre[owner]), mesh.delta[f])
}
