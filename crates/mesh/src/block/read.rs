//! `blockMeshDict` to [`BlockMesh`].

use super::curve::{Curve, passes};
use super::grading::Section;
use super::{Block, BlockMesh, BlockPatch, Edge, FACES};
use crate::patch_kind::{read_kind, refusal, simple_kind};
use crate::polymesh::PatchKind;
use granflow_base::{Dims, Vec3, scale};
use granflow_dict::{Diag, Dict, Reader, Severity, Sink, Span, Token, TokenReader, nearest};

/// Reads a parsed `blockMeshDict`.
///
/// # Errors
/// Every mistake found, each with its place.
pub fn read(dict: &Dict) -> Result<BlockMesh, Vec<Diag>> {
    let sink = Sink::new();
    let r = Reader::new(dict, &sink);
    r.ignore("FoamFile");
    for flag in ["fastMerge", "mergeType", "checkFaceCorrespondence", "verbose", "namedVertices"] {
        r.ignore(flag);
    }
    for refused in ["geometry", "mergePatchPairs"] {
        refuse_unless_empty(&r, refused);
    }
    let unit = if r.has("scale") {
        r.ignore("convertToMeters");
        r.opt_positive("scale", Dims::NONE, 1.0)
    } else {
        r.opt_positive("convertToMeters", Dims::NONE, 1.0)
    };
    let vertices: Vec<Vec3> = read_vertices(&r).into_iter().map(|v| scale(v, unit)).collect();
    let mut mesh = BlockMesh {
        vertices,
        blocks: Vec::new(),
        edges: Vec::new(),
        patches: Vec::new(),
        default_patch: ("defaultFaces".into(), PatchKind::Empty),
        whole: dict.close.clone(),
        warnings: Vec::new(),
    };
    if let Some(mut list) = r.list("blocks") {
        while !list.is_empty() {
            match read_block(&mut list) {
                Some(b) => mesh.blocks.push(b),
                // Out of step: what follows would only produce nonsense.
                None => break,
            }
        }
    }
    if let Some(mut list) = r.maybe_list("edges") {
        while !list.is_empty() {
            let Some(edge) = read_edge(&mut list, unit) else { break };
            mesh.edges.extend(edge);
        }
    }
    if let Some(list) = r.maybe_list("faces")
        && !list.is_empty()
    {
        list.error("projected faces are not supported", "here", None);
    }
    if let Some(d) = r.opt_sub("defaultPatch") {
        d.opt_word("name", "defaultFaces").clone_into(&mut mesh.default_patch.0);
        if d.has("type") {
            mesh.default_patch.1 = read_kind(&d);
        }
    }
    if r.has("boundary") {
        read_boundary(&r, &mut mesh);
    } else if r.has("patches") {
        read_patches(&r, &mut mesh);
    }
    r.finish(Severity::Warning);
    if !sink.has_errors() {
        odd_edges(&mesh, &sink);
        free_sides(&mesh, &sink);
    }
    let found = sink.take();
    if found.has_errors() {
        return Err(found.0);
    }
    mesh.warnings = found.0;
    Ok(mesh)
}

fn refuse_unless_empty(r: &Reader<'_>, key: &str) {
    let empty = match r.raw(key) {
        None => match r.opt_sub(key) {
            None => true,
            Some(s) => {
                let none = s.keys().is_empty();
                s.ignore_all();
                none
            }
        },
        Some(tokens) => {
            tokens.iter().all(|t| t.list().is_some_and(<[Token]>::is_empty) || t.label() == Some(0))
        }
    };
    if !empty {
        let help = if key == "mergePatchPairs" {
            "divide the blocks so that their sides match one to one"
        } else {
            "use arc, polyLine or spline edges"
        };
        r.error_at_key(key, format!("`{key}` is not supported"), "here", Some(help));
    }
}

fn read_vertices(r: &Reader<'_>) -> Vec<Vec3> {
    let Some(tokens) = r.raw("vertices") else {
        r.error_here("`vertices` is missing", "", Some("list the corners of the blocks"));
        return Vec::new();
    };
    let list = tokens.iter().rfind(|t| t.label().is_none());
    if let Some(v) = list.and_then(Token::vectors) {
        return v;
    }
    // One by one, to say which entry is odd.
    let Some(mut list) = r.list("vertices") else { return Vec::new() };
    let mut out = Vec::new();
    while !list.is_empty() {
        if let Some(v) = list.opt_vector() {
            out.push(v);
            continue;
        }
        let help = match list.peek().and_then(Token::word) {
            Some("project") => Some("projection onto surfaces is not supported"),
            Some("name") => Some("named vertices are not supported: use their numbers"),
            _ => None,
        };
        list.error("expected a vertex, three numbers in parentheses", "not a point", help);
        break;
    }
    out
}

