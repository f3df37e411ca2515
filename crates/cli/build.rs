//! Puts the repository's cases into the program: a table of names and files.
//!
//! Only what a user needs to run a case goes in: not what a run makes (`postProcessing`, logs, time
//! directories, the mesh that `blockMeshDict` describes).

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

fn main() -> io::Result<()> {
    // The folders of input are watched whole, so that a new file in them is noticed; the case's
    // own folder is not: each run in the repository would compile the program anew.
    println!("cargo:rerun-if-changed=build.rs");
    let root = PathBuf::from(env("CARGO_MANIFEST_DIR")?).join("../../cases");
    let mut table = String::from("&[\n");
    for name in names_in(&root)? {
        let case = root.join(&name);
        if !case.join("system/controlDict").is_file() {
            continue;
        }
        for input in ["system", "constant", "0.orig", "reference"].map(|d| case.join(d)) {
            if input.is_dir() {
                println!("cargo:rerun-if-changed={}", fs::canonicalize(input)?.display());
            }
        }
        let mut files = Vec::new();
        collect(&case, "", &mut files)?;
        writeln!(table, "    Builtin {{ name: {name:?}, files: &[").map_err(io::Error::other)?;
        for rel in files {
            let path = fs::canonicalize(case.join(&rel))?;
            let path = path.display();
            println!("cargo:rerun-if-changed={path}");
            writeln!(table, "        ({rel:?}, include_bytes!(r#\"{path}\"#)),")
                .map_err(io::Error::other)?;
        }
        table.push_str("    ] },\n");
    }
    table.push_str("]\n");
    fs::write(PathBuf::from(env("OUT_DIR")?).join("cases.rs"), table)
}

fn env(name: &str) -> io::Result<String> {
    std::env::var(name).map_err(io::Error::other)
}

/// Names in a directory in order; none when there is no such directory (a packaged crate).
fn names_in(dir: &Path) -> io::Result<Vec<String>> {
    if !dir.is_dir() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(dir)? {
        names.extend(entry?.file_name().into_string().ok());
    }
    names.sort();
    Ok(names)
}

/// The files of a case below `rel` that belong to its input.
fn collect(case: &Path, rel: &str, files: &mut Vec<String>) -> io::Result<()> {
    for name in names_in(&case.join(rel))? {
        let below = if rel.is_empty() { name.clone() } else { format!("{rel}/{name}") };
        let path = case.join(&below);
        if made_by_a_run(case, &below, &name) {
            continue;
        }
        if path.is_dir() {
            collect(case, &below, files)?;
        } else {
            files.push(below);
        }
    }
    Ok(())
}

fn made_by_a_run(case: &Path, rel: &str, name: &str) -> bool {
    let top = !rel.contains('/');
    let has = |file: &str| case.join(file).exists();
    name.starts_with('.')
        || (top && matches!(name, "postProcessing" | "log.jsonl" | "superseded"))
        || (top && name == "0" && has("0.orig"))
        || (top && name != "0" && name.parse::<f64>().is_ok())
        || (rel == "constant/polyMesh" && has("system/blockMeshDict"))
}
