//! The granflow command.

use std::process::ExitCode;

fn main() -> ExitCode {
    granflow_cli::main()
}
