//! Gmsh's `.msh` files of format 2 and 4, text and binary.
//!
//! Layout after the Gmsh reference manual, "MSH file format" and "Legacy formats" (C. Geuzaine and
//! J.-F. Remacle, gmsh.info).

mod kinds;
mod stream;
mod v2;
mod v4;

use super::elements::{Elements, NONE};
use super::{Importer, Options};
use granflow_base::Vec3;
use granflow_dict::{Diag, Source, Span};
use kinds::{Kind, kind};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use stream::Stream;

/// Gmsh's format.
pub(super) const IMPORTER: Importer =
    Importer { name: "Gmsh", claims: |b| b.trim_ascii_start().starts_with(b"$MeshFormat"), read };

/// What is gathered while a file is read.
#[derive(Default)]
struct Mesh {
    out: Elements,
    /// Where the file's number of a point is in `out.points`.
    labels: HashMap<u64, u32>,
    /// Names of physical groups by dimension and number.
    names: HashMap<(usize, i64), String>,
    /// Physical groups of entities by dimension and number (format 4).
    physical: HashMap<(usize, i64), Vec<i64>>,
    /// Elements there are already: an element of two groups is written twice by format 2.
    seen: HashSet<(usize, Vec<u32>)>,
    repeated: usize,
}

fn read(src: &Arc<Source>, _: &Options) -> Result<Elements, Vec<Diag>> {
    let mut s = Stream::new(src);
    let mut mesh = Mesh::default();
    sections(&mut s, &mut mesh).map_err(|d| vec![d])?;
    let mut out = mesh.out;
    if mesh.repeated > 0 {
        let n = mesh.repeated;
        out.notes.push(format!("{n} elements are in several groups: the first one counts"));
    }
    Ok(out)
}

fn sections(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let mut major = 0;
    let (mut nodes, mut elements) = (false, false);
    while let Some((name, at)) = s.section()? {
        match name.as_str() {
            "MeshFormat" => major = format(s, &at)?,
            _ if major == 0 => {
                return Err(Diag::error(&at, "`$MeshFormat` must come first"));
            }
            "PhysicalNames" => physical_names(s, mesh)?,
            "PartitionedEntities" => {
                let d = Diag::error(&at, "partitioned meshes are not supported");
                return Err(
                    d.help("save the mesh without partitions (Mesh.PartitionSplitMeshFiles 0)")
                );
            }
            "Entities" => v4::entities(s, mesh)?,
            "Nodes" => {
                nodes = true;
                if major == 2 { v2::nodes(s, mesh)? } else { v4::nodes(s, mesh)? }
            }
            "Elements" => {
                elements = true;
                if major == 2 { v2::elements(s, mesh)? } else { v4::elements(s, mesh)? }
            }
            _ => {
                s.skip_to_end_of(&name, &at)?;
                continue;
            }
        }
        s.end_of(&name)?;
    }
    for (there, what) in [(nodes, "$Nodes"), (elements, "$Elements")] {
        if !there {
            let d = Diag::error(&s.here(), format!("the file has no section `{what}`"));
            return Err(d.help("was it cut off? Save the mesh again"));
        }
    }
    Ok(())
}

/// `version file-type data-size`; returns the format's first number.
fn format(s: &mut Stream<'_>, at: &Span) -> Result<u32, Diag> {
    let (version, place) = s.word()?;
    let binary = s.text_number::<i64>("0 for text or 1 for binary")?;
    let size = s.text_number::<i64>("the size of a number, 8")?;
    if size != 8 {
        return Err(Diag::error(at, format!("numbers of {size} bytes are not supported")));
    }
    let major = match version.as_str() {
        v if v.starts_with("2") => 2,
        "4" | "4.0" => {
            s.version_40 = true;
            4
        }
        "4.1" => 4,
        _ => {
            let d = Diag::error(&place, format!("Gmsh's format {version} is not supported"));
            return Err(d.help("known are 2, 4.0 and 4.1: save the mesh with `-format msh41`"));
        }
    };
    s.set_binary(binary == 1)?;
    Ok(major)
}

fn physical_names(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let n = s.text_number::<u64>("the number of names")?;
    for _ in 0..n {
        let dimension = s.text_number::<usize>("a dimension")?;
        let number = s.text_number::<i64>("the number of a group")?;
        let name = s.quoted()?;
        mesh.names.insert((dimension, number), name);
    }
    Ok(())
}

impl Mesh {
    fn add_point(&mut self, label: u64, x: Vec3) {
        self.labels.insert(label, self.out.points.len() as u32);
        self.out.points.push(x);
    }

    /// Adds an element by the file's numbers of its points. `physical` is 0 for none.
    fn add_element(
        &mut self,
        kind: Kind,
        entity: i64,
        physical: i64,
        nodes: &[u64],
        at: &Span,
    ) -> Result<(), Diag> {
        let dimension = kind.dimension();
        let mut points = [0; 8];
        for (node, p) in nodes.iter().zip(&mut points) {
            *p = *self.labels.get(node).ok_or_else(|| {
                Diag::error(at, format!("an element uses node {node}, which is not in `$Nodes`"))
            })?;
        }
        let points = &points[..nodes.len()];
        if dimension == 0 {
            return Ok(());
        }
        let mut sorted = points.to_vec();
        sorted.sort_unstable();
        if !self.seen.insert((dimension, sorted)) {
            self.repeated += 1;
            return Ok(());
        }
        let group = self.group(dimension, entity, physical);
        match kind {
            Kind::Volume(shape) => self.out.volumes.push_shape(shape, points, group),
            Kind::Triangle | Kind::Quadrilateral => self.out.surfaces.push(points, group),
            Kind::Line => self.out.lines.push(points, group),
            Kind::Point => {}
        }
        Ok(())
    }

    /// The group of an element: its physical one by name or number, or else the entity of the
    /// geometry it lies on, where the file has no physical groups at all.
    fn group(&mut self, dimension: usize, entity: i64, physical: i64) -> u32 {
        let name = match (physical, self.names.get(&(dimension, physical))) {
            (0, _) if dimension == 3 || !self.names.is_empty() => return NONE,
            (0, _) => format!("{}{entity}", ["", "curve", "surface"][dimension]),
            (_, Some(name)) => name.clone(),
            (n, None) => format!("physical{n}"),
        };
        self.out.group(dimension, &name, None)
    }
}

/// The kind of element `number`, or why it is refused.
fn known_kind(number: i64, at: &Span) -> Result<Kind, Diag> {
    kind(number).map_err(|name| match name {
        Some(name) => {
            Diag::error(at, format!("elements of type {number} ({name}) are not supported"))
                .label("this element")
                .help("make a mesh of first order: `Mesh.ElementOrder = 1`, or `gmsh -order 1`")
        }
        None => Diag::error(at, format!("there is no element type {number}")).label("this element"),
    })
}
