//! Files that hold one list: `points`, `faces`, `owner`, `boundary`.

use crate::diag::Diag;
use crate::files::NoFiles;
use crate::lists::{self, Arch, Elem, ListError, Payload};
use crate::parse::{Cursor, Parser};
use crate::scan;
use crate::source::{Source, Span};
use crate::token::{Lexeme, lex};
use crate::tree::{Dict, Entry, Key, Tok, Token, Value};
use std::sync::Arc;

/// Parses a file that is a header and one list: the header's entries (empty without a header), the
/// list (empty when it cannot be read), and what is wrong.
pub fn parse_list_file(src: Arc<Source>) -> (Dict, Payload, Vec<Diag>) {
    let mut files = NoFiles;
    let mut p = Parser::new(&mut files);
    let mut c = Cursor::new(&src);
    let mut header = Dict::new();
    if let (Lexeme::Word(w), span) = c.peek()
        && w == "FoamFile"
    {
        c.at = span.range.end;
        if let Some(open) = c.take(b'{') {
            header = p.block(&mut c, w, open, None).unwrap_or_default();
        }
    }
    let class = header.word("class").unwrap_or("").to_owned();
    let arch = Arch::parse(header.word("arch").unwrap_or(""));
    c.binary = (header.word("format") == Some("binary")).then_some(arch);
    let elem = Elem::of_class(&class);
    let payload = match content(&mut p, &mut c, &class, elem) {
        Ok(payload) => payload,
        Err(e) => {
            let end = lex(&src.text, e.at).1.end.clamp(e.at.min(src.text.len()), src.text.len());
            let at = Span::new(&src, e.at.min(end)..end);
            p.push(Diag::error(&at, e.message).label(e.label));
            elem.map_or_else(|| Payload::Tokens(Vec::new()), lists::empty)
        }
    };
    (header, payload, p.diags)
}

fn content(
    p: &mut Parser<'_>,
    c: &mut Cursor,
    class: &str,
    elem: Option<Elem>,
) -> Result<Payload, ListError> {
    let src = c.src.clone();
    let b = &src.text;
    if let (Some(arch), "faceCompactList") = (c.binary, class) {
        let (payload, end) = lists::compact_faces(b, c.at, arch)?;
        c.at = end;
        return Ok(payload);
    }
    let start = scan::space(b, c.at);
    if class == "featureEdgeMesh" {
        let message = "a `featureEdgeMesh` is not read: edges of surfaces have no use here";
        return Err(ListError { at: start, message: message.into(), label: "refused" });
    }
    let mut count = None;
    let mut at = start;
    if let Some((n, end)) = scan::label(b, start) {
        count = Some(n);
        at = scan::space(b, end);
    }
    let wrong = |message: &str, label: &'static str| {
        Err(ListError { at, message: message.to_owned(), label })
    };
    let n = usize::try_from(count.unwrap_or(0)).unwrap_or(usize::MAX);
    match b.get(at) {
        Some(b'(') => {}
        Some(b'{') => {
            let mut out = Vec::new();
            c.at = start;
            // `N{v}`, which the parser of values knows.
            let _ = p.item(c, &mut out);
            return Ok(of_tokens(out, elem));
        }
        _ if count == Some(0) => return Ok(elem.map_or(Payload::Tokens(Vec::new()), lists::empty)),
        _ => return wrong("a list is needed here", "expected `(`"),
    }
    let body = at + 1;
    let guessed = elem.or_else(|| lists::guess(b, body));
    let payload = match (guessed, c.binary) {
        (Some(Elem::Face), None) if class == "faceCompactList" => {
            // Starts and points as two ascii lists: the same numbers as in binary.
            return ascii_compact(b, body);
        }
        (Some(elem), Some(arch)) if class != "polyBoundaryMesh" && count.is_some() => {
            let (payload, end) = lists::binary(b, body, elem, n, arch)?;
            c.at = end;
            return Ok(payload);
        }
        (Some(like), None) => {
            let (payload, end) = match lists::ascii(b, body, like) {
                // Only the first item looked like numbers: read it as tokens.
                Err(_) if elem.is_none() => return Ok(generic(p, c, at)),
                read => read?,
            };
            c.at = end;
            // A list without a class keeps whole numbers whole.
            if class.is_empty() { lists::narrow(payload) } else { payload }
        }
        _ => generic(p, c, at),
    };
    if count.is_some() && n != payload.len() {
        let found = payload.len();
        let place = Span::new(&src, start..at);
        let d = Diag::error(&place, format!("this list announces {n} items and holds {found}"));
        p.push(d.label(format!("expected {found}")));
    }
    let (rest, range) = lex(b, c.at);
    if c.binary.is_none() && !matches!(rest, Lexeme::End | Lexeme::Mark(b';')) {
        let d = Diag::warning(&Span::new(&src, range), "unexpected text behind the list");
        p.push(d.label("not read: the list ended before this"));
    }
    Ok(payload)
}

