//! Named sets of cells and faces: `constant/polyMesh/cellZones` and `faceZones`, and what
//! `system/topoSetDict` would make of the mesh.
//!
//! The reference tool needs its utility `topoSet` to be run first. Here the dictionary is read where a
//! zone is asked for, and nothing is written.

mod faces;

pub(crate) use faces::ZoneFace;

use crate::{CaseError, files, set_fields};
use faces::FaceZones;
use granflow_dict::{
    Payload, Reader, Severity, Sink, Source, Tok, Value, nearest, parse_list_file,
};
use granflow_mesh::{Mesh, PolyMesh};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "constant/polyMesh/cellZones";
const TOPO_SET: &str = "system/topoSetDict";
/// What an action without a name makes, which is a mistake.
const NAMELESS: &str = "";

/// Sets of cells and of faces by name, in the user's numbering.
#[derive(Clone, Debug, Default)]
pub struct Zones {
    cells: BTreeMap<String, Vec<u32>>,
    faces: FaceZones,
}

impl Zones {
    /// Reads the zones of a case. Mistakes go to the sink.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn read(
        root: &Path,
        poly: &PolyMesh,
        mesh: &Mesh,
        sink: &Sink,
    ) -> Result<Zones, CaseError> {
        let mut zones = Zones::default();
        for zone in &poly.cell_zones {
            zones.cells.insert(zone.name.clone(), zone.cells.clone());
        }
        if let Some(source) = files::source(root, FILE)? {
            zones.read_file(source, mesh.n_cells, sink);
        }
        if let Some(source) = files::source(root, faces::FILE)? {
            zones.faces.read_file(source, poly.n_faces(), sink);
        }
        if let Some(dict) = files::dict(root, TOPO_SET, sink)? {
            zones.make(&Reader::new(&dict, sink), poly, mesh);
        }
        Ok(zones)
    }

    /// The cells of the zone `name`, in the user's numbering.
    pub fn get(&self, name: &str) -> Option<&[u32]> {
        self.cells.get(name).map(Vec::as_slice)
    }

    /// Names of all zones.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.cells.keys().map(String::as_str)
    }

    /// `N ( name { type cellZone; cellLabels List<label> n (...); } ... )`.
    fn read_file(&mut self, source: Arc<Source>, n: usize, sink: &Sink) {
        each_listed(source, sink, |name, r| {
            if let Some(cells) = labels(r, "cellLabels", n) {
                self.cells.insert(name.to_owned(), sorted(cells));
            }
        });
    }

    /// The actions of `topoSetDict`, in their order.
    fn make(&mut self, r: &Reader<'_>, poly: &PolyMesh, mesh: &Mesh) {
        let Some(mut list) = r.list("actions") else { return };
        while !list.is_empty() {
            let Some(action) = list.dict("an action") else { break };
            self.act(&action, poly, mesh);
            // Of an action that is not understood nothing more is said.
            action.finish(Severity::Error);
        }
        r.ignore_all();
    }

    fn act(&mut self, r: &Reader<'_>, poly: &PolyMesh, mesh: &Mesh) {
        if !r.has("name") {
            let help = Some("add the name of the set that it makes or changes: `name rotor;`");
            let label = "`name` not found before this brace";
            r.error_here("an action of topoSetDict has no name", label, help);
            // Which zone is missing cannot be known then.
            self.cells.insert(NAMELESS.to_owned(), Vec::new());
            r.ignore_all();
            return;
        }
        let name = r.word("name").to_owned();
        let kind = r.word("type").to_owned();
        if matches!(kind.as_str(), "faceSet" | "faceZoneSet") {
            self.faces.act(r, &name, &self.cells, (poly, mesh));
            return;
        }
        if !matches!(kind.as_str(), "cellSet" | "cellZoneSet") {
            // Sets of points: nothing here asks for them.
            r.ignore_all();
            return;
        }
        let actions = ["new", "add", "delete", "subtract", "subset", "clear", "invert", "remove"];
        let action = r.one_of("action", &actions.map(|a| (a, a)));
        if matches!(action, "clear" | "remove" | "invert") {
            // They need no cells.
            r.ignore("source");
            r.ignore("sourceInfo");
        }
        if matches!(action, "clear" | "remove") {
            self.cells.insert(name, Vec::new());
            return;
        }
        let known = self.get(&name).is_some();
        if !known && matches!(action, "delete" | "subtract" | "subset" | "invert") {
            self.expect(r, "name", &name);
        }
        // A zone may have the name of the set that it is made of.
        let found = if action == "invert" { Vec::new() } else { self.source(r, mesh) };
        let mut now = self.cells.remove(&name).unwrap_or_default();
        if action == "invert" {
            now = (0..mesh.n_cells as u32).filter(|c| now.binary_search(c).is_err()).collect();
            self.cells.insert(name, now);
            return;
        }
        let chosen = match action {
            "new" => found,
            "add" => {
                now.extend(found);
                now
            }
            "subset" => now.into_iter().filter(|c| found.binary_search(c).is_ok()).collect(),
            _ => now.into_iter().filter(|c| found.binary_search(c).is_err()).collect(),
        };
        self.cells.insert(name, sorted(chosen));
    }

    /// The cells that `source` of an action finds, in ascending order.
    fn source(&self, r: &Reader<'_>, mesh: &Mesh) -> Vec<u32> {
        let kind = r.word("source").to_owned();
        // Older cases give its entries in a dictionary of their own.
        let inner = r.entry("sourceInfo").and_then(|_| r.opt_sub("sourceInfo"));
        let of = inner.as_ref().unwrap_or(r);
        let named = ["set", "zone", "name"];
        match kind.as_str() {
            "" => {
                r.ignore_all();
                Vec::new()
            }
            "cellToCell" | "zoneToCell" | "setToCellZone" => {
                let key =
                    named.into_iter().find(|k| of.has(k) && (*k != "name" || inner.is_some()));
                let key = key.unwrap_or(if kind == "zoneToCell" { "zone" } else { "set" });
                let other = of.word(key).to_owned();
                self.expect(of, key, &other).to_vec()
            }
            "labelToCell" => sorted(labels(of, "value", mesh.n_cells).unwrap_or_default()),
            _ => match set_fields::cells_of(&kind, of, mesh) {
                Some(cells) => sorted(cells.into_iter().map(|c| mesh.global_cell[c]).collect()),
                None => {
                    let known: Vec<&str> =
                        SETS.into_iter().chain(set_fields::region_names()).collect();
                    let near = nearest(&kind, known.iter().copied());
                    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
                    let help = format!("{near}there are {}", known.join(", "));
                    let message = format!("the source of cells `{kind}` is not done here");
                    r.error_at_key("source", message, "not available", Some(&help));
                    r.ignore_all();
                    Vec::new()
                }
            },
        }
    }

    /// The cells of the zone that the entry `key` names; one without any is a mistake.
    pub fn filled(&self, r: &Reader<'_>, key: &str) -> Vec<u32> {
        let name = r.word(key);
        let cells = self.expect(r, key, name).to_vec();
        if cells.is_empty() && self.get(name).is_some() {
            let help = Some("no centre of a cell lies within it: look at system/topoSetDict");
            r.error_at_key(key, format!("the zone `{name}` has no cells"), "empty", help);
        }
        cells
    }

    /// The zone that the entry `key` names.
    pub fn expect(&self, r: &Reader<'_>, key: &str, name: &str) -> &[u32] {
        if name.is_empty() || (self.get(name).is_none() && self.get(NAMELESS).is_some()) {
            return &[];
        }
        self.get(name).unwrap_or_else(|| {
            let near = nearest(name, self.names());
            let help = match (near, self.cells.is_empty()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, true) => format!("the case has none: give them in {FILE} or {TOPO_SET}"),
                (None, false) => {
                    format!("there are {}", self.names().collect::<Vec<_>>().join(", "))
                }
            };
            r.error_at_key(key, format!("no cell zone `{name}`"), "not known", Some(&help));
            &[]
        })
    }
}

