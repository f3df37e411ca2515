//! The report as lines: sections, keys in a column of their own, tables.

use crate::text::wrap;

/// Width of the column of keys.
const KEY: usize = 18;
/// Width of what stands beside it.
const TEXT: usize = 92;

/// A report that grows line by line.
#[derive(Default)]
pub(super) struct Page {
    lines: Vec<String>,
    warnings: usize,
}

impl Page {
    /// Begins a section.
    pub(super) fn open(&mut self, title: &str) {
        if !self.lines.is_empty() {
            self.lines.push(String::new());
        }
        self.lines.push(format!("== {title}"));
    }
    /// A key and what there is to say; long text goes on below itself.
    pub(super) fn say(&mut self, key: &str, text: impl AsRef<str>) {
        let wrapped = wrap(text.as_ref(), 0, TEXT);
        for (i, line) in wrapped.lines().enumerate() {
            let key = if i == 0 { key } else { "" };
            self.lines.push(format!("{key:<KEY$} {line}").trim_end().to_owned());
        }
    }
    /// What the run will suffer from.
    pub(super) fn warn(&mut self, text: impl AsRef<str>) {
        self.warnings += 1;
        self.say("warning", text);
    }
    /// Rows with columns as wide as they need; the first row is the heading.
    pub(super) fn table(&mut self, rows: &[Vec<String>]) {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| {
            rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in rows {
            let cells = row.iter().zip(&widths).map(|(t, &w)| format!("{t:<w$}"));
            let line = cells.collect::<Vec<_>>().join("  ");
            self.lines.push(line.trim_end().to_owned());
        }
    }
    /// How many warnings there are.
    pub(super) fn warnings(&self) -> usize {
        self.warnings
    }
    /// All lines.
    pub(super) fn lines(self) -> Vec<String> {
        self.lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_tables_are_columns() {
        let mut page = Page::default();
        page.open("One");
        page.say("key", "text");
        page.open("Two");
        page.warn("w ".repeat(60));
        page.table(&[vec!["a".into(), "b".into()], vec!["long".into(), "c".into()]]);
        assert_eq!(page.warnings(), 1);
        let lines = page.lines();
        assert_eq!(lines[..4], ["== One", "key                text", "", "== Two"]);
        assert!(lines[4].starts_with("warning            w w"), "{lines:?}");
        assert!(lines[5].starts_with("                   w w"), "{lines:?}");
        assert_eq!(lines[6..], ["a     b", "long  c"]);
    }
}
