//! What can go wrong with a case, by who has to act.

use crate::plot::PlotError;
use crate::store::{LockError, StoreError};
use granflow_flow::StepError;
use std::path::PathBuf;

/// Why a case cannot be loaded, run or written.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// The input is wrong: the diagnostics are in the sink that was given.
    #[error("the case has mistakes")]
    Invalid,
    /// Another process changes the case at this moment.
    #[error("{}", LockError::Held { path: path.clone(), pid: *pid })]
    Busy {
        /// The locked file.
        path: PathBuf,
        /// The process, where it is known.
        pid: Option<u32>,
    },
    /// The disk refused.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The computation failed; the last good state was kept.
    #[error("{source}{}", kept.as_ref().map_or(String::new(), |t| format!("; the state before this step is in `{t}`")))]
    Step {
        /// What happened.
        source: StepError,
        /// Time directory of the last good state, when it could be written.
        kept: Option<String>,
    },
    /// A figure could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl CaseError {
    /// The exit code of the command: 2 bad input, 3 the computation failed, 4 the machine failed.
    pub fn exit_code(&self) -> i32 {
        match self {
            CaseError::Invalid | CaseError::Busy { .. } => 2,
            CaseError::Step { .. } | CaseError::Plot(_) => 3,
            CaseError::Store(e) if e.is_machine_failure() => 4,
            CaseError::Store(_) => 2,
        }
    }
}

impl From<LockError> for CaseError {
    fn from(e: LockError) -> Self {
        match e {
            LockError::Held { path, pid } => CaseError::Busy { path, pid },
            LockError::Store(e) => CaseError::Store(e),
        }
    }
}
