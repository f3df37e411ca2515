//! The typed view of a dictionary.
//!
//! Asking for a key takes it; a key nobody asked for is reported by [`Reader::finish`]. Whatever is
//! wrong goes to the shared [`Sink`], and a harmless value comes back, so that one run reports every
//! mistake of a case. Nothing read may be used before the sink was seen to hold no error.

mod field;
mod positional;
mod units;
mod values;

pub use field::FieldValue;
pub use positional::TokenReader;

use crate::diag::{Diag, Severity, Sink};
use crate::nearest;
use crate::source::Span;
use crate::tree::{Dict, Entry, Key, Token, Value, brief};
use std::cell::{Cell, RefCell};
use std::collections::HashSet;
use std::rc::Rc;

/// What was asked of one dictionary, shared by all readers of it below one root reader.
struct Node<'a> {
    dict: &'a Dict,
    name: String,
    asked: RefCell<Vec<String>>,
    taken: RefCell<HashSet<usize>>,
    all: Cell<bool>,
    children: RefCell<Vec<Rc<Node<'a>>>>,
}

impl<'a> Node<'a> {
    fn new(dict: &'a Dict, name: String) -> Rc<Node<'a>> {
        Rc::new(Node {
            dict,
            name,
            asked: RefCell::default(),
            taken: RefCell::default(),
            all: Cell::new(false),
            children: RefCell::default(),
        })
    }
    /// The node of a dictionary inside this one; the same one for the same dictionary.
    fn child(&self, dict: &'a Dict, key: &str) -> Rc<Node<'a>> {
        let mut children = self.children.borrow_mut();
        if let Some(n) = children.iter().find(|n| std::ptr::eq(n.dict, dict)) {
            return n.clone();
        }
        let name =
            if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) };
        let node = Node::new(dict, name);
        children.push(node.clone());
        node
    }
}

/// Typed reads of one dictionary; cheap to clone, clones share what was taken.
#[derive(Clone)]
pub struct Reader<'a> {
    node: Rc<Node<'a>>,
    sink: Sink,
}

