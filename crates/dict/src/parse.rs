//! Lexemes to a tree. Nothing stops it: every mistake becomes a diagnostic and parsing goes on at
//! the next place that makes sense. Macros and directives are expanded on the way (`expand.rs`, `directives.rs`),
//! because what they mean depends on the entries read so far.

use crate::diag::Diag;
use crate::directives::InputMode;
use crate::files::Files;
use crate::lists::Arch;
use crate::scan;
use crate::sequence::typed;
use crate::source::{Source, Span};
use crate::token::{Lexeme, lex};
use crate::tree::{Dict, Entry, Key, Pattern, Tok, Token, Value, brief};
use std::cell::RefCell;
use std::collections::HashSet;
use std::sync::Arc;

/// Nesting beyond this is refused: it would exhaust the stack.
const DEEPEST: usize = 100;
/// After this many mistakes a file is something else than a dictionary.
const MOST_DIAGS: usize = 100;
/// Tokens that macros may produce in one file; guards against doubling definitions.
const MOST_EXPANDED: usize = 1_000_000;

/// Parses a dictionary file: whatever was understood, and everything that is wrong.
pub fn parse(src: Arc<Source>, files: &mut dyn Files) -> (Dict, Vec<Diag>) {
    let mut p = Parser::new(files);
    p.open_files.push(src.path.clone());
    let mut c = Cursor::new(&src);
    p.scopes.push(Scope { name: String::new(), dict: root(&src) });
    p.entries(&mut c, None);
    let mut dict = p.scopes.pop().map(|s| s.dict).unwrap_or_default();
    dict.mark_referenced(&p.referenced.borrow());
    (dict, p.diags)
}

/// Parses a text without includes; messages name it `text`.
pub fn parse_str(text: &str) -> (Dict, Vec<Diag>) {
    parse(Source::new("text", text), &mut crate::files::NoFiles)
}

/// An empty dictionary that spans a file.
pub(crate) fn root(src: &Arc<Source>) -> Dict {
    let end = src.text.trim_ascii_end().len();
    Dict { open: Span::new(src, 0..0), close: Span::new(src, end..end), ..Dict::new() }
}

/// A place in one file.
pub(crate) struct Cursor {
    pub(crate) src: Arc<Source>,
    pub(crate) at: usize,
    /// Set by a header that says `format binary`.
    pub(crate) binary: Option<Arch>,
}
impl Cursor {
    pub(crate) fn new(src: &Arc<Source>) -> Cursor {
        // Editors of Windows put a mark of UTF-8 first.
        let at = if src.text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Cursor { src: src.clone(), at, binary: None }
    }
    pub(crate) fn peek(&self) -> (Lexeme, Span) {
        let (l, r) = lex(&self.src.text, self.at);
        (l, Span::new(&self.src, r))
    }
    pub(crate) fn next(&mut self) -> (Lexeme, Span) {
        let (l, s) = self.peek();
        self.at = s.range.end;
        (l, s)
    }
    /// Takes the mark `m` if it stands next.
    pub(crate) fn take(&mut self, m: u8) -> Option<Span> {
        let at = scan::space(&self.src.text, self.at);
        if self.src.text.get(at) != Some(&m) {
            return None;
        }
        self.at = at + 1;
        Some(Span::new(&self.src, at..at + 1))
    }
    /// Skips to the end, so that every open construct closes.
    pub(crate) fn abandon(&mut self) {
        self.at = self.src.text.len();
    }
}

/// A dictionary being filled.
pub(crate) struct Scope {
    pub(crate) name: String,
    pub(crate) dict: Dict,
}

pub(crate) struct Parser<'f> {
    pub(crate) files: &'f mut dyn Files,
    pub(crate) scopes: Vec<Scope>,
    pub(crate) diags: Vec<Diag>,
    pub(crate) mode: InputMode,
    pub(crate) open_files: Vec<String>,
    /// Tokens produced by macros so far.
    pub(crate) expanded: usize,
    pub(crate) depth: usize,
    /// Too many mistakes: say nothing more.
    pub(crate) silent: bool,
    /// An include was refused, which was said: macros may be unknown because of that.
    pub(crate) lost: bool,
    /// Macros that were unknown because of that.
    pub(crate) gaps: usize,
    /// Keywords that macros have stood for.
    pub(crate) referenced: RefCell<HashSet<String>>,
}

/// A list broke off at a mark that belongs to something around it; it was reported.
pub(crate) struct Broken;

