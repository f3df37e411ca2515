//! What the faces of two patches that lie on each other have in common.

use granflow_base::{Vec3, add, cross, dot, norm, scale, sub};
use std::collections::HashMap;

/// A convex face.
pub(super) struct Face {
    ring: Vec<u32>,
    at: Vec<Vec3>,
    normal: Vec3,
    low: Vec3,
    high: Vec3,
    pub(super) centre: Vec3,
    pub(super) area: f64,
}

/// The part that two faces share, turning as the first one does.
pub(super) struct Part {
    pub(super) first: usize,
    pub(super) second: usize,
    pub(super) ring: Vec<u32>,
    pub(super) area: f64,
}

/// All parts, and the points on edges that they bring.
pub(super) struct Overlay {
    pub(super) parts: Vec<Part>,
    /// Crossings of edges; they are numbered behind the points there are.
    pub(super) new_points: Vec<Vec3>,
    /// Points on edges, which go from the smaller to the larger of their ends.
    pub(super) on_edge: HashMap<(u32, u32), Vec<u32>>,
}

fn area_vector(at: &[Vec3]) -> Vec3 {
    let of = |i: usize| cross(sub(at[i], at[0]), sub(at[i + 1], at[0]));
    scale((1..at.len() - 1).map(of).fold([0.0; 3], add), 0.5)
}

impl Face {
    pub(super) fn new(ring: &[u32], points: &[Vec3]) -> Face {
        let at: Vec<Vec3> = ring.iter().map(|&p| points[p as usize]).collect();
        let vector = area_vector(&at);
        let area = norm(vector);
        let bound = |pick: fn(f64, f64) -> f64| -> Vec3 {
            std::array::from_fn(|k| at.iter().map(|x| x[k]).fold(at[0][k], pick))
        };
        let centre = scale(at.iter().copied().fold([0.0; 3], add), 1.0 / at.len() as f64);
        let normal = scale(vector, 1.0 / area.max(f64::MIN_POSITIVE));
        let (low, high) = (bound(f64::min), bound(f64::max));
        Face { ring: ring.to_vec(), at, normal, low, high, centre, area }
    }
    fn edge(&self, i: usize) -> [(u32, Vec3); 2] {
        let j = (i + 1) % self.ring.len();
        [(self.ring[i], self.at[i]), (self.ring[j], self.at[j])]
    }
    /// The edge's vector inwards, across it.
    fn inward(&self, i: usize, normal: Vec3) -> Vec3 {
        let [(_, a), (_, b)] = self.edge(i);
        let v = cross(normal, sub(b, a));
        scale(v, 1.0 / norm(v).max(f64::MIN_POSITIVE))
    }
    /// Distance to the edges' lines, positive inside, seen along the face's own normal.
    fn depths(&self, x: Vec3) -> impl Iterator<Item = f64> + '_ {
        (0..self.ring.len()).map(move |i| dot(self.inward(i, self.normal), sub(x, self.at[i])))
    }
    fn meets(&self, other: &Face, near: f64) -> bool {
        let apart =
            |k: usize| self.low[k] > other.high[k] + near || other.low[k] > self.high[k] + near;
        !(0..3).any(apart) && dot(self.normal, other.normal) < -0.5
    }
}

impl Overlay {
    /// Of the `first` and the `second` faces, which look at each other. Points nearer to an edge
    /// than `near` lie on it.
    pub(super) fn new(first: &[Face], second: &[Face], points: &[Vec3], near: f64) -> Overlay {
        let mut all =
            Overlay { parts: Vec::new(), new_points: Vec::new(), on_edge: HashMap::new() };
        let mut crossings: HashMap<[u32; 4], u32> = HashMap::new();
        for (i, a) in first.iter().enumerate() {
            for (j, b) in second.iter().enumerate().filter(|(_, b)| a.meets(b, near)) {
                all.pair((i, a), (j, b), points.len() as u32, near, &mut crossings);
            }
        }
        all
    }

