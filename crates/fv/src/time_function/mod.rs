//! Values that depend on time (OpenFOAM's `Function1`): one trait, one line a form in `forms`.
//!
//! | in a dictionary | |
//! |---|---|
//! | `key 2;`, `key constant 2;`, `key uniform 2;` | a constant |
//! | `key table ((0 1) (2 5));` | inline, settings beside it or in `keyCoeffs { }` |
//! | `key sine; keyCoeffs { amplitude 1; ... }` | settings of their own, or beside `key` |
//! | `key { type sine; amplitude 1; ... }` | the same as a sub-dictionary |
//!
//! To add a form: one file here with its `read`, its value and a test, and one line in `forms`.

mod csv;
mod periodic;
mod polynomial;
mod ramp;
mod scale;
mod table;

use crate::conditions::CaseContext;
use granflow_base::{Dims, Value};
use granflow_dict::{
    Dict, Format, Reader, Token, TokenReader, Value as Raw, Writer, nearest, number,
};
use std::sync::Arc;

pub use table::Beyond;
use table::Table;

/// What a value does in time.
pub trait Form<T>: Send + Sync {
    /// The value at `time` (s).
    fn at(&self, time: f64) -> T;
}

/// Where a form finds its settings.
pub(crate) struct Settings<'a, 'c> {
    /// The dictionary that holds them.
    pub(crate) r: Reader<'a>,
    /// The entry they belong to.
    pub(crate) key: &'c str,
    /// What follows the name of the form, where it was not given as a sub-dictionary.
    pub(crate) inline: Option<TokenReader<'a>>,
    /// The case around.
    pub(crate) case: CaseContext<'c>,
}

impl<'a> Settings<'a, '_> {
    /// The list with the values, which stands behind the name of the form or under `key`.
    pub(crate) fn list(&mut self, key: &str, what: &str) -> Option<TokenReader<'a>> {
        let of_key = match &mut self.inline {
            Some(t) => return counted(t, what),
            None if self.r.has(key) => self.r.tokens(key),
            // As v1912 has it: under the name of the whole.
            None if self.r.has(self.key) => self.r.tokens(self.key).map(|mut t| {
                t.opt_word();
                t
            }),
            None => self.r.tokens(key),
        };
        counted(&mut of_key?, what)
    }
    /// A function of time among the settings.
    pub(crate) fn function<T: Value>(&self, key: &str) -> TimeFunction<T> {
        TimeFunction::read(&self.r, key, Dims::NONE, self.case)
    }
    /// The same, if it is there.
    pub(crate) fn opt_function<T: Value>(&self, key: &str, default: T) -> TimeFunction<T> {
        match self.r.has(key) {
            true => self.function(key),
            false => TimeFunction::constant(default),
        }
    }
    /// The text of the file that `key` names; a mistake where it cannot be read.
    pub(crate) fn file(&self, key: &str) -> Option<(String, String)> {
        let given = self.r.string(key);
        if given.is_empty() {
            return None;
        }
        let path = case_path(given);
        match self.case.files.load(&path) {
            Ok(bytes) => Some((path, String::from_utf8_lossy(&bytes).into_owned())),
            Err(e) => {
                let message = format!("cannot read the file `{path}` of `{}`: {e}", self.key);
                let help = "paths are relative to the case, or begin with `<case>`";
                self.r.error_at_key(key, message, "not readable", Some(help));
                None
            }
        }
    }
}

/// The list that stands next, in front of it perhaps its length.
fn counted<'a>(t: &mut TokenReader<'a>, what: &str) -> Option<TokenReader<'a>> {
    if t.rest().len() > 1 && t.peek().is_some_and(|x| x.label().is_some()) {
        t.next();
    }
    let list = t.list(what);
    t.finish();
    list
}

/// A path in a dictionary relative to the case.
pub(crate) fn case_path(given: &str) -> String {
    let whole = |prefix: &str| given.strip_prefix(prefix).map(|p| p.trim_start_matches('/'));
    for root in ["<case>", "$FOAM_CASE", "${FOAM_CASE}"] {
        if let Some(rest) = whole(root) {
            return rest.to_owned();
        }
    }
    for part in ["constant", "system"] {
        if let Some(rest) = whole(&format!("<{part}>")) {
            return format!("{part}/{rest}");
        }
    }
    given.to_owned()
}

type Read<T> = fn(&mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>>;

/// A form by its name.
struct Entry<T> {
    name: &'static str,
    /// Settings that may stand beside the entry itself.
    keys: &'static [&'static str],
    read: Read<T>,
}

