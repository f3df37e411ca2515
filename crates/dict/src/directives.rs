//! `#directives`: includes, input modes, removal, branches, and what is refused by name.

use crate::diag::Diag;
use crate::expand::skip_entry;
use crate::nearest;
use crate::parse::{Cursor, Parser};
use crate::source::{Source, Span};
use crate::token::{Lexeme, lex};
use crate::tree::{Entry, Key, Pattern, Tok, Token};
use std::io;

/// What happens when a keyword occurs again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InputMode {
    /// Dictionaries merge, other entries are replaced.
    Merge,
    /// The new one replaces the old one.
    Overwrite,
    /// The old one stays.
    Protect,
    /// The old one stays, and it is said.
    Warn,
    /// It is an error.
    Error,
}

const DIRECTIVES: &[&str] = &[
    "include",
    "includeIfPresent",
    "sinclude",
    "includeEtc",
    "sincludeEtc",
    "includeFunc",
    "inputMode",
    "inputSyntax",
    "remove",
    "calc",
    "eval",
    "codeStream",
    "if",
    "ifeq",
    "else",
    "endif",
    "message",
];

impl Parser<'_> {
    /// A `#name` where a keyword is needed.
    pub(crate) fn directive(&mut self, c: &mut Cursor, name: &str, span: &Span) {
        match name {
            "include" => self.include(c, span, false, None),
            "includeIfPresent" | "sinclude" => self.include(c, span, true, None),
            "includeEtc" | "sincludeEtc" => self.include_etc(c, span),
            "includeFunc" => self.include_func(c, span),
            // `$a.b` and `$a/b` are read alike.
            "inputSyntax" => {
                c.next();
            }
            "inputMode" => self.input_mode(c),
            "remove" => self.remove(c, span),
            "if" | "ifeq" => self.conditional(c, name, span),
            // The branch before was taken: what follows up to #endif is not.
            "else" => skip_branch(c, true),
            "endif" => {}
            "message" => {
                c.next();
            }
            "codeStream" => self.refuse_code(c, span),
            "calc" | "eval" => {
                self.push(
                    Diag::error(span, format!("`#{name}` needs a keyword before it"))
                        .label("a keyword is needed here"),
                );
                skip_entry(c);
            }
            _ => {
                self.unknown_directive(name, span);
                rest_of_line(c, span);
            }
        }
    }
    fn unknown_directive(&mut self, name: &str, span: &Span) {
        let near =
            nearest(name, DIRECTIVES.iter().copied()).map(|n| format!("did you mean `#{n}`?"));
        let d = Diag::error(span, format!("unknown directive `#{name}`"));
        self.push(d.label("not known").maybe_help(near));
    }
    /// A `#name` in a value.
    pub(crate) fn value_directive(
        &mut self,
        c: &mut Cursor,
        name: &str,
        span: &Span,
        out: &mut Vec<Token>,
    ) {
        match name {
            "calc" | "eval" => {
                if let Some((text, at, whole)) = self.expression_text(c, span) {
                    let kind = self.arithmetic(&text, &whole, at, name == "calc");
                    out.push(Token {
                        kind: kind.unwrap_or(Tok::Number(f64::NAN)),
                        span: span.to(&whole),
                    });
                }
            }
            "include" => self.include(c, span, false, Some(out)),
            "includeIfPresent" | "sinclude" => self.include(c, span, true, Some(out)),
            "codeStream" => self.refuse_code(c, span),
            _ => self.unknown_directive(name, span),
        }
    }
    fn refuse_code(&mut self, c: &mut Cursor, span: &Span) {
        let d = Diag::error(span, "`#codeStream` is refused: granflow does not compile C++");
        self.push(d.label("refused").help("write the value, or use `#calc \"expression\"`"));
        if let Some(open) = c.take(b'{') {
            let before = self.diags.len();
            self.block(c, String::new(), open, None);
            // Its code uses macros of its own; one message is enough.
            self.diags.truncate(before);
        }
    }
    fn include(
        &mut self,
        c: &mut Cursor,
        span: &Span,
        optional: bool,
        out: Option<&mut Vec<Token>>,
    ) {
        let (lexeme, at) = c.next();
        let (Lexeme::Str { text: name, .. } | Lexeme::Word(name) | Lexeme::Template(name)) = lexeme
        else {
            let d = Diag::error(span, "the name of a file is needed behind `#include`");
            self.push(d.label("such as `#include \"other\"`"));
            c.at = at.range.start;
            return;
        };
        let root = self.files.case_root();
        let mut name = name;
        for (mark, folder) in [
            ("<case>", ""),
            ("<constant>", "constant"),
            ("<system>", "system"),
            ("$FOAM_CASE", ""),
            ("${FOAM_CASE}", ""),
        ] {
            if let Some(rest) = name.strip_prefix(mark) {
                let parts = [root.as_str(), folder, rest.trim_start_matches('/')];
                name =
                    parts.iter().filter(|p| !p.is_empty()).copied().collect::<Vec<_>>().join("/");
                break;
            }
        }
        let from_root = matches!(c.src.text.get(at.range.start + 1), Some(b'<'))
            || at.text().contains("FOAM_CASE");
        let name = self.expand_text(&name, &at);
        let path =
            if from_root || name.starts_with('/') { name } else { normal(c.src.folder(), &name) };
        if self.open_files.contains(&path) || self.open_files.len() > 30 {
            let d = Diag::error(&at, format!("`{path}` includes itself"));
            self.push(d.label("this would never end"));
            return;
        }
        let bytes = match self.files.load(&path).and_then(crate::decompress) {
            Ok(b) => b,
            Err(e) if optional && e.kind() == io::ErrorKind::NotFound => return,
            Err(e) => {
                let why = if e.kind() == io::ErrorKind::NotFound {
                    "no such file".into()
                } else {
                    e.to_string()
                };
                let d = Diag::error(&at, format!("cannot include `{path}`: {why}"));
                self.push(d.label("included here"));
                self.lose();
                return;
            }
        };
        let src = Source::new(path.clone(), bytes);
        let mut inner = Cursor::new(&src);
        self.open_files.push(path);
        match out {
            Some(out) => self.splice(&mut inner, out),
            None => {
                self.entries(&mut inner, None);
            }
        }
        self.open_files.pop();
    }
    /// The tokens of a file as part of a value.
    fn splice(&mut self, c: &mut Cursor, out: &mut Vec<Token>) {
        loop {
            match c.peek().0 {
                Lexeme::End => return,
                Lexeme::Mark(b';') => {
                    c.next();
                }
                _ => {
                    if self.item(c, out).is_err() {
                        return;
                    }
                }
            }
        }
    }
    fn input_mode(&mut self, c: &mut Cursor) {
        let (_, at) = c.next();
        self.mode = match &*at.text() {
            "merge" | "default" => InputMode::Merge,
            "overwrite" => InputMode::Overwrite,
            "protect" => InputMode::Protect,
            "warn" => InputMode::Warn,
            "error" => InputMode::Error,
            other => {
                let modes = ["merge", "overwrite", "protect", "warn", "error", "default"];
                let near = nearest(other, modes).map(|n| format!("did you mean `{n}`?"));
                let d = Diag::error(&at, format!("unknown input mode `{other}`"));
                self.push(d.label(format!("one of {}", modes.join(", "))).maybe_help(near));
                return;
            }
        };
    }
    fn remove(&mut self, c: &mut Cursor, span: &Span) {
        let mut tokens = Vec::new();
        if self.item(c, &mut tokens).is_err() {
            return;
        }
        let flat: Vec<&Token> =
            tokens.iter().flat_map(|t| t.list().map_or(vec![t], |l| l.iter().collect())).collect();
        for t in flat {
            match &t.kind {
                Tok::Word(w) => {
                    self.here().remove(w);
                }
                Tok::Str(p) => {
                    let key = Key::Regex(Pattern::new(p).0);
                    self.here().entries.retain(|e: &Entry| !key.matches(e.key.text()));
                }
                _ => self.push(
                    Diag::error(span, "`#remove` needs keywords").label("such as `#remove (a b)`"),
                ),
            }
        }
    }
    /// `#if value` and `#ifeq a b`: goes on behind it when true, else behind `#else` or `#endif`.
    fn conditional(&mut self, c: &mut Cursor, name: &str, span: &Span) {
        let mut args = Vec::new();
        let wanted = if name == "if" { 1 } else { 2 };
        while args.len() < wanted {
            if self.item(c, &mut args).is_err() {
                return;
            }
        }
        let text = |t: &Token| {
            t.text().map(str::to_owned).or_else(|| t.number().map(crate::writer::number))
        };
        let holds = match args.as_slice() {
            [a] => match (a.number(), a.word()) {
                (Some(x), _) => Some(x != 0.0),
                (_, Some("true" | "on" | "yes" | "y" | "t")) => Some(true),
                (_, Some("false" | "off" | "no" | "n" | "f" | "none")) => Some(false),
                _ => None,
            },
            [a, b] => Some(text(a) == text(b)),
            _ => None,
        };
        if holds.is_none() {
            self.push(
                Diag::error(span, format!("`#{name}` needs a value that is true or false"))
                    .label("taken as false"),
            );
        }
        if holds != Some(true) {
            skip_branch(c, false);
        }
    }
}

