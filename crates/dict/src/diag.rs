//! What is wrong, where, and how to mend it.

use crate::source::{Source, Span};
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::{cell::RefCell, cmp::Ordering, fmt, ops::Range, rc::Rc, sync::Arc};

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The case cannot run.
    Error,
    /// The case runs, perhaps not as meant.
    Warning,
}

/// One finding with the place it is about.
#[derive(Clone, Debug, PartialEq)]
pub struct Diag {
    /// Error or warning.
    pub severity: Severity,
    /// One line: what is wrong.
    pub message: String,
    /// The file.
    pub src: Arc<Source>,
    /// Bytes of `src` under the caret.
    pub span: Range<usize>,
    /// Text beside the caret.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Diag {
    fn new(severity: Severity, at: &Span, message: String) -> Diag {
        let (src, span) = (at.src.clone(), at.range.clone());
        Diag { severity, message, src, span, label: String::new(), help: None }
    }
    /// An error at a place.
    pub fn error(at: &Span, message: impl Into<String>) -> Diag {
        Diag::new(Severity::Error, at, message.into())
    }
    /// A warning at a place.
    pub fn warning(at: &Span, message: impl Into<String>) -> Diag {
        Diag::new(Severity::Warning, at, message.into())
    }
    /// An error about a whole file, such as one that is missing.
    /// The `./` of the current directory is not shown; an empty path names no file.
    pub fn file(path: impl Into<String>, message: impl Into<String>) -> Diag {
        let path: String = path.into();
        let shown = path.strip_prefix("./").unwrap_or(&path);
        Diag::error(&Span::new(&Source::new(shown, ""), 0..0), message)
    }
    /// Sets the text beside the caret.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Diag {
        self.label = label.into();
        self
    }
    /// Sets the help line.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Diag {
        self.help = Some(help.into());
        self
    }
    /// Sets the help line when there is one.
    #[must_use]
    pub fn maybe_help(mut self, help: Option<impl Into<String>>) -> Diag {
        self.help = help.map(Into::into).or(self.help);
        self
    }
    /// `path:line:col`, or the bare path of an empty file.
    pub fn place(&self) -> String {
        if self.src.text.is_empty() {
            return self.src.path.clone();
        }
        let (line, col) = self.src.line_col(self.span.start);
        format!("{}:{line}:{col}", self.src.path)
    }
    /// The message as a person reads it: message, place, source line with caret, help.
    pub fn render(&self, colour: bool) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = Group::with_title(level.primary_title(self.message.as_str()));
        if self.src.text.is_empty() {
            if !self.src.path.is_empty() {
                group = group.element(Origin::path(self.src.path.as_str()));
            }
        } else {
            let (text, mark, whole) = self.excerpt();
            let mut caret = AnnotationKind::Primary.span(mark);
            if !self.label.is_empty() {
                caret = caret.label(self.label.as_str());
            }
            let (line, col) = self.src.line_col(self.span.start);
            let mut snippet = Snippet::source(text).line_start(line).annotation(caret);
            if whole {
                snippet = snippet.path(self.src.path.as_str());
            } else {
                // The column must be that of the file, not of the excerpt.
                let origin = Origin::path(self.src.path.as_str()).line(line);
                group = group.element(origin.char_column(col));
            }
            group = group.element(snippet);
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        renderer.decor_style(DecorStyle::Ascii).render(&[group])
    }
    /// The line of the caret as text, with the caret's bytes in it. Lines of data that run to
    /// megabytes are cut to what surrounds the caret; the last value says that the start is whole.
    fn excerpt(&self) -> (String, Range<usize>, bool) {
        const AROUND: usize = 200;
        let text = &self.src.text;
        let start = self.span.start.min(text.len());
        let line = self.src.line_range(start);
        // An offset between `\r` and `\n` lies behind the line's text.
        let start = start.min(line.end);
        let end = self.span.end.clamp(start, line.end);
        let from = line.start.max(start.saturating_sub(AROUND));
        let to = line.end.min(end.saturating_add(AROUND)).min(start.saturating_add(2 * AROUND));
        let end = end.min(to);
        let clean = |r: Range<usize>| {
            String::from_utf8_lossy(&text[r]).replace(|c: char| c.is_control() && c != '\t', " ")
        };
        let mut out = clean(from..start);
        let at = out.len();
        out.push_str(&clean(start..end));
        let mark = at..out.len();
        out.push_str(&clean(end..to));
        (out, mark, from == line.start)
    }
    fn order(&self, o: &Diag) -> Ordering {
        (self.src.path.cmp(&o.src.path))
            .then_with(|| self.span.start.cmp(&o.span.start))
            .then_with(|| self.severity.cmp(&o.severity))
            .then_with(|| self.span.end.cmp(&o.span.end))
            .then_with(|| self.message.cmp(&o.message))
    }
}

