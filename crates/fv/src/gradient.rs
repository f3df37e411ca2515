//! Cell gradients.
//!
//! `Gauss linear`: Gauss's theorem with linearly interpolated face values, second order on
//! regular meshes. `leastSquares`: the gradient that fits the neighbours best with weights
//! 1/|d|^2 (Barth & Jespersen 1989), exact for linear fields on any mesh.
//!
//! Neither has its values where it needs them on every mesh. Interpolation hits a point beside
//! the centre of a skewed face, and a boundary condition that leaves the value free gives it at
//! the foot of the normal from the cell's centre, not at the centre of a leaning face. Both lack
//! a known vector times the gradient. Taking the cell's own, `g = g0 + C g`, leaves three
//! equations a cell, solved in place: exact for linear fields, with no second pass and no
//! neighbours in it.

use crate::{Differentiable, Unknown};
use granflow_base::{IDENTITY, Tensor, Value, Vec3, cross, dot, inverse_symmetric, scale, sub};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// How gradients are computed.
#[derive(Clone, Debug)]
pub enum Gradient {
    /// Gauss's theorem, linear interpolation to faces.
    GaussLinear,
    /// Weighted least squares; holds the inverse normal matrices of the mesh.
    LeastSquares(LeastSquares),
}

/// The inverse of `sum w d d^T` in every cell.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    inverse: Vec<Tensor>,
    by_area: bool,
}

impl LeastSquares {
    /// Precomputes the inverses for a mesh, weights `1/|d|^2`. Directions without neighbours get a zero gradient.
    pub fn new(mesh: &Mesh) -> Self {
        Self::weighed(mesh, false)
    }
    /// With the weights that OpenFOAM v1912's `leastSquares` is found to have: `a |S|/|d|^2`, `a` the neighbour's share
    /// of the distance, and 1 at boundaries, where `d` is along the normal.
    pub fn by_area(mesh: &Mesh) -> Self {
        Self::weighed(mesh, true)
    }
    fn weighed(mesh: &Mesh, by_area_of_faces: bool) -> Self {
        let towards = if by_area_of_faces { by_area } else { by_distance };
        let one = |c: usize| {
            let mut m = [0.0; 9];
            for (f, s) in mesh.faces_of(c) {
                let (d, weight) = towards(mesh, f, s);
                m = m.axpy(weight, Vec3::dyad(d, d));
            }
            inverse_symmetric(&mesh.fit_to_invert(m))
        };
        let inverse = (0..mesh.n_cells).map(one).collect();
        LeastSquares { inverse, by_area: by_area_of_faces }
    }

    /// The gradients of own cells, with the weights that the inverses were made with.
    fn fit<T: Differentiable>(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        phi: &Unknown<T>,
        out: &mut [T::Gradient],
        towards: impl Fn(&Mesh, usize, f64) -> (Vec3, f64) + Sync,
    ) {
        let leaning = mesh.max_nonorth_deg > 0.1;
        exec.for_each(out, |first, out| {
            for (i, g) in out.iter_mut().enumerate() {
                let c = first + i;
                let here = phi.cells.data[c];
                let mut sum = T::Gradient::ZERO;
                let mut lack = [0.0; 9];
                for (f, s) in mesh.faces_of(c) {
                    let there = if f >= mesh.n_inner {
                        phi.boundary_value(mesh, f)
                    } else if s > 0.0 {
                        phi.cells.data[mesh.neighbour[f] as usize]
                    } else {
                        phi.cells.data[mesh.owner[f] as usize]
                    };
                    let (d, weight) = towards(mesh, f, s);
                    let ld = granflow_base::apply(&self.inverse[c], d);
                    sum = sum.axpy(weight, T::dyad(ld, there.minus(here)));
                    if leaning && f >= mesh.n_inner {
                        let beside = beside_foot(mesh, phi, f);
                        lack = lack.axpy(weight, Vec3::dyad(ld, beside));
                    }
                }
                *g = if lack == [0.0; 9] { sum } else { completed::<T>(sum, &lack) };
            }
        });
    }
}

/// From a cell to what is behind its face `f`, whose normal leaves it where `s > 0`, and the weight of that.
#[inline]
fn by_distance(mesh: &Mesh, f: usize, s: f64) -> (Vec3, f64) {
    let d = scale(mesh.delta[f], s);
    (d, 1.0 / dot(d, d))
}

