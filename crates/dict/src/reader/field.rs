//! `uniform (0 0 0)` and `nonuniform List<vector> N(..)`.

use super::Reader;
use super::values::counted;
use crate::diag::Diag;
use crate::lists::Payload;
use crate::source::Span;
use crate::tree::{Entry, Tok, Token, Value as Raw};
use granflow_base::{Value, Vec3};

/// The values of a field or of a patch.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue<T> {
    /// One value everywhere.
    Uniform(T),
    /// One value an element.
    NonUniform(Vec<T>),
}

impl<T: Copy> FieldValue<T> {
    /// One value an element, for `n` elements.
    pub fn into_vec(self, n: usize) -> Vec<T> {
        match self {
            FieldValue::Uniform(v) => vec![v; n],
            FieldValue::NonUniform(v) => v,
        }
    }
    /// The value of element `i`.
    ///
    /// # Panics
    /// When `i` lies outside a list of values.
    pub fn get(&self, i: usize) -> T {
        match self {
            FieldValue::Uniform(v) => *v,
            FieldValue::NonUniform(v) => v[i],
        }
    }
    /// Whether it is one value everywhere.
    pub fn is_uniform(&self) -> bool {
        matches!(self, FieldValue::Uniform(_))
    }
}

fn from_parts<T: Value>(parts: &[f64]) -> Option<T> {
    if parts.len() != T::N {
        return None;
    }
    let mut v = T::ZERO;
    parts.iter().enumerate().for_each(|(c, &x)| v.set_comp(c, x));
    Some(v)
}

/// One value of type `T`.
fn one<T: Value>(t: &Token) -> Option<T> {
    if T::N == 1 { from_parts(&[t.number()?]) } else { from_parts(&t.scalars()?) }
}

/// A list of values of type `T`.
fn many<T: Value>(t: &Token) -> Option<Vec<T>> {
    let Tok::Packed(p) = &t.kind else {
        return t.list()?.iter().map(one).collect();
    };
    match &**p {
        Payload::Scalars(x) if T::N == 1 => x.iter().map(|x| from_parts(&[*x])).collect(),
        Payload::Labels(x) if T::N == 1 => x.iter().map(|x| from_parts(&[*x as f64])).collect(),
        Payload::Vectors(x) if T::N == 3 => x.iter().map(|x| from_parts(x)).collect(),
        Payload::Tensors(x) if T::N == 9 => x.iter().map(|x| from_parts(x)).collect(),
        p if p.is_empty() => Some(Vec::new()),
        _ => None,
    }
}

impl<'a> Reader<'a> {
    /// `uniform v` or `nonuniform List<T> ..` for `n` elements; zero everywhere on error.
    pub fn field<T: Value>(&self, key: &str, n: usize) -> FieldValue<T> {
        match self.entry(key) {
            Some(e) => self.field_of(key, e, n),
            None => {
                let zero = if T::N == 1 { "0" } else { "(0 0 0)" };
                self.missing(key, &format!("add `{key} uniform {zero};`"));
                FieldValue::Uniform(T::ZERO)
            }
        }
    }
    /// The same, if the key is there.
    pub fn maybe_field<T: Value>(&self, key: &str, n: usize) -> Option<FieldValue<T>> {
        self.entry(key).map(|e| self.field_of(key, e, n))
    }
    /// [`Reader::field`] of scalars.
    pub fn field_scalar(&self, key: &str, n: usize) -> FieldValue<f64> {
        self.field(key, n)
    }
    /// [`Reader::field`] of vectors.
    pub fn field_vector(&self, key: &str, n: usize) -> FieldValue<Vec3> {
        self.field(key, n)
    }
    fn field_of<T: Value>(&self, key: &str, e: &'a Entry, n: usize) -> FieldValue<T> {
        let bad = |at: &Span, text: String, label: String| {
            if self.sink().blames(&e.key_span) {
                return FieldValue::Uniform(T::ZERO);
            }
            self.sink().push(Diag::error(at, text).label(label).help(format!(
                "write `{key} uniform <{0}>;` or `{key} nonuniform List<{0}> {n} ( ... );`",
                T::WORD
            )));
            FieldValue::Uniform(T::ZERO)
        };
        let t = match &e.value {
            Raw::Stream(t) => t.as_slice(),
            Raw::Dict(_) => {
                let text = format!("`{key}` must be the values of a field, found a sub-dictionary");
                return bad(&e.key_span, text, "expected values".into());
            }
        };
        let how = t.first().and_then(Token::word);
        let (Some("uniform" | "nonuniform"), Some(second)) = (how, t.get(1)) else {
            let at = t.first().map_or(&e.key_span, |t| &t.span);
            let text = format!("`{key}` must be `uniform` or `nonuniform` with values");
            return bad(at, text, "expected `uniform` or `nonuniform`".into());
        };
        if how == Some("uniform") {
            let Some(v) = one(second) else {
                let text = format!("`{key}` needs a {}, found {}", T::WORD, second.describe());
                return bad(&second.span, text, format!("expected a {}", T::WORD));
            };
            self.surplus(e, 2);
            return FieldValue::Uniform(v);
        }
        let at = 1 + counted(&t[1..]);
        let Some(values) = many::<T>(&t[at]) else {
            let text = format!("`{key}` needs a list of {}s, found {}", T::WORD, t[at].describe());
            return bad(&t[at].span, text, format!("expected List<{}>", T::WORD));
        };
        self.surplus(e, at + 1);
        if values.len() != n {
            let text = format!("`{key}` has {} values for {n} elements", values.len());
            return bad(&t[at].span, text, format!("expected {n} values"));
        }
        FieldValue::NonUniform(values)
    }
}
