//! Profiles along lines.
//!
//! `sets` is OpenFOAM's function; `profile` is the same with one line, written without the list:
//!
//! ```text
//! acrossGap { type profile; start (0.051 0 0); end (0.063 0 0); fields (U fluidity); }
//! ```
//!
//! Files: `postProcessing/<function>/<time>/<line>_<fields>.xy` and the like, see
//! [`super::set_format`].

use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::set_format::{Row, Set, SetFormat, files};
use super::track::{Line, Place};
use super::{Around, Entry, Function, Plan, Reading, Remembered, View, Written};
use crate::CaseConfig;
use granflow_dict::{Diag, Reader, Sink, Span, Value};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "sets",
    summary: "values along lines (`uniform`, `face`, `midPoint`, `midPointAndFace`, `polyLine`, `circle`) and at \
              points (`cloud`, `array`, `cellCentre`, `patchCloud`, `patchSeed`)",
    formula: "phi_P of the cell that holds each point, or phi_P + (x - x_P) . grad phi, the \
              gradient that fits the neighbours best (cellPoint)",
    reference: "OpenFOAM user guide, sampling",
    read: |r, reading| Box::new(Sets::read(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

pub(super) const ENTRY_PROFILE: Entry = Entry {
    name: "profile",
    summary: "a profile along one line: `start`, `end`, `fields`, perhaps `nPoints`, `axis`",
    formula: "as sets",
    reference: "as `sets`",
    read: |r, reading| Box::new(Sets::read_profile(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

/// A line of the list.
#[derive(Clone)]
struct Listed {
    line: Line,
    span: Span,
    /// Whether something of it was a mistake: of what it finds nothing is said then.
    refused: bool,
}

impl Listed {
    fn read(r: &Reader<'_>, span: Span, line: impl FnOnce() -> Line) -> Listed {
        let told = r.sink().n_errors();
        let line = line();
        Listed { line, span, refused: r.sink().n_errors() > told }
    }
}

#[derive(Clone)]
struct Sets {
    name: String,
    lines: Vec<Listed>,
    fields: Wanted,
    linear: bool,
    format: SetFormat,
}

impl Sets {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> Sets {
        let mut out = Sets::common(r, reading);
        // `sets ( a { .. } )`, or in newer files `sets { a { .. } }`.
        if matches!(r.dict().get("sets"), Some(Value::Dict(_))) {
            let subs = r.opt_sub("sets").map_or(Vec::new(), |s| s.subs());
            for (name, line) in subs {
                let span = r.value_span("sets");
                let read = || Line::read(&line, name, Some("type"));
                out.lines.push(Listed::read(r, span, read));
            }
        } else if let Some(mut list) = r.list("sets") {
            while !list.is_empty() {
                let span = list.here();
                let before = list.rest().len();
                let name = list.word("the name of a line");
                if let Some(line) = list.dict("a line") {
                    if out.lines.iter().any(|l| l.line.name == name) {
                        let message = format!("two sets are called `{name}`");
                        r.error_at(&span, message, "they would be one file", None);
                    }
                    let read = || Line::read(&line, name, Some("type"));
                    out.lines.push(Listed::read(r, span, read));
                }
                if list.rest().len() == before {
                    break;
                }
            }
        }
        out
    }

    fn read_profile(r: &Reader<'_>, reading: &Reading<'_>) -> Sets {
        let mut out = Sets::common(r, reading);
        let points = r.has("points").then_some("points");
        let read = || Line::read(r, reading.name, points);
        let line = Listed::read(r, Span::none(), read);
        out.lines.push(Listed { span: r.value_span("start"), ..line });
        out
    }

    fn common(r: &Reader<'_>, reading: &Reading<'_>) -> Sets {
        // Of moving meshes.
        r.ignore("fixedLocations");
        let scheme = [("cell", false), ("cellPoint", true), ("cellPointFace", true)];
        Sets {
            name: reading.name.into(),
            lines: Vec::new(),
            fields: Wanted::read(r, "fields", reading),
            linear: r.opt_one_of("interpolationScheme", &scheme, true),
            format: SetFormat::read(r, SetFormat::Raw),
        }
    }
}

impl Plan for Sets {
    fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        for Listed { line, span, refused } in &mut self.lines {
            let told = sink.n_errors();
            line.place(around, span, sink);
            *refused |= sink.n_errors() > told;
        }
    }
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        for Listed { line, span, .. } in self.lines.iter().filter(|l| !l.refused) {
            if line.places(mesh).is_empty() {
                let message =
                    format!("no point of `{}` of `{}` lies in the mesh", line.name, self.name);
                sink.push(Diag::error(span, message).label("outside the mesh"));
            }
        }
    }
    fn uses(&self) -> Vec<usize> {
        self.fields.uses()
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        let places = self.lines.iter().map(|l| l.line.places(mesh)).collect();
        Box::new(Placed { plan: self.clone(), places })
    }
}

struct Placed {
    plan: Sets,
    places: Vec<Vec<Place>>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        self.plan.fields.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let mut out = Vec::new();
        let fields = &self.plan.fields.list;
        for (Listed { line, .. }, places) in self.plan.lines.iter().zip(&self.places) {
            let width = 4 + fields.iter().map(|f| f.quantity.n()).sum::<usize>();
            let mut mine = Vec::with_capacity(width * places.len());
            for place in places {
                mine.push(place.t);
                mine.extend(place.x);
                for f in fields {
                    let v = view.at(f.quantity, place.cell, place.x, self.plan.linear);
                    mine.extend(&v[..f.quantity.n()]);
                }
            }
            let Some(all) = view.exec.comm().gather(mine) else { continue };
            let mut found: Vec<&[f64]> = all.iter().flat_map(|v| v.chunks_exact(width)).collect();
            found.sort_by(|a, b| a[0].total_cmp(&b[0]));
            // A point on a face is found in both of its cells.
            found.dedup_by(|b, a| b[0] - a[0] < line.grain());
            let rows: Vec<Row> = found.iter().map(|v| row(v, &self.plan)).collect();
            let along: Vec<Vec<f64>> =
                found.iter().map(|v| line.along(v[0], [v[1], v[2], v[3]])).collect();
            let set = Set {
                name: &line.name,
                axis: line.axis_word(),
                heads: &line.heads(),
                rows: &rows,
                along: &along,
                fields,
            };
            out.extend(files(self.plan.format, &set));
        }
        out
    }
}

/// A point and its values from what was gathered: order, place, components of all fields.
fn row(gathered: &[f64], plan: &Sets) -> Row {
    let mut rest = &gathered[4..];
    let mut values = Vec::with_capacity(plan.fields.list.len());
    for f in &plan.fields.list {
        let (own, others) = rest.split_at(f.quantity.n());
        values.push(components(own));
        rest = others;
    }
    Row { at: [gathered[1], gathered[2], gathered[3]], values }
}
