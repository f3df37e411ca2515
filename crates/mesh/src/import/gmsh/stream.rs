//! The bytes of a `.msh` file as numbers, text or binary.

use granflow_dict::{Diag, Source, Span};
use std::str::FromStr;
use std::sync::Arc;

/// A place in the file.
pub(super) struct Stream<'s> {
    src: &'s Arc<Source>,
    bytes: &'s [u8],
    at: usize,
    binary: bool,
    swapped: bool,
    /// Format 4.0, whose order of numbers differs from that of 4.1.
    pub(super) version_40: bool,
}

impl<'s> Stream<'s> {
    pub(super) fn new(src: &'s Arc<Source>) -> Stream<'s> {
        Stream { src, bytes: &src.text, at: 0, binary: false, swapped: false, version_40: false }
    }
    pub(super) fn binary(&self) -> bool {
        self.binary
    }
    /// The rest of the line.
    pub(super) fn here(&self) -> Span {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let n = rest.iter().take(80).position(|&b| b == b'\n').unwrap_or(rest.len().min(80));
        let n = if self.binary { 0 } else { n };
        Span::new(self.src, self.at..self.at + n)
    }
    fn skip_space(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }
    fn ended(&self, what: &str) -> Diag {
        let end = self.bytes.len();
        Diag::error(&Span::new(self.src, end..end), format!("the file ends where {what} is due"))
            .help("was it cut off? Save the mesh again")
    }

    /// The next section's name and place; `None` at the end of the file.
    pub(super) fn section(&mut self) -> Result<Option<(String, Span)>, Diag> {
        self.skip_space();
        if self.at >= self.bytes.len() {
            return Ok(None);
        }
        let (word, at) = self.word()?;
        match word.strip_prefix('$') {
            Some(name) if !name.is_empty() => Ok(Some((name.to_owned(), at))),
            _ => {
                let what = format!("expected the beginning of a section, found `{word}`");
                Err(Diag::error(&at, what).label("not `$Name`"))
            }
        }
    }
    /// Reads `$EndName`.
    pub(super) fn end_of(&mut self, name: &str) -> Result<(), Diag> {
        let (word, at) = self.word()?;
        if word == format!("$End{name}") {
            return Ok(());
        }
        let what = format!("expected `$End{name}`, found `{word}`");
        Err(Diag::error(&at, what).help("a number in the section does not say how much follows"))
    }
    pub(super) fn skip_to_end_of(&mut self, name: &str, from: &Span) -> Result<(), Diag> {
        let mark = format!("$End{name}");
        let rest = &self.bytes[self.at..];
        match rest.windows(mark.len()).position(|w| w == mark.as_bytes()) {
            Some(n) => {
                self.at += n + mark.len();
                Ok(())
            }
            None => Err(Diag::error(from, format!("the section has no `{mark}`"))),
        }
    }

    /// A word of text, whatever the rest of the file is.
    pub(super) fn word(&mut self) -> Result<(String, Span), Diag> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let n = rest.iter().take(200).position(u8::is_ascii_whitespace);
        let n = n.unwrap_or(rest.len().min(200));
        if n == 0 {
            return Err(self.ended("a word"));
        }
        let span = Span::new(self.src, self.at..self.at + n);
        self.at += n;
        Ok((String::from_utf8_lossy(&rest[..n]).into_owned(), span))
    }
    /// A number that is text in binary files too.
    pub(super) fn text_number<T: FromStr>(&mut self, what: &str) -> Result<T, Diag> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let n = rest.iter().take(64).position(u8::is_ascii_whitespace);
        let n = n.unwrap_or(rest.len().min(64));
        if n == 0 {
            return Err(self.ended(what));
        }
        let text = std::str::from_utf8(&rest[..n]).ok();
        let Some(number) = text.and_then(|t| t.parse().ok()) else {
            let span = Span::new(self.src, self.at..self.at + n);
            let found = String::from_utf8_lossy(&rest[..n]);
            return Err(Diag::error(&span, format!("expected {what}, found `{found}`")));
        };
        self.at += n;
        Ok(number)
    }
    /// A name in quotes.
    pub(super) fn quoted(&mut self) -> Result<String, Diag> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().skip(1).position(|&b| b == b'"');
        match (rest.first(), end) {
            (Some(b'"'), Some(n)) => {
                self.at += n + 2;
                Ok(String::from_utf8_lossy(&rest[1..=n]).into_owned())
            }
            _ => Err(Diag::error(&self.here(), "expected a name in quotes")),
        }
    }
    /// From here on numbers are binary; the number 1 says in which order their bytes are.
    pub(super) fn set_binary(&mut self, binary: bool) -> Result<(), Diag> {
        if !binary {
            return Ok(());
        }
        self.line_end();
        self.binary = true;
        let mark = self.raw::<4>("the number 1")?;
        self.swapped = match (u32::from_le_bytes(mark), u32::from_be_bytes(mark)) {
            (1, _) => false,
            (_, 1) => true,
            _ => {
                let what = "the binary number behind the format must be 1";
                return Err(Diag::error(&self.here(), what));
            }
        };
        Ok(())
    }
    /// In binary files the numbers of a section begin behind its name's line.
    pub(super) fn line_end(&mut self) {
        while self.bytes.get(self.at).is_some_and(|&b| b != b'\n') {
            self.at += 1;
        }
        self.at += 1;
    }
    fn raw<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Diag> {
        let found = self.bytes.get(self.at..self.at + N).and_then(|b| b.try_into().ok());
        let mut bytes: [u8; N] = found.ok_or_else(|| self.ended(what))?;
        self.at += N;
        if self.swapped {
            bytes.reverse();
        }
        Ok(bytes)
    }
    /// A number of four bytes in binary files.
    pub(super) fn int(&mut self, what: &str) -> Result<i64, Diag> {
        if self.binary {
            return Ok(i64::from(i32::from_le_bytes(self.raw(what)?)));
        }
        self.text_number(what)
    }
    /// A number of eight bytes in binary files.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, Diag> {
        if self.binary {
            return Ok(u64::from_le_bytes(self.raw(what)?));
        }
        self.text_number(what)
    }
    pub(super) fn double(&mut self, what: &str) -> Result<f64, Diag> {
        if self.binary {
            return Ok(f64::from_le_bytes(self.raw(what)?));
        }
        self.text_number(what)
    }
    /// Refuses counts that the rest of the file cannot hold.
    pub(super) fn plausible(&self, n: u64, what: &str) -> Result<u64, Diag> {
        if n > (self.bytes.len() - self.at.min(self.bytes.len())) as u64 {
            let text = format!("{n} {what} are announced, more than the rest of the file can hold");
            return Err(Diag::error(&self.here(), text));
        }
        Ok(n)
    }
}
