//! What is computed from the flow while it runs: the `functions` of `controlDict`.
//!
//! To add one: a file here with its parameters, its `read`, its `sample` and its tests, and one
//! line in [`ALL`].

mod cell_centres;
mod cell_region;
mod cell_volumes;
mod columns;
mod courant_number;
mod cut;
mod derived_field;
mod divergence;
mod face_zone;
mod field;
mod field_average;
mod field_min_max;
mod flow_type;
mod force_coefficients;
mod forces;
mod gradient;
mod interface_height;
mod locate;
mod magnitude;
mod operations;
mod patches;
mod phase;
mod point_sets;
mod probes;
mod q_criterion;
mod quantity;
mod refused;
pub(crate) mod remembered;
mod residuals;
pub(crate) mod schedule;
mod set_flow;
mod set_format;
mod sets;
mod solver_info;
mod stream_line;
mod surface_field_value;
mod surface_format;
mod surfaces;
mod track;
mod view;
mod vol_field_value;
mod vorticity;
mod wall_shear_stress;
pub(crate) mod whole;

pub use field::{Components, Info, Rank, Unit, Values, Whole};
pub(crate) use field::{file as field_file, flat as field_values};
pub use quantity::{Named, Quantity};
pub use schedule::Schedule;
pub use set_flow::SetFlow;
pub use view::{Derivations, View};

use crate::{CaseConfig, Zones};
use granflow_dict::{Dict, Reader, Sink, nearest};
use granflow_mesh::{Mesh, PolyMesh};
use granflow_par::Exec;

/// What a function wants in its folder `postProcessing/<name>/`.
#[derive(Clone, Debug, PartialEq)]
pub enum Written {
    /// A line at the end of `<start time>/<file>`, which begins with `header`.
    Line {
        /// File name.
        file: String,
        /// First lines of the file.
        header: String,
        /// The line, without its end.
        line: String,
    },
    /// The whole file `<time>/<file>`.
    File {
        /// File name.
        file: String,
        /// What it holds.
        bytes: Vec<u8>,
    },
}

/// A function on one rank's part of the mesh.
pub trait Function: Send {
    /// Whether strain rate, viscosity and the like are needed.
    fn needs_derived(&self) -> bool {
        false
    }
    /// Brings the fields it makes up to date. Every rank calls it, once a step at most.
    fn execute(&mut self, _: &View<'_>) {}
    /// The fields it makes, in the order of [`Plan::makes`].
    fn fields(&self) -> &[Values] {
        &[]
    }
    /// Looks at the flow. Every rank calls it; only rank 0 returns something.
    fn sample(&mut self, view: &View<'_>) -> Vec<Written>;
    /// Whether its fields hold anything yet.
    fn ready(&self) -> bool {
        true
    }
    /// Its fields have been written.
    fn written(&mut self) {}
    /// What a restart must know beside its fields: for each key, entries with their values.
    fn memory(&self) -> Vec<(String, Vec<(&'static str, String)>)> {
        Vec::new()
    }
}

/// A function as the dictionary describes it.
pub trait Plan: Send + Sync {
    /// Checks what depends on the mesh and on the rest of the case.
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink);
    /// Whether it asks for zones of cells or faces.
    fn wants_zones(&self) -> bool {
        false
    }
    /// Finds its place in the mesh, before anything else is asked of it. Mistakes go to the sink.
    fn place(&mut self, _: &Around<'_>, _: &Sink) {}
    /// The flow that it gives, in place of one that is solved for.
    fn prescribes(&self) -> Option<&SetFlow> {
        None
    }
    /// The folder below `postProcessing` that its own folder is in, if any.
    fn folder(&self) -> Option<&'static str> {
        None
    }
    /// The fields it makes, which time directories hold and later functions may look at.
    fn makes(&self) -> Vec<Info> {
        Vec::new()
    }
    /// The functions before it whose fields it looks at.
    fn uses(&self) -> Vec<usize> {
        Vec::new()
    }
    /// Whether its fields remember earlier steps: it is then executed after each, and a restart
    /// reads them.
    fn remembers(&self) -> bool {
        false
    }
    /// The function on a rank's mesh, as it was when the run stopped if that is known. Every rank
    /// calls it.
    fn build(&self, mesh: &Mesh, exec: &Exec, earlier: Option<&Remembered>) -> Box<dyn Function>;
}

/// What a time directory knows of a function.
#[derive(Clone, Debug, Default)]
pub struct Remembered {
    /// Its fields, in the order of [`Plan::makes`].
    pub fields: Vec<Whole>,
    /// Its entry in `uniform/functionObjects/functionObjectProperties`.
    pub memory: Dict,
}

/// A field that an earlier function makes.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// The field.
    pub info: Info,
    /// Number of the function.
    pub function: usize,
    /// Which of its fields.
    pub slot: usize,
}

/// What is known where a function's dictionary is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    /// Name of the function.
    pub name: &'a str,
    /// Fields that functions before it make.
    pub made: &'a [Made],
}

/// What a plan may look for its place in.
pub struct Around<'a> {
    /// The mesh in the user's numbering.
    pub poly: &'a PolyMesh,
    /// The numerics' view of it.
    pub mesh: &'a Mesh,
    /// Its zones, empty if no function wants them.
    pub zones: &'a Zones,
}

