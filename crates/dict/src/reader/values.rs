//! Reads of numbers, words, choices, vectors and lists.

use super::{Reader, TokenReader, units};
use crate::diag::Diag;
use crate::nearest;
use crate::tree::{Entry, Tok, Token, Value};
use granflow_base::{Dims, Tensor, Vec3, unit};
use std::ops::RangeInclusive;

const NAN3: Vec3 = [f64::NAN; 3];

impl<'a> Reader<'a> {
    /// The tokens of an entry; an error for a sub-dictionary or an empty value.
    fn stream(&self, e: &'a Entry, what: &str) -> Option<&'a [Token]> {
        let key = e.key.text();
        match &e.value {
            Value::Stream(t) if t.is_empty() => {
                // Such as a macro that is not defined: that was said.
                if self.sink().blames(&e.key_span) {
                    return None;
                }
                let d = Diag::error(&e.key_span.after(), format!("`{key}` has no value"));
                self.sink().push(d.label(format!("expected {what}")));
                None
            }
            Value::Stream(t) => Some(t),
            Value::Dict(_) => {
                let d = Diag::error(
                    &e.key_span,
                    format!("`{key}` must be {what}, found a sub-dictionary"),
                );
                self.sink().push(d.label(format!("expected {what}")));
                None
            }
        }
    }
    fn not_a(&self, key: &str, t: &Token, what: &str) {
        if self.entry(key).is_some_and(|e| self.sink().blames(&e.key_span)) {
            return;
        }
        let d = Diag::error(&t.span, format!("`{key}` must be {what}, found {}", t.describe()));
        let d = d.label(format!("expected {what}"));
        let slip =
            t.word().is_some_and(|w| w.contains(',') && w.replace(',', ".").parse::<f64>().is_ok());
        self.sink().push(d.maybe_help(slip.then_some("decimals are written with a point")));
    }
    /// The only token of the value, converted; an error names `what` was needed.
    fn single<T>(
        &self,
        key: &str,
        e: &'a Entry,
        what: &str,
        get: impl Fn(&'a Token) -> Option<T>,
    ) -> Option<T> {
        let t = self.stream(e, what)?;
        let v = get(&t[0]);
        match v {
            Some(_) => self.surplus(e, 1),
            None => self.not_a(key, &t[0], what),
        }
        v
    }
    /// The same after `[dims]` or `name [dims]`; also says which dimensions were written.
    fn dimensioned<T>(
        &self,
        key: &str,
        e: &'a Entry,
        accept: &[Dims],
        what: &str,
        get: impl Fn(&'a [Token]) -> Option<(T, usize)>,
    ) -> Option<(T, Option<Dims>)> {
        let t = self.stream(e, what)?;
        let named =
            t[0].text().is_some() && matches!(t.get(1).map(|t| &t.kind), Some(Tok::Bracket(_)));
        let mut at = usize::from(named);
        let mut written = None;
        if let Tok::Bracket(items) = &t[at].kind {
            match units::parse(items) {
                Ok(d) => {
                    written = Some(d);
                    if !accept.contains(&d) {
                        let names: Vec<String> = accept.iter().map(Dims::to_string).collect();
                        let names = names.join(" or ");
                        let text =
                            format!("wrong dimensions for `{key}`: expected {names}, found {d}");
                        self.sink().push(
                            Diag::error(&t[at].span, text).label(format!("expected {names}")),
                        );
                    }
                }
                Err(why) => {
                    let d = Diag::error(&t[at].span, format!("these are no dimensions: {why}"));
                    self.sink().push(d.label("cannot be understood"));
                }
            }
            at += 1;
        }
        let Some(first) = t.get(at) else {
            let last = &t[t.len() - 1].span;
            let d = Diag::error(&last.after(), format!("`{key}` has dimensions and no value"));
            self.sink().push(d.label(format!("expected {what}")));
            return None;
        };
        match get(&t[at..]) {
            Some((v, n)) => {
                self.surplus(e, at + n);
                Some((v, written))
            }
            None => {
                self.not_a(key, first, what);
                None
            }
        }
    }

    // ---- numbers

    /// A number: `key value;`, `key [dims] value;` or `key name [dims] value;`. NaN on error.
    pub fn scalar(&self, key: &str, dims: Dims) -> f64 {
        match self.entry(key) {
            Some(e) => self.scalar_of(key, e, dims),
            None => {
                self.missing(key, &format!("add `{key} {dims} <number>;`"));
                f64::NAN
            }
        }
    }
    fn scalar_of(&self, key: &str, e: &'a Entry, dims: Dims) -> f64 {
        self.dimensioned(key, e, &[dims], "a number", |t| Some((t[0].number()?, 1)))
            .map_or(f64::NAN, |v| v.0)
    }
    /// A number, or `default` when absent.
    pub fn opt_scalar(&self, key: &str, dims: Dims, default: f64) -> f64 {
        self.maybe_scalar(key, dims).unwrap_or(default)
    }
    /// A number, if the key is there (NaN when it is wrong).
    pub fn maybe_scalar(&self, key: &str, dims: Dims) -> Option<f64> {
        self.entry(key).map(|e| self.scalar_of(key, e, dims))
    }
    /// A number in any of the dimensions `accept`, and the ones written (`None`: none written).
    pub fn scalar_any(&self, key: &str, accept: &[Dims]) -> (f64, Option<Dims>) {
        let Some(e) = self.entry(key) else {
            self.missing(key, &format!("add `{key} <number>;`"));
            return (f64::NAN, None);
        };
        self.dimensioned(key, e, accept, "a number", |t| Some((t[0].number()?, 1)))
            .unwrap_or((f64::NAN, None))
    }
    fn check(&self, key: &str, x: f64, ok: bool, need: &str) -> f64 {
        if x.is_nan() || ok {
            return x;
        }
        let found = crate::writer::number(x);
        let text = format!("`{key}` must be {need}, found {found}");
        let t = self.dict().find(key).and_then(|e| match &e.value {
            Value::Stream(t) => t.iter().find(|t| t.number() == Some(x)),
            Value::Dict(_) => None,
        });
        let at = t.map_or_else(|| self.value_span(key), |t| t.span.clone());
        self.sink().push(Diag::error(&at, text).label(format!("must be {need}")));
        f64::NAN
    }
    /// A number above zero.
    pub fn positive(&self, key: &str, dims: Dims) -> f64 {
        let x = self.scalar(key, dims);
        self.check(key, x, x > 0.0, "positive")
    }
    /// A number above zero, or `default`.
    pub fn opt_positive(&self, key: &str, dims: Dims, default: f64) -> f64 {
        self.maybe_scalar(key, dims).map_or(default, |x| self.check(key, x, x > 0.0, "positive"))
    }
    /// Zero or above.
    pub fn non_negative(&self, key: &str, dims: Dims) -> f64 {
        let x = self.scalar(key, dims);
        self.check(key, x, x >= 0.0, "zero or positive")
    }
    /// Zero or above, or `default`.
    pub fn opt_non_negative(&self, key: &str, dims: Dims, default: f64) -> f64 {
        self.maybe_scalar(key, dims)
            .map_or(default, |x| self.check(key, x, x >= 0.0, "zero or positive"))
    }
    /// A number in a closed interval.
    pub fn in_range(&self, key: &str, dims: Dims, range: RangeInclusive<f64>) -> f64 {
        let x = self.scalar(key, dims);
        self.check(key, x, range.contains(&x), &between(&range))
    }
    /// A number in a closed interval, or `default`.
    pub fn opt_in_range(
        &self,
        key: &str,
        dims: Dims,
        range: RangeInclusive<f64>,
        default: f64,
    ) -> f64 {
        let x = self.maybe_scalar(key, dims);
        x.map_or(default, |x| self.check(key, x, range.contains(&x), &between(&range)))
    }
    /// A whole number; 0 on error.
    pub fn label(&self, key: &str) -> i64 {
        self.maybe_label(key).unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} <whole number>;`"));
            0
        })
    }
    /// A whole number, or `default`.
    pub fn opt_label(&self, key: &str, default: i64) -> i64 {
        self.maybe_label(key).unwrap_or(default)
    }
    /// A whole number, if the key is there (0 when it is wrong).
    pub fn maybe_label(&self, key: &str) -> Option<i64> {
        let e = self.entry(key)?;
        Some(self.single(key, e, "a whole number", Token::label).unwrap_or(0))
    }
    /// A whole number in a closed interval; its lower end on error.
    pub fn label_in(&self, key: &str, range: RangeInclusive<i64>) -> i64 {
        match self.entry(key) {
            Some(e) => self.label_of(key, e, &range),
            None => {
                self.missing(key, &format!("add `{key} <whole number>;`"));
                *range.start()
            }
        }
    }
    /// A whole number in a closed interval, or `default`.
    pub fn opt_label_in(&self, key: &str, range: RangeInclusive<i64>, default: i64) -> i64 {
        self.entry(key).map_or(default, |e| self.label_of(key, e, &range))
    }
    fn label_of(&self, key: &str, e: &'a Entry, range: &RangeInclusive<i64>) -> i64 {
        match self.single(key, e, "a whole number", Token::label) {
            Some(i) if range.contains(&i) => i,
            Some(i) => {
                let need = match (*range.start(), *range.end()) {
                    (a, i64::MAX) => format!("{a} or more"),
                    (a, b) => format!("from {a} to {b}"),
                };
                let text = format!("`{key}` must be {need}, found {i}");
                self.error_at_key(key, text, format!("must be {need}"), None);
                *range.start()
            }
            None => *range.start(),
        }
    }

    // ---- words

    /// `on/off`, `yes/no`, `true/false`, `y/n`, `t/f`; false on error.
    pub fn switch(&self, key: &str) -> bool {
        match self.entry(key) {
            Some(e) => self.switch_of(key, e),
            None => {
                self.missing(key, &format!("add `{key} yes;` or `{key} no;`"));
                false
            }
        }
    }
    /// A switch, or `default`.
    pub fn opt_switch(&self, key: &str, default: bool) -> bool {
        self.entry(key).map_or(default, |e| self.switch_of(key, e))
    }
    fn switch_of(&self, key: &str, e: &'a Entry) -> bool {
        let get = |t: &Token| match (t.word(), t.label()) {
            (Some("on" | "yes" | "true" | "y" | "t"), _) | (_, Some(1)) => Some(true),
            (Some("off" | "no" | "false" | "n" | "f" | "none"), _) | (_, Some(0)) => Some(false),
            _ => None,
        };
        self.single(key, e, "`yes` or `no`", get).unwrap_or(false)
    }
    /// A bare word; empty on error.
    pub fn word(&self, key: &str) -> &'a str {
        self.maybe_word(key).unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} <word>;`"));
            ""
        })
    }
    /// A bare word, or `default`.
    pub fn opt_word(&self, key: &str, default: &'a str) -> &'a str {
        self.maybe_word(key).unwrap_or(default)
    }
    /// A bare word, if the key is there (empty when it is wrong).
    pub fn maybe_word(&self, key: &str) -> Option<&'a str> {
        let e = self.entry(key)?;
        Some(self.single(key, e, "a word", Token::word).unwrap_or(""))
    }
    /// A quoted text or a word; empty on error.
    pub fn string(&self, key: &str) -> &'a str {
        self.maybe_string(key).unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} \"text\";`"));
            ""
        })
    }
    /// A quoted text or a word, or `default`.
    pub fn opt_string(&self, key: &str, default: &'a str) -> &'a str {
        self.maybe_string(key).unwrap_or(default)
    }
    /// A quoted text or a word, if the key is there (empty when it is wrong).
    pub fn maybe_string(&self, key: &str) -> Option<&'a str> {
        let e = self.entry(key)?;
        Some(self.single(key, e, "a text", Token::text).unwrap_or(""))
    }
    /// One of the named choices; the first one on error.
    ///
    /// # Panics
    /// When `choices` is empty, which is a mistake of the program, not of the input.
    pub fn one_of<T: Clone>(&self, key: &str, choices: &[(&str, T)]) -> T {
        assert!(!choices.is_empty(), "a choice for `{key}` needs something to choose from");
        match self.entry(key) {
            Some(e) => self.choice(key, e, choices).unwrap_or_else(|| choices[0].1.clone()),
            None => {
                self.missing(key, &format!("add `{key} <word>;`, one of {}", listed(choices)));
                choices[0].1.clone()
            }
        }
    }
    /// One of the named choices, or `default`.
    pub fn opt_one_of<T: Clone>(&self, key: &str, choices: &[(&str, T)], default: T) -> T {
        self.entry(key).map_or(default.clone(), |e| self.choice(key, e, choices).unwrap_or(default))
    }
    fn choice<T: Clone>(&self, key: &str, e: &'a Entry, choices: &[(&str, T)]) -> Option<T> {
        let t = self.stream(e, "a word")?;
        let Some(w) = t[0].text() else {
            self.not_a(key, &t[0], "a word");
            return None;
        };
        self.surplus(e, 1);
        let found = choices.iter().find(|c| c.0 == w).map(|c| c.1.clone());
        if found.is_none() {
            let d = Diag::error(&t[0].span, format!("unknown value `{w}` for `{key}`"));
            self.sink().push(d.label("not known").help(known(w, choices)));
        }
        found
    }

    // ---- vectors and lists

    /// A vector `(x y z)` with optional dimensions before it; NaN on error.
    pub fn vector(&self, key: &str, dims: Dims) -> Vec3 {
        self.maybe_vector(key, dims).unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} {dims} (x y z);`"));
            NAN3
        })
    }
    /// A vector, or `default`.
    pub fn opt_vector(&self, key: &str, dims: Dims, default: Vec3) -> Vec3 {
        self.maybe_vector(key, dims).unwrap_or(default)
    }
    /// A vector, if the key is there (NaN when it is wrong).
    pub fn maybe_vector(&self, key: &str, dims: Dims) -> Option<Vec3> {
        let e = self.entry(key)?;
        let v =
            self.dimensioned(key, e, &[dims], "a vector `(x y z)`", |t| Some((t[0].vec3()?, 1)));
        Some(v.map_or(NAN3, |v| v.0))
    }
    /// The unit vector along a vector of any length but zero, which is an error; NaN where it is no vector.
    pub fn direction(&self, key: &str) -> Vec3 {
        let v = self.vector(key, Dims::NONE);
        let most = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if v == [0.0; 3] || most.is_infinite() {
            let label = if most == 0.0 { "zero vector" } else { "beyond numbers" };
            let help = Some("its length does not matter: `(0 0 1)` is a direction");
            self.error_at_key(key, format!("`{key}` has no direction"), label, help);
            return NAN3;
        }
        // The square of a small one would be zero.
        unit(v.map(|x| x / most))
    }
    /// A tensor of nine numbers by rows; NaN on error.
    pub fn tensor(&self, key: &str, dims: Dims) -> Tensor {
        let Some(e) = self.entry(key) else {
            self.missing(key, &format!("add `{key} {dims} (xx xy xz yx yy yz zx zy zz);`"));
            return [f64::NAN; 9];
        };
        let get = |t: &[Token]| Some((t[0].scalars()?.try_into().ok()?, 1));
        self.dimensioned(key, e, &[dims], "a tensor of nine numbers", get)
            .map_or([f64::NAN; 9], |v| v.0)
    }
    /// A list through `get`, with or without its length before it.
    fn list_of<T>(
        &self,
        key: &str,
        what: &str,
        get: impl Fn(&'a Token) -> Option<Vec<T>>,
    ) -> Option<Vec<T>> {
        let e = self.entry(key)?;
        let Some(t) = self.stream(e, what) else { return Some(Vec::new()) };
        let at = counted(t);
        let v = get(&t[at]);
        match v {
            Some(_) => self.surplus(e, at + 1),
            None => self.not_a(key, &t[at], what),
        }
        Some(v.unwrap_or_default())
    }
    fn or_missing<T>(&self, key: &str, v: Option<Vec<T>>, form: &str) -> Vec<T> {
        v.unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} {form};`"));
            Vec::new()
        })
    }
    /// A list of words `(a b c)`, or a single word; empty on error.
    pub fn words(&self, key: &str) -> Vec<&'a str> {
        self.or_missing(key, self.maybe_words(key), "(word word ...)")
    }
    /// A list of words, if the key is there.
    pub fn maybe_words(&self, key: &str) -> Option<Vec<&'a str>> {
        self.list_of(key, "a list of words", |t| t.words().or_else(|| t.text().map(|w| vec![w])))
    }
    /// A list of numbers; empty on error.
    pub fn scalars(&self, key: &str) -> Vec<f64> {
        self.or_missing(key, self.maybe_scalars(key), "(number number ...)")
    }
    /// A list of numbers, if the key is there.
    pub fn maybe_scalars(&self, key: &str) -> Option<Vec<f64>> {
        self.list_of(key, "a list of numbers", Token::scalars)
    }
    /// A list of whole numbers; empty on error.
    pub fn labels(&self, key: &str) -> Vec<i64> {
        self.or_missing(key, self.maybe_labels(key), "(1 2 ...)")
    }
    /// A list of whole numbers, if the key is there.
    pub fn maybe_labels(&self, key: &str) -> Option<Vec<i64>> {
        self.list_of(key, "a list of whole numbers", Token::labels)
    }
    /// A list of vectors; empty on error.
    pub fn vectors(&self, key: &str) -> Vec<Vec3> {
        self.or_missing(key, self.maybe_vectors(key), "((x y z) ...)")
    }
    /// A list of vectors, if the key is there.
    pub fn maybe_vectors(&self, key: &str) -> Option<Vec<Vec3>> {
        self.list_of(key, "a list of vectors", Token::vectors)
    }
    /// Dimensions `[kg m s K mol A cd]`; none on error.
    pub fn dims(&self, key: &str) -> Dims {
        self.maybe_dims(key).unwrap_or_else(|| {
            self.missing(key, &format!("add `{key} [0 0 0 0 0 0 0];`"));
            Dims::NONE
        })
    }
    /// Dimensions, if the key is there.
    pub fn maybe_dims(&self, key: &str) -> Option<Dims> {
        let e = self.entry(key)?;
        let get = |t: &'a Token| match &t.kind {
            Tok::Bracket(items) => Some((t, units::parse(items))),
            _ => None,
        };
        let what = "dimensions such as `[0 1 -1 0 0 0 0]`";
        Some(match self.single(key, e, what, get) {
            Some((_, Ok(d))) => d,
            Some((t, Err(why))) => {
                let d = Diag::error(&t.span, format!("these are no dimensions: {why}"));
                self.sink().push(d.label("cannot be understood"));
                Dims::NONE
            }
            None => Dims::NONE,
        })
    }
    /// The value of `key` word by word; an error when absent.
    pub fn tokens(&self, key: &str) -> Option<TokenReader<'a>> {
        let r = self.maybe_tokens(key);
        if r.is_none() && !self.has(key) {
            self.missing(key, &format!("add `{key} ...;`"));
        }
        r
    }
    /// The same as [`Reader::tokens`].
    pub fn token_reader(&self, key: &str) -> Option<TokenReader<'a>> {
        self.tokens(key)
    }
    /// The value of `key` word by word, if the key is there; an error for a sub-dictionary.
    pub fn maybe_tokens(&self, key: &str) -> Option<TokenReader<'a>> {
        let e = self.entry(key)?;
        let t = match &e.value {
            Value::Stream(t) => t.as_slice(),
            Value::Dict(_) => self.stream(e, "a value")?,
        };
        let end = t.last().map_or(&e.key_span, |t| &t.span).after();
        Some(TokenReader::of_entry(self, e, t, end, key))
    }
    /// The inside of the list `key ( .. );` item by item; an error when absent.
    pub fn list(&self, key: &str) -> Option<TokenReader<'a>> {
        let r = self.maybe_list(key);
        if r.is_none() && !self.has(key) {
            self.missing(key, &format!("add `{key} ( ... );`"));
        }
        r
    }
    /// The inside of the list `key ( .. );`, if the key is there; an error for something else.
    pub fn maybe_list(&self, key: &str) -> Option<TokenReader<'a>> {
        let e = self.entry(key)?;
        let t = self.stream(e, "a list")?;
        let at = counted(t);
        let Some(items) = t[at].list() else {
            self.not_a(key, &t[at], "a list");
            return None;
        };
        self.surplus(e, at + 1);
        Some(TokenReader::inside(self, items, &t[at], key))
    }
}

/// Index of the list in `(..)` or `N (..)`.
pub(super) fn counted(t: &[Token]) -> usize {
    let is_list = |t: &Token| matches!(t.kind, Tok::List(_) | Tok::Packed(_));
    usize::from(t.len() > 1 && t[0].label().is_some() && is_list(&t[1]))
}
fn between(r: &RangeInclusive<f64>) -> String {
    let n = crate::writer::number;
    format!("from {} to {}", n(*r.start()), n(*r.end()))
}
fn listed<T>(choices: &[(&str, T)]) -> String {
    choices.iter().map(|c| c.0).collect::<Vec<_>>().join(", ")
}
/// Help for an unknown choice.
pub(super) fn known<T>(word: &str, choices: &[(&str, T)]) -> String {
    let near = nearest(word, choices.iter().map(|c| c.0));
    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
    format!("{near}known: {}", listed(choices))
}
