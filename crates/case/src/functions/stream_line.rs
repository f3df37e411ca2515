//! Stream lines from seeds along a line, on the first rank.
//!
//! Velocity and fields are linear in the tetrahedra between the middles of cells and faces and the
//! points of the mesh, so that they are continuous and take the conditions on walls. A line takes
//! steps of the classical Runge-Kutta method of fourth order, some to a cell.

use super::field::{Components, components};
use super::locate::Locator;
use super::quantity::{Named, Quantity, Wanted};
use super::schedule::{Every, Schedule};
use super::set_format::{Row, SetFormat, vtk};
use super::track::{Line, Points};
use super::{Entry, Function, Plan, Reading, Remembered, View, Written};
use crate::CaseConfig;
use crate::export::poly_data;
use crate::section::{Grid, with_centres};
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub};
use granflow_dict::{Diag, Reader, Sink, Span, Token};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "streamLine",
    summary: "stream lines from seeds on a line with fields along them, as `.vtk` (or `.vtp`)",
    formula: "dx/ds = U(x)/|U(x)|, s the length along the line; Runge-Kutta steps of a share \
              of a cell",
    reference: "W. Kutta, Z. Math. Phys. 46 (1901) 435",
    read: |r, reading| Box::new(StreamLine::read(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

#[derive(Clone)]
struct StreamLine {
    name: String,
    fields: Wanted,
    /// The velocity that lines follow.
    along: Wanted,
    seeds: Line,
    seeds_span: Span,
    /// With the flow, against it.
    ways: [bool; 2],
    /// Most points of a line.
    life: usize,
    /// Steps in a cell.
    per_cell: f64,
    /// Length of a step in place of that, m.
    step: Option<f64>,
    /// Whether VTK's XML is written, rather than its legacy form.
    xml: bool,
}

impl StreamLine {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> StreamLine {
        for key in ["cloud", "cloudName", "interpolationScheme", "bounds", "lengthScale"] {
            r.ignore(key);
        }
        let ways = [
            ("forward", [true, false]),
            ("backward", [false, true]),
            ("bidirectional", [true, true]),
        ];
        let default = [true, false];
        let forward = r.opt_switch("trackForward", true);
        let ways = match r.has("direction") {
            true => r.opt_one_of("direction", &ways, default),
            false => [forward, !forward],
        };
        let span = r.value_span("seedSampleSet");
        // `seedSampleSet uniform;` with `uniformCoeffs { .. }` in older files.
        let old = r.raw("seedSampleSet").and_then(|t| t.first().and_then(Token::word));
        let seeds = match old {
            Some(word) => {
                r.ignore("seedSampleSet");
                r.sub(&format!("{word}Coeffs")).map(|sub| Line::of_kind(&sub, "seeds", word))
            }
            None => r.sub("seedSampleSet").map(|sub| Line::read(&sub, "seeds", Some("type"))),
        };
        let xml = r.maybe_word("setFormat") == Some("vtp");
        if xml {
            r.ignore("setFormat");
        } else if SetFormat::read(r, SetFormat::Vtk) != SetFormat::Vtk {
            let help = "write `setFormat vtk;`";
            r.error_at_key("setFormat", "stream lines are written as VTK", "refused", Some(help));
        }
        StreamLine {
            name: reading.name.into(),
            fields: Wanted::read(r, "fields", reading),
            along: Wanted::or_velocity(r, "U", reading),
            seeds: seeds.unwrap_or_else(|| Line::idle("seeds")),
            seeds_span: span,
            ways,
            life: r.opt_label_in("lifeTime", 2..=i64::from(u32::MAX), 10_000) as usize,
            per_cell: r.opt_label_in("nSubCycle", 1..=1000, 5) as f64,
            step: r.maybe_scalar("trackLength", Dims::LENGTH).filter(|s| *s > 0.0),
            xml,
        }
    }
}

impl Plan for StreamLine {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        if self.seeds.places(mesh).is_empty() {
            let message = format!("no seed of `{}` lies in the mesh", self.name);
            sink.push(Diag::error(&self.seeds_span, message).label("outside the mesh"));
        }
    }
    fn folder(&self) -> Option<&'static str> {
        Some("sets")
    }
    fn uses(&self) -> Vec<usize> {
        self.fields.uses().into_iter().chain(self.along.uses()).collect()
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(self.clone())
    }
}

