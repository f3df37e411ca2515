//! A field over a plane: colours, contour lines, arrows, equal axes.

use super::axis::{Axis, Ruler};
use super::canvas::{Anchor, Box2, Canvas, Point};
use super::frame::{self, Bar, GAP, INK, LABEL_SIZE, Shades, TICK_SIZE, TITLE_SIZE};
use super::raster::{PIXELS, Raster};
use super::{PlotError, Rgb, labels, text};

/// Arrows of a vector field.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Arrows {
    /// Foot and components, both in the plane.
    pub arrows: Vec<((f64, f64), (f64, f64))>,
    /// Length of the longest one, in the unit of the axes.
    pub longest: f64,
    /// Unit behind the number of the key arrow.
    pub unit: String,
}

/// A line in the coordinates of the axes.
pub type Polyline = Vec<(f64, f64)>;

/// A field over a plane. Coordinates are those of the axes, upwards positive.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SliceFigure {
    /// Above the axes; empty for none.
    pub title: String,
    /// Label and range of the horizontal axis.
    pub x: Axis,
    /// Label and range of the vertical axis.
    pub y: Axis,
    /// How values become colours.
    pub shades: Shades,
    /// Triangles of the field: corners and their values.
    pub triangles: Vec<[(f64, f64, f64); 3]>,
    /// Contour lines of the field: level and its pieces.
    pub contours: Vec<(f64, Vec<Polyline>)>,
    /// Heavier lines: contours of other fields.
    pub lines: Vec<Polyline>,
    /// Arrows, if any.
    pub arrows: Option<Arrows>,
    /// Stream lines, each in the direction of the flow.
    pub streams: Vec<Polyline>,
}

/// Most a frame takes of the page.
const MOST: (f64, f64) = (560.0, 520.0);
/// Least height of a colour bar.
const LEAST_BAR: f64 = 150.0;
/// Size of the numbers on contour lines.
const CONTOUR_SIZE: f64 = 13.0;
/// What is left light on either side of arrows and stream lines, so that they are seen on dark colours.
const HALO: f64 = 1.1;

impl SliceFigure {
    /// The figure as SVG (lines and text as such, colours as a picture in it) and as PNG.
    ///
    /// # Errors
    /// When the rasteriser fails.
    pub fn render(&self) -> Result<(String, Vec<u8>), PlotError> {
        let (canvas, pixels) = self.draw();
        canvas.render(pixels)
    }

    fn draw(&self) -> (Canvas, Raster) {
        let layout = Layout::new(self);
        let mut canvas = Canvas::new(layout.page.0, layout.page.1);
        let mut raster = Raster::new(layout.page, PIXELS);
        layout.draw_field(&mut raster, self);
        layout.draw_lines(&mut canvas, self);
        let levels: Vec<f64> = self.contours.iter().map(|c| c.0).collect();
        let middle = 0.5 * (layout.frame.top + layout.frame.bottom);
        let at = (layout.frame.right + GAP, middle - 0.5 * layout.bar_height);
        layout.bar.draw(&mut canvas, &mut raster, at, layout.bar_height, &levels);
        layout.draw_axes(&mut canvas, self);
        (canvas, raster)
    }
}

struct Layout<'a> {
    page: (f64, f64),
    frame: Box2,
    x: Ruler,
    y: Ruler,
    bar: Bar<'a>,
    bar_height: f64,
}

impl<'a> Layout<'a> {
    fn new(figure: &'a SliceFigure) -> Layout<'a> {
        let ends = |of: fn(&(f64, f64, f64)) -> f64, given: Option<(f64, f64)>| {
            let all = figure.triangles.iter().flatten().map(of).filter(|v| v.is_finite());
            let (lo, hi) =
                all.fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| (e.0.min(v), e.1.max(v)));
            let found = if lo < hi { (lo, hi) } else { (0.0, 1.0) };
            given.filter(|(a, b)| a < b).unwrap_or(found)
        };
        let (x, y) = (ends(|p| p.0, figure.x.range), ends(|p| p.1, figure.y.range));
        // Never a needle: axes of a sliver are not equal.
        let aspect = ((x.1 - x.0) / (y.1 - y.0)).clamp(0.08, 20.0);
        let height = MOST.1.min(MOST.0 / aspect);
        let width = aspect * height;
        let ranged = |e: (f64, f64)| Axis::linear("").ranged(e.0, e.1);
        let labels = |room: f64, each: f64| (room / each) as usize;
        let x = Ruler::new(&ranged(x), std::iter::empty(), labels(width, 60.0));
        let y = Ruler::new(&ranged(y), std::iter::empty(), labels(height, 55.0));
        let bar_height = height.max(LEAST_BAR);
        let bar = Bar::new(&figure.shades, bar_height);

        let y_label = if figure.y.label.is_empty() { 0.0 } else { 1.5 * LABEL_SIZE };
        let left = 18.0 + y_label + frame::widest(&y) + 9.0;
        let title = if figure.title.is_empty() { 0.0 } else { 1.6 * TITLE_SIZE };
        let key = if figure.arrows.is_some() { 1.5 * TICK_SIZE } else { 0.0 };
        let power = if y.factor == 0 { 0.0 } else { 1.5 * TICK_SIZE };
        let spare = 0.5 * (bar_height - height);
        let top = 18.0 + title + key.max(power).max(bar.above() + spare);
        let frame = Box2 { left, top, right: left + width, bottom: top + height };
        let x_label = if figure.x.label.is_empty() { 0.0 } else { 1.5 * LABEL_SIZE };
        let x_power = if x.factor == 0 { 0.0 } else { 1.7 * TICK_SIZE };
        let below = 1.9 * TICK_SIZE + 14.0 + x_label.max(x_power);
        let beside = frame.right + GAP + bar.width() + 14.0;
        let title = text::width(&text::parse(&figure.title), TITLE_SIZE);
        let middle = 0.5 * (frame.left + frame.right);
        let page = (
            beside.max(middle + 0.5 * title + 12.0).ceil(),
            (frame.bottom + below.max(spare + 14.0)).ceil(),
        );
        Layout { page, frame, x, y, bar, bar_height }
    }

