//! A cell as a closed surface of flat polygons, and what a level of a function cuts off it.
//!
//! All volumes come from Gauss's theorem with the apex of the pyramids on the cutting surface,
//! so that the section itself contributes nothing: no list of section corners has to be put in
//! order and cells need not be convex. Below a plane the volume is a cubic of the plane's place
//! between two successive corners (Scardovelli & Zaleski, J. Comput. Phys. 164 (2000) 228; Lopez
//! & Hernandez, J. Comput. Phys. 227 (2008) 5939), which is how it is inverted.

use super::corners::Corners;
use granflow_base::{Tensor, Value, Vec3, add, cross, dot, norm, scale, sub};
use granflow_fv::Differentiable;
use granflow_mesh::Mesh;

/// A cell's surface. Reused from cell to cell: it allocates for the largest cell only.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Corners relative to `origin`, m.
    points: Vec<Vec3>,
    /// Number of each corner in the mesh; empty after a clip.
    labels: Vec<u32>,
    /// Corners of the facets, counter-clockwise seen from outside.
    ring: Vec<u32>,
    /// Start of every facet in `ring`, and the end of the last one.
    start: Vec<u32>,
    /// Outward area vectors of the facets, m2.
    area: Vec<Vec3>,
    /// What corners are relative to, m.
    origin: Vec3,
    /// Volume, m3.
    volume: f64,
    /// Pieces of the section's rim, each with the section on its left seen from outside.
    rim: Vec<(Vec3, Vec3)>,
    /// Distinct corner values in order.
    levels: Vec<f64>,
}

/// The surface on which a function has one value, inside a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Area vector, out of the part below, m2.
    pub area: Vec3,
    /// Centroid relative to the body's origin, m.
    pub centre: Vec3,
}

impl Body {
    /// Room for the largest cell of a mesh.
    pub fn reserve(&mut self, corners: &Corners) {
        let [points, ring, facets] = corners.largest_cell;
        self.points.reserve(points.saturating_sub(self.points.len()));
        self.labels.reserve(points.saturating_sub(self.labels.len()));
        self.levels.reserve(points.saturating_sub(self.levels.len()));
        self.ring.reserve(ring.saturating_sub(self.ring.len()));
        self.rim.reserve(ring.saturating_sub(self.rim.len()));
        self.start.reserve((facets + 1).saturating_sub(self.start.len()));
        self.area.reserve(facets.saturating_sub(self.area.len()));
    }

    /// Becomes cell `c` of the mesh, about its centroid.
    pub fn load(&mut self, corners: &Corners, mesh: &Mesh, c: usize) {
        self.origin = mesh.cell_centre[c];
        self.points.clear();
        self.labels.clear();
        self.ring.clear();
        self.start.clear();
        self.start.push(0);
        for (f, sign) in corners.faces_of(mesh, c) {
            for k in corners.facets_of(f) {
                let first = self.ring.len();
                for &p in corners.facet(k) {
                    let known = self.labels.iter().position(|&l| l == p);
                    let local = known.unwrap_or_else(|| {
                        self.labels.push(p);
                        self.points.push(sub(corners.points[p as usize], self.origin));
                        self.labels.len() - 1
                    });
                    self.ring.push(local as u32);
                }
                if sign < 0.0 {
                    self.ring[first..].reverse();
                }
                self.start.push(self.ring.len() as u32);
            }
        }
        self.measure();
    }

    fn measure(&mut self) {
        self.area.clear();
        let mut thrice = 0.0;
        for k in 0..self.start.len() - 1 {
            let ring = &self.ring[self.start[k] as usize..self.start[k + 1] as usize];
            let first = self.points[ring[0] as usize];
            let spoke = |i: usize| sub(self.points[ring[i] as usize], first);
            let twice =
                (1..ring.len() - 1).map(|i| cross(spoke(i), spoke(i + 1))).fold([0.0; 3], add);
            let area = scale(twice, 0.5);
            self.area.push(area);
            thrice += dot(area, first);
        }
        self.volume = thrice / 3.0;
    }

    /// Volume, m3.
    pub fn volume(&self) -> f64 {
        self.volume
    }
    /// Corners relative to [`Self::origin`], m.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }
    /// What corners are relative to, m.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }
    /// The mesh's numbers of the corners.
    pub fn labels(&self) -> &[u32] {
        &self.labels
    }
    /// Corners of every facet, counter-clockwise seen from outside.
    pub fn facets(&self) -> impl Iterator<Item = &[u32]> {
        self.start.windows(2).map(|w| &self.ring[w[0] as usize..w[1] as usize])
    }

