//! Lists that are too long for tokens: typed, ascii or binary, read in one pass.

use crate::scan::{self, OUT_OF_RANGE, TOO_LARGE};
use crate::tree::{Entry, Token};
use granflow_base::{Tensor, Vec3};

/// The contents of a list.
#[derive(Clone, Debug, PartialEq)]
pub enum Payload {
    /// Whole numbers.
    Labels(Vec<i64>),
    /// Numbers.
    Scalars(Vec<f64>),
    /// `(x y z)` each.
    Vectors(Vec<Vec3>),
    /// `(xx xy xz yy yz zz)` each.
    SymmTensors(Vec<[f64; 6]>),
    /// By rows, nine numbers each.
    Tensors(Vec<Tensor>),
    /// Points of face `f`: `points[ptr[f]..ptr[f + 1]]`; `ptr` is one longer than the list.
    Faces {
        /// Where each face starts.
        ptr: Vec<u32>,
        /// Point labels, face after face.
        points: Vec<u32>,
    },
    /// `( name { .. } .. )`.
    Entries(Vec<Entry>),
    /// Anything else.
    Tokens(Vec<Token>),
}

impl Payload {
    /// Number of items.
    pub fn len(&self) -> usize {
        match self {
            Payload::Labels(x) => x.len(),
            Payload::Scalars(x) => x.len(),
            Payload::Vectors(x) => x.len(),
            Payload::SymmTensors(x) => x.len(),
            Payload::Tensors(x) => x.len(),
            Payload::Faces { ptr, .. } => ptr.len().saturating_sub(1),
            Payload::Entries(x) => x.len(),
            Payload::Tokens(x) => x.len(),
        }
    }
    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// For messages: "a list of 3 vectors".
    pub fn describe(&self) -> String {
        let kind = match self {
            Payload::Labels(_) => "whole number",
            Payload::Scalars(_) => "number",
            Payload::Vectors(_) => "vector",
            Payload::SymmTensors(_) => "symmetric tensor",
            Payload::Tensors(_) => "tensor",
            Payload::Faces { .. } => "face",
            Payload::Entries(_) => "named dictionary",
            Payload::Tokens(_) => "item",
        };
        match (self.len(), kind) {
            (1, k) => format!("a list of 1 {k}"),
            (n, "named dictionary") => format!("a list of {n} named dictionaries"),
            (n, k) => format!("a list of {n} {k}s"),
        }
    }
}

/// What the items of a list are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Elem {
    Label,
    /// Yes or no, as labels 1 and 0.
    Flag,
    Scalar,
    Vector,
    SymmTensor,
    Tensor,
    Face,
}

impl Elem {
    /// From the `T` of `List<T>`.
    pub(crate) fn of_type(name: &str) -> Option<Elem> {
        Some(match name {
            "label" => Elem::Label,
            "bool" => Elem::Flag,
            "scalar" | "sphericalTensor" => Elem::Scalar,
            "vector" | "point" => Elem::Vector,
            "symmTensor" => Elem::SymmTensor,
            "tensor" => Elem::Tensor,
            "face" => Elem::Face,
            _ => return None,
        })
    }
    /// From the `class` of a list file's header.
    pub(crate) fn of_class(class: &str) -> Option<Elem> {
        Some(match class {
            "faceList" | "faceCompactList" | "faceIOList" => Elem::Face,
            "refinementHistory" | "polyBoundaryMesh" => return None,
            _ => {
                let stem = ["IOField", "IOList", "Field", "List"];
                let stem = stem.iter().find_map(|s| class.strip_suffix(s))?;
                Elem::of_type(stem)?
            }
        })
    }
    fn empty(self) -> Payload {
        match self {
            Elem::Label | Elem::Flag => Payload::Labels(Vec::new()),
            Elem::Scalar => Payload::Scalars(Vec::new()),
            Elem::Vector => Payload::Vectors(Vec::new()),
            Elem::SymmTensor => Payload::SymmTensors(Vec::new()),
            Elem::Tensor => Payload::Tensors(Vec::new()),
            Elem::Face => Payload::Faces { ptr: vec![0], points: Vec::new() },
        }
    }
}

