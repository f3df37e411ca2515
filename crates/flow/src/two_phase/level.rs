//! Where the interface is above the ground, for the weight of the fluids.
//!
//! The density jumps at the interface, and its weight there is `-(G.x) grad rho` with x on the
//! interface. Face centres serve on meshes whose faces are level or upright. Elsewhere cells are cut
//! aslant, each face has a height of its own, and still water would flow: there the height is that
//! of the level surface which parts the cell as the volume fraction says, where neighbours agree
//! about it. Flat water then weighs the same wherever a mesh cuts it. Where they do not agree the
//! interface is not level, and face centres serve again.

use crate::vof::{Body, Corners};
use granflow_base::{Vec3, dot, norm, scale, unit};
use granflow_fv::{Gradient, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use std::cell::RefCell;

/// Fractions nearer to 0 or 1 than this have no interface.
const PURE: f64 = 1e-13;
/// Disagreement of neighbours over the height of the cell at which levels count for nothing.
const DISAGREED: f64 = 0.25;
/// Sine of the angle by which a face may lean and still be level or upright.
const ALIGNED: f64 = 1e-6;

thread_local! {
    static BODY: RefCell<(Body, Vec<f64>)> = RefCell::default();
}

/// The level surface of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Level {
    /// `G.x` on it, m2/s2.
    potential: f64,
    /// The same from the cell's lowest to its highest point; 0 without a level.
    height: f64,
}

/// Levels in the cells that hold both fluids.
pub(crate) struct Levels {
    corners: Corners,
    /// Whether the mesh needs them.
    needed: bool,
    gravity: Vec3,
    levels: Vec<Level>,
    /// `G.x` of the level surface, how much it counts against that of a neighbour (a sliver knows
    /// nothing), and against face centres. In cells and ghosts.
    potential: Vec<f64>,
    weight: Vec<f64>,
    share: Vec<f64>,
    gradient: Vec<Vec3>,
}

impl Levels {
    pub(crate) fn new(exec: &Exec, corners: Corners, mesh: &Mesh, gravity: Vec3) -> Levels {
        let down = unit(gravity);
        let leans = |f: usize| {
            let s = dot(down, mesh.normal(f)).abs();
            let d = if f < mesh.n_inner { dot(down, unit(mesh.delta[f])).abs() } else { s };
            // Level: both vertical; upright: both horizontal.
            let level = 1.0 - s < ALIGNED && 1.0 - d < ALIGNED;
            let upright = s < ALIGNED && d < ALIGNED;
            f64::from(u8::from(!(level || upright)))
        };
        let any = exec.max(mesh.n_faces(), |r| r.map(leans).fold(0.0, f64::max));
        let needed = norm(gravity) > 0.0 && any > 0.0;
        let size = if needed { mesh.n_all() } else { 0 };
        Levels {
            corners,
            needed,
            gravity,
            levels: vec![Level::default(); if needed { mesh.n_cells } else { 0 }],
            potential: vec![0.0; size],
            weight: vec![0.0; size],
            share: vec![0.0; size],
            gradient: vec![[0.0; 3]; size],
        }
    }

    /// The levels of `alpha`, whose conditions are up to date.
    pub(crate) fn update(&mut self, exec: &Exec, mesh: &Mesh, alpha: &Unknown<f64>) {
        if !self.needed {
            return;
        }
        Gradient::GaussLinear.of(exec, mesh, alpha, &mut self.gradient);
        let a = &alpha.cells.data;
        self.find(exec, mesh, a);
        let Levels { levels, potential, weight, share, .. } = self;
        for (c, level) in levels.iter().enumerate() {
            potential[c] = level.potential;
            let mixed = a[c].clamp(0.0, 1.0) * (1.0 - a[c].clamp(0.0, 1.0));
            weight[c] = if level.height > 0.0 { mixed } else { 0.0 };
        }
        mesh.halo.update(exec, potential);
        mesh.halo.update(exec, weight);
        let (levels, potential, weight) = (&*levels, &*potential, &*weight);
        exec.for_each(&mut share[..mesh.n_cells], |first, out| {
            for (i, share) in out.iter_mut().enumerate() {
                let c = first + i;
                *share = 0.0;
                if weight[c] == 0.0 {
                    continue;
                }
                let (mut apart, mut sum) = (0.0, 0.0);
                for (f, sign) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
                    let other = if sign > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] } as usize;
                    apart += weight[other] * (potential[other] - potential[c]).abs();
                    sum += weight[other];
                }
                let apart = if sum > 0.0 { apart / (sum * levels[c].height) } else { 0.0 };
                let t = (1.0 - apart / DISAGREED).max(0.0);
                *share = t * t * (3.0 - 2.0 * t);
            }
        });
        mesh.halo.update(exec, share);
    }

    /// The level surface of every mixed cell.
    fn find(&mut self, exec: &Exec, mesh: &Mesh, a: &[f64]) {
        let Levels { corners, gravity, gradient, levels, .. } = self;
        let (down, g) = (unit(*gravity), norm(*gravity));
        exec.for_each(levels, |first, levels| {
            BODY.with_borrow_mut(|(body, values)| {
                body.reserve(corners);
                values.reserve(corners.largest_cell[0].saturating_sub(values.len()));
                for (i, level) in levels.iter_mut().enumerate() {
                    let c = first + i;
                    *level = Level::default();
                    if !(PURE..=1.0 - PURE).contains(&a[c]) {
                        continue;
                    }
                    // Fluid 1 lies on the side that alpha's gradient points to.
                    let side = dot(gradient[c], down).signum();
                    let out = scale(down, -side);
                    body.load(corners, mesh, c);
                    values.clear();
                    values.extend(body.points().iter().map(|&x| dot(out, x)));
                    let at = body.find_level(values, Some(out), a[c]);
                    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                    let potential = dot(*gravity, mesh.cell_centre[c]) - side * g * at;
                    *level = Level { potential, height: g * (most - least) };
                }
            });
        });
    }

    /// `G.x` where the density jumps between the cells of face `f`.
    #[inline]
    pub(crate) fn on_face(&self, mesh: &Mesh, f: usize) -> f64 {
        let at_face = dot(self.gravity, mesh.face_centre[f]);
        if !self.needed {
            return at_face;
        }
        let o = mesh.owner[f] as usize;
        let (mut potential, mut weight) = (self.weight[o] * self.potential[o], self.weight[o]);
        let mut share = weight * self.share[o];
        if let Some(&n) = mesh.neighbour.get(f) {
            let n = n as usize;
            potential += self.weight[n] * self.potential[n];
            weight += self.weight[n];
            share += self.weight[n] * self.share[n];
        }
        if weight == 0.0 {
            return at_face;
        }
        let share = share / weight;
        share * (potential / weight) + (1.0 - share) * at_face
    }
}
