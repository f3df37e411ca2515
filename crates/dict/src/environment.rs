//! What `$NAME` stands for when no entry has that name: a variable of the environment, as in
//! OpenFOAM, and the few that its programs set for themselves.

use crate::files::Files;
use crate::tree::Value;

/// The language that is spoken here, for cases that ask for the version of OpenFOAM.
const LANGUAGE: [(&str, &str); 5] = [
    ("FOAM_API", "1912"),
    ("FOAM_APPLICATION", "granflow"),
    ("FOAM_EXECUTABLE", "granflow"),
    ("WM_PROJECT", "OpenFOAM"),
    ("WM_PROJECT_VERSION", "v1912"),
];

/// The value of the variable `name`, a number where it reads as one.
pub(crate) fn variable(files: &dyn Files, name: &str) -> Option<Value> {
    let root = files.case_root();
    let own = match name {
        "FOAM_CASE" if !root.is_empty() => Some(root),
        "FOAM_CASENAME" if !root.is_empty() => {
            Some(root.rsplit('/').next().unwrap_or_default().to_owned())
        }
        _ => None,
    };
    let default = || LANGUAGE.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
    let text = own.or_else(|| files.variable(name)).or_else(default)?;
    Some(match text.parse::<f64>() {
        Ok(x) if x.is_finite() => x.into(),
        _ => text.as_str().into(),
    })
}
