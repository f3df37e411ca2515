//! Surfaces in a mesh on which fields are sampled: planes, patches, surfaces of equal value or of equal
//! distance from a shape.
//!
//! They live on the first rank, which has the whole mesh, so that they do not depend on how many
//! ranks there are.

use super::field::Components;
use super::patches::Patches;
use super::quantity::Wanted;
use super::whole::Everywhere;
use super::{Rank, Reading, View};
use crate::CaseConfig;
use crate::section::{self, Grid, with_centres};
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::{Reader, Sink};
use granflow_mesh::Mesh;
use std::collections::HashMap;

/// What is cut out of the mesh.
#[derive(Clone)]
enum Kind {
    Plane {
        point: Vec3,
        normal: Vec3,
    },
    Patch {
        patches: Patches,
        /// Values of the cells behind the patch, rather than those on it.
        inside: bool,
    },
    Iso {
        field: Wanted,
        level: f64,
    },
    Distance {
        shape: Shape,
        level: f64,
        /// Whether one side counts as negative.
        signed: bool,
    },
}

/// What distances are measured from.
#[derive(Clone, Copy)]
enum Shape {
    /// Positive where the unit normal points to.
    Plane { point: Vec3, normal: Vec3 },
    /// Positive outside.
    Sphere { centre: Vec3, radius: f64 },
}

impl Shape {
    /// Reads `surfaceType` and what belongs to it.
    fn read(r: &Reader<'_>) -> Shape {
        let kinds = [
            ("searchablePlane", true),
            ("plane", true),
            ("searchableSphere", false),
            ("sphere", false),
        ];
        r.ignore("surfaceName");
        let word = r.maybe_word("surfaceType");
        if let Some(word) = word.filter(|w| kinds.iter().all(|k| k.0 != *w) && w.contains("Surf")) {
            let message = format!("`{word}`: surfaces of triangles are not read");
            let help = "distances are measured from a `searchablePlane` or a `searchableSphere`";
            r.error_at_key("surfaceType", message, "refused", Some(help));
            r.ignore_all();
            return Shape::Plane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] };
        }
        if r.one_of("surfaceType", &kinds) {
            let (point, normal) = point_and_normal(r);
            return Shape::Plane { point, normal };
        }
        let key = if r.has("origin") { "origin" } else { "centre" };
        Shape::Sphere {
            centre: r.vector(key, Dims::LENGTH),
            radius: r.positive("radius", Dims::LENGTH),
        }
    }
    fn distance(self, x: Vec3) -> f64 {
        match self {
            Shape::Plane { point, normal } => dot(sub(x, point), normal),
            Shape::Sphere { centre, radius } => norm(sub(x, centre)) - radius,
        }
    }
}

/// A point of a plane and its unit normal.
fn point_and_normal(r: &Reader<'_>) -> (Vec3, Vec3) {
    r.opt_one_of("planeType", &[("pointAndNormal", ())], ());
    let own = r.opt_sub("pointAndNormalDict");
    let at = own.as_ref().unwrap_or(r);
    let either = |old: &'static str, new: &'static str| {
        at.vector(if at.has(old) { old } else { new }, Dims::LENGTH)
    };
    let (point, normal) = (either("basePoint", "point"), either("normalVector", "normal"));
    if normal == [0.0; 3] {
        let key = if at.has("normal") { "normal" } else { "normalVector" };
        at.error_at_key(key, "the normal of a plane is null", "no direction", None);
    }
    (point, unit(normal))
}

