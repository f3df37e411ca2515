//! Every case under `cases/` that says what to expect runs through the command, with one thread
//! and with three, and meets its `expect.toml`; the two runs write the same bytes.
//!
//! ```toml
//! [[check]]
//! what      = "V/V_wall against the exact profile"
//! file      = "postProcessing/profile/3/radius_U.csv"
//! x         = "(x - 0.051)/0.00075"        # expressions over the columns of the file
//! y         = "U_y/5.1e-4"
//! reference = "reference/profile.csv"      # with columns (or expressions) ref_x, ref_y
//! ref_x     = "col1"
//! ref_y     = "col6"
//! tolerance = 1.2e-4                       # greatest |y - reference(x)|
//! source    = "where the reference comes from"
//!
//! `exact`, an expression over the columns of the file, may stand in place of `reference`.
//!
//! [[check]]
//! what      = "centre velocity"
//! file      = "..."
//! value     = "max(U_x)"                   # its last entry, or that of time `at`
//! expected  = 0.1
//! tolerance = 1e-3
//! source    = "..."
//! ```

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

use granflow_case::figures::expression::evaluate;
use granflow_case::figures::table::Table;
use std::path::{Path, PathBuf};
use std::process::Command;

fn cases() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    let mut all: Vec<PathBuf> = std::fs::read_dir(root)
        .expect("cases/")
        .map(|e| e.expect("an entry").path())
        .filter(|p| p.join("expect.toml").is_file())
        .collect();
    all.sort();
    all
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a directory");
    for entry in std::fs::read_dir(from).expect("a directory") {
        let entry = entry.expect("an entry");
        let (path, name) = (entry.path(), entry.file_name());
        let generated = ["postProcessing", "polyMesh", "log.jsonl"].iter().any(|g| name == *g);
        let time = name.to_string_lossy().parse::<f64>().is_ok();
        if generated || time {
            continue;
        }
        if path.is_dir() {
            copy(&path, &to.join(name))
        } else {
            std::fs::copy(&path, to.join(name)).expect("a copy");
        }
    }
}

fn run(case: &Path, threads: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a directory");
    copy(case, dir.path());
    let out = Command::new(env!("CARGO_BIN_EXE_granflow"))
        .args(["run", "-j", threads])
        .arg(dir.path())
        .output()
        .expect("granflow runs");
    let text = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{}: {text}", case.display());
    let said = format!("{}{text}", String::from_utf8_lossy(&out.stdout));
    assert!(!said.contains("not converged"), "{}: {said}", case.display());
    dir
}

fn columns(root: &Path, file: &str, wanted: &[&str]) -> Vec<Vec<f64>> {
    let path = root.join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let table = Table::parse(&text);
    wanted
        .iter()
        .map(|w| evaluate(w, &table).unwrap_or_else(|e| panic!("{file}: `{w}`: {e}")))
        .collect()
}

/// The greatest magnitude; no value at all and a value that is no number are errors.
fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = values.map(f64::abs).collect();
    assert!(!all.is_empty() && all.iter().all(|v| v.is_finite()), "{all:?}");
    all.into_iter().fold(0.0, f64::max)
}

/// Cubic interpolation of the points `(x, y)`, x growing, at `at`.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|v| *v < at).clamp(2, x.len() - 2) - 2;
    (k..k + 4)
        .map(|i| {
            let others = (k..k + 4).filter(|&j| j != i);
            y[i] * others.map(|j| (at - x[j]) / (x[i] - x[j])).product::<f64>()
        })
        .sum()
}

fn check(case: &Path, ran: &Path) {
    let text = std::fs::read_to_string(case.join("expect.toml")).expect("expect.toml");
    let expect: toml::Table = text.parse().unwrap_or_else(|e| panic!("{}: {e}", case.display()));
    let checks = expect.get("check").and_then(|c| c.as_array()).expect("[[check]]");
    assert!(!checks.is_empty());
    for c in checks {
        let word = |key: &str| c.get(key).and_then(|v| v.as_str());
        let must = |key: &str| word(key).unwrap_or_else(|| panic!("{}: {key}", case.display()));
        let number = |key: &str| {
            let v = c.get(key).unwrap_or_else(|| panic!("{}: {key}", case.display()));
            v.as_float().or_else(|| v.as_integer().map(|i| i as f64)).expect("a number")
        };
        let (what, tolerance) = (must("what"), number("tolerance"));
        assert!(!must("source").is_empty());
        let name = case.file_name().expect("a name").to_string_lossy();
        let error = match word("value") {
            Some(value) => {
                let v = columns(ran, must("file"), &[value, "col1"]);
                let row = match c.get("at") {
                    None => v[0].len() - 1,
                    Some(_) => {
                        let at = number("at");
                        let close = |t: &f64| (t - at).abs() < 1e-6 * at.abs().max(1.0);
                        v[1].iter().position(close).expect("a row at that time")
                    }
                };
                (v[0][row] - number("expected")).abs()
            }
            None if word("exact").is_some() => {
                let own = columns(ran, must("file"), &[must("y"), must("exact")]);
                greatest(own[0].iter().zip(&own[1]).map(|(y, e)| y - e))
            }
            None => {
                let own = columns(ran, must("file"), &[must("x"), must("y")]);
                let of = columns(case, must("reference"), &[must("ref_x"), must("ref_y")]);
                // Few measured points are compared where they are, a curve where we have values.
                let few = of[0].len() < own[0].len();
                let (points, curve) = if few { (&of, &own) } else { (&own, &of) };
                let each = points[0].iter().zip(&points[1]);
                greatest(each.map(|(x, y)| y - interpolate(&curve[0], &curve[1], *x)))
            }
        };
        println!("{name}: {what}: {error:.2e} of {tolerance:.1e}");
        assert!(error <= tolerance, "{name}: {what}: {error:.3e} exceeds {tolerance:.3e}");
    }
}

/// Relative paths and bytes of what a run wrote into its time directories.
fn written(root: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    fn walk(root: &Path, at: &Path, out: &mut Vec<(PathBuf, Vec<u8>)>) {
        let mut entries: Vec<PathBuf> = std::fs::read_dir(at)
            .expect("a directory")
            .map(|e| e.expect("an entry").path())
            .collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                walk(root, &path, out)
            } else {
                let bytes = std::fs::read(&path).expect("a file");
                out.push((path.strip_prefix(root).expect("below").to_path_buf(), bytes));
            }
        }
    }
    let mut out = Vec::new();
    for entry in std::fs::read_dir(root).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.file_name().is_some_and(|n| n.to_string_lossy().parse::<f64>().is_ok()) {
            walk(root, &path, &mut out);
        }
    }
    out.sort();
    out
}

#[test]
fn every_case_meets_its_reference_with_any_number_of_threads() {
    let all = cases();
    assert!(all.len() >= 8, "{all:?}");
    for case in all {
        let one = run(&case, "1");
        check(&case, one.path());
        let three = run(&case, "3");
        let (a, b) = (written(one.path()), written(three.path()));
        assert!(a.len() > 4 && a == b, "{}: threads change the result", case.display());
    }
}
