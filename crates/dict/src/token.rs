//! Bytes to lexemes, with OpenFOAM's odd rules: words hold balanced parentheses
//! (`div(phi,U)`), numbers stop at `(` and `{` (`4(0 1 2 3)`, `5{0}`), `#{ .. #}` is verbatim.

use crate::scan;
use std::ops::Range;

/// The smallest piece of text with a meaning.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Lexeme {
    /// End of the text.
    End,
    /// One of `{ } ( ) [ ] ;`.
    Mark(u8),
    /// A bare word.
    Word(String),
    /// A word with `${..}` inside.
    Template(String),
    /// A quoted text; `closed` is false when the line ends before the quote.
    Str {
        text: String,
        closed: bool,
    },
    /// `#{ .. #}`.
    Verbatim {
        text: String,
        closed: bool,
    },
    Number(f64),
    Label(i64),
    /// `$name` or `${name}`.
    Macro(String),
    /// `${{ expression }}`.
    Expression(String),
    /// `#name`.
    Directive(String),
    /// `,` or `=` on its own.
    Punct(char),
}

fn lossy(b: &[u8]) -> String {
    String::from_utf8_lossy(b).into_owned()
}

/// The lexeme at or behind `from` and its bytes.
pub(crate) fn lex(b: &[u8], from: usize) -> (Lexeme, Range<usize>) {
    let at = scan::space(b, from);
    let Some(&c) = b.get(at) else { return (Lexeme::End, b.len()..b.len()) };
    let one = at..at + 1;
    match c {
        b'{' | b'}' | b'(' | b')' | b'[' | b']' | b';' => (Lexeme::Mark(c), one),
        b',' | b'=' | b'\'' => (Lexeme::Punct(char::from(c)), one),
        b'"' => quoted(b, at),
        b'#' if b.get(at + 1) == Some(&b'{') => verbatim(b, at),
        b'#' if b.get(at + 1).is_some_and(u8::is_ascii_alphabetic) => {
            let end = run(b, at + 1, |c| c.is_ascii_alphanumeric() || c == b'_');
            (Lexeme::Directive(lossy(&b[at + 1..end])), at..end)
        }
        b'$' => variable(b, at),
        b'0'..=b'9' | b'+' | b'-' | b'.' => numeric(b, at),
        _ => word(b, at),
    }
}

fn run(b: &[u8], from: usize, ok: impl Fn(u8) -> bool) -> usize {
    b[from..].iter().position(|&c| !ok(c)).map_or(b.len(), |n| from + n)
}

fn numeric(b: &[u8], at: usize) -> (Lexeme, Range<usize>) {
    let Some((x, end, whole)) = scan::number(b, at) else { return word(b, at) };
    match scan::label(b, at) {
        Some((i, _)) if whole => (Lexeme::Label(i), at..end),
        _ => (Lexeme::Number(x), at..end),
    }
}

fn quoted(b: &[u8], at: usize) -> (Lexeme, Range<usize>) {
    let mut text = Vec::new();
    let mut i = at + 1;
    while let Some(&c) = b.get(i) {
        match (c, b.get(i + 1)) {
            (b'"', _) => return (Lexeme::Str { text: lossy(&text), closed: true }, at..i + 1),
            (b'\\', Some(b'"')) => {
                text.push(b'"');
                i += 2;
            }
            (b'\\', Some(b'\n')) => i += 2,
            (b'\\', Some(b'\\')) => {
                text.extend_from_slice(b"\\\\");
                i += 2;
            }
            (b'\n', _) => break,
            _ => {
                text.push(c);
                i += 1;
            }
        }
    }
    // What follows on the line is most likely the end of the entry, not part of the text.
    let line = &b[at + 1..i.min(b.len())];
    let cut = line.iter().rposition(|&c| c == b';').unwrap_or(line.len());
    (Lexeme::Str { text: lossy(&line[..cut]), closed: false }, at..at + 1 + cut)
}

fn verbatim(b: &[u8], at: usize) -> (Lexeme, Range<usize>) {
    let body = &b[at + 2..];
    match body.windows(2).position(|w| w == b"#}") {
        Some(n) => (Lexeme::Verbatim { text: lossy(&body[..n]), closed: true }, at..at + n + 4),
        None => (Lexeme::Verbatim { text: lossy(body), closed: false }, at..b.len()),
    }
}

fn in_name(c: u8) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, b'_' | b'.' | b':' | b'/' | b'!' | b'|' | b'-' | b'+')
}

fn variable(b: &[u8], at: usize) -> (Lexeme, Range<usize>) {
    if b[at..].starts_with(b"${{") {
        if let Some(n) = b[at + 3..].windows(2).position(|w| w == b"}}") {
            return (Lexeme::Expression(lossy(&b[at + 3..at + 3 + n])), at..at + n + 5);
        }
    } else if b.get(at + 1) == Some(&b'{') {
        if let Some(end) = brace_end(b, at + 1) {
            let whole = word_end(b, at);
            if whole > end {
                return (Lexeme::Template(lossy(&b[at..whole])), at..whole);
            }
            return (Lexeme::Macro(lossy(&b[at + 2..end - 1])), at..end);
        }
    } else {
        let mut end = run(b, at + 1, in_name);
        // `$x//comment` and `$x/*..*/`: the name ends before the comment.
        if let Some(n) = b[at..end].windows(2).position(|w| w == b"//") {
            end = at + n;
        }
        if b.get(end) == Some(&b'*') && b[end - 1] == b'/' {
            end -= 1;
        }
        if end > at + 1 {
            return (Lexeme::Macro(lossy(&b[at + 1..end])), at..end);
        }
    }
    word(b, at)
}

