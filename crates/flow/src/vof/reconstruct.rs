//! Where the interface is: a plane in every cell that holds both fluids.
//!
//! - `isoAlpha`: fractions are interpolated to the points, and the iso-surface whose volume
//!   matches the cell's fraction is the interface (Roenby, Bredmose & Jasak, R. Soc. Open Sci. 3
//!   (2016) 160405, section 3.1).
//! - `gradAlpha`: a plane normal to the least-squares gradient of alpha, at the place that
//!   matches the fraction.
//! - `plicRDF`: the same with the normal taken from a distance function rebuilt from the planes
//!   around, again and again until the normals rest (Scheufler & Roenby, J. Comput. Phys. 383
//!   (2019) 1). Second order on any mesh.

use super::body::Body;
use super::corners::Corners;
use super::stencil::Stencil;
use granflow_base::{Tensor, Value, Vec3, dot, inverse_symmetric, norm, scale, sub, unit};
use granflow_fv::Differentiable;
use granflow_mesh::Mesh;
use granflow_par::Exec;
use std::cell::RefCell;

/// Entries of the lists of mixed cells that a thread takes at a time.
pub(super) const BLOCK: usize = 32;

/// How the interface is found (`reconstructionScheme`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reconstruct {
    /// Iso-surfaces of interpolated fractions.
    IsoAlpha,
    /// Planes normal to the gradient of alpha.
    GradAlpha,
    /// Planes normal to the gradient of a reconstructed distance function.
    #[default]
    PlicRdf,
}

impl Reconstruct {
    /// All names, as in `fvSolution`.
    pub const NAMES: [&str; 3] = ["isoAlpha", "gradAlpha", "plicRDF"];
    /// The scheme of that name.
    pub fn parse(name: &str) -> Option<Reconstruct> {
        use Reconstruct::{GradAlpha, IsoAlpha, PlicRdf};
        let all = [IsoAlpha, GradAlpha, PlicRdf];
        all.into_iter().zip(Self::NAMES).find(|x| x.1 == name).map(|x| x.0)
    }
}

/// The interface of all cells, in wide arrays (see [`Stencil`]).
#[derive(Clone, Debug, Default)]
pub struct Interface {
    /// Unit normal out of fluid 1; null where there is no interface.
    pub normal: Vec<Vec3>,
    /// Centre of the interface relative to the cell's centroid, m.
    pub offset: Vec<Vec3>,
    /// Area of the interface in own cells, m2.
    pub area: Vec<f64>,
}

/// One cell's plane while it is worked out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plane {
    pub(super) normal: Vec3,
    pub(super) offset: Vec3,
    pub(super) area: f64,
}

/// Finds the interface; owns what that takes.
pub struct Reconstructor {
    scheme: Reconstruct,
    /// Fractions nearer to 0 or 1 than this belong to one fluid.
    mixed_tolerance: f64,
    /// The interface found last.
    pub interface: Interface,
    /// Fractions in the wide layout.
    pub(super) alpha: Vec<f64>,
    /// Own mixed cells, in order.
    pub(super) mixed: Vec<u32>,
    /// Own cells that are mixed or share a corner with one that is, in order.
    pub(super) near: Vec<u32>,
    is_near: Vec<bool>,
    planes: Vec<Plane>,
    near_values: Vec<f64>,
    distance: Vec<f64>,
    foot_normal: Vec<Vec3>,
    /// Directions that are solved for.
    solved: [bool; 3],
}

/// Greatest number of times normals are taken from distances. (The paper allows 5. With normals
/// turned to the interface's centre, the fourth and fifth change nothing but under-resolved
/// filaments, and those not for the better.)
const ITERATIONS: usize = 3;
/// Mean of `1 - n . n_old` at which normals rest.
const REST: f64 = 1e-6;
/// Planes at a greater angle than this belong to another part of the interface.
const LEAST_COSINE: f64 = 0.8;
/// No curve that the mesh resolves turns more than this within a cell, radians.
const MOST_TURN: f64 = 0.2;

