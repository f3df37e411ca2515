//! `boundaryField`: which entry belongs to which patch, and the conditions it makes.
//!
//! A patch's entry is found as OpenFOAM does: its own name, then a group it belongs to (the last
//! one in the file wins), then a pattern (again the last one).

use crate::WaveTable;
use granflow_base::Vec3;
use granflow_dict::{
    CONSTRAINT_TYPES, Dict, Entry, Key, Payload, Reader, Sink, Tok, Token, Value, nearest,
};
use granflow_fv::conditions::{CaseContext, PatchContext, read_scalar, read_vector};
use granflow_fv::{Condition, Differentiable};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, PolyPatch};
use std::sync::Arc;

/// Values that have field files.
pub trait FieldType: Differentiable {
    /// The class in the file's header.
    const CLASS: &'static str;
    /// Reads a condition.
    fn condition(r: &Reader<'_>, context: &PatchContext<'_>) -> Box<dyn Condition<Self>>;
}

impl FieldType for f64 {
    const CLASS: &'static str = "volScalarField";
    fn condition(r: &Reader<'_>, context: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
        read_scalar(r, context)
    }
}
impl FieldType for Vec3 {
    const CLASS: &'static str = "volVectorField";
    fn condition(r: &Reader<'_>, context: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
        read_vector(r, context)
    }
}

/// What conditions are made for.
#[derive(Clone, Copy)]
pub struct Patches<'a> {
    /// The patches of the whole mesh.
    pub poly: &'a PolyMesh,
    /// Waves at them.
    pub waves: &'a WaveTable,
    /// The case around.
    pub case: CaseContext<'a>,
}

/// Finds the entry of every patch and checks that a condition can be made of it. Returns the
/// entries as the user wrote them, one per patch; mistakes go to the reader's sink.
pub fn resolve<T: FieldType>(
    r: &Reader<'_>,
    field: &str,
    dims: granflow_base::Dims,
    poly: &PolyMesh,
    case: CaseContext<'_>,
) -> Vec<Dict> {
    let mut out = Vec::with_capacity(poly.patches.len());
    for patch in &poly.patches {
        let Some(key) = key_of(r.dict(), patch) else {
            if patch.kind != PatchKind::Empty {
                missing(r, field, patch, poly);
            }
            out.push(of_kind(&patch.kind));
            continue;
        };
        let Some(sub) = r.opt_sub(&key) else {
            out.push(of_kind(&patch.kind));
            continue;
        };
        let context = PatchContext {
            patch: &patch.name,
            kind: &patch.kind,
            n_faces: patch.len,
            n_inner: poly.n_inner(),
            field,
            dims,
            factor: 1.0,
            case,
            wave: None,
        };
        T::condition(&sub, &context);
        // Left by OpenFOAM's own tools.
        sub.ignore("patchType");
        out.push(sub.dict().clone());
    }
    unknown(r, field, poly);
    out
}

/// The key of the entry that serves `patch`.
pub(crate) fn key_of(boundary: &Dict, patch: &PolyPatch) -> Option<String> {
    let word = |name: &str| {
        let exact = |e: &&Entry| matches!(&e.key, Key::Word(w) if w == name);
        boundary.entries.iter().find(exact).map(|_| name.to_owned())
    };
    if let Some(key) = word(&patch.name) {
        return Some(key);
    }
    let groups = implied_groups(patch);
    let in_group = |e: &&Entry| matches!(&e.key, Key::Word(w) if groups.iter().any(|g| g == w));
    if let Some(e) = boundary.entries.iter().rev().find(in_group) {
        return Some(e.key.text().to_owned());
    }
    boundary.find(&patch.name).map(|_| patch.name.clone())
}

/// The groups in the mesh file, and the one that every constrained patch and wall belongs to.
fn implied_groups(patch: &PolyPatch) -> Vec<String> {
    let mut groups = patch.in_groups.clone();
    if patch.kind != PatchKind::Patch {
        groups.push(patch.kind.word().to_owned());
    }
    groups
}

