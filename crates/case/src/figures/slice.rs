//! `type slice;`: a field over a plane through the mesh.

use super::field::{Scene, Within, check, within};
use crate::CaseError;
use crate::plot::{Arrows, Axis, ColourMap, Shades, SliceFigure};
use crate::section::{self, CARRIED, Corner, OTHERS, Piece, VECTOR};
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::Reader;

/// How values become colours, as the dictionary says.
pub(super) struct ShadeSpec {
    map: ColourMap,
    range: Option<(f64, f64)>,
    label: String,
}

impl ShadeSpec {
    pub(super) fn read(r: &Reader<'_>) -> ShadeSpec {
        let maps = [("viridis", ColourMap::Viridis), ("coolwarm", ColourMap::CoolWarm)];
        ShadeSpec {
            map: r.opt_one_of("map", &maps, ColourMap::Viridis),
            range: range(r, "range"),
            label: r.opt_string("barLabel", "").to_owned(),
        }
    }

    /// With the ends of the values where no range is given; around zero for a diverging map.
    pub(super) fn over(&self, values: impl Iterator<Item = f64>, field: &str) -> Shades {
        let (lo, hi) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| (e.0.min(v), e.1.max(v)));
        let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, 1.0) };
        let (lo, hi) = match self.map {
            ColourMap::CoolWarm if lo < 0.0 && hi > 0.0 => {
                let most = hi.max(-lo);
                (-most, most)
            }
            _ if hi - lo <= 1e-12 * hi.abs().max(lo.abs()) => {
                let half = if lo == 0.0 { 1.0 } else { 0.1 * lo.abs() };
                (lo - half, hi + half)
            }
            _ => (lo, hi),
        };
        let label = match &self.label[..] {
            "" => crate::plot::literal(field).into_owned(),
            given => given.to_owned(),
        };
        Shades { map: self.map, range: self.range.unwrap_or((lo, hi)), label }
    }
}

/// Two growing numbers.
pub(super) fn range(r: &Reader<'_>, key: &str) -> Option<(f64, f64)> {
    let v = r.maybe_scalars(key)?;
    match v[..] {
        [a, b] if a < b => Some((a, b)),
        _ => {
            let help = Some("write `(0 16)`");
            r.error_at_key(key, "a range is two growing numbers", "not a range", help);
            None
        }
    }
}

/// What `contours` asks for.
enum Contours {
    None,
    Count(usize),
    Levels(Vec<f64>),
}

fn contours(r: &Reader<'_>) -> Contours {
    let Some(token) = r.raw("contours").and_then(|t| t.first()) else { return Contours::None };
    if let Some(levels) = token.scalars() {
        return Contours::Levels(levels);
    }
    match token.label() {
        Some(n @ 1..=100) => Contours::Count(n as usize),
        _ => {
            let help = Some("write a number of lines, 1 to 100, or a list of levels");
            let message = format!("{} is no number of contours", token.describe());
            r.error_at_key("contours", message, "not known", help);
            Contours::None
        }
    }
}

/// Axes of the plane: right and up.
fn base(normal: Vec3, up: Vec3) -> (Vec3, Vec3) {
    let v = unit(sub(up, scale(normal, dot(up, normal))));
    let u = cross(v, normal);
    let greatest = u.iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() + 1e-12 { *b } else { a });
    (if greatest < 0.0 { scale(u, -1.0) } else { u }, v)
}

