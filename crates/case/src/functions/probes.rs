//! Values at points, at every step or so.

use super::locate::Locator;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Vec3;
use granflow_dict::{Diag, Reader, Sink, Span};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "probes",
    summary: "values at points against time, one table a field",
    reference: "OpenFOAM user guide, function objects",
    read: |r, name| Box::new(Probes::read(r, name)),
    schedule: Schedule::always(Every::Steps(1)),
};

/// What OpenFOAM writes for a point outside the mesh.
const OUTSIDE: f64 = -1e300;

#[derive(Clone)]
struct Probes {
    name: String,
    fields: Wanted,
    points: Vec<Vec3>,
    span: Span,
    /// Continue the cell's value to the point by its gradient.
    linear: bool,
}

impl Probes {
    fn read(r: &Reader<'_>, name: &str) -> Probes {
        r.ignore("fixedLocations");
        r.ignore("includeOutOfBounds");
        let scheme = [("cell", false), ("cellPoint", true), ("cellPointFace", true)];
        Probes {
            name: name.into(),
            fields: Wanted::read(r, "fields"),
            points: r.vectors("probeLocations"),
            span: r.value_span("probeLocations"),
            linear: r.opt_one_of("interpolationScheme", &scheme, false),
        }
    }
}

impl Plan for Probes {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        let mut find = Locator::new(mesh);
        for (i, x) in self.points.iter().enumerate() {
            if find.find(*x).is_none() {
                let message = format!(
                    "probe {i} of `{}` at {} lies outside the mesh",
                    self.name,
                    columns::vector(*x)
                );
                sink.push(Diag::warning(&self.span, message).label("writes -1e300 for it"));
            }
        }
    }
    fn build(&self, mesh: &Mesh, exec: &Exec) -> Box<dyn Function> {
        let mut find = Locator::new(mesh);
        let mut cells: Vec<Option<usize>> = self.points.iter().map(|x| find.find(*x)).collect();
        // A point on a cut belongs to the lowest rank that holds it.
        let rank = exec.rank() as f64;
        let mut claim: Vec<f64> =
            cells.iter().map(|c| if c.is_some() { -rank } else { f64::NEG_INFINITY }).collect();
        exec.comm().max(&mut claim);
        for (cell, claim) in cells.iter_mut().zip(claim) {
            *cell = cell.filter(|_| claim == -rank);
        }
        Box::new(Placed { plan: self.clone(), cells })
    }
}

struct Placed {
    plan: Probes,
    /// The cell of each point, where this rank has it.
    cells: Vec<Option<usize>>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        self.plan.fields.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let mut out = Vec::new();
        for &q in &self.plan.fields.list {
            // Values and how many ranks gave one.
            let mut sums = Vec::with_capacity(4 * self.cells.len());
            for (cell, x) in self.cells.iter().zip(&self.plan.points) {
                match cell {
                    Some(c) => {
                        sums.extend(view.at(q, *c, *x, self.plan.linear));
                        sums.push(1.0);
                    }
                    None => sums.extend([0.0; 4]),
                }
            }
            view.exec.comm().sum(&mut sums);
            if view.exec.rank() != 0 {
                continue;
            }
            let mut line = view.time_name.to_owned();
            for v in sums.chunks_exact(4) {
                let v = if v[3] > 0.0 { [v[0], v[1], v[2]] } else { [OUTSIDE; 3] };
                line.push('\t');
                line.push_str(&columns::value(q, v));
            }
            let mut header = String::new();
            for (i, x) in self.plan.points.iter().enumerate() {
                header.push_str(&format!("# Probe {i} {}\n", columns::vector(*x)));
            }
            let numbers: Vec<String> = (0..self.plan.points.len()).map(|i| i.to_string()).collect();
            header.push_str(&format!("# Probe\t{}\n# Time", numbers.join("\t")));
            out.push(Written::Line { file: q.name(), header, line });
        }
        out
    }
}
