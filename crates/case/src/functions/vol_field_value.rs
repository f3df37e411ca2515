//! Sums, means and extremes of fields over all cells.

use super::operations::{Element, OVER_CELLS, Operation};
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Reading, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Dims;
use granflow_dict::{Reader, Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "volFieldValue",
    summary: "sum, mean, integral, variation or extremes of fields over the cells, perhaps weighed",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| Box::new(VolFieldValue::read(r, reading)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct VolFieldValue {
    fields: Wanted,
    operation: Operation,
    factor: f64,
}

impl VolFieldValue {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> VolFieldValue {
        for key in ["writeFields", "name", "source"] {
            r.ignore(key);
        }
        if r.maybe_word("regionType") == Some("cellZone") {
            let help = "write `regionType all;`";
            let message = "`regionType cellZone` is not supported: zones are for `fvOptions` only";
            r.error_at_key("regionType", message, "refused", Some(help));
        } else {
            r.opt_one_of("regionType", &[("all", ())], ());
        }
        VolFieldValue {
            fields: Wanted::read(r, "fields", reading),
            operation: Operation::read(r, OVER_CELLS, reading),
            factor: r.opt_scalar("scaleFactor", Dims::NONE, 1.0),
        }
    }
}

impl Plan for VolFieldValue {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        self.operation.weight.iter().for_each(|w| w.check(config, sink));
    }
    fn uses(&self) -> Vec<usize> {
        let weights = self.operation.weight.iter().flat_map(Wanted::uses);
        self.fields.uses().into_iter().chain(weights).collect()
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

impl Function for VolFieldValue {
    fn needs_derived(&self) -> bool {
        self.fields.derived() || self.operation.weight.as_ref().is_some_and(Wanted::derived)
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        if self.operation.idle() {
            return Vec::new();
        }
        let (mesh, operation) = (view.mesh, &self.operation);
        let weight = operation.weight.as_ref().map(|w| w.list[0].quantity);
        let mut values = Vec::new();
        for field in &self.fields.list {
            let q = field.quantity;
            let element = |c: usize| Element {
                value: view.cell(q, c).map(|x| self.factor * x),
                size: mesh.volume[c],
                weight: weight.map_or(1.0, |w| view.cell(w, c)[0]),
                area: [0.0; 3],
            };
            let elements: Vec<Element> = (0..mesh.n_cells).map(element).collect();
            let v = operation.of(view.exec, q.n(), &elements);
            values.push(columns::value(q.rank(), &v));
        }
        let mut size = [mesh.n_cells as f64, mesh.volume[..mesh.n_cells].iter().sum::<f64>()];
        view.exec.comm().sum(&mut size);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let heads = self.fields.list.iter().map(|f| format!("{}({})", operation.name, f.name));
        let mut header = columns::property("Region", "all region0");
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
