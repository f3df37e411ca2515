//! When a function acts: `writeControl`, `writeInterval`, `timeStart`, `timeEnd`, and the same for
//! `execute`.

use granflow_base::Dims;
use granflow_dict::Reader;

/// How often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Every {
    /// So many steps.
    Steps(usize),
    /// So many seconds.
    Seconds(f64),
    /// So many written times.
    Writes(usize),
    /// The end of the run only.
    End,
    /// Never.
    Never,
}

impl Every {
    /// Reads what stands under `control` and `interval`, if either does.
    fn read(r: &Reader<'_>, control: &str, interval: &str) -> Option<Every> {
        let kinds = [
            ("timeStep", 0),
            ("writeTime", 1),
            ("outputTime", 1),
            ("runTime", 2),
            ("adjustableRunTime", 2),
            ("adjustable", 2),
            ("onEnd", 3),
            ("none", 4),
        ];
        if !r.has(control) && !r.has(interval) {
            return None;
        }
        Some(match r.opt_one_of(control, &kinds, 0) {
            0 => Every::Steps(r.opt_label_in(interval, 1..=i64::MAX, 1) as usize),
            1 => Every::Writes(r.opt_label_in(interval, 1..=i64::MAX, 1) as usize),
            2 => Every::Seconds(r.positive(interval, Dims::TIME)),
            kind => {
                r.ignore(interval);
                if kind == 3 { Every::End } else { Every::Never }
            }
        })
    }
}

/// When a function acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// How often.
    pub every: Every,
    /// Not before this time, s.
    pub from: f64,
    /// Not after this time, s.
    pub to: f64,
}

/// What just happened.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time before the step, s.
    pub before: f64,
    /// Time now, s.
    pub time: f64,
    /// Steps since time zero.
    pub step: usize,
    /// Times written by this run so far, when one is about to be written.
    pub written: Option<usize>,
    /// Whether the run ends here.
    pub last: bool,
}

/// Whether a multiple of `interval` lies in `(before, now]`, with half a step's grace.
pub(crate) fn passes(before: f64, now: f64, interval: f64) -> bool {
    let grace = 0.5 * (now - before);
    ((now + grace) / interval).floor() > ((before + grace) / interval).floor()
}

impl Schedule {
    /// The whole run.
    pub const fn always(every: Every) -> Schedule {
        Schedule { every, from: f64::NEG_INFINITY, to: f64::INFINITY }
    }

    /// Reads the entries, `default` where there are none.
    pub fn read(r: &Reader<'_>, default: Schedule) -> Schedule {
        // The older name comes first in no file: both are never there together.
        let old = r.has("outputControl") && !r.has("writeControl");
        let (control, interval) = if old {
            ("outputControl", "outputInterval")
        } else {
            ("writeControl", "writeInterval")
        };
        Schedule {
            every: Every::read(r, control, interval).unwrap_or(default.every),
            from: r.opt_scalar("timeStart", Dims::TIME, default.from),
            to: r.opt_scalar("timeEnd", Dims::TIME, default.to),
        }
    }

    /// Reads `executeControl` and `executeInterval`, if they are there; its times are those of `write`.
    pub fn read_execute(r: &Reader<'_>, write: Schedule) -> Option<Schedule> {
        let every = Every::read(r, "executeControl", "executeInterval")?;
        Some(Schedule { every, ..write })
    }

    /// Whether a time that is written now holds the fields of the function: those of functions that act
    /// at other moments are written with every time.
    pub(crate) fn with_times(&self, m: &Moment) -> bool {
        match self.every {
            Every::Writes(_) | Every::End => self.due(m),
            Every::Steps(_) | Every::Seconds(_) => m.time >= self.from && m.time <= self.to,
            Every::Never => false,
        }
    }

    /// Whether to act now.
    pub fn due(&self, m: &Moment) -> bool {
        if m.time < self.from || m.time > self.to {
            return false;
        }
        match self.every {
            Every::Steps(n) => m.step.is_multiple_of(n),
            Every::Seconds(s) => passes(m.before, m.time, s),
            Every::Writes(n) => m.written.is_some_and(|w| w.is_multiple_of(n)),
            Every::End => m.last,
            Every::Never => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_of_times_neither_skips_nor_doubles() {
        let (mut t, mut hits) = (0.0, 0);
        for _ in 0..1000 {
            let before = t;
            t += 0.1;
            hits += usize::from(passes(before, t, 0.3));
        }
        assert_eq!(hits, 333);
    }
}
