//! Links of the book and of the documents beside it: every relative one must lead somewhere, and
//! every page of the book must be in its table of contents.

use crate::run;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Links that lead nowhere and pages that nothing leads to, one line each.
pub(crate) fn faults(root: &Path) -> Vec<String> {
    let book = root.join("book/src");
    let pages = run::files_below(&book, ".md");
    let mut documents = pages.clone();
    documents.extend(files_here(root));
    documents.extend(run::files_below(&root.join("cases"), ".md"));
    let mut faults = Vec::new();
    for document in &documents {
        let shown = document.strip_prefix(root).unwrap_or(document).display().to_string();
        let Ok(text) = fs::read_to_string(document) else {
            faults.push(format!("{shown} is not readable as text"));
            continue;
        };
        let dir = document.parent().unwrap_or(root);
        for (line, link) in links(&text) {
            if let Some(why) = broken(document, dir, &link) {
                faults.push(format!("{shown}:{line}: {link}: {why}"));
            }
        }
    }
    faults.extend(unlisted(root, &book, &pages));
    faults
}

fn files_here(dir: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten().flatten().map(|e| e.path());
    let mut found: Vec<PathBuf> =
        entries.filter(|p| p.is_file() && p.extension().is_some_and(|e| e == "md")).collect();
    found.sort();
    found
}

/// Pages of the book that the table of contents does not name.
fn unlisted(root: &Path, book: &Path, pages: &[PathBuf]) -> Vec<String> {
    let summary = book.join("SUMMARY.md");
    let text = fs::read_to_string(&summary).unwrap_or_default();
    let listed: Vec<PathBuf> = links(&text).iter().map(|(_, l)| clean(&book.join(l))).collect();
    let missing = pages.iter().filter(|p| **p != summary && !listed.contains(p));
    missing
        .map(|p| format!("{} is not in SUMMARY.md", p.strip_prefix(root).unwrap_or(p).display()))
        .collect()
}

/// Why a link leads nowhere, if it does not.
fn broken(document: &Path, dir: &Path, link: &str) -> Option<String> {
    if link.contains("://") || link.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(f, a)| (f, Some(a)));
    let target = if file.is_empty() { document.to_path_buf() } else { clean(&dir.join(file)) };
    if !target.exists() {
        return Some("no such file".into());
    }
    let anchor = anchor?;
    let text = fs::read_to_string(&target).unwrap_or_default();
    let known = prose(&text).any(|(_, l)| l.starts_with('#') && slug(l) == anchor);
    (!known).then(|| "no such heading".into())
}

/// A path without `.` and `..`.
fn clean(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(out.pop()),
            Component::CurDir => (),
            part => out.push(part),
        }
    }
    out
}

/// The name of a heading in links.
fn slug(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Lines outside fenced code, numbered from 1.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(i, line)| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        (!fenced && !fence).then_some((i + 1, line))
    })
}

/// Targets of inline links with their lines; code does not count.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in prose(text) {
        let words: String = line.split('`').step_by(2).collect::<Vec<_>>().join("``");
        for part in words.split("](").skip(1) {
            if let Some((target, _)) = part.split_once(')') {
                found.push((number, target.to_owned()));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_and_code_is_left_alone() {
        let text = "a [b](c.md) and [`x`](d.md#e), `[no](link)`\n```\n[no](code)\n```\n[f](#g)";
        let found = [(1, "c.md".into()), (1, "d.md#e".into()), (5, "#g".to_string())];
        assert_eq!(links(text), found);
    }

    #[test]
    fn headings_are_named_as_the_book_does() {
        assert_eq!(slug("## mu -> mu_s: a limit"), "mu---mu_s-a-limit");
    }

    #[test]
    fn a_link_to_nothing_is_a_fault() {
        let here = run::root();
        let document = here.join("Cargo.toml");
        assert!(broken(&document, &here, "no/such.md").is_some());
        assert!(broken(&document, &here, "xtask/../Cargo.toml").is_none());
        assert!(broken(&document, &here, "https://example.org").is_none());
    }
}
