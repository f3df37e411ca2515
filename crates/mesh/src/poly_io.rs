//! The files of a `polyMesh` directory, as bytes in and bytes out.

use crate::patch_kind::read_kind;
use crate::polymesh::{CyclicTransform, PatchKind, PolyMesh, PolyPatch};
use granflow_dict::{
    Diag, Dict, Format, Header, List, Payload, Reader, Severity, Sink, Source, Span, list_file,
    parse_list_file,
};
use std::sync::Arc;

/// Names of the files in the order of [`PolyFiles`].
pub const FILES: [&str; 5] = ["points", "faces", "owner", "neighbour", "boundary"];

/// Name of the file of the cell zones; nothing here reads it.
pub const CELL_ZONES: &str = "cellZones";

/// The five files that make a mesh, already decompressed.
#[derive(Clone)]
pub struct PolyFiles {
    /// `points`.
    pub points: Arc<Source>,
    /// `faces`, as a face list or compact.
    pub faces: Arc<Source>,
    /// `owner`.
    pub owner: Arc<Source>,
    /// `neighbour`.
    pub neighbour: Arc<Source>,
    /// `boundary`.
    pub boundary: Arc<Source>,
}

/// A mesh read from its files.
#[derive(Clone)]
pub struct Read {
    /// The mesh; its topology is valid.
    pub mesh: PolyMesh,
    /// What is odd but does no harm.
    pub warnings: Vec<Diag>,
}

/// Puts the files together and checks that they fit each other.
///
/// # Errors
/// Every mistake found, each with its file and place.
pub fn read(files: &PolyFiles) -> Result<Read, Vec<Diag>> {
    let sink = Sink::new();
    let load = |src: &Arc<Source>| {
        let (header, payload, found) = parse_list_file(src.clone());
        let broken = found.iter().any(|d| d.severity == Severity::Error);
        sink.extend(found);
        (header, (!broken).then_some(payload))
    };
    let wrong = |src: &Arc<Source>, payload: &Payload, wanted: &str| {
        let what = format!("expected {wanted}, found {}", payload.describe());
        sink.push(Diag::error(&Span::new(src, 0..0), what));
    };
    let mut mesh = PolyMesh::default();
    match load(&files.points).1 {
        Some(Payload::Vectors(p)) => mesh.points = p,
        Some(other) => wrong(&files.points, &other, "a list of points"),
        None => {}
    }
    match load(&files.faces).1 {
        Some(Payload::Faces { ptr, points }) => {
            mesh.face_ptr = ptr;
            mesh.face_points = points;
        }
        Some(other) => wrong(&files.faces, &other, "a list of faces"),
        None => {}
    }
    let labels = |src: &Arc<Source>| match load(src).1 {
        Some(Payload::Labels(l)) => {
            let cells: Option<Vec<u32>> = l.iter().map(|&c| u32::try_from(c).ok()).collect();
            if cells.is_none() {
                let what = "cell numbers must not be negative";
                sink.push(Diag::error(&Span::new(src, 0..0), what));
            }
            cells.unwrap_or_default()
        }
        Some(other) => {
            // An empty list has no type of its own.
            if !other.is_empty() {
                wrong(src, &other, "a list of cell numbers");
            }
            Vec::new()
        }
        None => Vec::new(),
    };
    mesh.owner = labels(&files.owner);
    mesh.neighbour = labels(&files.neighbour);
    match load(&files.boundary).1 {
        Some(Payload::Entries(entries)) => {
            for e in &entries {
                match &e.value {
                    granflow_dict::Value::Dict(d) => {
                        mesh.patches.push(read_patch(e.key.text(), d, &sink));
                    }
                    granflow_dict::Value::Stream(_) => {
                        sink.push(Diag::error(&e.key_span, "expected the entries of a patch"));
                    }
                }
            }
        }
        Some(other) if !other.is_empty() => {
            wrong(&files.boundary, &other, "a list of patches");
        }
        _ => {}
    }
    if !sink.has_errors()
        && let Err(e) = mesh.validate()
    {
        sink.push(Diag::file(&files.owner.path, e.to_string()));
    }
    let found = sink.take();
    if found.has_errors() { Err(found.0) } else { Ok(Read { mesh, warnings: found.0 }) }
}

