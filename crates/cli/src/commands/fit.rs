//! `granflow fit`: the parameters behind measured profiles.

use super::{need_case, set_aside};
use crate::args::Study;
use crate::failure::Failure;
use crate::session::Session;
use crate::signals::Signals;
use crate::text::{count, duration, number, rounded, shown};
use granflow_case::Options;
use granflow_case::study::fit::{Fit, FitError, Outcome};
use std::time::Instant;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &Study) -> Result<(), Failure> {
    need_case(&args.case)?;
    let signals = Signals::listen().map_err(Failure::Output)?;
    let file = args.dict.as_deref().unwrap_or("system/fitDict");
    let fit = Fit::read(&args.case, file, &session.sink)?;
    let options = Options { threads: args.threads(), stop: signals.stop(), ..Options::default() };
    session.changed = true;
    let begin = Instant::now();
    let out = &mut session.out;
    let found = fit.run(&args.case, &options, &session.sink, &mut |step, at, sum| {
        let each = fit.parameters.iter().zip(at);
        let each: Vec<String> =
            each.map(|(p, x)| format!("{} {}", p.name, rounded(*x, 6))).collect();
        out.print(&format!("step {step}  chi2 {}  {}", number(sum), each.join("  ")));
    });
    let outcome = match found {
        Ok(outcome) => outcome,
        Err(FitError::Case(e)) => return Err(e.into()),
        Err(FitError::NoStart(why)) => {
            let help = "give a `start` of the parameters for which `granflow run` finds one";
            return Err(Failure::refused(
                format!("the case has no solution at the start: {why}"),
                help,
            ));
        }
        Err(FitError::NoData(why)) => {
            let help = "look at `file`, `modelX` and `modelY` of the data, and at the range that the case writes";
            return Err(Failure::refused(format!("nothing to compare with: {why}"), help));
        }
        Err(FitError::Stopped) => {
            let signal = signals.received().unwrap_or(signal_hook::consts::SIGTERM);
            return Err(Failure::Signal(signal));
        }
    };
    session.speak_up();
    set_aside(session, outcome.set_aside.as_deref());
    for text in told(&fit, &outcome, begin.elapsed().as_secs_f64()) {
        session.out.say(&text);
    }
    for file in &outcome.files {
        let what = if file.extension().is_some_and(|e| e == "csv") { "table " } else { "figure" };
        session.out.say(&format!("{what}   {}", shown(file)));
    }
    Ok(())
}

fn told(fit: &Fit, o: &Outcome, seconds: f64) -> Vec<String> {
    let percent = 100.0 * fit.confidence;
    let mut lines = vec![format!(
        "{} of the case in {} of wall time",
        count(o.points, "solution"),
        duration(seconds)
    )];
    for p in &o.parameters {
        let half = p.half.map_or("the data do not tell it".into(), |h| {
            format!("+- {} ({percent} %)", number(h))
        });
        let bound = if p.at_bound { ", at the end of its range" } else { "" };
        lines.push(format!("{:<10} {} {half}{bound}", p.name, rounded(p.value, 6)));
    }
    let per = o.chi2 / o.freedom as f64;
    lines.push(if o.errors_known {
        format!(
            "chi2 {} for {} degrees of freedom ({} each; about 1 is as good as the data)",
            number(o.chi2),
            o.freedom,
            number(per)
        )
    } else {
        format!(
            "what is left: {} (root mean square); errors of the data are taken to be that",
            number(per.sqrt())
        )
    });
    if let Some(c) = &o.correlation {
        for (i, row) in c.iter().enumerate() {
            for (j, r) in row.iter().enumerate().take(i).filter(|(_, r)| r.abs() > ALIKE) {
                lines.push(format!(
                    "warning: {} and {} are told apart badly (correlation {})",
                    fit.parameters[i].name,
                    fit.parameters[j].name,
                    rounded(*r, 3)
                ));
            }
        }
    }
    if !o.converged {
        lines.push("warning: the search did not come to its end".into());
    }
    lines
}

/// Correlation from which on two parameters can hardly be told apart.
const ALIKE: f64 = 0.95;
