//! Numbers on contour lines: where they stand.

use super::canvas::{Box2, Point};

/// Where along a line a label is tried, in shares of its length.
const PLACES: [f64; 9] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9];

/// A box of `size` on the longest of some lines, within the frame and off the boxes that are
/// `taken`; none on a line that is hardly longer than the box.
pub(super) fn room(
    lines: &[Vec<Point>],
    size: (f64, f64),
    frame: &Box2,
    taken: &[Box2],
) -> Option<Box2> {
    let length = |line: &&Vec<Point>| line.windows(2).map(|w| apart(w[0], w[1])).sum::<f64>();
    let longest = lines.iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
    let whole = length(&longest);
    if whole < 2.5 * size.0 {
        return None;
    }
    PLACES
        .into_iter()
        .filter_map(|share| along(longest, share * whole))
        .map(|(x, y)| Box2 {
            left: x - 0.5 * size.0,
            right: x + 0.5 * size.0,
            top: y - 0.5 * size.1,
            bottom: y + 0.5 * size.1,
        })
        .find(|b| {
            let inside = frame.contains((b.left, b.top)) && frame.contains((b.right, b.bottom));
            let meets = |o: &Box2| {
                b.left < o.right && o.left < b.right && b.top < o.bottom && o.top < b.bottom
            };
            inside && !taken.iter().any(|o| meets(&o.grown(3.0)))
        })
}

fn apart(a: Point, b: Point) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

/// The point at a distance along a line.
fn along(line: &[Point], mut left: f64) -> Option<Point> {
    for w in line.windows(2) {
        let step = apart(w[0], w[1]);
        if left <= step && step > 0.0 {
            let t = left / step;
            return Some((w[0].0 + t * (w[1].0 - w[0].0), w[0].1 + t * (w[1].1 - w[0].1)));
        }
        left -= step;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_on_their_line_and_off_each_other() {
        let frame = Box2 { left: 0.0, top: 0.0, right: 100.0, bottom: 100.0 };
        let lines = [vec![(0.0, 50.0), (40.0, 50.0), (100.0, 50.0)], vec![(0.0, 0.0), (9.0, 0.0)]];
        let first = room(&lines, (20.0, 10.0), &frame, &[]).unwrap();
        assert_eq!(first, Box2 { left: 40.0, right: 60.0, top: 45.0, bottom: 55.0 });
        let second = room(&lines, (20.0, 10.0), &frame, &[first]).unwrap();
        assert_eq!(second, Box2 { left: 10.0, right: 30.0, top: 45.0, bottom: 55.0 });
        assert!(room(&lines[1..], (20.0, 10.0), &frame, &[]).is_none(), "too short");
        assert!(room(&lines, (20.0, 120.0), &frame, &[]).is_none(), "no room");
    }
}