    fn at(&self, p: (f64, f64)) -> Point {
        let f = |t: Option<f64>| t.unwrap_or(f64::NAN).clamp(-1e6, 1e6);
        let b = &self.frame;
        (b.left + f(self.x.place(p.0)) * b.width(), b.bottom - f(self.y.place(p.1)) * b.height())
    }

    fn draw_field(&self, raster: &mut Raster, figure: &SliceFigure) {
        raster.confine(self.frame);
        for t in &figure.triangles {
            let corners = t.map(|p| {
                let (x, y) = self.at((p.0, p.1));
                [x, y, 0.0]
            });
            let v = t.map(|p| p.2);
            raster.triangle(corners, 1.0, |s| {
                self.bar.colour(s[0] * v[0] + s[1] * v[1] + s[2] * v[2])
            });
        }
    }

    /// The pieces of a line within the frame, on the page.
    fn visible(&self, points: &[(f64, f64)]) -> Vec<Vec<Point>> {
        let mut out: Vec<Vec<Point>> = Vec::new();
        for w in points.windows(2) {
            let Some((a, b)) = self.frame.clip(self.at(w[0]), self.at(w[1])) else { continue };
            match out.last_mut() {
                Some(piece) if piece.last() == Some(&a) => piece.push(b),
                _ => out.push(vec![a, b]),
            }
        }
        out
    }

    fn draw_lines(&self, canvas: &mut Canvas, figure: &SliceFigure) {
        let mut labels: Vec<(Box2, Vec<text::Run>)> = Vec::new();
        let mut taken = Vec::new();
        for (level, pieces) in &figure.contours {
            let lines: Vec<Vec<Point>> = pieces.iter().flat_map(|p| self.visible(p)).collect();
            let label = self.bar.number(*level);
            let size = (text::width(&label, CONTOUR_SIZE) + 6.0, 1.15 * CONTOUR_SIZE);
            if let Some(b) = labels::room(&lines, size, &self.frame, &taken) {
                taken.push(b);
                labels.push((b, label));
            }
            let ink = self.bar.ink_on(*level);
            lines.into_iter().for_each(|line| canvas.line_over(line, ink, 1.3));
        }
        for (b, label) in labels {
            canvas.blank_over(b);
            let at = (0.5 * (b.left + b.right), b.bottom - 0.25 * CONTOUR_SIZE);
            canvas.text(at, &label, CONTOUR_SIZE, Anchor::Middle);
        }
        let heavy = figure.lines.iter().flat_map(|p| self.visible(p));
        heavy.for_each(|line| canvas.line_over(line, INK, 2.4));
        if let Some(arrows) = &figure.arrows {
            self.draw_arrows(canvas, arrows);
        }
        for line in figure.streams.iter().flat_map(|p| self.visible(p)) {
            self.draw_stream(canvas, line);
        }
    }

    /// A stream line with a head in its middle.
    fn draw_stream(&self, canvas: &mut Canvas, line: Vec<Point>) {
        // A line along the frame is the frame.
        let inside = self.frame.grown(-2.0);
        if !line.iter().any(|p| inside.contains(*p)) {
            return;
        }
        let middle = line.len() / 2;
        let head = line.get(middle.saturating_sub(3)).zip(line.get(middle));
        let head =
            head.filter(|h| self.frame.grown(-4.0).contains(*h.1)).and_then(|(from, tip)| {
                let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
                let length = dx.hypot(dy);
                // As long as the head of the longest arrow.
                let stretch = 17.5 / length;
                (length > 1.0).then(|| wings((tip.0 - stretch * dx, tip.1 - stretch * dy), *tip))
            });
        let parts = std::iter::once((line, 1.0)).chain(head.map(|h| (h, 1.2)));
        strokes(canvas, &parts.collect::<Vec<_>>());
    }

