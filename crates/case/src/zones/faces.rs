//! Named sets of faces, each face with the side that its normal points to.

use super::{each_listed, labels_of, sorted};
use crate::set_fields;
use granflow_dict::{Reader, Sink, Source, nearest};
use granflow_mesh::{Mesh, PolyMesh};
use std::collections::BTreeMap;
use std::sync::Arc;

pub(super) const FILE: &str = "constant/polyMesh/faceZones";

/// A face of a zone: its number in the user's mesh, and whether the zone's normal is opposite to the
/// face's own.
pub(crate) type ZoneFace = (u32, bool);

/// Sets of faces by name. A set that nothing here can make has the reason in its place, which is said
/// when somebody asks for it.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceZones(BTreeMap<String, Result<Vec<ZoneFace>, String>>);

impl FaceZones {
    /// `N ( name { type faceZone; faceLabels List<label> n (..); flipMap List<bool> n (..); } .. )`.
    pub(super) fn read_file(&mut self, source: Arc<Source>, n: usize, sink: &Sink) {
        each_listed(source, sink, |name, r| {
            r.opt_one_of("type", &[("faceZone", ())], ());
            let Some(faces) = labels_of(r, "faceLabels", ("face", n)) else {
                if !r.has("faceLabels") {
                    let message = format!("the zone `{name}` has no `faceLabels`");
                    r.error_here(message, "not found before this brace", None);
                }
                return;
            };
            let flips = labels_of(r, "flipMap", ("side", 2)).unwrap_or_default();
            if flips.len() != faces.len() {
                let message = format!("{} faces need as many sides", faces.len());
                r.error_at_key("flipMap", message, format!("{} here", flips.len()), None);
            }
            let turned = flips.into_iter().map(|f| f == 1).chain(std::iter::repeat(false));
            let faces = faces.into_iter().zip(turned).collect();
            self.0.insert(name.to_owned(), Ok(faces));
        });
    }

    /// An action of `topoSetDict` on a set or zone of faces.
    pub(super) fn act(
        &mut self,
        r: &Reader<'_>,
        name: &str,
        cells: &BTreeMap<String, Vec<u32>>,
        (poly, mesh): (&PolyMesh, &Mesh),
    ) {
        let action = r.word("action");
        let found = self.found(r, action, cells, (poly, mesh));
        r.ignore_all();
        let now = self.0.remove(name).unwrap_or(Ok(Vec::new()));
        let made = match (now, found) {
            (_, Ok(found)) if matches!(action, "new" | "clear" | "remove") => Ok(found),
            (Ok(now), Ok(found)) => combined(action, now, &found),
            (Err(why), _) | (_, Err(why)) => Err(why),
        };
        self.0.insert(name.to_owned(), made);
    }

    /// The faces that `source` of an action finds, or why there are none.
    fn found(
        &self,
        r: &Reader<'_>,
        action: &str,
        cells: &BTreeMap<String, Vec<u32>>,
        (poly, mesh): (&PolyMesh, &Mesh),
    ) -> Result<Vec<ZoneFace>, String> {
        if matches!(action, "clear" | "remove" | "invert") {
            return Ok(Vec::new());
        }
        let inner = r.entry("sourceInfo").and_then(|_| r.opt_sub("sourceInfo"));
        let of = inner.as_ref().unwrap_or(r);
        let set = |keys: &[&str]| -> Result<Vec<ZoneFace>, String> {
            let key = keys.iter().find(|k| of.has(k)).copied().unwrap_or(keys[0]);
            let other = of.word(key);
            self.0.get(other).cloned().unwrap_or_else(|| Err(format!("there is no set `{other}`")))
        };
        let plain = |faces: Vec<u32>| faces.into_iter().map(|f| (f, false)).collect();
        let user = |f: usize| mesh.poly_face[f] >> 1;
        match r.word("source") {
            "faceToFace" | "setToFaceZone" | "zoneToFace" => set(&["faceSet", "set", "zone"]),
            "setsToFaceZone" => {
                let faces = set(&["faceSet"])?;
                let inside = of.word("cellSet");
                let Some(inside) = cells.get(inside) else {
                    return Err(format!("there is no set of cells `{inside}`"));
                };
                let against = of.opt_switch("flip", false);
                let out = |f: u32| inside.binary_search(&poly.owner[f as usize]).is_ok();
                Ok(faces.into_iter().map(|(f, _)| (f, out(f) == against)).collect())
            }
            "labelToFace" => {
                let found = labels_of(of, "value", ("face", poly.n_faces())).unwrap_or_default();
                Ok(plain(found))
            }
            "patchToFace" => {
                let key = ["patch", "patches", "name"].into_iter().find(|k| of.has(k));
                let names = key.map_or(Vec::new(), |k| of.words(k));
                if let Some(none) =
                    names.iter().find(|n| poly.patches.iter().all(|p| p.name != **n))
                {
                    return Err(format!("there is no patch `{none}`"));
                }
                let wanted = poly.patches.iter().filter(|p| names.contains(&p.name.as_str()));
                Ok(plain(wanted.flat_map(|p| p.faces()).map(|f| f as u32).collect()))
            }
            "boxToFace" => {
                let inside = set_fields::in_box(of);
                let at = (0..mesh.n_faces()).filter(|f| inside(mesh.face_centre[*f]));
                Ok(plain(sorted(at.map(user).collect())))
            }
            other => Err(format!("the source of faces `{other}` is not done here")),
        }
    }

    /// The zone that the entry `key` names.
    pub(super) fn expect(&self, r: &Reader<'_>, key: &str, name: &str) -> Vec<ZoneFace> {
        let names = || self.0.keys().map(String::as_str);
        let (message, help) = match self.0.get(name) {
            Some(Ok(faces)) if faces.is_empty() => (
                format!("the face zone `{name}` has no faces"),
                "look at system/topoSetDict".into(),
            ),
            Some(Ok(faces)) => return faces.clone(),
            Some(Err(why)) => {
                let help =
                    "make it with OpenFOAM's topoSet, which writes constant/polyMesh/faceZones";
                (format!("the face zone `{name}` cannot be made: {why}"), help.to_owned())
            }
            None => {
                let help = match (nearest(name, names()), self.0.is_empty()) {
                    (Some(near), _) => format!("did you mean `{near}`?"),
                    (None, true) => {
                        format!("the case has none: give them in {FILE} or system/topoSetDict")
                    }
                    (None, false) => {
                        format!("there are {}", names().collect::<Vec<_>>().join(", "))
                    }
                };
                (format!("no face zone `{name}`"), help)
            }
        };
        r.error_at_key(key, message, "not known", Some(&help));
        Vec::new()
    }
}

fn combined(
    action: &str,
    mut now: Vec<ZoneFace>,
    found: &[ZoneFace],
) -> Result<Vec<ZoneFace>, String> {
    let has = |f: &ZoneFace| found.iter().any(|o| o.0 == f.0);
    match action {
        "add" => {
            let more: Vec<ZoneFace> =
                found.iter().filter(|f| now.iter().all(|o| o.0 != f.0)).copied().collect();
            now.extend(more);
        }
        "subset" => now.retain(has),
        "delete" | "subtract" => now.retain(|f| !has(f)),
        other => return Err(format!("the action `{other}` is not done on faces")),
    }
    Ok(now)
}