/// Every form of values of type `T`.
fn forms<T: Value>() -> Vec<Entry<T>> {
    const PERIODIC: &[&str] = &["amplitude", "frequency", "t0", "scale", "level", "markSpace"];
    const RAMP: &[&str] = &["start", "duration"];
    const TABLE: &[&str] = &["outOfBounds", "interpolationScheme", "file"];
    let mut all = vec![
        Entry::<T> { name: "table", keys: TABLE, read: table::inline },
        Entry { name: "tableFile", keys: TABLE, read: table::file },
        Entry { name: "csvFile", keys: csv::KEYS, read: csv::read },
        Entry { name: "csv", keys: csv::KEYS, read: csv::read },
        Entry { name: "polynomial", keys: &[], read: polynomial::read },
        Entry { name: "sine", keys: PERIODIC, read: periodic::sine },
        Entry { name: "square", keys: PERIODIC, read: periodic::square },
        Entry { name: "scale", keys: &["scale"], read: scale::read },
        Entry { name: "zero", keys: &[], read: |_| Some(Arc::new(Constant(T::ZERO))) },
        Entry { name: "one", keys: &[], read: |_| Some(Arc::new(Constant(ones::<T>()))) },
    ];
    if T::N == 1 {
        all.extend([
            Entry { name: "linearRamp", keys: RAMP, read: ramp::linear },
            Entry { name: "quadraticRamp", keys: RAMP, read: ramp::quadratic },
            Entry { name: "quarterSineRamp", keys: RAMP, read: ramp::quarter_sine },
            Entry { name: "quarterCosineRamp", keys: RAMP, read: ramp::quarter_cosine },
            Entry { name: "halfCosineRamp", keys: RAMP, read: ramp::half_cosine },
        ]);
    }
    all
}

/// Forms that are known and not there, with the reason.
const REFUSED: &[(&str, &str)] = &[
    ("coded", "it holds C++ that would have to be compiled: write it as `table` or `tableFile`"),
    ("sampled", "values sampled from another case or surface are not there"),
    ("mappedFile", "use the condition `timeVaryingMappedFixedValue`"),
];

struct Constant<T>(T);
impl<T: Value> Form<T> for Constant<T> {
    fn at(&self, _: f64) -> T {
        self.0
    }
}

fn ones<T: Value>() -> T {
    all(1.0)
}

/// `x` in every component.
fn all<T: Value>(x: f64) -> T {
    let mut v = T::ZERO;
    (0..T::N).for_each(|c| v.set_comp(c, x));
    v
}

/// The value with these components.
pub(crate) fn of_components<T: Value>(parts: &[f64]) -> T {
    let mut v = T::ZERO;
    parts.iter().take(T::N).enumerate().for_each(|(c, x)| v.set_comp(c, *x));
    v
}

/// A value against time.
#[derive(Clone)]
pub struct TimeFunction<T> {
    form: Arc<dyn Form<T>>,
    /// From the units of the file to those inside.
    factor: f64,
    /// Its entries in the dictionary, as they were given.
    entries: Vec<(String, String)>,
}

