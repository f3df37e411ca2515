//! Curvature of a reconstructed interface: a paraboloid ([`super::paraboloid`]) through the planes of
//! the cells around every mixed cell, then the mean over those cells.

use super::corners::Corners;
use super::paraboloid::Fit;
use super::reconstruct::{BLOCK, Plane, Reconstructor, plane_in, ridged_inverse, with_body};
use super::stencil::Stencil;
use granflow_base::{Tensor, Value, Vec3, add, apply, dot, norm, scale, sub, unit};
use granflow_fv::Differentiable;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Planes at a greater angle than this belong to another part of the interface.
const LEAST_COSINE: f64 = 0.3;
/// Square of the distance, in units of the cells' spacing, from which planes have no say: about two
/// cells. Were they all equal, a zigzag of the interface would have a curvature of the wrong sign, and
/// grow: a parabola through five points takes 1 -1 1 -1 1 for a valley.
const FAR: f64 = 5.5;
/// The same for the mean of curvatures: it must not turn the sign of a zigzag, either.
const NEAR: f64 = 3.5;
/// Distance from a wall within which its angle counts, over that of the farthest cell around.
const REACH: f64 = 1.5;

/// How often planes are turned to the paraboloid before the last one is fitted.
const TURNS: usize = 2;

/// What a mixed cell contributes, while it is worked out.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    plane: Plane,
    spread: Tensor,
    /// Of the paraboloid around it.
    normal: Vec3,
    curvature: f64,
}

/// Curvature of the interface, and what it takes.
#[derive(Debug, Default)]
pub(super) struct Curvature {
    /// 1/m, wide (see [`Stencil`]), positive where fluid 1 is a drop. Null away from the interface.
    pub(super) value: Vec<f64>,
    /// What it counts for: area of the interface, wide, m2.
    pub(super) area: Vec<f64>,
    /// The planes, wide: they are turned more closely than transport needs.
    normal: Vec<Vec3>,
    offset: Vec<Vec3>,
    /// Mean of `d d` over the interface in a cell, with d from its centre, wide, m2.
    spread: Vec<Tensor>,
    /// Of the mixed cells, in their order.
    pieces: Vec<Piece>,
    /// Of the cells near the interface, in their order.
    means: Vec<f64>,
    /// Cells that have a value.
    known: Vec<u32>,
}

impl Curvature {
    /// Work arrays for a mesh.
    pub(super) fn new(stencil: &Stencil) -> Curvature {
        let (n, all) = (stencil.n_cells, stencil.n_all);
        Curvature {
            value: vec![0.0; all],
            area: vec![0.0; all],
            normal: vec![[0.0; 3]; all],
            offset: vec![[0.0; 3]; all],
            spread: vec![[0.0; 9]; all],
            pieces: Vec::with_capacity(n),
            means: Vec::with_capacity(n),
            known: Vec::with_capacity(n),
        }
    }

    /// Curvature of the interface as `r` has it. `cosine` is that of the angle, through fluid 1, at
    /// which the interface meets each boundary face; NaN where nothing is known about it.
    pub(super) fn update(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        corners: &Corners,
        stencil: &Stencil,
        r: &Reconstructor,
        cosine: &[f64],
    ) {
        for &c in &self.known {
            let c = c as usize;
            (self.value[c], self.area[c], self.normal[c]) = (0.0, 0.0, [0.0; 3]);
        }
        self.known.clear();
        self.known.extend_from_slice(&r.near);
        self.pieces.clear();
        self.pieces.extend(r.mixed.iter().map(|&c| {
            let c = c as usize;
            let interface = &r.interface;
            let (normal, offset, area) =
                (interface.normal[c], interface.offset[c], interface.area[c]);
            let plane = Plane { normal, offset, area };
            Piece { plane, normal, ..Piece::default() }
        }));
        for turn in 0..=TURNS {
            self.cut(exec, mesh, corners, r, turn > 0);
            self.publish(exec, stencil, &r.mixed);
            self.fit(exec, mesh, stencil, &r.mixed, cosine);
        }
        for (&c, p) in r.mixed.iter().zip(&self.pieces) {
            self.value[c as usize] = p.curvature;
        }
        stencil.halo.update(exec, &mut self.value);
        self.average(exec, mesh, stencil, r);
        stencil.halo.update(exec, &mut self.value);
    }

    /// Planes normal to the paraboloids where they are to `turn`, and what cells cut out of them.
    fn cut(&mut self, exec: &Exec, mesh: &Mesh, corners: &Corners, r: &Reconstructor, turn: bool) {
        exec.for_each_block(&mut self.pieces, BLOCK, |first, out| {
            with_body(corners, |body, values| {
                for (i, p) in out.iter_mut().enumerate() {
                    let c = r.mixed[first + i] as usize;
                    if p.normal == [0.0; 3] {
                        continue;
                    }
                    body.load(corners, mesh, c);
                    if turn {
                        p.plane = plane_in(body, values, p.normal, r.alpha[c]);
                    }
                    let Plane { normal, offset, .. } = p.plane;
                    values.clear();
                    values.extend(body.points().iter().map(|&x| dot(normal, x)));
                    p.spread = body.spread(dot(normal, offset), values);
                }
            });
        });
    }

    fn publish(&mut self, exec: &Exec, stencil: &Stencil, mixed: &[u32]) {
        for (&c, p) in mixed.iter().zip(&self.pieces) {
            let c = c as usize;
            (self.normal[c], self.offset[c]) = (p.plane.normal, p.plane.offset);
            (self.area[c], self.spread[c]) = (p.plane.area, p.spread);
        }
        stencil.halo.update(exec, &mut self.normal);
        stencil.halo.update(exec, &mut self.offset);
        stencil.halo.update(exec, &mut self.spread);
        stencil.halo.update(exec, &mut self.area);
    }