impl Function for StreamLine {
    fn needs_derived(&self) -> bool {
        self.fields.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let along = view.everywhere(self.along.list[0].quantity);
        let list = &self.fields.list;
        let fields: Vec<_> = list.iter().filter_map(|f| view.everywhere(f.quantity)).collect();
        let Some(along) = along else { return Vec::new() };
        let (grid, mesh) = (view.grid(), &view.whole.case.mesh);
        let nodes = |all: &super::whole::Everywhere| {
            let points = all.at_points(grid);
            let own = |(k, p): (usize, &Vec<f64>)| {
                let mut v = with_centres(grid, p);
                // In the middle of a cell its own value.
                let first = v.len() - grid.poly.n_cells();
                v[first..].copy_from_slice(&all.parts[k][..grid.poly.n_cells()]);
                v
            };
            points.iter().enumerate().map(own).collect::<Vec<_>>()
        };
        let walker = Walker::new(grid, mesh, nodes(&along));
        let values: Vec<Vec<Vec<f64>>> = fields.iter().map(nodes).collect();
        let (mut rows, mut lines) = (Vec::new(), Vec::new());
        for seed in self.seeds.places(mesh) {
            let points = self.line(&walker, seed.x);
            let first = rows.len();
            for (x, spot) in &points {
                let values = values.iter().map(|v| spot.of(v)).collect();
                rows.push(Row { at: *x, values });
            }
            lines.push((first..rows.len()).collect::<Vec<usize>>());
        }
        self.files(view.time, &rows, &lines)
    }
}

impl StreamLine {
    /// The points of the line through `seed` with the places of their values.
    fn line(&self, walker: &Walker<'_>, seed: Vec3) -> Vec<(Vec3, Spot)> {
        let mut find = Locator::new(walker.mesh);
        let mut out: Vec<(Vec3, Spot)> = Vec::new();
        for (way, sign) in self.ways.into_iter().zip([1.0, -1.0]) {
            if !way {
                continue;
            }
            let mut part = Vec::new();
            let mut x = seed;
            while part.len() < self.life {
                let Some(spot) = walker.spot(&mut find, x) else { break };
                part.push((x, spot));
                let Some(next) = walker.step(&mut find, x, sign, self.per_cell, self.step) else {
                    break;
                };
                x = next;
            }
            if sign < 0.0 {
                part.reverse();
                // The seed is in both halves.
                part.extend(out.drain(..).skip(1));
            }
            out = part;
        }
        out
    }

    fn files(&self, time: f64, rows: &[Row], lines: &[Vec<usize>]) -> Vec<Written> {
        let list: &[Named] = &self.fields.list;
        if self.xml {
            let array = |(i, f): (usize, &Named)| {
                let n = f.quantity.n();
                let data = rows.iter().flat_map(|r| r.values[i][..n].to_vec()).collect();
                poly_data::Array { name: f.name.clone(), components: n, data }
            };
            let arrays: Vec<poly_data::Array> = list.iter().enumerate().map(array).collect();
            let points: Vec<Vec3> = rows.iter().map(|r| r.at).collect();
            let lines: Vec<Vec<u32>> =
                lines.iter().map(|l| l.iter().map(|i| *i as u32).collect()).collect();
            let bytes = poly_data::file(&points, &[], &lines, true, Some(time), &arrays);
            return vec![Written::File { file: "track0.vtp".into(), bytes }];
        }
        let one = |(i, f): (usize, &Named)| Written::File {
            file: format!("track0_{}.vtk", f.name),
            bytes: vtk("track0", rows, list, &[i], lines).into_bytes(),
        };
        list.iter().enumerate().map(one).collect()
    }
}

/// A point as the mean of the nodes of a tetrahedron.
#[derive(Clone, Copy)]
struct Spot {
    nodes: [usize; 4],
    weights: [f64; 4],
}

impl Spot {
    /// The value there of a field given at the nodes, one list a component.
    fn of(&self, parts: &[Vec<f64>]) -> Components {
        let at = |v: &Vec<f64>| self.nodes.iter().zip(self.weights).map(|(n, w)| w * v[*n]).sum();
        components(&parts.iter().map(at).collect::<Vec<f64>>())
    }
}

/// Goes along the flow.
struct Walker<'a> {
    grid: &'a Grid,
    mesh: &'a Mesh,
    /// Where the nodes are, and the velocity there, one list a component.
    places: [Vec<f64>; 3],
    velocity: Vec<Vec<f64>>,
}

