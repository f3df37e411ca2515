//! What functions that make one field of others have in common.

use super::quantity::Wanted;
use super::{Function, Info, Plan, Rank, Remembered, Unit, Values, View, Written};
use crate::CaseConfig;
use granflow_dict::{Reader, Sink};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Computes the fields from the flow; sets cells and, where `Info::on_faces`, boundary faces.
pub(super) type Compute = fn(&Wanted, &View<'_>, &mut [Values]);

/// A function whose fields follow from the present flow.
#[derive(Clone)]
pub(super) struct DerivedField {
    /// What it looks at.
    pub(super) of: Wanted,
    /// What it makes.
    pub(super) makes: Vec<Info>,
    /// Whether the velocity gradient or the viscosity is needed.
    pub(super) derived: bool,
    /// How.
    pub(super) compute: Compute,
}

impl DerivedField {
    /// A field in the cells that follows from the velocity's gradient.
    pub(super) fn of_velocity_gradient(
        r: &Reader<'_>,
        name: &str,
        (rank, unit): (Rank, Unit),
        compute: Compute,
    ) -> Box<dyn Plan> {
        let makes = vec![Info { name: result(r, name), rank, unit, on_faces: false }];
        Box::new(DerivedField { of: Wanted::velocity(r), makes, derived: true, compute })
    }
}

impl Plan for DerivedField {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.of.check(config, sink);
    }
    fn makes(&self) -> Vec<Info> {
        self.makes.clone()
    }
    fn uses(&self) -> Vec<usize> {
        self.of.uses()
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        let values = self.makes.iter().map(|info| Values::new(mesh, info)).collect();
        Box::new(Placed { plan: self.clone(), values })
    }
}

struct Placed {
    plan: DerivedField,
    values: Vec<Values>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        self.plan.derived || self.plan.of.derived()
    }
    fn execute(&mut self, view: &View<'_>) {
        (self.plan.compute)(&self.plan.of, view, &mut self.values);
        for v in &mut self.values {
            v.update_ghosts(view.exec, view.mesh);
        }
    }
    fn fields(&self) -> &[Values] {
        &self.values
    }
    fn sample(&mut self, _: &View<'_>) -> Vec<Written> {
        Vec::new()
    }
}

/// Sets every own cell and, where the field has values there, every boundary face.
pub(super) fn fill(
    view: &View<'_>,
    out: &mut Values,
    cell: impl Fn(usize) -> super::Components,
    face: impl Fn(usize) -> super::Components,
) {
    let mesh = view.mesh;
    (0..mesh.n_cells).for_each(|c| out.set_cell(c, &cell(c)));
    if !out.faces.is_empty() {
        (mesh.n_inner..mesh.n_faces()).for_each(|f| out.set_face(mesh, f, &face(f)));
    }
}

/// The name that the dictionary gives to what is made, or `default`.
pub(super) fn result(r: &Reader<'_>, default: &str) -> String {
    r.maybe_string("result").unwrap_or(default).to_owned()
}
