//! `blockMeshDict` to [`BlockMesh`].

use super::curve::{Curve, passes};
use super::grading::Section;
use super::names::Names;
use super::read_edges::read_edge;
use super::read_patches::{read_boundary, read_patches};
use super::{Block, BlockMesh, HELP_PROJECT, Merge};
use crate::patch_kind::read_kind;
use crate::polymesh::PatchKind;
use granflow_base::{Dims, Vec3, scale};
use granflow_dict::{Diag, Dict, Reader, Severity, Sink, Token, TokenReader, nearest};

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
    // Surfaces do no harm as long as nothing is projected onto them.
    r.ignore("geometry");
    if let Some(g) = r.opt_sub("geometry") {
        g.ignore_all();
    }
    let key = if r.has("scale") { "scale" } else { "convertToMeters" };
    r.ignore("convertToMeters");
    let unit = r.opt_positive(key, Dims::NONE, 1.0) * r.opt_positive("prescale", Dims::NONE, 1.0);
    let mut names = Names::default();
    let vertices = read_vertices(&r, &mut names).into_iter().map(|v| scale(v, unit)).collect();
    let mut mesh = BlockMesh {
        vertices,
        blocks: Vec::new(),
        edges: Vec::new(),
        patches: Vec::new(),
        default_patch: ("defaultFaces".into(), PatchKind::Empty),
        merges: Vec::new(),
        whole: dict.close.clone(),
        warnings: Vec::new(),
    };
    if let Some(mut list) = r.list("blocks") {
        while !list.is_empty() {
            match read_block(&mut list, &mut names, mesh.blocks.len()) {
                Some(b) => mesh.blocks.push(b),
                // Out of step: what follows would only produce nonsense.
                None => break,
            }
        }
    }
    if let Some(mut list) = r.maybe_list("edges") {
        while !list.is_empty() {
            let Some(edge) = read_edge(&mut list, &names, unit) else { break };
            mesh.edges.extend(edge);
        }
    }
    if let Some(mut list) = r.maybe_list("faces") {
        projected_faces(&mut list);
    }
    if let Some(d) = r.opt_sub("defaultPatch") {
        d.opt_word("name", "defaultFaces").clone_into(&mut mesh.default_patch.0);
        if d.has("type") {
            mesh.default_patch.1 = read_kind(&d);
        }
    }
    if r.has("boundary") {
        read_boundary(&r, &mut mesh, &names);
    } else if r.has("patches") {
        read_patches(&r, &mut mesh, &names);
    }
    read_merges(&r, &mut mesh);
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

/// `faces ( project (vertices) surface .. )`: refused one by one.
fn projected_faces(list: &mut TokenReader<'_>) {
    while !list.is_empty() {
        let start = list.here();
        let word = list.word("`project`");
        list.next();
        list.next();
        let what = format!("faces of type `{word}` are not supported");
        list.error_at(&start.to(&list.last_span()), what, "this face", Some(HELP_PROJECT));
    }
}

/// `mergePatchPairs ( (first second) .. )`.
fn read_merges(r: &Reader<'_>, mesh: &mut BlockMesh) {
    // An empty list may stand without brackets of its own, or be `0()`.
    let Some(mut list) = r.maybe_list("mergePatchPairs") else { return };
    while !list.is_empty() {
        let at = list.here();
        let Some(mut pair) = list.list("a pair of patches") else { return };
        let mut patch = |what: &str| {
            let here = pair.here();
            let name = pair.word(what).to_owned();
            let found = mesh.patches.iter().position(|p| p.name == name);
            if found.is_none() && !name.is_empty() {
                let near = nearest(&name, mesh.patches.iter().map(|p| p.name.as_str()));
                let help = near.map(|n| format!("did you mean `{n}`?"));
                let what = format!("there is no patch `{name}` to merge");
                pair.error_at(&here, what, "not in `boundary`", help.as_deref());
            }
            found
        };
        let (first, second) = (patch("the first patch"), patch("the second patch"));
        if let (Some(first), Some(second)) = (first, second) {
            mesh.merges.push(Merge { first, second, span: at });
        }
    }
}

fn read_vertices(r: &Reader<'_>, names: &mut Names) -> Vec<Vec3> {
    let Some(tokens) = r.raw("vertices") else {
        r.error_here("`vertices` is missing", "", Some("list the corners of the blocks"));
        return Vec::new();
    };
    let list = tokens.iter().rfind(|t| t.label().is_none());
    if let Some(v) = list.and_then(Token::vectors) {
        return v;
    }
    // One by one: some have names, and what is odd is to be said.
    let Some(mut list) = r.list("vertices") else { return Vec::new() };
    let mut out = Vec::new();
    while !list.is_empty() {
        let start = list.here();
        let Some(name) = Names::opening(&mut list) else { break };
        if let Some(name) = name {
            names.vertices.insert(name.to_owned(), out.len() as u32);
        }
        let project = list.peek().and_then(Token::word) == Some("project");
        if project {
            list.next();
        }
        let Some(v) = list.opt_vector() else {
            list.error("expected a vertex, three numbers in parentheses", "not a point", None);
            break;
        };
        out.push(v);
        if project {
            list.next();
            let what = "vertices of type `project` are not supported";
            list.error_at(&start.to(&list.last_span()), what, "this vertex", Some(HELP_PROJECT));
        }
    }
    out
}

/// `hex (8 vertices) [zone] (3 cell counts) grading`.
fn read_block(list: &mut TokenReader<'_>, names: &mut Names, number: usize) -> Option<Block> {
    let start = list.here();
    if let Some(name) = Names::opening(list)? {
        names.blocks.insert(name.to_owned(), number as u32);
    }
    let shape = list.word("a block shape");
    if shape != "hex" {
        let what = format!("blocks of shape `{shape}` are not supported");
        list.error_at(&start, &what, "expected `hex`", None);
        return None;
    }
    let at = list.here();
    let vertices = names.vertices(list, "the block's vertices")?;
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
