//! The arrays of a VTK file, however they are written.

use flate2::read::ZlibDecoder;
use granflow_dict::{Diag, Source, Span};
use roxmltree::Node;
use std::io::Read;
use std::sync::Arc;

/// The file without its appended data, and these.
pub(super) struct Arrays {
    src: Arc<Source>,
    pub(super) xml: String,
    /// Behind the `_` of the appended data.
    appended: Option<usize>,
}

/// Where the bytes of an array are, and how they are written.
enum Bytes<'b> {
    Raw(&'b [u8]),
    Base64(&'b [u8]),
}

impl Arrays {
    /// Takes the XML apart from what is appended to it, which may be anything.
    pub(super) fn of(src: &Arc<Source>) -> Result<Arrays, Vec<Diag>> {
        const TAG: &[u8] = b"<AppendedData";
        let text = &src.text;
        let fault = |at: usize, what: &str| vec![Diag::error(&Span::new(src, at..at), what)];
        let tag = text.windows(TAG.len()).position(|w| w == TAG);
        let head = &text[..tag.unwrap_or(text.len())];
        let mut xml = std::str::from_utf8(head)
            .map_err(|e| fault(e.valid_up_to(), "the XML holds bytes that are no text"))?
            .to_owned();
        let mut appended = None;
        if let Some(tag) = tag {
            let begin = text[tag..].iter().position(|&b| b == b'>').map(|n| tag + n);
            let begin = begin.ok_or_else(|| fault(tag, "`AppendedData` has no `>`"))?;
            let mark = text[begin..].iter().position(|&b| b == b'_').map(|n| begin + n + 1);
            appended = Some(mark.ok_or_else(|| fault(begin, "appended data begin with `_`"))?);
            // The tag itself says how they are written.
            xml += &String::from_utf8_lossy(&text[tag..begin]);
            xml += if xml.ends_with('/') { "></VTKFile>" } else { "/></VTKFile>" };
        }
        Ok(Arrays { src: src.clone(), xml, appended })
    }

    /// The tag of a node.
    pub(super) fn span(&self, node: Node<'_, '_>) -> Span {
        let range = node.range();
        let end = self.xml[range.clone()].find('>').map_or(range.end, |n| range.start + n + 1);
        Span::new(&self.src, range.start..end)
    }

    pub(super) fn numbers(
        &self,
        root: Node<'_, '_>,
        array: Node<'_, '_>,
    ) -> Result<Vec<f64>, Diag> {
        self.read(root, array, |kind, bytes, big| {
            macro_rules! of {
                ($t:ty) => {
                    bytes.chunks_exact(size_of::<$t>()).map(|b| order::<$t>(b, big)).collect()
                };
            }
            /// The number in `b`, in the file's order of bytes.
            fn order<T: Number>(b: &[u8], big: bool) -> f64 {
                T::read(b, big)
            }
            Some(match kind {
                "Float64" => of!(f64),
                "Float32" => of!(f32),
                "Int64" => of!(i64),
                "UInt64" => of!(u64),
                "Int32" => of!(i32),
                "UInt32" => of!(u32),
                "Int16" => of!(i16),
                "UInt16" => of!(u16),
                "Int8" => of!(i8),
                "UInt8" => of!(u8),
                _ => return None,
            })
        })
    }

    /// As [`Self::numbers`]: numbers of points and cells are exact up to 2^53.
    pub(super) fn integers(
        &self,
        root: Node<'_, '_>,
        array: Node<'_, '_>,
    ) -> Result<Vec<i64>, Diag> {
        let numbers = self.numbers(root, array)?;
        match numbers.iter().find(|x| x.fract() != 0.0 || x.abs() > 9e15) {
            None => Ok(numbers.iter().map(|&x| x as i64).collect()),
            Some(x) => {
                let name = array.attribute("Name").unwrap_or("");
                let what = format!("`{name}` must hold whole numbers, found {x}");
                Err(Diag::error(&self.span(array), what))
            }
        }
    }

    fn read(
        &self,
        root: Node<'_, '_>,
        array: Node<'_, '_>,
        convert: impl Fn(&str, &[u8], bool) -> Option<Vec<f64>>,
    ) -> Result<Vec<f64>, Diag> {
        let fault = |what: String| Diag::error(&self.span(array), what);
        let bytes = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => {
                let text = array.text().unwrap_or("");
                return text
                    .split_whitespace()
                    .map(|w| w.parse().map_err(|_| fault(format!("`{w}` is no number"))))
                    .collect();
            }
            "binary" => Bytes::Base64(array.text().unwrap_or("").trim().as_bytes()),
            "appended" => {
                let offset = array.attribute("offset").and_then(|o| o.trim().parse::<usize>().ok());
                let at = self.appended.zip(offset).map(|(a, o)| a.saturating_add(o));
                let rest = at.and_then(|at| self.src.text.get(at..));
                let rest = rest.ok_or_else(|| fault("its appended data are missing".into()))?;
                let tag = root.children().find(|n| n.has_tag_name("AppendedData"));
                match tag.and_then(|t| t.attribute("encoding")) {
                    Some("base64") => Bytes::Base64(rest),
                    _ => Bytes::Raw(rest),
                }
            }
            other => return Err(fault(format!("the format `{other}` is not supported"))),
        };
        let big = root.attribute("byte_order") == Some("BigEndian");
        let wide = match root.attribute("header_type").unwrap_or("UInt32") {
            "UInt32" => 4,
            "UInt64" => 8,
            other => return Err(fault(format!("headers of type `{other}` are not supported"))),
        };
        let data = match root.attribute("compressor") {
            None => plain(&bytes, wide, big),
            Some("vtkZLibDataCompressor") => inflated(&bytes, wide, big),
            Some(other) => {
                let d = fault(format!("data compressed by `{other}` are not supported"));
                return Err(d.help("save the file with zlib or without compression"));
            }
        };
        let data = data.ok_or_else(|| fault("its data are damaged or cut off".into()))?;
        let kind = array.attribute("type").unwrap_or("");
        convert(kind, &data, big)
            .ok_or_else(|| fault(format!("numbers of type `{kind}` are not supported")))
    }
}

