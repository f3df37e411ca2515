//! Texts and places in them.

use std::{fmt, ops::Range, sync::Arc};

/// A file's contents under the name a user knows it by. The bytes may hold binary lists.
#[derive(PartialEq, Eq)]
pub struct Source {
    /// Path as shown in messages; includes are resolved relative to its folder.
    pub path: String,
    /// The (decompressed) contents; not necessarily UTF-8.
    pub text: Vec<u8>,
}

impl Source {
    /// A shared source.
    pub fn new(path: impl Into<String>, text: impl Into<Vec<u8>>) -> Arc<Source> {
        Arc::new(Source { path: path.into(), text: text.into() })
    }
    /// Line and column of a byte offset, both from 1; columns count characters.
    pub fn line_col(&self, at: usize) -> (usize, usize) {
        let at = at.min(self.text.len());
        let line = 1 + self.text[..at].iter().filter(|&&b| b == b'\n').count();
        let head = &self.text[self.line_range(at).start..at];
        (line, 1 + String::from_utf8_lossy(head).chars().count())
    }
    /// Bytes of the line that holds offset `at`, without its end-of-line characters.
    pub(crate) fn line_range(&self, at: usize) -> Range<usize> {
        let at = at.min(self.text.len());
        let start = self.text[..at].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let mut end =
            self.text[at..].iter().position(|&b| b == b'\n').map_or(self.text.len(), |i| at + i);
        if end > at && self.text[end - 1] == b'\r' {
            end -= 1;
        }
        start..end
    }
    /// Folder part of the path, with its closing slash; empty when there is none.
    pub(crate) fn folder(&self) -> &str {
        self.path.rfind('/').map_or("", |i| &self.path[..=i])
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} bytes)", self.path, self.text.len())
    }
}

/// A range of bytes of one source.
#[derive(Clone, PartialEq, Eq)]
pub struct Span {
    /// The text.
    pub src: Arc<Source>,
    /// Byte offsets in it.
    pub range: Range<usize>,
}

impl Span {
    /// `range` of `src`.
    pub fn new(src: &Arc<Source>, range: Range<usize>) -> Span {
        Span { src: src.clone(), range }
    }
    /// The place of things no file holds (generated trees).
    pub fn none() -> Span {
        use std::sync::OnceLock;
        static NOWHERE: OnceLock<Arc<Source>> = OnceLock::new();
        Span::new(NOWHERE.get_or_init(|| Source::new("", "")), 0..0)
    }
    /// From the start of `self` to the end of `other`; `self` alone when they lie in two files.
    #[must_use]
    pub fn to(&self, other: &Span) -> Span {
        if !Arc::ptr_eq(&self.src, &other.src) || other.range.end < self.range.start {
            return self.clone();
        }
        Span::new(&self.src, self.range.start..other.range.end)
    }
    /// The empty place just behind the span.
    #[must_use]
    pub fn after(&self) -> Span {
        Span::new(&self.src, self.range.end..self.range.end)
    }
    /// The text of the span, bytes that are not UTF-8 replaced.
    pub fn text(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(self.src.text.get(self.range.clone()).unwrap_or(&[]))
    }
    /// Whether a line ends between `self` and a later span of the same file.
    pub(crate) fn line_break_before(&self, next: &Span) -> bool {
        Arc::ptr_eq(&self.src, &next.src)
            && self.range.end <= next.range.start
            && self.src.text[self.range.end..next.range.start].contains(&b'\n')
    }
}

impl fmt::Debug for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}..{}", self.src.path, self.range.start, self.range.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_lines_count_newlines() {
        let s = Source::new("f", "aé\nλx");
        assert_eq!(s.line_col(3), (1, 3));
        assert_eq!(s.line_col(6), (2, 2));
        assert_eq!(s.line_col(999), (2, 3));
    }

    #[test]
    fn bytes_that_are_no_text_are_counted_without_panic() {
        let s = Source::new("f", vec![0xff, 0xfe, b'a', b'\r', b'\n']);
        assert_eq!(s.line_col(3), (1, 4));
        assert_eq!(s.line_range(0), 0..3);
    }
}
