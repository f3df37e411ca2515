//! Volume fractions of simple shapes by exact geometry.
//!
//! Half-spaces clip the cell. What a ball has of the remaining body is summed over its facets:
//! each facet spans a pyramid with the centre of the ball, whose overlap with the ball is an
//! integral over the facet that has a closed form edge by edge (compare Strobl, Formella &
//! Poschel, J. Comput. Phys. 311 (2016) 158, where the bodies are tetrahedra to hexahedra). For
//! a cylinder the facets are seen along its axis: the height over a disc is linear on each.

use super::body::Body;
use super::corners::Corners;
use granflow_base::{Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// A round body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Round {
    /// A ball.
    Sphere {
        /// Its centre, m.
        centre: Vec3,
        /// Its radius, m.
        radius: f64,
    },
    /// A cylinder without ends (half-spaces can give it some).
    Cylinder {
        /// A point of its axis, m.
        origin: Vec3,
        /// Direction of its axis.
        axis: Vec3,
        /// Its radius, m.
        radius: f64,
    },
}

/// The intersection of half-spaces and at most one round body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// `(outward normal, a point of the plane)`, m.
    pub half_spaces: Vec<(Vec3, Vec3)>,
    /// The round body, everything if absent.
    pub round: Option<Round>,
}

impl Shape {
    /// Everything behind the plane through `point` with the outward `normal`.
    pub fn half_space(normal: Vec3, point: Vec3) -> Shape {
        Shape { half_spaces: vec![(normal, point)], round: None }
    }
    /// A box along the axes between two corners.
    pub fn cuboid(lo: Vec3, hi: Vec3) -> Shape {
        let side = |d: usize, s: f64| {
            let mut n = [0.0; 3];
            n[d] = s;
            n
        };
        let both = |d: usize| [(side(d, 1.0), hi), (side(d, -1.0), lo)];
        Shape { half_spaces: (0..3).flat_map(both).collect(), round: None }
    }
    /// A ball.
    pub fn sphere(centre: Vec3, radius: f64) -> Shape {
        Shape { half_spaces: Vec::new(), round: Some(Round::Sphere { centre, radius }) }
    }
    /// An endless cylinder.
    pub fn cylinder(origin: Vec3, axis: Vec3, radius: f64) -> Shape {
        Shape { half_spaces: Vec::new(), round: Some(Round::Cylinder { origin, axis, radius }) }
    }
    /// This shape's part in `other`'s half-spaces; the round body of this one stays.
    #[must_use]
    pub fn and(mut self, other: &Shape) -> Shape {
        self.half_spaces.extend_from_slice(&other.half_spaces);
        self
    }

    /// Volume of the shape inside `body`, m3. Exact but for rounding. `body` is consumed in that
    /// it is clipped.
    pub fn volume_in(&self, body: &mut Body) -> f64 {
        for &(n, p) in &self.half_spaces {
            if body.points().is_empty() {
                return 0.0;
            }
            body.clip_by(n, p);
        }
        match self.round {
            None => body.volume(),
            Some(Round::Sphere { centre, radius }) => in_ball(body, centre, radius),
            Some(Round::Cylinder { origin, axis, radius }) => {
                in_cylinder(body, origin, unit(axis), radius)
            }
        }
    }
}

/// Volume fraction of `shape` in every own cell, into `alpha` (ghosts are left alone).
pub fn fill(exec: &Exec, mesh: &Mesh, corners: &Corners, shape: &Shape, alpha: &mut [f64]) {
    exec.for_each(&mut alpha[..mesh.n_cells], |first, out| {
        let mut body = Body::default();
        for (i, a) in out.iter_mut().enumerate() {
            body.load(corners, mesh, first + i);
            let whole = body.volume();
            // Rounding only: the fraction of a full cell is 1 to the last bit.
            let share = shape.volume_in(&mut body) / whole;
            *a = if share < 1e-13 {
                0.0
            } else if share > 1.0 - 1e-13 {
                1.0
            } else {
                share
            };
        }
    });
}

/// What a ball has of a body: `sum over facets of the integral of min(1, R^3/r^3) (x . n)/3`.
fn in_ball(body: &Body, centre: Vec3, radius: f64) -> f64 {
    let at = |p: u32| sub(add(body.points()[p as usize], body.origin()), centre);
    if body.points().iter().all(|&p| norm(sub(add(p, body.origin()), centre)) <= radius) {
        return body.volume();
    }
    let mut volume = 0.0;
    for ring in body.facets() {
        let Some(n) = normal(ring, at) else { continue };
        let h = dot(n, at(ring[0]));
        // Foot of the perpendicular from the centre of the ball.
        let foot = scale(n, h);
        let share = |i: usize| {
            let (a, b) = (at(ring[i]), at(ring[(i + 1) % ring.len()]));
            spherical_share(sub(a, foot), sub(b, foot), n, h.abs(), radius)
        };
        volume += h.signum() * (0..ring.len()).map(share).sum::<f64>();
    }
    volume
}

/// Unit normal of a facet, none where it has no area.
fn normal(ring: &[u32], at: impl Fn(u32) -> Vec3) -> Option<Vec3> {
    let first = at(ring[0]);
    let spoke = |i: usize| sub(at(ring[i]), first);
    let twice = (1..ring.len() - 1).map(|i| cross(spoke(i), spoke(i + 1))).fold([0.0; 3], add);
    let size = (1..ring.len()).map(|i| dot(spoke(i), spoke(i))).fold(0.0, f64::max);
    (norm(twice) > 1e-14 * size).then(|| unit(twice))
}