/// The figure at each time; none without times, when only the form is looked at.
pub(super) fn read(r: &Reader<'_>, scenes: &[Scene<'_>]) -> Result<Vec<SliceFigure>, CaseError> {
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
    if norm(cross(up, normal)) <= 1e-9 * norm(up) {
        r.error_at_key("up", "up must not be along the normal", "along the normal", None);
    }
    let origin = r.opt_vector("origin", Dims::LENGTH, [0.0; 3]);
    let unit_length = r.opt_positive("scale", Dims::LENGTH, 1.0);
    let text = r.string("field");
    check(r, "field", text);
    let smooth = r.opt_one_of("shading", &[("smooth", true), ("cells", false)], true);
    let shades = ShadeSpec::read(r);
    let contours = contours(r);
    let axis = |label: &str, key: &str| Axis {
        label: r.opt_string(label, "").to_owned(),
        range: range(r, key),
        ..Axis::default()
    };
    let (x, y) = (axis("xLabel", "xRange"), axis("yLabel", "yRange"));
    let title = r.opt_string("title", "");
    let limits = within(r);
    let mut lines = Vec::new();
    let line_reader = r.opt_sub("lines");
    if let Some(sub) = &line_reader {
        sub.keys().into_iter().for_each(|k| lines.push((k.to_owned(), sub.scalar(k, Dims::NONE))));
    }
    let limit_count = limits.as_ref().map_or(0, |l| l.1.len());
    if limit_count + lines.len() > CARRIED - OTHERS {
        let message = "`where` and `lines` name at most four fields together";
        r.error_at_key("lines", message, "too many", None);
        lines.clear();
    }
    let arrows = r.opt_sub("arrows").map(|a| {
        let field = a.word("field");
        let spacing = a.opt_positive("spacing", Dims::NONE, 0.0f64.max(f64::MIN_POSITIVE));
        let longest = a.opt_positive("longest", Dims::NONE, f64::MIN_POSITIVE);
        (field, spacing, longest, a.opt_string("unit", "").to_owned(), a)
    });

    let mut out = Vec::new();
    for scene in scenes {
        let grid = scene.grid;
        let mut slots: Vec<(usize, Vec<f64>)> = Vec::new();
        let samples = scene.samples(r, "field", text)?;
        if let Some(s) = &samples {
            slots.push((0, grid.at_points(s)));
        }
        let no_limits: Vec<Within> = Vec::new();
        let limits_of = limits.as_ref().map_or(&no_limits, |l| &l.1);
        let others = limits_of
            .iter()
            .filter_map(|w| limits.as_ref().map(|l| (&l.0, &w.field)))
            .chain(lines.iter().filter_map(|l| line_reader.as_ref().map(|r| (r, &l.0))));
        for (k, (reader, field)) in others.enumerate() {
            if let Some(v) = scene.at_points(reader, field, field)? {
                slots.push((OTHERS + k, v));
            }
        }
        if let Some((field, .., a)) = &arrows {
            for (k, axis) in ["x", "y", "z"].iter().enumerate() {
                match scene.at_points(a, "field", &format!("{field}_{axis}"))? {
                    Some(v) => slots.push((VECTOR + k, v)),
                    None => break,
                }
            }
        }
        let (u, v) = base(normal, up);
        let flat = |p: Vec3| {
            let d = sub(p, origin);
            (dot(d, u) / unit_length, dot(d, v) / unit_length)
        };
        let polygons = section::cut(grid, point, normal);
        let whole = triangles(grid, &polygons, &slots);
        if polygons.is_empty() {
            r.warn_at_key("plane", "the plane does not meet the mesh", "beside the mesh", None);
        }
        let mut pieces = whole.clone();
        for (k, w) in limits_of.iter().enumerate() {
            let slack = 1e-9 * (w.range.1 - w.range.0);
            pieces = section::clip(pieces, OTHERS + k, w.range.0 - slack, 1.0);
            pieces = section::clip(pieces, OTHERS + k, w.range.1 + slack, -1.0);
        }
        if pieces.is_empty() && !polygons.is_empty() {
            let message = format!("nothing of the plane is within `where` at {}", scene.time);
            r.warn_at_key("where", message, "leaves nothing", None);
        }
        let cell = |p: &Piece| samples.as_ref().map_or(0.0, |s| s.values[p.cell]);
        let value = |p: &Piece, c: &Corner| if smooth { c.v[0] } else { cell(p) };
        let all = pieces.iter().flat_map(|p| p.corners.iter().map(|c| value(p, c)));
        let shades = shades.over(all, text);
        let levels = match &contours {
            Contours::None => Vec::new(),
            Contours::Levels(l) => l.clone(),
            Contours::Count(n) => {
                let (lo, hi) = shades.range;
                (1..=*n).map(|i| lo + (hi - lo) * i as f64 / (*n as f64 + 1.0)).collect()
            }
        };
        let near = 1e-7 * grid.size / unit_length;
        let line = |pieces: &[Piece], slot: usize, level: f64| {
            section::chain(&section::level_segments(pieces, slot, level, flat), near)
        };
        out.push(SliceFigure {
            title: title.replace("<time>", scene.time),
            x: x.clone(),
            y: y.clone(),
            triangles: pieces
                .iter()
                .map(|p| {
                    p.corners.map(|c| {
                        let (x, y) = flat(c.at);
                        (x, y, value(p, &c))
                    })
                })
                .collect(),
            contours: levels.iter().map(|l| (*l, line(&pieces, 0, *l))).collect(),
            lines: lines
                .iter()
                .enumerate()
                .flat_map(|(k, l)| line(&whole, OTHERS + limit_count + k, l.1))
                .collect(),
            arrows: arrows.as_ref().map(|(_, spacing, longest, unit, _)| {
                let extent = grid.size / unit_length;
                let spacing = if *spacing > f64::MIN_POSITIVE { *spacing } else { extent / 24.0 };
                let longest = if *longest > f64::MIN_POSITIVE { *longest } else { 1.5 * spacing };
                let arrows = arrows_on(&pieces, flat, (u, v), spacing.max(extent / 500.0));
                Arrows { arrows, longest, unit: unit.clone() }
            }),
            shades,
        });
    }
    Ok(out)
}

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

/// Vectors on a square lattice over the pieces.
fn arrows_on(
    pieces: &[Piece],
    flat: impl Fn(Vec3) -> (f64, f64),
    (u, v): (Vec3, Vec3),
    spacing: f64,
) -> Vec<((f64, f64), (f64, f64))> {
    let mut out = Vec::new();
    for piece in pieces {
        let c = piece.corners.map(|c| flat(c.at));
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
                    if !out.iter().rev().take(8).any(|o: &((f64, f64), _)| o.0 == at) {
                        out.push((at, (dot(w, u), dot(w, v))));
                    }
                }
            }
        }
    }
    out
}
