//! `type slice;`: a field over a plane through the mesh.

use super::field::{Scene, check};
use super::limits::Limits;
use super::shades::{ShadeSpec, range};
use super::stream;
use crate::CaseError;
use crate::plot::{Arrows, Axis, SliceFigure, round_levels};
use crate::section::{self, CARRIED, Corner, OTHERS, Piece, VECTOR};
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::Reader;
use std::collections::BTreeMap;

/// Arrows and stream lines are no nearer to each other than this share of the figure: beyond it they are a
/// black area.
const FINEST: f64 = 100.0;

/// What `contours` asks for.
enum Contours {
    /// About so many at round levels; none at all for 0.
    Count(usize),
    Levels(Vec<f64>),
}

fn contours(r: &Reader<'_>) -> Contours {
    let Some(token) = r.raw("contours").and_then(|t| t.first()) else { return Contours::Count(0) };
    if let Some(levels) = token.scalars() {
        return Contours::Levels(levels);
    }
    match token.label() {
        Some(n @ 0..=100) => Contours::Count(n as usize),
        _ => {
            let help = Some("write a number of lines, 0 to 100, or a list of levels");
            let message = format!("{} is no number of contours", token.describe());
            r.error_at_key("contours", message, "not known", help);
            Contours::Count(0)
        }
    }
}

/// What `arrows` or `streamLines` asks for.
struct ArrowSpec<'a> {
    reader: Reader<'a>,
    field: &'a str,
    /// Distance of arrows or lines in the unit of the axes.
    spacing: Option<f64>,
    /// Length of the longest one in the unit of the axes.
    longest: Option<f64>,
    unit: &'a str,
}

