//! Stream lines in a plane, evenly spaced.
//!
//! B. Jobard, W. Lefer, Creating evenly-spaced streamlines of arbitrary density, Visualization in
//! Scientific Computing (1997): a line grows until it comes nearer than half the spacing to another
//! one; the next one starts a spacing beside it.

use crate::plot::Polyline;
use std::collections::HashMap;

type Point = (f64, f64);

/// A corner on the page with the components of the vector there.
type Corner = (Point, Point);

/// Of the spacing: length of a step.
const STEP: f64 = 0.1;
/// Of the spacing: how near lines may come to each other.
const NEAR: f64 = 0.5;
/// Points of a line that are too new to be in its own way.
const BEHIND: usize = 20;
/// Most points of a line.
const MOST_POINTS: usize = 20_000;
/// Most lines of a figure.
const MOST_LINES: usize = 4000;

/// Triangles of a vector field, found by place.
struct Field<'a> {
    triangles: &'a [[Corner; 3]],
    bins: HashMap<(i64, i64), Vec<usize>>,
    bin: f64,
}

fn cell((x, y): Point, size: f64) -> (i64, i64) {
    ((x / size).floor() as i64, (y / size).floor() as i64)
}

impl<'a> Field<'a> {
    fn new(triangles: &'a [[Corner; 3]], bin: f64) -> Field<'a> {
        let mut bins: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
        for (i, t) in triangles.iter().enumerate() {
            let (mut lo, mut hi) = ((i64::MAX, i64::MAX), (i64::MIN, i64::MIN));
            for at in t.iter().map(|c| cell(c.0, bin)) {
                lo = (lo.0.min(at.0), lo.1.min(at.1));
                hi = (hi.0.max(at.0), hi.1.max(at.1));
            }
            for x in lo.0..=hi.0 {
                (lo.1..=hi.1).for_each(|y| bins.entry((x, y)).or_default().push(i));
            }
        }
        Field { triangles, bins, bin }
    }

    /// The vector at `p`; `None` outside.
    fn at(&self, p: Point) -> Option<Point> {
        for i in self.bins.get(&cell(p, self.bin))? {
            let [a, b, c] = self.triangles[*i];
            let cross = |u: Point, v: Point| (u.0 - p.0) * (v.1 - p.1) - (u.1 - p.1) * (v.0 - p.0);
            let s = [cross(b.0, c.0), cross(c.0, a.0), cross(a.0, b.0)];
            let area: f64 = s.iter().sum();
            if area != 0.0 && s.iter().all(|x| x / area >= -1e-9) {
                let mix =
                    |k: fn(Point) -> f64| (s[0] * k(a.1) + s[1] * k(b.1) + s[2] * k(c.1)) / area;
                return Some((mix(|v| v.0), mix(|v| v.1)));
            }
        }
        None
    }

    /// The direction at `p`; `None` outside and where nothing flows.
    fn along(&self, p: Point, least: f64) -> Option<Point> {
        let (u, v) = self.at(p)?;
        let size = u.hypot(v);
        (size > least).then(|| (u / size, v / size))
    }
}

/// Points of the lines so far, by place.
struct Taken {
    points: HashMap<(i64, i64), Vec<Point>>,
    size: f64,
}

impl Taken {
    fn put(&mut self, p: Point) {
        self.points.entry(cell(p, self.size)).or_default().push(p);
    }
    /// Whether a point is nearer to a line than `least`, which is at most the size of a bin.
    fn near(&self, p: Point, least: f64) -> bool {
        let (x, y) = cell(p, self.size);
        (x - 1..=x + 1).any(|i| {
            (y - 1..=y + 1).any(|j| {
                let there = self.points.get(&(i, j)).into_iter().flatten();
                there.into_iter().any(|q| (p.0 - q.0).hypot(p.1 - q.1) < least)
            })
        })
    }
}

/// Lines along the vectors at the corners of triangles, `spacing` apart, each in the direction of the
/// flow.
pub(super) fn lines(triangles: &[[Corner; 3]], spacing: f64) -> Vec<Polyline> {
    let size = |c: &Corner| c.1.0.hypot(c.1.1);
    let fastest = triangles.iter().flatten().map(size).fold(0.0, f64::max);
    if !(fastest > 0.0 && spacing > 0.0) {
        return Vec::new();
    }
    let field = Field::new(triangles, spacing);
    // What only rounding moves is at rest.
    let least = 1e-9 * fastest;
    let mut taken = Taken { points: HashMap::new(), size: spacing };
    let mut out: Vec<Polyline> = Vec::new();
    // Where the flow is fastest first, then beside what is there, then anywhere.
    let mut corners: Vec<&Corner> = triangles.iter().flatten().collect();
    corners.sort_by(|a, b| size(b).total_cmp(&size(a)));
    for seed in corners.into_iter().map(|c| c.0) {
        let mut waiting = vec![seed];
        while let Some(seed) = waiting.pop() {
            if out.len() == MOST_LINES || taken.near(seed, spacing) {
                continue;
            }
            let line = grow(&field, &taken, seed, spacing, least);
            let length = STEP * spacing * line.len() as f64;
            if length < spacing {
                continue;
            }
            line.iter().for_each(|p| taken.put(*p));
            let beside = |w: &[Point]| {
                let (dx, dy) = (w[1].0 - w[0].0, w[1].1 - w[0].1);
                let n = dx.hypot(dy).max(f64::MIN_POSITIVE);
                let (ex, ey) = (-dy / n * spacing, dx / n * spacing);
                [
                    (w[0].0 + 1.001 * ex, w[0].1 + 1.001 * ey),
                    (w[0].0 - 1.001 * ex, w[0].1 - 1.001 * ey),
                ]
            };
            waiting.extend(line.windows(2).step_by(5).flat_map(beside));
            out.push(line);
        }
    }
    out
}

/// The line through `seed`, against the flow and with it, as far as there is room.
fn grow(field: &Field<'_>, taken: &Taken, seed: Point, spacing: f64, least: f64) -> Polyline {
    let h = STEP * spacing;
    // Whether a point lies on the way back into the seed.
    let start = field.along(seed, least).unwrap_or_default();
    let meets = |p: Point| {
        let (dx, dy) = (p.0 - seed.0, p.1 - seed.1);
        dx.hypot(dy) < spacing && (dx * start.1 - dy * start.0).abs() < 0.5 * h
    };
    let half = |sign: f64, forth: &[Point]| {
        let mut points = vec![seed];
        let mut p = seed;
        // What is a way behind: a spiral ends where it comes near to itself, the other half included.
        let mut own = Taken { points: HashMap::new(), size: spacing };
        forth.iter().skip(BEHIND).for_each(|p| own.put(*p));
        while points.len() < MOST_POINTS {
            let Some(k1) = field.along(p, least) else { break };
            let middle = (p.0 + 0.5 * sign * h * k1.0, p.1 + 0.5 * sign * h * k1.1);
            let Some(k2) = field.along(middle, least) else { break };
            let next = (p.0 + sign * h * k2.0, p.1 + sign * h * k2.1);
            if field.at(next).is_none() || taken.near(next, NEAR * spacing) {
                break;
            }
            if own.near(next, NEAR * spacing) && !meets(next) {
                break;
            }
            if let Some(behind) = points.len().checked_sub(BEHIND) {
                own.put(points[behind]);
            }
            // Round and back to where it began.
            let closed = points.len() > 20 && (next.0 - seed.0).hypot(next.1 - seed.1) < h;
            points.push(next);
            p = next;
            if closed {
                points.push(seed);
                return (points, true);
            }
        }
        (points, false)
    };
    let (forth, closed) = half(1.0, &[]);
    if closed {
        return forth;
    }
    let (mut back, _) = half(-1.0, &forth);
    back.reverse();
    back.extend(forth.into_iter().skip(1));
    back
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles of the unit square about the origin with a linear vector field.
    fn square(f: impl Fn(Point) -> Point) -> Vec<[Corner; 3]> {
        let n = 20;
        let at = |i: usize, j: usize| {
            let p = (i as f64 / n as f64 - 0.5, j as f64 / n as f64 - 0.5);
            (p, f(p))
        };
        let mut out = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                out.extend([[a, b, c], [a, c, d]]);
            }
        }
        out
    }

    #[test]
    fn uniform_flow_has_straight_lines_from_end_to_end_at_a_distance() {
        let lines = lines(&square(|_| (2.0, 0.0)), 0.1);
        assert!((8..=11).contains(&lines.len()), "{}", lines.len());
        let mut heights: Vec<f64> = lines.iter().map(|l| l[0].1).collect();
        heights.sort_by(f64::total_cmp);
        assert!(heights.windows(2).all(|w| w[1] - w[0] > 0.0999), "{heights:?}");
        for line in &lines {
            assert!(line.iter().all(|p| (p.1 - line[0].1).abs() < 1e-12));
            assert!(line[line.len() - 1].0 - line[0].0 > 0.95, "with the flow, all the way");
        }
    }

    /// A vortex that draws water in: no line runs over itself where it does not quite close.
    #[test]
    fn a_line_that_almost_closes_is_drawn_once() {
        let spacing = 0.05;
        let all = lines(&square(|p| (-p.1 - 0.003 * p.0, p.0 - 0.003 * p.1)), spacing);
        for line in &all {
            for (i, p) in line.iter().enumerate() {
                let far = line
                    .iter()
                    .skip(i + 3 * BEHIND)
                    .take(line.len().saturating_sub(i + 6 * BEHIND));
                let near = far.filter(|q| (p.0 - q.0).hypot(p.1 - q.1) < 0.2 * spacing).count();
                assert!(near <= 3, "{near} points of {} lie on it again", line.len());
            }
        }
    }

    #[test]
    fn a_vortex_has_circles() {
        let lines = lines(&square(|p| (-p.1, p.0)), 0.1);
        let whole = lines.iter().filter(|l| l[0] == l[l.len() - 1]).count();
        assert!(whole >= 3, "{whole} closed of {}", lines.len());
        for line in &lines {
            let r = |p: &Point| p.0.hypot(p.1);
            assert!(line.iter().all(|p| (r(p) - r(&line[0])).abs() < 2e-3));
        }
        assert!(super::lines(&square(|_| (0.0, 0.0)), 0.1).is_empty());
        // A spiral does not wind itself up in its eye.
        let wound = super::lines(&square(|p| (-p.1 - 0.02 * p.0, p.0 - 0.02 * p.1)), 0.1);
        let turns = |l: &Polyline| {
            let turn = |w: &[Point]| {
                (w[0].0 * w[1].1 - w[0].1 * w[1].0).atan2(w[0].0 * w[1].0 + w[0].1 * w[1].1)
            };
            l.windows(2).map(turn).sum::<f64>() / std::f64::consts::TAU
        };
        assert!(!wound.is_empty() && wound.iter().all(|l| turns(l) < 2.5), "{}", wound.len());
    }
}
