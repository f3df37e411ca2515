//! `granflow run`: everything from a case on the disk to its figures.

use super::init::Initial;
use super::{need_case, need_sound_mesh};
use crate::args::{self, Start};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::session::Session;
use crate::signals::Signals;
use crate::tally::{Tally, pulled_apart, taken_again};
use crate::text::{count, rounded, shown};
use granflow_case::store::{CaseLock, Stale, clean_stale};
use granflow_case::{Case, End, Event, From, Options, Run, SetAside};
use granflow_dict::Sink;
use granflow_mesh::check::check;
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
        share: args.share,
        stop: signals.stop(),
        ..Options::default()
    };
    let _lock = CaseLock::take(root)?;
    let initial = Initial::prepare(root)?;
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
    let mut progress = Progress::new(&session.out);
    options.watch = progress.watch(&session.out);
    let mut run = Run::start(case, &options, &session.sink)?;
    if let Some(old) = run.set_aside() {
        session.notices.say(set_aside(old));
    }
    session.speak_up();
    introduce(session, run.case(), initialised, options.threads);

    let begin = Instant::now();
    let mut tally = Tally::new(run.case());
    let end = loop {
        match run.advance() {
            Ok(Event::Step(event)) => {
                tally.note(&event);
                for s in &event.shortened {
                    progress.warn(&session.out, &taken_again(s));
                }
                if let Some(t) = &event.tensile {
                    progress.warn(&session.out, &pulled_apart(t, event.report.time));
                }
                progress.step(&mut session.out, &event);
            }
            Ok(Event::Done(end)) => break end,
            Err(e) => {
                progress.close();
                tally.say_where(session, root);
                // What was computed until then is worth a look; what keeps a figure from being drawn
                // is not what the run failed of.
                for file in run.finish(&Sink::new()).unwrap_or_default() {
                    session.out.say(&format!("figure   {}", shown(&file)));
                }
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
    tally.summary(session, run.case(), run.time(), begin.elapsed().as_secs_f64());
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

/// What to say of an earlier run's times.
fn set_aside(old: &SetAside) -> String {
    let (first, last) = (old.times.first(), old.times.last());
    let which = match (first, last, old.times.len()) {
        (Some(first), _, 1) => format!("the time {first} of an earlier run lies"),
        (Some(first), Some(last), n) => {
            format!("the {n} times {first} to {last} of an earlier run lie")
        }
        _ => String::new(),
    };
    let dir = shown(&old.dir);
    format!("{which} behind the start of this one: set aside in {dir}, to keep or to remove")
}
