//! One call of the program: arguments, the command, then messages and the exit code.

use crate::args::{Args, Command};
use crate::commands;
use crate::failure::Failure;
use crate::output::{Output, complain};
use crate::text::count;
use clap::Parser;
use clap::error::ErrorKind;
use granflow_case::{CaseError, Notices};
use granflow_dict::{Diag, Diags, Severity, Sink};
use granflow_flow::StepError;
use std::ffi::OsString;

/// What every command works with.
pub(crate) struct Session {
    /// Standard output.
    pub(crate) out: Output,
    /// Mistakes found in the input.
    pub(crate) sink: Sink,
    /// Facts to say once.
    pub(crate) notices: Notices,
    /// Whether something was written already.
    pub(crate) changed: bool,
}

/// Runs the program; returns its exit code.
pub(crate) fn run(args: impl IntoIterator<Item = OsString>) -> i32 {
    let args = match Args::try_parse_from(args) {
        Ok(args) => args,
        Err(e) => {
            // Help and version end up here too; a closed pipe is no error.
            let _ = e.print();
            return match e.kind() {
                ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => 0,
                _ => 2,
            };
        }
    };
    let mut session = Session::new(args.quiet);
    let outcome = match &args.command {
        Command::Run(a) => commands::run::command(&mut session, a),
        Command::Mesh(a) => commands::mesh::command(&mut session, a),
        Command::Init(a) => commands::init::command(&mut session, a),
        Command::Check(a) => commands::check::command(&mut session, a),
        Command::New(a) => commands::new::command(&mut session, a),
        Command::List(a) => commands::list::command(&mut session, a),
        Command::Plot(a) => commands::plot::command(&mut session, a),
        Command::Export(a) => commands::export::command(&mut session, a),
        Command::Sweep(a) => commands::sweep::command(&mut session, a),
        Command::Fit(a) => commands::fit::command(&mut session, a),
        Command::Validate(a) => commands::validate::command(&mut session, a),
    };
    finish(session, outcome)
}

/// What to do when somebody else changes the case.
const BUSY_HELP: &str = "  = help: wait until it has ended, stop it (it writes its state first), or \
                         run a copy of the case";

/// What to do when grains are asked for more stress than they carry.
const BEYOND_HELP: &str = "  = help: lower the wall speed or the force that drives the flow, raise \
                           the pressure, or look at mu2; `granflow run --from latest` goes on";

/// What to do when a formula of a condition failed.
const CONDITION_HELP: &str = "  = help: mend the condition in this and in that directory, then `granflow run --from latest` goes on";

/// What to do when the computation failed.
const STEP_HELP: &str = "  = help: shorten deltaT (or write `adjustTimeStep yes; maxCo 0.5;`), look at \
                         the boundary conditions, then `granflow run --from latest` goes on";

impl Session {
    fn new(quiet: bool) -> Session {
        Session {
            out: Output::new(quiet),
            sink: Sink::new(),
            notices: Notices::new(),
            changed: false,
        }
    }

    /// Prints what was found so far that does not stop the command, and the facts to say once.
    pub(crate) fn speak_up(&mut self) {
        self.show(&self.sink.take());
        for notice in self.notices.take() {
            self.out.say(&format!("note: {notice}"));
        }
    }

    /// Prints what was found; errors alone if the user wants nothing else.
    fn show(&self, found: &Diags) {
        let wanted = |d: &&Diag| d.severity == Severity::Error || !self.out.quiet();
        let shown: Vec<Diag> = found.iter().filter(wanted).cloned().collect();
        if !shown.is_empty() {
            complain(&Diags(shown).render(self.out.colour()));
            complain("");
        }
    }
}

/// Says what is left to say and works out the exit code.
fn finish(mut session: Session, outcome: Result<(), Failure>) -> i32 {
    let outcome = outcome.and_then(|()| match session.out.failure() {
        Some(e) => Err(Failure::Output(e)),
        None => Ok(()),
    });
    let found = session.sink.take();
    session.show(&found);
    let (errors, warnings) = (found.n_errors(), found.n_warnings());
    match outcome {
        Ok(()) if errors == 0 => 0,
        Err(Failure::Case(CaseError::Invalid)) | Ok(()) => {
            let mut all = count(errors, "error");
            if warnings > 0 {
                all += &format!(", {}", count(warnings, "warning"));
            }
            let rest =
                if session.changed { "what was written stays" } else { "nothing was changed" };
            complain(&format!("{all}: {rest}"));
            2
        }
        Err(Failure::Refused { message, help }) => {
            complain(&format!("error: {message}"));
            if let Some(help) = help {
                complain(&format!("  = help: {help}"));
            }
            2
        }
        Err(failure) => {
            match &failure {
                Failure::Case(e) => {
                    complain(&format!("error: {e}"));
                    if let CaseError::Busy { .. } = e {
                        complain(BUSY_HELP);
                    }
                    if let CaseError::Step { source, .. } = e {
                        complain(match source {
                            StepError::Beyond { .. } => BEYOND_HELP,
                            StepError::Condition { .. } => CONDITION_HELP,
                            _ => STEP_HELP,
                        });
                    }
                }
                Failure::Validation { failed, of } => {
                    let of = count(*of, "check");
                    complain(&format!("error: {failed} of {of} did not come out as expected"));
                }
                Failure::Scratch(e) => complain(&format!("error: cannot use scratch files: {e}")),
                Failure::Output(e) => complain(&format!("error: cannot write the output: {e}")),
                Failure::Signal(_) | Failure::Refused { .. } => {}
            }
            failure.exit_code()
        }
    }
}
