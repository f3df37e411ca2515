//! `boundaryField`: which entry belongs to which patch, and the conditions it makes.
//!
//! A patch's entry is found as OpenFOAM does: its own name, then a group it belongs to (the last
//! one in the file wins), then a pattern (again the last one).

use crate::WaveTable;
use granflow_base::Vec3;
use granflow_dict::{
    CONSTRAINT_TYPES, Dict, Entry, Key, Payload, Reader, Sink, Tok, Token, Value, nearest,
};
use granflow_fv::conditions::{PatchContext, read_scalar, read_vector};
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

/// Entries of a condition that are in units of the field.
const SCALED: &[&str] = &["value", "gradient", "inletValue", "p", "p0", "uniformValue", "refValue"];

/// Finds the entry of every patch and checks that a condition can be made of it. Returns the
/// entries as the user wrote them, one per patch; mistakes go to the reader's sink.
pub fn resolve<T: FieldType>(
    r: &Reader<'_>,
    field: &str,
    dims: granflow_base::Dims,
    poly: &PolyMesh,
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
            dims,
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
    (poly, waves): (&PolyMesh, &WaveTable),
    dims: granflow_base::Dims,
    factor: f64,
) -> Vec<Box<dyn Condition<T>>> {
    let silent = Sink::new();
    let one = |(i, whole): (usize, &PolyPatch)| {
        let patch = &mesh.patches[i];
        let mine: Vec<usize> =
            patch.faces.clone().map(|f| (mesh.poly_face[f] >> 1) as usize - whole.start).collect();
        let d = local(&entries[i], factor, whole.len, &mine);
        let extents = waves.extents(i, poly, mesh, &mine);
        let context = PatchContext {
            patch: &whole.name,
            kind: &whole.kind,
            n_faces: mine.len(),
            n_inner: mesh.n_inner,
            dims,
            wave: waves.at(i, &extents),
        };
        T::condition(&Reader::new(&d, &silent), &context)
    };
    poly.patches.iter().enumerate().map(one).collect()
}

/// An entry for some faces of its patch, its values times `factor`.
fn local(entry: &Dict, factor: f64, n_faces: usize, mine: &[usize]) -> Dict {
    let mut d = entry.clone();
    for e in &mut d.entries {
        let Value::Stream(tokens) = &mut e.value else { continue };
        let k = if SCALED.contains(&e.key.text()) { factor } else { 1.0 };
        let how = tokens.first().and_then(Token::word).map(str::to_owned);
        match how.as_deref() {
            Some("nonuniform") => {
                if let Some(list) = tokens.last().and_then(|t| picked(t, k, n_faces, mine)) {
                    *tokens = vec![Token::of_word("nonuniform"), list];
                }
            }
            Some("table") if k != 1.0 => {
                for t in tokens.iter_mut().skip(1) {
                    scale_table(t, k);
                }
            }
            _ if k != 1.0 => tokens.iter_mut().for_each(|t| scale(t, k)),
            _ => {}
        }
    }
    d
}

/// The chosen items of a list of `n` values, times `k`.
fn picked(t: &Token, k: f64, n: usize, mine: &[usize]) -> Option<Token> {
    let payload = if let Some(v) = t.scalars().filter(|v| v.len() == n) {
        Payload::Scalars(mine.iter().map(|&i| k * v[i]).collect())
    } else {
        let v = t.vectors().filter(|v| v.len() == n)?;
        Payload::Vectors(mine.iter().map(|&i| v[i].map(|x| k * x)).collect())
    };
    Some(Token { kind: Tok::Packed(Arc::new(payload)), span: t.span.clone() })
}

fn scale(t: &mut Token, k: f64) {
    if let Some(x) = t.number() {
        t.kind = Tok::Number(k * x);
    }
}

/// `((t v) (t v))`: the second of each pair.
fn scale_table(t: &mut Token, k: f64) {
    if let Tok::List(rows) = &mut t.kind {
        for row in rows {
            if let Tok::List(pair) = &mut row.kind
                && let Some(v) = pair.get_mut(1)
            {
                scale(v, k);
            }
        }
    }
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
        let found = resolve::<f64>(&Reader::new(&dict, &sink), "p", dims, &poly);
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
        resolve::<f64>(&Reader::new(&dict, &sink), "p", dims, &mesh());
        let all = sink.take();
        assert_eq!((all.n_errors(), all.n_warnings()), (1, 1));
        let text = all.to_string();
        assert!(text.contains("no condition for patch `xMin`"), "{text}");
        assert!(text.contains("`xMim` is no patch; did you mean `xMin`?"), "{text}");
    }

    #[test]
    fn values_are_cut_and_scaled() {
        let (d, _) = parse_str(
            "type fixedValue; value nonuniform List<scalar> 3 (1 2 3); \
             uniformValue table ((0 1) (2 5)); mode 4;",
        );
        let cut = local(&d, 10.0, 3, &[2, 0]);
        let values = cut.stream("value").and_then(|t| t.last()?.scalars());
        assert_eq!(values, Some(vec![30.0, 10.0]));
        let table = cut.stream("uniformValue").and_then(|t| t[1].list()?[1].scalars());
        assert_eq!(table, Some(vec![2.0, 50.0]));
        assert_eq!(cut.number("mode"), Some(4.0));
    }
}
