//! Fluent's `.msh` files (text), in two and three dimensions.
//!
//! The file gives faces with the cells on either side, by zones; numbers are hexadecimal. Layout
//! after the Ansys Fluent user's guide, appendix "Mesh file format".

use super::elements::{Elements, NONE};
use super::{Importer, Options};
use crate::polymesh::PatchKind;
use granflow_base::Vec3;
use granflow_dict::{Diag, Source, Span};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Fluent's format.
pub(super) const IMPORTER: Importer =
    Importer { name: "Fluent", claims: |b| b.trim_ascii_start().starts_with(b"("), read };

/// One face: its points, and the cells it lies between, 0 for none.
struct Face {
    points: Range<usize>,
    cells: [u32; 2],
    zone: u32,
}

#[derive(Default)]
struct Mesh {
    dimension: usize,
    points: Vec<Vec3>,
    faces: Vec<Face>,
    face_points: Vec<u32>,
    /// First and last cell of the zones of cells.
    cells: Vec<(u32, [u32; 2])>,
    /// Type and name of zones.
    zones: HashMap<u32, (String, String)>,
}

/// Text between parentheses, and where it is.
struct Scan<'s> {
    src: &'s Arc<Source>,
    at: usize,
}

impl Scan<'_> {
    fn span(&self, range: Range<usize>) -> Span {
        Span::new(self.src, range)
    }
    fn fault(&self, at: usize, what: impl Into<String>) -> Diag {
        let text = &self.src.text;
        let at = at.min(text.len());
        let n = text[at..].iter().take(60).position(|&b| b == b'\n').unwrap_or(0);
        Diag::error(&self.span(at..at + n), what)
    }
    fn skip_space(&mut self) {
        while self.src.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }
    /// The next mark or word; `None` at the end of the file.
    fn next(&mut self) -> Option<Range<usize>> {
        self.skip_space();
        let text = &self.src.text;
        let first = *text.get(self.at)?;
        let start = self.at;
        let ends = |&b: &u8| b.is_ascii_whitespace() || matches!(b, b'(' | b')' | b'"');
        self.at += match first {
            b'(' | b')' => 1,
            b'"' => text[start + 1..].iter().position(|&b| b == b'"').map_or(text.len(), |n| n + 2),
            _ => text[start..].iter().position(ends).unwrap_or(text.len() - start),
        };
        self.at = self.at.min(text.len());
        Some(start..self.at)
    }
    fn text(&self, range: &Range<usize>) -> &str {
        std::str::from_utf8(&self.src.text[range.clone()]).unwrap_or("?")
    }
    /// Reads `(`; whether it was there.
    fn opens(&mut self) -> bool {
        let before = self.at;
        let found = self.next().is_some_and(|r| self.text(&r) == "(");
        if !found {
            self.at = before;
        }
        found
    }
    /// The words up to the `)` of this list, which has no lists inside.
    fn words(&mut self) -> Result<Vec<String>, Diag> {
        let start = self.at;
        let mut out = Vec::new();
        while let Some(r) = self.next() {
            match self.text(&r) {
                ")" => return Ok(out),
                "(" => break,
                word => out.push(word.trim_matches('"').to_owned()),
            }
        }
        Err(self.fault(start, "expected a list of words and its `)`"))
    }
    /// Goes behind the `)` of a list that has begun.
    fn skip(&mut self) -> Result<(), Diag> {
        let (start, mut depth) = (self.at, 1usize);
        while let Some(r) = self.next() {
            match self.text(&r) {
                "(" => depth += 1,
                ")" if depth == 1 => return Ok(()),
                ")" => depth -= 1,
                _ => {}
            }
        }
        Err(self.fault(start, "a list has no end: `)` is missing"))
    }
    fn closes(&mut self) -> Result<(), Diag> {
        let at = self.at;
        match self.next() {
            Some(r) if self.text(&r) == ")" => Ok(()),
            _ => Err(self.fault(at, "expected `)`")),
        }
    }
    fn hex(&mut self, what: &str) -> Result<u32, Diag> {
        self.skip_space();
        let at = self.at;
        let word = self.next();
        let number = word.and_then(|r| u32::from_str_radix(self.text(&r), 16).ok());
        number.ok_or_else(|| self.fault(at, format!("expected {what}, a hexadecimal number")))
    }
    fn double(&mut self) -> Result<f64, Diag> {
        self.skip_space();
        let at = self.at;
        let word = self.next();
        let number = word.and_then(|r| self.text(&r).parse().ok());
        number.ok_or_else(|| self.fault(at, "expected a coordinate"))
    }
}