    /// A paraboloid around every mixed cell.
    fn fit(&mut self, exec: &Exec, mesh: &Mesh, stencil: &Stencil, mixed: &[u32], cosine: &[f64]) {
        let Curvature { pieces, area, normal, offset, spread, .. } = self;
        let (area, normal, offset, spread) = (&*area, &*normal, &*offset, &*spread);
        let centre = |c: usize| add(stencil.centre[c], offset[c]);
        // Of a ball both principal curvatures are the same, of a circle there is one.
        let share = if mesh.solved_dirs == [true; 3] { 0.5 } else { 1.0 };
        exec.for_each_block(pieces, BLOCK, |first, out| {
            for (i, piece) in out.iter_mut().enumerate() {
                let c = mixed[first + i] as usize;
                let (here, n) = (centre(c), normal[c]);
                if n == [0.0; 3] {
                    continue;
                }
                let walls = || {
                    let boundary = mesh.faces_of(c).map(|(f, _)| f).filter(|&f| f >= mesh.n_inner);
                    boundary.filter_map(|f| meeting(mesh, f, n, cosine[f - mesh.n_inner]))
                };
                // Halfway to what a wall asks for, or heights would have no end.
                let up = unit(walls().fold(n, |s, m| add(s, m.normal)));
                let metric = stencil_metric(stencil, mesh.solved_dirs, c);
                let reach = |&d: &u32| norm(sub(stencil.centre[d as usize], stencil.centre[c]));
                let size = stencil.around(c).iter().map(reach).fold(0.0, f64::max);
                let mut fit = Fit::new(here, up, mesh.solved_dirs, size);
                let mut total = 0.0;
                for &d in stencil.around(c).iter().chain(&[c as u32]) {
                    let d = d as usize;
                    let cosine = dot(normal[d], up);
                    if area[d] <= 0.0 || cosine < LEAST_COSINE {
                        continue;
                    }
                    let arm = sub(centre(d), here);
                    let near = (1.0 - dot(arm, apply(&metric, arm)) / FAR).max(0.0);
                    let weight = area[d] * cosine * near * near;
                    fit.polygon(centre(d), &spread[d], piece.curvature * share, weight);
                    total += weight;
                }
                for m in walls() {
                    let (wall, on_wall) = (mesh.normal(m.face), mesh.face_centre[m.face]);
                    let away = dot(sub(on_wall, here), wall) / size;
                    let near = (1.0 - (away / REACH).powi(2)).max(0.0);
                    fit.normal_at_wall(wall, on_wall, m.normal, total * near);
                }
                (piece.normal, piece.curvature) = fit.solve();
            }
        });
    }

    /// The mean over the cells around, so that neighbouring cells pull alike; cells without an
    /// interface that have one beside them get one, too.
    fn average(&mut self, exec: &Exec, mesh: &Mesh, stencil: &Stencil, r: &Reconstructor) {
        self.means.clear();
        self.means.resize(r.near.len(), 0.0);
        let Curvature { value, area, normal, offset, means, .. } = self;
        let (value, area, normal, offset) = (&*value, &*area, &*normal, &*offset);
        let centre = |c: usize| add(stencil.centre[c], offset[c]);
        exec.for_each_block(means, BLOCK, |first, out| {
            for (i, mean) in out.iter_mut().enumerate() {
                let c = r.near[first + i] as usize;
                let mixed = normal[c] != [0.0; 3];
                let metric = stencil_metric(stencil, mesh.solved_dirs, c);
                let (mut sum, mut weight) = (0.0, 0.0);
                for &d in stencil.around(c).iter().chain(&[c as u32]) {
                    let d = d as usize;
                    if area[d] <= 0.0 || (mixed && dot(normal[c], normal[d]) < LEAST_COSINE) {
                        continue;
                    }
                    let w = if mixed {
                        let arm = sub(centre(d), centre(c));
                        area[d] * (1.0 - dot(arm, apply(&metric, arm)) / NEAR).max(0.0).powi(2)
                    } else {
                        area[d]
                    };
                    sum += w * value[d];
                    weight += w;
                }
                *mean = if weight > 0.0 { sum / weight } else { value[c] };
            }
        });
        for (&c, &k) in r.near.iter().zip(&self.means) {
            self.value[c as usize] = k;
        }
    }
}

/// The inverse of the mean of `d d` over the cells around `c`: a length squared by it is in units of
/// the cells' spacing, whatever their aspect; 1.33 for a neighbour in a mesh of squares.
fn stencil_metric(stencil: &Stencil, solved: [bool; 3], c: usize) -> Tensor {
    let mut m = [0.0; 9];
    for &d in stencil.around(c) {
        let mut arm = sub(stencil.centre[d as usize], stencil.centre[c]);
        (0..3).filter(|&k| !solved[k]).for_each(|k| arm[k] = 0.0);
        m = m.axpy(1.0 / stencil.around(c).len() as f64, Vec3::dyad(arm, arm));
    }
    ridged_inverse(m, 1e-9)
}

/// A boundary face and the interface's normal there.
struct Meeting {
    face: usize,
    normal: Vec3,
}

/// The normal with which an interface, here normal to `n`, meets the wall of face `f`.
fn meeting(mesh: &Mesh, f: usize, n: Vec3, cosine: f64) -> Option<Meeting> {
    let wall = mesh.normal(f);
    let along = n.axpy(-dot(n, wall), wall);
    if cosine.is_nan() || norm(along) < 1e-6 {
        return None;
    }
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    Some(Meeting { face: f, normal: scale(unit(along), sine).axpy(-cosine, wall) })
}