/// A surface as a dictionary describes it.
#[derive(Clone)]
pub(super) struct CutPlan {
    pub(super) name: String,
    kind: Kind,
    /// Whether values belong to points, rather than to faces.
    pub(super) interpolate: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Word {
    Plane,
    Patch,
    Inside,
    Iso,
    Distance,
}

const KINDS: &[(&str, Word)] = &[
    ("cuttingPlane", Word::Plane),
    ("plane", Word::Plane),
    ("patch", Word::Patch),
    ("patchInternalField", Word::Inside),
    ("isoSurface", Word::Iso),
    ("isoSurfaceCell", Word::Iso),
    ("isoSurfaceTopo", Word::Iso),
    ("isoSurfacePoint", Word::Iso),
    ("distanceSurface", Word::Distance),
];

/// Kinds of OpenFOAM's that are refused by name.
const REFUSED: &[&str] = &[
    "faceZone",
    "faceZones",
    "meshedSurface",
    "sampledTriSurfaceMesh",
    "thresholdCellFaces",
    "triSurfaceMesh",
];

impl CutPlan {
    /// Reads a surface called `name`; mistakes go to the sink.
    pub(super) fn read(r: &Reader<'_>, name: &str, reading: &Reading<'_>) -> CutPlan {
        for key in [
            "triangulate",
            "regularise",
            "mergeTol",
            "zone",
            "zones",
            "bounds",
            "average",
            "enabled",
        ] {
            r.ignore(key);
        }
        let interpolate = r.opt_switch("interpolate", false);
        if let Some(word) = r.maybe_word("type").filter(|w| REFUSED.contains(w)) {
            let known: Vec<&str> = KINDS.iter().map(|k| k.0).collect();
            let help = format!("one of {}", known.join(", "));
            let message = format!("surfaces of type `{word}` are not supported");
            r.error_at_key("type", message, "refused", Some(&help));
            r.ignore_all();
            let patches = Patches::or_walls(r, "");
            let kind = Kind::Patch { patches, inside: false };
            return CutPlan { name: name.into(), kind, interpolate };
        }
        let kind = match r.one_of("type", KINDS) {
            Word::Plane => {
                let (point, normal) = point_and_normal(r);
                Kind::Plane { point, normal }
            }
            word @ (Word::Patch | Word::Inside) => {
                r.ignore("offsetMode");
                r.ignore("distance");
                let inside = word == Word::Inside;
                Kind::Patch { patches: Patches::read(r, "patches"), inside }
            }
            Word::Iso => {
                let field = Wanted::one(r, "isoField", reading);
                if field.list[0].quantity.rank() != Rank::Scalar {
                    let message = format!("`{}` is no scalar", field.list[0].name);
                    let help = "the function `mag` makes one of a vector";
                    r.error_at_key("isoField", message, "a scalar is needed", Some(help));
                }
                Kind::Iso { field, level: r.scalar("isoValue", Dims::NONE) }
            }
            Word::Distance => {
                // How OpenFOAM makes triangles of it.
                ["cell", "regularise", "isoAlgorithm", "topology"].iter().for_each(|k| r.ignore(k));
                let shape = Shape::read(r);
                let level = r.scalar("distance", Dims::LENGTH);
                // Without distance both sides are one.
                let signed = r.opt_switch("signed", true) || level == 0.0;
                if !signed && level < 0.0 {
                    let help = Some("write `signed true;`, or a positive distance");
                    r.error_at_key("distance", "no place is nearer than nothing", "negative", help);
                }
                Kind::Distance { shape, level, signed }
            }
        };
        CutPlan { name: name.into(), kind, interpolate }
    }

    /// Complains about what the mesh and the case do not have.
    pub(super) fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        match &self.kind {
            Kind::Patch { patches, .. } => patches.check(mesh, sink),
            Kind::Iso { field, .. } => field.check(config, sink),
            Kind::Plane { .. } | Kind::Distance { .. } => {}
        }
    }
    /// The functions whose fields it looks at.
    pub(super) fn uses(&self) -> Vec<usize> {
        if let Kind::Iso { field, .. } = &self.kind { field.uses() } else { Vec::new() }
    }
    /// Whether it looks at what must be computed.
    pub(super) fn derived(&self) -> bool {
        if let Kind::Iso { field, .. } = &self.kind { field.derived() } else { false }
    }

    /// Brings the surface up to date, on the first rank. Every rank calls it.
    pub(super) fn update(&self, view: &View<'_>, cut: &mut Option<Cut>) {
        if let Kind::Iso { field, level } = &self.kind {
            let Some(all) = view.everywhere(field.list[0].quantity) else { return };
            let nodes = with_centres(view.grid(), &all.at_points(view.grid())[0]);
            *cut = Some(Cut::iso(view.grid(), &nodes, *level));
            return;
        }
        if cut.is_some() || view.exec.rank() != 0 {
            return;
        }
        let grid = view.grid();
        *cut = Some(match &self.kind {
            Kind::Plane { point, normal } => Cut::plane(grid, *point, *normal),
            Kind::Patch { patches, inside } => {
                Cut::patches(grid, &patches.indices(&view.whole.case.mesh), *inside)
            }
            Kind::Distance { shape, level, signed } => {
                let along = |k: usize| {
                    let all: Vec<f64> = grid.poly.points.iter().map(|p| p[k]).collect();
                    with_centres(grid, &all)
                };
                let [x, y, z] = [0, 1, 2].map(along);
                let far = |i: usize| shape.distance([x[i], y[i], z[i]]);
                let far = (0..x.len()).map(|i| if *signed { far(i) } else { far(i).abs() });
                Cut::iso(grid, &far.collect::<Vec<f64>>(), *level)
            }
            Kind::Iso { .. } => return,
        });
    }
}

/// A point of a surface: at `t` of the way from one node to another. Nodes are the mesh's points,
/// then the middles of its faces, then those of its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    from: usize,
    to: usize,
    t: f64,
}

/// A surface in the mesh.
#[derive(Default)]
pub(super) struct Cut {
    corners: Vec<Corner>,
    /// Where the points are, m.
    pub(super) points: Vec<Vec3>,
    /// Points of each face of the surface.
    pub(super) faces: Vec<Vec<u32>>,
    /// Of each face the sample that it has its value from: a cell, or a boundary face.
    samples: Vec<usize>,
}

