//! Contour lines: segments in triangles, joined.

use super::Piece;
use std::collections::HashMap;

type Place = (f64, f64);

/// Where `v[slot]` is `level` in triangles, seen through `flat`.
pub(crate) fn level_segments(
    pieces: &[Piece],
    slot: usize,
    level: f64,
    flat: impl Fn(granflow_base::Vec3) -> Place,
) -> Vec<(Place, Place)> {
    let mut out = Vec::new();
    for piece in pieces {
        let c = &piece.corners;
        let over = c.map(|c| c.v[slot] - level);
        let mut ends = [(0.0, 0.0); 2];
        let mut n = 0;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if (over[i] >= 0.0) != (over[j] >= 0.0) && n < 2 {
                ends[n] = flat(super::crossing(&c[i], &c[j], over[i], over[j]).at);
                n += 1;
            }
        }
        if n == 2 {
            out.push((ends[0], ends[1]));
        }
    }
    out
}

/// Joins segments whose ends are nearer than `near`.
pub(crate) fn chain(segments: &[(Place, Place)], near: f64) -> Vec<Vec<Place>> {
    let key = |p: Place| ((p.0 / near).round() as i64, (p.1 / near).round() as i64);
    let segments: Vec<_> = segments.iter().filter(|(a, b)| key(*a) != key(*b)).collect();
    let mut at: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    for (i, (a, b)) in segments.iter().enumerate() {
        at.entry(key(*a)).or_default().push(i);
        at.entry(key(*b)).or_default().push(i);
    }
    let mut used = vec![false; segments.len()];
    let walk = |from: Place, used: &mut Vec<bool>| {
        let mut line = Vec::new();
        let mut end = from;
        while let Some(i) = at.get(&key(end)).and_then(|v| v.iter().find(|i| !used[**i])) {
            used[*i] = true;
            let (a, b) = *segments[*i];
            end = if key(a) == key(end) { b } else { a };
            line.push(end);
        }
        line
    };
    let mut out = Vec::new();
    for i in 0..segments.len() {
        if used[i] {
            continue;
        }
        used[i] = true;
        let (a, b) = *segments[i];
        let ahead = walk(b, &mut used);
        let mut line = walk(a, &mut used);
        line.reverse();
        line.extend([a, b]);
        line.extend(ahead);
        out.push(line);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_in_any_order_and_direction_are_one_line() {
        let p = |i: i32| (f64::from(i), 0.1 * f64::from(i));
        let s = [(p(2), p(1)), (p(3), p(4)), (p(0), p(1)), (p(2), p(3)), (p(7), p(8))];
        let mut lines = chain(&s, 1e-6);
        lines.sort_by_key(Vec::len);
        assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 5]);
        let xs: Vec<f64> = lines[1].iter().map(|q| q.0).collect();
        assert!(xs.windows(2).all(|w| (w[1] - w[0]).abs() == 1.0), "{xs:?}");
    }
}