    fn draw_arrows(&self, canvas: &mut Canvas, all: &Arrows) {
        let unit = (self.at((1.0, 0.0)).0 - self.at((0.0, 0.0)).0).abs();
        let fastest = all.arrows.iter().map(|a| a.1.0.hypot(a.1.1)).fold(0.0, f64::max);
        if fastest <= 0.0 || !(all.longest > 0.0 && unit.is_finite()) {
            return;
        }
        let stretch = all.longest * unit / fastest;
        for (foot, (u, v)) in &all.arrows {
            let from = self.at(*foot);
            let tip = (from.0 + stretch * u, from.1 - stretch * v);
            // What would reach beyond the frame is not drawn over its numbers.
            if self.frame.contains(from) && self.frame.contains(tip) {
                draw_arrow(canvas, from, tip);
            } else if let Some((from, end)) = self.frame.clip(from, tip) {
                strokes(canvas, &[(vec![from, end], 1.2)]);
            }
        }
        // The key: a round number that is drawn no longer than the longest.
        let decade = 10f64.powf(fastest.log10().floor());
        let round = [5.0, 2.0, 1.0].into_iter().map(|n| n * decade).find(|n| *n <= fastest);
        let round = round.unwrap_or(decade);
        let text = text::parse(format!("{} {}", plain(round), all.unit).trim());
        let (right, y) = (self.frame.right, self.frame.top - 9.0);
        let from = (right - text::width(&text, TICK_SIZE) - 8.0 - stretch * round, y - 5.0);
        draw_arrow(canvas, from, (from.0 + stretch * round, from.1));
        canvas.text((right, y), &text, TICK_SIZE, Anchor::End);
    }

    fn draw_axes(&self, canvas: &mut Canvas, figure: &SliceFigure) {
        let b = self.frame;
        frame::ticks(canvas, b, &self.x, &self.y);
        let middle = (0.5 * (b.left + b.right), 0.5 * (b.top + b.bottom));
        let below = (middle.0, b.bottom + 1.9 * TICK_SIZE + LABEL_SIZE);
        canvas.text(below, &text::parse(&figure.x.label), LABEL_SIZE, Anchor::Middle);
        if !figure.y.label.is_empty() {
            let at = (12.0 + LABEL_SIZE, middle.1);
            canvas.text_upwards(at, text::parse(&figure.y.label), LABEL_SIZE);
        }
        let above = (middle.0, 12.0 + TITLE_SIZE);
        canvas.text(above, &text::parse(&figure.title), TITLE_SIZE, Anchor::Middle);
    }
}

/// A number for a label: powers of ten as such.
fn plain(v: f64) -> String {
    if (1e-3..1e5).contains(&v) {
        // Digits behind the last one that counts are rounding.
        let decimals = (-v.log10().floor()).max(0.0) as usize;
        return format!("{v:.decimals$}");
    }
    let exponent = v.log10().floor();
    format!("{:.0}×10^{{{exponent}}}", v / 10f64.powf(exponent))
}

fn draw_arrow(canvas: &mut Canvas, from: Point, tip: Point) {
    let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
    let length = dx.hypot(dy);
    if length < 1.0 {
        return;
    }
    strokes(canvas, &[(vec![from, tip], 1.2), (wings(from, tip), 1.2)]);
}

/// Lines with their widths on something light, so that they are seen on dark colours.
fn strokes(canvas: &mut Canvas, lines: &[(Vec<Point>, f64)]) {
    for (line, width) in lines {
        canvas.line_over(line.clone(), Rgb(255, 255, 255), width + 2.0 * HALO);
    }
    lines.iter().for_each(|(line, width)| canvas.line_over(line.clone(), INK, *width));
}

/// The head of an arrow.
fn wings(from: Point, tip: Point) -> Vec<Point> {
    let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
    let length = dx.hypot(dy);
    let (ex, ey) = (dx / length, dy / length);
    let head = (0.4 * length).min(7.0);
    let wing = |side: f64| {
        (tip.0 - head * ex + side * 0.45 * head * ey, tip.1 - head * ey - side * 0.45 * head * ex)
    };
    vec![wing(1.0), tip, wing(-1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_keys() {
        assert_eq!(["0.05", "2", "200"], [0.05, 2.0, 200.0].map(plain).each_ref().map(|s| &s[..]));
        assert_eq!(plain(5e-5), "5×10^{-5}");
    }
}
