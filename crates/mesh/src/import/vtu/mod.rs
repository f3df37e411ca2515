//! VTK's unstructured grids in XML, `.vtu`.
//!
//! Layout after "VTK XML file formats" (docs.vtk.org). Arrays may be text, base64 in place, or
//! appended raw or in base64, compressed with zlib or not.

mod arrays;

use super::elements::{Elements, NONE, Shape};
use super::{Importer, Options};
use arrays::Arrays;
use granflow_dict::{Diag, Source, Span, nearest};
use roxmltree::{Document, Node};
use std::sync::Arc;

/// VTK's format.
pub(super) const IMPORTER: Importer = Importer { name: "VTU", claims, read };

/// Arrays on cells that are taken to tell groups apart when nobody says which.
const GROUPS: [&str; 4] = ["patch", "CellEntityIds", "gmsh:physical", "PhysicalIds"];

fn claims(bytes: &[u8]) -> bool {
    let head = bytes.trim_ascii_start();
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    head.starts_with(b"<") && head.windows(8).take(4096).any(|w| w == b"<VTKFile")
}

/// VTK's numbers of shapes.
mod shape {
    pub(super) const VERTEX: i64 = 1;
    pub(super) const POLY_VERTEX: i64 = 2;
    pub(super) const LINE: i64 = 3;
    pub(super) const TRIANGLE: i64 = 5;
    pub(super) const POLYGON: i64 = 7;
    pub(super) const PIXEL: i64 = 8;
    pub(super) const QUAD: i64 = 9;
    pub(super) const TETRA: i64 = 10;
    pub(super) const VOXEL: i64 = 11;
    pub(super) const HEXAHEDRON: i64 = 12;
    pub(super) const WEDGE: i64 = 13;
    pub(super) const PYRAMID: i64 = 14;
    pub(super) const POLYHEDRON: i64 = 42;
}

fn read(src: &Arc<Source>, options: &Options) -> Result<Elements, Vec<Diag>> {
    let arrays = Arrays::of(src)?;
    let xml = Document::parse(&arrays.xml).map_err(|e| vec![no_xml(src, &arrays.xml, &e)])?;
    let root = xml.root_element();
    let kind = root.attribute("type").unwrap_or("nothing");
    if kind != "UnstructuredGrid" {
        let d = Diag::error(&arrays.span(root), format!("a VTK file of type {kind} is no mesh"));
        return Err(vec![d.help("save an unstructured grid (.vtu)")]);
    }
    let mut out = Elements::default();
    for piece in xml.descendants().filter(|n| n.has_tag_name("Piece")) {
        read_piece(&arrays, root, piece, options, &mut out).map_err(|d| vec![d])?;
    }
    Ok(out)
}

/// What is wrong with the XML, at its line.
fn no_xml(src: &Arc<Source>, xml: &str, e: &roxmltree::Error) -> Diag {
    let before = xml.split_inclusive('\n').take(e.pos().row.saturating_sub(1) as usize);
    let line = before.map(str::len).sum::<usize>();
    let end = xml[line..].find('\n').map_or(xml.len(), |n| line + n);
    Diag::error(&Span::new(src, line..end.min(src.text.len())), "this is no XML")
        .label(e.to_string())
}

/// Adds the points and the cells of a piece.
fn read_piece(
    arrays: &Arrays,
    root: Node<'_, '_>,
    piece: Node<'_, '_>,
    options: &Options,
    out: &mut Elements,
) -> Result<(), Diag> {
    let section = |name: &str| {
        let found = piece.children().find(|n| n.has_tag_name(name));
        let what = format!("the piece has no `{name}`");
        found.ok_or_else(|| Diag::error(&arrays.span(piece), what))
    };
    let points = section("Points")?;
    let array = points.children().find(|n| n.has_tag_name("DataArray"));
    let array = array.ok_or_else(|| Diag::error(&arrays.span(points), "there are no points"))?;
    let values = arrays.numbers(root, array)?;
    announced(arrays, piece, "NumberOfPoints", values.len() as f64 / 3.0)?;
    let cells = section("Cells")?;
    let cells = Cells {
        first_point: out.points.len() as u32,
        groups: group_array(arrays, root, piece, options)?,
        ..Cells::new(arrays, root, cells)?
    };
    announced(arrays, piece, "NumberOfCells", cells.types.len() as f64)?;
    out.points.extend(values.chunks_exact(3).map(|x| [x[0], x[1], x[2]]));
    cells.add_to(out)
}

/// What a piece says of itself must be what it has: a number that fits nothing is a damaged file.
fn announced(arrays: &Arrays, piece: Node<'_, '_>, key: &str, found: f64) -> Result<(), Diag> {
    let Some(said) = piece.attribute(key) else { return Ok(()) };
    if said.trim().parse() == Ok(found) {
        return Ok(());
    }
    let what = format!("`{key}` is {said}, and the piece has {found}");
    Err(Diag::error(&arrays.span(piece), what)
        .help("the file is damaged or cut off: save it again"))
}

