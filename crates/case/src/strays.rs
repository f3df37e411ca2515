//! Files of a case that nothing reads, and names that are likely misspelt.

use crate::store::{Operation, StoreError};
use crate::{CaseConfig, files};
use granflow_dict::{Diag, Severity, Sink};
use std::io;
use std::path::Path;

const SYSTEM: &[&str] = &[
    "controlDict",
    "fvSchemes",
    "fvSolution",
    "blockMeshDict",
    "setFieldsDict",
    "setAlphaFieldDict",
    "topoSetDict",
    "fvOptions",
    "plotDict",
    "sweepDict",
    "fitDict",
    // Of mapFields and of runs in parts, which are mentioned or need none here.
    "mapFieldsDict",
    "decomposeParDict",
];
const CONSTANT: &[&str] = &[
    "transportProperties",
    "physicalProperties",
    "g",
    "hRef",
    "waveProperties",
    "fvOptions",
    "turbulenceProperties",
    "momentumTransport",
    "RASProperties",
    "LESProperties",
    "dynamicMeshDict",
    "fvOptions",
    "fvModels",
    "fvConstraints",
    "MRFProperties",
    "SRFProperties",
];

/// Files of `system`, `constant` and the start time that nothing reads, as paths in the case.
///
/// # Errors
/// A directory cannot be read.
pub fn unread(root: &Path, time: &str, config: &CaseConfig) -> Result<Vec<String>, StoreError> {
    let (mut out, mut includes) = (Vec::new(), String::new());
    for (folder, known) in places(time, config) {
        for name in names(root, &folder)? {
            let path = format!("{folder}/{name}");
            includes += &include_lines(root, &path)?;
            // A field that setFields or a script makes another of.
            let stem = name.trim_end_matches(".orig");
            if !known.iter().any(|k| k == stem) {
                out.push((path, name));
            }
        }
    }
    out.retain(|(_, name)| !includes.contains(name.as_str()));
    Ok(out.into_iter().map(|(path, _)| path).collect())
}

/// The lines of a file that include others.
fn include_lines(root: &Path, path: &str) -> Result<String, StoreError> {
    let Some(src) = files::source(root, path)? else { return Ok(String::new()) };
    // They stand before or between values, not among a field's numbers.
    const HEAD: usize = 100_000;
    let text = String::from_utf8_lossy(&src.text[..src.text.len().min(HEAD)]);
    Ok(text.lines().filter(|l| l.contains("#include") || l.contains("#sinclude")).collect())
}

/// Warns of unread files whose name is nearly that of one that is missing.
///
/// # Errors
/// A directory cannot be read.
pub(crate) fn check(
    root: &Path,
    time: &str,
    config: &CaseConfig,
    sink: &Sink,
) -> Result<(), StoreError> {
    for (folder, known) in places(time, config) {
        for name in names(root, &folder)?.iter().filter(|n| !known.contains(n)) {
            let missing = |k: &&String| !files::exists(root, &format!("{folder}/{k}"));
            let Some(near) = known.iter().filter(missing).find(|k| one_slip(name, k)) else {
                continue;
            };
            let path = root.join(&folder).join(name).display().to_string();
            let d = Diag::file(path, "nothing reads this file");
            let help = format!("did you mean `{near}`, which the case does not have?");
            sink.push(Diag { severity: Severity::Warning, ..d }.help(help));
        }
    }
    Ok(())
}

/// Whether two names differ by case alone, or by one letter that is another, missing, too many or
/// swapped with its neighbour. Files of other programs are not far from ours, so no more may differ.
fn one_slip(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(|s| s.to_lowercase().into_bytes());
    let start = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let (a, b) = (&a[start..], &b[start..]);
    let end = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
    match (&a[..a.len() - end], &b[..b.len() - end]) {
        // One letter is near any other.
        ([_], [_]) => start + end > 0,
        ([], [] | [_]) | ([_], []) => true,
        ([x, y], [u, v]) => (x, y) == (v, u),
        _ => false,
    }
}

/// Folders, and the names that are read in each.
fn places(time: &str, config: &CaseConfig) -> [(String, Vec<String>); 3] {
    let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    let mut fields = owned(&["U", config.pressure(), "phi", "phi_0", "U_0"]);
    if config.transport.has_fluidity {
        fields.push("fluidity".into());
    }
    if let Some(two) = &config.transport.second {
        fields.push(two.alpha());
    }
    // What a run writes beside its state.
    fields.extend(owned(&["p", "strainRate", "stressRatio", "inertialNumber", "viscosity"]));
    [
        ("system".into(), owned(SYSTEM)),
        ("constant".into(), owned(CONSTANT)),
        (time.to_owned(), fields),
    ]
}

/// Names of the plain files of a folder, without `.gz`, in order; none when there is no folder.
fn names(root: &Path, folder: &str) -> Result<Vec<String>, StoreError> {
    let dir = root.join(folder);
    let failed = |e: io::Error| StoreError::new(Operation::Read, dir.clone(), e);
    let entries = match std::fs::read_dir(&dir) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(failed(e)),
    };
    let mut out = Vec::new();
    for entry in entries {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let hidden = name.starts_with('.') || name.ends_with('~');
        if entry.path().is_file() && !hidden {
            out.push(name.trim_end_matches(".gz").to_owned());
        }
    }
    out.sort();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::one_slip;

    #[test]
    fn one_slip_and_no_more() {
        for (a, b) in [
            ("fvsolution", "fvSolution"),
            ("fvSolutions", "fvSolution"),
            ("fvSoltuion", "fvSolution"),
            ("alpha.watr", "alpha.water"),
            ("G", "g"),
        ] {
            assert!(one_slip(a, b) && one_slip(b, a), "{a} {b}");
        }
        for (a, b) in [("T", "U"), ("topoSetDict", "plotDict"), ("alpha.grains", "alpha.air")] {
            assert!(!one_slip(a, b), "{a} {b}");
        }
    }
}