thread_local! {
    static BODY: RefCell<(Body, Vec<f64>)> = RefCell::default();
}

impl Reconstructor {
    /// Work arrays for a mesh.
    pub fn new(mesh: &Mesh, stencil: &Stencil, scheme: Reconstruct, mixed_tolerance: f64) -> Self {
        let (n, all) = (stencil.n_cells, stencil.n_all);
        Reconstructor {
            scheme,
            mixed_tolerance,
            interface: Interface {
                normal: vec![[0.0; 3]; all],
                offset: vec![[0.0; 3]; all],
                area: vec![0.0; n],
            },
            alpha: vec![0.0; all],
            mixed: Vec::with_capacity(n),
            near: Vec::with_capacity(n),
            is_near: vec![false; n],
            planes: Vec::with_capacity(n),
            near_values: Vec::with_capacity(n),
            distance: vec![0.0; all],
            foot_normal: vec![[0.0; 3]; all],
            solved: mesh.solved_dirs,
        }
    }

    /// Whether a cell of the wide layout holds an interface.
    #[inline]
    pub(super) fn has_interface(&self, c: usize) -> bool {
        self.interface.normal[c] != [0.0; 3]
    }

    /// Finds the interface of `alpha` (own cells) and returns how often normals were improved.
    pub fn update(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        corners: &Corners,
        stencil: &Stencil,
        alpha: &[f64],
    ) -> usize {
        let n = stencil.n_cells;
        self.alpha[..n].copy_from_slice(&alpha[..n]);
        stencil.halo.update(exec, &mut self.alpha);
        self.list_cells(stencil);
        self.planes.clear();
        self.planes.resize(self.mixed.len(), Plane::default());
        match self.scheme {
            Reconstruct::IsoAlpha => {
                self.place_surfaces(exec, mesh, corners, stencil);
                self.publish(exec, stencil);
                0
            }
            Reconstruct::GradAlpha => {
                self.normals_from(exec, stencil, -1.0, Source::Alpha);
                self.place_planes(exec, mesh, corners);
                self.publish(exec, stencil);
                0
            }
            Reconstruct::PlicRdf => {
                self.normals_from(exec, stencil, -1.0, Source::Alpha);
                self.place_planes(exec, mesh, corners);
                self.publish(exec, stencil);
                for i in 1..=ITERATIONS {
                    self.rebuild_distance(exec, stencil);
                    self.normals_from(exec, stencil, 1.0, Source::Distance);
                    let change = self.shift_normals(exec, stencil);
                    self.place_planes(exec, mesh, corners);
                    self.publish(exec, stencil);
                    if change <= REST {
                        return i;
                    }
                }
                ITERATIONS
            }
        }
    }

    /// Lists mixed cells and those near them. One pass over all cells, then only over the few.
    fn list_cells(&mut self, stencil: &Stencil) {
        let n = stencil.n_cells;
        let tol = self.mixed_tolerance;
        let is_mixed = |a: f64| a > tol && a < 1.0 - tol;
        for &c in &self.near {
            self.is_near[c as usize] = false;
        }
        for &c in &self.mixed {
            self.interface.area[c as usize] = 0.0;
            self.interface.normal[c as usize] = [0.0; 3];
        }
        self.mixed.clear();
        self.near.clear();
        for c in 0..self.alpha.len() {
            if !is_mixed(self.alpha[c]) {
                continue;
            }
            if c < n {
                self.mixed.push(c as u32);
                self.mark(c as u32);
            }
            for &d in stencil.around(c) {
                if (d as usize) < n {
                    self.mark(d);
                }
            }
        }
        self.near.sort_unstable();
    }

    fn mark(&mut self, c: u32) {
        if !self.is_near[c as usize] {
            self.is_near[c as usize] = true;
            self.near.push(c);
        }
    }

