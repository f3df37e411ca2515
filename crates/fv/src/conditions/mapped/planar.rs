//! From points near a plane to other points near it.

use granflow_base::{Value, Vec3, cross, dot, norm, scale, sub, unit};

/// Points and weights that make a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stencil {
    points: [u32; 3],
    weights: [f64; 3],
}

impl Stencil {
    fn one(point: usize) -> Stencil {
        Stencil { points: [point as u32; 3], weights: [1.0, 0.0, 0.0] }
    }
    /// The value of `values` there.
    pub(super) fn value<T: Value>(&self, values: &[T]) -> T {
        let each = self.points.iter().zip(self.weights);
        each.fold(T::ZERO, |sum, (p, w)| sum.axpy(w, values[*p as usize]))
    }
}

/// For every target the nearest of `points`, of which there is at least one.
pub(super) fn nearest(points: &[Vec3], targets: &[Vec3]) -> Vec<Stencil> {
    let one = |x: &Vec3| {
        let far = |p: &usize| norm(sub(points[*p], *x));
        let near = (0..points.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
        Stencil::one(near.unwrap_or(0))
    };
    targets.iter().map(one).collect()
}

/// For every target the corners of the triangle around it, in the plane that the points span; beyond
/// them what is nearest on their edge. Points on a line: the two around the target.
pub(super) fn linear(points: &[Vec3], targets: &[Vec3]) -> Vec<Stencil> {
    let Some((origin, along)) = longest(points) else { return nearest(points, targets) };
    let from = |x: &Vec3| sub(*x, origin);
    let aside = |x: &Vec3| cross(along, from(x));
    let widest = points.iter().map(aside).max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
    let length = points.iter().map(|x| norm(from(x))).fold(0.0, f64::max);
    let normal = widest.filter(|n| norm(*n) > 1e-9 * length).map(unit);
    let Some(normal) = normal else {
        let s = |x: &Vec3| dot(from(x), along);
        return on_a_line(&points.iter().map(s).collect::<Vec<_>>(), targets.iter().map(s));
    };
    let across = cross(normal, along);
    let flat = |x: &Vec3| delaunator::Point { x: dot(from(x), along), y: dot(from(x), across) };
    let flat_points: Vec<_> = points.iter().map(flat).collect();
    let triangles = delaunator::triangulate(&flat_points).triangles;
    let corners: Vec<[usize; 3]> = triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    targets.iter().map(|x| in_triangles(&flat_points, &corners, &flat(x))).collect()
}

/// The first point and the direction from it to the farthest one.
fn longest(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let origin = *points.first()?;
    let arms = points.iter().map(|x| sub(*x, origin));
    let far = arms.max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
    (norm(far) > 0.0).then(|| (origin, scale(far, 1.0 / norm(far))))
}

fn on_a_line(points: &[f64], targets: impl Iterator<Item = f64>) -> Vec<Stencil> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a].total_cmp(&points[*b]));
    let one = |s: f64| {
        let k = order.partition_point(|p| points[*p] <= s);
        let (Some(&a), Some(&b)) = (k.checked_sub(1).and_then(|k| order.get(k)), order.get(k))
        else {
            return Stencil::one(order[k.min(order.len() - 1)]);
        };
        let share = (s - points[a]) / (points[b] - points[a]);
        Stencil { points: [a as u32, b as u32, b as u32], weights: [1.0 - share, share, 0.0] }
    };
    targets.map(one).collect()
}

/// The stencil of `x`: in the triangle it lies in, or on the nearest side of any.
fn in_triangles(
    points: &[delaunator::Point],
    triangles: &[[usize; 3]],
    x: &delaunator::Point,
) -> Stencil {
    let mut best = (f64::INFINITY, Stencil::one(0));
    for corners in triangles {
        let [a, b, c] = corners.map(|p| &points[p]);
        let twice = |p: &delaunator::Point, q: &delaunator::Point, r: &delaunator::Point| {
            (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x)
        };
        let whole = twice(a, b, c);
        if whole == 0.0 {
            continue;
        }
        let points_of = corners.map(|p| p as u32);
        let weights = [twice(x, b, c) / whole, twice(a, x, c) / whole, twice(a, b, x) / whole];
        if weights.iter().all(|w| *w >= 0.0) {
            return Stencil { points: points_of, weights };
        }
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let (p, q) = (&points[corners[i]], &points[corners[j]]);
            let (dx, dy) = (q.x - p.x, q.y - p.y);
            let along = ((x.x - p.x) * dx + (x.y - p.y) * dy) / (dx * dx + dy * dy);
            let share = along.clamp(0.0, 1.0);
            let far = (x.x - p.x - share * dx).hypot(x.y - p.y - share * dy);
            if far < best.0 {
                let mut weights = [0.0; 3];
                (weights[i], weights[j]) = (1.0 - share, share);
                best = (far, Stencil { points: points_of, weights });
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(points: &[Vec3], values: &[f64], x: Vec3) -> f64 {
        linear(points, &[x])[0].value(values)
    }

    #[test]
    fn a_plane_is_met_inside_and_held_at_the_edge_outside() {
        // A plane that leans, points a little off it.
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let values: Vec<f64> = points.iter().map(|p| 2.0 + 3.0 * p[0] - p[1]).collect();
        for x in [[0.5, 0.25, 0.5], [0.1, 0.9, 0.1], [1.0, 1.0, 1.0]] {
            let found = at(&points, &values, x);
            assert!((found - (2.0 + 3.0 * x[0] - x[1])).abs() < 1e-12, "{x:?} {found}");
        }
        let beyond = at(&points, &values, [0.25, 2.0, 0.25]);
        assert!((beyond - (2.0 + 0.75 - 1.0)).abs() < 1e-12, "{beyond}");
    }

    #[test]
    fn points_on_a_line_and_a_single_point() {
        let points = [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let found: Vec<f64> =
            [-1.0, 0.5, 1.75, 9.0].map(|y| at(&points, &[5.0, 1.0, 2.0], [0.3, y, 0.0])).to_vec();
        assert_eq!(found, [1.0, 1.5, 4.25, 5.0]);
        assert_eq!(at(&[[1.0; 3]], &[7.0], [0.0; 3]), 7.0);
    }
}