impl Zones {
    /// The faces of the zone that the entry `key` names, each with its direction.
    pub(crate) fn expect_faces(&self, r: &Reader<'_>, key: &str, name: &str) -> Vec<ZoneFace> {
        self.faces.expect(r, key, name)
    }
}

const SETS: [&str; 4] = ["cellToCell", "zoneToCell", "setToCellZone", "labelToCell"];

/// A list of cells of a mesh with `n`.
fn labels(r: &Reader<'_>, key: &str, n: usize) -> Option<Vec<u32>> {
    labels_of(r, key, ("cell", n))
}

/// Shows the zones of a file, each with its name.
fn each_listed(source: Arc<Source>, sink: &Sink, mut show: impl FnMut(&str, &Reader<'_>)) {
    let (_, payload, found) = parse_list_file(source);
    sink.extend(found);
    let Payload::Entries(entries) = payload else { return };
    for entry in &entries {
        let Value::Dict(zone) = &entry.value else { continue };
        show(entry.key.text(), &Reader::new(zone, sink));
    }
}

/// A list of numbers of which there are `n`.
fn labels_of(r: &Reader<'_>, key: &str, (what, n): (&str, usize)) -> Option<Vec<u32>> {
    let list = r.raw(key)?.last()?;
    let cells: Option<Vec<i64>> = match &list.kind {
        Tok::Packed(p) => match &**p {
            Payload::Labels(cells) => Some(cells.clone()),
            p => p.is_empty().then(Vec::new),
        },
        _ => list.list().and_then(|l| l.iter().map(|t| t.label()).collect()),
    };
    let Some(cells) = cells else {
        let message = format!("expected a list of {what}s");
        r.error_at_key(key, message, format!("not a list of {what}s"), None);
        return None;
    };
    let own = |c: &i64| usize::try_from(*c).is_ok_and(|c| c < n);
    if let Some(beyond) = cells.iter().find(|c| !own(c)) {
        let message = format!("there is no {what} {beyond}: there are {n}");
        r.error_at_key(key, message, "beyond the mesh", None);
        return None;
    }
    Some(cells.into_iter().map(|c| c as u32).collect())
}

fn sorted(mut cells: Vec<u32>) -> Vec<u32> {
    cells.sort_unstable();
    cells.dedup();
    cells
}
