//! Between one rank's arrays and the whole mesh in the user's numbering.

use granflow_base::Value;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Where the entries of every rank belong in the whole mesh. Only rank 0 holds the maps.
pub(crate) struct Collector {
    n_cells: usize,
    n_faces: usize,
    /// Of every rank: the whole mesh's cell of each own cell, its `face << 1 | flipped` of each
    /// face.
    maps: Vec<(Vec<u32>, Vec<u32>)>,
}

impl Collector {
    /// For a mesh of `n_cells` and `n_faces` in all. Every rank calls it.
    pub(crate) fn new(exec: &Exec, mesh: &Mesh, n_cells: usize, n_faces: usize) -> Collector {
        let own = (mesh.global_cell.clone(), mesh.poly_face.clone());
        if exec.ranks() == 1 {
            return Collector { n_cells, n_faces, maps: vec![own] };
        }
        let numbers = |v: &[u32]| exec.comm().gather(v.iter().map(|&i| f64::from(i)).collect());
        let (cells, faces) = (numbers(&own.0), numbers(&own.1));
        let back = |v: Vec<f64>| v.into_iter().map(|x| x as u32).collect();
        let maps = cells.zip(faces).map(|(cells, faces)| {
            cells.into_iter().zip(faces).map(|(c, f)| (back(c), back(f))).collect()
        });
        Collector { n_cells, n_faces, maps: maps.unwrap_or_default() }
    }

    /// Cell values (own cells first in `own`) in the user's order; `Some` on rank 0.
    pub(crate) fn cells<T: Value>(&self, exec: &Exec, own: &[T], n_own: usize) -> Option<Vec<T>> {
        let mut out = vec![T::ZERO; self.n_cells];
        self.each(exec, &own[..n_own], |rank, i, v| out[self.maps[rank].0[i] as usize] = v)?;
        Some(out)
    }

    /// Face values in the user's order; `oriented` ones change sign with the direction of the
    /// face. `Some` on rank 0.
    pub(crate) fn faces<T: Value>(&self, exec: &Exec, own: &[T], oriented: bool) -> Option<Vec<T>> {
        let mut out = vec![T::ZERO; self.n_faces];
        self.each(exec, own, |rank, i, v| {
            let e = self.maps[rank].1[i];
            let turned = oriented && e & 1 == 1;
            // Both ranks at a cut hold its flux: the first one's counts.
            let slot = &mut out[(e >> 1) as usize];
            *slot = if turned { T::ZERO.minus(v) } else { v };
        })?;
        Some(out)
    }

    /// Hands every rank's values to `put(rank, index, value)`, on rank 0; the last rank first.
    fn each<T: Value>(
        &self,
        exec: &Exec,
        own: &[T],
        mut put: impl FnMut(usize, usize, T),
    ) -> Option<()> {
        if exec.ranks() == 1 {
            own.iter().enumerate().for_each(|(i, v)| put(0, i, tidy(*v)));
            return Some(());
        }
        let flat = own.iter().flat_map(|v| (0..T::N).map(|c| v.comp(c))).collect();
        let all = exec.comm().gather(flat)?;
        for (rank, values) in all.iter().enumerate().rev() {
            for (i, parts) in values.chunks_exact(T::N).enumerate() {
                let mut v = T::ZERO;
                parts.iter().enumerate().for_each(|(c, x)| v.set_comp(c, *x));
                put(rank, i, tidy(v));
            }
        }
        Some(())
    }
}

/// Without negative zeros: text has only one zero.
pub(crate) fn tidy<T: Value>(v: T) -> T {
    v.plus(T::ZERO)
}

/// The part of `whole` (user's order) that lives on `mesh`, own cells.
pub(crate) fn own_cells<T: Copy>(mesh: &Mesh, whole: &[T]) -> Vec<T> {
    mesh.global_cell.iter().map(|&c| whole[c as usize]).collect()
}

/// The part of an oriented face field that lives on `mesh`.
pub(crate) fn own_fluxes(mesh: &Mesh, whole: &[f64]) -> Vec<f64> {
    let one = |e: &u32| {
        let v = whole[(e >> 1) as usize];
        if e & 1 == 1 { 0.0 - v } else { v }
    };
    mesh.poly_face.iter().map(one).collect()
}
