//! The first of two phases as a whole: its volume, where it is, how it moves, how far it reaches, what
//! leaves.

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written};
use crate::CaseConfig;
use granflow_dict::{Diag, Sink, Span, number};
use granflow_fv::Unknown;
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "phase",
    summary: "volume, centroid, mean velocity, extent (where alpha = 0.5) and outflow of the first phase",
    formula: "V = sum alpha V_P, x = sum alpha V_P x_P/V, u = sum alpha V_P U_P/V",
    reference: "S. Hysing et al., Int. J. Numer. Meth. Fluids 60 (2009) 1259, section 2",
    read: |r, _| Box::new(Phase { span: r.key_span("type") }),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct Phase {
    span: Span,
}

impl Plan for Phase {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        if config.transport.second.is_none() {
            let message = "the function `phase` needs two phases";
            sink.push(Diag::error(&self.span, message).label("the case has one"));
        }
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

/// Volume, first moments and momentum over density: sums over this rank's cells.
fn moments(view: &View<'_>, alpha: &[f64]) -> [f64; 7] {
    let mesh = view.mesh;
    view.exec.sums(mesh.n_cells, |range| {
        let mut s = [0.0; 7];
        for c in range {
            let v = alpha[c] * mesh.volume[c];
            s[0] += v;
            for k in 0..3 {
                s[1 + k] += v * mesh.cell_centre[c][k];
                s[4 + k] += v * view.u.cells.data[c][k];
            }
        }
        s
    })
}

/// Least (`sign` -1) or greatest coordinate at which alpha is 0.5 between two cells, or of a wall
/// beside a cell that is more than half full; times `sign`.
fn reach(view: &View<'_>, alpha: &[f64], k: usize, sign: f64) -> f64 {
    let mesh = view.mesh;
    let at = |f: usize| {
        let o = mesh.owner[f] as usize;
        let (here, x) = (alpha[o] - 0.5, mesh.cell_centre[o][k]);
        let Some(&n) = mesh.neighbour.get(f) else {
            return if here >= 0.0 { sign * mesh.face_centre[f][k] } else { f64::NEG_INFINITY };
        };
        let there = alpha[n as usize] - 0.5;
        if (here >= 0.0) == (there >= 0.0) {
            return f64::NEG_INFINITY;
        }
        sign * (x + here / (here - there) * mesh.delta[f][k])
    };
    view.exec.max(mesh.n_faces(), |r| r.map(at).fold(f64::NEG_INFINITY, f64::max))
}

/// What leaves through the boundary less what enters, m3/s, with the flow as the step ends: what the volume
/// loses in the next step.
fn outflow(view: &View<'_>, alpha: &Unknown<f64>) -> f64 {
    let (mesh, first) = (view.mesh, view.mesh.n_inner);
    let leaves = |b: usize| view.phi[first + b] * alpha.boundary_value(mesh, first + b);
    view.exec.sum(mesh.n_faces() - first, |r| r.map(leaves).sum())
}

impl Function for Phase {
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let Some(alpha) = view.alpha else { return Vec::new() };
        let leaves = outflow(view, alpha);
        let alpha = &alpha.cells.data;
        let m = moments(view, alpha);
        let mut row = vec![m[0]];
        row.extend(m[1..].iter().map(|x| if m[0] > 0.0 { x / m[0] } else { 0.0 }));
        let n = view.mesh.n_cells;
        let half_full = view.exec.max(n, |r| r.map(|c| alpha[c]).fold(0.0, f64::max)) >= 0.5;
        for k in 0..3 {
            for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
                // There are no faces on empty patches.
                let x = match view.mesh.solved_dirs[k] {
                    false if half_full => view.mesh.extent[k][side],
                    _ => sign * reach(view, alpha, k, sign),
                };
                row.push(if x.is_finite() { x } else { 0.0 });
            }
        }
        row.push(leaves);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let cells: Vec<String> = row.into_iter().map(number).collect();
        vec![Written::Line {
            file: "phase.dat".into(),
            header:
                "# The first phase: m3, m, m/s, m3/s\n# Time\tvolume\tx\ty\tz\tU_x\tU_y\tU_z\tx_min\t\
                     x_max\ty_min\ty_max\tz_min\tz_max\toutflow"
                    .into(),
            line: format!("{}\t{}", view.time_name, cells.join("\t")),
        }]
    }
}
