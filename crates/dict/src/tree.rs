//! The tree a dictionary parses into: macros and includes are already expanded in it.

use crate::lists::Payload;
use crate::source::Span;
use granflow_base::Vec3;
use regex::bytes::{Regex, RegexBuilder};
use std::collections::HashSet;
use std::sync::Arc;

/// The entries of one `{ }` or of a whole file.
#[derive(Clone, Debug, PartialEq)]
pub struct Dict {
    /// In file order; no key occurs twice.
    pub entries: Vec<Entry>,
    /// The opening brace; the start of a file.
    pub open: Span,
    /// The closing brace; the end of a file.
    pub close: Span,
    /// Whether entries are missing because an include was refused, which was said: that they are
    /// missing is no mistake of its own.
    pub incomplete: bool,
}

/// One keyword with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The keyword.
    pub key: Key,
    /// Where it stands.
    pub key_span: Span,
    /// What it is given.
    pub value: Value,
    /// Whether a `$macro` stands for it somewhere: then it is in use even if nothing reads it.
    pub referenced: bool,
}

impl Entry {
    /// An entry that no macro stands for.
    pub fn new(key: Key, key_span: Span, value: Value) -> Entry {
        Entry { key, key_span, value, referenced: false }
    }
}

/// A keyword: a plain word, or a regular expression in double quotes.
#[derive(Clone, Debug, PartialEq)]
pub enum Key {
    /// `U`, `div(phi,U)`.
    Word(String),
    /// `"(U|p).*"`.
    Regex(Pattern),
}

impl Key {
    /// The word, or the pattern without its quotes.
    pub fn text(&self) -> &str {
        match self {
            Key::Word(w) => w,
            Key::Regex(p) => &p.text,
        }
    }
    /// Whether the key stands for `word`.
    pub fn matches(&self, word: &str) -> bool {
        match self {
            Key::Word(w) => w == word,
            Key::Regex(p) => {
                p.text == word || p.regex.as_ref().is_some_and(|r| r.is_match(word.as_bytes()))
            }
        }
    }
}

/// A regular expression used as a key; it must match a whole word.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// As written between the quotes.
    pub text: String,
    regex: Option<Regex>,
}

impl Pattern {
    /// Compiles a pattern; the second value says why it is no regular expression, in which case
    /// the pattern matches only itself.
    pub fn new(text: &str) -> (Pattern, Option<String>) {
        // Bytes without Unicode tables: `(?i)` then needs none, and keys are ASCII.
        match RegexBuilder::new(&format!("^(?:{text})$")).unicode(false).build() {
            Ok(r) => (Pattern { text: text.to_owned(), regex: Some(r) }, None),
            Err(e) => {
                let why = e.to_string();
                let why = why.lines().last().unwrap_or("").trim_start_matches("error: ").to_owned();
                (Pattern { text: text.to_owned(), regex: None }, Some(why))
            }
        }
    }
}
impl PartialEq for Pattern {
    fn eq(&self, o: &Pattern) -> bool {
        self.text == o.text
    }
}

/// What a keyword is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `key a b (c d);`
    Stream(Vec<Token>),
    /// `key { .. }`
    Dict(Dict),
}

/// A piece of a stream with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// What it is.
    pub kind: Tok,
    /// Where it was written (for an expanded macro: in its definition).
    pub span: Span,
}

/// Kinds of token.
#[derive(Clone, Debug, PartialEq)]
pub enum Tok {
    /// A bare word.
    Word(String),
    /// A text in double quotes, without them.
    Str(String),
    /// `#{ .. #}`, without the marks.
    Verbatim(String),
    /// A number that is not a whole number.
    Number(f64),
    /// A whole number.
    Label(i64),
    /// A character with no other meaning here.
    Punct(char),
    /// `[ .. ]`, dimensions.
    Bracket(Vec<Token>),
    /// `( .. )`, nested.
    List(Vec<Token>),
    /// `{ .. }` inside a list; its name, if any, is the word before.
    Dict(Dict),
    /// A numeric list that is long or was written with its type: `List<scalar> 3(1 2 3)`.
    Packed(Arc<Payload>),
}