/// Overlap of the ball with the pyramid from its centre over the triangle (foot, a, b), signed by
/// the sense in which the triangle turns about `n`.
fn spherical_share(a: Vec3, b: Vec3, n: Vec3, h: f64, radius: f64) -> f64 {
    let edge = sub(b, a);
    let along = unit(edge);
    let Some(line) = Line::new(a, b, along, n) else { return 0.0 };
    let d = line.distance;
    // In the plane the ball is a disc of this radius.
    let disc2 = radius * radius - h * h;
    // Beyond the ball, a sector of angle dt holds R^3/3 (1 - h/r) dt of it where r is the
    // distance of the edge from the centre of the ball.
    let shell = |t1: f64, t2: f64, inner: f64| {
        let k = (h * h + d * d).sqrt();
        let primitive = |t: f64| (h * t.sin() / k).clamp(-1.0, 1.0).asin();
        let rim = if inner > 0.0 { h / radius } else { 1.0 };
        let disc = h * inner / 6.0 * (t2 - t1);
        let cap = rim * (t2 - t1) - (primitive(t2) - primitive(t1));
        disc + radius.powi(3) / 3.0 * cap
    };
    let flat = |t1: f64, t2: f64| h * d * d / 6.0 * (t2.tan() - t1.tan());
    line.sign * line.split(disc2.max(0.0), flat, |t1, t2| shell(t1, t2, disc2.max(0.0)))
}

/// An edge seen from the origin of its plane, in polar coordinates about the perpendicular.
struct Line {
    /// Distance of the line from the origin, m.
    distance: f64,
    /// Angles of the ends.
    t: [f64; 2],
    /// Sense of the triangle.
    sign: f64,
}

impl Line {
    fn new(a: Vec3, b: Vec3, along: Vec3, n: Vec3) -> Option<Line> {
        let turn = dot(n, cross(a, along));
        let distance = turn.abs();
        if distance <= 1e-300 || norm(along) == 0.0 {
            return None;
        }
        let angle = |p: Vec3| (dot(p, along) / distance).atan();
        Some(Line { distance, t: [angle(a), angle(b)], sign: turn.signum() })
    }

    /// Sum of `inside` where the line is within a disc of radius squared `disc2`, `outside`
    /// elsewhere.
    fn split(
        &self,
        disc2: f64,
        inside: impl Fn(f64, f64) -> f64,
        outside: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        let [t1, t2] = self.t;
        let chord2 = disc2 - self.distance * self.distance;
        if chord2 <= 0.0 {
            return outside(t1, t2);
        }
        let rim = (chord2.sqrt() / self.distance).atan();
        let (c1, c2) = ((-rim).clamp(t1, t2), rim.clamp(t1, t2));
        let part = |f: &dyn Fn(f64, f64) -> f64, a: f64, b: f64| if b > a { f(a, b) } else { 0.0 };
        part(&outside, t1, c1) + part(&inside, c1, c2) + part(&outside, c2, t2)
    }
}

/// What a cylinder has of a body: the heights of the facets along the axis over the disc.
fn in_cylinder(body: &Body, origin: Vec3, axis: Vec3, radius: f64) -> f64 {
    let at = |p: u32| sub(add(body.points()[p as usize], body.origin()), origin);
    let flat = |x: Vec3| sub(x, scale(axis, dot(axis, x)));
    let level = dot(axis, sub(body.origin(), origin));
    let mut volume = 0.0;
    for ring in body.facets() {
        let Some(n) = normal(ring, at) else { continue };
        let steep = dot(n, axis);
        if steep.abs() < 1e-12 {
            continue;
        }
        // Height over the plane through the body's origin: z = z0 + g . x.
        let z0 = dot(n, at(ring[0])) / steep - level;
        let g = scale(flat(n), -1.0 / steep);
        for (i, &p) in ring.iter().enumerate() {
            let (a, b) = (flat(at(p)), flat(at(ring[(i + 1) % ring.len()])));
            let along = unit(sub(b, a));
            let Some(line) = Line::new(a, b, along, axis) else { continue };
            let d = line.distance;
            let across = scale(cross(along, axis), line.sign);
            let direction = |t: f64| add(scale(across, t.cos()), scale(along, t.sin()));
            let inside = |t1: f64, t2: f64| {
                // Triangle: its area times the height at its centroid.
                let (u, v) = (t1.tan(), t2.tan());
                let middle = add(scale(across, 2.0 * d / 3.0), scale(along, d * (u + v) / 3.0));
                0.5 * d * d * (v - u) * (z0 + dot(g, middle))
            };
            let outside = |t1: f64, t2: f64| {
                // Sector: area R^2/2 dt, first moment R^3/3 of the turned directions.
                let swept = cross(sub(direction(t2), direction(t1)), scale(axis, line.sign));
                0.5 * radius * radius * (t2 - t1) * z0 + radius.powi(3) / 3.0 * dot(g, swept)
            };
            volume += line.sign * line.split(radius * radius, inside, outside);
        }
    }
    volume
}
