//! `#includeEtc`: the one file of OpenFOAM's `etc` folder that fields need, written anew.

use crate::diag::Diag;
use crate::nearest;
use crate::parse::{Cursor, Parser};
use crate::source::{Source, Span};
use crate::token::Lexeme;

/// Types of patch that leave a field no choice. Each is also the name of a group that its patches
/// belong to, so that one entry serves them all.
pub const CONSTRAINT_TYPES: &[&str] = &[
    "cyclic",
    "cyclicACMI",
    "cyclicAMI",
    "cyclicSlip",
    "empty",
    "nonuniformTransformCyclic",
    "processor",
    "processorCyclic",
    "symmetry",
    "symmetryPlane",
    "wedge",
];

/// What fields include in their `boundaryField`.
const CONSTRAINTS: &str = "caseDicts/setConstraintTypes";

impl Parser<'_> {
    /// Reads the file that is built in; refuses any other by name.
    pub(crate) fn include_etc(&mut self, c: &mut Cursor, span: &Span) {
        let (lexeme, at) = c.next();
        let (Lexeme::Str { text: name, .. } | Lexeme::Word(name)) = lexeme else {
            let d = Diag::error(span, "the name of a file is needed behind `#includeEtc`");
            self.push(d.label(format!("such as `#includeEtc \"{CONSTRAINTS}\"`")));
            c.at = at.range.start;
            return;
        };
        let name = name.strip_prefix("<etc>").unwrap_or(&name).trim_start_matches('/');
        if name == CONSTRAINTS {
            let entry = |t: &&str| format!("{t} {{ type {t}; }}\n");
            let text: String = CONSTRAINT_TYPES.iter().map(entry).collect();
            let src = Source::new(format!("etc/{CONSTRAINTS} (built in)"), text.into_bytes());
            self.entries(&mut Cursor::new(&src), None);
            return;
        }
        let near = nearest(name, [CONSTRAINTS]).map(|n| format!("did you mean \"{n}\"? "));
        let help = format!(
            "{}granflow does not read OpenFOAM's `etc` folder, but for \"{CONSTRAINTS}\", which is \
             built in; copy the entries that are needed into the case",
            near.unwrap_or_default()
        );
        let message = format!("`#includeEtc \"{name}\"` is not available");
        self.push(Diag::error(&span.to(&at), message).label("refused").help(help));
        self.lose();
    }

    /// Entries of the dictionary at hand are lost, which was said.
    pub(crate) fn lose(&mut self) {
        self.lost = true;
        self.here().incomplete = true;
    }
}
