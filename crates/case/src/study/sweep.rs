//! `system/sweepDict`: a case at many values of one parameter.
//!
//! ```text
//! parameter    omega;                  // its name in the table
//! unit         "rad/s";                // optional
//! values       (0.01 0.02 0.05);       // or: range { from 1e-4; to 1; points 9; spacing logarithmic; }
//! set                                  // what it changes; `x` is its value
//! (
//!     { file 0.orig/U; entry boundaryField.inner.omega; value "{x}"; }
//! );
//! continuation yes;                    // each point starts from the one before; no: all at once
//! results
//! (
//!     { name torque; file "postProcessing/torque/0/moment.dat"; value "total_z"; }
//! );
//! limit { result torque; below 1e-9; points 8; }   // optional: where it ends, by bisection
//! ```
//!
//! Point by point a case is written to `sweep/`, and the table to `sweep/<parameter>.csv`.

use super::{Point, Quantity, Setting, Solution};
use crate::output::POST;
use crate::plot::{Axis, LineFigure, Marker, Scale, Series};
use crate::store::write_atomic;
use crate::{CaseError, Options, files};
use granflow_dict::{Diag, Reader, Severity, Sink, number};
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::channel;

/// How values follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spacing {
    Linear,
    Logarithmic,
}

/// Where the flow ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The result that tells, and the value below which there is no flow; else only whether a solution was found.
    pub below: Option<(usize, f64)>,
    /// Halvings of the gap between the last value that flows and the first that does not.
    pub points: usize,
}

/// A sweep as the dictionary describes it.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The parameter's name.
    pub parameter: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// Its values, in the order in which they are walked.
    pub values: Vec<f64>,
    /// What it changes.
    pub settings: Vec<Setting>,
    /// Whether each point starts from the one before.
    pub continuation: bool,
    /// What is taken from each point.
    pub results: Vec<Quantity>,
    /// Where it ends.
    pub limit: Option<Limit>,
    spacing: Spacing,
}

/// A point of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// The parameter.
    pub x: f64,
    /// Its case.
    pub root: PathBuf,
    /// How it came out.
    pub solution: Solution,
    /// The results; none where they could not be had, with the reason.
    pub results: Vec<Result<f64, String>>,
}

/// What a sweep came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The points, by the parameter.
    pub rows: Vec<Row>,
    /// The last value that flows and the first that does not.
    pub limit: Option<(f64, f64)>,
    /// The table and the figures.
    pub files: Vec<PathBuf>,
    /// Whether the program was asked to stop.
    pub stopped: bool,
}

impl Sweep {
    /// Reads `rel` of the case; mistakes go to the sink.
    ///
    /// # Errors
    /// The file is there and cannot be read; [`CaseError::Invalid`] with mistakes in the sink.
    pub fn read(root: &Path, rel: &str, sink: &Sink) -> Result<Sweep, CaseError> {
        let Some(dict) = files::dict(root, rel, sink)? else {
            let d = Diag::file(root.join(rel).display().to_string(), "this file is missing");
            sink.push(d.help("it says what to walk: see the book, \"Sweeps\""));
            return Err(CaseError::Invalid);
        };
        let r = Reader::new(&dict, sink);
        let (values, spacing) = read_values(&r);
        let results = Quantity::read_all(&r);
        let limit = r.opt_sub("limit").map(|l| {
            let names: Vec<(&str, usize)> =
                results.iter().enumerate().map(|(i, q)| (q.name.as_str(), i)).collect();
            let below = l.entry("result").map(|_| {
                (l.one_of("result", &names), l.scalar("below", granflow_base::Dims::NONE))
            });
            Limit { below, points: l.opt_label_in("points", 0..=60, 8) as usize }
        });
        let sweep = Sweep {
            parameter: r.word("parameter").to_owned(),
            unit: r.opt_string("unit", "").to_owned(),
            values,
            settings: Setting::read_all(&r),
            continuation: r.opt_switch("continuation", true),
            results,
            limit,
            spacing,
        };
        r.finish(Severity::Error);
        if sink.has_errors() { Err(CaseError::Invalid) } else { Ok(sweep) }
    }

    /// Walks all points; `tell` hears of each when it is done.
    ///
    /// # Errors
    /// The input is wrong, or the machine failed.
    pub fn run(
        &self,
        case: &Path,
        options: &Options,
        sink: &Sink,
        tell: &mut dyn FnMut(&Row),
    ) -> Result<Outcome, CaseError> {
        let mut out = Outcome::default();
        if self.continuation {
            let mut last: Option<Point> = None;
            for &x in &self.values {
                let row = self.point(case, x, last.as_ref(), options, sink)?;
                tell(&row);
                if row.solution.found() {
                    last = Some(Point { root: row.root.clone() });
                }
                out.stopped |= row.solution.stopped;
                out.rows.push(row);
                if out.stopped {
                    break;
                }
            }
        } else {
            self.all_at_once(case, options, sink, tell, &mut out)?;
            // In the order in which they were asked for.
            let at = |row: &Row| self.values.iter().position(|x| *x == row.x);
            out.rows.sort_by_key(at);
        }
        if !out.stopped {
            self.find_limit(case, options, sink, tell, &mut out)?;
        }
        out.rows.sort_by(|a, b| a.x.total_cmp(&b.x));
        self.write(case, &mut out)?;
        Ok(out)
    }