fn read(src: &Arc<Source>, _: &Options) -> Result<Elements, Vec<Diag>> {
    let mut s = Scan { src, at: 0 };
    let mut mesh = Mesh { dimension: 3, ..Mesh::default() };
    while let Some(r) = s.next() {
        if s.text(&r) != "(" {
            return Err(vec![s.fault(r.start, "expected a section, `(number ..`")]);
        }
        section(&mut s, &mut mesh).map_err(|d| vec![d])?;
    }
    mesh.elements().map_err(|what| vec![Diag::error(&Span::new(src, 0..0), what)])
}

fn section(s: &mut Scan<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let at = s.at;
    let number = s.next().map(|r| s.text(&r).to_owned()).unwrap_or_default();
    match number.as_str() {
        "2" => {
            let words = s.words()?;
            mesh.dimension = words.first().and_then(|w| w.parse().ok()).unwrap_or(0);
            if !matches!(mesh.dimension, 2 | 3) {
                return Err(s.fault(at, "the dimension must be 2 or 3"));
            }
            Ok(())
        }
        "10" => points(s, mesh),
        "12" => {
            if !s.opens() {
                return s.skip();
            }
            let [zone, first, last, ..] = header(s)?[..] else {
                return Err(s.fault(at, "cells need a zone, the first and the last cell"));
            };
            if zone > 0 {
                mesh.cells.push((zone, [first, last]));
            }
            // What follows are shapes, which the faces tell as well.
            s.skip()
        }
        "13" => faces(s, mesh, at),
        "39" | "45" => {
            if s.opens() {
                let words = s.words()?;
                if let [zone, kind, name, ..] = &words[..]
                    && let Ok(zone) = zone.parse()
                {
                    mesh.zones.insert(zone, (kind.clone(), name.clone()));
                }
            }
            s.skip()
        }
        "2010" | "2012" | "2013" | "3010" | "3012" | "3013" => {
            let d = s.fault(at, format!("binary sections ({number}) are not supported"));
            Err(d.help("save the mesh as text (ASCII)"))
        }
        "59" | "58" => {
            let d = s.fault(at, "meshes refined with hanging nodes are not supported");
            Err(d.help("save the mesh without adaption"))
        }
        _ => s.skip(),
    }
}

/// The hexadecimal numbers of a section's header, whose `(` is read.
fn header(s: &mut Scan<'_>) -> Result<Vec<u32>, Diag> {
    let words = s.words()?;
    Ok(words.iter().filter_map(|w| u32::from_str_radix(w, 16).ok()).collect())
}

fn points(s: &mut Scan<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let at = s.at;
    if !s.opens() {
        return s.skip();
    }
    let head = header(s)?;
    let [zone, first, last, ..] = head[..] else {
        return Err(s.fault(at, "points need a zone, the first and the last point"));
    };
    if zone == 0 || !s.opens() {
        return s.skip();
    }
    let dimension = head.get(4).map_or(mesh.dimension, |&d| d as usize);
    if first == 0 || last < first || last as usize > s.src.text.len() || dimension > 3 {
        return Err(s.fault(at, "the range of points makes no sense"));
    }
    if mesh.points.len() < last as usize {
        mesh.points.resize(last as usize, [0.0; 3]);
    }
    for p in first..=last {
        for k in 0..dimension {
            mesh.points[p as usize - 1][k] = s.double()?;
        }
    }
    s.closes()?;
    s.closes()
}