    /// The volume where the corner values, linear along edges, are below `level`. `apex` is a
    /// point of the level surface if one is known (relative to the origin).
    pub fn volume_below(&self, level: f64, values: &[f64], apex: Option<Vec3>) -> f64 {
        let apex = apex.unwrap_or_else(|| self.middle_of_section(level, values));
        let mut thrice = 0.0;
        for (ring, &area) in self.facets().zip(&self.area) {
            let below = ring.iter().filter(|&&p| values[p as usize] < level).count();
            if below == ring.len() {
                thrice += dot(area, sub(self.points[ring[0] as usize], apex));
            } else if below > 0 {
                let mut fan = Fan::default();
                clip(ring, &self.points, values, level, |p| fan.push(p), |_, _| {});
                thrice += dot(fan.twice, sub(fan.first, apex)) * 0.5;
            }
        }
        thrice / 3.0
    }

    /// Average of the points where the level crosses edges; the origin if it crosses none. A
    /// crossing near a corner counts little, so that nothing jumps when the level passes it.
    fn middle_of_section(&self, level: f64, values: &[f64]) -> Vec3 {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for ring in self.facets() {
            for (i, &a) in ring.iter().enumerate() {
                let (a, b) = (a as usize, ring[(i + 1) % ring.len()] as usize);
                if (values[a] < level) != (values[b] < level) {
                    let t = (level - values[a]) / (values[b] - values[a]);
                    let w = (t * (1.0 - t)).max(f64::MIN_POSITIVE);
                    let at = crossing(&self.points, values, level, a, b);
                    sum = add(sum, scale(at, w));
                    weight += w;
                }
            }
        }
        if weight > 0.0 { scale(sum, 1.0 / weight) } else { sum }
    }

    /// The level surface itself, none where it has no area.
    pub fn section(&mut self, level: f64, values: &[f64]) -> Option<Section> {
        let mut rim = std::mem::take(&mut self.rim);
        rim.clear();
        for ring in self.facets() {
            clip(ring, &self.points, values, level, |_| {}, |out, back| rim.push((back, out)));
        }
        let section = section_of(&rim);
        self.rim = rim;
        section
    }

    /// Mean of `d d` over the level surface, with d from its centroid, m2; null where it has no area.
    pub fn spread(&mut self, level: f64, values: &[f64]) -> Tensor {
        let Some(section) = self.section(level, values) else { return [0.0; 9] };
        let (mut weight, mut sum) = (0.0, [0.0; 9]);
        for &(a, b) in &self.rim {
            // Of a triangle with one corner at the centroid: (a a + b b + (a + b)(a + b))/12.
            let (a, b) = (sub(a, section.centre), sub(b, section.centre));
            let w = dot(cross(a, b), section.area);
            let both = add(a, b);
            weight += w;
            for (x, k) in [(a, w), (b, w), (both, w)] {
                sum = sum.axpy(k / 12.0, Vec3::dyad(x, x));
            }
        }
        sum.scaled(1.0 / weight)
    }

    /// The level below which lies the share `fraction` of the volume. With `plane`, the values
    /// are `normal . point` of that normal, and the level is exact; otherwise the surface between
    /// the edges is a fan, whose volume is matched by iteration to 1e-14 of the body.
    pub fn find_level(&mut self, values: &[f64], plane: Option<Vec3>, fraction: f64) -> f64 {
        let mut levels = std::mem::take(&mut self.levels);
        levels.clear();
        levels.extend_from_slice(values);
        levels.sort_unstable_by(f64::total_cmp);
        let level = self.invert(values, plane, fraction, &levels);
        self.levels = levels;
        level
    }

    fn invert(&self, v: &[f64], plane: Option<Vec3>, fraction: f64, levels: &[f64]) -> f64 {
        let target = fraction * self.volume;
        let below = |level: f64| self.volume_below(level, v, plane.map(|n| scale(n, level)));
        let (mut lo, mut hi) = (0, levels.len() - 1);
        let (mut v_lo, mut v_hi) = (0.0, self.volume);
        while hi - lo > 1 {
            let mid = usize::midpoint(lo, hi);
            let v_mid = below(levels[mid]);
            if v_mid < target {
                (lo, v_lo) = (mid, v_mid);
            } else {
                (hi, v_hi) = (mid, v_mid);
            }
        }
        let (mut a, mut b) = (levels[lo], levels[hi]);
        let size = levels[levels.len() - 1] - levels[0];
        if b - a <= 1e-15 * size {
            return 0.5 * (a + b);
        }
        // The cubic through four points, exact for planes.
        let at = |t: f64| a + t * (b - a);
        let t = invert_cubic([v_lo, below(at(1.0 / 3.0)), below(at(2.0 / 3.0)), v_hi], target);
        let (mut fa, mut fb) = (v_lo - target, v_hi - target);
        let mut x = at(t);
        // What rounding left, and what the surface lacks in flatness: bracketed false position
        // (Dowell & Jarratt, BIT 11 (1971) 168).
        let mut last_side = 0.0;
        for _ in 0..100 {
            let fx = below(x) - target;
            if fx.abs() <= 1e-14 * self.volume || b - a <= 1e-15 * size {
                break;
            }
            // An end that stays twice loses weight, or it would stay for ever.
            let stays = fx.signum() == last_side;
            if fx < 0.0 {
                fb *= if stays { fa / (fa + fx) } else { 1.0 };
                (a, fa) = (x, fx);
            } else {
                fa *= if stays { fb / (fb + fx) } else { 1.0 };
                (b, fb) = (x, fx);
            }
            last_side = fx.signum();
            let next = (a * fb - b * fa) / (fb - fa);
            x = if next > a && next < b { next } else { 0.5 * (a + b) };
        }
        x
    }

