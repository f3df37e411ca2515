//! Lists inside values: `( .. )`, `[ .. ]`, `N( .. )`, `N{v}`, `List<T> N ( .. )`.

use crate::diag::Diag;
use crate::lists::{self, Elem, Payload};
use crate::parse::{Broken, Cursor, Parser};
use crate::source::Span;
use crate::token::{Lexeme, lex};
use crate::tree::{Tok, Token};
use std::sync::Arc;

/// Lists of numbers from this length on are one token.
const PACK: usize = 256;
impl Parser<'_> {
    /// The inside of `( )` whose opening was taken.
    pub(crate) fn list(&mut self, c: &mut Cursor, open: &Span) -> Result<(Tok, Span), Broken> {
        if let Some(elem) = lists::guess(&c.src.text, c.at)
            && let Ok((payload, end)) = lists::ascii(&c.src.text, c.at, elem)
            && payload.len() >= PACK
        {
            c.at = end;
            let close = Span::new(&c.src, end - 1..end);
            return Ok((Tok::Packed(Arc::new(lists::narrow(payload))), close));
        }
        if self.too_deep(c, open) {
            return Err(Broken);
        }
        self.depth += 1;
        let result = self.items(c, open);
        self.depth -= 1;
        result
    }
    fn items(&mut self, c: &mut Cursor, open: &Span) -> Result<(Tok, Span), Broken> {
        let mut items = Vec::new();
        loop {
            if let Some(close) = c.take(b')') {
                return Ok((Tok::List(items), close));
            }
            if matches!(c.peek().0, Lexeme::End | Lexeme::Mark(b';' | b'}')) {
                let d = Diag::error(open, "this list is not closed").label("no matching `)`");
                self.push(d);
                return Err(Broken);
            }
            self.item(c, &mut items)?;
        }
    }
    pub(crate) fn bracket(
        &mut self,
        c: &mut Cursor,
        open: Span,
        out: &mut Vec<Token>,
    ) -> Result<(), Broken> {
        let mut items = Vec::new();
        loop {
            if let Some(close) = c.take(b']') {
                out.push(Token { kind: Tok::Bracket(items), span: open.to(&close) });
                return Ok(());
            }
            match c.peek().0 {
                Lexeme::End | Lexeme::Mark(b';' | b'}' | b'{' | b'(' | b')' | b'[') => {
                    self.push(
                        Diag::error(&open, "these dimensions are not closed")
                            .label("no matching `]`"),
                    );
                    return Err(Broken);
                }
                _ => self.item(c, &mut items)?,
            }
        }
    }
    /// A whole number: by itself, the length of a list `4(0 1 2 3)`, or of equal items `5{0}`.
    pub(crate) fn counted(
        &mut self,
        c: &mut Cursor,
        n: i64,
        span: Span,
        out: &mut Vec<Token>,
    ) -> Result<(), Broken> {
        let number = Token { kind: Tok::Label(n), span: span.clone() };
        match c.src.text.get(c.at) {
            Some(b'{') => {
                c.at += 1;
                out.push(self.repeated(c, n, &span)?);
            }
            Some(b'(') => {
                c.at += 1;
                let open = Span::new(&c.src, c.at - 1..c.at);
                let (kind, close) = self.list(c, &open)?;
                let len = match &kind {
                    Tok::List(items) => items.len(),
                    Tok::Packed(p) => p.len(),
                    _ => 0,
                };
                // `(0(1 2 3))` may also be a pair of a time and a vector.
                if usize::try_from(n) == Ok(len) {
                    out.push(Token { kind, span: span.to(&close) });
                } else {
                    out.push(number);
                    out.push(Token { kind, span: open.to(&close) });
                }
            }
            _ => out.push(number),
        }
        Ok(())
    }
    /// The inside of `N{ }`, brace taken.
    fn repeated(&mut self, c: &mut Cursor, n: i64, count: &Span) -> Result<Token, Broken> {
        if self.too_deep(c, count) {
            return Err(Broken);
        }
        self.depth += 1;
        let token = self.repeated_inside(c, n, count);
        self.depth -= 1;
        token
    }
    fn repeated_inside(&mut self, c: &mut Cursor, n: i64, count: &Span) -> Result<Token, Broken> {
        /// Items of one list; beyond it a typing error is likelier than a list.
        const MOST: i64 = 1 << 26;
        let mut items = Vec::new();
        let close = loop {
            if let Some(close) = c.take(b'}') {
                break close;
            }
            if matches!(c.peek().0, Lexeme::End | Lexeme::Mark(b';' | b')')) {
                self.push(
                    Diag::error(count, "this `N{value}` is not closed").label("no matching `}`"),
                );
                return Err(Broken);
            }
            self.item(c, &mut items)?;
        };
        let span = count.to(&close);
        let (Ok(len), [item]) = (usize::try_from(n), items.as_slice()) else {
            self.push(
                Diag::error(&span, "`N{value}` needs a length and one value").label("not a list"),
            );
            return Ok(Token { kind: Tok::List(Vec::new()), span });
        };
        if n > MOST {
            self.push(
                Diag::error(count, format!("a list of {n} items is too long"))
                    .label("at most 67108864"),
            );
            return Ok(Token { kind: Tok::List(Vec::new()), span });
        }
        let one = match &item.kind {
            Tok::Label(i) => Some(Payload::Labels(vec![*i])),
            Tok::Number(x) => Some(Payload::Scalars(vec![*x])),
            Tok::List(_) => item.vec3().map(|v| Payload::Vectors(vec![v])),
            _ => None,
        };
        let packed = one.filter(|_| len >= PACK).and_then(|one| lists::repeat(&one, len));
        let kind = match packed {
            Some(p) => Tok::Packed(Arc::new(p)),
            None if self.afford(len, count) => Tok::List(vec![item.clone(); len]),
            None => Tok::List(Vec::new()),
        };
        Ok(Token { kind, span })
    }
    /// Behind `List<T>`: `N ( .. )` in the format of the file, `( .. )`, `N{v}`.
    pub(crate) fn typed_list(
        &mut self,
        c: &mut Cursor,
        word: String,
        elem: Option<Elem>,
        span: Span,
        out: &mut Vec<Token>,
    ) -> Result<(), Broken> {
        let start = c.at;
        let mut count = None;
        if let (Lexeme::Label(n), at) = c.peek() {
            c.at = at.range.end;
            count = Some((n, at));
        }
        if let (Some((n, at)), Some(_)) = (&count, c.take(b'{')) {
            let mut token = self.repeated(c, *n, &at.clone())?;
            token.span = span.to(&token.span);
            out.push(token);
            return Ok(());
        }
        let Some(open) = c.take(b'(') else {
            match (&count, elem) {
                // OpenFOAM writes an empty binary list without parentheses.
                (Some((0, at)), Some(elem)) => {
                    let kind = Tok::Packed(Arc::new(lists::empty(elem)));
                    out.push(Token { kind, span: span.to(at) });
                }
                _ => {
                    c.at = start;
                    out.push(Token { kind: Tok::Word(word), span });
                }
            }
            return Ok(());
        };
        let Some(elem) = elem else {
            let (kind, close) = self.list(c, &open)?;
            out.push(Token { kind, span: span.to(&close) });
            return Ok(());
        };
        let len = count.as_ref().map(|(n, at)| (usize::try_from(*n).unwrap_or(usize::MAX), at));
        let read = match (c.binary, len) {
            (Some(arch), Some((n, _))) => lists::binary(&c.src.text, c.at, elem, n, arch),
            _ => lists::ascii(&c.src.text, c.at, elem),
        };
        match read {
            Ok((payload, end)) => {
                c.at = end;
                if let Some((n, at)) = len.filter(|(n, _)| *n != payload.len()) {
                    let found = payload.len();
                    let d =
                        Diag::error(at, format!("this list announces {n} items and holds {found}"));
                    self.push(d.label(format!("expected {found}")));
                }
                let span = span.to(&Span::new(&c.src, end - 1..end));
                out.push(Token { kind: Tok::Packed(Arc::new(payload)), span });
                Ok(())
            }
            Err(e) => {
                let b = &c.src.text;
                let end = lex(b, e.at).1.end.clamp(e.at, b.len());
                let at = Span::new(&c.src, e.at.min(end)..end);
                self.push(Diag::error(&at, e.message).label(e.label));
                if c.binary.is_some() {
                    // Raw bytes cannot be searched for the next entry.
                    c.abandon();
                    self.silent = true;
                    return Err(Broken);
                }
                c.at = close_of(b, open.range.end);
                let span = span.to(&Span::new(&c.src, c.at..c.at));
                out.push(Token { kind: Tok::Packed(Arc::new(lists::empty(elem))), span });
                Ok(())
            }
        }
    }
}

/// `List<T>`: the kind of `T`, `None` inside for one without a packed form.
pub(crate) fn typed(word: &str) -> Option<Option<Elem>> {
    let t = word.strip_prefix("List<")?.strip_suffix('>')?;
    Some(Elem::of_type(t))
}

/// Offset behind the `)` that closes a list, parentheses counted; stops before `;` and `}`.
fn close_of(b: &[u8], mut at: usize) -> usize {
    let mut depth = 1usize;
    loop {
        let (l, r) = lex(b, at);
        match l {
            Lexeme::Mark(b'(') => depth += 1,
            Lexeme::Mark(b')') if depth == 1 => return r.end,
            Lexeme::Mark(b')') => depth -= 1,
            Lexeme::Mark(b';' | b'}') | Lexeme::End => return r.start,
            _ => {}
        }
        at = r.end;
    }
}