impl<T: Value> TimeFunction<T> {
    /// The constant `v`.
    pub fn constant(v: T) -> Self {
        let entries = vec![(String::new(), text(v))];
        TimeFunction { form: Arc::new(Constant(v)), factor: 1.0, entries }
    }
    /// Points (time, value) with straight lines between them, constant beyond their ends; `None`
    /// when there are none or the times do not increase.
    pub fn table(points: Vec<(f64, T)>) -> Option<Self> {
        let rows: Vec<String> =
            points.iter().map(|(t, v)| format!("({} {})", number(*t), text(*v))).collect();
        let entries = vec![(String::new(), format!("table ({})", rows.join(" ")))];
        let form = Arc::new(Table::new(points, Beyond::Hold)?);
        Some(TimeFunction { form, factor: 1.0, entries })
    }
    /// The value at `time` (s).
    pub fn at(&self, time: f64) -> T {
        match self.factor {
            1.0 => self.form.at(time),
            k => self.form.at(time).scaled(k),
        }
    }
    /// The same times `factor`, written as it was given.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        TimeFunction { factor: self.factor * factor, ..self }
    }
    /// Its entries under `key` in a dictionary, as they were given.
    pub fn entries(&self, key: &str) -> Vec<(String, String)> {
        let named = |(k, v): &(String, String)| match k.is_empty() {
            true => (key.to_owned(), v.clone()),
            false => (k.clone(), v.clone()),
        };
        self.entries.iter().map(named).collect()
    }
    /// Reads `key`, in units `dims` if it is a plain number with dimensions before it. Mistakes go to
    /// the reader's sink, and the value is zero.
    pub fn read(r: &Reader<'_>, key: &str, dims: Dims, case: CaseContext<'_>) -> Self {
        let zero = TimeFunction::constant(T::ZERO);
        let mut out = Self::form_of(r, key, dims, case).unwrap_or(zero);
        let given = given(r.dict(), key);
        if !given.is_empty() {
            out.entries = given;
        }
        out
    }
    /// The same, if it is there.
    pub fn opt_read(
        r: &Reader<'_>,
        key: &str,
        dims: Dims,
        case: CaseContext<'_>,
    ) -> Option<TimeFunction<T>> {
        r.has(key).then(|| Self::read(r, key, dims, case))
    }

    fn form_of(r: &Reader<'_>, key: &str, dims: Dims, case: CaseContext<'_>) -> Option<Self> {
        if matches!(r.dict().find(key).map(|e| &e.value), Some(Raw::Dict(_))) {
            let sub = r.opt_sub(key)?;
            let word = sub.word("type");
            let coefficients = format!("{word}Coeffs");
            let inner = match sub.has(&coefficients) {
                true => sub.opt_sub(&coefficients)?,
                false => sub.clone(),
            };
            if ["constant", "uniform"].contains(&word) {
                return Some(Self::constant(value(&mut inner.tokens("value")?)));
            }
            let settings = Settings { r: inner, key, inline: None, case };
            return Self::of_form(&sub, "type", word, settings);
        }
        // `[dims]` before a plain number is accepted by the scalar reader only.
        if T::N == 1
            && r.raw(key)
                .is_some_and(|t| t.len() == 2 && t[1].number().is_some() && t[0].word().is_none())
        {
            return Some(Self::constant(of_components(&[r.scalar(key, dims)])));
        }
        let mut t = r.tokens(key)?;
        match t.opt_word() {
            None | Some("constant" | "uniform") => {
                let v = value(&mut t);
                t.finish();
                Some(Self::constant(v))
            }
            Some(word) => {
                let coefficients = format!("{key}Coeffs");
                let inner = match r.has(&coefficients) {
                    true => r.opt_sub(&coefficients)?,
                    false => r.clone(),
                };
                let inline = (!t.is_empty()).then_some(t);
                Self::of_form(r, key, word, Settings { r: inner, key, inline, case })
            }
        }
    }

    /// What the form `word`, which stands under `at`, makes of its settings.
    fn of_form(
        r: &Reader<'_>,
        at: &str,
        word: &str,
        mut settings: Settings<'_, '_>,
    ) -> Option<Self> {
        let all = forms::<T>();
        let key = settings.key;
        let Some(form) = all.iter().find(|f| f.name == word) else {
            settings.r.ignore_all();
            if word.is_empty() {
                return None;
            }
            if let Some((_, why)) = REFUSED.iter().find(|x| x.0 == word) {
                let message = format!("`{word}` as a function of time is not supported");
                r.error_at_key(at, message, "refused", Some(why));
                return None;
            }
            let names: Vec<&str> =
                ["constant"].into_iter().chain(all.iter().map(|f| f.name)).collect();
            let near = nearest(word, names.iter().copied());
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let help = format!("{near}write a value, or one of {}", names.join(", "));
            let label = format!("`{word}` is not known here");
            r.error_at_key(at, format!("`{key}` is no function of time"), label, Some(&help));
            return None;
        };
        let before = r.sink().n_errors();
        let made = (form.read)(&mut settings);
        if r.sink().n_errors() > before {
            return None;
        }
        let entries = Vec::new();
        Some(TimeFunction { form: made?, factor: 1.0, entries })
    }
}

/// The entries of a function under `key` as they stand: itself, its coefficients, and what of them
/// stands beside it.
fn given(dict: &Dict, key: &str) -> Vec<(String, String)> {
    let Some(entry) = dict.find(key) else { return Vec::new() };
    let mut out = vec![(String::new(), raw_text(&entry.value))];
    let coefficients = format!("{key}Coeffs");
    if let Some(c) = dict.find(&coefficients) {
        out.push((coefficients, raw_text(&c.value)));
        return out;
    }
    let word = dict.stream(key).and_then(|t| t.first()).and_then(Token::word);
    let all = forms::<f64>();
    let keys = all.iter().find(|f| Some(f.name) == word).map_or(&[][..], |f| f.keys);
    for k in keys {
        if let Some(e) = dict.find(k) {
            out.push(((*k).to_owned(), raw_text(&e.value)));
        }
    }
    out
}

/// A value as a dictionary writes it: `table ((0 1))`, `{ type sine; ... }`.
pub(crate) fn raw_text(value: &Raw) -> String {
    let mut d = Dict::new();
    d.set("x", value.clone());
    let mut w = Writer::bare(Format::Ascii);
    w.dict(&d);
    let text = String::from_utf8_lossy(&w.finish()).into_owned();
    let words: Vec<&str> = text.split_whitespace().skip(1).collect();
    let joined = words.join(" ");
    joined.trim_end_matches(';').to_owned()
}

use crate::conditions::value_text as text;

/// One value of the type of the field: a number or a vector.
pub(crate) fn value<T: Value>(t: &mut TokenReader<'_>) -> T {
    if T::N == 1 {
        return of_components(&[t.number("the value")]);
    }
    of_components(&t.vector("the value"))
}

#[cfg(test)]
mod tests;