fn faces(s: &mut Scan<'_>, mesh: &mut Mesh, at: usize) -> Result<(), Diag> {
    if !s.opens() {
        return s.skip();
    }
    let head = header(s)?;
    let [zone, first, last, ..] = head[..] else {
        return Err(s.fault(at, "faces need a zone, the first and the last face"));
    };
    if zone == 0 || !s.opens() {
        return s.skip();
    }
    let kind = head.get(4).copied().unwrap_or(0);
    for _ in first..=last {
        let n = match kind {
            0 | 5 => s.hex("the number of points of a face")?,
            n => n,
        };
        let here = s.at;
        if !(2..1000).contains(&n) {
            return Err(s.fault(here, format!("a face of {n} points")));
        }
        let start = mesh.face_points.len();
        for _ in 0..n {
            let p = s.hex("a point")?;
            mesh.face_points.push(p.checked_sub(1).ok_or_else(|| s.fault(here, "point 0"))?);
        }
        let cells = [s.hex("a cell")?, s.hex("a cell")?];
        mesh.faces.push(Face { points: start..mesh.face_points.len(), cells, zone });
    }
    s.closes()?;
    s.closes()
}

/// What a zone's type makes of a patch.
fn patch_kind(kind: &str) -> PatchKind {
    match kind {
        "wall" => PatchKind::Wall,
        "symmetry" => PatchKind::Symmetry,
        _ => PatchKind::Patch,
    }
}

impl Mesh {
    fn elements(self) -> Result<Elements, String> {
        let mut out = Elements { points: self.points, ..Elements::default() };
        // What users of Fluent's meshes in OpenFOAM cases know it as.
        out.front_and_back = Some("frontAndBackPlanes");
        let n_cells = self.faces.iter().flat_map(|f| f.cells).max().unwrap_or(0) as usize;
        if n_cells > 2 * self.faces.len() {
            return Err(format!("{n_cells} cells cannot be closed by {} faces", self.faces.len()));
        }
        let flat = self.dimension == 2;
        let mut of_cell: Vec<Vec<Vec<u32>>> = vec![Vec::new(); n_cells];
        for face in &self.faces {
            let ring = &self.face_points[face.points.clone()];
            // Seen from the first cell the points turn counter-clockwise: the face's normal enters it.
            for (side, &c) in face.cells.iter().enumerate().filter(|c| *c.1 > 0) {
                let mut ring = ring.to_vec();
                if side == 0 {
                    ring.reverse();
                }
                of_cell[c as usize - 1].push(ring);
            }
            if face.cells.contains(&0) {
                let unknown = (String::new(), format!("zone{}", face.zone));
                let (kind, name) = self.zones.get(&face.zone).unwrap_or(&unknown);
                let group = out.group(if flat { 1 } else { 2 }, name, Some(patch_kind(kind)));
                let list = if flat { &mut out.lines } else { &mut out.surfaces };
                list.push(ring, group);
            }
        }
        for (c, faces) in of_cell.into_iter().enumerate() {
            let number = c as u32 + 1;
            let zone = self.cells.iter().find(|(_, [a, b])| (*a..=*b).contains(&number));
            let group = match zone.and_then(|z| self.zones.get(&z.0)) {
                Some((_, name)) => out.group(if flat { 2 } else { 3 }, name, None),
                None => NONE,
            };
            if flat {
                let ring =
                    chain(&faces).ok_or(format!("the sides of cell {number} do not close"))?;
                out.surfaces.push(&ring, group);
            } else {
                out.volumes.push(faces.iter().map(Vec::as_slice), group);
            }
        }
        Ok(out)
    }
}

/// The ring of points that lines make, each running on from the end of another.
fn chain(lines: &[Vec<u32>]) -> Option<Vec<u32>> {
    let mut ring = vec![lines.first()?[0]];
    let mut end = lines[0][1];
    while end != ring[0] {
        ring.push(end);
        end = lines.iter().find(|l| l[0] == end)?[1];
        if ring.len() > lines.len() {
            return None;
        }
    }
    (ring.len() == lines.len()).then_some(ring)
}
