//! Residuals of every step, for plots of convergence.

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_dict::{Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "residuals",
    summary: "residuals of momentum, continuity and viscosity, outer iterations of every step",
    formula: "U: imbalance of forces over forces; p: net over gross flux of the cells; viscosity: \
              max |ln eta' - ln eta|, eta': one more evaluation of the rheology",
    reference: "OpenFOAM user guide, function objects",
    read: |r, _| {
        r.ignore("fields");
        r.ignore("writeResidualFields");
        Box::new(Residuals)
    },
    schedule: Schedule::always(Every::Steps(1)),
};

struct Residuals;

impl Plan for Residuals {
    fn check(&self, _: &Mesh, _: &CaseConfig, _: &Sink) {}
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Residuals)
    }
}

impl Function for Residuals {
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let r = view.report;
        let cells = [r.residuals.u, r.residuals.p, r.residuals.viscosity, r.outer as f64];
        let heads = ["U", "p", "viscosity", "outer"].map(str::to_owned);
        vec![Written::Line {
            file: "residuals.dat".into(),
            header: format!("# Residuals\n{}", columns::head(&heads)),
            line: columns::row(view, &cells.map(number)),
        }]
    }
}
