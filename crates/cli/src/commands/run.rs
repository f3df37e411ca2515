//! `granflow run`: everything from a case on the disk to its figures.

use super::init::Initial;
use super::{need_case, need_sound_mesh};
use crate::args::{self, Start};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::session::Session;
use crate::signals::Signals;
use crate::text::{count, duration, number, place, rounded, shown};
use granflow_case::store::{Stale, clean_stale};
use granflow_case::{Case, End, Event, From, Options, Run, StepEvent};
use granflow_mesh::check::check;
use std::path::Path;
use std::time::Instant;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &args::Run) -> Result<(), Failure> {
    let root = args.case.as_path();
    need_case(root)?;
    let signals = Signals::listen().map_err(Failure::Output)?;
    let mut options = Options {
        from: args.from.map(|from| match from {
            Start::Start => From::Start,
            Start::Latest => From::Latest,
            Start::Time(t) => From::Time(t),
        }),
        until: args.until,
        stop: signals.stop(),
        ..Options::default()
    };
    let initial = Initial::prepare(root, &session.sink)?;
    let loaded = Case::load(root, &options, &session.sink, &session.notices);
    if loaded.is_err() {
        initial.restate(root, &session.sink);
    }
    let case = loaded?;
    options.threads = args.threads.map_or_else(|| worthwhile(case.mesh.n_cells), usize::from);
    need_sound_mesh(&check(&case.poly))?;
    session.changed = true;
    let initialised = initial.keep();
    for stale in clean_stale(root)? {
        if let Stale::Restored(path) = stale {
            let path = shown(&path);
            session.notices.say(format!("{path} of an interrupted run was restored"));
        }
    }
    let mut run = Run::start(case, &options, &session.sink)?;
    session.speak_up();
    introduce(session, run.case(), initialised, options.threads);

    let begin = Instant::now();
    let mut tally = Tally::new(run.case());
    let mut progress = Progress::new(&session.out);
    let end = loop {
        match run.advance() {
            Ok(Event::Step(event)) => {
                tally.note(&event);
                progress.step(&mut session.out, &event);
            }
            Ok(Event::Done(end)) => break end,
            Err(e) => {
                progress.close();
                tally.say_where(session, root);
                return Err(e.into());
            }
        }
    };
    progress.close();
    if tally.steps == 0 && matches!(end, End::EndTime) {
        let (time, end) = (rounded(run.time(), 6), rounded(run.end_time(), 6));
        session.out.say(&format!(
            "nothing to compute: the start is at t {time} s, the end at {end} s (--until and --from \
             change them)"
        ));
    } else {
        tally.written(run.write_now()?);
    }
    tally.summary(session, run.time(), begin.elapsed().as_secs_f64());
    if let End::Stopped = end {
        // Written, which is what a person in a hurry wants; figures can be drawn later.
        tally.say_where(session, root);
        let signal = signals.received().unwrap_or(signal_hook::consts::SIGTERM);
        session.out.say("stopped by a signal: `granflow run --from latest` goes on from here");
        return Err(Failure::Signal(signal));
    }
    let figures = run.finish(&session.sink);
    tally.say_where(session, root);
    for file in figures? {
        session.out.say(&format!("figure   {}", shown(&file)));
    }
    Ok(())
}

/// As many threads as the mesh keeps busy: below some ten thousand cells each, waiting for one
/// another costs more than sharing the work gains.
fn worthwhile(cells: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (cells / 10_000).clamp(1, cores)
}

fn introduce(session: &mut Session, case: &Case, initialised: bool, threads: usize) {
    let made = match (case.mesh_made, initialised) {
        (true, true) => ", meshed from blockMeshDict, 0 made from 0.orig",
        (true, false) => ", meshed from blockMeshDict",
        (false, true) => ", 0 made from 0.orig",
        (false, false) => "",
    };
    let (cells, model) = (count(case.mesh.n_cells, "cell"), &case.config.transport.model);
    let (from, to) = (rounded(case.start.time, 6), rounded(case.end, 6));
    let threads = count(threads, "thread");
    session.out.say(&format!("{cells}, {model}, t {from} to {to} s, {threads}{made}"));
}

/// What the run has done so far.
struct Tally {
    steps: usize,
    unconverged: usize,
    began_at: f64,
    /// Time, length and relative change of velocity of the last full step.
    last: Option<(f64, f64, f64)>,
    written: Vec<String>,
}

impl Tally {
    fn new(case: &Case) -> Tally {
        Tally {
            steps: 0,
            unconverged: 0,
            began_at: case.start.time,
            last: None,
            written: Vec::new(),
        }
    }

    fn note(&mut self, event: &StepEvent) {
        let r = &event.report;
        self.steps += 1;
        self.unconverged += usize::from(!r.converged);
        // A short step, fitted to a write time, says little about a rate of change.
        if self.last.is_none_or(|(_, dt, _)| r.dt >= 0.5 * dt) {
            self.last = Some((r.time, r.dt, r.change));
        }
        if let Some(name) = &event.wrote {
            self.written(name.clone());
        }
    }

    /// A time directory holds results of this run.
    fn written(&mut self, name: String) {
        if self.steps > 0 && self.written.last() != Some(&name) {
            self.written.push(name);
        }
    }

    fn summary(&self, session: &mut Session, time: f64, wall: f64) {
        if self.steps == 0 {
            return;
        }
        let mut line = format!("t {} s after {}", rounded(time, 6), count(self.steps, "step"));
        line += &format!(", {} wall time", duration(wall));
        line += &format!(" ({} ms a step)", number(1e3 * wall / self.steps as f64));
        session.out.say(&line);
        if let Some(line) = self.steadiness() {
            session.out.say(&line);
        }
        if self.unconverged > 0 {
            session.out.say(&format!(
                "warning: {} of {} did not meet residualControl within nOuterCorrectors",
                self.unconverged,
                count(self.steps, "step"),
            ));
        }
    }

    /// How far the flow would still move if it went on at its last rate for as long as this run.
    fn steadiness(&self) -> Option<String> {
        let (time, dt, change) = self.last?;
        let span = time - self.began_at;
        let drift = change / dt * span;
        let (word, rate) = match drift {
            d if d <= STEADY => ("steady", number(d)),
            d => ("not steady", number(d)),
        };
        Some(format!(
            "{word}: in another {} s at its last rate U would change by {rate} of its maximum",
            rounded(span, 3)
        ))
    }

    fn say_where(&self, session: &mut Session, root: &Path) {
        let (Some(first), Some(last)) = (self.written.first(), self.written.last()) else { return };
        session.out.say(&match self.written.len() {
            1 => format!("results  {}", place(root, last)),
            n => format!("results  {} to {last} ({})", place(root, first), count(n, "time")),
        });
        if root.join("postProcessing").is_dir() {
            session.out.say(&format!("         {}", place(root, "postProcessing")));
        }
    }
}

/// Greatest drift that counts as steady.
const STEADY: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_is_a_matter_of_rate_not_of_the_length_of_a_step() {
        let tally = |dt: f64, change: f64| Tally {
            steps: 1,
            unconverged: 0,
            began_at: 0.0,
            last: Some((10.0, dt, change)),
            written: Vec::new(),
        };
        let says = |t: Tally| t.steadiness().unwrap();
        assert!(says(tally(1.0, 1e-6)).starts_with("steady: in another 10 s"));
        assert!(says(tally(1e-4, 1e-6)).starts_with("not steady"), "small steps change little");
    }
}
