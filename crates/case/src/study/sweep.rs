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
//! family                               // optional: all of it for several values `y` of another parameter
//! {
//!     parameter gap;  unit mm;  values (5 10);  set ( { file ..; entry ..; value "{y}"; } );
//! }
//! figures { .. }                       // optional: as in plotDict; else one of each result
//! ```
//!
//! Point by point a case is written to `sweep/`, and the table to `sweep/<parameter>.csv`; the limits of a family to
//! `sweep/limit.csv`.

use super::setting::check_name;
use super::sweep_table::scale;
use super::{Point, Quantity, Setting, Solution, begin};
use crate::plot::Scale;
use crate::{CaseError, Options, files};
use granflow_dict::{Diag, Reader, Severity, Sink, number};
use std::collections::VecDeque;
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

/// Another parameter, for each of whose values the sweep is walked.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Its name.
    pub parameter: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// Its values.
    pub values: Vec<f64>,
    /// What it changes.
    pub settings: Vec<Setting>,
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
    /// The parameter of a family.
    pub family: Option<Family>,
    spacing: Spacing,
    /// The dictionary, where it has figures of its own.
    pub(super) figures: Option<String>,
}

/// A point of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// The family's parameter, where there is one.
    pub y: Option<f64>,
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
    /// The points, by the parameters.
    pub rows: Vec<Row>,
    /// For each of a family the last value that flows and the first that does not.
    pub limits: Vec<Ends>,
    /// The table and the figures.
    pub files: Vec<PathBuf>,
    /// Where an earlier sweep was put.
    pub set_aside: Option<PathBuf>,
    /// Whether the program was asked to stop.
    pub stopped: bool,
}

/// Where the flow of one of a family ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The family's parameter, where there is one.
    pub y: Option<f64>,
    /// The last value that flows.
    pub flows: f64,
    /// The first that does not.
    pub stands: f64,
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
            // What there is to choose from may be missing, which is said elsewhere.
            if names.is_empty() {
                l.ignore_all();
            }
            let below = l.entry("result").filter(|_| !names.is_empty()).map(|_| {
                (l.one_of("result", &names), l.scalar("below", granflow_base::Dims::NONE))
            });
            Limit { below, points: l.opt_label_in("points", 0..=60, 8) as usize }
        });
        let family = r.opt_sub("family").map(|f| Family {
            parameter: {
                let name = f.word("parameter").to_owned();
                check_name(&f, "parameter", &name, &[]);
                name
            },
            unit: f.opt_string("unit", "").to_owned(),
            values: read_values(&f).0,
            settings: Setting::read_all(&f, true),
        });
        let figures = r.has("figures").then(|| rel.to_owned());
        r.ignore("figures");
        let parameter = r.word("parameter").to_owned();
        check_name(&r, "parameter", &parameter, &["limit"]);
        let sweep = Sweep {
            parameter,
            unit: r.opt_string("unit", "").to_owned(),
            values,
            settings: Setting::read_all(&r, r.has("family")),
            continuation: r.opt_switch("continuation", true),
            results,
            limit,
            family,
            spacing,
            figures,
        };
        r.finish(Severity::Error);
        if sweep.figures.is_some() {
            crate::figures::check_in(root, rel, sink)?;
        }
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
        let (_lock, set_aside) = begin(case, "sweep")?;
        let Some(family) = &self.family else {
            let out = self.walk(case, None, options, sink, tell)?;
            return self.end(case, sink, (set_aside, out));
        };
        // Each of a family goes its own way.
        let one = Options { threads: 1, ..options.clone() };
        let mut out = Outcome::default();
        let walk = |y: f64, own: &Sink| self.walk(case, Some(y), &one, own, &mut |_| ());
        let mut take = |walked: Outcome| {
            walked.rows.iter().for_each(&mut *tell);
            out.stopped |= walked.stopped;
            out.rows.extend(walked.rows);
            out.limits.extend(walked.limits);
            out.stopped
        };
        side_by_side(&family.values, options.threads, sink, &walk, &mut take)?;
        let key = |y: Option<f64>| y.unwrap_or(0.0);
        out.rows.sort_by(|a, b| key(a.y).total_cmp(&key(b.y)).then(a.x.total_cmp(&b.x)));
        out.limits.sort_by(|a, b| key(a.y).total_cmp(&key(b.y)));
        self.end(case, sink, (set_aside, out))
    }

    /// Writes what there is. Where every point had mistakes in its files, they are the study's.
    fn end(
        &self,
        case: &Path,
        sink: &Sink,
        (set_aside, mut out): (Option<PathBuf>, Outcome),
    ) -> Result<Outcome, CaseError> {
        let wrong = |row: &Row| row.solution.mistakes.is_some();
        if !out.rows.is_empty() && out.rows.iter().all(wrong) {
            sink.extend(out.rows.swap_remove(0).solution.mistakes.unwrap_or_default().0);
            return Err(CaseError::Invalid);
        }
        out.set_aside = set_aside;
        self.write(case, sink, &mut out)?;
        Ok(out)
    }

    /// All values of the parameter, and the limit.
    fn walk(
        &self,
        case: &Path,
        y: Option<f64>,
        options: &Options,
        sink: &Sink,
        tell: &mut dyn FnMut(&Row),
    ) -> Result<Outcome, CaseError> {
        let mut out = Outcome::default();
        if self.continuation {
            let mut last: Option<Point> = None;
            for &x in &self.values {
                let quiet = Sink::new();
                // What one point has to say the others would say again.
                let said = if out.rows.is_empty() { sink } else { &quiet };
                let row = self.point(case, (x, y), last.as_ref(), options, said)?;
                if row.solution.stopped {
                    out.stopped = true;
                    break;
                }
                tell(&row);
                let flows = self.flows(&row);
                let ended = self.limit.is_some() && last.is_some() && !flows;
                if flows {
                    last = Some(Point { root: row.root.clone() });
                }
                out.rows.push(row);
                // Behind the limit nothing is left to follow.
                if ended {
                    break;
                }
            }
        } else {
            let one = Options { threads: 1, ..options.clone() };
            let point = |x: f64, own: &Sink| self.point(case, (x, y), None, &one, own);
            let mut take = |row: Row| {
                if row.solution.stopped {
                    out.stopped = true;
                } else {
                    tell(&row);
                    out.rows.push(row);
                }
                out.stopped
            };
            side_by_side(&self.values, options.threads, sink, &point, &mut take)?;
            // In the order in which they were asked for.
            out.rows.sort_by_key(|row| self.values.iter().position(|x| *x == row.x));
        }
        if !out.stopped {
            self.find_limit(case, y, options, tell, &mut out)?;
        }
        out.rows.sort_by(|a, b| a.x.total_cmp(&b.x));
        Ok(out)
    }

    /// Whether a point flows: where no limit says what that is, whether a solution was found.
    pub(super) fn flows(&self, row: &Row) -> bool {
        self.limit.as_ref().map_or_else(|| row.solution.found(), |limit| limit.flows(row))
    }

    /// Halves the gap between what flows and what does not.
    fn find_limit(
        &self,
        case: &Path,
        y: Option<f64>,
        options: &Options,
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
            let row = self.point(case, (x, y), Some(&from), options, &Sink::new())?;
            if row.solution.stopped {
                out.stopped = true;
                return Ok(());
            }
            tell(&row);
            if limit.flows(&row) {
                (flows, from) = (x, Point { root: row.root.clone() });
            } else {
                stands = x;
            }
            out.rows.push(row);
        }
        out.limits.push(Ends { y, flows, stands });
        Ok(())
    }

    fn point(
        &self,
        case: &Path,
        (x, y): (f64, Option<f64>),
        from: Option<&Point>,
        options: &Options,
        sink: &Sink,
    ) -> Result<Row, CaseError> {
        let mut root = case.join("sweep");
        if let (Some(family), Some(y)) = (&self.family, y) {
            root = root.join(format!("{}_{}", family.parameter, number(y)));
        }
        let root = root.join(format!("{}_{}", self.parameter, number(x)));
        let point = Point::copy(case, &root)?;
        let outer = self.family.as_ref().map_or(&[][..], |f| &f.settings);
        if let Err(e) = point.set(outer, x, y).and_then(|()| point.set(&self.settings, x, y)) {
            sink.push(Diag::file(root.display().to_string(), e.to_string()));
            return Err(CaseError::Invalid);
        }
        let solution = point.run(from, options, sink)?;
        let of = |q: &Quantity| q.of(&root);
        let results = self.results.iter().map(of).collect();
        Ok(Row { y, x, root, solution, results })
    }
}

