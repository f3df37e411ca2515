//! `granflow validate`: runs built-in cases, compares them with their references, writes a report.

use crate::args::Validate;
use crate::catalogue::{self, Builtin};
use crate::failure::Failure;
use crate::session::Session;
use crate::signals::Signals;
use crate::text::{duration, number, residual, rounded, shown};
use granflow_case::expect::{Quantity, judge};
use granflow_case::store::DirWriter;
use granflow_case::{CaseError, End, Event, Notices, Options, Run};
use granflow_dict::{Sink, nearest};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A case that was run.
struct Outcome {
    case: &'static Builtin,
    quantities: Vec<Quantity>,
    /// Why there are none.
    failure: Option<String>,
    figures: Vec<PathBuf>,
    wall: f64,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`]; [`Failure::Validation`] when a quantity is not what it should be.
pub(crate) fn command(session: &mut Session, args: &Validate) -> Result<(), Failure> {
    let cases = chosen(&args.names)?;
    let signals = Signals::listen().map_err(Failure::Output)?;
    let scratch = tempfile::tempdir().map_err(Failure::Scratch)?;
    session.out.print(&row(["case", "quantity", "expected", "found", "verdict"]));
    let mut outcomes = Vec::new();
    for case in cases {
        let dir = scratch.path().join(case.name);
        let options = Options { stop: signals.stop(), ..Options::default() };
        let outcome = run(case, &dir, &options)?;
        if let Some(signal) = signals.received() {
            return Err(Failure::Signal(signal));
        }
        for line in table(&outcome) {
            session.out.print(&line);
        }
        outcomes.push(outcome);
    }
    let report = write_report(&args.out, &outcomes)?;
    session.out.say(&format!("report  {}", shown(&report)));
    let failed = outcomes.iter().map(Outcome::failed).sum();
    let of = outcomes.iter().map(|o| o.quantities.len().max(1)).sum();
    if failed > 0 { Err(Failure::Validation { failed, of }) } else { Ok(()) }
}

/// The cases of those names, or all that have something to compare with.
fn chosen(names: &[String]) -> Result<Vec<&'static Builtin>, Failure> {
    let known = || catalogue::ALL.iter().filter(|c| c.has("expect.toml"));
    if names.is_empty() {
        return Ok(known().filter(|c| !c.is_slow()).collect());
    }
    let find = |name: &String| {
        known().find(|c| c.name == *name).ok_or_else(|| {
            let all: Vec<&str> = known().map(|c| c.name).collect();
            let near = nearest(name, all.iter().copied());
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let message = format!("there is no built-in case `{name}` with a reference");
            Failure::refused(message, format!("{near}known are {}", all.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

/// Writes the case to `dir`, runs it and judges what came out.
fn run(case: &'static Builtin, dir: &Path, options: &Options) -> Result<Outcome, Failure> {
    let begin = Instant::now();
    let mut writer = DirWriter::begin(dir)?;
    for (path, bytes) in case.files {
        writer.file_plain(path, bytes)?;
    }
    writer.commit()?;
    let mut out =
        Outcome { case, quantities: Vec::new(), failure: None, figures: Vec::new(), wall: 0.0 };
    let sink = Sink::new();
    match computed(dir, options, &sink) {
        Ok((figures, unconverged)) => {
            out.figures = figures;
            match judge(dir) {
                Ok(all) => out.quantities = all,
                Err(e) => out.failure = Some(e),
            }
            out.quantities.push(Quantity {
                what: "steps that did not converge".into(),
                value: Some(unconverged as f64),
                expected: Some(0.0),
                error: unconverged as f64,
                tolerance: case.may_not_converge(),
                source: "residualControl".into(),
            });
        }
        // A full disk is nothing to report on.
        Err(e) if e.exit_code() == 4 => return Err(e.into()),
        Err(CaseError::Invalid) => out.failure = Some(sink.take().to_string()),
        Err(e) => out.failure = Some(e.to_string()),
    }
    out.wall = begin.elapsed().as_secs_f64();
    Ok(out)
}

/// The figures that a run of the case draws, and how many of its steps did not converge.
fn computed(
    dir: &Path,
    options: &Options,
    sink: &Sink,
) -> Result<(Vec<PathBuf>, usize), CaseError> {
    let mut run = Run::load(dir, options, sink, &Notices::new())?;
    let mut unconverged = 0;
    loop {
        match run.advance()? {
            Event::Step(step) => unconverged += usize::from(!step.report.converged),
            Event::Done(End::Stopped) => return Ok((Vec::new(), unconverged)),
            Event::Done(End::EndTime | End::Steady) => break,
        }
    }
    let mut figures = run.finish(sink)?;
    figures.retain(|f| f.extension().is_some_and(|e| e == "png"));
    Ok((figures, unconverged))
}

impl Outcome {
    fn failed(&self) -> usize {
        let wrong = self.quantities.iter().filter(|q| !q.passed()).count();
        wrong + usize::from(self.failure.is_some())
    }
}

/// Expected, found and verdict of a quantity.
fn words(q: &Quantity) -> [String; 3] {
    let verdict = if q.passed() { "pass" } else { "FAIL" };
    let (expected, found) = match (q.expected, q.value) {
        (Some(e), Some(v)) if q.tolerance == 0.0 => (rounded(e, 6), rounded(v, 6)),
        (Some(e), Some(v)) => {
            (format!("{} +- {}", rounded(e, 6), number(q.tolerance)), rounded(v, 6))
        }
        _ => (format!("error <= {}", residual(q.tolerance)), residual(q.error)),
    };
    [expected, found, verdict.to_owned()]
}

fn row(cells: [&str; 5]) -> String {
    let [case, what, expected, found, verdict] = cells;
    format!("{case:<27} {what:<43} {expected:<23} {found:<11} {verdict}").trim_end().to_owned()
}

fn table(o: &Outcome) -> Vec<String> {
    let line = |q: &Quantity| {
        let [expected, found, verdict] = words(q);
        row([o.case.name, &q.what, &expected, &found, &verdict])
    };
    let mut lines: Vec<String> = o.quantities.iter().map(line).collect();
    if let Some(why) = &o.failure {
        lines.push(row([o.case.name, why.lines().next().unwrap_or(""), "", "", "FAIL"]));
    }
    lines
}

/// Writes `report.md` with the figures beside it; files of other names in `dir` stay.
fn write_report(dir: &Path, outcomes: &[Outcome]) -> Result<PathBuf, Failure> {
    let mut writer = DirWriter::begin(dir)?.keep_existing()?;
    let mut text = format!(
        "# granflow {}: validation\n\nEach case of the catalogue was run as `granflow run` runs it \
         and compared with its reference.\n",
        env!("CARGO_PKG_VERSION")
    );
    // Writing to a string does not fail.
    for o in outcomes {
        let _ = write!(text, "\n## {}\n\n{}. ", o.case.name, o.case.summary());
        let (reference, wall) = (o.case.reference(), duration(o.wall));
        let _ = writeln!(text, "Reference: {reference}. {wall} of wall time.\n");
        if let Some(why) = &o.failure {
            let _ = writeln!(text, "**Not computed:**\n\n```\n{}\n```\n", why.trim_end());
        }
        if !o.quantities.is_empty() {
            text += "| quantity | expected | found | verdict | source |\n|---|---|---|---|---|\n";
        }
        for q in &o.quantities {
            let [expected, found, verdict] = words(q);
            let source = &q.source;
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} |",
                cell(&q.what),
                cell(&expected),
                cell(&found),
                verdict,
                cell(source)
            );
        }
        for figure in &o.figures {
            let stem = figure.file_stem().unwrap_or_default().to_string_lossy();
            let name = format!("{}_{stem}.png", o.case.name);
            let bytes = fs::read(figure).map_err(Failure::Scratch)?;
            writer.file_plain(&name, &bytes)?;
            let _ = writeln!(text, "\n![{} of {}]({name})", stem, o.case.name);
        }
    }
    writer.file_plain("report.md", text.as_bytes())?;
    writer.commit()?;
    Ok(dir.join("report.md"))
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
