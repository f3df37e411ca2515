//! Values on cells or faces.

use granflow_base::{Dims, Value};
use granflow_mesh::Mesh;
use std::marker::PhantomData;

/// Marks a field on cells.
#[derive(Clone, Copy, Debug)]
pub enum Cell {}
/// Marks a field on faces.
#[derive(Clone, Copy, Debug)]
pub enum Face {}

/// Values at one kind of location. On cells: own cells, then ghosts. On faces: every face,
/// inner ones first, then the boundary patch by patch.
#[derive(Clone, Debug)]
pub struct Field<T, L> {
    /// Name, as in messages and files.
    pub name: String,
    /// Physical dimensions of the values.
    pub dims: Dims,
    /// The values, SI units.
    pub data: Vec<T>,
    at: PhantomData<L>,
}

/// A field on cells (ghosts included).
pub type CellField<T> = Field<T, Cell>;
/// A field on faces (boundary included).
pub type FaceField<T> = Field<T, Face>;

impl<T: Value> CellField<T> {
    /// The uniform field `v`.
    pub fn new(mesh: &Mesh, name: &str, dims: Dims, v: T) -> Self {
        let data = vec![v; mesh.n_cells + mesh.n_ghosts];
        Field { name: name.into(), dims, data, at: PhantomData }
    }
}

impl<T: Value> FaceField<T> {
    /// The uniform field `v`.
    pub fn new(mesh: &Mesh, name: &str, dims: Dims, v: T) -> Self {
        Field { name: name.into(), dims, data: vec![v; mesh.n_faces()], at: PhantomData }
    }
}