/// Folder and name with `./` and `a/../` taken out, so that one file has one path.
fn normal(folder: &str, name: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    let joined = format!("{folder}{name}");
    for p in joined.split('/') {
        match p {
            "." => {}
            ".." if parts.last().is_some_and(|l| !l.is_empty() && *l != "..") => {
                parts.pop();
            }
            p => parts.push(p),
        }
    }
    parts.join("/")
}

/// Takes the rest of the line; the span runs from `from` to its end.
fn rest_of_line(c: &mut Cursor, from: &Span) -> Span {
    let line = c.src.line_range(c.at);
    let text = &c.src.text[c.at.min(line.end)..line.end];
    let cut = text.windows(2).position(|w| w == b"//").unwrap_or(text.len());
    let end = c.at + text[..cut].trim_ascii_end().len();
    c.at = line.end;
    Span::new(&c.src, from.range.start..end.max(from.range.end))
}

/// Skips to behind the `#endif` (or `#else`) of the branch at hand.
fn skip_branch(c: &mut Cursor, past_else: bool) {
    let mut depth = 0usize;
    loop {
        let (l, r) = lex(&c.src.text, c.at);
        c.at = r.end;
        match l {
            Lexeme::End => return,
            Lexeme::Directive(d) => match d.as_str() {
                "if" | "ifeq" => depth += 1,
                "endif" if depth == 0 => return,
                "endif" => depth -= 1,
                "else" if depth == 0 && !past_else => return,
                _ => {}
            },
            _ => {}
        }
    }
}
