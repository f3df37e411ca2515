//! One point: a copy of the case with its entries set, run to its end.

use super::{EditError, Setting, set_entry};
use crate::restart::WholeState;
use crate::store::{CaseLock, DirWriter, Operation, StoreError, list_times};
use crate::{Case, CaseError, End, Event, Notices, Options, Run, init};
use granflow_dict::{Diags, Severity, Sink};
use std::path::{Path, PathBuf};

/// A copy of a case.
#[derive(Clone, Debug)]
pub struct Point {
    /// Its directory.
    pub root: PathBuf,
}

/// How a point came out.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// Whether all its steps converged.
    pub converged: bool,
    /// Whether its end is a steady state that was found without marching.
    pub steady: bool,
    /// Outer passes, all steps together.
    pub passes: usize,
    /// Steps taken.
    pub steps: usize,
    /// Why there is none.
    pub failure: Option<String>,
    /// The mistakes, where the case with these entries has some.
    pub mistakes: Option<Diags>,
    /// Whether the program was asked to stop.
    pub stopped: bool,
}

impl Solution {
    /// Whether there is one.
    pub fn found(&self) -> bool {
        self.failure.is_none() && self.converged && self.steps > 0 && !self.stopped
    }
}

impl Point {
    /// Copies the case `from` to `root`, which is made anew: dictionaries, mesh and first fields (`0.orig` where there
    /// are both).
    ///
    /// # Errors
    /// The disk refuses.
    pub fn copy(from: &Path, root: &Path) -> Result<Point, StoreError> {
        let mut writer = DirWriter::begin(root)?;
        let fields = if from.join("0.orig").is_dir() { "0.orig" } else { "0" };
        for part in ["system", "constant", "reference", fields] {
            let there = from.join(part);
            if there.is_dir() {
                init::copy_tree(&there, Path::new(part), &mut writer)?;
            }
        }
        writer.commit()?;
        Ok(Point { root: root.to_owned() })
    }

    /// Sets the entries for the parameter's value `x`, and `y` of its family.
    ///
    /// # Errors
    /// [`EditError`].
    pub fn set(&self, settings: &[Setting], x: f64, y: Option<f64>) -> Result<(), EditError> {
        for s in settings {
            let text = s.text(x, y).map_err(|_| EditError::NoEntry {
                file: s.file.clone(),
                entry: s.entry.clone(),
                why: "nowhere: its value cannot be evaluated",
            })?;
            let mesh = self.root.join("constant/polyMesh");
            if s.file == "system/blockMeshDict" && mesh.is_dir() {
                // What was made of it is out of date.
                std::fs::remove_dir_all(&mesh)
                    .map_err(|e| StoreError::new(Operation::Write, mesh.clone(), e))?;
            }
            set_entry(&self.root, &s.file, &s.entry, &text)?;
        }
        Ok(())
    }

    /// Runs it, from the fields that the point `from` ended with, where they are of a mesh of the same size.
    /// A computation that fails is a [`Solution`] without one, and so is a case with mistakes; what else is to be said
    /// of it goes to the sink.
    ///
    /// # Errors
    /// The machine failed.
    pub fn run(
        &self,
        from: Option<&Point>,
        options: &Options,
        sink: &Sink,
    ) -> Result<Solution, CaseError> {
        let _lock = CaseLock::take(&self.root)?;
        init::from_orig(&self.root)?;
        let own = Sink::new();
        let begun = Case::load(&self.root, options, &own, &Notices::new()).and_then(|mut case| {
            if let Some(from) = from {
                from.hand_over(&mut case)?;
            }
            Run::start(case, options, &own)
        });
        let mut run = match begun {
            Ok(run) => run,
            Err(CaseError::Invalid) => {
                let said = own.take();
                let failure = said.iter().find(|d| d.severity == Severity::Error);
                return Ok(Solution {
                    failure: Some(failure.map_or(String::new(), |d| d.message.clone())),
                    mistakes: Some(said),
                    ..Solution::default()
                });
            }
            Err(e) => return Err(e),
        };
        sink.extend(own.take().0);
        let mut out = Solution { converged: true, ..Solution::default() };
        loop {
            match run.advance() {
                Ok(Event::Step(event)) => {
                    out.steps += 1;
                    out.converged &= event.report.converged;
                    out.steady = event.report.steady;
                    out.passes += event.report.outer;
                }
                Ok(Event::Done(end)) => {
                    out.stopped = end == End::Stopped;
                    break;
                }
                Err(CaseError::Step { source, .. }) => {
                    out.converged = false;
                    out.failure = Some(source.to_string());
                    break;
                }
                Err(e) => return Err(e),
            }
        }
        Ok(out)
    }

    /// Gives `case` the fields of the last time of this one as a first guess.
    fn hand_over(&self, case: &mut Case) -> Result<(), CaseError> {
        let Some((_, dir)) = list_times(&self.root)?.pop() else { return Ok(()) };
        let Some(dir) = dir.file_name().and_then(|d| d.to_str()) else { return Ok(()) };
        let state =
            WholeState::read(&self.root, dir, (&case.config, case.end), &case.poly, &Sink::new());
        let Ok(Some(state)) = state else { return Ok(()) };
        let start = &mut case.start;
        if state.u.cells.len() != start.u.cells.len() {
            return Ok(());
        }
        start.u.cells = state.u.cells;
        start.p.cells = state.p.cells;
        if state.has_fluidity {
            start.fluidity.cells = state.fluidity.cells;
            start.has_fluidity = true;
        }
        Ok(())
    }
}
