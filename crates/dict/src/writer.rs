//! Dictionaries, fields and lists as OpenFOAM reads them back.

use crate::lists::Payload;
use crate::tree::{Dict, Entry, Key, Tok, Token, Value as Raw};
use granflow_base::{Dims, Value, Vec3};
use std::fmt::{Display, Write as _};

/// How lists are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Format {
    /// Decimal text that reads back to the same bits.
    #[default]
    Ascii,
    /// Little-endian, labels of 32 and scalars of 64 bits.
    Binary,
}

/// The `FoamFile` header.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// `volVectorField`, `dictionary`, `labelList`, ...
    pub class: String,
    /// The file's name.
    pub object: String,
    /// The file's folder in the case: `0`, `constant/polyMesh`.
    pub location: Option<String>,
    /// A remark, such as the mesh sizes in `owner`.
    pub note: Option<String>,
    /// Of the lists in the file.
    pub format: Format,
}

impl Header {
    /// An ascii header.
    pub fn new(class: impl Into<String>, object: impl Into<String>) -> Header {
        let (class, object) = (class.into(), object.into());
        Header { class, object, location: None, note: None, format: Format::Ascii }
    }
    /// Sets the folder.
    #[must_use]
    pub fn location(mut self, location: impl Into<String>) -> Header {
        self.location = Some(location.into());
        self
    }
    /// Sets the remark.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Header {
        self.note = Some(note.into());
        self
    }
    /// Sets the format.
    #[must_use]
    pub fn format(mut self, format: Format) -> Header {
        self.format = format;
        self
    }
}

/// The shortest text that reads back to the same bits: `1`, `0.1`, `1e-7`.
pub fn number(x: f64) -> String {
    let mut s = Vec::new();
    push_number(&mut s, x);
    String::from_utf8_lossy(&s).into_owned()
}
fn push_number(out: &mut Vec<u8>, x: f64) {
    use std::io::Write as _;
    if x.is_nan() {
        out.extend_from_slice(b"nan");
        return;
    }
    // Writing to memory does not fail.
    let _ = write!(out, "{x:?}");
    // `-0.0` keeps its point: `-0` would be read back as the whole number 0.
    if out.ends_with(b".0") && !out.ends_with(b"-0.0") {
        out.truncate(out.len() - 2);
    }
}

