//! One case at many values of its entries: `granflow sweep` walks a parameter, `granflow fit` finds parameters from
//! measured profiles.
//!
//! Every point is a case of its own, a copy with some entries changed, so that it can be looked at, drawn and run
//! again like any other.

mod edit;
pub mod fit;
mod least_squares;
mod point;
mod setting;
pub mod sweep;
mod sweep_table;

pub use edit::{EditError, set_entry};
pub use point::{Point, Solution};
pub use setting::{Quantity, Setting};

use crate::store::{CaseLock, Operation, StoreError};
use crate::{CaseError, SUPERSEDED};
use std::path::{Path, PathBuf};

/// Locks the case for a study and puts what an earlier one left in `name` aside, to `superseded/name_N`; says where.
fn begin(case: &Path, name: &str) -> Result<(CaseLock, Option<PathBuf>), CaseError> {
    let lock = CaseLock::take(case)?;
    let old = case.join(name);
    if !old.exists() {
        return Ok((lock, None));
    }
    let shelf = case.join(SUPERSEDED);
    let fail = |e| StoreError::new(Operation::Write, shelf.clone(), e);
    std::fs::create_dir_all(&shelf).map_err(fail)?;
    let free = (1..).map(|n| shelf.join(format!("{name}_{n}"))).find(|p| !p.exists());
    let to = free.unwrap_or_else(|| shelf.join(name));
    std::fs::rename(&old, &to).map_err(fail)?;
    Ok((lock, Some(to)))
}
