//! From the ranks to the whole mesh, for what is computed on the first rank: cuts, surfaces of
//! equal value, stream lines.

use super::field::Components;
use super::{Quantity, View};
use crate::Case;
use crate::collect::Collector;
use crate::section::{Grid, Samples};
use granflow_base::{Value, Vec3};
use granflow_mesh::PatchKind;
use std::cell::OnceCell;

/// What leads to the whole mesh.
#[derive(Clone, Copy)]
pub(crate) struct Whole<'a> {
    pub(crate) case: &'a Case,
    pub(crate) collector: &'a Collector,
    /// Made on the first rank when it is first needed.
    pub(crate) grid: &'a OnceCell<Grid>,
}

/// A field of the whole mesh in the user's numbering: in all cells, then on all boundary faces.
#[derive(Default)]
pub(crate) struct Everywhere {
    /// One list a component, as [`Samples`] have them.
    pub(crate) parts: Vec<Vec<f64>>,
    /// Whether boundary values are the field's own.
    pub(crate) on_faces: bool,
}

impl Everywhere {
    /// The value at sample `s`.
    pub(crate) fn at(&self, s: usize) -> Components {
        let mut out = [0.0; 9];
        self.parts.iter().zip(&mut out).for_each(|(all, x)| *x = all[s]);
        out
    }
    /// Which samples are values of the field's own.
    pub(crate) fn known(&self, grid: &Grid) -> Vec<bool> {
        let poly = &grid.poly;
        let mut known = vec![self.on_faces; grid.n_samples()];
        known[..poly.n_cells()].fill(true);
        let bare = |p: &&granflow_mesh::PolyPatch| p.kind == PatchKind::Empty || p.kind.coupled();
        for p in poly.patches.iter().filter(bare) {
            let first = poly.n_cells() + p.start - poly.n_inner();
            known[first..first + p.len].fill(false);
        }
        known
    }
    /// Values at the points of the mesh, one list a component.
    pub(crate) fn at_points(&self, grid: &Grid) -> Vec<Vec<f64>> {
        let known = self.known(grid);
        let one = |values: &Vec<f64>| {
            let (values, known) = (values.clone(), known.clone());
            grid.at_points(&Samples { values, known, periodic: true })
        };
        self.parts.iter().map(one).collect()
    }
}

impl View<'_> {
    /// The field `q` of the whole mesh, on the first rank. Every rank calls it.
    pub(crate) fn everywhere(&self, q: Quantity) -> Option<Everywhere> {
        let (mesh, c, n) = (self.mesh, self.whole.collector, q.n());
        let mut own = Vec::with_capacity(mesh.n_cells);
        own.extend((0..mesh.n_cells).map(|i| self.cell(q, i)));
        let mut faces = vec![[0.0; 9]; mesh.n_faces()];
        let mut on_faces = [0.0];
        for (f, v) in faces.iter_mut().enumerate().skip(mesh.n_inner) {
            on_faces[0] = f64::max(on_faces[0], f64::from(u8::from(self.boundary(q, f).is_some())));
            *v = self.on_boundary(q, f);
        }
        self.exec.comm().max(&mut on_faces);
        let (cells, faces) = match n {
            1 => self.gathered::<f64>(&own, &faces, c),
            3 => self.gathered::<Vec3>(&own, &faces, c),
            _ => self.gathered::<Components>(&own, &faces, c),
        }?;
        let inner = self.whole.case.poly.n_inner();
        let part = |k: usize| {
            let all = cells.iter().chain(&faces[inner..]);
            all.map(|v| v[k]).collect()
        };
        Some(Everywhere { parts: (0..n).map(part).collect(), on_faces: on_faces[0] > 0.0 })
    }

    fn gathered<T: Value>(
        &self,
        cells: &[Components],
        faces: &[Components],
        c: &Collector,
    ) -> Option<(Vec<Components>, Vec<Components>)> {
        let narrow = |v: &Components| {
            let mut t = T::ZERO;
            (0..T::N).for_each(|k| t.set_comp(k, v[k]));
            t
        };
        let wide = |t: T| {
            let mut v = [0.0; 9];
            (0..T::N).for_each(|k| v[k] = t.comp(k));
            v
        };
        let cells: Vec<T> = cells.iter().map(narrow).collect();
        let faces: Vec<T> = faces.iter().map(narrow).collect();
        let cells = c.cells(self.exec, &cells, cells.len());
        let faces = c.faces(self.exec, &faces, false);
        Some((cells?.into_iter().map(wide).collect(), faces?.into_iter().map(wide).collect()))
    }

    /// The whole mesh with what cuts through it need. On the first rank only.
    pub(crate) fn grid(&self) -> &Grid {
        self.whole.grid.get_or_init(|| Grid::new(self.whole.case.poly.clone()))
    }
}