/// A list of a list file.
#[derive(Clone, Copy, Debug)]
pub enum List<'l> {
    /// Cell or point labels.
    Labels(&'l [u32]),
    /// Numbers.
    Scalars(&'l [f64]),
    /// Vectors.
    Vectors(&'l [Vec3]),
    /// Faces: points of face `f` are `points[ptr[f]..ptr[f + 1]]`.
    Faces {
        /// Starts, one more than faces.
        ptr: &'l [u32],
        /// Point labels.
        points: &'l [u32],
    },
}

/// A file of one list. Faces are written as `faceList` in ascii and `faceCompactList` in binary,
/// whatever class the header names.
pub fn list_file(header: &Header, list: List<'_>) -> Vec<u8> {
    let mut header = header.clone();
    if let List::Faces { .. } = list {
        let class = if header.format == Format::Binary { "faceCompactList" } else { "faceList" };
        header.class = class.into();
    }
    let mut w = Writer::new(&header);
    w.list(list);
    w.finish()
}

/// Builds one file in memory.
#[derive(Clone, Debug)]
pub struct Writer {
    out: Vec<u8>,
    format: Format,
    depth: usize,
}

impl Writer {
    /// Starts a file with a header.
    pub fn new(header: &Header) -> Writer {
        let mut w = Writer::bare(header.format);
        w.open("FoamFile");
        w.entry("version", "2.0");
        match header.format {
            Format::Ascii => w.entry("format", "ascii"),
            Format::Binary => {
                w.entry("format", "binary");
                w.entry("arch", "\"LSB;label=32;scalar=64\"");
            }
        }
        w.entry("class", &header.class);
        if let Some(note) = &header.note {
            w.entry("note", quoted(note));
        }
        if let Some(location) = &header.location {
            w.entry("location", quoted(location));
        }
        w.entry("object", &header.object);
        w.close();
        w.blank();
        w
    }
    /// Starts a text without a header.
    pub fn bare(format: Format) -> Writer {
        Writer { out: Vec::new(), format, depth: 0 }
    }
    /// The bytes.
    pub fn finish(self) -> Vec<u8> {
        self.out
    }
    fn text(&mut self, s: &str) {
        self.out.extend_from_slice(s.as_bytes());
    }
    fn indent(&mut self) {
        self.out.resize(self.out.len() + 4 * self.depth, b' ');
    }
    fn key(&mut self, key: &str) {
        self.indent();
        self.text(key);
        let pad = 16usize.saturating_sub(key.chars().count()).max(1);
        self.out.resize(self.out.len() + pad, b' ');
    }
    /// `key value;`
    pub fn entry(&mut self, key: &str, value: impl Display) {
        self.key(key);
        let mut s = String::new();
        let _ = write!(s, "{value}");
        self.text(&s);
        self.text(";\n");
    }
    /// `key {`
    pub fn open(&mut self, key: &str) {
        self.indent();
        self.text(key);
        self.text("\n");
        self.indent();
        self.text("{\n");
        self.depth += 1;
    }
    /// `}`
    pub fn close(&mut self) {
        self.depth = self.depth.saturating_sub(1);
        self.indent();
        self.text("}\n");
    }
    /// `key (`
    pub fn open_list(&mut self, key: &str) {
        self.indent();
        self.text(key);
        self.text("\n");
        self.indent();
        self.text("(\n");
        self.depth += 1;
    }
    /// `);`
    pub fn close_list(&mut self) {
        self.depth = self.depth.saturating_sub(1);
        self.indent();
        self.text(");\n");
    }
    /// An empty line.
    pub fn blank(&mut self) {
        self.text("\n");
    }
    /// A comment to the end of its line.
    pub fn comment(&mut self, text: &str) {
        for line in text.lines() {
            self.indent();
            self.text("// ");
            self.text(line);
            self.text("\n");
        }
    }
    /// Text as it is.
    pub fn raw(&mut self, text: &str) {
        self.text(text);
    }
    /// `key [dims];`
    pub fn dims(&mut self, key: &str, dims: Dims) {
        self.entry(key, dims);
    }
    /// `key [dims] value;`
    pub fn dimensioned(&mut self, key: &str, dims: Dims, x: f64) {
        self.entry(key, format_args!("{dims} {}", number(x)));
    }
    /// `key (x y z);`
    pub fn vector(&mut self, key: &str, v: Vec3) {
        self.key(key);
        push_value(&mut self.out, &v);
        self.text(";\n");
    }
    /// `key uniform v;`
    pub fn uniform<T: Value>(&mut self, key: &str, v: T) {
        self.key(key);
        self.text("uniform ");
        push_value(&mut self.out, &v);
        self.text(";\n");
    }
    /// `uniform` when all values are equal, else `nonuniform`.
    pub fn field<T: Value>(&mut self, key: &str, values: &[T]) {
        match values.first() {
            Some(v) if values.iter().all(|x| x == v) => self.uniform(key, *v),
            _ => self.nonuniform(key, values),
        }
    }
    /// `key nonuniform List<T> N ( .. );` in the format of the file.
    pub fn nonuniform<T: Value>(&mut self, key: &str, values: &[T]) {
        self.key(key);
        self.text("nonuniform List<");
        self.text(T::WORD);
        self.text("> ");
        self.values(values);
        self.text(";\n");
    }
    /// `N ( .. )`.
    fn values<T: Value>(&mut self, values: &[T]) {
        self.text(&format!("\n{}\n(", values.len()));
        match self.format {
            Format::Ascii => {
                self.text("\n");
                for v in values {
                    push_value(&mut self.out, v);
                    self.out.push(b'\n');
                }
            }
            Format::Binary => {
                self.out.reserve(8 * T::N * values.len());
                for v in values {
                    for c in 0..T::N {
                        self.out.extend_from_slice(&v.comp(c).to_le_bytes());
                    }
                }
            }
        }
        self.text(")\n");
    }
    fn labels(&mut self, labels: impl ExactSizeIterator<Item = i64>) {
        use std::io::Write as _;
        self.text(&format!("\n{}\n(", labels.len()));
        if self.format == Format::Ascii {
            self.text("\n");
        }
        for l in labels {
            match self.format {
                Format::Ascii => {
                    let _ = writeln!(self.out, "{l}");
                }
                Format::Binary => self.out.extend_from_slice(&(l as i32).to_le_bytes()),
            }
        }
        self.text(")\n");
    }
    /// The list of a list file.
    pub fn list(&mut self, list: List<'_>) {
        match list {
            List::Labels(l) => self.labels(l.iter().map(|&l| i64::from(l))),
            List::Scalars(x) => self.values(x),
            List::Vectors(x) => self.values(x),
            List::Faces { ptr, points } if self.format == Format::Binary => {
                self.labels(ptr.iter().map(|&l| i64::from(l)));
                self.labels(points.iter().map(|&l| i64::from(l)));
            }
            List::Faces { ptr, points } => {
                self.text(&format!("\n{}\n(\n", ptr.len().saturating_sub(1)));
                for w in ptr.windows(2) {
                    push_face(
                        &mut self.out,
                        points.get(w[0] as usize..w[1] as usize).unwrap_or(&[]),
                    );
                    self.out.push(b'\n');
                }
                self.text(")\n");
            }
        }
    }
    /// The entries of a tree.
    pub fn dict(&mut self, dict: &Dict) {
        for e in &dict.entries {
            let key = match &e.key {
                Key::Word(w) => w.clone(),
                Key::Regex(p) => quoted(&p.text),
            };
            match &e.value {
                Raw::Dict(d) => {
                    self.open(&key);
                    self.dict(d);
                    self.close();
                }
                Raw::Stream(t) => {
                    self.key(&key);
                    self.tokens(t);
                    self.text(";\n");
                }
            }
        }
    }
    fn tokens(&mut self, tokens: &[Token]) {
        for (i, t) in tokens.iter().enumerate() {
            if i > 0 {
                self.text(" ");
            }
            self.token(t);
        }
    }
    fn token(&mut self, t: &Token) {
        match &t.kind {
            Tok::Word(w) => self.text(w),
            Tok::Str(s) => self.text(&quoted(s)),
            Tok::Verbatim(s) => self.text(&format!("#{{{s}#}}")),
            // The point tells a number from a label when it is read back.
            Tok::Number(x) if x.is_finite() => self.text(&format!("{x:?}")),
            Tok::Number(x) => self.text(&number(*x)),
            Tok::Label(i) => self.text(&i.to_string()),
            Tok::Punct(c) => self.text(c.encode_utf8(&mut [0; 4])),
            Tok::Bracket(items) => {
                self.text("[");
                self.tokens(items);
                self.text("]");
            }
            Tok::List(items) => {
                self.text("(");
                self.tokens(items);
                self.text(")");
            }
            Tok::Dict(d) => {
                self.text("{\n");
                self.depth += 1;
                self.dict(d);
                self.depth -= 1;
                self.indent();
                self.text("}");
            }
            Tok::Packed(p) => self.payload(p),
        }
    }
    fn payload(&mut self, p: &Payload) {
        match p {
            Payload::Labels(x) => {
                self.text("List<label> ");
                self.labels(x.iter().copied());
            }
            Payload::Scalars(x) => {
                self.text("List<scalar> ");
                self.values(x);
            }
            Payload::Vectors(x) => {
                self.text("List<vector> ");
                self.values(x);
            }
            Payload::Tensors(x) => {
                self.text("List<tensor> ");
                self.values(x);
            }
            Payload::SymmTensors(x) => self.symm_tensors(x),
            Payload::Faces { ptr, points } => {
                self.text("List<face> ");
                let format = std::mem::replace(&mut self.format, Format::Ascii);
                self.list(List::Faces { ptr, points });
                self.format = format;
            }
            Payload::Tokens(t) => {
                self.text("(");
                self.tokens(t);
                self.text(")");
            }
            Payload::Entries(entries) => self.entries(entries),
        }
    }
    fn symm_tensors(&mut self, x: &[[f64; 6]]) {
        self.text(&format!("List<symmTensor> \n{}\n(", x.len()));
        for t in x {
            match self.format {
                Format::Ascii => {
                    self.out.push(b'\n');
                    push_tuple(&mut self.out, t);
                }
                Format::Binary => {
                    t.iter().for_each(|c| self.out.extend_from_slice(&c.to_le_bytes()))
                }
            }
        }
        self.text(")\n");
    }
    fn entries(&mut self, entries: &[Entry]) {
        self.text("(\n");
        let list = Dict { entries: entries.to_vec(), ..Dict::new() };
        self.dict(&list);
        self.text(")");
    }
}

fn push_face(out: &mut Vec<u8>, points: &[u32]) {
    use std::io::Write as _;
    let _ = write!(out, "{}(", points.len());
    for (i, p) in points.iter().enumerate() {
        let _ = write!(out, "{}{p}", if i > 0 { " " } else { "" });
    }
    out.push(b')');
}

fn push_tuple(out: &mut Vec<u8>, parts: &[f64]) {
    out.push(b'(');
    for (i, x) in parts.iter().enumerate() {
        if i > 0 {
            out.push(b' ');
        }
        push_number(out, *x);
    }
    out.push(b')');
}

fn push_value<T: Value>(out: &mut Vec<u8>, v: &T) {
    if T::N == 1 {
        push_number(out, v.comp(0));
        return;
    }
    let mut parts = [0.0; 9];
    (0..T::N).for_each(|c| parts[c] = v.comp(c));
    push_tuple(out, &parts[..T::N]);
}

/// A text between quotes, its own quotes escaped.
fn quoted(s: &str) -> String {
    format!("\"{}\"", s.replace('"', "\\\"").replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        let cases = [
            (1.0, "1"),
            (0.1, "0.1"),
            (1e-7, "1e-7"),
            (0.0, "0"),
            (-0.0, "-0.0"),
            (1e22, "1e22"),
            (-2.5, "-2.5"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
        assert_eq!(number(f64::NAN), "nan");
        assert_eq!(number(f64::NEG_INFINITY), "-inf");
    }
}
