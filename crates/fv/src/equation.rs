//! An equation on a mesh: matrix and right-hand side, filled from its terms in one pass.

use crate::{Differentiable, Term, Terms, Unknown};
use granflow_base::{Dims, Tensor, Value, Vec3};
use granflow_linsolve::{Blocks, Csr};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use std::sync::Arc;

/// `A phi = b` on a mesh's pattern. Built once, refilled for every solve.
pub struct Equation<T> {
    /// The matrix: one row a cell, columns may be ghosts.
    pub a: Csr,
    /// Right-hand side, integrated over cells.
    pub b: Vec<T>,
    /// Row sums without what boundary conditions take: the matrix's answer to a uniform change.
    pub row_sum: Vec<f64>,
    /// Position of each entry of `mesh.cell_faces` in the values of its row (`u32::MAX`: a
    /// boundary face, which has no column).
    column_of_face: Vec<u32>,
    scratch: Vec<Row<T>>,
}

#[derive(Clone, Copy, Default)]
struct Row<T> {
    b: T,
    sum: f64,
}

/// Two terms that cannot be added.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "inconsistent dimensions in the equation for `{unknown}`: {first} is {first_dims} but {other} \
     is {other_dims}"
)]
pub struct DimError {
    /// Name of the unknown.
    pub unknown: String,
    /// The first term and
    pub first: String,
    /// its dimensions,
    pub first_dims: Dims,
    /// the term that differs and
    pub other: String,
    /// its dimensions.
    pub other_dims: Dims,
}

impl<T: Differentiable> Equation<T> {
    /// The pattern of a mesh: the cell itself and its neighbours across inner faces.
    pub fn new(exec: &Exec, mesh: &Mesh) -> Self {
        let n = mesh.n_cells;
        let mut ptr = Vec::with_capacity(n + 1);
        let (mut col, mut diag) = (Vec::new(), Vec::with_capacity(n));
        let mut column_of_face = vec![u32::MAX; mesh.cell_faces.len()];
        let mut row: Vec<(u32, usize)> = Vec::new();
        ptr.push(0);
        for c in 0..n {
            row.clear();
            row.push((c as u32, usize::MAX));
            for k in mesh.cell_ptr[c] as usize..mesh.cell_ptr[c + 1] as usize {
                let (f, flipped) =
                    ((mesh.cell_faces[k] >> 1) as usize, mesh.cell_faces[k] & 1 == 1);
                if f < mesh.n_inner {
                    let other = if flipped { mesh.owner[f] } else { mesh.neighbour[f] };
                    row.push((other, k));
                }
            }
            row.sort_unstable();
            for &(other, k) in &row {
                // Two faces between the same two cells share one entry.
                let start = ptr[c] as usize;
                if col.len() == start || col[col.len() - 1] != other {
                    col.push(other);
                }
                let at = (col.len() - 1 - start) as u32;
                match k {
                    usize::MAX => diag.push((start as u32) + at),
                    k => column_of_face[k] = at,
                }
            }
            ptr.push(col.len() as u32);
        }
        let image = mesh.halo.local_image(exec.rank(), mesh.n_ghosts);
        let val = vec![0.0; col.len()];
        let a = Csr {
            ptr,
            col,
            val,
            diag,
            halo: mesh.halo.clone(),
            image: Arc::new(image),
            blocks: Blocks::default(),
        };
        Equation {
            a,
            b: vec![T::ZERO; n],
            row_sum: vec![0.0; n],
            column_of_face,
            scratch: vec![Row { b: T::ZERO, sum: 0.0 }; n],
        }
    }