    /// Independent points, one thread each.
    fn all_at_once(
        &self,
        case: &Path,
        options: &Options,
        sink: &Sink,
        tell: &mut dyn FnMut(&Row),
        out: &mut Outcome,
    ) -> Result<(), CaseError> {
        let queue = Mutex::new(self.values.iter().copied().collect::<VecDeque<f64>>());
        let (queue, (done, rows)) = (&queue, channel());
        let one = Options { threads: 1, ..options.clone() };
        let mut failed = None;
        std::thread::scope(|scope| {
            for _ in 0..options.threads.max(1).min(self.values.len()) {
                let (done, one) = (done.clone(), &one);
                scope.spawn(move || {
                    loop {
                        let next = queue.lock().ok().and_then(|mut q| q.pop_front());
                        let Some(x) = next else { break };
                        // Mistakes of each go to a sink of its own, which is no thing of two threads.
                        let own = Sink::new();
                        let row = self.point(case, x, None, one, &own);
                        let stop = row.as_ref().map_or(true, |r| r.solution.stopped);
                        if done.send((row, own.take())).is_err() || stop {
                            break;
                        }
                    }
                });
            }
            drop(done);
            for (row, said) in rows {
                match row {
                    Ok(row) => {
                        tell(&row);
                        out.stopped |= row.solution.stopped;
                        out.rows.push(row);
                    }
                    Err(e) => {
                        if let Ok(mut q) = queue.lock() {
                            q.clear();
                        }
                        // The same mistake of many points is said once.
                        if failed.is_none() {
                            sink.extend(said.0);
                            failed = Some(e);
                        }
                    }
                }
            }
        });
        failed.map_or(Ok(()), Err)
    }

    /// Halves the gap between what flows and what does not.
    fn find_limit(
        &self,
        case: &Path,
        options: &Options,
        sink: &Sink,
        tell: &mut dyn FnMut(&Row),
        out: &mut Outcome,
    ) -> Result<(), CaseError> {
        let Some(limit) = &self.limit else { return Ok(()) };
        let gap = out.rows.windows(2).find(|w| limit.flows(&w[0]) != limit.flows(&w[1]));
        let Some([a, b]) = gap else { return Ok(()) };
        let (yes, no) = if limit.flows(a) { (a, b) } else { (b, a) };
        let (mut flows, mut stands) = (yes.x, no.x);
        let mut from = Point { root: yes.root.clone() };
        for _ in 0..limit.points {
            let x = match self.spacing {
                Spacing::Logarithmic => (flows * stands).sqrt(),
                Spacing::Linear => 0.5 * (flows + stands),
            };
            let row = self.point(case, x, Some(&from), options, sink)?;
            tell(&row);
            out.stopped |= row.solution.stopped;
            if out.stopped {
                return Ok(());
            }
            if limit.flows(&row) {
                (flows, from) = (x, Point { root: row.root.clone() });
            } else {
                stands = x;
            }
            out.rows.push(row);
        }
        out.limit = Some((flows, stands));
        Ok(())
    }

    fn point(
        &self,
        case: &Path,
        x: f64,
        from: Option<&Point>,
        options: &Options,
        sink: &Sink,
    ) -> Result<Row, CaseError> {
        let root = case.join("sweep").join(format!("{}_{}", self.parameter, number(x)));
        let point = Point::copy(case, &root)?;
        if let Err(e) = point.set(&self.settings, x) {
            sink.push(Diag::file(root.display().to_string(), e.to_string()));
            return Err(CaseError::Invalid);
        }
        let solution = point.run(from, options, sink)?;
        let of = |q: &Quantity| q.of(&root);
        let results = self.results.iter().map(of).collect();
        Ok(Row { x, root, solution, results })
    }