/// How the binary parts of a file are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arch {
    big_endian: bool,
    label_bytes: usize,
    scalar_bytes: usize,
}
impl Default for Arch {
    fn default() -> Self {
        Arch { big_endian: false, label_bytes: 4, scalar_bytes: 8 }
    }
}
impl Arch {
    /// Reads `LSB;label=32;scalar=64`; what it does not say stays at OpenFOAM's default.
    pub(crate) fn parse(text: &str) -> Arch {
        let mut arch = Arch::default();
        for part in text.split(';').map(str::trim) {
            match part {
                "MSB" => arch.big_endian = true,
                "label=64" => arch.label_bytes = 8,
                "scalar=32" => arch.scalar_bytes = 4,
                _ => {}
            }
        }
        arch
    }
    fn label(self, b: &[u8]) -> i64 {
        match (<[u8; 4]>::try_from(b), <[u8; 8]>::try_from(b)) {
            (Ok(w), _) if self.big_endian => i64::from(i32::from_be_bytes(w)),
            (Ok(w), _) => i64::from(i32::from_le_bytes(w)),
            (_, Ok(w)) if self.big_endian => i64::from_be_bytes(w),
            (_, Ok(w)) => i64::from_le_bytes(w),
            _ => 0,
        }
    }
    fn scalar(self, b: &[u8]) -> f64 {
        match (<[u8; 4]>::try_from(b), <[u8; 8]>::try_from(b)) {
            (Ok(w), _) if self.big_endian => f64::from(f32::from_be_bytes(w)),
            (Ok(w), _) => f64::from(f32::from_le_bytes(w)),
            (_, Ok(w)) if self.big_endian => f64::from_be_bytes(w),
            (_, Ok(w)) => f64::from_le_bytes(w),
            _ => 0.0,
        }
    }
}

/// Why a list could not be read, and where.
#[derive(Debug, PartialEq)]
pub(crate) struct ListError {
    /// Byte offset of the culprit.
    pub(crate) at: usize,
    pub(crate) message: String,
    pub(crate) label: &'static str,
}
fn fail<T>(at: usize, message: impl Into<String>, label: &'static str) -> Result<T, ListError> {
    Err(ListError { at, message: message.into(), label })
}

/// A list and the offset behind its closing parenthesis.
pub(crate) type Read<T> = Result<(T, usize), ListError>;

/// Reads the ascii items behind `(` up to and with `)`.
pub(crate) fn ascii(b: &[u8], at: usize, elem: Elem) -> Read<Payload> {
    Ok(match elem {
        Elem::Label | Elem::Flag => labels(b, at).map(|(x, end)| (Payload::Labels(x), end))?,
        Elem::Scalar => scalars(b, at).map(|(x, end)| (Payload::Scalars(x), end))?,
        Elem::Vector => tuples(b, at).map(|(x, end)| (Payload::Vectors(x), end))?,
        Elem::SymmTensor => tuples(b, at).map(|(x, end)| (Payload::SymmTensors(x), end))?,
        Elem::Tensor => tuples(b, at).map(|(x, end)| (Payload::Tensors(x), end))?,
        Elem::Face => faces(b, at)?,
    })
}

/// What the items of an untyped list look like, judged by the first one behind `(`.
pub(crate) fn guess(b: &[u8], at: usize) -> Option<Elem> {
    let mut i = scan::space(b, at);
    if let Some((_, end, whole)) = scan::number(b, i) {
        let next = scan::space(b, end);
        return Some(match b.get(next) {
            Some(b'(') if whole => Elem::Face,
            _ => Elem::Scalar,
        });
    }
    if b.get(i) != Some(&b'(') {
        return None;
    }
    i = scan::space(b, i + 1);
    let mut n = 0;
    while let Some((_, end, _)) = scan::number(b, i) {
        i = scan::space(b, end);
        n += 1;
        if n > 9 {
            return None;
        }
    }
    match (n, b.get(i)) {
        (3, Some(b')')) => Some(Elem::Vector),
        (6, Some(b')')) => Some(Elem::SymmTensor),
        (9, Some(b')')) => Some(Elem::Tensor),
        _ => None,
    }
}

/// Whole numbers only become labels again: for untyped lists.
pub(crate) fn narrow(p: Payload) -> Payload {
    match p {
        Payload::Scalars(x) if x.iter().all(|v| *v == v.trunc() && v.abs() < 9.0e15) => {
            Payload::Labels(x.iter().map(|&v| v as i64).collect())
        }
        p => p,
    }
}

fn unclosed<T>(b: &[u8]) -> Result<T, ListError> {
    fail(b.len(), "the file ends inside a list", "`)` is missing")
}

fn labels(b: &[u8], mut i: usize) -> Read<Vec<i64>> {
    let mut out = Vec::new();
    loop {
        i = scan::space(b, i);
        match b.get(i) {
            Some(b')') => return Ok((out, i + 1)),
            None => return unclosed(b),
            _ => {}
        }
        let Some((x, end)) = scan::label(b, i) else {
            return fail(i, "a whole number is needed in this list", "not a whole number");
        };
        out.push(x);
        i = end;
    }
}

fn scalar_at(b: &[u8], i: usize) -> Read<f64> {
    let written = scan::number(b, i).map(|(x, end, _)| (x, end));
    match written.or_else(|| scan::not_finite(b, i)) {
        Some((x, _)) if written.is_some() && x.is_infinite() => fail(i, OUT_OF_RANGE, TOO_LARGE),
        Some(r) => Ok(r),
        None if i >= b.len() => unclosed(b),
        None => fail(i, "a number is needed in this list", "not a number"),
    }
}