impl<'f> Parser<'f> {
    pub(crate) fn new(files: &'f mut dyn Files) -> Parser<'f> {
        Parser {
            files,
            scopes: Vec::new(),
            diags: Vec::new(),
            mode: InputMode::Merge,
            open_files: Vec::new(),
            expanded: 0,
            depth: 0,
            silent: false,
            lost: false,
            gaps: 0,
            referenced: RefCell::default(),
        }
    }
    pub(crate) fn push(&mut self, d: Diag) {
        if self.silent {
            return;
        }
        self.diags.push(d);
        if self.diags.len() == MOST_DIAGS {
            self.silent = true;
            if let Some(last) = self.diags.last_mut() {
                last.help = Some("further mistakes in this file are not listed".into());
            }
        }
    }
    /// The dictionary being filled.
    pub(crate) fn here(&mut self) -> &mut Dict {
        if self.scopes.is_empty() {
            self.scopes.push(Scope { name: String::new(), dict: Dict::new() });
        }
        let last = self.scopes.len() - 1;
        &mut self.scopes[last].dict
    }
    pub(crate) fn add(&mut self, entry: Entry) {
        let mode = self.mode;
        let old = self.here().same_key(&entry.key);
        match (old, mode) {
            (Some(_), InputMode::Protect) => {}
            (Some(_), InputMode::Warn) => {
                let text = format!("`{}` is given twice; the first one holds", entry.key.text());
                self.push(Diag::warning(&entry.key_span, text).label("ignored (#inputMode warn)"));
            }
            (Some(_), InputMode::Error) => {
                let text = format!("`{}` is given twice", entry.key.text());
                self.push(
                    Diag::error(&entry.key_span, text).label("#inputMode error forbids this"),
                );
            }
            _ => self.here().insert(entry),
        }
    }
    /// Counts tokens made by macros; false when there are too many.
    pub(crate) fn afford(&mut self, n: usize, at: &Span) -> bool {
        let before = self.expanded;
        self.expanded = before.saturating_add(n);
        if before <= MOST_EXPANDED && self.expanded > MOST_EXPANDED {
            self.push(Diag::error(at, "macros expand to too much text").label("given up here"));
        }
        self.expanded <= MOST_EXPANDED
    }
    pub(crate) fn too_deep(&mut self, c: &mut Cursor, at: &Span) -> bool {
        if self.depth < DEEPEST {
            return false;
        }
        if c.at < c.src.text.len() {
            self.push(
                Diag::error(at, format!("nested more than {DEEPEST} deep")).label("given up here"),
            );
        }
        c.abandon();
        self.silent = true;
        true
    }

    /// Entries up to `}` (of the brace at `open`) or the end of the file; returns the closing place.
    pub(crate) fn entries(&mut self, c: &mut Cursor, open: Option<&Span>) -> Span {
        loop {
            let before = c.at;
            let (lexeme, span) = c.next();
            match lexeme {
                Lexeme::End => {
                    let tail = scan_comment_start(&c.src.text, before);
                    if let Some(at) = tail {
                        let at = Span::new(&c.src, at..at + 2);
                        self.push(
                            Diag::error(&at, "this comment is not closed").label("`*/` is missing"),
                        );
                    } else if let Some(open) = open {
                        let d = Diag::error(open, "this `{` is not closed");
                        self.push(d.label("no matching `}`"));
                    }
                    return root(&c.src).close;
                }
                Lexeme::Mark(b'}') if open.is_some() => return span,
                Lexeme::Mark(b';') => {}
                Lexeme::Mark(b'(') => self.stray_list(c, &span),
                Lexeme::Mark(b'{') if c.take(b'}').is_some() => {
                    let d = Diag::warning(&span, "an empty `{}` without a keyword");
                    self.push(d.label("skipped"));
                }
                Lexeme::Mark(m) => {
                    let m = char::from(m);
                    let d = Diag::error(&span, format!("unexpected `{m}`"));
                    self.push(d.label(if m == '}' {
                        "nothing to close here"
                    } else {
                        "a keyword is needed here"
                    }));
                }
                Lexeme::Punct(m) => {
                    let d = Diag::error(&span, format!("unexpected `{m}`"));
                    self.push(d.label("a keyword is needed here"));
                }
                Lexeme::Label(_) if c.src.text.get(c.at) == Some(&b'(') || lone_count(c) => {
                    c.take(b'(');
                    self.stray_list(c, &span);
                }
                Lexeme::Macro(name) => self.key_macro(c, &name, &span),
                Lexeme::Directive(name) => self.directive(c, &name, &span),
                Lexeme::Expression(_) | Lexeme::Verbatim { .. } => {
                    self.push(
                        Diag::error(&span, "a keyword is needed here").label("not a keyword"),
                    );
                }
                Lexeme::Str { text, closed } => {
                    self.check_quote(closed, &span);
                    let text = self.expand_text(&text, &span);
                    let (pattern, why) = Pattern::new(&text);
                    if let Some(why) = why {
                        let d =
                            Diag::error(&span, format!("this key is no regular expression: {why}"));
                        self.push(d.label("cannot be matched"));
                    }
                    self.value(c, Key::Regex(pattern), span);
                }
                Lexeme::Template(text) => {
                    let text = self.expand_text(&text, &span);
                    self.value(c, Key::Word(text), span);
                }
                Lexeme::Word(_) | Lexeme::Number(_) | Lexeme::Label(_) => {
                    let key = Key::Word(span.text().into_owned());
                    self.value(c, key, span);
                }
            }
        }
    }
    pub(crate) fn check_quote(&mut self, closed: bool, span: &Span) {
        if !closed {
            let d = Diag::error(span, "this text in quotes is not closed on its line");
            self.push(d.label("`\"` is missing"));
        }
    }
    /// A list where a keyword is needed: one message, not one a number.
    fn stray_list(&mut self, c: &mut Cursor, span: &Span) {
        let d = Diag::error(span, "a list stands where a keyword is needed").label("not a keyword");
        self.push(d.help("give it a name: `name ( ... );`"));
        let quiet = std::mem::replace(&mut self.silent, true);
        let _ = self.list(c, span);
        self.silent = quiet;
    }

    /// The value of `key` and the entry's end.
    pub(crate) fn value(&mut self, c: &mut Cursor, key: Key, key_span: Span) {
        let gaps = self.gaps;
        if let Some(open) = c.take(b'{') {
            let from = match (self.here().same_key(&key), self.mode) {
                (Some(i), mode) if mode != InputMode::Overwrite => {
                    match &self.here().entries[i].value {
                        Value::Dict(old) => Some(old.clone()),
                        Value::Stream(_) => None,
                    }
                }
                _ => None,
            };
            let Some(dict) = self.block(c, key.text().to_owned(), open, from) else { return };
            if key.text() == "FoamFile" && self.scopes.len() == 1 {
                if dict.word("format") == Some("binary") {
                    c.binary = Some(Arch::parse(dict.word("arch").unwrap_or("")));
                }
                if self.open_files.len() > 1 {
                    return;
                }
            }
            // In the guarding modes an existing dictionary is still merged into, entry by entry.
            let value = Value::Dict(dict);
            match self.here().same_key(&key) {
                Some(i) if self.mode != InputMode::Overwrite => {
                    self.here().entries[i].value = value
                }
                _ => self.here().insert(Entry::new(key, key_span, value)),
            }
            return;
        }
        let mut out: Vec<Token> = Vec::new();
        let mut last = key_span.clone();
        loop {
            let (lexeme, span) = c.peek();
            match lexeme {
                Lexeme::Mark(b';') => {
                    c.at = span.range.end;
                    break;
                }
                Lexeme::End | Lexeme::Mark(b'}') => {
                    self.missing_semicolon(&key, &last, None);
                    break;
                }
                Lexeme::Mark(b'{') => {
                    // `a 1` newline `b {`: the word before the brace is the next keyword.
                    if let Some(word) = self.swallowed_key(&out, &key_span, c) {
                        out.pop();
                        c.at = word.range.start;
                        last = out.last().map_or(key_span.clone(), |t| t.span.clone());
                        self.missing_semicolon(&key, &last, Some(&word.text()));
                        break;
                    }
                    c.at = span.range.end;
                    let Some(d) = self.block(c, String::new(), span.clone(), None) else { break };
                    out.push(Token { kind: Tok::Dict(d), span });
                }
                _ => {
                    if self.item(c, &mut out).is_err() {
                        c.take(b';');
                        break;
                    }
                }
            }
            last = Span::new(&c.src, c.at.saturating_sub(1)..c.at);
        }
        if self.gaps > gaps {
            self.here().incomplete = true;
            return;
        }
        // `key $dict;` copies a dictionary.
        let value = match out.as_slice() {
            [Token { kind: Tok::Dict(d), .. }] => Value::Dict(d.clone()),
            _ => Value::Stream(out),
        };
        self.add(Entry::new(key, key_span, value));
    }
    /// The span of the last token, when it is a word of this file at the start of a line.
    fn swallowed_key(&self, out: &[Token], key_span: &Span, c: &Cursor) -> Option<Span> {
        let (last, before) = out.split_last()?;
        let prev = before.last().map_or(key_span, |t| &t.span);
        let here = Arc::ptr_eq(&last.span.src, &c.src) && last.word().is_some();
        (here && prev.line_break_before(&last.span)).then(|| last.span.clone())
    }
    /// A number that can be represented, or NaN after saying that it cannot.
    fn in_range(&mut self, x: f64, span: &Span) -> f64 {
        if x.is_finite() {
            return x;
        }
        self.push(Diag::error(span, scan::OUT_OF_RANGE).label(scan::TOO_LARGE));
        f64::NAN
    }
    fn missing_semicolon(&mut self, key: &Key, last: &Span, next: Option<&str>) {
        let d =
            Diag::error(&last.after(), format!("missing `;` after entry `{}`", brief(key.text())));
        let help = next.map(|n| format!("`{}` on the next line was read as part of it", brief(n)));
        self.push(d.label("expected `;` here").maybe_help(help));
    }
    /// The inside of `{ }` whose brace was taken; continues `from` when the key occurs again.
    pub(crate) fn block(
        &mut self,
        c: &mut Cursor,
        name: String,
        open: Span,
        from: Option<Dict>,
    ) -> Option<Dict> {
        if self.too_deep(c, &open) {
            return None;
        }
        self.depth += 1;
        let mut dict = from.unwrap_or_default();
        dict.open = open.clone();
        self.scopes.push(Scope { name, dict });
        let close = self.entries(c, Some(&open));
        self.depth -= 1;
        let mut dict = self.scopes.pop()?.dict;
        dict.close = close;
        Some(dict)
    }

    /// One piece of a stream or list, appended to `out`.
    pub(crate) fn item(&mut self, c: &mut Cursor, out: &mut Vec<Token>) -> Result<(), Broken> {
        let (lexeme, span) = c.next();
        let kind = match lexeme {
            Lexeme::Word(w) => match typed(&w) {
                Some(elem) => return self.typed_list(c, w, elem, span, out),
                None => Tok::Word(w),
            },
            Lexeme::Template(t) => Tok::Word(self.expand_text(&t, &span)),
            Lexeme::Str { text, closed } => {
                self.check_quote(closed, &span);
                Tok::Str(text)
            }
            Lexeme::Verbatim { text, closed } => {
                if !closed {
                    self.push(
                        Diag::error(&span, "verbatim text is not closed").label("`#}` is missing"),
                    );
                }
                Tok::Verbatim(text)
            }
            Lexeme::Number(x) => Tok::Number(self.in_range(x, &span)),
            Lexeme::Label(n) => return self.counted(c, n, span, out),
            Lexeme::Punct(m) => Tok::Punct(m),
            Lexeme::Mark(b'(') => {
                let (kind, close) = self.list(c, &span)?;
                out.push(Token { kind, span: span.to(&close) });
                return Ok(());
            }
            Lexeme::Mark(b'[') => return self.bracket(c, span, out),
            Lexeme::Mark(b'{') => {
                let name = out.last().and_then(Token::word).unwrap_or("").to_owned();
                let d = self.block(c, name, span.clone(), None).ok_or(Broken)?;
                let span = span.to(&d.close);
                out.push(Token { kind: Tok::Dict(d), span });
                return Ok(());
            }
            Lexeme::Macro(name) => {
                self.value_macro(&name, &span, out);
                return Ok(());
            }
            Lexeme::Expression(text) => {
                let kind = self.arithmetic(&text, &span, span.range.start + 3, false);
                kind.unwrap_or(Tok::Number(f64::NAN))
            }
            Lexeme::Directive(name) => {
                self.value_directive(c, &name, &span, out);
                return Ok(());
            }
            Lexeme::Mark(m) => {
                let m = char::from(m);
                self.push(
                    Diag::error(&span, format!("unexpected `{m}`")).label("nothing to close here"),
                );
                return Ok(());
            }
            Lexeme::End => return Err(Broken),
        };
        out.push(Token { kind, span });
        Ok(())
    }
}

/// Whether the only thing left is a list, as in `points` files.
fn lone_count(c: &Cursor) -> bool {
    let b = &c.src.text;
    b.get(scan::space(b, c.at)) == Some(&b'(')
}

/// Where a comment starts that runs to the end of the file without being closed.
fn scan_comment_start(b: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    while at < b.len() {
        if b[at] == b'/' {
            if scan::unclosed_comment(b, at) {
                return Some(at);
            }
            at = scan::space(b, at).max(at + 1);
        } else {
            at += 1;
        }
    }
    None
}