fn missing(r: &Reader<'_>, field: &str, patch: &PolyPatch, poly: &PolyMesh) {
    if r.dict().incomplete {
        return;
    }
    let names: Vec<&str> = poly.patches.iter().map(|p| p.name.as_str()).collect();
    let strangers = r.keys().into_iter().filter(|k| !names.contains(k));
    let help = match nearest(&patch.name, strangers) {
        Some(n) => format!("`{n}` is no patch; did you mean `{}`?", patch.name),
        None => match patch.kind {
            PatchKind::Patch | PatchKind::Wall => {
                format!("add `{} {{ type ...; }}` (`granflow list conditions`)", patch.name)
            }
            _ => format!("add `{} {{ type {}; }}`", patch.name, patch.kind.word()),
        },
    };
    let message = format!("field `{field}` has no condition for patch `{}`", patch.name);
    r.error_here(message, "not found before this brace", Some(&help));
}

fn unknown(r: &Reader<'_>, field: &str, poly: &PolyMesh) {
    for e in &r.dict().entries {
        let Key::Word(w) = &e.key else {
            // A pattern for patches that other meshes have.
            r.ignore(e.key.text());
            continue;
        };
        let named = poly.patches.iter().any(|p| p.name == *w || implied_groups(p).contains(w));
        if named {
            r.ignore(w);
            continue;
        }
        // Keys of a decomposed case, and groups that no patch of this mesh belongs to.
        if w.starts_with("procBoundary") || CONSTRAINT_TYPES.contains(&w.as_str()) {
            r.ignore(w);
            continue;
        }
        if let Some(sub) = r.opt_sub(w) {
            sub.ignore_all();
        }
        let names = poly.patches.iter().map(|p| p.name.as_str());
        let known: Vec<&str> = names.clone().collect();
        let help = nearest(w, names).map_or_else(
            || format!("the patches are {}", known.join(", ")),
            |n| format!("did you mean `{n}`?"),
        );
        let message = format!("the mesh has no patch `{w}` for which `{field}` gives a condition");
        r.warn_at(&e.key_span, message, "no such patch", Some(&help));
    }
}

/// `{ type <kind>; }` where the patch dictates its condition, else `zeroGradient`.
pub fn of_kind(kind: &PatchKind) -> Dict {
    let mut d = Dict::new();
    let word = match kind {
        PatchKind::Patch | PatchKind::Wall => "zeroGradient",
        other => other.word(),
    };
    d.set("type", word);
    d
}

/// The conditions of one rank's part of the mesh, from the entries of the whole one. `factor`
/// takes values in the file to values inside.
pub fn conditions<T: FieldType>(
    entries: &[Dict],
    mesh: &Mesh,
    patches: Patches<'_>,
    (field, dims): (&str, granflow_base::Dims),
    factor: f64,
) -> Vec<Box<dyn Condition<T>>> {
    let silent = Sink::new();
    let Patches { poly, waves, case } = patches;
    let one = |(i, whole): (usize, &PolyPatch)| {
        let patch = &mesh.patches[i];
        let mine: Vec<usize> =
            patch.faces.clone().map(|f| (mesh.poly_face[f] >> 1) as usize - whole.start).collect();
        let d = local(&entries[i], whole.len, &mine);
        let extents = waves.extents(i, poly, mesh, &mine);
        let context = PatchContext {
            patch: &whole.name,
            kind: &whole.kind,
            n_faces: mine.len(),
            n_inner: mesh.n_inner,
            field,
            dims,
            factor,
            case,
            wave: waves.at(i, &extents),
        };
        T::condition(&Reader::new(&d, &silent), &context)
    };
    poly.patches.iter().enumerate().map(one).collect()
}

/// An entry for some faces of its patch.
fn local(entry: &Dict, n_faces: usize, mine: &[usize]) -> Dict {
    let mut d = entry.clone();
    for e in &mut d.entries {
        let Value::Stream(tokens) = &mut e.value else { continue };
        if tokens.first().and_then(Token::word) == Some("nonuniform")
            && let Some(list) = tokens.last().and_then(|t| picked(t, n_faces, mine))
        {
            *tokens = vec![Token::of_word("nonuniform"), list];
        }
    }
    d
}