fn scalars(b: &[u8], mut i: usize) -> Read<Vec<f64>> {
    let mut out = Vec::new();
    loop {
        i = scan::space(b, i);
        if b.get(i) == Some(&b')') {
            return Ok((out, i + 1));
        }
        let (x, end) = scalar_at(b, i)?;
        out.push(x);
        i = end;
    }
}

fn tuples<const N: usize>(b: &[u8], mut i: usize) -> Read<Vec<[f64; N]>> {
    let mut out = Vec::new();
    loop {
        i = scan::space(b, i);
        match b.get(i) {
            Some(b')') => return Ok((out, i + 1)),
            Some(b'(') => i += 1,
            None => return unclosed(b),
            _ => return fail(i, format!("`(` and {N} numbers are needed here"), "expected `(`"),
        }
        let mut t = [0.0; N];
        for c in &mut t {
            let (x, end) = scalar_at(b, scan::space(b, i))?;
            *c = x;
            i = end;
        }
        i = scan::space(b, i);
        if b.get(i) != Some(&b')') {
            return fail(
                i,
                format!("{N} numbers are needed between the parentheses"),
                "expected `)`",
            );
        }
        out.push(t);
        i += 1;
    }
}

/// `4(0 1 2 3)` or `(0 1 2 3)` each.
fn faces(b: &[u8], mut i: usize) -> Read<Payload> {
    let (mut ptr, mut points) = (vec![0u32], Vec::new());
    loop {
        i = scan::space(b, i);
        match b.get(i) {
            Some(b')') => return Ok((Payload::Faces { ptr, points }, i + 1)),
            None => return unclosed(b),
            _ => {}
        }
        let (at, mut said) = (i, None);
        if let Some((n, end)) = scan::label(b, i) {
            said = Some(n);
            i = scan::space(b, end);
        }
        if b.get(i) != Some(&b'(') {
            return fail(i, "a face such as `4(0 1 2 3)` is needed here", "expected `(`");
        }
        i += 1;
        let first = points.len();
        loop {
            i = scan::space(b, i);
            if b.get(i) == Some(&b')') {
                i += 1;
                break;
            }
            match scan::label(b, i).map(|(x, end)| (u32::try_from(x), end)) {
                Some((Ok(p), end)) => {
                    points.push(p);
                    i = end;
                }
                _ if i >= b.len() => return unclosed(b),
                _ => return fail(i, "a point label is needed here", "not a point label"),
            }
        }
        let found = points.len() - first;
        if said.is_some_and(|n| n != found as i64) {
            return fail(
                at,
                format!("this face holds {found} points"),
                "another number is written here",
            );
        }
        ptr.push(index(points.len(), at)?);
    }
}
fn index(n: usize, at: usize) -> Result<u32, ListError> {
    u32::try_from(n).or_else(|_| fail(at, "too many points in one list", "beyond 2^32"))
}

/// Reads `n` binary items behind `(` with the closing `)`.
pub(crate) fn binary(b: &[u8], at: usize, elem: Elem, n: usize, arch: Arch) -> Read<Payload> {
    if elem == Elem::Face {
        return binary_faces(b, at, n, arch);
    }
    let (width, parts) = match elem {
        Elem::Label => (arch.label_bytes, 1),
        Elem::Flag => (1, 1),
        Elem::Scalar => (arch.scalar_bytes, 1),
        Elem::Vector => (arch.scalar_bytes, 3),
        Elem::SymmTensor => (arch.scalar_bytes, 6),
        _ => (arch.scalar_bytes, 9),
    };
    let (raw, end) = raw(b, at, n, width * parts)?;
    let scalars = |item: &[u8], t: &mut [f64]| {
        for (x, raw) in t.iter_mut().zip(item.chunks_exact(width)) {
            *x = arch.scalar(raw);
        }
    };
    fn collect<const N: usize>(
        raw: &[u8],
        size: usize,
        read: impl Fn(&[u8], &mut [f64]),
    ) -> Vec<[f64; N]> {
        let tuple = |item| {
            let mut t = [0.0; N];
            read(item, &mut t);
            t
        };
        raw.chunks_exact(size).map(tuple).collect()
    }
    let size = width * parts;
    let payload = match elem {
        Elem::Label => Payload::Labels(raw.chunks_exact(width).map(|w| arch.label(w)).collect()),
        Elem::Flag => Payload::Labels(raw.iter().map(|b| i64::from(*b != 0)).collect()),
        Elem::Scalar => Payload::Scalars(raw.chunks_exact(width).map(|w| arch.scalar(w)).collect()),
        Elem::Vector => Payload::Vectors(collect(raw, size, scalars)),
        Elem::SymmTensor => Payload::SymmTensors(collect(raw, size, scalars)),
        _ => Payload::Tensors(collect(raw, size, scalars)),
    };
    Ok((payload, end))
}