impl<'a> Reader<'a> {
    /// A reader of `dict` that reports to `sink`. A `FoamFile` header counts as taken.
    pub fn new(dict: &'a Dict, sink: &Sink) -> Reader<'a> {
        Reader { node: Node::new(dict, String::new()), sink: sink.clone() }
    }
    /// Where mistakes go.
    pub fn sink(&self) -> &Sink {
        &self.sink
    }
    /// The dictionary.
    pub fn dict(&self) -> &'a Dict {
        self.node.dict
    }
    /// Path of keys from the root reader: `solvers.p`; empty at the root.
    pub fn name(&self) -> &str {
        &self.node.name
    }
    /// Whether `key` is there (exactly or by a pattern). Does not take it.
    pub fn has(&self, key: &str) -> bool {
        self.dict().find(key).is_some()
    }
    /// Plain keywords in file order, the header left out. Does not take them.
    pub fn keys(&self) -> Vec<&'a str> {
        let word = |e: &'a Entry| match &e.key {
            Key::Word(w) if w != "FoamFile" => Some(w.as_str()),
            _ => None,
        };
        self.dict().entries.iter().filter_map(word).collect()
    }
    /// The keys that were asked for so far, there or not.
    pub fn asked(&self) -> Vec<String> {
        self.node.asked.borrow().clone()
    }
    /// The entry for `key`, taken; silent when absent.
    pub fn entry(&self, key: &str) -> Option<&'a Entry> {
        let mut asked = self.node.asked.borrow_mut();
        if !asked.iter().any(|k| k == key) {
            asked.push(key.to_owned());
        }
        let i = self.dict().find_index(key)?;
        self.node.taken.borrow_mut().insert(i);
        Some(&self.dict().entries[i])
    }
    /// The tokens for `key`, taken; silent when absent or a sub-dictionary.
    pub fn raw(&self, key: &str) -> Option<&'a [Token]> {
        match &self.entry(key)?.value {
            Value::Stream(t) => Some(t),
            Value::Dict(_) => None,
        }
    }
    /// Takes `key` without reading it.
    pub fn ignore(&self, key: &str) {
        self.entry(key);
    }
    /// Takes an entry of this dictionary whatever its key, of which a later pattern may be the better match.
    pub fn take(&self, entry: &Entry) {
        let i = self.dict().entries.iter().position(|e| std::ptr::eq(e, entry));
        self.node.taken.borrow_mut().extend(i);
    }
    /// Takes every key, here and below.
    pub fn ignore_all(&self) {
        self.node.all.set(true);
    }
    /// The sub-dictionary `key`; an error when absent.
    pub fn sub(&self, key: &str) -> Option<Reader<'a>> {
        match self.entry(key) {
            Some(e) => self.sub_of(e, key),
            None => {
                self.missing(key, &format!("add `{key} {{ ... }}`"));
                None
            }
        }
    }
    /// The sub-dictionary `key`, if it is there.
    pub fn opt_sub(&self, key: &str) -> Option<Reader<'a>> {
        self.entry(key).and_then(|e| self.sub_of(e, key))
    }
    /// All sub-dictionaries with a plain keyword, taken, in file order.
    pub fn subs(&self) -> Vec<(&'a str, Reader<'a>)> {
        let dicts = |e: &'a Entry| match (&e.key, &e.value) {
            (Key::Word(w), Value::Dict(_)) if w != "FoamFile" => Some(w.as_str()),
            _ => None,
        };
        let keys: Vec<&str> = self.dict().entries.iter().filter_map(dicts).collect();
        keys.into_iter().filter_map(|k| Some((k, self.opt_sub(k)?))).collect()
    }
    fn sub_of(&self, e: &'a Entry, key: &str) -> Option<Reader<'a>> {
        match &e.value {
            Value::Dict(d) => {
                Some(Reader { node: self.node.child(d, key), sink: self.sink.clone() })
            }
            Value::Stream(t) => {
                let at = t.first().map_or(&e.key_span, |t| &t.span);
                let found = t.first().map_or("nothing".into(), Token::describe);
                let d = Diag::error(at, format!("`{key}` must be a sub-dictionary, found {found}"));
                self.sink.push(d.label("expected `{`"));
                None
            }
        }
    }

    // ---- places and messages

    /// Where the keyword stands; the closing brace when it is absent.
    pub fn key_span(&self, key: &str) -> Span {
        self.dict().find(key).map_or_else(|| self.dict().close.clone(), |e| e.key_span.clone())
    }
    /// Where the value stands (a sub-dictionary: its keyword); the closing brace when absent.
    pub fn value_span(&self, key: &str) -> Span {
        match self.dict().find(key) {
            None => self.dict().close.clone(),
            Some(e) => match &e.value {
                Value::Stream(t) => match (t.first(), t.last()) {
                    (Some(a), Some(b)) => a.span.to(&b.span),
                    _ => e.key_span.clone(),
                },
                Value::Dict(_) => e.key_span.clone(),
            },
        }
    }
    /// An error about the value of `key`.
    pub fn error_at_key(
        &self,
        key: &str,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<&str>,
    ) {
        self.error_at(&self.value_span(key), message, label, help);
    }
    /// A warning about the value of `key`.
    pub fn warn_at_key(
        &self,
        key: &str,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<&str>,
    ) {
        self.warn_at(&self.value_span(key), message, label, help);
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
    /// A warning at a place.
    pub fn warn_at(
        &self,
        at: &Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<&str>,
    ) {
        self.sink.push(Diag::warning(at, message).label(label).maybe_help(help));
    }
    /// An error about the dictionary as a whole, shown at its end.
    pub fn error_here(
        &self,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<&str>,
    ) {
        self.error_at(&self.dict().close, message, label, help);
    }
    /// ` in `solvers.p``, or nothing at the root.
    fn inside(&self) -> String {
        if self.name().is_empty() { String::new() } else { format!(" in `{}`", self.name()) }
    }
    /// Reports that `key` is absent, or that a missing `;` hides it.
    fn missing(&self, key: &str, help: &str) {
        if self.dict().incomplete {
            return;
        }
        for e in &self.dict().entries {
            if let Value::Stream(t) = &e.value
                && let Some(i) =
                    (0..t.len()).find(|&i| t[i].word() == Some(key) && fresh_line(e, t, i))
            {
                self.swallowed(e, t, i);
                return;
            }
        }
        let asked = self.node.asked.borrow();
        let unread = self.keys().into_iter().filter(|k| !asked.iter().any(|a| a == k));
        let help = match nearest(key, unread) {
            Some(n) => format!("`{n}` is there; did you mean `{key}`?"),
            None => help.to_owned(),
        };
        let d = Diag::error(&self.dict().close, format!("missing entry `{key}`{}", self.inside()));
        let top = self.dict().close.range.is_empty();
        let label = if top {
            "not found before the end of this file"
        } else {
            "not found before this brace"
        };
        self.sink.push(d.label(label).help(help));
    }
    /// Token `i` of the entry stands on a line of its own: the `;` before it is missing.
    fn swallowed(&self, e: &Entry, t: &[Token], i: usize) {
        let last = if i == 0 { &e.key_span } else { &t[i - 1].span };
        let next = t[i].text().map_or_else(|| t[i].describe(), |w| format!("`{}`", brief(w)));
        // Several lines may be swallowed: name the one whose end lacks its `;`.
        let head = (0..i).rev().find(|&j| fresh_line(e, t, j)).and_then(|j| t[j].word());
        let head = brief(head.unwrap_or(e.key.text()));
        let d = Diag::error(&last.after(), format!("missing `;` after entry `{head}`"));
        let help = format!("{next} on the next line was read as part of it");
        self.sink.push(d.label("expected `;` here").help(help));
    }
    /// Complains about tokens from `i` on, which the value does not need.
    fn surplus(&self, e: &Entry, i: usize) {
        let Value::Stream(t) = &e.value else { return };
        if i >= t.len() {
            return;
        }
        if t[i].word().is_some() && fresh_line(e, t, i) {
            self.swallowed(e, t, i);
        } else {
            let (key, what) = (brief(e.key.text()), t[i].describe());
            let text = format!("{what} is not expected after the value of `{key}`");
            let comma = i > 0 && t[i - 1].number().is_some() && t[i].span.text().starts_with(',');
            let help = comma.then_some("decimals are written with a point");
            let d = Diag::error(&t[i].span, text).maybe_help(help);
            self.sink.push(d.label("expected `;` before this"));
        }
    }

    /// Reports every key nobody asked for as an error or a warning, here and in all
    /// sub-dictionaries opened through this reader. To be called when all reading of it is done: a
    /// later call, of the dictionary around it too, has no more to say.
    pub fn finish(&self, unknown: Severity) {
        finish(&self.node, &self.sink, unknown);
    }
}

/// Whether token `i` starts a line.
fn fresh_line(e: &Entry, t: &[Token], i: usize) -> bool {
    let last = if i == 0 { &e.key_span } else { &t[i - 1].span };
    last.line_break_before(&t[i].span)
}

fn finish(node: &Node<'_>, sink: &Sink, unknown: Severity) {
    if node.all.get() {
        return;
    }
    let (taken, asked) = (node.taken.borrow(), node.asked.borrow());
    for (i, e) in node.dict.entries.iter().enumerate() {
        let key = e.key.text();
        if taken.contains(&i) || e.referenced || (key == "FoamFile" && node.name.is_empty()) {
            continue;
        }
        let known = asked.iter().map(String::as_str).filter(|k| node.dict.find(k).is_none());
        let inside =
            if node.name.is_empty() { String::new() } else { format!(" in `{}`", node.name) };
        // A pattern that matches nothing asked for does no harm.
        let severity = if matches!(e.key, Key::Regex(_)) { Severity::Warning } else { unknown };
        let d = match severity {
            Severity::Error => {
                Diag::error(&e.key_span, format!("unknown entry `{}`{inside}", brief(key)))
            }
            Severity::Warning => {
                Diag::warning(&e.key_span, format!("unused entry `{}`{inside}", brief(key)))
            }
        };
        let near = nearest(key, known).map(|n| format!("did you mean `{n}`?"));
        sink.push(d.label("nothing reads this").maybe_help(near));
    }
    for child in node.children.borrow().iter() {
        finish(child, sink, unknown);
    }
    node.all.set(true);
}