impl<'a> Walker<'a> {
    fn new(grid: &'a Grid, mesh: &'a Mesh, velocity: Vec<Vec<f64>>) -> Walker<'a> {
        let along = |k: usize| {
            let all: Vec<f64> = grid.poly.points.iter().map(|p| p[k]).collect();
            with_centres(grid, &all)
        };
        Walker { grid, mesh, places: [0, 1, 2].map(along), velocity }
    }

    /// The tetrahedron that holds `x`, `None` outside the mesh.
    fn spot(&self, find: &mut Locator<'_>, x: Vec3) -> Option<Spot> {
        let cell = self.mesh.global_cell[find.find(x)?] as usize;
        let poly = &self.grid.poly;
        let (start, faces) = &self.grid.cell_faces;
        let n = poly.points.len();
        let place = |i: usize| [self.places[0][i], self.places[1][i], self.places[2][i]];
        let middle = n + poly.n_faces() + cell;
        // Rounding puts points between tetrahedra: the one it is least outside of.
        let mut best: Option<(f64, Spot)> = None;
        for f in faces[start[cell] as usize..start[cell + 1] as usize].iter().map(|f| *f >> 1) {
            let face = poly.face(f as usize);
            for (i, p) in face.iter().enumerate() {
                let q = face[(i + 1) % face.len()];
                let nodes = [middle, n + f as usize, *p as usize, q as usize];
                let Some(weights) = inside(nodes.map(place), x) else { continue };
                let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
                if best.is_none_or(|b| least > b.0) {
                    best = Some((least, Spot { nodes, weights }));
                }
            }
        }
        best.map(|b| b.1)
    }

    fn velocity(&self, find: &mut Locator<'_>, x: Vec3) -> Option<Vec3> {
        let v = self.spot(find, x)?.of(&self.velocity);
        let mut v = [v[0], v[1], v[2]];
        // Two-dimensional flows stay in their plane.
        (0..3).filter(|&k| !self.mesh.solved_dirs[k]).for_each(|k| v[k] = 0.0);
        Some(v)
    }

    /// The point one step on; `None` where the flow stands or leaves the mesh.
    fn step(
        &self,
        find: &mut Locator<'_>,
        x: Vec3,
        sign: f64,
        per_cell: f64,
        length: Option<f64>,
    ) -> Option<Vec3> {
        let size = self.mesh.cell_size(find.find(x)?);
        let k1 = self.velocity(find, x)?;
        let speed = norm(k1);
        let h = sign * length.unwrap_or(size / per_cell) / speed;
        // What stands goes nowhere.
        if !(h.is_finite() && speed > f64::MIN_POSITIVE) {
            return None;
        }
        let mut at = |k: Vec3, part: f64| self.velocity(find, add(x, scale(k, part * h)));
        let whole = || -> Option<Vec3> {
            let k2 = at(k1, 0.5)?;
            let k3 = at(k2, 0.5)?;
            let k4 = at(k3, 1.0)?;
            let sum = add(add(k1, k4), scale(add(k2, k3), 2.0));
            Some(add(x, scale(sum, h / 6.0)))
        };
        let mut whole = whole;
        if let Some(next) = whole() {
            return Some(next);
        }
        // Beside the boundary: as far as the mesh goes.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            match find.find(add(x, scale(k1, middle * h))) {
                Some(_) => low = middle,
                None => high = middle,
            }
        }
        (low * h.abs() * speed > 1e-6 * size).then(|| add(x, scale(k1, low * h)))
    }
}

/// Barycentric coordinates of `x`; `None` in a flat tetrahedron.
fn inside(t: [Vec3; 4], x: Vec3) -> Option<[f64; 4]> {
    let [a, b, c] = [1, 2, 3].map(|i| sub(t[i], t[0]));
    let det = dot(a, cross(b, c));
    let size = norm(a) * norm(b) * norm(c);
    if det.abs() <= 1e-12 * size {
        return None;
    }
    let d = sub(x, t[0]);
    let (u, v) = (dot(d, cross(b, c)) / det, dot(a, cross(d, c)) / det);
    let w = dot(a, cross(b, d)) / det;
    Some([1.0 - u - v - w, u, v, w])
}

/// Kinds of seeds by their words, for older files.
impl Line {
    fn of_kind(r: &Reader<'_>, name: &str, word: &str) -> Line {
        let mut line = Line::idle(name);
        match word {
            "uniform" | "lineUniform" => {
                r.ignore("axis");
                line.start = r.vector("start", Dims::LENGTH);
                line.end = r.vector("end", Dims::LENGTH);
                let n = r.label_in("nPoints", 2..=i64::from(i32::MAX)) as usize;
                line.points = Points::Uniform(n);
            }
            _ => {
                r.ignore("axis");
                line.points = Points::Given(r.vectors("points"));
            }
        }
        line
    }
}

/// The velocity of a case that names no other.
impl Wanted {
    fn or_velocity(r: &Reader<'_>, key: &str, reading: &Reading<'_>) -> Wanted {
        if !r.has(key) {
            let u = Named::find("U", reading).into_iter().collect();
            return Wanted { list: u, span: Span::none() };
        }
        let out = Wanted::one(r, key, reading);
        if out.list[0].quantity.n() != 3 {
            let message = format!("`{}` is no vector: no line follows it", out.list[0].name);
            r.error_at_key(key, message, "a vector is needed", None);
            return Wanted {
                list: vec![Named { quantity: Quantity::U, ..out.list[0].clone() }],
                ..out
            };
        }
        out
    }
}
