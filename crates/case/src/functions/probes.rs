//! Values at points, at every step or so.

use super::field::components;
use super::locate::Locator;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Reading, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Vec3;
use granflow_dict::{Diag, Reader, Sink, Span};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "probes",
    summary: "values at points against time, one table a field",
    formula: "phi(t) of the cell that holds each point; with interpolationScheme cellPoint \
              phi_P + (x - x_P) . grad phi",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| Box::new(Probes::read(r, reading)),
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
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> Probes {
        // Of moving meshes.
        r.ignore("fixedLocations");
        r.ignore("includeOutOfBounds");
        let scheme = [("cell", false), ("cellPoint", true), ("cellPointFace", true)];
        Probes {
            name: reading.name.into(),
            fields: Wanted::read(r, "fields", reading),
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
    fn uses(&self) -> Vec<usize> {
        self.fields.uses()
    }
    fn build(&self, mesh: &Mesh, exec: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
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
        for field in &self.plan.fields.list {
            let (q, n) = (field.quantity, field.quantity.n());
            // Values and how many ranks gave one.
            let mut sums = Vec::with_capacity((n + 1) * self.cells.len());
            for (cell, x) in self.cells.iter().zip(&self.plan.points) {
                match cell {
                    Some(c) => {
                        sums.extend(&view.at(q, *c, *x, self.plan.linear)[..n]);
                        sums.push(1.0);
                    }
                    None => sums.extend(vec![0.0; n + 1]),
                }
            }
            view.exec.comm().sum(&mut sums);
            if view.exec.rank() != 0 {
                continue;
            }
            let mut line = format!("{:>13}", view.time_name);
            let mut header = String::new();
            let mut numbers = String::new();
            for (i, (v, x)) in sums.chunks_exact(n + 1).zip(&self.plan.points).enumerate() {
                let there = v[n] > 0.0;
                let v = if there { components(&v[..n]) } else { [OUTSIDE; 9] };
                line += &format!(" {:>13}", columns::value(q.rank(), &v));
                let missing = if there { "" } else { "  # Not Found" };
                header += &format!("# Probe {i} {}{missing}\n", columns::vector(*x));
                numbers += &format!(" {i:>13}");
            }
            header += &format!("# {:>11}{numbers}\n# {:>11}", "Probe", "Time");
            out.push(Written::Line { file: field.name.clone(), header, line });
        }
        out
    }
}