impl Dict {
    /// An empty dictionary that no file holds.
    pub fn new() -> Dict {
        Dict { entries: Vec::new(), open: Span::none(), close: Span::none(), incomplete: false }
    }
    /// The entry for `key`: an exact keyword first, else the last regular expression that matches.
    pub fn find(&self, key: &str) -> Option<&Entry> {
        self.find_index(key).map(|i| &self.entries[i])
    }
    pub(crate) fn find_index(&self, key: &str) -> Option<usize> {
        let exact = |e: &Entry| matches!(&e.key, Key::Word(w) if w == key);
        self.entries
            .iter()
            .position(exact)
            .or_else(|| self.entries.iter().rposition(|e| e.key.matches(key)))
    }
    /// The value for `key`.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.find(key).map(|e| &e.value)
    }
    /// The sub-dictionary for `key`.
    pub fn sub(&self, key: &str) -> Option<&Dict> {
        match self.get(key) {
            Some(Value::Dict(d)) => Some(d),
            _ => None,
        }
    }
    /// The tokens for `key`.
    pub fn stream(&self, key: &str) -> Option<&[Token]> {
        match self.get(key) {
            Some(Value::Stream(t)) => Some(t),
            _ => None,
        }
    }
    /// The first token for `key`, when it is a word or a quoted text.
    pub fn word(&self, key: &str) -> Option<&str> {
        self.stream(key)?.first()?.text()
    }
    /// The first token for `key`, when it is a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.stream(key)?.first()?.number()
    }
    /// The `FoamFile` header.
    pub fn header(&self) -> Option<&Dict> {
        self.sub("FoamFile")
    }
    /// Replaces or appends the plain keyword `key`.
    pub fn set(&mut self, key: &str, value: impl Into<Value>) {
        let entry = Entry::new(Key::Word(key.to_owned()), Span::none(), value.into());
        self.insert(entry);
    }
    /// Removes the keyword written exactly `key`.
    pub fn remove(&mut self, key: &str) -> Option<Entry> {
        let i = self.entries.iter().position(|e| e.key.text() == key)?;
        Some(self.entries.remove(i))
    }
    /// Position of an entry with the same keyword (not: a matching one).
    pub(crate) fn same_key(&self, key: &Key) -> Option<usize> {
        self.entries.iter().position(|e| e.key == *key)
    }
    /// Marks the entries whose keywords macros have stood for, on every level.
    pub(crate) fn mark_referenced(&mut self, names: &HashSet<String>) {
        for e in &mut self.entries {
            e.referenced = names.contains(e.key.text());
            if let Value::Dict(d) = &mut e.value {
                d.mark_referenced(names);
            }
        }
    }
    /// Replaces the entry with the same keyword or appends.
    pub(crate) fn insert(&mut self, entry: Entry) {
        match self.same_key(&entry.key) {
            Some(i) => self.entries[i] = entry,
            None => self.entries.push(entry),
        }
    }
    /// Takes over all entries of `other`, merging sub-dictionaries.
    pub(crate) fn merge(&mut self, other: Dict) {
        for e in other.entries {
            let Some(i) = self.same_key(&e.key) else {
                self.entries.push(e);
                continue;
            };
            match (&mut self.entries[i].value, e.value) {
                (Value::Dict(old), Value::Dict(new)) => old.merge(new),
                (_, value) => self.entries[i] = Entry { value, ..e },
            }
        }
    }
}
impl Default for Dict {
    fn default() -> Self {
        Dict::new()
    }
}