    /// Normals of the mixed cells along the gradient of alpha or of the distance, times `sign`.
    /// The distance of a cell behind a film belongs to the film's other side, which says nothing
    /// about this one.
    fn normals_from(&mut self, exec: &Exec, stencil: &Stencil, sign: f64, of: Source) {
        let values = match of {
            Source::Alpha => &self.alpha,
            Source::Distance => &self.distance,
        };
        let by_alpha = matches!(of, Source::Alpha);
        let (mixed, solved, old) = (&self.mixed, self.solved, &self.interface.normal);
        exec.for_each_block(&mut self.planes, BLOCK, |first, planes| {
            for (i, p) in planes.iter_mut().enumerate() {
                let c = mixed[first + i] as usize;
                let this_side = |d: usize| by_alpha || dot(old[d], old[c]) >= 0.0;
                let g = gradient(stencil, solved, c, |d| {
                    this_side(d).then(|| sign * (values[d] - values[c]))
                });
                // A cell alone among equals has no direction; it keeps the one it had.
                if norm(g) > 0.0 && norm(g).is_finite() {
                    p.normal = unit(g);
                }
            }
        });
    }

    /// The gradient of the distance at a cell's centre is the normal at the foot of the
    /// perpendicular from there, which lies beside the interface's centre by as much as the cell
    /// is wide: turns each normal by what the interface bends on the way. Without it normals are
    /// first order. Returns the mean of `1 - n . n_old` over all ranks.
    fn shift_normals(&mut self, exec: &Exec, stencil: &Stencil) -> f64 {
        for (&c, p) in self.mixed.iter().zip(&self.planes) {
            self.foot_normal[c as usize] = p.normal;
        }
        stencil.halo.update(exec, &mut self.foot_normal);
        let Reconstructor { mixed, planes, foot_normal, distance, interface, solved, .. } = self;
        let Interface { normal: old, offset, .. } = &*interface;
        let (mixed, foot_normal, distance) = (&*mixed, &*foot_normal, &*distance);
        exec.for_each_block(planes, BLOCK, |first, planes| {
            for (i, p) in planes.iter_mut().enumerate() {
                let c = mixed[first + i] as usize;
                let n = foot_normal[c];
                let along = |v: Vec3| v.axpy(-dot(n, v), n);
                let foot = |d: usize| stencil.centre[d].axpy(-distance[d], foot_normal[d]);
                let (mut m, mut rhs, here) = ([0.0; 9], [0.0; 9], foot(c));
                for &d in stencil.around(c) {
                    let d = d as usize;
                    if old[d] == [0.0; 3] || dot(foot_normal[d], n) < LEAST_COSINE {
                        continue;
                    }
                    let arm = along(sub(foot(d), here));
                    let w = 1.0 / dot(arm, arm).max(f64::MIN_POSITIVE);
                    m = m.axpy(w, Vec3::dyad(arm, arm));
                    rhs = rhs.axpy(w, Vec3::dyad(arm, along(sub(foot_normal[d], n))));
                }
                // Nothing is known across the interface, nor along what is not solved for.
                let size = m[0] + m[4] + m[8];
                m = m.axpy(size, Vec3::dyad(n, n));
                (0..3).filter(|&k| !solved[k]).for_each(|k| m[4 * k] += size);
                let bend = solve(&ridged_inverse(m, 1e-6), rhs);
                let way = along(offset[c]);
                let turn: Vec3 =
                    std::array::from_fn(|j| (0..3).map(|k| bend[3 * k + j] * way[k]).sum());
                if norm(turn) < MOST_TURN {
                    p.normal = unit(n.axpy(1.0, turn));
                }
            }
        });
        let planes = &*planes;
        let [change, count] = exec.sums(planes.len(), |r| {
            let one = |k: usize| 1.0 - dot(planes[k].normal, old[mixed[k] as usize]);
            [r.clone().map(one).sum(), r.len() as f64]
        });
        if count > 0.0 { change / count } else { 0.0 }
    }

