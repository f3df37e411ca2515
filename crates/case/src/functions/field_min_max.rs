//! Smallest and greatest values, in cells and on boundary faces, and where they are.

use super::field::{Components, components};
use super::magnitude::square;
use super::quantity::{Named, Wanted};
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Rank, Reading, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Vec3;
use granflow_dict::{Reader, Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "fieldMinMax",
    summary: "smallest and greatest value of fields (magnitude or components) with their places",
    formula: "min and max of phi (|phi| with mode magnitude) over cells and boundary faces",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| Box::new(MinMax::read(r, reading)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct MinMax {
    fields: Wanted,
    /// Sizes of vectors and tensors, rather than their components.
    magnitude: bool,
    /// Whether places are written.
    places: bool,
}

impl MinMax {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> MinMax {
        let modes = [("magnitude", true), ("component", false)];
        let mut fields = Wanted::read(r, "fields", reading);
        // In the order of OpenFOAM's columns.
        fields.list.sort_by(|a, b| a.name.cmp(&b.name));
        r.ignore("write");
        MinMax {
            fields,
            magnitude: r.opt_one_of("mode", &modes, true),
            places: r.opt_switch("location", true),
        }
    }
}

impl Plan for MinMax {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
    }
    fn uses(&self) -> Vec<usize> {
        self.fields.uses()
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

/// An extreme value: each component's own, and the place of the last one's.
struct Extreme {
    value: Components,
    place: Vec3,
}

impl MinMax {
    /// Whether the size of `f` is looked at, which is said.
    fn sized(&self, f: &Named) -> bool {
        self.magnitude && f.quantity.rank() != Rank::Scalar
    }
    /// What is compared at one place.
    fn compared(&self, f: &Named, v: Components) -> Components {
        match self.sized(f) {
            true => components(&[square(&v, f.quantity.rank()).sqrt()]),
            false => v,
        }
    }
    /// The least (`sign` -1) or greatest value of all ranks; `Some` on the first.
    fn extreme(&self, view: &View<'_>, f: &Named, sign: f64) -> Option<Extreme> {
        let (mesh, q) = (view.mesh, f.quantity);
        let n = if self.sized(f) { 1 } else { q.n() };
        // Value and place of each component.
        let mut best = vec![[f64::NEG_INFINITY, 0.0, 0.0, 0.0]; n];
        let mut take = |v: Components, x: Vec3| {
            for (best, v) in best.iter_mut().zip(self.compared(f, v)) {
                if sign * v > best[0] {
                    *best = [sign * v, x[0], x[1], x[2]];
                }
            }
        };
        (0..mesh.n_cells).for_each(|c| take(view.cell(q, c), mesh.cell_centre[c]));
        for face in mesh.n_inner..mesh.n_faces() {
            if let Some(v) = view.boundary(q, face) {
                take(v, mesh.face_centre[face]);
            }
        }
        let all = view.exec.comm().gather(best.into_iter().flatten().collect())?;
        let mut out = Extreme { value: [0.0; 9], place: [0.0; 3] };
        for k in 0..n {
            let of = |rank: &Vec<f64>| [0, 1, 2, 3].map(|i| rank[4 * k + i]);
            let mut most = of(all.first()?);
            for rank in &all[1..] {
                if rank[4 * k] > most[0] {
                    most = of(rank);
                }
            }
            out.value[k] = sign * most[0];
            out.place = [most[1], most[2], most[3]];
        }
        Some(out)
    }
}

impl Function for MinMax {
    fn needs_derived(&self) -> bool {
        self.fields.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let file = "fieldMinMax.dat".to_owned();
        let title = "# Field minima and maxima\n";
        let (mut out, mut heads, mut cells) = (Vec::new(), Vec::new(), Vec::new());
        for f in &self.fields.list {
            let ends = [-1.0, 1.0].map(|sign| self.extreme(view, f, sign));
            let [Some(low), Some(high)] = ends else { continue };
            let rank = if self.sized(f) { Rank::Scalar } else { f.quantity.rank() };
            let name = if self.sized(f) { format!("mag({})", f.name) } else { f.name.clone() };
            let [least, most] = [&low, &high].map(|e| match rank {
                Rank::Scalar => number(e.value[0]),
                _ => columns::value(rank, &e.value),
            });
            if !self.places {
                heads.extend([format!("min({name})"), format!("max({name})")]);
                cells.extend([least, most]);
                continue;
            }
            let heads = ["field", "min", "location(min)", "max", "location(max)"];
            let row = [name, least, columns::vector(low.place), most, columns::vector(high.place)];
            out.push(Written::Line {
                file: file.clone(),
                header: format!("{title}{}", columns::head(&heads.map(str::to_owned))),
                line: columns::row(view, &row),
            });
        }
        if !heads.is_empty() {
            let header = format!("{title}{}", columns::head(&heads));
            out.push(Written::Line { file, header, line: columns::row(view, &cells) });
        }
        out
    }
}