    /// Keeps the part where `normal . (x - through) < 0` (`through` as a point of the mesh).
    pub fn clip_by(&mut self, normal: Vec3, through: Vec3) {
        let level = dot(normal, sub(through, self.origin));
        let values: Vec<f64> = self.points.iter().map(|&p| dot(normal, p)).collect();
        let (mut points, mut ring, mut start) = (Vec::new(), Vec::new(), vec![0u32]);
        let mut rim = Vec::new();
        for old in self.facets() {
            let first = points.len();
            clip(old, &self.points, &values, level, |p| points.push(p), |o, b| rim.push((b, o)));
            if points.len() - first >= 3 {
                ring.extend(first as u32..points.len() as u32);
                start.push(ring.len() as u32);
            }
        }
        let middle = rim.iter().fold([0.0; 3], |s, &(a, _)| add(s, a));
        let middle = scale(middle, 1.0 / rim.len().max(1) as f64);
        for &(a, b) in &rim {
            let first = points.len() as u32;
            points.extend([middle, a, b]);
            ring.extend(first..first + 3);
            start.push(ring.len() as u32);
        }
        (self.points, self.ring, self.start) = (points, ring, start);
        self.labels.clear();
        self.measure();
    }
}

/// Area of a polygon whose corners come one by one.
#[derive(Clone, Copy, Default)]
pub(super) struct Fan {
    pub(super) first: Vec3,
    last: Vec3,
    /// Twice the area vector.
    pub(super) twice: Vec3,
    count: u32,
}

impl Fan {
    #[inline]
    pub(super) fn push(&mut self, p: Vec3) {
        if self.count == 0 {
            self.first = p;
        } else {
            let spoke = sub(p, self.first);
            self.twice = add(self.twice, cross(self.last, spoke));
            self.last = spoke;
        }
        self.count += 1;
    }
}

/// Where the level crosses the edge from `a` to `b`. The lower corner comes first in the formula,
/// so that both facets of an edge get the same bits.
#[inline]
fn crossing(points: &[Vec3], values: &[f64], level: f64, a: usize, b: usize) -> Vec3 {
    let (a, b) = if values[a] < values[b] { (a, b) } else { (b, a) };
    let t = (level - values[a]) / (values[b] - values[a]);
    add(points[a], scale(sub(points[b], points[a]), t))
}

/// Corners of the part of a facet below `level`, in order, and each piece of its rim on the level
/// surface: `rim(where the facet's edge leaves the part, where it comes back)`.
#[inline]
pub(super) fn clip(
    ring: &[u32],
    points: &[Vec3],
    values: &[f64],
    level: f64,
    mut corner: impl FnMut(Vec3),
    mut rim: impl FnMut(Vec3, Vec3),
) {
    let (mut left, mut first_return) = (None, None);
    for (i, &a) in ring.iter().enumerate() {
        let (a, b) = (a as usize, ring[if i + 1 < ring.len() { i + 1 } else { 0 }] as usize);
        let (a_below, b_below) = (values[a] < level, values[b] < level);
        if a_below {
            corner(points[a]);
        }
        if a_below != b_below {
            let x = crossing(points, values, level, a, b);
            corner(x);
            if a_below {
                left = Some(x);
            } else {
                match left.take() {
                    Some(out) => rim(out, x),
                    None => first_return = Some(x),
                }
            }
        }
    }
    if let (Some(out), Some(back)) = (left, first_return) {
        rim(out, back);
    }
}

