//! Courses of block edges.

use granflow_base::{Vec3, add, apply, cross, dot, norm, rotation_about, scale, sub, unit};

/// How an edge runs between its two vertices.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A circular arc through a point, m.
    Arc(Vec3),
    /// Straight pieces through points, m.
    PolyLine(Vec<Vec3>),
    /// A Catmull-Rom spline through points, m.
    Spline(Vec<Vec3>),
    /// A uniform cubic B-spline with these control points beside the two ends, m. It passes its
    /// ends, beyond which the control points go on by point reflection.
    BSpline(Vec<Vec3>),
}

/// What runs between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    Straight,
    CatmullRom,
    BSpline,
}

/// A curve with its end points, ready to be evaluated.
pub(super) enum Course {
    Line([Vec3; 2]),
    Arc { centre: Vec3, arm: Vec3, axis: Vec3, angle: f64 },
    Knots { points: Vec<Vec3>, at: Vec<f64>, basis: Basis },
}

impl Course {
    /// The straight line.
    pub(super) fn line(from: Vec3, to: Vec3) -> Course {
        Course::Line([from, to])
    }

    /// A curve between two points.
    ///
    /// # Errors
    /// What is wrong with it, as the label of a diagnostic.
    pub(super) fn new(curve: &Curve, from: Vec3, to: Vec3) -> Result<Course, String> {
        match curve {
            Curve::Arc(through) => arc(from, *through, to),
            Curve::PolyLine(inner) => knots(from, inner, to, Basis::Straight),
            Curve::Spline(inner) => knots(from, inner, to, Basis::CatmullRom),
            Curve::BSpline(inner) => knots(from, inner, to, Basis::BSpline),
        }
    }

    /// The point at the fraction `t` of the curve, by arc length (of the chords, for a spline).
    pub(super) fn at(&self, t: f64) -> Vec3 {
        match self {
            Course::Line([a, b]) => add(*a, scale(sub(*b, *a), t)),
            Course::Arc { centre, arm, axis, angle } => {
                add(*centre, apply(&rotation_about(*axis, angle * t), *arm))
            }
            Course::Knots { points, at, basis } => {
                if t <= 0.0 {
                    return points[0];
                }
                if t >= 1.0 {
                    return points[points.len() - 1];
                }
                let piece = at.partition_point(|&x| x <= t).clamp(1, at.len() - 1) - 1;
                let s = (t - at[piece]) / (at[piece + 1] - at[piece]);
                let (a, b) = (points[piece], points[piece + 1]);
                // Beyond the ends the curve goes on as its own point reflection.
                let before = if piece > 0 { points[piece - 1] } else { sub(scale(a, 2.0), b) };
                let after = points.get(piece + 2).copied().unwrap_or_else(|| sub(scale(b, 2.0), a));
                match basis {
                    Basis::Straight => add(a, scale(sub(b, a), s)),
                    Basis::CatmullRom => catmull_rom([before, a, b, after], s),
                    Basis::BSpline => b_spline([before, a, b, after], s),
                }
            }
        }
    }
}

/// Catmull & Rom, in Computer Aided Geometric Design (1974): tension 1/2.
fn catmull_rom(p: [Vec3; 4], s: f64) -> Vec3 {
    std::array::from_fn(|d| {
        let [a, b, c, e] = p.map(|q| q[d]);
        0.5 * (2.0 * b
            + s * ((c - a)
                + s * ((2.0 * a - 5.0 * b + 4.0 * c - e) + s * (3.0 * b - a - 3.0 * c + e))))
    })
}

/// One piece of a uniform cubic B-spline; de Boor, A Practical Guide to Splines (1978).
fn b_spline(p: [Vec3; 4], s: f64) -> Vec3 {
    let r = 1.0 - s;
    let weight = [
        r * r * r,
        3.0 * s * s * s - 6.0 * s * s + 4.0,
        3.0 * r * r * r - 6.0 * r * r + 4.0,
        s * s * s,
    ];
    std::array::from_fn(|d| (0..4).map(|k| weight[k] * p[k][d]).sum::<f64>() / 6.0)
}

