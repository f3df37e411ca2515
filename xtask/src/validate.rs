//! The catalogue of cases at full resolution: a word to `granflow validate`, which does the work.

use crate::run;
use std::process::Command;

pub(crate) fn task(names: &[String]) -> Result<bool, String> {
    let granflow = run::build_granflow("release")?;
    let mut command = Command::new(&granflow);
    command.args(["validate", "-o", "target/validation"]).args(names).current_dir(run::root());
    command.status().map(|s| s.success()).map_err(|e| format!("granflow validate: {e}"))
}
