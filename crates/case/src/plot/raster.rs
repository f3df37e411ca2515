//! Pixels of our own for fields and surfaces: triangles in depth order, lines, twice as fine as
//! the picture in both directions, so that edges come out smooth.

use super::Rgb;
use super::canvas::{Box2, Point};

/// Pixels per unit of the page in figures of fields.
pub(super) const PIXELS: f64 = 2.0;
/// Samples a pixel has along each direction.
const FINE: usize = 2;

/// A place on the page with its depth: right, down, away from the eye.
pub(super) type Deep = [f64; 3];

/// A picture under construction, in samples; white where nothing is drawn.
pub(super) struct Raster {
    width: usize,
    height: usize,
    /// Samples per unit of the page.
    fine: f64,
    /// What lies outside is not drawn, in samples.
    window: Box2,
    rgb: Vec<[u8; 3]>,
    depth: Vec<f32>,
}

impl Raster {
    /// A white page of `size` units at `scale` pixels per unit.
    pub(super) fn new(size: (f64, f64), scale: f64) -> Raster {
        // As the rasteriser of text and lines rounds.
        let pixels = |units: f64| (units * scale).round().max(1.0) as usize * FINE;
        let (width, height) = (pixels(size.0), pixels(size.1));
        let right = width as f64;
        let window = Box2 { left: 0.0, top: 0.0, right, bottom: height as f64 };
        let (rgb, depth) = (vec![[255; 3]; width * height], vec![f32::INFINITY; width * height]);
        Raster { width, height, fine: scale * FINE as f64, window, rgb, depth }
    }

    /// Confines drawing to a rectangle of the page.
    pub(super) fn confine(&mut self, to: Box2) {
        let f = |v: f64| v * self.fine;
        self.window =
            Box2 { left: f(to.left), top: f(to.top), right: f(to.right), bottom: f(to.bottom) };
    }

    /// Allows drawing everywhere again.
    pub(super) fn release(&mut self) {
        self.window.left = 0.0;
        self.window.top = 0.0;
        self.window.right = self.width as f64;
        self.window.bottom = self.height as f64;
    }