/// The bytes of `n` items of `size` bytes, and the offset behind the `)` that follows them.
fn raw(b: &[u8], at: usize, n: usize, size: usize) -> Read<&[u8]> {
    let slice = n.checked_mul(size).and_then(|len| b.get(at..at.checked_add(len)?));
    let Some(raw) = slice else {
        let left = b.len().saturating_sub(at) / size.max(1);
        return fail(
            at.saturating_sub(1),
            format!("the file is cut short: {n} binary items announced, {left} present"),
            "the list starts here",
        );
    };
    let end = at + raw.len();
    if b.get(end) != Some(&b')') {
        return fail(
            at.saturating_sub(1),
            format!("this binary list does not end where {n} items of {size} bytes end"),
            "check `format` and `arch` of the header",
        );
    }
    Ok((raw, end + 1))
}

/// Uncompacted binary faces: each is a list of its own.
fn binary_faces(b: &[u8], mut i: usize, n: usize, arch: Arch) -> Read<Payload> {
    let (mut ptr, mut points) = (vec![0u32], Vec::new());
    for _ in 0..n {
        let (labels, end) = counted_binary_labels(b, i, arch)?;
        push_points(&labels, i, &mut points)?;
        ptr.push(index(points.len(), i)?);
        i = end;
    }
    i = scan::space(b, i);
    if b.get(i) != Some(&b')') {
        return fail(i, "`)` is missing behind the faces", "expected `)`");
    }
    Ok((Payload::Faces { ptr, points }, i + 1))
}
fn push_points(labels: &[i64], at: usize, points: &mut Vec<u32>) -> Result<(), ListError> {
    for &l in labels {
        match u32::try_from(l) {
            Ok(p) => points.push(p),
            Err(_) => return fail(at, format!("`{l}` is no point label"), "in this list"),
        }
    }
    Ok(())
}

/// `N(raw labels)`.
pub(crate) fn counted_binary_labels(b: &[u8], at: usize, arch: Arch) -> Read<Vec<i64>> {
    let at = scan::space(b, at);
    let Some((n, end)) = scan::label(b, at) else {
        return fail(at, "the length of a binary list is needed here", "not a whole number");
    };
    let open = scan::space(b, end);
    if b.get(open) != Some(&b'(') {
        // An empty binary list is written without parentheses.
        return if n == 0 {
            Ok((Vec::new(), end))
        } else {
            fail(open, "`(` is needed here", "expected `(`")
        };
    }
    let (raw, end) = raw(b, open + 1, usize::try_from(n).unwrap_or(usize::MAX), arch.label_bytes)?;
    Ok((raw.chunks_exact(arch.label_bytes).map(|w| arch.label(w)).collect(), end))
}

/// `faceCompactList` in binary: where each face starts (one more than faces), then all points.
pub(crate) fn compact_faces(b: &[u8], at: usize, arch: Arch) -> Read<Payload> {
    let (starts, mid) = counted_binary_labels(b, at, arch)?;
    let (labels, end) = counted_binary_labels(b, mid, arch)?;
    Ok((faces_of(&starts, &labels, at)?, end))
}

/// Faces from where each starts (one more than faces) and all their points.
pub(crate) fn faces_of(starts: &[i64], labels: &[i64], at: usize) -> Result<Payload, ListError> {
    let (mut ptr, mut points) =
        (Vec::with_capacity(starts.len()), Vec::with_capacity(labels.len()));
    push_points(starts, at, &mut ptr)?;
    push_points(labels, at, &mut points)?;
    if ptr.is_empty() {
        ptr.push(0);
    }
    let ordered = ptr[0] == 0 && ptr.windows(2).all(|w| w[0] <= w[1]);
    if !ordered || ptr.last().map(|&l| l as usize) != Some(points.len()) {
        return fail(at, "the starts of these faces do not fit their points", "damaged list");
    }
    Ok(Payload::Faces { ptr, points })
}

/// `n` equal items, as `N{v}` means.
pub(crate) fn repeat(item: &Payload, n: usize) -> Option<Payload> {
    Some(match item {
        Payload::Labels(x) => Payload::Labels(vec![*x.first()?; n]),
        Payload::Scalars(x) => Payload::Scalars(vec![*x.first()?; n]),
        Payload::Vectors(x) => Payload::Vectors(vec![*x.first()?; n]),
        Payload::SymmTensors(x) => Payload::SymmTensors(vec![*x.first()?; n]),
        Payload::Tensors(x) => Payload::Tensors(vec![*x.first()?; n]),
        _ => return None,
    })
}

/// A list of no items.
pub(crate) fn empty(elem: Elem) -> Payload {
    elem.empty()
}
