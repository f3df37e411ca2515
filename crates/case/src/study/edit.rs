//! Entries of a case's files, given another value: where the entry stands (the definition, where a macro stands for
//! it), or behind the end of the file where there is none.

use crate::files;
use crate::store::{Operation, StoreError, write_atomic};
use granflow_dict::{Dict, Sink, Span, Value};
use std::path::Path;

/// Why an entry cannot be given another value.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// There is no such file.
    #[error("there is no file `{0}` in the case")]
    NoFile(String),
    /// The path leads through something that is no dictionary, or ends at one.
    #[error("`{entry}` of `{file}` leads {why}")]
    NoEntry {
        /// The file.
        file: String,
        /// The path to the entry.
        entry: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// What stands for it lies in a file outside of the case.
    #[error("`{entry}` is given its value in `{file}`, which is no file of the case")]
    Outside {
        /// The path to the entry.
        entry: String,
        /// The file.
        file: String,
    },
    /// The disk refuses.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Gives `entry`, a path like `NGFCoeffs.d`, the value `text` in the file `rel` of the case.
///
/// # Errors
/// [`EditError`].
pub fn set_entry(root: &Path, rel: &str, entry: &str, text: &str) -> Result<(), EditError> {
    let sink = Sink::new();
    let dict = files::dict(root, rel, &sink)?.ok_or_else(|| EditError::NoFile(rel.to_owned()))?;
    let (path, range, new) = match place(&dict, rel, entry)? {
        Some(span) => (Path::new(&span.src.path).to_owned(), Some(span.range), text.to_owned()),
        None => (root.join(rel), None, appended(entry, text)),
    };
    // Where it really lies, links and `..` followed.
    let real = |p: &Path| p.canonicalize().ok();
    if !real(&path).zip(real(root)).is_some_and(|(path, root)| path.starts_with(root)) {
        let (entry, file) = (entry.to_owned(), path.display().to_string());
        return Err(EditError::Outside { entry, file });
    }
    let fail = |e| StoreError::new(Operation::Read, path.clone(), e);
    let mut bytes = std::fs::read(&path).map_err(fail)?;
    match range {
        Some(range) => drop(bytes.splice(range, new.into_bytes())),
        None => bytes.extend(new.into_bytes()),
    }
    write_atomic(&path, &bytes)?;
    Ok(())
}

/// Where the value of `entry` stands; none where there is no such entry.
fn place(dict: &Dict, file: &str, entry: &str) -> Result<Option<Span>, EditError> {
    let wrong = |why| EditError::NoEntry { file: file.to_owned(), entry: entry.to_owned(), why };
    let mut here = dict;
    let mut parts = entry.split('.').peekable();
    while let Some(part) = parts.next() {
        match (here.get(part), parts.peek()) {
            (Some(Value::Dict(sub)), Some(_)) => here = sub,
            (Some(Value::Dict(_)), None) => return Err(wrong("to a dictionary, not to a value")),
            (Some(Value::Stream(_)), Some(_)) => {
                return Err(wrong("through a value, not through dictionaries"));
            }
            (Some(Value::Stream(tokens)), None) => {
                let own = here.find(part).map(|e| &e.key_span).and_then(own_text);
                let ends = tokens.first().zip(tokens.last());
                let whole = ends.map(|(first, last)| first.span.to(&last.span));
                // One macro is changed where it is defined, a value with macros in it where it stands.
                let one = |t: &str| t.starts_with('$') && !t.contains(char::is_whitespace);
                return Ok(match own {
                    Some(own) if own.text().contains('$') && !one(&own.text()) => Some(own),
                    _ => whole,
                });
            }
            (None, _) => return Ok(None),
        }
    }
    Ok(None)
}

/// What stands between a key and its `;`.
fn own_text(key: &Span) -> Option<Span> {
    let rest = key.src.text.get(key.range.end..)?;
    let end = rest.iter().position(|b| *b == b';')?;
    let from = rest[..end].iter().position(|b| !b.is_ascii_whitespace())?;
    let to = rest[..end].iter().rposition(|b| !b.is_ascii_whitespace())? + 1;
    let at = key.range.end;
    Some(Span::new(&key.src, at + from..at + to))
}

/// `a { b { c text; } }` on a line of its own: later entries win, and dictionaries merge.
fn appended(entry: &str, text: &str) -> String {
    let parts: Vec<&str> = entry.split('.').collect();
    let (last, outer) = parts.split_last().unwrap_or((&"", &[]));
    let open: String = outer.iter().map(|p| format!("{p} {{ ")).collect();
    format!("\n{open}{last} {text};{}\n", " }".repeat(outer.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(dir.path().join("constant")).unwrap();
        let text = "d 0.5e-3; // beads\nNGFCoeffs { mus 0.38; d $d; v (1 0 0); }\n";
        std::fs::write(dir.path().join("constant/x"), text).unwrap();
        dir
    }
    fn read(dir: &tempfile::TempDir) -> String {
        std::fs::read_to_string(dir.path().join("constant/x")).unwrap()
    }

    #[test]
    fn a_value_is_replaced_where_it_stands() {
        let dir = case();
        set_entry(dir.path(), "constant/x", "NGFCoeffs.mus", "0.4").unwrap();
        set_entry(dir.path(), "constant/x", "NGFCoeffs.v", "(0 0 2)").unwrap();
        assert_eq!(read(&dir), "d 0.5e-3; // beads\nNGFCoeffs { mus 0.4; d $d; v (0 0 2); }\n");
    }

    #[test]
    fn a_macro_is_replaced_in_its_definition() {
        let dir = case();
        set_entry(dir.path(), "constant/x", "NGFCoeffs.d", "2e-3").unwrap();
        assert!(read(&dir).starts_with("d 2e-3; // beads\n"), "{}", read(&dir));
    }

    #[test]
    fn a_value_with_macros_in_it_is_replaced_where_it_stands() {
        let dir = case();
        let file = dir.path().join("constant/x");
        std::fs::write(&file, "p0 75;\ninternalField uniform $p0;\nboth $p0 $p0;\n").unwrap();
        set_entry(dir.path(), "constant/x", "internalField", "uniform 80").unwrap();
        set_entry(dir.path(), "constant/x", "both", "1 2").unwrap();
        assert_eq!(read(&dir), "p0 75;\ninternalField uniform 80;\nboth 1 2;\n");
    }

    #[test]
    fn nothing_outside_of_the_case_is_touched() {
        let dir = case();
        let inner = dir.path().join("inner");
        std::fs::create_dir_all(&inner).unwrap();
        let before = read(&dir);
        let outside = dir.path().join("constant/x").display().to_string();
        for file in ["../constant/x", outside.as_str()] {
            for entry in ["d", "nothing"] {
                let e = set_entry(&inner, file, entry, "1").unwrap_err();
                assert!(matches!(e, EditError::Outside { .. }), "{e}");
            }
        }
        assert_eq!(read(&dir), before);
    }

    #[test]
    fn what_is_not_there_is_added() {
        let dir = case();
        set_entry(dir.path(), "constant/x", "NGFCoeffs.form", "primitive").unwrap();
        let sink = Sink::new();
        let dict = files::dict(dir.path(), "constant/x", &sink).unwrap().unwrap();
        let coeffs = dict.sub("NGFCoeffs").unwrap();
        assert_eq!((coeffs.word("form"), coeffs.number("mus")), (Some("primitive"), Some(0.38)));
    }

    #[test]
    fn what_is_no_value_is_refused() {
        let dir = case();
        for entry in ["NGFCoeffs", "d.mus"] {
            let e = set_entry(dir.path(), "constant/x", entry, "1").unwrap_err();
            assert!(matches!(e, EditError::NoEntry { .. }), "{e}");
        }
        assert!(matches!(set_entry(dir.path(), "constant/y", "a", "1"), Err(EditError::NoFile(_))));
    }
}