/// The chosen items of a list of `n` values.
fn picked(t: &Token, n: usize, mine: &[usize]) -> Option<Token> {
    let payload = if let Some(v) = t.scalars().filter(|v| v.len() == n) {
        Payload::Scalars(mine.iter().map(|&i| v[i]).collect())
    } else {
        let v = t.vectors().filter(|v| v.len() == n)?;
        Payload::Vectors(mine.iter().map(|&i| v[i]).collect())
    };
    Some(Token { kind: Tok::Packed(Arc::new(payload)), span: t.span.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_dict::parse_str;
    use granflow_mesh::shapes;

    fn mesh() -> PolyMesh {
        let mut poly = shapes::unit_box([2, 2, 1]);
        poly.patches[0].in_groups = vec!["sides".into()];
        poly.patches[1].in_groups = vec!["sides".into()];
        poly
    }

    #[test]
    fn names_come_before_groups_and_groups_before_patterns() {
        let text =
            "\"(x|y|z).*\" { type zeroGradient; } sides { type fixedValue; value uniform 2; }
                    xMin { type fixedValue; value uniform 1; }";
        let (dict, diags) = parse_str(text);
        assert!(diags.is_empty());
        let sink = Sink::new();
        let poly = mesh();
        let dims = granflow_base::Dims::PRESSURE;
        let found = resolve::<f64>(&Reader::new(&dict, &sink), "p", dims, &poly, CaseContext::NONE);
        let words: Vec<_> = found.iter().map(|d| d.word("type").unwrap_or("")).collect();
        assert!(sink.take().is_empty());
        assert_eq!(words[..3], ["fixedValue", "fixedValue", "zeroGradient"]);
        let value = |d: &Dict| d.stream("value").and_then(|t| t.last()?.number());
        assert_eq!((value(&found[0]), value(&found[1])), (Some(1.0), Some(2.0)));
    }

    #[test]
    fn a_misspelt_patch_is_named_with_its_neighbour() {
        let text = "xMim { type zeroGradient; } \"[yz].*\" { type zeroGradient; }
                    xMax { type zeroGradient; }";
        let (dict, _) = parse_str(text);
        let sink = Sink::new();
        let dims = granflow_base::Dims::PRESSURE;
        resolve::<f64>(&Reader::new(&dict, &sink), "p", dims, &mesh(), CaseContext::NONE);
        let all = sink.take();
        assert_eq!((all.n_errors(), all.n_warnings()), (1, 1));
        let text = all.to_string();
        assert!(text.contains("no condition for patch `xMin`"), "{text}");
        assert!(text.contains("`xMim` is no patch; did you mean `xMin`?"), "{text}");
    }

    #[test]
    fn values_are_cut_to_the_faces_of_a_rank() {
        let (d, _) = parse_str(
            "type fixedValue; value nonuniform List<scalar> 3 (1 2 3); \
             uniformValue table ((0 1) (2 5) (3 6)); mode 4;",
        );
        let cut = local(&d, 3, &[2, 0]);
        let values = cut.stream("value").and_then(|t| t.last()?.scalars());
        assert_eq!(values, Some(vec![3.0, 1.0]));
        assert_eq!(cut.stream("uniformValue").map(<[Token]>::len), Some(2));
        assert_eq!(cut.number("mode"), Some(4.0));
    }

    #[test]
    fn functions_of_time_come_in_the_units_of_the_file() {
        let (d, _) =
            parse_str("type uniformFixedValue; uniformValue { type sine; frequency 0; level 3; }");
        let poly = shapes::unit_box([1, 1, 1]);
        let mesh = Mesh::new(&poly).unwrap();
        let waves = WaveTable::default();
        let patches = Patches { poly: &poly, waves: &waves, case: CaseContext::NONE };
        let entries = vec![d; poly.patches.len()];
        let dims = granflow_base::Dims::PRESSURE;
        let all = conditions::<f64>(&entries, &mesh, patches, ("p", dims), 1000.0);
        let mut p = granflow_fv::Unknown::new(&mesh, "p", dims, 0.0, all);
        let around = granflow_fv::Surroundings::default();
        p.update(&granflow_par::Exec::serial(), &mesh, &around, None);
        assert_eq!(p.boundary_value(&mesh, mesh.n_inner), 3000.0);
    }
}
