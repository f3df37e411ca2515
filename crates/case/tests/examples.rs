//! The book's examples of functions, schemes, solvers and sources are what a case reads, and every
//! entry of their registries has one.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::*;
use granflow_case::{Case, Notices, Options, functions};
use granflow_dict::{Reader, Severity, Sink, parse_str};
use granflow_flow::sources::ALL as SOURCES;
use std::path::Path;

fn example(kind: &str, name: &str) -> String {
    let path = format!("{}/../../book/examples/{kind}/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The names that have an example.
fn examples(kind: &str) -> Vec<String> {
    let folder = format!("{}/../../book/examples/{kind}", env!("CARGO_MANIFEST_DIR"));
    let files = std::fs::read_dir(folder).unwrap().flatten();
    let name =
        |f: std::fs::DirEntry| f.file_name().to_str()?.strip_suffix(".txt").map(str::to_owned);
    files.filter_map(name).collect()
}

/// What is said of a case, notices left out.
fn mistakes(root: &Path) -> String {
    let (sink, notices) = (Sink::new(), Notices::new());
    let loaded = Case::load(root, &Options::default(), &sink, &notices);
    let said = sink.take().to_string();
    match loaded {
        Ok(_) => said,
        Err(e) => format!("{e}\n{said}"),
    }
}

#[test]
fn functions_read_their_examples() {
    for entry in functions::ALL {
        let text = format!("functions {{ {} }}", example("functions", entry.name));
        let (dict, diags) = parse_str(&text);
        assert!(diags.is_empty(), "{}: {diags:?}", entry.name);
        let sink = Sink::new();
        let r = Reader::new(&dict, &sink);
        let planned = functions::read(&r);
        r.finish(Severity::Error);
        assert_eq!(sink.take().to_string(), "", "{}", entry.name);
        assert_eq!(planned.len(), 1, "{}", entry.name);
        assert!(
            text.contains(&format!("type {}", entry.name))
                || text.contains(&format!("type    {}", entry.name))
        );
        assert!(!entry.formula.is_empty());
    }
}

#[test]
fn cases_read_the_examples_of_schemes() {
    let all = examples("schemes");
    assert!(all.len() >= 34, "{all:?}");
    for name in all {
        let dir = cavity_case(4);
        let text = example("schemes", &name);
        assert!(text.contains(&name), "{name}");
        put(dir.path(), "system/fvSchemes", &text);
        assert_eq!(mistakes(dir.path()), "", "{name}");
    }
}

#[test]
fn cases_read_the_examples_of_solvers() {
    for entry in granflow_linsolve::ALL {
        let text = example("solvers", entry.name);
        assert!(!entry.formula.is_empty() && text.contains(entry.name), "{}", entry.name);
        let dir = cavity_case(4);
        put(
            dir.path(),
            "system/fvSolution",
            &format!(
                "solvers {{ {text} U {{ solver PBiCGStab; preconditioner DILU; tolerance 1e-8; }} }}"
            ),
        );
        assert_eq!(mistakes(dir.path()), "", "{}", entry.name);
    }
}

#[test]
fn cases_read_the_examples_of_sources() {
    for entry in SOURCES {
        let name = entry.names[0];
        let text = example("sources", name);
        assert!(!entry.formula.is_empty() && text.contains(name));
        let dir = cavity_case(4);
        put(dir.path(), "constant/fvOptions", &text);
        put(
            dir.path(),
            "system/topoSetDict",
            "actions ( { name fan; type cellSet; action new; source boxToCell; box (-1 -1 -1) (0.5 2 1); } );",
        );
        assert_eq!(mistakes(dir.path()), "", "{name}");
    }
}
