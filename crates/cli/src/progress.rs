//! How a run shows itself: one line on a terminal, drawn over and over; else a plain line now and
//! then that a person can read in a file.

use crate::output::{Output, complain};
use crate::text::{count, duration, number, residual, rounded};
use granflow_case::StepEvent;
use granflow_flow::{Report, Residuals, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::Write as _;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Least time between two plain lines.
const PLAIN: Duration = Duration::from_secs(2);
/// Least time between two drawings of the bar.
const DRAWN: Duration = Duration::from_millis(100);
/// The same within a step.
const LONG: Duration = Duration::from_secs(5);
const LONG_DRAWN: Duration = Duration::from_millis(500);
/// Parts of the bar.
const PARTS: u64 = 1000;

/// The line of a running case.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    last: Option<Instant>,
}

impl Progress {
    /// A bar where a terminal can show it.
    pub(crate) fn new(out: &Output) -> Progress {
        let bar = out.bar().then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(10);
            let bar = ProgressBar::with_draw_target(Some(PARTS), target);
            let template = if out.colour() {
                "{bar:10.cyan/blue} {percent:>3} %  {wide_msg}"
            } else {
                "{bar:10} {percent:>3} %  {wide_msg}"
            };
            let style = ProgressStyle::with_template(template)
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .progress_chars("=> ");
            bar.set_style(style);
            bar
        });
        Progress { bar, last: None }
    }

    /// Shows the passes of a step that takes long.
    pub(crate) fn watch(&self, out: &Output) -> Option<Watch> {
        if out.quiet() {
            return None;
        }
        let (bar, last) = (self.bar.clone(), Mutex::new(Instant::now()));
        Some(Watch(Arc::new(move |pass, now| {
            let Ok(mut last) = last.lock() else { return };
            if pass == 0 {
                *last = Instant::now();
            }
            let least = if bar.is_some() { LONG_DRAWN } else { LONG };
            if last.elapsed() < least {
                return;
            }
            *last = Instant::now();
            let line = passing(pass, now);
            match &bar {
                Some(bar) => bar.set_message(line),
                // A closed pipe is the reader's choice.
                None => drop(writeln!(std::io::stdout().lock(), "       {line}")),
            }
        })))
    }

    /// Shows a step.
    pub(crate) fn step(&mut self, out: &mut Output, event: &StepEvent) {
        if out.quiet() {
            return;
        }
        let since = self.last.map_or(Duration::MAX, |t| t.elapsed());
        if let Some(bar) = &self.bar {
            if since >= DRAWN || event.wrote.is_some() {
                self.last = Some(Instant::now());
                bar.set_position((event.progress.clamp(0.0, 1.0) * PARTS as f64) as u64);
                bar.set_message(status(event.step, &event.report, event.left));
            }
        } else if since >= PLAIN {
            self.last = Some(Instant::now());
            let percent = (100.0 * event.progress.clamp(0.0, 1.0)).floor();
            let line = status(event.step, &event.report, event.left);
            let wrote = event.wrote.as_ref().map_or(String::new(), |t| format!("  wrote {t}"));
            out.print(&format!("{percent:>3} %  {line}{wrote}"));
        } else if let Some(time) = &event.wrote {
            // Not a whole line for each when results are written many times a second.
            self.last = Some(Instant::now());
            let line = status(event.step, &event.report, None);
            out.print(&format!("{:>3} %  {line}  wrote {time}", (100.0 * event.progress).floor()));
        }
    }

    /// A warning among the lines.
    pub(crate) fn warn(&self, out: &Output, text: &str) {
        if out.quiet() {
            return;
        }
        match &self.bar {
            Some(bar) => bar.suspend(|| complain(text)),
            None => complain(text),
        }
    }

    /// Takes the bar away.
    pub(crate) fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// `t 1.25 s  left 12 s  step 1250  U 2.1e-9  p 3.4e-10  visc 8.0e-9  outer 3  Co 0.12`, and how
/// many linear solves of the step ran out of iterations, if any did.
///
/// U and p are the residuals of momentum and continuity. Of a single outer iteration (PISO) the
/// relative change of velocity in the step says more: how far the flow is from steady.
pub(crate) fn status(step: usize, r: &Report, left: Option<f64>) -> String {
    let mut parts = vec![format!("t {} s", rounded(r.time, 5))];
    // Early in the line: a narrow terminal cuts the end off.
    parts.extend(left.map(|left| format!("left {}", duration(left))));
    parts.push(format!("step {step}"));
    for (name, value) in [("U", r.residuals.u), ("p", r.residuals.p)] {
        parts.push(format!("{name} {}", residual(value)));
    }
    if r.residuals.viscosity > 0.0 {
        parts.push(format!("visc {}", residual(r.residuals.viscosity)));
    }
    parts.push(match (r.outer, r.converged) {
        (..=1, true) => format!("change {}", residual(r.change)),
        (_, true) => format!("outer {}", r.outer),
        (_, false) => format!("outer {} (not converged)", r.outer),
    });
    if !r.steady {
        parts.push(format!("Co {}", number(r.courant[1])));
    }
    // Inside outer iterations they do no harm if the step converged.
    let judged = !(r.coupled && r.converged);
    let solves = if judged { &r.solves[..] } else { &[] };
    let unconverged = solves.iter().map(|s| s.unconverged).sum::<usize>();
    if unconverged + r.rheology.unconverged > 0 {
        let solves = count(unconverged + r.rheology.unconverged, "solve");
        parts.push(format!("{solves} unconverged"));
    }
    parts.join("  ")
}

/// `pass 12  U 2.1e-3  p 3.4e-5  visc 8.0e-2`.
fn passing(pass: usize, now: &Residuals) -> String {
    let (u, p, viscosity) = (residual(now.u), residual(now.p), residual(now.viscosity));
    format!("pass {pass}  U {u}  p {p}  visc {viscosity}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_is_told_in_a_line() {
        let now = Residuals { u: 2.12e-3, p: 0.0, viscosity: 0.0812 };
        assert_eq!(passing(12, &now), "pass 12  U 2.1e-3  p 0  visc 8.1e-2");
    }
    use granflow_flow::SolveCount;

    #[test]
    fn the_line_is_readable() {
        let mut r = Report {
            time: 1.25,
            outer: 3,
            converged: true,
            residuals: Residuals { u: 2.12e-9, p: 3.4e-10, viscosity: 8e-9 },
            courant: [0.01, 0.1234],
            ..Report::default()
        };
        assert_eq!(
            status(1250, &r, Some(72.0)),
            "t 1.25 s  left 1 min 12 s  step 1250  U 2.1e-9  p 3.4e-10  visc 8.0e-9  outer 3  \
             Co 0.123"
        );
        r.converged = false;
        r.residuals.viscosity = 0.0;
        assert_eq!(
            status(7, &r, None),
            "t 1.25 s  step 7  U 2.1e-9  p 3.4e-10  outer 3 (not converged)  Co 0.123"
        );
        (r.outer, r.converged, r.change) = (1, true, 0.0123);
        assert_eq!(
            status(7, &r, None),
            "t 1.25 s  step 7  U 2.1e-9  p 3.4e-10  change 1.2e-2  Co 0.123"
        );
        r.solves[1] = SolveCount { all: 9, unconverged: 2 };
        assert!(status(7, &r, None).ends_with("Co 0.123  2 solves unconverged"));
    }
}