/// The cells of a piece as the file has them.
struct Cells {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<i64>,
    polyhedra: Polyhedra,
    /// Name and values of the array that tells groups apart.
    groups: Option<(String, Vec<i64>)>,
    /// Points of earlier pieces.
    first_point: u32,
    /// Where the file has them.
    span: Span,
}

impl Cells {
    fn new(arrays: &Arrays, root: Node<'_, '_>, cells: Node<'_, '_>) -> Result<Cells, Diag> {
        let named = |name: &str| {
            let wanted = |n: &Node<'_, '_>| n.attribute("Name") == Some(name);
            cells.children().filter(|n| n.has_tag_name("DataArray")).find(wanted)
        };
        let integers = |name: &str| -> Result<Vec<i64>, Diag> {
            let what = format!("`Cells` has no array `{name}`");
            let array = named(name).ok_or_else(|| Diag::error(&arrays.span(cells), what))?;
            arrays.integers(root, array)
        };
        let types = integers("types")?;
        let polyhedra = match (named("faces"), named("polyhedron_to_faces")) {
            (Some(_), _) => Polyhedra::Streams(integers("faces")?, integers("faceoffsets")?),
            (None, Some(_)) => Polyhedra::Faces {
                points: integers("face_connectivity")?,
                ends: integers("face_offsets")?,
                faces: integers("polyhedron_to_faces")?,
                cells: integers("polyhedron_offsets")?,
                n_cells: types.len(),
            },
            _ => Polyhedra::None,
        };
        Ok(Cells {
            connectivity: integers("connectivity")?,
            offsets: integers("offsets")?,
            types,
            polyhedra,
            groups: None,
            first_point: 0,
            span: arrays.span(cells),
        })
    }

    fn fault(&self, what: String) -> Diag {
        Diag::error(&self.span, what)
    }

    fn point(&self, p: i64) -> Result<u32, Diag> {
        let found = u32::try_from(p).ok().and_then(|p| p.checked_add(self.first_point));
        found.ok_or_else(|| self.fault(format!("a cell uses point {p}")))
    }

    fn points(&self, ring: &[i64]) -> Result<Vec<u32>, Diag> {
        ring.iter().map(|&p| self.point(p)).collect()
    }

    fn add_to(&self, out: &mut Elements) -> Result<(), Diag> {
        let n = self.types.len();
        if self.offsets.len() != n {
            let m = self.offsets.len();
            return Err(self.fault(format!("{n} types of cells but {m} offsets")));
        }
        if let Some((name, g)) = self.groups.as_ref().filter(|(_, g)| g.len() != n) {
            let m = g.len();
            return Err(self.fault(format!("the array `{name}` has {m} values for {n} cells")));
        }
        let mut start = 0i64;
        for c in 0..n {
            let range = usize::try_from(start).ok().zip(usize::try_from(self.offsets[c]).ok());
            let ring = range.and_then(|(a, b)| self.connectivity.get(a..b));
            let ring =
                ring.ok_or_else(|| self.fault(format!("cell {c} ends beyond the list of points")))?;
            start = self.offsets[c];
            self.add_cell(c, self.points(ring)?, out)?;
        }
        Ok(())
    }

    fn add_cell(&self, c: usize, mut corners: Vec<u32>, out: &mut Elements) -> Result<(), Diag> {
        let dimension = match self.types[c] {
            shape::VERTEX | shape::POLY_VERTEX => return Ok(()),
            shape::LINE => 1,
            shape::TRIANGLE | shape::POLYGON | shape::PIXEL | shape::QUAD => 2,
            _ => 3,
        };
        let group = match &self.groups {
            Some((name, g)) => out.group(dimension, &format!("{name}{}", g[c]), None),
            None => NONE,
        };
        let solid = match self.types[c] {
            shape::LINE => {
                out.lines.push(&corners, group);
                return Ok(());
            }
            shape::TRIANGLE | shape::POLYGON | shape::QUAD => {
                out.surfaces.push(&corners, group);
                return Ok(());
            }
            shape::PIXEL if corners.len() == 4 => {
                corners.swap(2, 3);
                out.surfaces.push(&corners, group);
                return Ok(());
            }
            shape::POLYHEDRON => {
                let faces = self.polyhedra.faces(c);
                let faces = faces.ok_or_else(|| self.fault(format!("cell {c} lacks its faces")))?;
                let rings: Result<Vec<_>, Diag> = faces.iter().map(|f| self.points(f)).collect();
                out.volumes.push(rings?.iter().map(Vec::as_slice), group);
                return Ok(());
            }
            shape::TETRA => Shape::Tetrahedron,
            shape::PYRAMID => Shape::Pyramid,
            shape::WEDGE => Shape::Prism,
            shape::HEXAHEDRON => Shape::Hexahedron,
            shape::VOXEL if corners.len() == 8 => {
                corners.swap(2, 3);
                corners.swap(6, 7);
                Shape::Hexahedron
            }
            other => return Err(unsupported(other, c, &self.span)),
        };
        if corners.len() != solid.corners() {
            let (n, wanted) = (corners.len(), solid.corners());
            return Err(self.fault(format!("cell {c} has {n} points, not {wanted}")));
        }
        out.volumes.push_shape(solid, &corners, group);
        Ok(())
    }
}

