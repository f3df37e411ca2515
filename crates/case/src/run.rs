//! A case that computes, writes and reports, one step at a time.

mod acting;
mod retry;

pub use retry::Shortened;

use crate::config::WriteControl;
use crate::functions::schedule::{Moment, passes};
use crate::jsonl::{Log, SolveRecord, StepRecord};
use crate::output::Tables;
use crate::store::{CaseLock, TimeName, clean_stale, list_times, purge};
use crate::superseded::{SetAside, set_aside};
use crate::worker::{Answer, Crew, Order, Sheets};
use crate::{Case, CaseError, Notices, Options, Tensile, figures, init, meshing, output};
use granflow_base::Stopwatch;
use granflow_dict::{Diag, Sink};
use granflow_flow::{Flow, Report, StepError};
use granflow_physics::rheology::Posedness;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Of a time step: less than that is rounding of the clock.
const SLIVER: f64 = 1e-6;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The end time was reached; its state is written.
    EndTime,
    /// A steady state was found, and its conditions stay the same until the end time; it is written.
    Steady,
    /// The stop flag was set; the state is written.
    Stopped,
}

/// What [`Run::advance`] did.
#[derive(Clone, Debug)]
pub enum Event {
    /// A time step.
    Step(Box<StepEvent>),
    /// Nothing: the run is over.
    Done(End),
}

/// A time step as a person follows it.
#[derive(Clone, Debug)]
pub struct StepEvent {
    /// What the flow reports.
    pub report: Report,
    /// Steps since time zero.
    pub step: usize,
    /// Longer steps that failed before it.
    pub shortened: Vec<Shortened>,
    /// Where grains are pulled apart: once in a run, when it first comes to such a state.
    pub tensile: Option<Tensile>,
    /// The time directory written at its end.
    pub wrote: Option<String>,
    /// Wall-clock time since the run began, s.
    pub wall: f64,
    /// Estimated wall-clock time to the end, s.
    pub left: Option<f64>,
    /// Share of the run's time that is done, 0 to 1.
    pub progress: f64,
}

/// A running case.
pub struct Run {
    case: Arc<Case>,
    crew: Crew,
    log: Log,
    tables: Tables,
    names: TimeName,
    stop: Arc<AtomicBool>,
    clock: Stopwatch,
    began: f64,
    /// Length of the next step before it is fitted to write times, s.
    dt: f64,
    /// Name and time of the last directory that holds the present run's state.
    last_written: (String, f64),
    n_written: usize,
    /// The step at whose end functions acted last, while its state is the present one.
    moment: Option<Moment>,
    /// Whether each function has made its fields in this run.
    executed: Vec<bool>,
    /// Held by runs that were loaded here.
    lock: Option<CaseLock>,
    set_aside: Option<SetAside>,
    /// Wall-clock seconds per second of the flow, averaged over the latest steps.
    pace: Option<f64>,
    /// Where the law was ill-posed in the last step.
    posedness: Posedness,
    /// Whether a steady state was found for all times to come.
    settled: bool,
}

impl Run {
    /// Loads the case, writes its mesh if that was made just now, and prepares the first step.
    ///
    /// # Errors
    /// As [`Case::load`], or the disk refuses.
    pub fn load(
        root: &Path,
        options: &Options,
        sink: &Sink,
        notices: &Notices,
    ) -> Result<Run, CaseError> {
        let lock = CaseLock::take(root)?;
        for stale in clean_stale(root)? {
            if let crate::store::Stale::Restored(path) = stale {
                notices.say(format!("{} of an interrupted run was restored", path.display()));
            }
        }
        // Only a case without any time starts from 0.orig.
        let timeless = list_times(root)?.is_empty() && root.join("0.orig").is_dir();
        if timeless && init::from_orig(root)? {
            notices.say("0.orig was copied to 0");
        }
        let case = Case::load(root, options, sink, notices)?;
        let mut run = Run::start(case, options, sink)?;
        run.lock = Some(lock);
        Ok(run)
    }