/// The same as [`LeastSquares::by_area`] has it.
#[inline]
fn by_area(mesh: &Mesh, f: usize, s: f64) -> (Vec3, f64) {
    let (d, share) = if f < mesh.n_inner {
        let weight = mesh.weight[f];
        (scale(mesh.delta[f], s), if s > 0.0 { 1.0 - weight } else { weight })
    } else {
        (scale(mesh.area[f], 1.0 / (mesh.mag_area[f] * mesh.inv_dist[f])), 1.0)
    };
    (d, share * mesh.mag_area[f] / dot(d, d))
}

impl Gradient {
    /// Writes the gradient of `phi` into `out` (own cells and ghosts). The closure and the ghosts
    /// of `phi` must be up to date.
    pub fn of<T: Differentiable>(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        phi: &Unknown<T>,
        out: &mut [T::Gradient],
    ) {
        let own = &mut out[..mesh.n_cells];
        let leaning = mesh.max_nonorth_deg > 0.1;
        let (skewed, solved) = (mesh.is_skewed(), mesh.solved_dirs);
        match self {
            Gradient::GaussLinear => exec.for_each(own, |first, out| {
                for (i, g) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let mut sum = T::Gradient::ZERO;
                    for (f, s) in mesh.faces_of(c) {
                        sum = sum.axpy(s, T::dyad(mesh.area[f], phi.face_value(mesh, f)));
                    }
                    let per_volume = 1.0 / mesh.volume[c];
                    *g = sum.scaled(per_volume);
                    let leans = |f: usize| {
                        f >= mesh.n_inner && dot(mesh.nonorth[f], mesh.nonorth[f]) > UPRIGHT
                    };
                    if skewed || leaning && mesh.faces_of(c).any(|(f, _)| leans(f)) {
                        // Gauss's theorem for the places that the values belong to would give
                        // the unit tensor; on warped faces even their centres do not.
                        let mut lack = IDENTITY;
                        for (f, s) in mesh.faces_of(c) {
                            let beside = match mesh.skew.get(f) {
                                Some(&skew) => skew,
                                None => beside_foot(mesh, phi, f),
                            };
                            let place = sub(mesh.face_centre[f], beside);
                            let arm = sub(place, mesh.cell_centre[c]);
                            lack = lack.axpy(-s * per_volume, Vec3::dyad(mesh.area[f], arm));
                        }
                        // Nothing is lacking where there are no faces.
                        (0..3).filter(|&k| !solved[k]).for_each(|k| lack[4 * k] = 0.0);
                        *g = completed::<T>(*g, &lack);
                    }
                }
            }),
            Gradient::LeastSquares(ls) if ls.by_area => ls.fit(exec, mesh, phi, own, by_area),
            Gradient::LeastSquares(ls) => ls.fit(exec, mesh, phi, own, by_distance),
        }
        mesh.halo.update(exec, out);
    }
}

/// From the foot of the normal, where the condition gives a free value, to the centre of boundary
/// face `f`; null where the value is given, and in part between. What slips along a wall stays:
/// its condition turns the vector as well.
#[inline]
fn beside_foot<T: Differentiable>(mesh: &Mesh, phi: &Unknown<T>, f: usize) -> Vec3 {
    let b = f - mesh.n_inner;
    if phi.closure.normal[b] != 0.0 {
        return [0.0; 3];
    }
    scale(mesh.nonorth[f], -phi.closure.slope[b] / mesh.inv_dist[f])
}

/// Square of the tangent of a boundary face's lean that is rounding.
const UPRIGHT: f64 = 1e-12;

/// Most that completing may multiply a gradient by. Cells beyond it are so distorted that values
/// extrapolated by their own gradient mean nothing; they keep the gradient they have.
const MOST: f64 = 4.0;

/// The `g` of `g = g0 + lack . g`.
#[inline]
fn completed<T: Differentiable>(g0: T::Gradient, lack: &Tensor) -> T::Gradient {
    let row = |i: usize| {
        let mut r = [-lack[3 * i], -lack[3 * i + 1], -lack[3 * i + 2]];
        r[i] += 1.0;
        r
    };
    let (x, y, z) = (row(0), row(1), row(2));
    let columns = [cross(y, z), cross(z, x), cross(x, y)];
    let det = dot(x, columns[0]);
    let size: f64 = columns.iter().map(|c| dot(*c, *c)).sum();
    if det <= 0.0 || size > MOST * MOST * det * det {
        return g0;
    }
    let mut g = T::Gradient::ZERO;
    for (i, column) in columns.iter().enumerate() {
        let mut along = [0.0; 3];
        along[i] = 1.0 / det;
        g = g.plus(T::dyad(*column, T::along(g0, along)));
    }
    g
}
