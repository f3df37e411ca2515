//! Lines through a mesh and other sets of points: where they are and which cells hold them.

use super::Around;
use super::locate::{Locator, clip};
use super::patches::Patches;
use super::point_sets::{self, InCell, Wanted};
use granflow_base::{Vec3, add, norm, scale, sub};
use granflow_dict::{Reader, Sink, Span};
use granflow_mesh::Mesh;

/// Kinds of set in OpenFOAM that are refused by name, with the reason.
const REFUSED: &[(&str, &str)] = &[
    ("patchEdge", "it needs a surface of triangles, which are not read"),
    ("triSurfaceMeshPointSet", "it needs a surface of triangles, which are not read"),
    ("shortestPath", "paths from cell to cell are not looked for"),
];

/// How the points of a line are chosen.
#[derive(Clone, Debug)]
pub(super) enum Points {
    /// So many at equal distances.
    Uniform(usize),
    /// Where the line crosses faces.
    Faces,
    /// Half way between crossings: one in each cell.
    Middles,
    /// Both.
    FacesAndMiddles,
    /// Given one by one.
    Given(Vec<Vec3>),
    /// Looked for in the mesh, and then
    Wanted(Wanted),
    /// found in these cells.
    Found(Vec<InCell>),
}

/// What the first column of a table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// Distance from the start.
    Distance,
    /// One coordinate.
    Coordinate(usize),
    /// All three.
    Xyz,
}

/// A line, or another set of points.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) name: String,
    pub(super) points: Points,
    pub(super) axis: Axis,
    pub(super) start: Vec3,
    pub(super) end: Vec3,
    /// What points given one by one are apart along the axis `distance`.
    spacing: f64,
}

/// A point of a line in a cell of this rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Order along the line.
    pub(super) t: f64,
    pub(super) x: Vec3,
    pub(super) cell: usize,
}

impl Line {
    /// Reads a line; `kind` is the key that holds its type.
    pub(super) fn read(r: &Reader<'_>, name: &str, kind: Option<&str>) -> Line {
        #[derive(Clone, Copy, PartialEq, PartialOrd)]
        enum Kind {
            Uniform,
            Faces,
            Middles,
            Both,
            Given,
            Lattice,
            Circle,
            Centres,
            Nearest,
            Seeds,
        }
        let kinds = [
            ("uniform", Kind::Uniform),
            ("lineUniform", Kind::Uniform),
            ("face", Kind::Faces),
            ("lineFace", Kind::Faces),
            ("midPoint", Kind::Middles),
            ("lineCell", Kind::Middles),
            ("midPointAndFace", Kind::Both),
            ("lineCellFace", Kind::Both),
            ("cloud", Kind::Given),
            ("points", Kind::Given),
            ("polyLine", Kind::Given),
            ("array", Kind::Lattice),
            ("circle", Kind::Circle),
            ("cellCentre", Kind::Centres),
            ("patchCloud", Kind::Nearest),
            ("patchSeed", Kind::Seeds),
        ];
        let word = kind.and_then(|key| r.maybe_word(key));
        if let Some((word, why)) = word.and_then(|w| REFUSED.iter().find(|e| e.0 == w)) {
            let known: Vec<&str> = kinds.iter().map(|k| k.0).collect();
            let message = format!("sets of type `{word}` are not supported: {why}");
            let help = format!("one of {}", known.join(", "));
            r.error_at_key("type", message, "refused", Some(&help));
            r.ignore_all();
            return Line::idle(name);
        }
        let kind = match kind {
            Some(key) => r.one_of(key, &kinds),
            None if r.has("nPoints") => Kind::Uniform,
            None => Kind::Middles,
        };
        let axis = r.opt_one_of(
            "axis",
            &[
                ("distance", Axis::Distance),
                ("x", Axis::Coordinate(0)),
                ("y", Axis::Coordinate(1)),
                ("z", Axis::Coordinate(2)),
                ("xyz", Axis::Xyz),
            ],
            if kind >= Kind::Given { Axis::Xyz } else { Axis::Distance },
        );
        r.ignore("ordered");
        if kind != Kind::Uniform {
            r.ignore("nPoints");
        }
        let mut line = Line { axis, ..Line::idle(name) };
        if kind == Kind::Given {
            line.points = Points::Given(r.vectors("points"));
            return line;
        }
        if kind > Kind::Given {
            match kind {
                Kind::Lattice => line.points = Points::Given(point_sets::lattice(r)),
                Kind::Circle => {
                    let (points, arc) = point_sets::circle(r);
                    (line.points, line.spacing) = (Points::Given(points), arc);
                }
                _ => {
                    line.points =
                        Points::Wanted(wanted(r, kind == Kind::Centres, kind == Kind::Nearest))
                }
            }
            return line;
        }
        line.start = r.vector("start", granflow_base::Dims::LENGTH);
        line.end = r.vector("end", granflow_base::Dims::LENGTH);
        if line.start == line.end {
            r.error_at_key("end", "the line ends where it starts", "same as `start`", None);
        }
        line.points = match kind {
            Kind::Uniform => {
                Points::Uniform(r.label_in("nPoints", 2..=i64::from(i32::MAX)) as usize)
            }
            Kind::Faces => Points::Faces,
            Kind::Both => Points::FacesAndMiddles,
            _ => Points::Middles,
        };
        line
    }