impl Token {
    /// A token that no file holds.
    pub fn generated(kind: Tok) -> Token {
        Token { kind, span: Span::none() }
    }
    /// A generated word.
    pub fn of_word(w: &str) -> Token {
        Token::generated(Tok::Word(w.to_owned()))
    }
    /// A generated quoted text.
    pub fn of_str(s: &str) -> Token {
        Token::generated(Tok::Str(s.to_owned()))
    }
    /// A generated number; a whole number becomes a label, as when it is read back.
    pub fn of_number(x: f64) -> Token {
        Token::generated(number_kind(x))
    }
    /// A generated whole number.
    pub fn of_label(i: i64) -> Token {
        Token::generated(Tok::Label(i))
    }
    /// A generated list.
    pub fn of_list(items: Vec<Token>) -> Token {
        Token::generated(Tok::List(items))
    }
    /// A generated vector `(x y z)`.
    pub fn of_vec3(v: Vec3) -> Token {
        Token::of_list(v.iter().map(|&x| Token::of_number(x)).collect())
    }
    /// The bare word.
    pub fn word(&self) -> Option<&str> {
        match &self.kind {
            Tok::Word(w) => Some(w),
            _ => None,
        }
    }
    /// The bare word or quoted text.
    pub fn text(&self) -> Option<&str> {
        match &self.kind {
            Tok::Word(w) | Tok::Str(w) => Some(w),
            _ => None,
        }
    }
    /// The number, whole or not.
    pub fn number(&self) -> Option<f64> {
        match &self.kind {
            Tok::Number(x) => Some(*x),
            Tok::Label(i) => Some(*i as f64),
            _ => None,
        }
    }
    /// The whole number.
    pub fn label(&self) -> Option<i64> {
        match &self.kind {
            Tok::Label(i) => Some(*i),
            _ => None,
        }
    }
    /// The items of a list that is not packed.
    pub fn list(&self) -> Option<&[Token]> {
        match &self.kind {
            Tok::List(items) => Some(items),
            Tok::Packed(p) if p.is_empty() => Some(&[]),
            _ => None,
        }
    }
    /// The dictionary inside a list.
    pub fn dict(&self) -> Option<&Dict> {
        match &self.kind {
            Tok::Dict(d) => Some(d),
            _ => None,
        }
    }
    /// `(x y z)`.
    pub fn vec3(&self) -> Option<Vec3> {
        match &self.kind {
            Tok::List(items) => match items.as_slice() {
                [x, y, z] => Some([x.number()?, y.number()?, z.number()?]),
                _ => None,
            },
            Tok::Packed(_) => self.scalars()?.try_into().ok(),
            _ => None,
        }
    }
    /// A list of numbers.
    pub fn scalars(&self) -> Option<Vec<f64>> {
        match &self.kind {
            Tok::List(items) => items.iter().map(Token::number).collect(),
            Tok::Packed(p) => match &**p {
                Payload::Scalars(s) => Some(s.clone()),
                Payload::Labels(l) => Some(l.iter().map(|&i| i as f64).collect()),
                p if p.is_empty() => Some(Vec::new()),
                _ => None,
            },
            _ => None,
        }
    }
    /// A list of whole numbers.
    pub fn labels(&self) -> Option<Vec<i64>> {
        match &self.kind {
            Tok::List(items) => items.iter().map(Token::label).collect(),
            Tok::Packed(p) => match &**p {
                Payload::Labels(l) => Some(l.clone()),
                p if p.is_empty() => Some(Vec::new()),
                _ => None,
            },
            _ => None,
        }
    }
    /// A list of vectors.
    pub fn vectors(&self) -> Option<Vec<Vec3>> {
        match &self.kind {
            Tok::List(items) => items.iter().map(Token::vec3).collect(),
            Tok::Packed(p) => match &**p {
                Payload::Vectors(v) => Some(v.clone()),
                p if p.is_empty() => Some(Vec::new()),
                _ => None,
            },
            _ => None,
        }
    }
    /// A list of words or quoted texts.
    pub fn words(&self) -> Option<Vec<&str>> {
        self.list()?.iter().map(Token::text).collect()
    }
    /// What the token is, for messages: "the word `x`".
    pub fn describe(&self) -> String {
        match &self.kind {
            Tok::Word(w) => format!("the word `{}`", brief(w)),
            Tok::Str(s) => format!("the text \"{}\"", brief(s)),
            Tok::Verbatim(_) => "verbatim text".into(),
            Tok::Number(x) => format!("the number {}", crate::writer::number(*x)),
            Tok::Label(i) => format!("the number {i}"),
            Tok::Punct(c) => format!("`{c}`"),
            Tok::Bracket(_) => "dimensions".into(),
            Tok::List(items) if items.is_empty() => "an empty list".into(),
            Tok::List(items) => match items.len() {
                1 => "a list of 1 item".into(),
                n => format!("a list of {n} items"),
            },
            Tok::Dict(_) => "a sub-dictionary".into(),
            Tok::Packed(p) => p.describe(),
        }
    }
}

/// A number as the lexer would read it back.
pub(crate) fn number_kind(x: f64) -> Tok {
    // Whole numbers beyond 2^53 are not all exact; they stay floating point.
    if x == x.trunc() && x.abs() < 9.0e15 && !(x == 0.0 && x.is_sign_negative()) {
        Tok::Label(x as i64)
    } else {
        Tok::Number(x)
    }
}

/// Cuts long texts in messages.
pub(crate) fn brief(s: &str) -> String {
    const MAX: usize = 60;
    if s.chars().count() <= MAX {
        return s.to_owned();
    }
    s.chars().take(MAX - 1).chain(['…']).collect()
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        Value::Stream(vec![Token::of_number(x)])
    }
}
impl From<i64> for Value {
    fn from(i: i64) -> Self {
        Value::Stream(vec![Token::of_label(i)])
    }
}
impl From<&str> for Value {
    /// A bare word.
    fn from(w: &str) -> Self {
        Value::Stream(vec![Token::of_word(w)])
    }
}
impl From<Vec<Token>> for Value {
    fn from(t: Vec<Token>) -> Self {
        Value::Stream(t)
    }
}
impl From<Dict> for Value {
    fn from(d: Dict) -> Self {
        Value::Dict(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_keys_beat_patterns_and_later_patterns_beat_earlier() {
        let mut d = Dict::new();
        for (pattern, v) in [("(U|p)", 1.0), ("p.*", 2.0)] {
            let key = Key::Regex(Pattern::new(pattern).0);
            d.insert(Entry::new(key, Span::none(), v.into()));
        }
        d.set("U", 3.0);
        assert_eq!(d.number("U"), Some(3.0));
        assert_eq!(d.number("p"), Some(2.0));
        assert_eq!(d.number("pFinal"), Some(2.0));
        assert_eq!(d.number("Up"), None, "patterns match whole words");
    }

    #[test]
    fn a_broken_pattern_says_why_and_matches_itself() {
        let (p, why) = Pattern::new("(U|p");
        assert!(why.is_some_and(|w| w.contains("unclosed group")));
        assert!(Key::Regex(p).matches("(U|p"));
    }
}
