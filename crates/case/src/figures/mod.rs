//! Figures.
use crate::CaseError;
use granflow_dict::Sink;
use std::path::{Path, PathBuf};

/// Draws.
///
/// # Errors
/// None.
pub fn draw(_root: &Path, _sink: &Sink) -> Result<Vec<PathBuf>, CaseError> {
    Ok(Vec::new())
}