fn arc(from: Vec3, through: Vec3, to: Vec3) -> Result<Course, String> {
    let (a, b) = (sub(through, from), sub(to, from));
    let normal = cross(a, b);
    let size = norm(a) * norm(b);
    if norm(normal) <= 1e-10 * size || size == 0.0 {
        return Err("the arc's three points lie on one line".into());
    }
    // Circumcentre of a triangle, relative to `from`.
    let (aa, bb, nn) = (dot(a, a), dot(b, b), dot(normal, normal));
    let to_centre = scale(cross(sub(scale(b, aa), scale(a, bb)), normal), -0.5 / nn);
    let centre = add(from, scale(to_centre, -1.0));
    let arm = sub(from, centre);
    let axis = unit(normal);
    let end = sub(to, centre);
    let angle = dot(axis, cross(arm, end)).atan2(dot(arm, end));
    // The short way round, unless the given point lies off to the other side of the start. So a
    // point beyond the end still gives the short arc that OpenFOAM's tool draws; see `passes`.
    let middle = sub(through, centre);
    let same_side = dot(cross(arm, middle), cross(arm, end)) >= 0.0;
    let angle = match (same_side, angle > 0.0) {
        (true, _) => angle,
        (false, true) => angle - std::f64::consts::TAU,
        (false, false) => angle + std::f64::consts::TAU,
    };
    Ok(Course::Arc { centre, arm, axis, angle })
}

/// Whether an arc from `from` to `to` contains the point it was given by.
pub(super) fn passes(from: Vec3, through: Vec3, to: Vec3) -> bool {
    match arc(from, through, to) {
        Ok(Course::Arc { centre, arm, axis, angle }) => {
            let middle = sub(through, centre);
            let at = dot(axis, cross(arm, middle)).atan2(dot(arm, middle));
            let at = if angle > 0.0 { at } else { -at };
            at.rem_euclid(std::f64::consts::TAU) <= angle.abs()
        }
        _ => true,
    }
}

fn knots(from: Vec3, inner: &[Vec3], to: Vec3, basis: Basis) -> Result<Course, String> {
    let points: Vec<Vec3> =
        std::iter::once(from).chain(inner.iter().copied()).chain(std::iter::once(to)).collect();
    let mut at = vec![0.0];
    for pair in points.windows(2) {
        let step = norm(sub(pair[1], pair[0]));
        if step == 0.0 {
            return Err("two successive points of the curve coincide".into());
        }
        at.push(at[at.len() - 1] + step);
    }
    let total = at[at.len() - 1];
    at.iter_mut().for_each(|x| *x /= total);
    Ok(Course::Knots { points, at, basis })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vec3, b: Vec3) -> bool {
        norm(sub(a, b)) < 1e-14
    }

    #[test]
    fn arcs_run_through_their_point_whichever_side_it_is_on() {
        let (from, to) = ([1.0, 0.0, 2.0], [0.0, 1.0, 2.0]);
        let h = 0.5f64.sqrt();
        let short = arc(from, [h, h, 2.0], to).unwrap();
        assert!(close(short.at(0.5), [h, h, 2.0]) && close(short.at(1.0), to));
        let long = arc(from, [-h, -h, 2.0], to).unwrap();
        assert!(close(long.at(0.5), [-h, -h, 2.0]) && close(long.at(0.0), from));
        assert!(arc(from, [0.5, 0.5, 2.0], to).is_err());
        assert!(passes(from, [h, h, 2.0], to) && passes(from, [-h, -h, 2.0], to));
        // Given by a point beyond its end an arc takes the short way.
        let short = arc(from, [-h, h, 2.0], to).unwrap();
        assert!(close(short.at(0.5), [h, h, 2.0]));
        assert!(!passes(from, [-h, h, 2.0], to));
    }

    #[test]
    fn polylines_are_measured_along_their_length() {
        let l = knots([0.0; 3], &[[3.0, 0.0, 0.0]], [3.0, 1.0, 0.0], Basis::Straight).unwrap();
        assert!(close(l.at(0.5), [2.0, 0.0, 0.0]) && close(l.at(0.875), [3.0, 0.5, 0.0]));
    }

    #[test]
    fn splines_pass_their_points_and_keep_straight_lines() {
        let p = [[1.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
        let l = knots([0.0; 3], &p, [3.0, 0.0, 1.0], Basis::CatmullRom).unwrap();
        let Course::Knots { at, .. } = &l else { unreachable!() };
        assert!(close(l.at(at[1]), p[0]) && close(l.at(at[2]), p[1]));
        let l = knots([0.0; 3], &[[1.0, 1.0, 1.0]], [2.0; 3], Basis::CatmullRom).unwrap();
        assert!(close(l.at(0.3), [0.6; 3]));
        let l = knots([0.0; 3], &[[1.0, 1.0, 1.0]], [2.0; 3], Basis::BSpline).unwrap();
        assert!(close(l.at(0.3), [0.6; 3]) && close(l.at(1.0), [2.0; 3]));
    }
}