    /// Runs a case that was loaded; the caller holds its [`CaseLock`].
    ///
    /// # Errors
    /// The disk refuses; the mesh cannot be cut into so many ranks.
    pub fn start(case: Case, options: &Options, sink: &Sink) -> Result<Run, CaseError> {
        let control = &case.config.control;
        if case.mesh_made {
            meshing::write(&case.root, &case.poly, control.format, control.compression)?;
        }
        output::write_set_fields(&case)?;
        let case = Arc::new(case);
        let crew = Crew::new(case.clone(), options).map_err(|e| {
            let path = case.root.join(meshing::POLY_MESH).display().to_string();
            sink.push(Diag::file(path, e.to_string()));
            CaseError::Invalid
        })?;
        let control = &case.config.control;
        let began = case.start.time;
        let fresh = case.start.step == 0;
        let computes = case.end > began + 0.5 * control.dt;
        let set_aside = if computes { set_aside(&case.root, began, fresh)? } else { None };
        let mut log = if fresh { Log::create(&case.root)? } else { Log::append(&case.root)? };
        let event = json!({
            "time": began, "end": case.end, "cells": case.poly.n_cells(),
            "ranks": options.ranks, "threads": options.threads,
            "rheology": case.config.transport.model,
        });
        log.event("start", &object(event))?;
        let dt = match (control.adjust, case.start.dt) {
            (Some(_), Some(dt)) if !fresh => dt,
            _ => control.dt,
        };
        Ok(Run {
            tables: Tables::new(&case.root, &case.start.dir),
            names: control.time_name,
            stop: options.stop.clone(),
            clock: Stopwatch::start(),
            began,
            dt,
            last_written: (case.start.dir.clone(), began),
            n_written: 0,
            moment: None,
            executed: vec![false; case.config.functions.len()],
            lock: None,
            set_aside,
            pace: None,
            posedness: Posedness::default(),
            settled: false,
            crew,
            log,
            case,
        })
    }

    /// The case.
    pub fn case(&self) -> &Case {
        &self.case
    }
    /// The flow of this process' first rank.
    pub fn flow(&self) -> &Flow {
        self.crew.worker.flow()
    }
    /// The present time, s.
    pub fn time(&self) -> f64 {
        self.flow().state.time
    }
    /// What an earlier run had written behind the start of this one, which was set aside.
    pub fn set_aside(&self) -> Option<&SetAside> {
        self.set_aside.as_ref()
    }
    /// The time to reach, s.
    pub fn end_time(&self) -> f64 {
        self.case.end
    }

    /// Goes one time step further, with functions and writing; or says that the run is over.
    ///
    /// # Errors
    /// [`CaseError::Step`] when the computation failed: the state before the step was restored
    /// and written. [`CaseError::Store`] when the disk refuses.
    pub fn advance(&mut self) -> Result<Event, CaseError> {
        if self.stop.load(Ordering::Relaxed) {
            return self.stopped();
        }
        let (before, wall, dt_before) = (self.time(), self.clock.seconds(), self.dt);
        let dt = self.next_dt()?;
        // A step fitted to the end may be all that rounding of the clock has left of it.
        let left = self.case.end - before;
        if self.settled || left < 0.5 * dt || left < SLIVER * self.dt {
            return self.over();
        }
        let (report, dt, shortened) = match self.step(dt) {
            Ok(done) => done,
            // Whoever goes on from here takes this step again, by the same rule from the same length.
            Err(StepError::Interrupted { .. }) => {
                self.dt = dt_before;
                return self.stopped();
            }
            Err(e) => {
                self.dt = dt_before;
                return Err(self.failed(e));
            }
        };
        let (time, step) = (self.time(), self.flow().state.step);
        if report.steady {
            let answer = self.crew.worker.order(Order::Settled(dt));
            self.settled = matches!(answer, Ok(Answer::Number(1.0)));
        }
        let last = self.settled || time > self.case.end - 0.5 * dt;
        let write = last || self.write_due(before, time, step);
        self.crew.worker.time_name = self.name_of(time, dt);
        let moment =
            Moment { before, time, step, written: write.then_some(self.n_written + 1), last };
        self.moment = write.then_some(moment);
        self.functions(&moment)?;
        let seconds = self.clock.seconds();
        self.log_step(&report, step, seconds)?;
        self.posedness = report.rheology.posedness;
        let tensile = self.crew.worker.tensile.take();
        if let Some(t) = &tensile {
            let event = json!({
                "time": time, "message": "the pressure is not positive",
                "cells": t.cells, "cell": t.cell, "place": t.place, "pressure": t.pressure,
            });
            self.log.event("warning", &object(event))?;
        }
        let wrote = if write { Some(self.write_now()?) } else { None };
        let pace = (self.clock.seconds() - wall) / dt;
        let pace = self.pace.map_or(pace, |old| old + 0.2 * (pace - old));
        self.pace = Some(pace);
        let span = self.case.end - self.began;
        Ok(Event::Step(Box::new(StepEvent {
            report,
            step,
            shortened,
            tensile,
            wrote,
            wall: self.clock.seconds(),
            left: Some(if last { 0.0 } else { (pace * (self.case.end - time)).max(0.0) }),
            // Time that passed is rarely the span to the bit, nor the end a multiple of the step.
            progress: if last { 1.0 } else { ((time - self.began) / span).clamp(0.0, 1.0) },
        })))
    }

