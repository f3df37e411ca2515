//! Sums, means and extremes of fields over all cells or those of a zone.

use super::cell_region::CellRegion;
use super::operations::{Element, OVER_CELLS, Operation};
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Around, Entry, Function, Plan, Reading, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Dims;
use granflow_dict::{Reader, Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "volFieldValue",
    summary: "sum, mean, integral, variation or extremes of fields over all cells or a zone, perhaps weighed",
    formula: "sum: sum w phi_P; average: sum w phi_P/sum w; volIntegrate: sum w phi_P V; \
              volAverage: sum w phi_P V/sum w V; CoV: sqrt(sum V (phi_P - m)^2/V_all)/m; w = 1 \
              or the weightField",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| Box::new(VolFieldValue::read(r, reading)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct VolFieldValue {
    region: CellRegion,
    fields: Wanted,
    operation: Operation,
    factor: f64,
}

impl VolFieldValue {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> VolFieldValue {
        for key in ["writeFields", "source"] {
            r.ignore(key);
        }
        VolFieldValue {
            region: CellRegion::read(r),
            fields: Wanted::read(r, "fields", reading),
            operation: Operation::read(r, OVER_CELLS, reading),
            factor: r.opt_scalar("scaleFactor", Dims::NONE, 1.0),
        }
    }
}

impl Plan for VolFieldValue {
    fn wants_zones(&self) -> bool {
        self.region.zone.is_some()
    }
    fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        self.region.place(around, sink);
    }
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        self.operation.weight.iter().for_each(|w| w.check(config, sink));
    }
    fn uses(&self) -> Vec<usize> {
        let weights = self.operation.weight.iter().flat_map(Wanted::uses);
        self.fields.uses().into_iter().chain(weights).collect()
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Placed { cells: self.region.cells(mesh), plan: self.clone() })
    }
}

struct Placed {
    plan: VolFieldValue,
    /// The cells of this rank.
    cells: Vec<usize>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        let plan = &self.plan;
        plan.fields.derived() || plan.operation.weight.as_ref().is_some_and(Wanted::derived)
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let (mesh, plan, operation) = (view.mesh, &self.plan, &self.plan.operation);
        if operation.idle() {
            return Vec::new();
        }
        let weight = operation.weight.as_ref().map(|w| w.list[0].quantity);
        let mut values = Vec::new();
        for field in &plan.fields.list {
            let q = field.quantity;
            let element = |c: usize| Element {
                value: view.cell(q, c).map(|x| plan.factor * x),
                size: mesh.volume[c],
                weight: weight.map_or(1.0, |w| view.cell(w, c)[0]),
                area: [0.0; 3],
            };
            let elements: Vec<Element> = self.cells.iter().map(|c| element(*c)).collect();
            let v = operation.of(view.exec, q.n(), &elements);
            values.push(columns::value(q.rank(), &v));
        }
        let volume = self.cells.iter().map(|c| mesh.volume[*c]).sum::<f64>();
        let mut size = [self.cells.len() as f64, volume];
        view.exec.comm().sum(&mut size);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let heads = plan.fields.list.iter().map(|f| format!("{}({})", operation.name, f.name));
        let region = plan.region.zone.as_ref();
        let region =
            region.map_or("all region0".to_owned(), |(kind, name)| format!("{kind} {name}"));
        let mut header = columns::property("Region", &region);
        header += &columns::property("Cells", &number(size[0]));
        header += &columns::property("Volume", &number(size[1]));
        if let Some(w) = &operation.weight {
            header += &columns::property("Weight field", &w.list[0].name);
        }
        header += &columns::head(&heads.collect::<Vec<_>>());
        let line = columns::row(view, &values);
        vec![Written::Line { file: "volFieldValue.dat".into(), header, line }]
    }
}