/// The list that opens at `at`, read token by token.
fn generic(p: &mut Parser<'_>, c: &mut Cursor, at: usize) -> Payload {
    c.at = at + 1;
    let open = Span::new(&c.src, at..at + 1);
    match p.list(c, &open) {
        Ok((Tok::List(items), _)) => entries(items),
        Ok((Tok::Packed(payload), _)) => Arc::unwrap_or_clone(payload),
        // Reported already; nothing behind it can be told apart.
        _ => {
            c.abandon();
            Payload::Tokens(Vec::new())
        }
    }
}

fn ascii_compact(b: &[u8], body: usize) -> Result<Payload, ListError> {
    let (first, mid) = lists::ascii(b, body, Elem::Label)?;
    let mut at = scan::space(b, mid);
    if let Some((_, end)) = scan::label(b, at) {
        at = scan::space(b, end);
    }
    let (second, _) = lists::ascii(b, (at + 1).min(b.len()), Elem::Label)?;
    let (Payload::Labels(starts), Payload::Labels(points)) = (first, second) else {
        return Err(ListError { at: body, message: "damaged list".into(), label: "here" });
    };
    lists::faces_of(&starts, &points, body)
}

/// `( name { .. } name { .. } )` as entries; anything else stays tokens.
fn entries(items: Vec<Token>) -> Payload {
    let named =
        |pair: &[Token]| pair.len() == 2 && pair[0].text().is_some() && pair[1].dict().is_some();
    if !items.chunks(2).all(named) {
        return Payload::Tokens(items);
    }
    let mut out = Vec::with_capacity(items.len() / 2);
    let mut key: Option<(String, Span)> = None;
    for t in items {
        match (t.kind, key.take()) {
            (Tok::Word(w) | Tok::Str(w), None) => key = Some((w, t.span)),
            (Tok::Dict(d), Some((k, key_span))) => {
                out.push(Entry::new(Key::Word(k), key_span, Value::Dict(d)));
            }
            _ => {}
        }
    }
    Payload::Entries(out)
}

fn of_tokens(mut out: Vec<Token>, elem: Option<Elem>) -> Payload {
    let Some(t) = out.pop() else { return Payload::Tokens(out) };
    let typed = match elem {
        Some(Elem::Label | Elem::Flag) => t.labels().map(Payload::Labels),
        Some(Elem::Scalar) => t.scalars().map(Payload::Scalars),
        Some(Elem::Vector) => t.vectors().map(Payload::Vectors),
        _ => None,
    };
    match (typed, t.kind) {
        (Some(p), _) => p,
        (None, Tok::Packed(p)) => Arc::unwrap_or_clone(p),
        (None, Tok::List(items)) => Payload::Tokens(items),
        (None, kind) => Payload::Tokens(vec![Token { kind, span: t.span }]),
    }
}
