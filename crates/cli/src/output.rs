//! Standard output and standard error, the way a command line program should treat them: a closed
//! pipe is the reader's choice and no error, colours are for terminals.

use std::io::{self, IsTerminal, Write};

/// Standard output with the user's wishes about it.
pub(crate) struct Output {
    quiet: bool,
    colour: bool,
    bar: bool,
    /// Nobody reads any more, or the device failed.
    closed: bool,
    failed: Option<io::Error>,
}

impl Output {
    /// The streams of this process.
    pub(crate) fn new(quiet: bool) -> Output {
        let (out, err) = (io::stdout().is_terminal(), io::stderr().is_terminal());
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        let no_colour = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        Output {
            quiet,
            colour: err && !dumb && !no_colour,
            bar: out && err && !dumb && !quiet,
            closed: false,
            failed: None,
        }
    }
    /// Whether diagnostics are coloured.
    pub(crate) fn colour(&self) -> bool {
        self.colour
    }
    /// Whether a line can be drawn over and over.
    pub(crate) fn bar(&self) -> bool {
        self.bar
    }
    /// Whether the user wants nothing but errors.
    pub(crate) fn quiet(&self) -> bool {
        self.quiet
    }
    /// A line that tells what happens; `--quiet` leaves it out.
    pub(crate) fn say(&mut self, line: &str) {
        if !self.quiet {
            self.print(line);
        }
    }
    /// A line that was asked for.
    pub(crate) fn print(&mut self, line: &str) {
        if self.closed {
            return;
        }
        let mut out = io::stdout().lock();
        let written = writeln!(out, "{line}").and_then(|()| out.flush());
        if let Err(e) = written {
            self.closed = true;
            if e.kind() != io::ErrorKind::BrokenPipe {
                self.failed = Some(e);
            }
        }
    }
    /// What went wrong with standard output, if anything did.
    pub(crate) fn failure(&mut self) -> Option<io::Error> {
        self.failed.take()
    }
}

/// A line on standard error; there is nowhere to complain when that fails.
pub(crate) fn complain(line: &str) {
    let mut err = io::stderr().lock();
    let _ = writeln!(err, "{line}");
}
