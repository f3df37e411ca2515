//! Every case under `cases/` that says what to expect runs through the command, with one thread
//! and with three, and meets its `expect.toml`; the two runs write the same bytes. (Threads share
//! even the smallest loops here, which on these meshes they would not do by themselves.)

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

use granflow_case::expect::{is_slow, judge};
use std::path::{Path, PathBuf};
use std::process::Command;

fn cases() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    let mut all: Vec<PathBuf> = std::fs::read_dir(root)
        .expect("cases/")
        .map(|e| e.expect("an entry").path())
        .filter(|p| std::fs::read_to_string(p.join("expect.toml")).is_ok_and(|t| !is_slow(&t)))
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
        .args(["run", "-j", threads, "--share", "1"])
        .arg(dir.path())
        .output()
        .expect("granflow runs");
    let text = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{}: {text}", case.display());
    let said = format!("{}{text}", String::from_utf8_lossy(&out.stdout));
    assert!(!said.contains("not converged"), "{}: {said}", case.display());
    dir
}

fn check(case: &Path, ran: &Path) {
    let name = case.file_name().expect("a name").to_string_lossy();
    for q in judge(ran).unwrap_or_else(|e| panic!("{name}: {e}")) {
        println!("{name}: {}: {:.2e} of {:.1e}", q.what, q.error, q.tolerance);
        assert!(!q.source.is_empty());
        assert!(q.passed(), "{name}: {}: {:.3e} exceeds {:.3e}", q.what, q.error, q.tolerance);
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
