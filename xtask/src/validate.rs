//! The catalogue of cases at full resolution: a word to `granflow validate`, which does the work.

use crate::run;
use std::process::Command;

pub(crate) fn task(names: &[String]) -> Result<bool, String> {
    let granflow = run::build_granflow("release")?;
    let help = Command::new(&granflow).args(["validate", "--help"]).output();
    if !help.is_ok_and(|h| h.status.success()) {
        return Err("this granflow has no `validate` command yet; until it has, run a case with \
                    `granflow run cases/NAME` and compare its postProcessing with the reference \
                    beside it (cases/NAME/README.md says which)"
            .into());
    }
    let mut command = Command::new(&granflow);
    command.arg("validate").args(names).current_dir(run::root());
    command.status().map(|s| s.success()).map_err(|e| format!("granflow validate: {e}"))
}