    fn pair(
        &mut self,
        (i, a): (usize, &Face),
        (j, b): (usize, &Face),
        n_points: u32,
        near: f64,
        crossings: &mut HashMap<[u32; 4], u32>,
    ) {
        let mut corners: Vec<(u32, Vec3)> = Vec::new();
        for (of, other) in [(a, b), (b, a)] {
            for (&p, &x) in of.ring.iter().zip(&of.at) {
                if corners.iter().any(|c| c.0 == p) {
                    continue;
                }
                if other.ring.contains(&p) || other.depths(x).all(|d| d >= -near) {
                    corners.push((p, x));
                    self.note_on_edges(p, x, other, near);
                }
            }
        }
        for k in 0..a.ring.len() {
            for l in 0..b.ring.len() {
                let Some(x) = crossing(a.edge(k), b.edge(l), a.normal, near) else { continue };
                let sorted = |e: [(u32, Vec3); 2]| (e[0].0.min(e[1].0), e[0].0.max(e[1].0));
                let (e, f) = (sorted(a.edge(k)), sorted(b.edge(l)));
                let point = *crossings.entry([e.0, e.1, f.0, f.1]).or_insert_with(|| {
                    self.new_points.push(x);
                    n_points + self.new_points.len() as u32 - 1
                });
                for edge in [e, f] {
                    let list = self.on_edge.entry(edge).or_default();
                    if !list.contains(&point) {
                        list.push(point);
                    }
                }
                corners.push((point, x));
            }
        }
        if corners.len() < 3 {
            return;
        }
        // The common part of two convex faces is convex: its corners go round its middle.
        let sum = corners.iter().map(|c| c.1).fold([0.0; 3], add);
        let middle = scale(sum, 1.0 / corners.len() as f64);
        let along = sub(corners[0].1, middle);
        let across = cross(a.normal, along);
        let angle = |x: Vec3| dot(across, sub(x, middle)).atan2(dot(along, sub(x, middle)));
        corners.sort_by(|p, q| angle(p.1).total_cmp(&angle(q.1)));
        let at: Vec<Vec3> = corners.iter().map(|c| c.1).collect();
        let area = dot(area_vector(&at), a.normal);
        if area <= near * near {
            return;
        }
        let ring = corners.iter().map(|c| c.0).collect();
        self.parts.push(Part { first: i, second: j, ring, area });
    }

    /// Remembers on which edges of a face a point lies.
    fn note_on_edges(&mut self, p: u32, x: Vec3, face: &Face, near: f64) {
        if face.ring.contains(&p) {
            return;
        }
        for i in 0..face.ring.len() {
            let [(a, from), (b, to)] = face.edge(i);
            let (way, out) = (sub(to, from), sub(x, from));
            let t = dot(way, out) / dot(way, way).max(f64::MIN_POSITIVE);
            if (0.0..=1.0).contains(&t) && norm(sub(out, scale(way, t))) <= near {
                let list = self.on_edge.entry((a.min(b), a.max(b))).or_default();
                if !list.contains(&p) {
                    list.push(p);
                }
            }
        }
    }
}

/// Where two edges cross, away from their ends.
fn crossing(a: [(u32, Vec3); 2], b: [(u32, Vec3); 2], normal: Vec3, near: f64) -> Option<Vec3> {
    if a.iter().any(|p| b.iter().any(|q| p.0 == q.0)) {
        return None;
    }
    let side = |e: [(u32, Vec3); 2], x: Vec3| {
        let v = cross(normal, sub(e[1].1, e[0].1));
        dot(v, sub(x, e[0].1)) / norm(v).max(f64::MIN_POSITIVE)
    };
    let across = |e: [(u32, Vec3); 2], f: [(u32, Vec3); 2]| {
        let (p, q) = (side(e, f[0].1), side(e, f[1].1));
        (p.abs() > near && q.abs() > near && p * q < 0.0).then(|| p / (p - q))
    };
    across(a, b)?;
    // On the first edge, as the first patch's points count.
    Some(add(a[0].1, scale(sub(a[1].1, a[0].1), across(b, a)?)))
}