    /// Fills matrix and right-hand side with `terms = 0`. The closure of `phi` must be up to date.
    ///
    /// # Errors
    /// [`DimError`] when two terms have different dimensions.
    pub fn assemble(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        phi: &Unknown<T>,
        terms: &Terms<'_, T>,
    ) -> Result<(), DimError> {
        check_dims(phi, terms)?;
        let Equation { a, b, row_sum, column_of_face, scratch } = self;
        let (ptr, diag) = (&a.ptr, &a.diag);
        let closure = &phi.closure;
        let inner = mesh.n_inner;
        exec.for_each_row(ptr, &mut a.val, scratch, |first, val, rows| {
            let base = ptr[first] as usize;
            for (i, row) in rows.iter_mut().enumerate() {
                let c = first + i;
                let start = ptr[c] as usize - base;
                let row_val = &mut val[start..ptr[c + 1] as usize - base];
                row_val.fill(0.0);
                let (mut d, mut src, mut sum) = (0.0, T::ZERO, 0.0);
                for (sign, t) in terms.iter() {
                    let volume = sign * mesh.volume[c];
                    match t {
                        Term::Ddt(t) => {
                            let k = volume / t.dt;
                            d += k * t.c[0] * t.rho.data[c];
                            sum += k * t.c[0] * t.rho.data[c];
                            src = src.axpy(k * t.c[1] * t.rho_old.data[c], t.old[c]);
                            if t.c[2] != 0.0 {
                                src = src.axpy(-k * t.c[2] * t.rho_old.data[c], t.older[c]);
                            }
                        }
                        Term::Sp { k } => {
                            d += volume * k.data[c];
                            sum += volume * k.data[c];
                        }
                        Term::Su { s } => src = src.axpy(-volume, s.data[c]),
                        Term::Flux { flux } => {
                            for (f, s) in mesh.faces_of(c) {
                                src = src.axpy(-sign * s, flux.data[f]);
                            }
                        }
                        Term::Div { flux, weights } => {
                            for k in mesh.cell_ptr[c] as usize..mesh.cell_ptr[c + 1] as usize {
                                let e = mesh.cell_faces[k];
                                let f = (e >> 1) as usize;
                                let owner = e & 1 == 0;
                                let m = sign * if owner { flux.data[f] } else { -flux.data[f] };
                                sum += m;
                                if f < inner {
                                    let w = weights.data[f];
                                    let (here, there) =
                                        if owner { (w, 1.0 - w) } else { (1.0 - w, w) };
                                    d += m * here;
                                    row_val[column_of_face[k] as usize] += m * there;
                                } else {
                                    d += m * closure.slope[f - inner];
                                    src = src.axpy(-m, closure.offset[f - inner]);
                                }
                            }
                        }
                        Term::Laplacian { gamma } => {
                            for k in mesh.cell_ptr[c] as usize..mesh.cell_ptr[c + 1] as usize {
                                let f = (mesh.cell_faces[k] >> 1) as usize;
                                let g = sign * gamma.data[f] * mesh.mag_area[f] * mesh.inv_dist[f];
                                if f < inner {
                                    d -= g;
                                    row_val[column_of_face[k] as usize] += g;
                                } else {
                                    d -= g * (1.0 - closure.slope[f - inner]);
                                    src = src.axpy(-g, closure.offset[f - inner]);
                                }
                            }
                        }
                    }
                }
                row_val[diag[c] as usize - base - start] += d;
                *row = Row { b: src, sum };
            }
        });
        exec.for_each2(b, row_sum, |first, b, sum| {
            for i in 0..b.len() {
                (b[i], sum[i]) = (scratch[first + i].b, scratch[first + i].sum);
            }
        });
        self.collect_blocks(mesh, phi, terms);
        Ok(())
    }

    /// The part of slip walls that acts on the normal component only: blocks on the diagonal.
    fn collect_blocks(&mut self, mesh: &Mesh, phi: &Unknown<T>, terms: &Terms<'_, T>) {
        self.a.blocks.clear();
        if T::N != 3 {
            return;
        }
        for f in mesh.n_inner..mesh.n_faces() {
            let k = phi.closure.normal[f - mesh.n_inner];
            if k == 0.0 {
                continue;
            }
            let mut strength = 0.0;
            for (sign, t) in terms.iter() {
                match t {
                    Term::Div { flux, .. } => strength -= sign * flux.data[f],
                    Term::Laplacian { gamma } => {
                        strength -= sign * gamma.data[f] * mesh.mag_area[f] * mesh.inv_dist[f];
                    }
                    _ => (),
                }
            }
            let n = phi.boundary_normal(mesh, f);
            let block: Tensor = Vec3::dyad(n, n).scaled(k * strength);
            self.a.blocks.add(mesh.n_cells, mesh.owner[f] as usize, &block);
        }
    }

    /// `out = (b - sum of the other entries of the row times x) / diagonal`: the velocity that
    /// momentum would give each cell if only its neighbours and sources acted.
    pub fn jacobi(&self, exec: &Exec, x: &[T], out: &mut [T]) {
        let a = &self.a;
        exec.for_each(out, |first, out| {
            for (i, h) in out.iter_mut().enumerate() {
                let (row, d) = (first + i, a.diag[first + i] as usize);
                let mut s = self.b[row];
                for k in a.ptr[row] as usize..a.ptr[row + 1] as usize {
                    if k != d {
                        s = s.axpy(-a.val[k], x[a.col[k] as usize]);
                    }
                }
                if let Some(t) = a.blocks.times(row, x[row]) {
                    s = s.minus(t);
                }
                *h = s.scaled(1.0 / a.val[d]);
            }
        });
    }
}

fn check_dims<T: Differentiable>(phi: &Unknown<T>, terms: &Terms<'_, T>) -> Result<(), DimError> {
    let mut dims = terms.iter().map(|(_, t)| (t, t.dims(phi.cells.dims)));
    let Some((first, want)) = dims.next() else { return Ok(()) };
    match dims.find(|(_, d)| *d != want) {
        None => Ok(()),
        Some((other, other_dims)) => Err(DimError {
            unknown: phi.cells.name.clone(),
            first: first.to_string(),
            first_dims: want,
            other: other.to_string(),
            other_dims,
        }),
    }
}