    /// The table, and a figure for each result.
    fn write(&self, case: &Path, out: &mut Outcome) -> Result<(), CaseError> {
        let mut text = self.parameter.clone();
        self.results.iter().for_each(|q| text += &format!(",{}", q.name));
        text += ",converged,steady,passes\n";
        for row in &out.rows {
            text += &number(row.x);
            for result in &row.results {
                // What is missing is no number.
                let _ = write!(text, ",{}", result.as_ref().map_or("nan".into(), |v| number(*v)));
            }
            let s = &row.solution;
            let [converged, steady] = [s.found(), s.steady].map(u8::from);
            let _ = writeln!(text, ",{converged},{steady},{}", s.passes);
        }
        let table = case.join("sweep").join(format!("{}.csv", self.parameter));
        write_atomic(&table, text.as_bytes())?;
        out.files.push(table);
        for (i, result) in self.results.iter().enumerate() {
            let of = |r: &Row| Some((r.x, *r.results[i].as_ref().ok()?));
            let flowing = out.rows.iter().filter(|r| r.solution.found());
            let points: Vec<(f64, f64)> = flowing.filter_map(of).collect();
            if points.is_empty() {
                continue;
            }
            let unit = if self.unit.is_empty() { String::new() } else { format!(", {}", self.unit) };
            let axis = |label: String, scale: Scale| Axis { label, scale, range: None };
            let x: Vec<f64> = points.iter().map(|p| p.0).collect();
            let y: Vec<f64> = points.iter().map(|p| p.1).collect();
            let markers = Series::markers("", Marker::nth(0), points.clone());
            let colour = crate::plot::PALETTE[0];
            let figure = LineFigure {
                title: String::new(),
                x: axis(format!("{}{unit}", self.parameter), scale(&x)),
                y: axis(result.name.clone(), scale(&y)),
                series: vec![
                    Series::line("", points).coloured(colour),
                    markers.coloured(colour),
                ],
                ..LineFigure::default()
            };
            let stem = case.join(POST).join("figures").join(format!("sweep_{}", result.name));
            let (svg, png) = (stem.with_extension("svg"), stem.with_extension("png"));
            write_atomic(&svg, figure.to_svg().as_bytes())?;
            write_atomic(&png, &figure.to_png()?)?;
            out.files.extend([png, svg]);
        }
        Ok(())
    }
}

impl Limit {
    /// Whether a point flows.
    fn flows(&self, row: &Row) -> bool {
        row.solution.found()
            && self.below.is_none_or(|(i, least)| {
                row.results.get(i).is_some_and(|r| r.as_ref().is_ok_and(|v| *v >= least))
            })
    }
}

/// Logarithmic where values span two decades or more.
fn scale(values: &[f64]) -> Scale {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    if least > 0.0 && most >= 100.0 * least { Scale::Log } else { Scale::Linear }
}

fn read_values(r: &Reader<'_>) -> (Vec<f64>, Spacing) {
    let none = granflow_base::Dims::NONE;
    let Some(range) = r.opt_sub("range") else {
        let mut out = Vec::new();
        if let Some(mut list) = r.list("values") {
            while !list.is_empty() {
                let left = list.rest().len();
                out.push(list.number("a value"));
                if list.rest().len() == left {
                    break;
                }
            }
        }
        let positive = out.iter().all(|x| *x > 0.0);
        let decades = positive && scale(&out) == Scale::Log;
        return (out, if decades { Spacing::Logarithmic } else { Spacing::Linear });
    };
    r.ignore("values");
    let kinds = [("linear", Spacing::Linear), ("logarithmic", Spacing::Logarithmic)];
    let spacing = range.opt_one_of("spacing", &kinds, Spacing::Linear);
    let (from, to) = match spacing {
        Spacing::Linear => (range.scalar("from", none), range.scalar("to", none)),
        Spacing::Logarithmic => (range.positive("from", none), range.positive("to", none)),
    };
    let n = range.label_in("points", 1..=10_000) as usize;
    let at = |i: usize| {
        let t = if n > 1 { i as f64 / (n - 1) as f64 } else { 0.0 };
        match spacing {
            Spacing::Linear => from + t * (to - from),
            // Twelve digits: a name that a person can read.
            Spacing::Logarithmic => {
                let x = from * (to / from).powf(t);
                format!("{x:.11e}").parse().unwrap_or(x)
            }
        }
    };
    ((0..n).map(at).collect(), spacing)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Result<Sweep, CaseError>, Sink) {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(dir.path().join("system")).unwrap();
        std::fs::write(dir.path().join("system/sweepDict"), text).unwrap();
        let sink = Sink::new();
        (Sweep::read(dir.path(), "system/sweepDict", &sink), sink)
    }
    const SET: &str = "set ( { file f; entry e; } ); results ( { name r; file t; value v; } );";

    #[test]
    fn a_range_walks_as_it_says() {
        let range = "range { from 1e-3; to 1; points 4; spacing logarithmic; }";
        let (sweep, _) = read(&format!("parameter p; {range} {SET}"));
        assert_eq!(sweep.unwrap().values, [1e-3, 1e-2, 1e-1, 1.0]);
        let (sweep, _) = read(&format!("parameter p; range {{ from 3; to 1; points 3; }} {SET}"));
        assert_eq!(sweep.unwrap().values, [3.0, 2.0, 1.0]);
    }

    #[test]
    fn all_mistakes_are_said_at_once() {
        let (sweep, sink) = read("parametr p; values (1 2); set ( { file f; entry e; value \"{y}\"; } ); \
                                  results (); limit { result no; below 1; }");
        assert!(sweep.is_err());
        let said = sink.take().to_string();
        for word in ["parametr", "`y`", "`no`"] {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}
