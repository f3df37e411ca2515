//! Profiles along lines.
//!
//! `sets` is OpenFOAM's function; `profile` is the same with one line, written without the list:
//!
//! ```text
//! acrossGap { type profile; start (0.051 0 0); end (0.063 0 0); fields (U fluidity); }
//! ```
//!
//! Files: `postProcessing/<function>/<time>/<line>_<fields>.xy` (raw, with a comment line that
//! names the columns) or `.csv`.

use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::track::{Line, Place};
use super::{Entry, Function, Plan, View, Written};
use crate::CaseConfig;
use granflow_dict::{Diag, Reader, Sink, Span, Value, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "sets",
    summary: "profiles along lines, one file a line and time",
    reference: "OpenFOAM user guide, sampling",
    read: |r, name| Box::new(Sets::read(r, name)),
    schedule: Schedule::always(Every::Writes(1)),
};

pub(super) const ENTRY_PROFILE: Entry = Entry {
    name: "profile",
    summary: "a profile along one line: `start`, `end`, `fields`, perhaps `nPoints`, `axis`",
    reference: "as `sets`",
    read: |r, name| Box::new(Sets::read_profile(r, name)),
    schedule: Schedule::always(Every::Writes(1)),
};

#[derive(Clone)]
struct Sets {
    name: String,
    lines: Vec<(Line, Span)>,
    fields: Wanted,
    linear: bool,
    csv: bool,
}

impl Sets {
    fn read(r: &Reader<'_>, name: &str) -> Sets {
        let mut out = Sets::common(r, name);
        // `sets ( a { .. } )`, or in newer files `sets { a { .. } }`.
        if matches!(r.dict().get("sets"), Some(Value::Dict(_))) {
            let subs = r.opt_sub("sets").map_or(Vec::new(), |s| s.subs());
            for (name, line) in subs {
                out.lines.push((Line::read(&line, name, Some("type")), r.value_span("sets")));
            }
        } else if let Some(mut list) = r.list("sets") {
            while !list.is_empty() {
                let span = list.here();
                let before = list.rest().len();
                let name = list.word("the name of a line");
                if let Some(line) = list.dict("a line") {
                    out.lines.push((Line::read(&line, name, Some("type")), span));
                }
                if list.rest().len() == before {
                    break;
                }
            }
        }
        out
    }

    fn read_profile(r: &Reader<'_>, name: &str) -> Sets {
        let mut out = Sets::common(r, name);
        let points = r.has("points").then_some("points");
        let line = Line::read(r, name, points);
        out.lines.push((line, r.value_span("start")));
        out
    }

    fn common(r: &Reader<'_>, name: &str) -> Sets {
        // Of moving meshes.
        r.ignore("fixedLocations");
        let scheme = [("cell", false), ("cellPoint", true), ("cellPointFace", true)];
        Sets {
            name: name.into(),
            lines: Vec::new(),
            fields: Wanted::read(r, "fields"),
            linear: r.opt_one_of("interpolationScheme", &scheme, true),
            csv: format(r),
        }
    }
}

/// Formats of other programs' tables: their numbers are written as columns.
const AS_COLUMNS: &[&str] = &["vtk", "gnuplot", "xmgr", "jplot", "ensight"];

/// Whether tables are csv, rather than columns.
fn format(r: &Reader<'_>) -> bool {
    if let Some(word) = r.raw("setFormat").and_then(|t| t.first()?.word())
        && AS_COLUMNS.contains(&word)
    {
        let message = format!("`{word}` is served by `raw`: columns of numbers");
        r.warn_at_key("setFormat", message, "not written", None);
        return false;
    }
    r.opt_one_of("setFormat", &[("raw", false), ("csv", true)], false)
}

impl Plan for Sets {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        for (line, span) in &self.lines {
            if line.places(mesh).is_empty() {
                let message =
                    format!("no point of `{}` of `{}` lies in the mesh", line.name, self.name);
                sink.push(Diag::error(span, message).label("outside the mesh"));
            }
        }
    }
    fn build(&self, mesh: &Mesh, _: &Exec) -> Box<dyn Function> {
        let places = self.lines.iter().map(|(line, _)| line.places(mesh)).collect();
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
        for ((line, _), places) in self.plan.lines.iter().zip(&self.places) {
            let width = 4 + fields.iter().map(|q| q.n()).sum::<usize>();
            let mut mine = Vec::with_capacity(width * places.len());
            for place in places {
                mine.push(place.t);
                mine.extend(place.x);
                for &q in fields {
                    let v = view.at(q, place.cell, place.x, self.plan.linear);
                    mine.extend(&v[..q.n()]);
                }
            }
            let Some(all) = view.exec.comm().gather(mine) else { continue };
            let mut rows: Vec<&[f64]> = all.iter().flat_map(|v| v.chunks_exact(width)).collect();
            rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
            // A point on a face is found in both of its cells.
            rows.dedup_by(|b, a| b[0] - a[0] < line.grain());
            let names: Vec<&str> = fields.iter().map(|q| q.name()).collect();
            let extension = if self.plan.csv { "csv" } else { "xy" };
            out.push(Written::File {
                file: format!("{}_{}.{extension}", line.name, names.join("_")),
                text: self.table(line, &rows),
            });
        }
        out
    }
}

impl Placed {
    fn table(&self, line: &Line, rows: &[&[f64]]) -> String {
        let mut heads: Vec<String> = line.heads().iter().map(|h| (*h).to_owned()).collect();
        heads.extend(self.plan.fields.list.iter().flat_map(|q| q.columns()));
        let separator = if self.plan.csv { "," } else { "\t" };
        let start = if self.plan.csv { "" } else { "# " };
        let mut text = format!("{start}{}\n", heads.join(separator));
        for row in rows {
            let mut cells = line.along([row[1], row[2], row[3]]);
            cells.extend(&row[4..]);
            let cells: Vec<String> = cells.into_iter().map(number).collect();
            text.push_str(&cells.join(separator));
            text.push('\n');
        }
        text
    }
}