    /// Moves each plane to where it matches its cell's fraction.
    fn place_planes(&mut self, exec: &Exec, mesh: &Mesh, corners: &Corners) {
        let (mixed, alpha) = (&self.mixed, &self.alpha);
        exec.for_each_block(&mut self.planes, BLOCK, |first, planes| {
            with_body(corners, |body, values| {
                for (i, p) in planes.iter_mut().enumerate() {
                    let c = mixed[first + i] as usize;
                    if p.normal != [0.0; 3] {
                        body.load(corners, mesh, c);
                        *p = plane_in(body, values, p.normal, alpha[c]);
                    }
                }
            });
        });
    }

    /// The iso-surface of interpolated fractions in each mixed cell.
    fn place_surfaces(&mut self, exec: &Exec, mesh: &Mesh, corners: &Corners, stencil: &Stencil) {
        let (mixed, alpha, solved) = (&self.mixed, &self.alpha, self.solved);
        exec.for_each_block(&mut self.planes, BLOCK, |first, planes| {
            with_body(corners, |body, values| {
                for (i, p) in planes.iter_mut().enumerate() {
                    let c = mixed[first + i] as usize;
                    body.load(corners, mesh, c);
                    point_values(body, stencil, corners, alpha, values);
                    let level = body.find_level(values, None, alpha[c]);
                    *p = match body.section(level, values) {
                        Some(s) => {
                            Plane { normal: unit(s.area), offset: s.centre, area: norm(s.area) }
                        }
                        // Points all alike: the gradient of the cells around must do.
                        None => {
                            let g = gradient(stencil, solved, c, |d| Some(alpha[c] - alpha[d]));
                            plane_in(body, values, unit(g), alpha[c])
                        }
                    };
                }
            });
        });
    }

    /// Writes the planes to the wide arrays and fills the ghosts.
    fn publish(&mut self, exec: &Exec, stencil: &Stencil) {
        let to = &mut self.interface;
        for (&c, p) in self.mixed.iter().zip(&self.planes) {
            let c = c as usize;
            (to.normal[c], to.offset[c], to.area[c]) = (p.normal, p.offset, p.area);
        }
        stencil.halo.update(exec, &mut to.normal);
        stencil.halo.update(exec, &mut to.offset);
    }

    /// Signed distance from the interface near it: from its own plane in a mixed cell, elsewhere
    /// the mean over the planes around, each the heavier the nearer it is and the straighter the
    /// cell lies ahead of it. (Nearness is not in the paper. It halves the error where filaments
    /// are as thin as the mesh.)
    fn rebuild_distance(&mut self, exec: &Exec, stencil: &Stencil) {
        let Interface { normal, offset, .. } = &self.interface;
        let near = &self.near;
        self.near_values.clear();
        self.near_values.resize(near.len(), 0.0);
        exec.for_each_block(&mut self.near_values, BLOCK, |first, out| {
            for (i, psi) in out.iter_mut().enumerate() {
                let c = near[first + i] as usize;
                if normal[c] != [0.0; 3] {
                    *psi = -dot(normal[c], offset[c]);
                    continue;
                }
                let (mut sum, mut weight) = (0.0, 0.0);
                for &d in stencil.around(c) {
                    let d = d as usize;
                    if normal[d] == [0.0; 3] {
                        continue;
                    }
                    let arm = sub(sub(stencil.centre[c], stencil.centre[d]), offset[d]);
                    let ahead = dot(normal[d], arm);
                    let w = (ahead / dot(arm, arm).max(f64::MIN_POSITIVE)).powi(2);
                    sum += w * ahead;
                    weight += w;
                }
                *psi = if weight > 0.0 { sum / weight } else { 0.0 };
            }
        });
        for (&c, &psi) in near.iter().zip(&self.near_values) {
            self.distance[c as usize] = psi;
        }
        stencil.halo.update(exec, &mut self.distance);
    }
}

/// What normals come from.
enum Source {
    Alpha,
    Distance,
}

/// A body of this thread, with room for the largest cell and for values at its corners.
pub(super) fn with_body<R>(corners: &Corners, f: impl FnOnce(&mut Body, &mut Vec<f64>) -> R) -> R {
    BODY.with_borrow_mut(|(body, values)| {
        body.reserve(corners);
        values.reserve(corners.largest_cell[0].saturating_sub(values.len()));
        f(body, values)
    })
}