/// Why a shape is refused.
fn unsupported(kind: i64, cell: usize, at: &Span) -> Diag {
    let name = match kind {
        4 => "polyline",
        6 => "triangle strip",
        15 => "pentagonal prism",
        16 => "hexagonal prism",
        21..=37 => "cell of second order",
        60..=81 => "Lagrange or Bezier cell",
        _ => "unknown to granflow",
    };
    Diag::error(at, format!("cell {cell} is of VTK's type {kind} ({name}), which is not supported"))
        .help(
            "known are triangle, quad, polygon, tetra, voxel, hexahedron, wedge, pyramid and \
             polyhedron",
        )
}

/// The array that tells groups apart, and its name.
fn group_array(
    arrays: &Arrays,
    root: Node<'_, '_>,
    piece: Node<'_, '_>,
    options: &Options,
) -> Result<Option<(String, Vec<i64>)>, Diag> {
    let data = piece.children().find(|n| n.has_tag_name("CellData"));
    let of = |name: &str| {
        data.and_then(|d| {
            d.children().find(|n| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name))
        })
    };
    if let Some(wanted) = &options.group_array {
        let array = of(wanted).ok_or_else(|| {
            let there: Vec<&str> = data
                .into_iter()
                .flat_map(|d| d.children())
                .filter_map(|n| n.attribute("Name"))
                .collect();
            let help = match (nearest(wanted, there.iter().copied()), there.is_empty()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, true) => "it has no arrays on cells".to_owned(),
                (None, false) => format!("its arrays on cells are {}", there.join(", ")),
            };
            let what = format!("the file has no array `{wanted}` on cells");
            Diag::error(&arrays.span(data.unwrap_or(piece)), what).help(help)
        })?;
        return Ok(Some((wanted.clone(), arrays.integers(root, array)?)));
    }
    for name in GROUPS {
        if let Some(array) = of(name) {
            let values = arrays.integers(root, array)?;
            return Ok(Some((if name == "patch" { name } else { "group" }.to_owned(), values)));
        }
    }
    Ok(None)
}

/// How a file gives the faces of polyhedra.
enum Polyhedra {
    None,
    /// Per cell: number of faces, then of each the number of points and the points; ends of the
    /// cells in it, -1 for other cells.
    Streams(Vec<i64>, Vec<i64>),
    /// Points of all faces and their ends; faces of all cells and their ends.
    Faces {
        points: Vec<i64>,
        ends: Vec<i64>,
        faces: Vec<i64>,
        cells: Vec<i64>,
        n_cells: usize,
    },
}

impl Polyhedra {
    fn faces(&self, c: usize) -> Option<Vec<&[i64]>> {
        match self {
            Polyhedra::None => None,
            Polyhedra::Streams(stream, ends) => {
                let before = ends.get(..c)?.iter().rev().find(|&&e| e >= 0).copied().unwrap_or(0);
                let mut rest = stream.get(before as usize..usize::try_from(*ends.get(c)?).ok()?)?;
                let (&n, tail) = rest.split_first()?;
                rest = tail;
                let mut out = Vec::new();
                for _ in 0..n {
                    let (&points, tail) = rest.split_first()?;
                    let points = usize::try_from(points).ok()?;
                    out.push(tail.get(..points)?);
                    rest = &tail[points..];
                }
                Some(out)
            }
            Polyhedra::Faces { points, ends, faces, cells, n_cells } => {
                let (a, b) = piece(cells, c, cells.len() > *n_cells)?;
                // No face has no points: a zero is an offset of its own.
                let ahead = ends.first() == Some(&0);
                let points = |&f: &i64| {
                    let (a, b) = piece(ends, usize::try_from(f).ok()?, ahead)?;
                    points.get(a..b)
                };
                faces.get(a..b)?.iter().map(points).collect()
            }
        }
    }
}

/// Where item `i` of a list begins and ends, by the ends of all, a zero ahead of them or not.
fn piece(ends: &[i64], i: usize, zero_ahead: bool) -> Option<(usize, usize)> {
    let i = i + usize::from(zero_ahead);
    let begin = if i == 0 { 0 } else { *ends.get(i - 1)? };
    Some((usize::try_from(begin).ok()?, usize::try_from(*ends.get(i)?).ok()?))
}
