//! Vertices and blocks that a dictionary refers to by name instead of by number.

use granflow_dict::{Token, TokenReader, nearest};
use std::collections::HashMap;

/// The names that `name WORD` in front of a vertex or a block has given.
#[derive(Default)]
pub(super) struct Names {
    pub(super) vertices: HashMap<String, u32>,
    pub(super) blocks: HashMap<String, u32>,
}

impl Names {
    /// Reads `name WORD`, if it is next. `None` when the name is missing.
    pub(super) fn opening<'a>(list: &mut TokenReader<'a>) -> Option<Option<&'a str>> {
        if list.peek().and_then(Token::word) != Some("name") {
            return Some(None);
        }
        list.next();
        let name = list.word("a name");
        (!name.is_empty()).then_some(Some(name))
    }

    /// The number a token stands for.
    fn number(names: &HashMap<String, u32>, token: &Token) -> Option<u32> {
        match token.label() {
            Some(n) => u32::try_from(n).ok(),
            None => token.word().and_then(|w| names.get(w).copied()),
        }
    }

    /// One vertex by number or name; a mistake is reported.
    pub(super) fn vertex(&self, list: &mut TokenReader<'_>, what: &str) -> Option<u32> {
        let at = list.here();
        let token = list.next();
        let found = token.and_then(|t| Names::number(&self.vertices, t));
        if found.is_none() {
            let help = token.and_then(|t| self.help(t));
            let message = format!("expected {what}, the number or the name of a vertex");
            list.error_at(&at, message, "not a vertex", help.as_deref());
        }
        found
    }

    /// Vertices in parentheses; a mistake is reported.
    pub(super) fn vertices(&self, list: &mut TokenReader<'_>, what: &str) -> Option<Vec<u32>> {
        let at = list.here();
        let token = list.next();
        if let Some(labels) = token.and_then(Token::labels) {
            let found: Option<Vec<u32>> = labels.iter().map(|&v| u32::try_from(v).ok()).collect();
            if found.is_some() {
                return found;
            }
        }
        let items = token.and_then(Token::list);
        let found =
            items.and_then(|l| l.iter().map(|t| Names::number(&self.vertices, t)).collect());
        if found.is_none() {
            let stranger = items.and_then(|l| l.iter().find_map(|t| self.help(t)));
            list.error_at(
                &at,
                format!("expected {what}, vertex numbers in parentheses"),
                "not a list of vertices",
                stranger.as_deref(),
            );
        }
        found
    }

    /// `(block side)` with a block by name or number, if the token is that.
    pub(super) fn side(&self, token: &Token) -> Option<(u32, u32)> {
        if let Some(labels) = token.labels() {
            let [b, s] = labels[..] else { return None };
            return Some((u32::try_from(b).ok()?, u32::try_from(s).ok()?));
        }
        let [b, s] = token.list()? else { return None };
        let block = self.blocks.get(b.word()?).copied()?;
        Some((block, u32::try_from(s.label()?).ok()?))
    }

    /// What may have been meant by a word that is no name.
    fn help(&self, token: &Token) -> Option<String> {
        let word = token.word().filter(|w| !self.vertices.contains_key(*w))?;
        let near = nearest(word, self.vertices.keys().map(String::as_str));
        Some(match near {
            Some(n) => format!("no vertex is called `{word}`; did you mean `{n}`?"),
            None => format!("no vertex is called `{word}`"),
        })
    }
}