fn word(b: &[u8], at: usize) -> (Lexeme, Range<usize>) {
    let end = word_end(b, at).max(at + 1);
    let text = lossy(&b[at..end]);
    let kind = if text.contains("${") { Lexeme::Template(text) } else { Lexeme::Word(text) };
    (kind, at..end)
}

fn stops(c: u8) -> bool {
    c <= b' ' || matches!(c, b'"' | b';' | b'{' | b'}' | b'[' | b']' | b'\'')
}

/// Offset behind the `}` that closes the `{` of a `${name}` at `open`, on the same line; names may
/// hold names: `${a${b}}`.
pub(crate) fn brace_end(b: &[u8], open: usize) -> Option<usize> {
    let mut depth = 0usize;
    for (n, &c) in b.get(open..)?.iter().enumerate() {
        match c {
            b'{' if depth == 0 || b[open + n - 1] == b'$' => depth += 1,
            b'}' if depth == 1 => return Some(open + n + 1),
            b'}' => depth -= 1,
            b'{' | b'\n' | b';' => return None,
            _ => {}
        }
    }
    None
}

fn word_end(b: &[u8], at: usize) -> usize {
    let mut i = at;
    while let Some(&c) = b.get(i) {
        match c {
            b'$' if b.get(i + 1) == Some(&b'{') => match brace_end(b, i + 1) {
                Some(end) => i = end,
                None => return i + 1,
            },
            b'(' => match balanced(b, i) {
                Some(end) => i = end,
                None => return i,
            },
            b')' => return i,
            b'/' if matches!(b.get(i + 1), Some(b'/' | b'*')) => return i,
            c if stops(c) => return i,
            _ => i += 1,
        }
    }
    i
}

/// Offset behind the `)` that closes the `(` at `open`, when no white space or mark lies between:
/// `div(phi,U)` is a word, `vertices((0 0 0)` is a word and a list.
fn balanced(b: &[u8], open: usize) -> Option<usize> {
    // Longer than any word: keeps `((((((..` from being scanned once per parenthesis.
    const LONGEST: usize = 512;
    let mut depth = 0usize;
    for (n, &c) in b[open..].iter().take(LONGEST).enumerate() {
        match c {
            b'(' => depth += 1,
            b')' if depth == 1 => return Some(open + n + 1),
            b')' => depth -= 1,
            b'$' | b'|' => {}
            b'{' | b'}' if b[open..open + n].contains(&b'$') => {}
            c if stops(c) => return None,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<Lexeme> {
        let (mut at, mut out) = (0, Vec::new());
        loop {
            let (l, r) = lex(text.as_bytes(), at);
            if l == Lexeme::End {
                return out;
            }
            at = r.end;
            out.push(l);
        }
    }
    fn w(s: &str) -> Lexeme {
        Lexeme::Word(s.into())
    }

    #[test]
    fn words_keep_balanced_parentheses_and_leave_lists_alone() {
        assert_eq!(all("div(phi,U)"), [w("div(phi,U)")]);
        assert_eq!(all("div((nuEff*dev(T(grad(U)))))"), [w("div((nuEff*dev(T(grad(U)))))")]);
        let open = Lexeme::Mark(b'(');
        assert_eq!(all("vertices((0 0")[..3], [w("vertices"), open.clone(), open]);
        assert_eq!(all("(grad(p))")[1], w("grad(p)"));
    }

    #[test]
    fn numbers_end_at_brackets_and_odd_words_stay_words() {
        assert_eq!(all("4(0")[0], Lexeme::Label(4));
        assert_eq!(all("5{0.5}")[2], Lexeme::Number(0.5));
        assert_eq!(all("2D 1e-3 -5 +.5 -")[..2], [w("2D"), Lexeme::Number(1e-3)]);
        assert_eq!(all("-5 +.5 - nan"), [Lexeme::Label(-5), Lexeme::Number(0.5), w("-"), w("nan")]);
    }

    #[test]
    fn macros_and_directives() {
        let m = |s: &str| Lexeme::Macro(s.into());
        assert_eq!(all("$a;$:b.c ${d} $..e)")[..3], [m("a"), Lexeme::Mark(b';'), m(":b.c")]);
        assert_eq!(all("${d} $..e)")[..2], [m("d"), m("..e")]);
        assert_eq!(
            all("${a}_x b${a}"),
            [Lexeme::Template("${a}_x".into()), Lexeme::Template("b${a}".into())]
        );
        assert_eq!(
            all("#calc ${{1 + $a}}"),
            [Lexeme::Directive("calc".into()), Lexeme::Expression("1 + $a".into())]
        );
        assert_eq!(all("#{ a; #} b")[1], w("b"));
        assert_eq!(all("$x//c"), [m("x")]);
        assert_eq!(all("${a_${b}};")[0], m("a_${b}"));
        assert_eq!(all("${a_${b}}_c")[0], Lexeme::Template("${a_${b}}_c".into()));
    }

    #[test]
    fn an_unclosed_quote_ends_before_the_semicolon() {
        let l = all("\"abc;\nd e;");
        assert_eq!(l[0], Lexeme::Str { text: "abc".into(), closed: false });
        assert_eq!(l[1..3], [Lexeme::Mark(b';'), w("d")]);
        assert_eq!(all(r#""a\"b\\.c""#), [Lexeme::Str { text: r#"a"b\\.c"#.into(), closed: true }]);
    }
}