/// Does `work` on every item, so many at a time, and hands what comes out to `take` until that says stop. What there is
/// to say of one item goes to the sink: the others would say it again.
fn side_by_side<R: Send>(
    items: &[f64],
    threads: usize,
    sink: &Sink,
    work: &(dyn Fn(f64, &Sink) -> Result<R, CaseError> + Sync),
    take: &mut dyn FnMut(R) -> bool,
) -> Result<(), CaseError> {
    let queue = Mutex::new(items.iter().copied().collect::<VecDeque<f64>>());
    let (queue, (done, results)) = (&queue, channel());
    let mut failed = None;
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1).min(items.len()) {
            let done = done.clone();
            scope.spawn(move || {
                loop {
                    let next = queue.lock().ok().and_then(|mut q| q.pop_front());
                    let Some(x) = next else { break };
                    // A sink is no thing of two threads.
                    let own = Sink::new();
                    let result = work(x, &own);
                    if done.send((result, own.take())).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        let empty = || {
            if let Ok(mut q) = queue.lock() {
                q.clear();
            }
        };
        let mut first = true;
        for (result, said) in results {
            match result {
                Ok(result) => {
                    if std::mem::take(&mut first) {
                        sink.extend(said.0);
                    }
                    if take(result) {
                        empty();
                    }
                }
                Err(e) => {
                    empty();
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

impl Limit {
    /// Whether a point flows.
    fn flows(&self, row: &Row) -> bool {
        row.solution.found()
            && self.below.is_none_or(|(i, least)| {
                row.results.get(i).is_some_and(|r| r.as_ref().is_ok_and(|v| *v >= least))
            })
    }
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
        let repeated = (1..out.len()).any(|i| out[..i].contains(&out[i]));
        if out.is_empty() || repeated {
            let what = if repeated { "a value is there twice" } else { "there is no value" };
            r.error_at_key("values", what, "needs values, each once", None);
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
    if n > 1 && from == to {
        range.error_at_key("to", "a range from a value to itself", "another value", None);
    }
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
        let (sweep, sink) = read(
            "parametr p; values (1 2); set ( { file f; entry e; value \"{y}\"; } ); \
                                  results ( { name r; file t; value v; } ); limit { result no; below 1; }",
        );
        assert!(sweep.is_err());
        let said = sink.take().to_string();
        for word in ["parametr", "`y`", "`no`"] {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}