/// `hex (8 vertices) [zone] (3 cell counts) grading`.
fn read_block(list: &mut TokenReader<'_>) -> Option<Block> {
    let start = list.here();
    let shape = list.word("a block shape");
    if shape != "hex" {
        let what = format!("blocks of shape `{shape}` are not supported");
        list.error_at(&start, &what, "expected `hex`", None);
        return None;
    }
    let at = list.here();
    let vertices = indices(list, "the block's vertices")?;
    let Ok(vertices) = <[u32; 8]>::try_from(vertices.as_slice()) else {
        let what = format!("a hex has 8 vertices, found {}", vertices.len());
        list.error_at(&at, &what, "the vertices of this block", None);
        return None;
    };
    let zone = list.opt_word().map(str::to_owned);
    let at = list.here();
    let counts = list.next().and_then(Token::labels).unwrap_or_default();
    let cells: Vec<usize> = counts.iter().filter_map(|&n| usize::try_from(n).ok()).collect();
    let cells = match <[usize; 3]>::try_from(cells.as_slice()) {
        Ok(c) if c.iter().all(|&n| (1..1 << 28).contains(&n)) => c,
        _ => {
            let what =
                "expected the numbers of cells along the three directions, such as (20 20 1)";
            list.error_at(&at, what, "three positive whole numbers", None);
            return None;
        }
    };
    let grading = read_grading(list)?;
    let span = start.to(&list.last_span());
    Some(Block { vertices, cells, grading, zone, span })
}

/// Non-negative whole numbers in parentheses.
fn indices(list: &mut TokenReader<'_>, what: &str) -> Option<Vec<u32>> {
    let at = list.here();
    let labels = list.next().and_then(Token::labels);
    let found = labels.and_then(|l| l.iter().map(|&v| u32::try_from(v).ok()).collect());
    if found.is_none() {
        list.error_at(
            &at,
            format!("expected {what}, vertex numbers in parentheses"),
            "not a list of vertex numbers",
            None,
        );
    }
    found
}

fn read_grading(list: &mut TokenReader<'_>) -> Option<[Vec<Section>; 12]> {
    let at = list.here();
    let word = list.opt_word().unwrap_or("simpleGrading");
    let count = match word {
        "simpleGrading" => 3,
        "edgeGrading" => 12,
        _ => {
            let near = nearest(word, ["simpleGrading", "edgeGrading"]);
            let help = near.map(|n| format!("did you mean `{n}`?"));
            let what = format!("unknown grading `{word}`");
            list.error_at(&at, &what, "expected simpleGrading or edgeGrading", help.as_deref());
            return None;
        }
    };
    let at = list.here();
    let token = list.next();
    let mut ratios: Vec<Vec<Section>> = Vec::new();
    if let Some(numbers) = token.and_then(Token::scalars) {
        ratios = numbers.iter().map(|&x| Section::simple(expansion(x))).collect();
    } else if let Some(items) = token.and_then(Token::list) {
        for t in items {
            match (t.number(), t.list()) {
                (Some(x), _) => ratios.push(Section::simple(expansion(x))),
                (_, Some(sections)) => ratios.push(sections.iter().filter_map(section).collect()),
                _ => ratios.push(Vec::new()),
            }
        }
    }
    if ratios.len() == 1 {
        ratios = vec![ratios[0].clone(); count];
    }
    let usable =
        |s: &Section| [s.length, s.cells, s.ratio].iter().all(|x| x.is_finite() && *x > 0.0);
    let fine =
        ratios.len() == count && ratios.iter().all(|s| !s.is_empty() && s.iter().all(usable));
    if !fine {
        let what = format!(
            "{word} needs {count} expansion ratios, each a number or a list of (length cells ratio)"
        );
        list.error_at(&at, &what, "not such a list", None);
        return None;
    }
    let each = |e: usize| ratios[if count == 3 { e / 4 } else { e }].clone();
    Some(std::array::from_fn(each))
}

/// A negative ratio means its reciprocal, as OpenFOAM's users write it.
fn expansion(x: f64) -> f64 {
    if x < 0.0 { -1.0 / x } else { x }
}

fn section(t: &Token) -> Option<Section> {
    match t.scalars()?[..] {
        [length, cells, ratio] => Some(Section { length, cells, ratio: expansion(ratio) }),
        _ => None,
    }
}