impl<'a> ArrowSpec<'a> {
    /// Lines have neither length nor key.
    fn read_lines(reader: Reader<'a>) -> ArrowSpec<'a> {
        let spacing = reader.has("spacing").then(|| reader.positive("spacing", Dims::NONE));
        ArrowSpec { field: reader.word("field"), spacing, longest: None, unit: "", reader }
    }

    fn read(reader: Reader<'a>) -> ArrowSpec<'a> {
        let given = |key| reader.has(key).then(|| reader.positive(key, Dims::NONE));
        ArrowSpec {
            field: reader.word("field"),
            spacing: given("spacing"),
            longest: given("longest"),
            unit: reader.opt_string("unit", ""),
            reader,
        }
    }

    /// The components at the points of the mesh, for the slots of a vector.
    fn slots(&self, scene: &Scene<'_>, limits: &Limits<'_>) -> Result<Slots, CaseError> {
        let mut out = Vec::new();
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let component = format!("{}_{axis}", self.field);
            match limits.at_points(scene, &self.reader, "field", &component)? {
                Some(v) => out.push((VECTOR + k, v)),
                None => break,
            }
        }
        Ok(out)
    }
}

/// The plane in space and on the page.
struct Plane {
    point: Vec3,
    normal: Vec3,
    /// Right and up in the figure.
    axes: (Vec3, Vec3),
    /// Zero of both axes.
    origin: Vec3,
    /// Unit of both axes, m.
    unit: f64,
}

impl Plane {
    fn read(r: &Reader<'_>) -> Plane {
        let (mut point, mut normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
        if let Some(plane) = r.sub("plane") {
            point = plane.vector("point", Dims::LENGTH);
            normal = plane.vector("normal", Dims::NONE);
            if norm(normal) == 0.0 {
                plane.error_at_key("normal", "a normal has a direction", "no direction", None);
            }
            normal = unit(normal);
        }
        let usual = if normal[2].abs() > 0.9 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let up = r.opt_vector("up", Dims::NONE, usual);
        if norm(normal) > 0.0 && norm(cross(up, normal)) <= 1e-9 * norm(up) {
            r.error_at_key("up", "up must not be along the normal", "along the normal", None);
        }
        Plane {
            point,
            normal,
            axes: base(normal, up),
            origin: r.opt_vector("origin", Dims::LENGTH, [0.0; 3]),
            unit: r.opt_positive("scale", Dims::LENGTH, 1.0),
        }
    }

    /// Where a point is on the page.
    fn flat(&self, p: Vec3) -> (f64, f64) {
        let d = sub(p, self.origin);
        (dot(d, self.axes.0) / self.unit, dot(d, self.axes.1) / self.unit)
    }
}

/// Axes of the plane: right and up.
fn base(normal: Vec3, up: Vec3) -> (Vec3, Vec3) {
    let v = unit(sub(up, scale(normal, dot(up, normal))));
    let u = cross(v, normal);
    let greatest = u.iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() + 1e-12 { *b } else { a });
    (if greatest < 0.0 { scale(u, -1.0) } else { u }, v)
}

/// A slice as the dictionary describes it.
pub(super) struct SliceSpec<'a> {
    r: Reader<'a>,
    title: &'a str,
    plane: Plane,
    field: &'a str,
    smooth: bool,
    shades: ShadeSpec,
    contours: Contours,
    x: Axis,
    y: Axis,
    limits: Limits<'a>,
    /// Contours of other fields: the dictionary, fields and levels.
    lines: Option<Reader<'a>>,
    levels: Vec<(&'a str, f64)>,
    arrows: Option<ArrowSpec<'a>>,
    streams: Option<ArrowSpec<'a>>,
}

impl<'a> SliceSpec<'a> {
    pub(super) fn read(r: &Reader<'a>) -> SliceSpec<'a> {
        let plane = Plane::read(r);
        let field = r.string("field");
        check(r, "field", field);
        let axis = |label: &str, key: &str| Axis {
            label: r.opt_string(label, "").to_owned(),
            range: range(r, key),
            ..Axis::default()
        };
        let limits = Limits::read(r);
        let lines = r.opt_sub("lines");
        let mut levels = Vec::new();
        if let Some(sub) = &lines {
            for key in sub.keys() {
                check(sub, key, key);
                levels.push((key, sub.scalar(key, Dims::NONE)));
            }
        }
        if limits.len() + levels.len() > CARRIED - OTHERS {
            let message = "`where` and `lines` name at most four fields together";
            r.error_at_key("lines", message, "too many", None);
        }
        let arrows = r.opt_sub("arrows").map(ArrowSpec::read);
        let streams = r.opt_sub("streamLines").map(ArrowSpec::read_lines);
        if arrows.is_some() && streams.is_some() {
            let help = "draw two figures";
            let message = "a slice has `arrows` or `streamLines`, not both";
            r.error_at_key("streamLines", message, "one of them", Some(help));
        }
        SliceSpec {
            r: r.clone(),
            title: r.opt_string("title", ""),
            plane,
            field,
            smooth: r.opt_one_of("shading", &[("smooth", true), ("cells", false)], true),
            shades: ShadeSpec::read(r),
            contours: contours(r),
            x: axis("xLabel", "xRange"),
            y: axis("yLabel", "yRange"),
            limits,
            lines,
            levels,
            arrows,
            streams,
        }
    }

    /// Values at the points of the mesh in their slots; `None` after a mistake.
    fn slots(&self, scene: &Scene<'_>) -> Result<Option<Slots>, CaseError> {
        let field = self.limits.at_points(scene, &self.r, "field", self.field)?;
        let Some(field) = field else { return Ok(None) };
        let mut slots = vec![(0, field)];
        slots.extend(self.limits.slots(scene, OTHERS)?);
        for (k, (field, _)) in self.levels.iter().enumerate() {
            let Some(reader) = &self.lines else { break };
            let values = scene.at_points(reader, field, field)?;
            slots.extend(values.map(|v| (OTHERS + self.limits.len() + k, v)));
        }
        if let Some(vector) = self.arrows.as_ref().or(self.streams.as_ref()) {
            slots.extend(vector.slots(scene, &self.limits)?);
        }
        Ok(Some(slots))
    }

    /// The figure at a time; `None` after a mistake, which is reported.
    pub(super) fn draw(&self, scene: &Scene<'_>) -> Result<Option<SliceFigure>, CaseError> {
        let Some(slots) = self.slots(scene)? else { return Ok(None) };
        let Some(samples) = scene.samples(&self.r, "field", self.field)? else { return Ok(None) };
        let (grid, plane) = (scene.grid, &self.plane);
        let polygons = section::cut(grid, plane.point, plane.normal);
        let whole = triangles(grid, &polygons, &slots);
        let pieces = self.limits.confine(whole.clone(), OTHERS, None);
        if polygons.is_empty() {
            let message = "the plane does not meet the mesh";
            self.r.warn_at_key("plane", message, "beside the mesh", None);
        } else {
            self.limits.warn_if_empty(&pieces, &self.r, scene.time);
        }
        let value =
            |p: &Piece, c: &Corner| if self.smooth { c.v[0] } else { samples.values[p.cell] };
        let all = pieces.iter().flat_map(|p| p.corners.iter().map(|c| value(p, c)));
        let shades = self.shades.over(all, self.field);
        let levels = match &self.contours {
            Contours::Levels(l) => l.clone(),
            Contours::Count(0) => Vec::new(),
            Contours::Count(n) => round_levels(shades.range, *n),
        };
        let flat = |p: Vec3| plane.flat(p);
        let extent = grid.size / plane.unit;
        let line = |pieces: &[Piece], slot: usize, level: f64| {
            section::chain(&section::level_segments(pieces, slot, level, flat), 1e-7 * extent)
        };
        let first_line = OTHERS + self.limits.len();
        let on_page = |p: &Piece| {
            p.corners.map(|c| {
                let (x, y) = flat(c.at);
                (x, y, value(p, &c))
            })
        };
        Ok(Some(SliceFigure {
            title: self.title.replace("<time>", scene.time),
            x: self.x.clone(),
            y: self.y.clone(),
            triangles: pieces.iter().map(on_page).collect(),
            contours: levels.iter().map(|l| (*l, line(&pieces, 0, *l))).collect(),
            lines: self
                .levels
                .iter()
                .enumerate()
                .flat_map(|(k, l)| line(&whole, first_line + k, l.1))
                .collect(),
            arrows: self.arrows.as_ref().map(|spec| {
                let spacing = spec.spacing.unwrap_or(extent / 24.0).max(extent / FINEST);
                Arrows {
                    arrows: arrows_on(&pieces, plane, spacing),
                    longest: spec.longest.unwrap_or(1.5 * spacing),
                    unit: spec.unit.to_owned(),
                }
            }),
            streams: self.streams.as_ref().map_or(Vec::new(), |spec| {
                let spacing = spec.spacing.unwrap_or(extent / 30.0).max(extent / FINEST);
                stream::lines(&vectors_on(&pieces, plane), spacing)
            }),
            shades,
        }))
    }
}

type Slots = Vec<(usize, Vec<f64>)>;

/// Polygons as triangles about their middles, with the values of the slots.
fn triangles(
    grid: &section::Grid,
    polygons: &[section::Polygon],
    slots: &[(usize, Vec<f64>)],
) -> Vec<Piece> {
    let mut out = Vec::new();
    for polygon in polygons {
        let corner = |&(a, b, t): &(u32, u32, f64)| {
            let end = |p: u32| {
                let mut c = Corner { at: grid.poly.points[p as usize], v: [0.0; CARRIED] };
                slots.iter().for_each(|(slot, v)| c.v[*slot] = v[p as usize]);
                c
            };
            end(a).towards(&end(b), t)
        };
        let corners: Vec<Corner> = polygon.corners.iter().map(corner).collect();
        let share = 1.0 / corners.len() as f64;
        let middle = corners.iter().fold(Corner::default(), |mut m, c| {
            m.at = add(m.at, scale(c.at, share));
            m.v.iter_mut().zip(c.v).for_each(|(a, b)| *a += share * b);
            m
        });
        for (i, c) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            out.push(Piece { cell: polygon.cell, corners: [middle, *c, next] });
        }
    }
    out
}

/// Corners on the page with the vector in the plane.
fn vectors_on(pieces: &[Piece], plane: &Plane) -> Vec<[Arrow; 3]> {
    let (u, v) = plane.axes;
    let corner = |c: Corner| {
        let w = [c.v[VECTOR], c.v[VECTOR + 1], c.v[VECTOR + 2]];
        (plane.flat(c.at), (dot(w, u), dot(w, v)))
    };
    pieces.iter().map(|p| p.corners.map(corner)).collect()
}

type Arrow = ((f64, f64), (f64, f64));

/// Vectors on a square lattice over the pieces.
fn arrows_on(pieces: &[Piece], plane: &Plane, spacing: f64) -> Vec<Arrow> {
    // A point on an edge is found in both of its triangles.
    let mut out: BTreeMap<(i64, i64), Arrow> = BTreeMap::new();
    for piece in pieces {
        let c = piece.corners.map(|c| plane.flat(c.at));
        let [a, b, d] = c;
        let area = (b.0 - a.0) * (d.1 - a.1) - (b.1 - a.1) * (d.0 - a.0);
        if area == 0.0 {
            continue;
        }
        // Half a spacing off, so that none lies on an axis of symmetry or a wall.
        let ends = |k: fn(&(f64, f64)) -> f64| {
            let (lo, hi) = c
                .iter()
                .map(k)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |e, x| (e.0.min(x), e.1.max(x)));
            ((lo / spacing - 0.5).ceil() as i64)..=((hi / spacing - 0.5).floor() as i64)
        };
        for i in ends(|p| p.0) {
            for j in ends(|p| p.1) {
                let at = ((i as f64 + 0.5) * spacing, (j as f64 + 0.5) * spacing);
                let part = |p: (f64, f64), q: (f64, f64)| {
                    ((p.0 - at.0) * (q.1 - at.1) - (p.1 - at.1) * (q.0 - at.0)) / area
                };
                let s = [part(b, d), part(d, a), part(a, b)];
                if s.iter().all(|x| *x >= 0.0) {
                    let w = |k: usize| (0..3).map(|i| s[i] * piece.corners[i].v[VECTOR + k]).sum();
                    let w: Vec3 = [w(0), w(1), w(2)];
                    let (u, v) = plane.axes;
                    out.entry((i, j)).or_insert((at, (dot(w, u), dot(w, v))));
                }
            }
        }
    }
    out.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::{PatchKind, PolyMesh, shapes};
    use section::Grid;

