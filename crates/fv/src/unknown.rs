//! A field somebody solves for: cell values and their closure at the boundary.

use crate::{Affine, CellField, Condition, Differentiable, FaceField, PatchView, Surroundings};
use granflow_base::{Dims, Vec3};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Cell values with one boundary condition per patch, reduced to an affine closure.
pub struct Unknown<T> {
    /// Values in cells and ghosts.
    pub cells: CellField<T>,
    /// One condition per patch of the mesh; coupled patches have one that is never asked.
    pub conditions: Vec<Box<dyn Condition<T>>>,
    /// Face values in terms of cell values, over all boundary faces.
    pub closure: Affine<T>,
    view_normals: Vec<Vec3>,
    /// Room for the sums that conditions ask for.
    totals: Vec<f64>,
}

impl<T: Differentiable> Unknown<T> {
    /// The uniform field `v`; `conditions` one per patch, in the order of the patches.
    pub fn new(
        mesh: &Mesh,
        name: &str,
        dims: Dims,
        v: T,
        conditions: Vec<Box<dyn Condition<T>>>,
    ) -> Self {
        debug_assert_eq!(conditions.len(), mesh.patches.len());
        let n = mesh.n_faces() - mesh.n_inner;
        let totals = conditions.iter().map(|c| c.n_totals()).max().unwrap_or(0);
        let normal = |f: usize| granflow_base::unit(mesh.area[f]);
        Unknown {
            cells: CellField::new(mesh, name, dims, v),
            conditions,
            closure: Affine::zero_gradient(n),
            view_normals: (mesh.n_inner..mesh.n_faces()).map(normal).collect(),
            totals: vec![0.0; totals],
        }
    }

    /// Refreshes ghosts and the closure from the present cell values. `flux` is what crosses the
    /// faces, for conditions that tell inflow from outflow.
    pub fn update(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        around: &Surroundings<'_>,
        flux: Option<&FaceField<f64>>,
    ) {
        mesh.halo.update(exec, &mut self.cells.data);
        for (patch, condition) in mesh.patches.iter().zip(&mut self.conditions) {
            let faces = patch.faces.clone();
            let b = faces.start - mesh.n_inner..faces.end - mesh.n_inner;
            let mut view: PatchView<'_, T> = PatchView {
                faces: faces.clone(),
                inv_dist: &mesh.inv_dist[faces.clone()],
                area: &mesh.area[faces.clone()],
                normal: &self.view_normals[b.clone()],
                centre: &mesh.face_centre[faces.clone()],
                owner: &mesh.owner[faces.clone()],
                owner_centre: &mesh.cell_centre,
                cells: &self.cells.data,
                flux: flux.map(|f| &f.data[faces.clone()]),
                totals: &[],
                around,
            };
            // A rank that has no faces of the patch takes part in the sums.
            let n_totals = condition.n_totals();
            if n_totals > 0 {
                let totals = &mut self.totals[..n_totals];
                totals.fill(0.0);
                condition.totals(&view, totals);
                exec.comm().sum(totals);
                view.totals = totals;
            }
            if faces.is_empty() {
                continue;
            }
            condition.update(&view, &mut self.closure.patch(b));
        }
    }

    /// Whether an update may find a condition at fault.
    pub fn may_fail(&self) -> bool {
        self.conditions.iter().any(|c| c.may_fail())
    }

    /// The first patch whose condition the last update found at fault.
    pub fn fault(&self) -> Option<usize> {
        self.conditions.iter().position(|c| c.fault().is_some())
    }

    /// The value on boundary face `f` (global face index).
    #[inline]
    pub fn boundary_value(&self, mesh: &Mesh, f: usize) -> T {
        self.boundary_value_beside(mesh, f, self.cells.data[mesh.owner[f] as usize])
    }

    /// The same were the value of the face's cell `cell`.
    #[inline]
    pub fn boundary_value_beside(&self, mesh: &Mesh, f: usize, cell: T) -> T {
        let b = f - mesh.n_inner;
        let v = self.closure.offset[b].axpy(self.closure.slope[b], cell);
        match self.closure.normal[b] {
            0.0 => v,
            k => {
                let n = self.view_normals[b];
                v.plus(cell.less_normal(k, n).minus(cell))
            }
        }
    }

    /// Unit outward normal of boundary face `f`.
    #[inline]
    pub fn boundary_normal(&self, mesh: &Mesh, f: usize) -> Vec3 {
        self.view_normals[f - mesh.n_inner]
    }

    /// The value on any face: linear between cells, the closure on the boundary.
    #[inline]
    pub fn face_value(&self, mesh: &Mesh, f: usize) -> T {
        if f < mesh.n_inner {
            let w = mesh.weight[f];
            let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
            self.cells.data[o].scaled(w).axpy(1.0 - w, self.cells.data[n])
        } else {
            self.boundary_value(mesh, f)
        }
    }

    /// Whether a condition pins the level of the field on this rank.
    pub fn fixes_level(&self, mesh: &Mesh) -> bool {
        let mut with_faces = mesh.patches.iter().zip(&self.conditions);
        with_faces.any(|(p, c)| !p.faces.is_empty() && c.fixes_value())
    }
}
