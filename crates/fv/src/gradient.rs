//! Cell gradients.
//!
//! `Gauss linear`: Gauss's theorem with linearly interpolated face values, second order on
//! regular meshes. `leastSquares`: the gradient that fits the neighbours best with weights
//! 1/|d|^2 (Barth & Jespersen 1989), exact for linear fields on any mesh.

use crate::{Differentiable, Unknown};
use granflow_base::{Tensor, Value, Vec3, dot, inverse_symmetric, scale};
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

/// The inverse of `sum d d^T/|d|^2` in every cell.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    inverse: Vec<Tensor>,
}

impl LeastSquares {
    /// Precomputes the inverses for a mesh. Directions without neighbours get a zero gradient.
    pub fn new(mesh: &Mesh) -> Self {
        let one = |c: usize| {
            let mut m = [0.0; 9];
            for (f, s) in mesh.faces_of(c) {
                let d = scale(mesh.delta[f], s);
                m = m.axpy(1.0 / dot(d, d), Vec3::dyad(d, d));
            }
            for (k, solved) in mesh.solved_dirs.iter().enumerate() {
                if !solved {
                    m[4 * k] += 1.0;
                }
            }
            inverse_symmetric(&m)
        };
        LeastSquares { inverse: (0..mesh.n_cells).map(one).collect() }
    }
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
        match self {
            Gradient::GaussLinear => exec.for_each(own, |first, out| {
                for (i, g) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let mut sum = T::Gradient::ZERO;
                    for (f, s) in mesh.faces_of(c) {
                        sum = sum.axpy(s, T::dyad(mesh.area[f], phi.face_value(mesh, f)));
                    }
                    *g = sum.scaled(1.0 / mesh.volume[c]);
                }
            }),
            Gradient::LeastSquares(ls) => exec.for_each(own, |first, out| {
                for (i, g) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let here = phi.cells.data[c];
                    let mut sum = T::Gradient::ZERO;
                    for (f, s) in mesh.faces_of(c) {
                        let there = if f >= mesh.n_inner {
                            phi.boundary_value(mesh, f)
                        } else if s > 0.0 {
                            phi.cells.data[mesh.neighbour[f] as usize]
                        } else {
                            phi.cells.data[mesh.owner[f] as usize]
                        };
                        let d = scale(mesh.delta[f], s);
                        let ld = granflow_base::apply(&ls.inverse[c], d);
                        sum = sum.axpy(1.0 / dot(d, d), T::dyad(ld, there.minus(here)));
                    }
                    *g = sum;
                }
            }),
        }
        mesh.halo.update(exec, out);
    }
}