impl fmt::Display for Diag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}
impl std::error::Error for Diag {}

/// Findings in the order of files and places, none twice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diags(pub Vec<Diag>);

impl Diags {
    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.n_errors() > 0
    }
    /// Number of errors.
    pub fn n_errors(&self) -> usize {
        self.0.iter().filter(|d| d.severity == Severity::Error).count()
    }
    /// Number of warnings.
    pub fn n_warnings(&self) -> usize {
        self.0.len() - self.n_errors()
    }
    /// Whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// In order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diag> {
        self.0.iter()
    }
    /// Adds more and restores the order.
    pub fn extend(&mut self, more: impl IntoIterator<Item = Diag>) {
        self.0.extend(more);
        self.0.sort_by(Diag::order);
        // The same finding can be made twice, by the parser and by a reader.
        self.0.dedup_by(|a, b| {
            a.message == b.message && a.span == b.span && a.src.path == b.src.path
        });
    }
    /// All of them as a person reads them, a blank line between.
    pub fn render(&self, colour: bool) -> String {
        self.0.iter().map(|d| d.render(colour)).collect::<Vec<_>>().join("\n\n")
    }
}
impl From<Vec<Diag>> for Diags {
    fn from(diags: Vec<Diag>) -> Self {
        let mut out = Diags::default();
        out.extend(diags);
        out
    }
}
impl IntoIterator for Diags {
    type Item = Diag;
    type IntoIter = std::vec::IntoIter<Diag>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
impl fmt::Display for Diags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}
impl std::error::Error for Diags {}

/// Where readers put what they find; clones share one collection.
#[derive(Clone, Debug, Default)]
pub struct Sink(Rc<RefCell<Vec<Diag>>>);

impl Sink {
    /// An empty collection.
    pub fn new() -> Sink {
        Sink::default()
    }
    /// Adds one finding.
    pub fn push(&self, diag: Diag) {
        self.0.borrow_mut().push(diag);
    }
    /// Adds several, such as those of [`crate::parse`].
    pub fn extend(&self, diags: impl IntoIterator<Item = Diag>) {
        self.0.borrow_mut().extend(diags);
    }
    /// Whether an error was found so far.
    pub fn has_errors(&self) -> bool {
        self.n_errors() > 0
    }
    /// Number of errors so far.
    pub fn n_errors(&self) -> usize {
        self.0.borrow().iter().filter(|d| d.severity == Severity::Error).count()
    }
    /// Whether an error was already found in the value behind the keyword at `key`: what
    /// else looks wrong there follows from it.
    pub(crate) fn blames(&self, key: &Span) -> bool {
        let from = key.range.end;
        let inside = |d: &Diag| {
            let value = key.src.text.get(from..d.span.start);
            // A warning stops nothing: it must not hide an error.
            d.severity == Severity::Error
                && Arc::ptr_eq(&d.src, &key.src)
                && value.is_some_and(|v| !v.contains(&b';'))
        };
        self.0.borrow().iter().any(inside)
    }
    /// Everything found so far in order; the sink is empty afterwards.
    pub fn take(&self) -> Diags {
        std::mem::take(&mut *self.0.borrow_mut()).into()
    }
}