/// `None`: out of step; `Some(None)`: a straight line, nothing to keep.
fn read_edge(list: &mut TokenReader<'_>, unit: f64) -> Option<Option<Edge>> {
    const KNOWN: [&str; 6] = ["arc", "line", "polyLine", "spline", "simpleSpline", "arc"];
    let start = list.here();
    let word = list.word("an edge type");
    if !KNOWN.contains(&word) {
        let help = nearest(word, KNOWN).map(|n| format!("did you mean `{n}`?"));
        let what = format!("edges of type `{word}` are not supported");
        list.error_at(&start, &what, "expected arc, line, polyLine or spline", help.as_deref());
        return None;
    }
    let (a, b) = (list.label("the edge's first vertex"), list.label("the edge's second vertex"));
    let (Ok(a), Ok(b)) = (u32::try_from(a), u32::try_from(b)) else {
        list.error_at(&start, "vertex numbers cannot be negative", "this edge", None);
        return None;
    };
    let curve = match word {
        "line" => return Some(None),
        "arc" => {
            if list.peek().and_then(Token::number).is_some()
                || list.peek().is_some_and(|t| t.word().is_some())
            {
                let help = "write `arc a b (x y z)` with a point the arc passes through";
                list.error("this form of arc is not supported", "not a point", Some(help));
                return None;
            }
            Curve::Arc(scale(list.vector("a point on the arc"), unit))
        }
        _ => {
            let at = list.here();
            let Some(points) = list.next().and_then(Token::vectors) else {
                list.error_at(&at, "expected the points of the edge", "not a list of points", None);
                return None;
            };
            let points = points.into_iter().map(|p| scale(p, unit)).collect();
            if word == "polyLine" { Curve::PolyLine(points) } else { Curve::Spline(points) }
        }
    };
    let span = start.to(&list.last_span());
    Some(Some(Edge { ends: [a, b], curve, span }))
}

/// `boundary ( name { type ...; faces (...); } ... )`.
fn read_boundary(r: &Reader<'_>, mesh: &mut BlockMesh) {
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
                let Some(face) = read_face(&mut f, mesh) else { break };
                faces.push(face);
            }
        }
        p.finish(Severity::Warning);
        push_patch(mesh, BlockPatch { name, kind, faces, in_groups, span: at }, &list);
    }
}

/// The old form: `patches ( type name ( faces ) ... )`.
fn read_patches(r: &Reader<'_>, mesh: &mut BlockMesh) {
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
            let Some(face) = read_face(&mut f, mesh) else { return };
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
fn read_face(list: &mut TokenReader<'_>, mesh: &BlockMesh) -> Option<([u32; 4], Span)> {
    let at = list.here();
    let v = indices(list, "a face")?;
    let face = match v[..] {
        [a, b, c, d] => Some([a, b, c, d]),
        [a, b, c] => Some([a, b, c, c]),
        [b, s] if (s as usize) < 6 => mesh.blocks.get(b as usize).map(|b| {
            let sides = FACES[s as usize];
            sides.map(|v| b.vertices[v])
        }),
        _ => None,
    };
    if face.is_none() {
        let what = format!("a face has 4 vertices, found {}", v.len());
        list.error_at(&at, &what, "this face", None);
    }
    face.map(|f| (f, at))
}

fn odd_edges(mesh: &BlockMesh, sink: &Sink) {
    for e in &mesh.edges {
        let end = |i: usize| mesh.vertices.get(e.ends[i] as usize).copied();
        if let (Curve::Arc(through), Some(from), Some(to)) = (&e.curve, end(0), end(1))
            && !passes(from, *through, to)
        {
            let d = Diag::warning(&e.span, "this arc does not pass through its point")
                .label("the point lies beyond the arc's end")
                .help("give a point between the two vertices");
            sink.push(d);
        }
        let on = |b: &Block| {
            super::EDGES.iter().any(|ends| {
                let [p, q] = ends.map(|v| b.vertices[v]);
                [p, q] == e.ends || [q, p] == e.ends
            })
        };
        if !mesh.blocks.iter().any(on) {
            let [a, b] = e.ends;
            let what = format!("no block has an edge between vertices {a} and {b}");
            sink.push(Diag::warning(&e.span, what).label("this curve is not used"));
        }
    }
}

fn free_sides(mesh: &BlockMesh, sink: &Sink) {
    let Ok(t) = super::topology::connect(mesh) else { return };
    let free = |s: &super::topology::Side| *s == super::topology::Side::Free;
    let n = t.sides.iter().flatten().filter(|s| free(s)).count();
    if n > 0 && mesh.default_patch.1 != PatchKind::Empty {
        return;
    }
    if n > 0 {
        let (name, kind) = &mesh.default_patch;
        let what = format!("{n} block sides belong to no patch");
        let d = Diag::warning(&mesh.whole, what)
            .label(format!("they become the patch `{name}` of type {}", kind.word()))
            .help("name them in `boundary`, or choose with `defaultPatch { name ..; type ..; }`");
        sink.push(d);
    }
}
