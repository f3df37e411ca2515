//! Smallest and greatest values and where they are.

use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Quantity, View, Written, columns};
use crate::CaseConfig;
use granflow_base::norm;
use granflow_dict::{Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "fieldMinMax",
    summary: "smallest and greatest value of fields (magnitude of vectors) with their places",
    reference: "OpenFOAM user guide, function objects",
    read: |r, _| {
        r.ignore("location");
        r.opt_one_of("mode", &[("magnitude", ())], ());
        Box::new(MinMax { fields: Wanted::read(r, "fields") })
    },
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct MinMax {
    fields: Wanted,
}

impl Plan for MinMax {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
    }
    fn build(&self, _: &Mesh, _: &Exec) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

/// `[value, x, y, z]` of the cell with the greatest `sign * value` on this rank.
fn extreme(view: &View<'_>, q: Quantity, sign: f64) -> [f64; 4] {
    let mut best = [f64::NEG_INFINITY, 0.0, 0.0, 0.0];
    for c in 0..view.mesh.n_cells {
        let v = view.cell(q, c);
        let size = sign * if q.n() == 3 { norm(v) } else { v[0] };
        if size > best[0] {
            let x = view.mesh.cell_centre[c];
            best = [size, x[0], x[1], x[2]];
        }
    }
    best
}

impl Function for MinMax {
    fn needs_derived(&self) -> bool {
        self.fields.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let mut out = Vec::new();
        for &q in &self.fields.list {
            let ends = [-1.0, 1.0].map(|sign| {
                let all = view.exec.comm().gather(extreme(view, q, sign).to_vec());
                let best = all.and_then(|all| all.into_iter().max_by(|a, b| a[0].total_cmp(&b[0])));
                best.map(|b| (sign * b[0], [b[1], b[2], b[3]]))
            });
            let [Some((low, at_low)), Some((high, at_high))] = ends else { continue };
            let cells = [
                view.time_name.to_owned(),
                q.name().to_owned(),
                number(low),
                columns::vector(at_low),
                number(high),
                columns::vector(at_high),
            ];
            out.push(Written::Line {
                file: "fieldMinMax.dat",
                header: "# Field minima and maxima\n# Time\tfield\tmin\tlocation(min)\tmax\t\
                         location(max)"
                    .into(),
                line: cells.join("\t"),
            });
        }
        out
    }
}
