//! The linear solves of every step.

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written, columns};
use crate::CaseConfig;
use crate::config::LinearSolve;
use granflow_dict::{Reader, Sink, number};
use granflow_flow::SolveCount;
use granflow_linsolve::Solved;
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "solverInfo",
    summary: "linear solvers of every step: residuals of the first solve, iterations, whether all converged",
    formula: "r = sum |b - A x|/sum (|A x - A x_mean| + |b - A x_mean|) before and after each \
              solve",
    reference: "OpenFOAM user guide, function objects",
    read: |r, _| Box::new(SolverInfo::read(r)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct SolverInfo {
    /// Fields that were asked for.
    fields: Vec<String>,
}

impl SolverInfo {
    fn read(r: &Reader<'_>) -> SolverInfo {
        r.ignore("writeResidualFields");
        let span = r.value_span("fields");
        let known = ["U", "p", "p_rgh"];
        let mut fields = Vec::new();
        for word in r.words("fields") {
            match word {
                "U" | "p" | "p_rgh" => fields.push(word.to_owned()),
                // Fields of turbulence models in files that serve many cases.
                _ => {
                    let message = format!("no linear solver of `{word}` is reported");
                    let help = format!("known are {}", known.join(", "));
                    r.warn_at(&span, message, "left out", Some(&help));
                }
            }
        }
        // In the order of OpenFOAM's columns.
        fields.sort();
        SolverInfo { fields }
    }
}

impl Plan for SolverInfo {
    fn check(&self, _: &Mesh, _: &CaseConfig, _: &Sink) {}
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

impl Function for SolverInfo {
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let (mut heads, mut cells) = (Vec::new(), Vec::new());
        let (report, config) = (view.report, &view.whole.case.config);
        for field in &self.fields {
            let velocity = field == "U";
            if !velocity && field != config.pressure() {
                continue;
            }
            let k = usize::from(!velocity);
            let solves = if velocity { report.u } else { report.p };
            let solver = if velocity { &config.solution.u } else { &config.solution.p };
            let solved = (solves.as_ref(), report.iterations[k], &report.solves[k]);
            let along = ["x", "y", "z"].iter().zip(view.mesh.solved_dirs).filter(|d| d.1);
            let parts: Vec<String> = match velocity {
                true => along.map(|d| format!("{field}{}", d.0)).collect(),
                false => vec![field.clone()],
            };
            put(field, &parts, solver, solved, &mut heads, &mut cells);
        }
        vec![Written::Line {
            file: "solverInfo.dat".into(),
            header: format!("# Solver information\n{}", columns::head(&heads)),
            line: columns::row(view, &cells),
        }]
    }
}

/// The columns of one field. Its components are solved together and have the same numbers.
fn put(
    field: &str,
    parts: &[String],
    solver: &LinearSolve,
    (solves, iterations, count): (Option<&(Solved, Solved)>, usize, &SolveCount),
    heads: &mut Vec<String>,
    cells: &mut Vec<String>,
) {
    let mut put = |head: String, cell: String| {
        heads.push(head);
        cells.push(cell);
    };
    let before = solver.spec.preconditioner.as_deref().unwrap_or("");
    put(format!("{field}_solver"), format!("{before}{}", solver.spec.solver));
    let [first, last] = solves.map_or([0.0; 2], |(first, last)| [first.first, last.last]);
    for part in parts {
        put(format!("{part}_initial"), number(first));
        put(format!("{part}_final"), number(last));
        put(format!("{part}_iters"), iterations.to_string());
    }
    put(format!("{field}_converged"), (count.unconverged == 0).to_string());
}
