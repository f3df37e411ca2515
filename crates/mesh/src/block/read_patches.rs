//! The lists `boundary` and `patches` of a `blockMeshDict`.

use super::names::Names;
use super::{BlockMesh, BlockPatch};
use crate::patch_kind::{read_kind, refusal, simple_kind};
use granflow_dict::{Reader, Severity, Span, TokenReader};

/// `boundary ( name { type ...; faces (...); } ... )`.
pub(super) fn read_boundary(r: &Reader<'_>, mesh: &mut BlockMesh, names: &Names) {
    r.ignore("patches");
    let Some(mut list) = r.list("boundary") else { return };
    while !list.is_empty() {
        let at = list.here();
        let name = list.word("a patch name").to_owned();
        let Some(p) = list.dict("the patch's entries") else { break };
        let kind = read_kind(&p);
        let in_groups =
            p.maybe_words("inGroups").unwrap_or_default().iter().map(|&w| w.to_owned()).collect();
        p.ignore("physicalType");
        let mut faces = Vec::new();
        if let Some(mut f) = p.list("faces") {
            while !f.is_empty() {
                let Some(face) = read_face(&mut f, mesh, names) else { break };
                faces.push(face);
            }
        }
        p.finish(Severity::Warning);
        push_patch(mesh, BlockPatch { name, kind, faces, in_groups, span: at }, &list);
    }
}

/// The old form: `patches ( type name ( faces ) ... )`.
pub(super) fn read_patches(r: &Reader<'_>, mesh: &mut BlockMesh, names: &Names) {
    let Some(mut list) = r.list("patches") else { return };
    while !list.is_empty() {
        let at = list.here();
        let word = list.word("a patch type");
        let Some(kind) = simple_kind(word) else {
            let help = if word == "cyclic" {
                "name both halves in a `boundary` list".to_owned()
            } else {
                refusal(word)
            };
            let what = format!("patches of type `{word}` are not supported in the list `patches`");
            list.error_at(&at, &what, "unknown patch type", Some(&help));
            return;
        };
        let name = list.word("a patch name").to_owned();
        let mut faces = Vec::new();
        let Some(mut f) = list.list("the patch's faces") else { return };
        while !f.is_empty() {
            let Some(face) = read_face(&mut f, mesh, names) else { return };
            faces.push(face);
        }
        let patch = BlockPatch { name, kind, faces, in_groups: Vec::new(), span: at };
        push_patch(mesh, patch, &list);
    }
}

fn push_patch(mesh: &mut BlockMesh, patch: BlockPatch, list: &TokenReader<'_>) {
    if mesh.patches.iter().any(|p| p.name == patch.name) {
        let what = format!("patch `{}` is given twice", patch.name);
        list.error_at(&patch.span, &what, "the second one", None);
    }
    mesh.patches.push(patch);
}

/// Four vertices, or a block and one of its sides.
fn read_face(
    list: &mut TokenReader<'_>,
    mesh: &BlockMesh,
    names: &Names,
) -> Option<([u32; 4], Span)> {
    let at = list.here();
    let side = list.peek().and_then(|t| names.side(t)).filter(|&(_, s)| s < 6);
    if let Some((b, s)) = side
        && let Some(block) = mesh.blocks.get(b as usize)
    {
        list.next();
        return Some((block.side(s as usize), at));
    }
    let v = names.vertices(list, "a face")?;
    let face = match v[..] {
        [a, b, c, d] => Some([a, b, c, d]),
        [a, b, c] => Some([a, b, c, c]),
        _ => None,
    };
    if face.is_none() {
        let what = format!("a face has 4 vertices, found {}", v.len());
        list.error_at(&at, &what, "this face", None);
    }
    face.map(|f| (f, at))
}