    pub(super) fn idle(name: &str) -> Line {
        Line {
            name: name.into(),
            points: Points::Middles,
            axis: Axis::Distance,
            start: [0.0; 3],
            end: [0.0; 3],
            spacing: 1.0,
        }
    }

    /// Finds the points that are looked for in the mesh.
    pub(super) fn place(&mut self, around: &Around<'_>, span: &Span, sink: &Sink) {
        if let Points::Wanted(wanted) = &self.points {
            self.points = Points::Found(wanted.find(around, &self.name, span, sink));
        }
    }

    /// The points that lie in cells of `mesh`, in order.
    pub(super) fn places(&self, mesh: &Mesh) -> Vec<Place> {
        let d = sub(self.end, self.start);
        let on = |t: f64| add(self.start, scale(d, t));
        match &self.points {
            Points::Uniform(n) => {
                let ts = (0..*n).map(|i| i as f64 / (*n - 1) as f64);
                held(mesh, ts.map(|t| (t, on(t))))
            }
            Points::Given(points) => {
                held(mesh, points.iter().enumerate().map(|(i, x)| (i as f64, *x)))
            }
            Points::Wanted(_) => Vec::new(),
            Points::Found(found) => {
                let mut own: Vec<(u32, usize)> =
                    mesh.global_cell.iter().enumerate().map(|(c, user)| (*user, c)).collect();
                own.sort_unstable();
                let cell = |user: u32| {
                    let i = own.binary_search_by_key(&user, |o| o.0).ok()?;
                    Some(own[i].1).filter(|c| *c < mesh.n_cells)
                };
                let place =
                    |(t, x, user): &InCell| Some(Place { t: *t, x: *x, cell: cell(*user)? });
                found.iter().filter_map(place).collect()
            }
            Points::Faces | Points::Middles | Points::FacesAndMiddles => {
                let (faces, middles) = match self.points {
                    Points::Faces => (true, false),
                    Points::Middles => (false, true),
                    _ => (true, true),
                };
                let mut out = Vec::new();
                for cell in 0..mesh.n_cells {
                    let Some((t0, t1)) = clip(mesh, cell, self.start, d) else { continue };
                    let mut put = |t: f64| out.push(Place { t, x: on(t), cell });
                    if faces {
                        put(t0);
                        put(t1);
                    }
                    if middles {
                        put(0.5 * (t0 + t1));
                    }
                }
                out.sort_by(|a, b| a.t.total_cmp(&b.t));
                out
            }
        }
    }

    /// Parameters nearer than this belong to one point.
    pub(super) fn grain(&self) -> f64 {
        match self.points {
            Points::Given(_) | Points::Found(_) => 0.5,
            _ => 1e-9,
        }
    }

    /// The axis' word.
    pub(super) fn axis_word(&self) -> &'static str {
        match self.axis {
            Axis::Distance => "distance",
            Axis::Coordinate(k) => ["x", "y", "z"][k],
            Axis::Xyz => "xyz",
        }
    }
    /// Heads of the axis' columns.
    pub(super) fn heads(&self) -> Vec<&'static str> {
        match self.axis {
            Axis::Distance => vec!["distance"],
            Axis::Coordinate(k) => vec![["x", "y", "z"][k]],
            Axis::Xyz => vec!["x", "y", "z"],
        }
    }

    /// The axis' columns at `x`, which is at `t` of the line.
    pub(super) fn along(&self, t: f64, x: Vec3) -> Vec<f64> {
        match self.axis {
            // Of points given one by one, as OpenFOAM does: their number.
            Axis::Distance if matches!(self.points, Points::Given(_) | Points::Found(_)) => {
                vec![self.spacing * t]
            }
            Axis::Distance => vec![norm(sub(x, self.start))],
            Axis::Coordinate(k) => vec![x[k]],
            Axis::Xyz => x.to_vec(),
        }
    }
}

/// What `cellCentre`, `patchCloud` or else `patchSeed` looks for.
fn wanted(r: &Reader<'_>, centres: bool, nearest: bool) -> Wanted {
    use granflow_base::Dims;
    if centres {
        let mut bounds = None;
        if let Some(mut t) = r.has("bounds").then(|| r.tokens("bounds")).flatten() {
            bounds = Some([t.vector("the lower corner"), t.vector("the upper corner")]);
            t.finish();
        }
        return Wanted::Centres(bounds);
    }
    let patches = Patches::read(r, "patches");
    if nearest {
        let (points, most) = (r.vectors("points"), r.positive("maxDistance", Dims::LENGTH));
        return Wanted::Nearest { patches, points, most };
    }
    Wanted::Seeds { patches, most: r.label_in("maxPoints", 1..=i64::from(i32::MAX)) as usize }
}

fn held(mesh: &Mesh, points: impl Iterator<Item = (f64, Vec3)>) -> Vec<Place> {
    let mut find = Locator::new(mesh);
    points.filter_map(|(t, x)| Some(Place { t, x, cell: find.find(x)? })).collect()
}
