//! `granflow sweep`: a case at many values of one parameter.

use super::{need_case, set_aside};
use crate::args::Study;
use crate::failure::Failure;
use crate::session::Session;
use crate::signals::Signals;
use crate::text::{count, duration, rounded, shown};
use granflow_case::Options;
use granflow_case::study::sweep::{Row, Sweep};
use std::time::Instant;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Study) -> Result<(), Failure> {
    need_case(&args.case)?;
    let signals = Signals::listen().map_err(Failure::Output)?;
    let file = args.dict.as_deref().unwrap_or("system/sweepDict");
    let sweep = Sweep::read(&args.case, file, &session.sink)?;
    let options = Options { threads: args.threads(), stop: signals.stop(), ..Options::default() };
    session.changed = true;
    let mut words: Vec<String> = sweep.family.iter().map(|f| f.parameter.clone()).collect();
    words.push(sweep.parameter.clone());
    words.extend(sweep.results.iter().map(|r| r.name.clone()));
    words.extend(["passes".into(), "end".into()]);
    session.out.say(&line(&words));
    let begin = Instant::now();
    let (out, mut points, mut why) = (&mut session.out, 0, None);
    let outcome = sweep.run(&args.case, &options, &session.sink, &mut |row: &Row| {
        points += 1;
        out.print(&line(&told(row)));
        let missing = row.results.iter().find_map(|r| r.as_ref().err());
        if let Some(e) = row.solution.failure.as_ref().or(missing.filter(|_| row.solution.found()))
        {
            why = Some((row.x, e.clone()));
        }
    })?;
    session.speak_up();
    set_aside(session, outcome.set_aside.as_deref());
    session.out.say(&format!(
        "{} in {} of wall time",
        count(points, "point"),
        duration(begin.elapsed().as_secs_f64())
    ));
    if let Some((x, why)) = why {
        session.out.say(&format!("{} {}: {why}", sweep.parameter, rounded(x, 6)));
    }
    for ends in &outcome.limits {
        let family = sweep.family.as_ref().zip(ends.y);
        let of =
            family.map_or(String::new(), |(f, y)| format!("{} {}: ", f.parameter, rounded(y, 6)));
        session.out.say(&format!(
            "{of}the flow ends between {} {} and {}",
            sweep.parameter,
            rounded(ends.flows, 6),
            rounded(ends.stands, 6)
        ));
    }
    for file in &outcome.files {
        let what = if file.extension().is_some_and(|e| e == "csv") { "table " } else { "figure" };
        session.out.say(&format!("{what}   {}", shown(file)));
    }
    match signals.received() {
        Some(signal) if outcome.stopped => Err(Failure::Signal(signal)),
        _ => Ok(()),
    }
}

fn told(row: &Row) -> Vec<String> {
    let mut words: Vec<String> = row.y.iter().map(|y| rounded(*y, 6)).collect();
    words.push(rounded(row.x, 6));
    words.extend(row.results.iter().map(|r| r.as_ref().map_or("-".into(), |v| rounded(*v, 6))));
    words.push(row.solution.passes.to_string());
    let s = &row.solution;
    words.push(match (s.found(), s.steady, s.failure.is_some()) {
        (true, true, _) => "steady".into(),
        (true, false, _) => "end time".into(),
        (.., true) => "no solution".into(),
        _ => "not converged".into(),
    });
    words
}

/// Columns that line up.
fn line(words: &[String]) -> String {
    let cells: Vec<String> = words.iter().map(|w| format!("{w:<14}")).collect();
    cells.join(" ").trim_end().to_owned()
}