/// The plane with a given normal that leaves the share `alpha` of the body behind it.
pub(super) fn plane_in(body: &mut Body, values: &mut Vec<f64>, normal: Vec3, alpha: f64) -> Plane {
    values.clear();
    values.extend(body.points().iter().map(|&p| dot(normal, p)));
    let level = body.find_level(values, Some(normal), alpha);
    match body.section(level, values) {
        Some(s) => Plane { normal, offset: s.centre, area: norm(s.area) },
        None => Plane { normal, offset: scale(normal, level), area: 0.0 },
    }
}

/// Minus the fractions at the corners of a body: inverse distances weigh the cells around. The
/// middle of a warped face takes the mean of its corners.
fn point_values(
    body: &Body,
    stencil: &Stencil,
    corners: &Corners,
    alpha: &[f64],
    values: &mut Vec<f64>,
) {
    values.clear();
    for &p in body.labels() {
        let (mut sum, mut weight) = (0.0, 0.0);
        if (p as usize) < stencil.n_points() {
            for &c in stencil.around_point(p as usize) {
                let c = c as usize;
                let w = 1.0 / norm(sub(stencil.centre[c], corners.points[p as usize]));
                sum += w * alpha[c];
                weight += w;
            }
        }
        values.push(if weight > 0.0 { -sum / weight } else { 0.0 });
    }
    for (k, &p) in body.labels().iter().enumerate() {
        if (p as usize) < stencil.n_points() {
            continue;
        }
        // Every triangle of the face has the middle last and starts from another corner.
        let (mut sum, mut n) = (0.0, 0);
        for ring in body.facets().filter(|r| r.contains(&(k as u32))) {
            for &q in ring.iter().filter(|&&q| q != k as u32) {
                sum += values[q as usize];
                n += 1;
            }
        }
        values[k] = sum / f64::from(n.max(1));
    }
}

/// Least-squares gradient over the cells around, weights `1/|d|^2`, of the differences
/// `difference(d)` between cell `d` and the own cell `c`, which leaves cells out by `None`.
/// Directions along which there are no neighbours get none.
#[inline]
pub(super) fn gradient<T: Differentiable>(
    stencil: &Stencil,
    solved: [bool; 3],
    c: usize,
    difference: impl Fn(usize) -> Option<T>,
) -> T::Gradient {
    let (mut m, mut rhs) = ([0.0; 9], T::Gradient::ZERO);
    for &d in stencil.around(c) {
        let d = d as usize;
        let Some(change) = difference(d) else { continue };
        let mut arm = sub(stencil.centre[d], stencil.centre[c]);
        (0..3).filter(|&k| !solved[k]).for_each(|k| arm[k] = 0.0);
        let w = 1.0 / dot(arm, arm).max(f64::MIN_POSITIVE);
        m = m.axpy(w, Vec3::dyad(arm, arm));
        rhs = rhs.axpy(w, T::dyad(arm, change));
    }
    solve(&ridged_inverse(m, 1e-9), rhs)
}

/// The inverse of a symmetric matrix with a `share` of its trace added to the diagonal, finite
/// where it is singular (one cell between walls): the right-hand side is null there, too.
#[inline]
pub(super) fn ridged_inverse(mut m: Tensor, share: f64) -> Tensor {
    let ridge = share * (m[0] + m[4] + m[8]);
    (0..3).for_each(|k| m[4 * k] += ridge);
    inverse_symmetric(&m)
}

/// `inverse . rhs` over the first index of a vector or a tensor.
#[inline]
fn solve<G: Value>(inverse: &Tensor, rhs: G) -> G {
    let columns = G::N / 3;
    let mut out = G::ZERO;
    for i in 0..3 {
        for j in 0..columns {
            let entry = (0..3).map(|l| inverse[3 * i + l] * rhs.comp(columns * l + j)).sum();
            out.set_comp(columns * i + j, entry);
        }
    }
    out
}
