//! `$macros` and the arithmetic of `#calc`, `#eval`, `${{ }}`.

use crate::arith;
use crate::diag::Diag;
use crate::environment;
use crate::nearest;
use crate::parse::{Cursor, Parser};
use crate::source::Span;
use crate::token::{Lexeme, brace_end};
use crate::tree::{Dict, Entry, Key, Pattern, Tok, Token, Value, number_kind};

impl Parser<'_> {
    // ---- macros

    /// What `name` (without `$`) stands for; `name:-word` has a default.
    fn lookup(&self, name: &str) -> Option<Value> {
        if let Some((name, default)) = name.split_once(":-") {
            let default = || default.parse::<f64>().map_or_else(|_| default.into(), Value::from);
            return self.lookup(name).or_else(|| Some(default()));
        }
        let top = self.scopes.len().checked_sub(1)?;
        if let Some(rest) = name.strip_prefix([':', '!']) {
            return self.descend(0, rest.trim_start_matches('/'));
        }
        if let Some(rest) = name.strip_prefix('/') {
            return self.descend(0, rest);
        }
        let (mut level, mut rest) = (top, name);
        if rest.starts_with("../") || rest.starts_with("./") {
            while let Some(r) = rest.strip_prefix("../") {
                level = level.checked_sub(1)?;
                rest = r;
            }
            return self.descend(level, rest.strip_prefix("./").unwrap_or(rest));
        }
        let bare = rest.trim_start_matches('.');
        let dots = rest.len() - bare.len();
        if dots > 0 {
            return self.descend(top.checked_sub(dots - 1)?, bare);
        }
        (0..=top)
            .rev()
            .find_map(|level| self.descend(level, name))
            .or_else(|| environment::variable(&*self.files, name))
    }
    /// Looks `path` up in the scope at `level`; keys may hold dots themselves (`alpha.water`).
    fn descend(&self, level: usize, path: &str) -> Option<Value> {
        let dict = &self.scopes.get(level)?.dict;
        if let Some(v) = dict.get(path) {
            self.referenced.borrow_mut().insert(path.to_owned());
            return Some(v.clone());
        }
        for (i, _) in path.match_indices(['.', '/']) {
            let (first, rest) = (&path[..i], &path[i + 1..]);
            // A dictionary still being read is not in its parent yet.
            if self.scopes.get(level + 1).is_some_and(|s| s.name == first && !first.is_empty())
                && let Some(v) = self.descend(level + 1, rest)
            {
                return Some(v);
            }
            if let Some(v) = dict.sub(first).and_then(|d| within(d, rest)) {
                self.referenced.borrow_mut().insert(first.to_owned());
                return Some(v);
            }
        }
        None
    }
    /// `name` with the macros inside it replaced: `a${b}` of `${a${b}}`.
    fn whole_name(&mut self, name: &str, span: &Span) -> String {
        if name.contains('$') { self.expand_text(name, span) } else { name.to_owned() }
    }
    fn unknown_macro(&mut self, name: &str, span: &Span) {
        if self.lost {
            self.gaps += 1;
            return;
        }
        let help = self.near_macro(name);
        self.push(
            Diag::error(span, format!("`${name}` is not defined")).label("unknown here").help(help),
        );
    }
    fn near_macro(&self, name: &str) -> String {
        let known: Vec<String> = self
            .scopes
            .iter()
            .flat_map(|s| &s.dict.entries)
            .map(|e| e.key.text().to_owned())
            .collect();
        let near = nearest(name, known.iter().map(String::as_str));
        near.map_or_else(
            || "define it above this line".to_owned(),
            |n| format!("did you mean `${n}`?"),
        )
    }
    /// `$name` where a keyword is needed.
    pub(crate) fn key_macro(&mut self, c: &mut Cursor, name: &str, span: &Span) {
        let ends = matches!(c.peek().0, Lexeme::Mark(b';' | b'}') | Lexeme::End);
        let name = &self.whole_name(name, span);
        match self.lookup(name) {
            None if ends && !self.lost => {
                // Cases rely on this: `${_${FOAM_EXECUTABLE}};` is for one program of several.
                let help = self.near_macro(name);
                let d = Diag::warning(span, format!("`${name}` is not defined"));
                self.push(d.label("nothing is inserted, as in OpenFOAM").help(help));
                skip_entry(c);
            }
            None => {
                self.unknown_macro(name, span);
                skip_entry(c);
            }
            Some(Value::Dict(d)) => {
                c.take(b';');
                if self.afford(size(&d), span) {
                    self.here().merge(d);
                }
            }
            Some(Value::Stream(t)) => match t.as_slice() {
                [Token { kind: Tok::Word(w), .. }] if !ends => {
                    self.value(c, Key::Word(w.clone()), span.clone());
                }
                [Token { kind: Tok::Str(w), .. }] if !ends => {
                    self.value(c, Key::Regex(Pattern::new(w).0), span.clone());
                }
                _ => {
                    let d = Diag::error(span, format!("`${name}` is not a sub-dictionary"));
                    self.push(d.label("only a sub-dictionary can be inserted here"));
                    skip_entry(c);
                }
            },
        }
    }
    /// `$name` in a value: its tokens.
    pub(crate) fn value_macro(&mut self, name: &str, span: &Span, out: &mut Vec<Token>) {
        let name = &self.whole_name(name, span);
        match self.lookup(name) {
            None => self.unknown_macro(name, span),
            Some(Value::Dict(d)) => {
                if self.afford(size(&d), span) {
                    out.push(Token { kind: Tok::Dict(d), span: span.clone() });
                }
            }
            Some(Value::Stream(t)) => {
                if self.afford(t.iter().map(weight).sum(), span) {
                    out.extend(t);
                }
            }
        }
    }
    /// Replaces `$name` and `${name}` in a text by the word, text or number they stand for.
    pub(crate) fn expand_text(&mut self, text: &str, span: &Span) -> String {
        self.expand_within(text, span, 0)
    }
    fn expand_within(&mut self, text: &str, span: &Span, depth: usize) -> String {
        /// Names in names in names: deeper is a typing error, and would exhaust the stack.
        const DEEPEST: usize = 5;
        let (mut out, mut rest) = (String::new(), text);
        while let Some(i) = rest.find('$') {
            out.push_str(&rest[..i]);
            let tail = &rest[i + 1..];
            let (name, used) = match tail.strip_prefix('{') {
                Some(_) => match brace_end(tail.as_bytes(), 0) {
                    Some(end) => (&tail[1..end - 1], end),
                    None => ("", 0),
                },
                None => {
                    let ok = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | ':');
                    let n = tail.find(|c| !ok(c)).unwrap_or(tail.len());
                    (&tail[..n], n)
                }
            };
            rest = &tail[used..];
            if name.is_empty() {
                // `$` at the end of a regular expression is an anchor.
                out.push('$');
                continue;
            }
            let inner;
            let name = if name.contains('$') && depth < DEEPEST {
                inner = self.expand_within(name, span, depth + 1);
                &inner
            } else {
                name
            };
            let value = match self.lookup(name) {
                Some(Value::Stream(t)) => match t.as_slice() {
                    [one] => one
                        .text()
                        .map(str::to_owned)
                        .or_else(|| one.number().map(crate::writer::number)),
                    _ => None,
                },
                _ => None,
            };
            match value {
                Some(v) => out.push_str(&v),
                None if self.lookup(name).is_some() => {
                    let d = Diag::error(span, format!("`${name}` cannot be part of a word"));
                    self.push(d.label("it is not a single word or number"));
                }
                None => self.unknown_macro(name, span),
            }
        }
        out.push_str(rest);
        out
    }

    /// The expression behind `#calc`: its text, where that starts, and the whole argument.
    pub(crate) fn expression_text(
        &mut self,
        c: &mut Cursor,
        span: &Span,
    ) -> Option<(String, usize, Span)> {
        let (lexeme, at) = c.peek();
        let start = at.range.start;
        let (text, inner) = match lexeme {
            Lexeme::Str { text, closed } => {
                self.check_quote(closed, &at);
                (text, start + 1)
            }
            Lexeme::Verbatim { text, .. } => (text, start + 2),
            Lexeme::Mark(b'{') => {
                let b = &c.src.text;
                let mut depth = 0usize;
                let end = (start..b.len()).find(|&i| {
                    match b[i] {
                        b'{' => depth += 1,
                        b'}' => depth -= 1,
                        _ => {}
                    }
                    depth == 0
                });
                let Some(end) = end else {
                    self.push(
                        Diag::error(&at, "this expression is not closed").label("no matching `}`"),
                    );
                    c.abandon();
                    return None;
                };
                c.at = end + 1;
                let text = String::from_utf8_lossy(&b[start + 1..end]).into_owned();
                return Some((text, start + 1, Span::new(&c.src, start..end + 1)));
            }
            _ => {
                let d = Diag::error(span, "an expression in quotes is needed here");
                self.push(d.label("such as `#calc \"2*$x\"`"));
                return None;
            }
        };
        c.at = at.range.end;
        Some((text, inner, at))
    }
    /// Evaluates an expression whose text starts at byte `start` of the file.
    pub(crate) fn arithmetic(
        &mut self,
        text: &str,
        whole: &Span,
        start: usize,
        cpp: bool,
    ) -> Option<Tok> {
        let look = |name: &str| match self.lookup(name) {
            None => Err(format!("`${name}` is not defined")),
            Some(Value::Stream(t)) if t.len() == 1 => t[0]
                .number()
                .ok_or_else(|| format!("`${name}` is {}, not a number", t[0].describe())),
            Some(Value::Stream(t)) if t.len() == 3 => {
                // OpenFOAM puts the text of the list there, and cannot evaluate it.
                Err(format!("`${name}` is a list, not a number: write `vector(x, y, z)`"))
            }
            Some(_) => Err(format!("`${name}` is not a number")),
        };
        match arith::eval(text, &look) {
            Ok(r) => {
                if cpp && r.cut_in_cpp {
                    let d = Diag::warning(whole, "a quotient of whole numbers in `#calc`");
                    let value = match r.value {
                        arith::Quantity::Number(x) => crate::writer::number(x),
                        arith::Quantity::Vector(v) => v.map(crate::writer::number).join(" "),
                    };
                    let d = d.label(format!("taken as {value} here"));
                    self.push(d.help("OpenFOAM compiles this as C++ and cuts the quotient; write `1.0/2` to mean the same in both"));
                }
                Some(match r.value {
                    arith::Quantity::Number(x) => number_kind(x),
                    arith::Quantity::Vector(v) => {
                        let of = |x: f64| Token { kind: number_kind(x), span: whole.clone() };
                        Tok::List(v.map(of).to_vec())
                    }
                })
            }
            Err(e) => {
                let at = (start + e.at).clamp(whole.range.start, whole.range.end);
                let at = Span::new(&whole.src, at..whole.range.end.min(at + 1).max(at));
                self.push(Diag::error(&at, e.message).label("in this expression"));
                None
            }
        }
    }
}

fn within(d: &Dict, path: &str) -> Option<Value> {
    if let Some(v) = d.get(path) {
        return Some(v.clone());
    }
    path.match_indices(['.', '/']).find_map(|(i, _)| within(d.sub(&path[..i])?, &path[i + 1..]))
}

fn weight(t: &Token) -> usize {
    match &t.kind {
        Tok::List(items) | Tok::Bracket(items) => 1 + items.iter().map(weight).sum::<usize>(),
        Tok::Dict(d) => size(d),
        _ => 1,
    }
}
fn size(d: &Dict) -> usize {
    let of = |e: &Entry| match &e.value {
        Value::Dict(d) => size(d),
        Value::Stream(t) => t.iter().map(weight).sum(),
    };
    1 + d.entries.iter().map(of).sum::<usize>()
}

/// Skips to behind the next `;`, or before the next `}`.
pub(crate) fn skip_entry(c: &mut Cursor) {
    loop {
        let (l, s) = c.peek();
        match l {
            Lexeme::End | Lexeme::Mark(b'}') => return,
            Lexeme::Mark(b';') => {
                c.at = s.range.end;
                return;
            }
            _ => c.at = s.range.end,
        }
    }
}
