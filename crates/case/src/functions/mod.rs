//! What is computed from the flow while it runs: the `functions` of `controlDict`.
//!
//! To add one: a file here with its parameters, its `read`, its `sample` and its tests, and one
//! line in [`ALL`].

mod columns;
mod field_min_max;
mod forces;
mod locate;
mod phase;
mod probes;
mod quantity;
mod residuals;
pub(crate) mod schedule;
mod set_flow;
mod sets;
mod surface_field_value;
mod track;

pub use quantity::{Derivations, Quantity, View};
pub use schedule::Schedule;
pub use set_flow::SetFlow;

use crate::CaseConfig;
use granflow_dict::{Reader, Sink, nearest};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// What a function wants in its folder `postProcessing/<name>/`.
#[derive(Clone, Debug, PartialEq)]
pub enum Written {
    /// A line at the end of `<start time>/<file>`, which begins with `header`.
    Line {
        /// File name.
        file: &'static str,
        /// First lines of the file.
        header: String,
        /// The line, without its end.
        line: String,
    },
    /// The whole file `<time>/<file>`.
    File {
        /// File name.
        file: String,
        /// Its text.
        text: String,
    },
}

/// A function on one rank's part of the mesh.
pub trait Function: Send {
    /// Looks at the flow. Every rank calls it; only rank 0 returns something.
    fn sample(&mut self, view: &View<'_>) -> Vec<Written>;
    /// Whether strain rate, viscosity and the like are needed.
    fn needs_derived(&self) -> bool;
}

/// A function as the dictionary describes it.
pub trait Plan: Send + Sync {
    /// Checks what depends on the mesh and on the rest of the case.
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink);
    /// The flow that it gives, in place of one that is solved for.
    fn prescribes(&self) -> Option<&SetFlow> {
        None
    }
    /// The function on a rank's mesh. Every rank calls it.
    fn build(&self, mesh: &Mesh, exec: &Exec) -> Box<dyn Function>;
}

/// A plan with its name and its times.
pub struct Planned {
    /// Name of the entry, and of the folder below `postProcessing`.
    pub name: String,
    /// When it acts.
    pub schedule: Schedule,
    /// What it does.
    pub plan: Box<dyn Plan>,
}

/// One function of the registry.
pub struct Entry {
    /// The word behind `type`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// Where the definition comes from.
    pub reference: &'static str,
    /// Reads its dictionary.
    pub read: fn(&Reader<'_>, &str) -> Box<dyn Plan>,
    /// When it acts if the dictionary does not say.
    pub schedule: Schedule,
}

/// Every function.
pub const ALL: &[Entry] = &[
    probes::ENTRY,
    sets::ENTRY,
    sets::ENTRY_PROFILE,
    forces::ENTRY,
    residuals::ENTRY,
    field_min_max::ENTRY,
    surface_field_value::ENTRY,
    phase::ENTRY,
    set_flow::ENTRY,
];

/// Names that OpenFOAM's cases write for the same things.
const ALIASES: &[(&str, &str)] = &[("solverInfo", "residuals"), ("minMax", "fieldMinMax")];

/// Entries every function may have and that change nothing here.
const HARMLESS: &[&str] = &[
    "libs",
    "functionObjectLibs",
    "region",
    "log",
    "executeControl",
    "executeInterval",
    "enabled",
    "useUserTime",
];

/// Reads `functions` of `controlDict`; mistakes go to the sink.
pub fn read(control: &Reader<'_>) -> Vec<Planned> {
    let mut out = Vec::new();
    let Some(functions) = control.opt_sub("functions") else { return out };
    for (name, r) in functions.subs() {
        for key in HARMLESS {
            r.ignore(key);
        }
        if !r.opt_switch("enabled", true) {
            r.ignore_all();
            continue;
        }
        let word = r.word("type");
        let word = ALIASES.iter().find(|a| a.0 == word).map_or(word, |a| a.1);
        let Some(entry) = ALL.iter().find(|e| e.name == word) else {
            if !word.is_empty() {
                let known: Vec<&str> = ALL.iter().map(|e| e.name).collect();
                let near = nearest(word, known.iter().copied());
                let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
                let help = format!(
                    "{near}known are {}; `enabled no;` leaves a function out",
                    known.join(", ")
                );
                r.error_at_key(
                    "type",
                    format!("unknown function `{word}`"),
                    "not known",
                    Some(&help),
                );
            }
            r.ignore_all();
            continue;
        };
        let schedule = Schedule::read(&r, entry.schedule);
        let plan = (entry.read)(&r, name);
        out.push(Planned { name: name.to_owned(), schedule, plan });
    }
    out
}