    /// Draws the figures of `system/plotDict`, if there is one, and returns the files made.
    ///
    /// # Errors
    /// The dictionary has mistakes (see the sink), or the disk refuses.
    pub fn finish(&mut self, sink: &Sink) -> Result<Vec<PathBuf>, CaseError> {
        figures::draw(&self.case.root, sink)
    }

    /// The length of the next step: the Courant number's, fitted to the next write time.
    fn next_dt(&mut self) -> Result<f64, CaseError> {
        let control = &self.case.config.control;
        let time = self.flow().state.time;
        if let Some(adjust) = control.adjust {
            // Over the greatest Courant number allowed.
            let rate = match self.crew.worker.order(Order::Courant) {
                Ok(Answer::Number(rate)) => rate,
                _ => 0.0,
            };
            let room = 1.0 / (rate * self.dt).max(1e-15);
            self.dt = (self.dt * room.min(1.0 + 0.1 * room).min(1.2)).min(adjust.max_dt);
        }
        let control = &self.case.config.control;
        let mut goal = None;
        if let WriteControl::Adjustable(interval) = control.write {
            goal = Some(next_multiple(time, interval, self.dt).min(self.case.end));
        } else if control.adjust.is_some() {
            goal = Some(self.case.end);
        }
        let Some(goal) = goal.filter(|g| *g > time) else { return Ok(self.dt) };
        let steps = ((goal - time) / self.dt - 1e-6).ceil().max(1.0);
        let fitted = (goal - time) / steps;
        // A step that fits as it is stays as it is, to the last bit.
        Ok(if (fitted - self.dt).abs() <= 1e-9 * self.dt { self.dt } else { fitted })
    }

    fn write_due(&self, before: f64, time: f64, step: usize) -> bool {
        match self.case.config.control.write {
            WriteControl::Steps(n) => step.is_multiple_of(n),
            WriteControl::Time(s) | WriteControl::Adjustable(s) => passes(before, time, s),
            WriteControl::Never => false,
        }
    }

    fn name_of(&mut self, time: f64, dt: f64) -> String {
        self.names.distinct(time, Some(self.last_written.1), dt)
    }

    /// Writes the present state and returns the name of its time directory.
    ///
    /// # Errors
    /// The disk refuses; what was there before is still there.
    pub fn write_now(&mut self) -> Result<String, CaseError> {
        if self.time() == self.last_written.1 {
            return Ok(self.last_written.0.clone());
        }
        let derived = self.crew.worker.order(Order::Derive).is_ok();
        let name = self.write_state(derived)?;
        // From here on the run is what a restart from this directory would be.
        let _ = self.crew.worker.order(Order::Renew);
        Ok(name)
    }