fn section_of(rim: &[(Vec3, Vec3)]) -> Option<Section> {
    if rim.len() < 3 {
        return None;
    }
    let middle = rim.iter().fold([0.0; 3], |s, &(a, b)| add(s, add(a, b)));
    let middle = scale(middle, 0.5 / rim.len() as f64);
    let twice = |&(a, b): &(Vec3, Vec3)| cross(sub(a, middle), sub(b, middle));
    let area = scale(rim.iter().map(twice).fold([0.0; 3], add), 0.5);
    let size = norm(area);
    if size <= f64::MIN_POSITIVE {
        return None;
    }
    let (mut weight, mut moment) = (0.0, [0.0; 3]);
    for e in rim {
        let w = dot(twice(e), area);
        let arms = add(sub(e.0, middle), sub(e.1, middle));
        weight += w;
        moment = add(moment, scale(arms, w / 3.0));
    }
    Some(Section { area, centre: add(middle, scale(moment, 1.0 / weight)) })
}

/// Where in 0..1 the cubic through `v` at 0, 1/3, 2/3 and 1 takes the value `target`; `v` ascends.
fn invert_cubic(v: [f64; 4], target: f64) -> f64 {
    // Newton's form in s = 3 t.
    let (d1, d2) = (v[1] - v[0], (v[2] - 2.0 * v[1] + v[0]) / 2.0);
    let d3 = (v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0]) / 6.0;
    let value = |s: f64| v[0] + s * (d1 + (s - 1.0) * (d2 + (s - 2.0) * d3)) - target;
    let slope = |s: f64| d1 + d2 * (2.0 * s - 1.0) + d3 * ((3.0 * s - 6.0) * s + 2.0);
    let (mut a, mut b) = (0.0, 3.0);
    let span = v[3] - v[0];
    let mut s = if span > 0.0 { 3.0 * (target - v[0]) / span } else { 1.5 };
    for _ in 0..60 {
        let f = value(s);
        if f < 0.0 {
            a = s;
        } else {
            b = s;
        }
        let next = s - f / slope(s);
        let next = if next > a && next < b { next } else { 0.5 * (a + b) };
        if (next - s).abs() <= 1e-16 * next.abs() {
            break;
        }
        s = next;
    }
    s / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_base::unit;
    use granflow_mesh::{PolyMesh, shapes};
    use proptest::prelude::*;

    fn bodies(poly: &PolyMesh) -> Vec<Body> {
        let mesh = Mesh::new(poly).expect("a sound mesh");
        let corners = Corners::new(poly, &mesh);
        let load = |c| {
            let mut b = Body::default();
            b.load(&corners, &mesh, c);
            b
        };
        (0..mesh.n_cells).map(load).collect()
    }

    proptest! {
        /// Hexahedra, prisms, warped cells: the plane that is found has the share below it.
        #[test]
        fn planes_match_volumes(
            n in prop::array::uniform3(-1.0f64..1.0), lg in -9.0f64..0.0, high: bool,
        ) {
            let n = unit(n);
            prop_assume!(norm(n) > 0.5);
            let share = if high { 1.0 - 0.5 * 10f64.powf(lg) } else { 0.5 * 10f64.powf(lg) };
            let hexes = shapes::unit_box([2, 2, 2]);
            for poly in [
                shapes::displaced(&shapes::unit_box([3, 3, 3]), 0.2, 7),
                shapes::prism_box([2, 2, 2], [0.0; 3], [1.0; 3], shapes::all(
                    granflow_mesh::PatchKind::Wall)),
                shapes::tetrahedron(), hexes,
            ] {
                for b in &mut bodies(&poly) {
                    let values: Vec<f64> = b.points().iter().map(|&p| dot(n, p)).collect();
                    let level = b.find_level(&values, Some(n), share);
                    let got = b.volume_below(level, &values, Some(scale(n, level))) / b.volume();
                    prop_assert!((got - share).abs() < 1e-13, "{got} for {share}");
                    // The section closes the surface of what is below.
                    let s = b.section(level, &values).expect("a cut");
                    prop_assert!(norm(sub(unit(s.area), n)) < 1e-6);
                    prop_assert!((dot(n, s.centre) - level).abs() < 1e-12);
                    let mut part = b.clone();
                    part.clip_by(n, add(b.origin(), scale(n, level)));
                    prop_assert!((part.volume() / b.volume() - share).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn a_corner_of_the_cube_is_a_tetrahedron() {
        let mut b = bodies(&shapes::unit_box([1, 1, 1])).remove(0);
        let n = unit([1.0; 3]);
        let values: Vec<f64> = b.points().iter().map(|&p| dot(n, p)).collect();
        // The plane through three corners of the cube cuts off 1/6.
        let level = b.find_level(&values, Some(n), 1.0 / 6.0);
        assert!((level + 0.5 / 3f64.sqrt()).abs() < 1e-14);
        let s = b.section(level, &values).expect("a cut");
        assert!((norm(s.area) - 0.75f64.sqrt()).abs() < 1e-14);
        assert!(norm(sub(add(s.centre, b.origin()), [1.0 / 3.0; 3])) < 1e-14);
    }
}