    /// Columns and rows of samples that a box of samples covers.
    fn covered(&self, b: Box2) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let w = &self.window;
        let from = |v: f64, lo: f64| (v.max(lo) - 0.5).ceil().max(0.0) as usize;
        let to = |v: f64, hi: f64, n: usize| {
            (((v.min(hi) - 0.5).floor() + 1.0).max(0.0) as usize).min(n)
        };
        (
            from(b.left, w.left)..to(b.right, w.right, self.width),
            from(b.top, w.top)..to(b.bottom, w.bottom, self.height),
        )
    }

    /// A triangle; `paint` gives the colour from the shares of the three corners. An opaque one
    /// (`opacity` 1) hides what is behind it, another one lets it through. Triangles that share
    /// an edge cover every sample on it once.
    pub(super) fn triangle(
        &mut self,
        corners: [Deep; 3],
        opacity: f64,
        paint: impl Fn([f64; 3]) -> Rgb,
    ) {
        let c = corners.map(|p| [p[0] * self.fine, p[1] * self.fine, p[2]]);
        if c.iter().flatten().any(|v| !v.is_finite()) {
            return;
        }
        let sides = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| Side::new(c[i], c[j]));
        let area = sides[2].over(sides[2].row(c[2][1]), c[2][0]);
        if area == 0.0 {
            return;
        }
        let ends = |k: usize| {
            let v = [c[0][k], c[1][k], c[2][k]];
            (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]))
        };
        let ((left, right), (top, bottom)) = (ends(0), ends(1));
        let (_, rows) = self.covered(Box2 { left, top, right, bottom });
        for row in rows {
            let y = row as f64 + 0.5;
            let (left, right) = sides.iter().fold((right, left), |e, s| s.widen(e, y));
            // Rounding may take a sample from either end, so one more of each is looked at.
            let (left, right) = (left - 1.0, right + 1.0);
            let (columns, _) = self.covered(Box2 { left, top, right, bottom });
            let rows_of = [0, 1, 2].map(|k| sides[k].row(y));
            for column in columns {
                let x = column as f64 + 0.5;
                let over = [0, 1, 2].map(|k| sides[k].over(rows_of[k], x));
                let inside = |k: usize| {
                    let v = over[k] * area.signum();
                    v > 0.0 || (v == 0.0 && sides[k].forward == (area > 0.0))
                };
                if !(inside(0) && inside(1) && inside(2)) {
                    continue;
                }
                let share = [over[0] / area, over[1] / area, over[2] / area];
                let depth = (0..3).map(|k| share[k] * c[k][2]).sum::<f64>() as f32;
                let at = row * self.width + column;
                if depth > self.depth[at] {
                    continue;
                }
                blend(&mut self.rgb[at], paint(share), opacity);
                if opacity >= 1.0 {
                    self.depth[at] = depth;
                }
            }
        }
    }

    /// A straight line over everything that is not nearer by more than `slack`.
    pub(super) fn segment(&mut self, a: Deep, b: Deep, colour: Rgb, width: f64, slack: f64) {
        let [a, b] = [a, b].map(|p| [p[0] * self.fine, p[1] * self.fine, p[2]]);
        if a.iter().chain(&b).any(|v| !v.is_finite()) {
            return;
        }
        let half = 0.5 * width * self.fine;
        let reach = half + 0.5;
        let (columns, rows) = self.covered(Box2 {
            left: a[0].min(b[0]) - reach,
            right: a[0].max(b[0]) + reach,
            top: a[1].min(b[1]) - reach,
            bottom: a[1].max(b[1]) + reach,
        });
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length2 = dx * dx + dy * dy;
        for row in rows {
            let y = row as f64 + 0.5 - a[1];
            for column in columns.clone() {
                let x = column as f64 + 0.5 - a[0];
                let t =
                    if length2 > 0.0 { ((x * dx + y * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
                let off = (x - t * dx).hypot(y - t * dy);
                let at = row * self.width + column;
                let depth = (a[2] + t * (b[2] - a[2]) - slack) as f32;
                if off < reach && depth <= self.depth[at] {
                    blend(&mut self.rgb[at], colour, (half + 0.5 - off).min(1.0));
                }
            }
        }
    }

    /// A polyline over everything.
    pub(super) fn stroke(&mut self, points: &[Point], colour: Rgb, width: f64) {
        for w in points.windows(2) {
            let deep = |p: Point| [p.0, p.1, 0.0];
            self.segment(deep(w[0]), deep(w[1]), colour, width, f64::MAX);
        }
    }

    /// A white rectangle over everything.
    pub(super) fn blank(&mut self, b: Box2) {
        let f = |v: f64| v * self.fine;
        let b = Box2 { left: f(b.left), top: f(b.top), right: f(b.right), bottom: f(b.bottom) };
        let (columns, rows) = self.covered(b);
        for row in rows {
            let first = row * self.width;
            self.rgb[first + columns.start..first + columns.end.max(columns.start)].fill([255; 3]);
        }
    }

    /// Width, height and the pixels, row by row.
    pub(super) fn pixels(&self) -> (usize, usize, Vec<u8>) {
        let (w, h) = (self.width / FINE, self.height / FINE);
        let mut out = Vec::with_capacity(3 * w * h);
        for row in 0..h {
            for column in 0..w {
                for k in 0..3 {
                    let mut sum = 0;
                    for i in 0..FINE {
                        let at = (row * FINE + i) * self.width + column * FINE;
                        sum += self.rgb[at..at + FINE]
                            .iter()
                            .map(|c| usize::from(c[k]))
                            .sum::<usize>();
                    }
                    let samples = FINE * FINE;
                    out.push(((sum + samples / 2) / samples) as u8);
                }
            }
        }
        (w, h, out)
    }
}

/// A side of a triangle. What it says of a point is the same to the bit, but for the sign,
/// whichever way the side is gone.
struct Side {
    /// The first of its ends in a fixed order, and from there to the other one.
    from: [f64; 2],
    step: [f64; 2],
    /// Whether it is gone in that order. It decides who owns a point on it.
    forward: bool,
}

impl Side {
    fn new(a: Deep, b: Deep) -> Side {
        let forward = (a[0], a[1]) <= (b[0], b[1]);
        let (p, q) = if forward { (a, b) } else { (b, a) };
        Side { from: [p[0], p[1]], step: [q[0] - p[0], q[1] - p[1]], forward }
    }

    /// What all points of a row have in common.
    fn row(&self, y: f64) -> f64 {
        self.step[0] * (y - self.from[1])
    }

    /// Twice the area of the triangle with a point of a row.
    fn over(&self, row: f64, x: f64) -> f64 {
        let area = row - self.step[1] * (x - self.from[0]);
        if self.forward { area } else { -area }
    }

    /// An interval that holds the place where the side crosses a row, too.
    fn widen(&self, (left, right): (f64, f64), y: f64) -> (f64, f64) {
        let t = (y - self.from[1]) / self.step[1];
        if !(0.0..=1.0).contains(&t) {
            return (left, right);
        }
        let x = self.from[0] + t * self.step[0];
        (left.min(x), right.max(x))
    }
}

fn blend(under: &mut [u8; 3], colour: Rgb, opacity: f64) {
    let o = opacity.clamp(0.0, 1.0);
    for (u, c) in under.iter_mut().zip([colour.0, colour.1, colour.2]) {
        *u = (f64::from(*u) + o * (f64::from(c) - f64::from(*u))).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = Rgb(200, 0, 0);
    const BLUE: Rgb = Rgb(0, 0, 200);

    fn pixel(picture: &(usize, usize, Vec<u8>), x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (y * picture.0 + x);
        [picture.2[at], picture.2[at + 1], picture.2[at + 2]]
    }

    #[test]
    fn the_nearer_one_hides_and_the_translucent_one_does_not() {
        let mut r = Raster::new((20.0, 20.0), 1.0);
        let corners = |z: f64| [[0.0, 0.0, z], [20.0, 0.0, z], [0.0, 20.0, z]];
        r.triangle(corners(1.0), 1.0, |_| RED);
        r.triangle(corners(2.0), 1.0, |_| BLUE);
        r.triangle([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]], 0.5, |_| BLUE);
        let picture = r.pixels();
        assert_eq!(pixel(&picture, 8, 3), [200, 0, 0]);
        assert_eq!(pixel(&picture, 1, 1), [100, 0, 100]);
        assert_eq!(pixel(&picture, 18, 18), [255; 3]);
    }

    #[test]
    fn neighbours_cover_their_edge_once() {
        // Corners in the middle of samples, so that edges run exactly through some.
        let at = |x: f64, y: f64| [x + 0.25, y + 0.25, 0.0];
        let (a, b, c, d) = (at(1.0, 1.0), at(15.0, 1.0), at(15.0, 15.0), at(1.0, 15.0));
        for pair in [[[a, b, c], [a, c, d]], [[b, a, c], [d, c, a]], [[a, b, d], [b, c, d]]] {
            let mut r = Raster::new((20.0, 20.0), 1.0);
            pair.into_iter().for_each(|t| r.triangle(t, 0.5, |_| Rgb(0, 0, 0)));
            let picture = r.pixels();
            for i in 2..15 {
                for j in 2..15 {
                    assert_eq!(pixel(&picture, i, j), [128; 3], "{i} {j} {pair:?}");
                }
            }
        }
    }

    #[test]
    fn lines_are_as_wide_as_asked_for_and_hidden_by_what_is_nearer() {
        let mut r = Raster::new((20.0, 20.0), 2.0);
        r.triangle([[10.0, 0.0, 1.0], [30.0, 0.0, 1.0], [10.0, 30.0, 1.0]], 1.0, |_| RED);
        r.segment([0.0, 10.0, 2.0], [20.0, 10.0, 2.0], Rgb::BLACK, 2.0, 0.1);
        let picture = r.pixels();
        let column: Vec<u8> = (0..40).map(|y| pixel(&picture, 8, y)[0]).collect();
        let ink: f64 = column.iter().map(|v| (255.0 - f64::from(*v)) / 255.0).sum();
        assert!((ink - 4.0).abs() < 0.1, "{ink}");
        assert_eq!(pixel(&picture, 24, 20), [200, 0, 0]);
    }
}