    fn write_state(&mut self, derived: bool) -> Result<String, CaseError> {
        let sheets: Box<Sheets> = match self.crew.worker.order(Order::Collect(derived)) {
            Ok(Answer::Collected(s)) => s,
            _ => Box::default(),
        };
        let s = &self.flow().state;
        let (time, step, dt_old) = (s.time, s.step, s.dt_old);
        let name = self.name_of(time, dt_old);
        let clock = crate::restart::Clock { time, step, dt: Some(self.dt), dt_old };
        let made = self.made_fields(derived);
        output::write_time(&self.case, &name, &clock, &sheets, &made)?;
        let control = &self.case.config.control;
        if control.purge > 0 {
            purge(&self.case.root, control.purge, &self.case.start.dir, &name)?;
        }
        self.last_written = (name.clone(), time);
        self.n_written += 1;
        self.log.event("write", &object(json!({"time": time, "directory": name})))?;
        Ok(name)
    }

    fn over(&mut self) -> Result<Event, CaseError> {
        if self.time() > self.began {
            self.write_now()?;
        }
        let (end, reason) = match self.settled {
            true => (End::Steady, "steady"),
            false => (End::EndTime, "endTime"),
        };
        self.log_end(reason)?;
        Ok(Event::Done(end))
    }

    fn stopped(&mut self) -> Result<Event, CaseError> {
        if self.time() > self.began {
            self.write_now()?;
        }
        self.log_end("stopped")?;
        Ok(Event::Done(End::Stopped))
    }

    fn log_end(&mut self, reason: &str) -> Result<(), CaseError> {
        let (time, p) = (self.time(), self.posedness);
        if p.ill_posed > 0 {
            let event = json!({
                "time": time, "message": "mu(I) is ill-posed",
                "cells": p.ill_posed, "yielded": p.yielded,
            });
            self.log.event("warning", &object(event))?;
        }
        Ok(self.log.event("end", &object(json!({"time": time, "reason": reason})))?)
    }

    /// Back to the last good state, which is written.
    fn failed(&mut self, source: StepError) -> CaseError {
        let _ = self.crew.worker.order(Order::Rollback);
        let event = json!({"time": self.time(), "message": source.to_string()});
        let logged = self.log.event("error", &object(event));
        let kept = if self.time() == self.last_written.1 {
            Some(self.last_written.0.clone())
        } else {
            self.write_state(false).ok()
        };
        // The failure of the step is what matters; a log that cannot be written changes nothing.
        let _ = logged;
        CaseError::Step { source, kept }
    }

    fn log_step(&mut self, r: &Report, step: usize, wall: f64) -> Result<(), CaseError> {
        let mut solves = Vec::with_capacity(3);
        let fields = [("U", &r.u), (self.case.config.pressure(), &r.p)];
        for (i, (field, pair)) in fields.into_iter().enumerate() {
            if let Some((first, last)) = pair {
                let (first, last) = (first.first, last.last);
                let (iterations, unconverged) = (r.iterations[i], r.solves[i].unconverged);
                solves.push(SolveRecord { field, iterations, first, last, unconverged });
            }
        }
        if r.rheology.solves > 0 {
            let g = &r.rheology;
            solves.push(SolveRecord {
                field: "fluidity",
                iterations: g.iterations,
                first: g.residual,
                last: g.residual,
                unconverged: g.unconverged,
            });
        }
        let residuals = [
            ("U", r.residuals.u),
            ("p", r.residuals.p),
            ("viscosity", r.residuals.viscosity),
            ("courant", r.courant[1]),
            ("change", r.change),
        ];
        Ok(self.log.step(&StepRecord {
            time: r.time,
            step: step as u64,
            dt: r.dt,
            outer: r.outer,
            residuals: &residuals,
            solves: &solves,
            wall,
        })?)
    }
}

/// The first multiple of `interval` behind `time`, not nearer than a millionth of a step.
fn next_multiple(time: f64, interval: f64, dt: f64) -> f64 {
    ((time + 1e-6 * dt) / interval).floor().mul_add(interval, interval)
}

fn object(v: Value) -> Map<String, Value> {
    match v {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}
