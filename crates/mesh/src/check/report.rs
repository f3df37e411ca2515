//! What a mesh check found.

use super::NO_CELLS;
use crate::geometry::Geometry;
use crate::polymesh::{place, short};
use granflow_base::Vec3;
use std::fmt;

/// The outcome of [`check`](super::check).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CheckReport {
    /// Number of points.
    pub points: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of inner faces.
    pub inner_faces: usize,
    /// Number of cells.
    pub cells: usize,
    /// Cells by shape.
    pub shapes: CellShapes,
    /// Smallest and largest coordinates, m.
    pub bounds: [Vec3; 2],
    /// The patches.
    pub patches: Vec<PatchSummary>,
    /// Numbers that tell how good the mesh is.
    pub quality: Quality,
    /// What was found, worst first within each group.
    pub findings: Vec<Finding>,
}

/// Cells counted by shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellShapes {
    /// Six quadrilaterals.
    pub hexahedra: usize,
    /// Two triangles, three quadrilaterals.
    pub prisms: usize,
    /// Four triangles, one quadrilateral.
    pub pyramids: usize,
    /// Four triangles.
    pub tetrahedra: usize,
    /// Everything else.
    pub polyhedra: usize,
}

/// One patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSummary {
    /// Name.
    pub name: String,
    /// Type as a `boundary` file writes it.
    pub kind: &'static str,
    /// Number of faces.
    pub faces: usize,
    /// Total area, m2.
    pub area: f64,
}

/// Quality of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// Smallest and largest cell volume, m3.
    pub volume: [f64; 2],
    /// Sum of the cell volumes, m3.
    pub total_volume: f64,
    /// Smallest and largest face area, m2.
    pub area: [f64; 2],
    /// Greatest angle between a face normal and the line of cell centres, degrees.
    pub max_nonorth_deg: f64,
    /// Angle of the mean cosine over the inner faces, degrees.
    pub mean_nonorth_deg: f64,
    /// Greatest distance of a face centre from the line of cell centres, relative to the size of
    /// the face.
    pub max_skewness: f64,
    /// Greatest ratio of a cell's extents.
    pub max_aspect: f64,
    /// Greatest ratio of the volumes of neighbours.
    pub max_volume_ratio: f64,
    /// Greatest sum of a cell's area vectors, relative to its surface; 0 when closed.
    pub max_openness: f64,
    /// Size of the sum of the boundary's area vectors, relative to its surface; 0 when closed.
    pub boundary_openness: f64,
    /// Shortest and longest edge, m.
    pub edge: [f64; 2],
    /// Least and mean area of a face over that of its triangles; 1 where it is plane.
    pub flatness: [f64; 2],
    /// Least and mean determinant of the faces between a cell and others; 1 of a cube among cubes, in
    /// two dimensions 0.5 of a square among squares.
    pub determinant: [f64; 2],
    /// Least and mean share of the nearer centre in the distance of two centres across their face.
    pub weight: [f64; 2],
    /// Least and mean ratio of the volumes of neighbours, the smaller over the larger.
    pub volume_ratio: [f64; 2],
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Good to know.
    Note,
    /// The run works but its accuracy or convergence suffers.
    Warning,
    /// The mesh cannot be used.
    Error,
}

/// One kind of fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// A word for it.
    pub name: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong.
    pub message: String,
    /// How many cells, faces or points have it; 0 when it concerns the whole mesh.
    pub count: usize,
    /// The worst of them.
    pub places: Vec<Place>,
    /// All cells that have it, ascending; of a face, those on its sides.
    pub cells: Vec<u32>,
    /// What to do about it.
    pub remedy: String,
}

/// Where a fault is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// `cell`, `face` or `point`.
    pub what: &'static str,
    /// Its number.
    pub index: usize,
    /// Where it is, m.
    pub at: Vec3,
    /// How bad it is there, in the units of the finding.
    pub value: f64,
    /// Of a face, the cells on its sides: the owner and, inside the mesh, the neighbour.
    pub cells: (Option<u32>, Option<u32>),
}

impl Place {
    /// Cell `c`.
    pub(super) fn cell(g: &Geometry, c: usize, value: f64) -> Place {
        Place { what: "cell", index: c, at: g.cell_centre[c], value, cells: NO_CELLS }
    }
    /// Face `f`.
    pub(super) fn face(g: &Geometry, f: usize, value: f64) -> Place {
        Place { what: "face", index: f, at: g.face_centre[f], value, cells: NO_CELLS }
    }
}