fn read_patch(name: &str, d: &Dict, sink: &Sink) -> PolyPatch {
    let r = Reader::new(d, sink);
    let kind = read_kind(&r);
    let in_groups = r.maybe_words("inGroups").unwrap_or_default();
    let in_groups = in_groups.iter().map(|&w| w.to_owned()).collect();
    let range = 0..=i64::from(i32::MAX);
    let len = r.label_in("nFaces", range.clone());
    let start = r.label_in("startFace", range);
    r.ignore("physicalType");
    r.finish(Severity::Warning);
    PolyPatch {
        name: name.to_owned(),
        kind,
        start: usize::try_from(start).unwrap_or(0),
        len: usize::try_from(len).unwrap_or(0),
        in_groups,
    }
}

/// The five files of a mesh, named as in [`FILES`], and `cellZones` where it has some. `boundary`
/// and `cellZones` are always text.
pub fn write(mesh: &PolyMesh, format: Format) -> Vec<(&'static str, Vec<u8>)> {
    let header = |class: &str, object: &str, format: Format| {
        Header::new(class, object).location("constant/polyMesh").format(format)
    };
    // OpenFOAM's tools read the sizes of the mesh from this note.
    let note = format!(
        "nPoints:{}  nCells:{}  nFaces:{}  nInternalFaces:{}",
        mesh.points.len(),
        mesh.n_cells(),
        mesh.n_faces(),
        mesh.n_inner()
    );
    let labels = |name: &'static str, list: &[u32]| {
        (name, list_file(&header("labelList", name, format).note(note.clone()), List::Labels(list)))
    };
    let faces = List::Faces { ptr: &mesh.face_ptr, points: &mesh.face_points };
    let mut files = vec![
        (
            "points",
            list_file(&header("vectorField", "points", format), List::Vectors(&mesh.points)),
        ),
        ("faces", list_file(&header("faceList", "faces", format), faces)),
        labels("owner", &mesh.owner),
        labels("neighbour", &mesh.neighbour),
        ("boundary", boundary(mesh, &header("polyBoundaryMesh", "boundary", Format::Ascii))),
    ];
    if !mesh.cell_zones.is_empty() {
        let header = header("regIOobject", CELL_ZONES, Format::Ascii);
        files.push((CELL_ZONES, cell_zones(mesh, &header)));
    }
    files
}

fn cell_zones(mesh: &PolyMesh, header: &Header) -> Vec<u8> {
    let mut w = granflow_dict::Writer::new(header);
    let mut text = format!("{}\n(\n", mesh.cell_zones.len());
    for zone in &mesh.cell_zones {
        text.push_str(&format!("{}\n{{\n    type cellZone;\n", zone.name));
        text.push_str(&format!("    cellLabels List<label>\n{}\n(\n", zone.cells.len()));
        for c in &zone.cells {
            text.push_str(&format!("{c}\n"));
        }
        text.push_str(")\n;\n}\n");
    }
    text.push_str(")\n");
    w.raw(&text);
    w.finish()
}

fn boundary(mesh: &PolyMesh, header: &Header) -> Vec<u8> {
    let mut w = granflow_dict::Writer::new(header);
    let mut text = format!("{}\n(\n", mesh.patches.len());
    for p in &mesh.patches {
        text.push_str(&format!("    {}\n    {{\n", p.name));
        let mut line = |key: &str, value: String| {
            text.push_str(&format!("        {key:<15} {value};\n"));
        };
        line("type", p.kind.word().to_owned());
        if !p.in_groups.is_empty() {
            line("inGroups", format!("{}({})", p.in_groups.len(), p.in_groups.join(" ")));
        }
        line("nFaces", p.len.to_string());
        line("startFace", p.start.to_string());
        if let PatchKind::Cyclic { neighbour, transform } = &p.kind {
            line("matchTolerance", "0.0001".into());
            let vector = |v: [f64; 3]| format!("({})", v.map(granflow_dict::number).join(" "));
            match *transform {
                CyclicTransform::Unknown => line("transform", "unknown".into()),
                CyclicTransform::Translational(s) => {
                    line("transform", "translational".into());
                    line("separationVector", vector(s));
                }
                CyclicTransform::Rotational { axis, origin, angle } => {
                    line("transform", "rotational".into());
                    line("rotationAxis", vector(axis));
                    line("rotationCentre", vector(origin));
                    if let Some(a) = angle {
                        line("rotationAngle", granflow_dict::number(a.to_degrees()));
                    }
                }
            }
            line("neighbourPatch", neighbour.clone());
        }
        text.push_str("    }\n");
    }
    text.push_str(")\n");
    w.raw(&text);
    w.finish()
}
