//! The `granflow` command: the only room that prints and exits.
//!
//! [`main`] reads the arguments, runs one command of `commands` and turns its outcome into
//! messages and an exit code:
//!
//! | code | meaning |
//! |---|---|
//! | 0 | done |
//! | 2 | bad input, nothing was changed |
//! | 3 | the computation failed, the last good state is kept |
//! | 4 | the machine failed: disk full, no permission |
//! | 70 | a fault of granflow itself |
//! | 130, 143 | stopped by a signal, after writing |

pub mod args;
mod catalogue;
mod commands;
mod failure;
mod output;
mod progress;
mod session;
mod signals;
mod tally;
mod text;

pub use failure::Failure;

use std::process::ExitCode;

/// The whole program: arguments in, exit code out.
pub fn main() -> ExitCode {
    apologise_for_panics();
    let code = session::run(std::env::args_os());
    ExitCode::from(u8::try_from(code).unwrap_or(1))
}

/// Exit code when granflow itself is at fault (`EX_SOFTWARE` of sysexits).
const FAULT: i32 = 70;

/// No user should meet a panic; one who does is told that it is not their fault. Leaves at once:
/// other threads may wait for the one that panicked.
fn apologise_for_panics() {
    std::panic::set_hook(Box::new(|info| {
        let payload = info.payload();
        let what = payload
            .downcast_ref::<&str>()
            .copied()
            .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
            .unwrap_or("no message");
        let place = info.location().map(|l| format!(" at {}:{}", l.file(), l.line()));
        output::complain(&format!(
            "granflow {} has met a mistake of its own and had to stop, sorry: {what}{}\n\
             Written time directories are intact. Please report this message with the case.",
            env!("CARGO_PKG_VERSION"),
            place.unwrap_or_default(),
        ));
        std::process::exit(FAULT);
    }));
}