impl Finding {
    pub(super) fn whole(severity: Severity, message: String, remedy: &str) -> Finding {
        Finding {
            name: "mesh",
            severity,
            message,
            count: 0,
            places: Vec::new(),
            cells: Vec::new(),
            remedy: remedy.into(),
        }
    }
}

impl CheckReport {
    /// Cells that a warning or an error names, ascending.
    pub fn bad_cells(&self) -> Vec<u32> {
        let bad = self.findings.iter().filter(|f| f.severity >= Severity::Warning);
        let mut cells: Vec<u32> = bad.flat_map(|f| f.cells.iter().copied()).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
    /// Whether the mesh can be used: no finding is an error.
    pub fn ok(&self) -> bool {
        self.findings.iter().all(|f| f.severity < Severity::Error)
    }
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.cells > 0 {
            self.numbers(f)?;
        }
        for finding in &self.findings {
            writeln!(f, "{finding}")?;
        }
        let [e, w] = [Severity::Error, Severity::Warning]
            .map(|s| self.findings.iter().filter(|x| x.severity == s).count());
        match (e, w) {
            (0, 0) => write!(f, "mesh ok"),
            (0, w) => write!(f, "mesh usable, {w} warning{}", if w == 1 { "" } else { "s" }),
            (e, _) => write!(f, "mesh unusable, {e} error{}", if e == 1 { "" } else { "s" }),
        }
    }
}

impl CheckReport {
    fn numbers(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = &self.shapes;
        let shapes: Vec<String> = [
            (s.hexahedra, "hexahedra"),
            (s.prisms, "prisms"),
            (s.pyramids, "pyramids"),
            (s.tetrahedra, "tetrahedra"),
            (s.polyhedra, "polyhedra"),
        ]
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, name)| format!("{n} {name}"))
        .collect();
        writeln!(f, "cells              {} ({})", self.cells, shapes.join(", "))?;
        writeln!(f, "faces              {} ({} inner)", self.faces, self.inner_faces)?;
        writeln!(f, "points             {}", self.points)?;
        let [lo, hi] = self.bounds;
        writeln!(f, "extent             {} to {} m", place(lo), place(hi))?;
        let q = &self.quality;
        let range = |[a, b]: [f64; 2]| format!("{} to {}", short(a), short(b));
        let total = short(q.total_volume);
        writeln!(f, "cell volume        {} m3, together {total} m3", range(q.volume))?;
        writeln!(f, "face area          {} m2", range(q.area))?;
        let (max, mean) = (q.max_nonorth_deg, q.mean_nonorth_deg);
        writeln!(f, "non-orthogonality  at most {max:.1}, mean {mean:.1} degrees")?;
        writeln!(f, "skewness           at most {:.2}", q.max_skewness)?;
        writeln!(f, "aspect ratio       at most {:.1}", q.max_aspect)?;
        let spread =
            |[least, mean]: [f64; 2]| format!("at least {}, mean {}", short(least), short(mean));
        writeln!(f, "volume ratio       at most {:.2} between neighbours", q.max_volume_ratio)?;
        writeln!(f, "                   smaller over larger {}", spread(q.volume_ratio))?;
        writeln!(f, "face weight        {}", spread(q.weight))?;
        writeln!(f, "edge length        {} m", range(q.edge))?;
        writeln!(f, "flatness           {}", spread(q.flatness))?;
        writeln!(f, "determinant        {}", spread(q.determinant))?;
        for p in &self.patches {
            let (name, kind, n, area) = (&p.name, p.kind, p.faces, short(p.area));
            writeln!(f, "patch              {name} ({kind}): {n} faces, {area} m2")?;
        }
        Ok(())
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{word}: {}", self.message)?;
        for p in &self.places {
            write!(f, "\n  {} {}", p.what, p.index)?;
            match p.cells {
                (Some(a), Some(b)) => write!(f, " between cells {a} and {b}")?,
                (Some(a), None) => write!(f, " of cell {a}")?,
                _ => {}
            }
            write!(f, " at {}: {}", place(p.at), short(p.value))?;
        }
        if self.count > self.places.len() {
            write!(f, "\n  and {} more", self.count - self.places.len())?;
        }
        write!(f, "\n  help: {}", self.remedy)
    }
}
