//! Why a command did not do what it was asked, and the exit code of each reason.

use granflow_case::CaseError;
use granflow_case::store::{LockError, StoreError};
use std::io;

/// Why a command stopped.
#[derive(Debug)]
pub enum Failure {
    /// The case cannot be loaded, computed or written; mistakes are in the session's sink.
    Case(CaseError),
    /// The request itself makes no sense: what is wrong, and what to do instead.
    Refused {
        /// What is wrong.
        message: String,
        /// What to do.
        help: Option<String>,
    },
    /// A signal asked to stop: its number. The state was written.
    Signal(i32),
    /// Quantities that are not what they should be.
    Validation {
        /// How many.
        failed: usize,
        /// Of how many.
        of: usize,
    },
    /// There is no room for scratch files.
    Scratch(io::Error),
    /// Standard output cannot be written (a closed pipe is no failure).
    Output(io::Error),
}

impl Failure {
    /// A request that makes no sense.
    pub fn refused(message: impl Into<String>, help: impl Into<String>) -> Failure {
        Failure::Refused { message: message.into(), help: Some(help.into()) }
    }
    /// The exit code of the program.
    pub fn exit_code(&self) -> i32 {
        match self {
            Failure::Case(e) => e.exit_code(),
            Failure::Refused { .. } => 2,
            Failure::Signal(number) => 128 + number,
            Failure::Validation { .. } => 3,
            Failure::Output(_) | Failure::Scratch(_) => 4,
        }
    }
}

impl From<CaseError> for Failure {
    fn from(e: CaseError) -> Self {
        Failure::Case(e)
    }
}
impl From<StoreError> for Failure {
    fn from(e: StoreError) -> Self {
        Failure::Case(e.into())
    }
}
impl From<LockError> for Failure {
    fn from(e: LockError) -> Self {
        Failure::Case(e.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes_are_those_of_the_interface() {
        assert_eq!(Failure::from(CaseError::Invalid).exit_code(), 2);
        assert_eq!(Failure::refused("a", "b").exit_code(), 2);
        assert_eq!(Failure::Validation { failed: 1, of: 2 }.exit_code(), 3);
        assert_eq!(Failure::Signal(2).exit_code(), 130);
        assert_eq!(Failure::Signal(15).exit_code(), 143);
        assert_eq!(Failure::Output(io::Error::other("disk")).exit_code(), 4);
    }
}