    fn meshes() -> [PolyMesh; 3] {
        let wall = shapes::all(PatchKind::Wall);
        [
            shapes::unit_box([5, 4, 3]),
            shapes::displaced(&shapes::unit_box([4, 4, 4]), 0.2, 11),
            shapes::prism_box([4, 5, 3], [0.0; 3], [1.0; 3], wall),
        ]
    }

    fn linear(p: Vec3) -> f64 {
        1.0 + p[0] + 2.0 * p[1] - 3.0 * p[2]
    }

    /// The plane x = 0.4 with axes y and z in units of half a metre from (0, 0.5, 0.5).
    fn plane() -> Plane {
        Plane {
            point: [0.4, 0.0, 0.0],
            normal: [1.0, 0.0, 0.0],
            axes: base([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            origin: [0.0, 0.5, 0.5],
            unit: 0.5,
        }
    }

    fn pieces(grid: &Grid, values: Vec<f64>) -> Vec<Piece> {
        let polygons = section::cut(grid, plane().point, plane().normal);
        triangles(grid, &polygons, &[(0, values)])
    }

    #[test]
    fn linear_fields_are_exact_on_a_plane_that_is_covered_once() {
        for poly in meshes() {
            let grid = Grid::new(poly);
            let n = grid.n_samples();
            let values = (0..n).map(|s| linear(grid.place(s))).collect();
            let samples = section::Samples { values, known: vec![true; n], periodic: true };
            let pieces = pieces(&grid, grid.at_points(&samples));
            let mut area = 0.0;
            for piece in &pieces {
                let [a, b, c] = piece.corners.map(|c| c.at);
                area += 0.5 * norm(cross(sub(b, a), sub(c, a)));
                let away = |p: Vec3| p[1..].iter().any(|x| (x - 0.5).abs() < 0.24);
                for c in &piece.corners {
                    assert!((c.at[0] - 0.4).abs() < 1e-12);
                    // Off the edges of the mesh, where values stay within what is around.
                    if away(c.at) {
                        assert!((c.v[0] - linear(c.at)).abs() < 1e-12, "{c:?}");
                    }
                }
            }
            assert!((area - 1.0).abs() < 1e-12, "{area}");
        }
    }

    #[test]
    fn contours_of_a_linear_field_are_straight() {
        for poly in meshes() {
            let grid = Grid::new(poly);
            let exact: Vec<f64> = grid.poly.points.iter().map(|p| linear(*p)).collect();
            let flat = |p: Vec3| plane().flat(p);
            let segments = section::level_segments(&pieces(&grid, exact), 0, 0.9, flat);
            let lines = section::chain(&segments, 1e-7);
            assert_eq!(lines.len(), 1);
            // 1.4 + 2 y - 3 z = 0.9 from (0, 1/6) to (1, 5/6), seen in half metres from the middle.
            for (u, v) in &lines[0] {
                assert!((2.0 * u - 3.0 * v).abs() < 1e-9, "{u} {v}");
            }
            let ends = [lines[0][0].0, lines[0][lines[0].len() - 1].0];
            assert!(ends.iter().all(|u| (u.abs() - 1.0).abs() < 1e-9) && ends[0] != ends[1]);
            let steps = lines[0].windows(2).map(|w| (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1));
            let length: f64 = steps.sum();
            assert!((length - 2.0 * (1.0 + 4.0 / 9.0f64).sqrt()).abs() < 1e-9, "{length}");
        }
    }

    #[test]
    fn arrows_stand_on_a_lattice_once_each() {
        let grid = Grid::new(shapes::unit_box([5, 4, 3]));
        let n = grid.poly.points.len();
        let polygons = section::cut(&grid, plane().point, plane().normal);
        let slots =
            [(VECTOR, vec![9.0; n]), (VECTOR + 1, vec![2.0; n]), (VECTOR + 2, vec![1.0; n])];
        let pieces = triangles(&grid, &polygons, &slots);
        // Two units of the axes either way: 8 by 8 places, many of them on edges of cells.
        let arrows = arrows_on(&pieces, &plane(), 0.25);
        assert_eq!(arrows.len(), 64);
        for (at, (u, v)) in arrows {
            assert!(((at.0 / 0.25).rem_euclid(1.0) - 0.5).abs() < 1e-9, "{at:?}");
            assert!((u - 2.0).abs() < 1e-12 && (v - 1.0).abs() < 1e-12);
        }
    }
}