impl Bytes<'_> {
    /// The first `n` bytes, and what follows the characters they end in.
    fn take(&self, n: usize) -> Option<(Vec<u8>, Bytes<'_>)> {
        match self {
            Bytes::Raw(b) => Some((b.get(..n)?.to_vec(), Bytes::Raw(&b[n..]))),
            Bytes::Base64(text) => {
                let (bytes, used) = from_base64(text, n)?;
                Some((bytes, Bytes::Base64(&text[used..])))
            }
        }
    }
}

fn word(b: &[u8], big: bool) -> Option<usize> {
    let x = match b.len() {
        4 => u32::read(b, big),
        _ => u64::read(b, big),
    };
    (x < 1e12).then_some(x as usize)
}

/// A header with the number of bytes, and these. Writers encode both together or apart.
fn plain(bytes: &Bytes<'_>, wide: usize, big: bool) -> Option<Vec<u8>> {
    let n = word(&bytes.take(wide)?.0, big)?;
    Some(bytes.take(wide.checked_add(n)?)?.0.split_off(wide))
}

/// A header with the number of blocks, their size, that of the last one and those when compressed.
fn inflated(bytes: &Bytes<'_>, wide: usize, big: bool) -> Option<Vec<u8>> {
    let blocks = word(&bytes.take(wide)?.0, big)?;
    let length = wide.checked_mul(blocks.checked_add(3)?)?;
    let (header, mut rest) = bytes.take(length)?;
    let head: Vec<usize> =
        header.chunks_exact(wide).map(|b| word(b, big)).collect::<Option<_>>()?;
    let total = head[3..].iter().sum();
    let (packed, _) = rest.take(total)?;
    rest = Bytes::Raw(&packed);
    let mut out = Vec::new();
    let Bytes::Raw(mut packed) = rest else { return None };
    for &size in &head[3..] {
        let (block, after) = packed.split_at_checked(size)?;
        // No more than the header says: a few damaged bytes may unpack to anything.
        let (before, most) = (out.len(), head[1] as u64);
        ZlibDecoder::new(block).take(most + 1).read_to_end(&mut out).ok()?;
        if (out.len() - before) as u64 > most {
            return None;
        }
        packed = after;
    }
    Some(out)
}

/// The first `n` bytes of base64 text, in which one piece with padding may follow another, and the
/// number of characters they took.
fn from_base64(text: &[u8], n: usize) -> Option<(Vec<u8>, usize)> {
    let value = |c: u8| -> Option<u32> {
        Some(u32::from(match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        }))
    };
    let mut out = Vec::with_capacity(n.min(text.len()) + 3);
    let (mut bits, mut count) = (0u32, 0);
    for (i, &c) in text.iter().enumerate() {
        if c.is_ascii_whitespace() {
            continue;
        }
        // Of padded characters the first bytes alone are meant.
        let padding = c == b'=';
        bits = bits << 6 | if padding { 0 } else { value(c)? };
        count += 1 + if padding { 8 } else { 0 };
        if count % 8 == 4 {
            let bytes = bits.to_be_bytes();
            out.extend(&bytes[1..4 - (count / 8).min(2)]);
            (bits, count) = (0, 0);
            if out.len() >= n {
                out.truncate(n);
                return Some((out, i + 1));
            }
        }
    }
    (n == 0).then_some((out, 0))
}

/// A number of a file.
trait Number {
    /// From its bytes, which are as many as it has.
    fn read(b: &[u8], big: bool) -> f64;
}

macro_rules! numbers {
    ($($t:ty)*) => {$(
        impl Number for $t {
            fn read(b: &[u8], big: bool) -> f64 {
                let mut bytes = [0; size_of::<$t>()];
                bytes.copy_from_slice(b);
                (if big { <$t>::from_be_bytes(bytes) } else { <$t>::from_le_bytes(bytes) }) as f64
            }
        }
    )*};
}
numbers!(f64 f32 i64 u64 i32 u32 i16 u16 i8 u8);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_base64_may_follow_one_another() {
        // "abc" and "d" each on its own, then "abcd" as one.
        assert_eq!(from_base64(b"YWJjZA==", 4).unwrap(), (b"abcd".to_vec(), 8));
        assert_eq!(from_base64(b"YWI=Y2Q=", 4).unwrap().0, b"abcd");
        assert_eq!(from_base64(b"YQ==YmNk", 4).unwrap().0, b"abcd");
        assert_eq!(from_base64(b"YWJj", 2).unwrap(), (b"ab".to_vec(), 4));
        assert!(from_base64(b"YWJj", 4).is_none() && from_base64(b"YW!j", 3).is_none());
    }
}