impl Cut {
    /// Numbers the corners, each once, and places them.
    fn new(grid: &Grid, faces: Vec<(usize, Vec<Corner>)>) -> Cut {
        let mut out = Cut::default();
        let mut seen: HashMap<(usize, usize), u32> = HashMap::new();
        for (sample, corners) in faces {
            let mut face = Vec::with_capacity(corners.len());
            for c in corners {
                let next = out.corners.len() as u32;
                let i = *seen.entry((c.from, c.to)).or_insert(next);
                if i == next {
                    out.corners.push(c);
                }
                face.push(i);
            }
            out.faces.push(face);
            out.samples.push(sample);
        }
        let along = |k: usize| {
            let all: Vec<f64> = grid.poly.points.iter().map(|p| p[k]).collect();
            out.between(&with_centres(grid, &all))
        };
        let [x, y, z] = [0, 1, 2].map(along);
        out.points = (0..x.len()).map(|i| [x[i], y[i], z[i]]).collect();
        out
    }

    fn plane(grid: &Grid, point: Vec3, normal: Vec3) -> Cut {
        let polygons = section::cut(grid, point, normal).into_iter().map(|p| {
            let corner =
                |c: &section::OnEdge| Corner { from: c.0 as usize, to: c.1 as usize, t: c.2 };
            (p.cell, p.corners.iter().map(corner).collect())
        });
        let mut out = Cut::new(grid, polygons.collect());
        let areas = out.areas();
        for (face, area) in out.faces.iter_mut().zip(areas) {
            if dot(area, normal) < 0.0 {
                face.reverse();
            }
        }
        out
    }

    fn patches(grid: &Grid, patches: &[usize], inside: bool) -> Cut {
        let poly = &grid.poly;
        let faces = patches.iter().flat_map(|p| poly.patches[*p].faces()).map(|f| {
            let on = |p: &u32| Corner { from: *p as usize, to: *p as usize, t: 0.0 };
            let sample = match inside {
                true => poly.owner[f] as usize,
                false => poly.n_cells() + f - poly.n_inner(),
            };
            (sample, poly.face(f).iter().map(on).collect())
        });
        Cut::new(grid, faces.collect())
    }

    /// Of values at the nodes.
    fn iso(grid: &Grid, nodes: &[f64], level: f64) -> Cut {
        let faces = section::iso_triangles(grid, nodes, level).into_iter().map(|(cell, t)| {
            let corner = |(i, j): (usize, usize)| {
                let (a, b) = (nodes[i] - level, nodes[j] - level);
                match a == 0.0 {
                    true => Corner { from: i, to: i, t: 0.0 },
                    false => Corner { from: i, to: j, t: a / (a - b) },
                }
            };
            (cell, t.map(corner).to_vec())
        });
        Cut::new(grid, faces.collect())
    }

    /// Values at the nodes to values at the corners.
    fn between(&self, nodes: &[f64]) -> Vec<f64> {
        let at = |c: &Corner| nodes[c.from] + c.t * (nodes[c.to] - nodes[c.from]);
        self.corners.iter().map(at).collect()
    }

    /// Area vectors of the faces, m2.
    pub(super) fn areas(&self) -> Vec<Vec3> {
        let area = |face: &Vec<u32>| {
            let at = |i: usize| self.points[face[i] as usize];
            let twice = |i: usize| cross(sub(at(i - 1), at(0)), sub(at(i), at(0)));
            scale((2..face.len()).map(twice).fold([0.0; 3], add), 0.5)
        };
        self.faces.iter().map(area).collect()
    }
    /// Middles of the faces, m.
    pub(super) fn middles(&self) -> Vec<Vec3> {
        let middle = |face: &Vec<u32>| {
            let sum = face.iter().map(|i| self.points[*i as usize]).fold([0.0; 3], add);
            scale(sum, 1.0 / face.len() as f64)
        };
        self.faces.iter().map(middle).collect()
    }

    /// The values of a field on the faces: those of cells, or those on the patch.
    pub(super) fn on_faces(&self, grid: &Grid, field: &Everywhere) -> Vec<Components> {
        let (known, poly) = (field.known(grid), &grid.poly);
        let of = |s: &usize| match known[*s] {
            true => field.at(*s),
            false => field.at(poly.owner[*s - poly.n_cells() + poly.n_inner()] as usize),
        };
        self.samples.iter().map(of).collect()
    }
    /// The values of a field at the points.
    pub(super) fn on_points(&self, grid: &Grid, field: &Everywhere) -> Vec<Components> {
        let mut out = vec![[0.0; 9]; self.points.len()];
        for (k, points) in field.at_points(grid).iter().enumerate() {
            let values = self.between(&with_centres(grid, points));
            out.iter_mut().zip(values).for_each(|(v, x)| v[k] = x);
        }
        out
    }
}
