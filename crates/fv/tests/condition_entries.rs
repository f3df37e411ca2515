//! The registry of conditions and the book's examples: what is said of a condition is what it reads.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use granflow_base::Dims;
use granflow_dict::{Dict, Reader, Severity, Sink, parse_str};
use granflow_fv::conditions::{ALL, CaseContext, CaseFiles, Entry, PatchContext};
use granflow_mesh::PatchKind;
use std::io;

/// Values at the corners of a square, at one time.
#[derive(Debug)]
struct Square;
impl CaseFiles for Square {
    fn load(&self, path: &str) -> io::Result<Vec<u8>> {
        let points = path.ends_with("points");
        let text = if points {
            "((0 0 0) (0 1 0) (0 0 1) (0 1 1))"
        } else {
            "4((1 0 0) (1 0 0) (1 0 0) (1 0 0))"
        };
        Ok(text.into())
    }
    fn folders(&self, _: &str) -> io::Result<Vec<String>> {
        Ok(vec!["0".into()])
    }
}

fn context() -> PatchContext<'static> {
    PatchContext {
        patch: "inlet",
        kind: &PatchKind::Patch,
        n_faces: 4,
        n_inner: 4,
        field: "U",
        dims: Dims::NONE,
        factor: 1.0,
        case: CaseContext { files: &Square, ..CaseContext::NONE },
        wave: None,
    }
}

/// What a condition's own reader says of a patch's dictionary, as a vector's or a scalar's, and
/// the keys it asks for.
fn read(entry: &Entry, patch: &Dict, vector: bool) -> Option<(String, Vec<String>)> {
    let sink = Sink::new();
    let r = Reader::new(patch, &sink);
    r.ignore("type");
    match vector {
        true => drop(entry.vector?(&r, &context())),
        false => drop(entry.scalar?(&r, &context())),
    }
    r.finish(Severity::Error);
    Some((sink.take().to_string(), r.asked()))
}

/// The patches of the example in the book.
fn example(name: &str) -> Dict {
    let path = format!("{}/../../book/examples/conditions/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (dict, diags) = parse_str(&text);
    assert!(diags.is_empty(), "{path}: {diags:?}");
    dict
}

fn patches(text: &Dict) -> Vec<&Dict> {
    let dict = |e: &'_ granflow_dict::Entry| e.key.text().to_owned();
    let names: Vec<String> = text.entries.iter().map(dict).collect();
    names.iter().filter_map(|name| text.sub(name)).collect()
}

#[test]
fn every_example_is_read_by_its_condition() {
    for entry in ALL {
        let dict = example(entry.name);
        let all = patches(&dict);
        assert!(!all.is_empty(), "{}: no patch in the example", entry.name);
        for patch in all {
            assert_eq!(patch.word("type"), Some(entry.name));
            let said: Vec<String> =
                [true, false].iter().filter_map(|v| Some(read(entry, patch, *v)?.0)).collect();
            assert!(said.iter().any(String::is_empty), "{}: {said:?}", entry.name);
        }
    }
}

#[test]
fn every_condition_has_a_formula_and_names_the_keys_it_reads() {
    let mut unread = Vec::new();
    for entry in ALL {
        let name = entry.name;
        assert!(!entry.formula.is_empty(), "{name}");
        let dict = example(name);
        let asked: Vec<String> = patches(&dict)
            .into_iter()
            .flat_map(|patch| [true, false].map(|vector| read(entry, patch, vector)))
            .flatten()
            .flat_map(|found| found.1)
            .collect();
        for key in patches(&dict).iter().flat_map(|p| p.entries.iter().map(|e| e.key.text())) {
            let documented = entry.keys.iter().any(|k| k.0 == key);
            assert!(documented || ["type", "value"].contains(&key), "{name}: {key} is not said");
        }
        for (key, meaning) in entry.keys {
            assert!(!meaning.is_empty(), "{name}: {key}");
            if !asked.iter().any(|k| k == key) {
                unread.push(format!("{name}: {key}"));
            }
        }
    }
    assert!(unread.is_empty(), "not read: {unread:?}");
}