/// A plan with its name and its times.
pub struct Planned {
    /// Name of the entry, and of the folder below `postProcessing`.
    pub name: String,
    /// When it writes.
    pub schedule: Schedule,
    /// When it brings its fields up to date: whenever somebody looks at them if not given.
    pub execute: Option<Schedule>,
    /// What it does.
    pub plan: Box<dyn Plan>,
}

/// One function of the registry.
pub struct Entry {
    /// The word behind `type`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// What it computes: `phi` a field, `_P` of a cell, `_f` on a face, `V` volume, `S` area vector.
    pub formula: &'static str,
    /// Where the definition comes from.
    pub reference: &'static str,
    /// Reads its dictionary.
    pub read: fn(&Reader<'_>, &Reading<'_>) -> Box<dyn Plan>,
    /// When it acts if the dictionary does not say.
    pub schedule: Schedule,
}

/// Every function.
pub const ALL: &[Entry] = &[
    probes::ENTRY,
    sets::ENTRY,
    sets::ENTRY_PROFILE,
    surfaces::ENTRY,
    stream_line::ENTRY,
    surface_field_value::ENTRY,
    vol_field_value::ENTRY,
    forces::ENTRY,
    force_coefficients::ENTRY,
    wall_shear_stress::ENTRY,
    field_min_max::ENTRY,
    field_average::ENTRY,
    residuals::ENTRY,
    solver_info::ENTRY,
    magnitude::ENTRY,
    magnitude::ENTRY_SQUARE,
    gradient::ENTRY,
    divergence::ENTRY,
    vorticity::ENTRY,
    q_criterion::ENTRY,
    flow_type::ENTRY,
    courant_number::ENTRY,
    cell_centres::ENTRY,
    cell_volumes::ENTRY,
    phase::ENTRY,
    interface_height::ENTRY,
    set_flow::ENTRY,
];

/// Other names for the same things in OpenFOAM's cases of earlier and later versions.
const ALIASES: &[(&str, &str)] = &[
    ("minMax", "fieldMinMax"),
    ("streamlines", "streamLine"),
    ("streamLines", "streamLine"),
    ("volRegion", "volFieldValue"),
    ("surfaceRegion", "surfaceFieldValue"),
];

/// Entries every function may have and that change nothing here.
const HARMLESS: &[&str] = &[
    "libs",
    "functionObjectLibs",
    "region",
    "log",
    "enabled",
    "useUserTime",
    "errors",
    "writePrecision",
];

/// Reads `functions` of `controlDict`; mistakes go to the sink.
pub fn read(control: &Reader<'_>) -> Vec<Planned> {
    let (mut out, mut made) = (Vec::new(), Vec::new());
    let Some(functions) = control.opt_sub("functions") else { return out };
    for (name, r) in functions.subs() {
        for key in HARMLESS {
            r.ignore(key);
        }
        if !r.opt_switch("enabled", true) {
            r.ignore_all();
            continue;
        }
        let Some(entry) = entry_of(&r, name) else {
            r.ignore_all();
            continue;
        };
        let schedule = Schedule::read(&r, entry.schedule);
        let execute = Schedule::read_execute(&r, schedule);
        let plan = (entry.read)(&r, &Reading { name, made: &made });
        let function = out.len();
        plan.makes().iter().for_each(|info| refuse_clash(&r, info, &made));
        let fields = plan.makes().into_iter().enumerate();
        made.extend(fields.map(|(slot, info)| Made { info, function, slot }));
        out.push(Planned { name: name.to_owned(), schedule, execute, plan });
    }
    out
}

/// Files of a time directory that are the flow's own.
const STATE: &[&str] = &["U", "U_0", "p", "p_rgh", "phi", "phi_0", "uniform"];

/// Complains about a field whose file would be that of another one.
fn refuse_clash(r: &Reader<'_>, info: &Info, made: &[Made]) {
    let name = info.name.as_str();
    let own = STATE.contains(&name)
        || name.starts_with("alpha.")
        || Quantity::ALL.iter().any(|q| q.0 == name)
        || name.contains('/');
    let twice = made.iter().any(|m| m.info.name == name);
    if !own && !twice {
        return;
    }
    let key = if r.has("result") { "result" } else { "type" };
    let why = if own { "a name of the case's own files" } else { "made by a function before" };
    let message = format!("the field `{name}` cannot be made under this name");
    r.error_at_key(key, message, why, Some("`result NAME;` gives it another one"));
}

/// The registry's entry for a function's dictionary; a mistake goes to the sink.
fn entry_of(r: &Reader<'_>, name: &str) -> Option<&'static Entry> {
    if r.has("includeFunc") {
        refused::packaged(r, name);
        return None;
    }
    let word = r.word("type");
    let word = ALIASES.iter().find(|a| a.0 == word).map_or(word, |a| a.1);
    let found = ALL.iter().find(|e| e.name == word);
    if found.is_some() || word.is_empty() {
        return found;
    }
    if let Some((_, why)) = refused::ALL.iter().find(|e| e.0 == word) {
        let message = format!("the function `{word}` is not supported");
        let help = format!("{why}; `enabled no;` leaves a function out");
        r.error_at_key("type", message, "refused", Some(&help));
        return None;
    }
    let known: Vec<&str> = ALL.iter().map(|e| e.name).collect();
    let near = nearest(word, known.iter().copied());
    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
    let help = format!("{near}known are {}; `enabled no;` leaves a function out", known.join(", "));
    r.error_at_key("type", format!("unknown function `{word}`"), "not known", Some(&help));
    None
}
