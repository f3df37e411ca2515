//! Values read by position: `Gauss limitedLinear 1`, `hex (0 1 2 3 4 5 6 7) (10 10 1) ..`.

use super::values::known;
use super::{Node, Reader};
use crate::diag::{Diag, Sink};
use crate::source::Span;
use crate::tree::{Dict, Entry, Token, Value};
use granflow_base::Vec3;
use std::rc::Rc;

/// Takes the tokens of a value or the items of a list one after the other.
pub struct TokenReader<'a> {
    tokens: &'a [Token],
    at: usize,
    end: Span,
    what: String,
    sink: Sink,
    /// The entry whose whole value this is, and its reader.
    entry: Option<(&'a Entry, Reader<'a>)>,
    owner: Option<Rc<Node<'a>>>,
}

impl<'a> TokenReader<'a> {
    /// A reader of `tokens`; `end` is where what is missing would have to be, `what` names the
    /// whole in messages.
    pub fn new(tokens: &'a [Token], end: Span, what: &str, sink: &Sink) -> TokenReader<'a> {
        let (what, sink) = (what.to_owned(), sink.clone());
        TokenReader { tokens, at: 0, end, what, sink, entry: None, owner: None }
    }
    pub(super) fn of_entry(
        r: &Reader<'a>,
        e: &'a Entry,
        t: &'a [Token],
        end: Span,
        key: &str,
    ) -> Self {
        let mut out = TokenReader::new(t, end, key, r.sink());
        out.entry = Some((e, r.clone()));
        out.owner = Some(r.node.clone());
        out
    }
    pub(super) fn inside(r: &Reader<'a>, items: &'a [Token], list: &Token, key: &str) -> Self {
        let mut out = TokenReader::new(items, close_of(list), key, r.sink());
        out.owner = Some(r.node.clone());
        out
    }
    fn nested(&self, list: &'a Token) -> Option<TokenReader<'a>> {
        let mut out = TokenReader::new(list.list()?, close_of(list), &self.what, &self.sink);
        out.owner = self.owner.clone();
        Some(out)
    }
    /// Whether everything was taken.
    pub fn is_empty(&self) -> bool {
        self.at >= self.tokens.len()
    }
    /// The next token, left in place.
    pub fn peek(&self) -> Option<&'a Token> {
        self.tokens.get(self.at)
    }
    /// Takes the next token.
    #[allow(clippy::should_implement_trait, reason = "an iterator could not be read by kind")]
    pub fn next(&mut self) -> Option<&'a Token> {
        let t = self.tokens.get(self.at)?;
        self.at += 1;
        Some(t)
    }
    /// What was not taken yet.
    pub fn rest(&self) -> &'a [Token] {
        &self.tokens[self.at.min(self.tokens.len())..]
    }
    /// The place of the next token, or of the end.
    pub fn here(&self) -> Span {
        self.peek().map_or_else(|| self.end.clone(), |t| t.span.clone())
    }
    /// The place of the token taken last, or of the next one when none was.
    pub fn last_span(&self) -> Span {
        match self.at.checked_sub(1).and_then(|i| self.tokens.get(i)) {
            Some(t) => t.span.clone(),
            None => self.here(),
        }
    }
    /// An error at the next token.
    pub fn error(&self, message: impl Into<String>, label: impl Into<String>, help: Option<&str>) {
        self.error_at(&self.here(), message, label, help);
    }
    /// An error at a place.
    pub fn error_at(
        &self,
        at: &Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<&str>,
    ) {
        self.sink.push(Diag::error(at, message).label(label).maybe_help(help));
    }
    fn opt<T>(&mut self, get: impl Fn(&'a Token) -> Option<T>) -> Option<T> {
        let v = get(self.peek()?)?;
        self.at += 1;
        Some(v)
    }
    /// Takes a token of the kind `get` wants, or reports that `what` (of this kind) is missing.
    fn need<T>(
        &mut self,
        what: &str,
        kind: &str,
        get: impl Fn(&'a Token) -> Option<T>,
    ) -> Option<T> {
        let Some(t) = self.peek() else {
            let d = Diag::error(&self.end, format!("`{}` ends where {what} is needed", self.what));
            self.sink.push(d.label(format!("expected {kind}")));
            return None;
        };
        self.at += 1;
        let v = get(t);
        if v.is_none() {
            let d = Diag::error(&t.span, format!("{what} must be {kind}, found {}", t.describe()));
            self.sink.push(d.label(format!("expected {kind}")));
        }
        v
    }
    /// A bare word; empty on error. `what` names it in the message: "the limiter".
    pub fn word(&mut self, what: &str) -> &'a str {
        self.need(what, "a word", Token::word).unwrap_or("")
    }
    /// A word or quoted text; empty on error.
    pub fn string(&mut self, what: &str) -> &'a str {
        self.need(what, "a text", Token::text).unwrap_or("")
    }
    /// A number; NaN on error.
    pub fn number(&mut self, what: &str) -> f64 {
        self.need(what, "a number", Token::number).unwrap_or(f64::NAN)
    }
    /// A whole number; 0 on error.
    pub fn label(&mut self, what: &str) -> i64 {
        self.need(what, "a whole number", Token::label).unwrap_or(0)
    }
    /// A vector; NaN on error.
    pub fn vector(&mut self, what: &str) -> Vec3 {
        self.need(what, "a vector `(x y z)`", Token::vec3).unwrap_or([f64::NAN; 3])
    }
    /// One of the named choices; `None` on error.
    pub fn one_of<T: Clone>(&mut self, what: &str, choices: &[(&str, T)]) -> Option<T> {
        let at = self.here();
        let w = self.need(what, "a word", Token::text)?;
        let found = choices.iter().find(|c| c.0 == w).map(|c| c.1.clone());
        if found.is_none() {
            let d = Diag::error(&at, format!("unknown value `{w}` for {what}"));
            self.sink.push(d.label("not known").help(known(w, choices)));
        }
        found
    }
    /// The inside of a list.
    pub fn list(&mut self, what: &str) -> Option<TokenReader<'a>> {
        let t = self.need(what, "a list", |t| t.list().map(|_| t))?;
        self.nested(t)
    }
    /// A dictionary of the list.
    pub fn dict(&mut self, what: &str) -> Option<Reader<'a>> {
        let d = self.need(what, "a sub-dictionary", Token::dict)?;
        Some(self.reader(d, what))
    }
    fn reader(&self, d: &'a Dict, name: &str) -> Reader<'a> {
        let node = match &self.owner {
            Some(o) => o.child(d, name),
            None => Node::new(d, name.to_owned()),
        };
        Reader { node, sink: self.sink.clone() }
    }
    /// A bare word, if one comes next.
    pub fn opt_word(&mut self) -> Option<&'a str> {
        self.opt(Token::word)
    }
    /// A number, if one comes next.
    pub fn opt_number(&mut self) -> Option<f64> {
        self.opt(Token::number)
    }
    /// A whole number, if one comes next.
    pub fn opt_label(&mut self) -> Option<i64> {
        self.opt(Token::label)
    }
    /// A vector, if one comes next.
    pub fn opt_vector(&mut self) -> Option<Vec3> {
        self.opt(Token::vec3)
    }
    /// The inside of a list, if one comes next.
    pub fn opt_list(&mut self) -> Option<TokenReader<'a>> {
        let t = self.opt(|t| t.list().map(|_| t))?;
        self.nested(t)
    }
    /// A dictionary, if one comes next; its name in messages is the word before it.
    pub fn opt_dict(&mut self) -> Option<Reader<'a>> {
        let name = self.at.checked_sub(1).and_then(|i| self.tokens[i].word()).unwrap_or("");
        let d = self.opt(Token::dict)?;
        Some(self.reader(d, name))
    }
    /// Reports what was not taken.
    pub fn finish(&self) {
        let Some(t) = self.peek() else { return };
        match &self.entry {
            Some((e, r)) if matches!(&e.value, Value::Stream(_)) => r.surplus(e, self.at),
            _ => {
                let d = Diag::error(
                    &t.span,
                    format!("{} is not expected in `{}`", t.describe(), self.what),
                );
                self.sink.push(d.label("not expected here"));
            }
        }
    }
}

/// The closing parenthesis of a list.
fn close_of(list: &Token) -> Span {
    let r = &list.span.range;
    Span::new(&list.span.src, r.end.saturating_sub(1).max(r.start)..r.end)
}
