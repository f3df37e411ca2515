//! Curves and markers over two axes.

use super::axis::{Axis, Ruler, Tick};
use super::canvas::{Anchor, Box2, Canvas, Point};
use super::frame::{self, LABEL_SIZE, TICK_SIZE, TITLE_SIZE, label_width};
use super::legend::{self, Entry};
use super::text;
use super::{Marker, PALETTE, PlotError, Rgb};

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// A full line.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// A marker at every point.
    Markers(Marker),
}

/// One set of points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Its name in the legend (with `_{...}`, `^{...}`; see [`literal`](super::literal)); empty:
    /// not in the legend.
    pub name: String,
    /// The points in the order they are joined. What is not finite, or not positive on a
    /// logarithmic axis, is dropped and interrupts the line.
    pub points: Vec<(f64, f64)>,
    /// Line or markers.
    pub style: Style,
    /// `None`: the next colour of [`PALETTE`].
    pub colour: Option<Rgb>,
}

impl Series {
    /// A full line.
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Series { name: name.into(), points, style: Style::Line, colour: None }
    }

    /// A dashed line.
    pub fn dashed(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Series { style: Style::Dashed, ..Self::line(name, points) }
    }

    /// Markers.
    pub fn markers(name: impl Into<String>, kind: Marker, points: Vec<(f64, f64)>) -> Self {
        Series { style: Style::Markers(kind), ..Self::line(name, points) }
    }

    /// The series in a colour of choice.
    #[must_use]
    pub fn coloured(mut self, colour: Rgb) -> Self {
        self.colour = Some(colour);
        self
    }
}

/// Where the legend goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Legend {
    /// In a corner where it covers nothing, otherwise beside the axes.
    #[default]
    Auto,
    /// Beside the axes.
    Outside,
    /// None.
    None,
}

/// A figure of curves and markers over two axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineFigure {
    /// Above the axes; empty for none (a paper has a caption).
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn; later series lie over earlier ones, markers over lines.
    pub series: Vec<Series>,
    /// Where the legend goes.
    pub legend: Legend,
}

const PAGE: (f64, f64) = (800.0, 560.0);
const GRID: Rgb = Rgb(226, 226, 226);
/// Width of curves.
pub(super) const WIDTH: f64 = 2.2;
/// Length of dashes and of the gaps between them.
pub(super) const DASH: (f64, f64) = (9.0, 5.5);
/// Radius of markers.
pub(super) const RADIUS: f64 = 5.0;
/// So many markers are drawn however near to each other they are: measured points are few.
const FEW: usize = 60;
/// Width of their outline.
pub(super) const MARKER_WIDTH: f64 = 1.7;

impl LineFigure {
    /// The figure as SVG, 800 by 560 units, text as text.
    pub fn to_svg(&self) -> String {
        self.draw().into_svg()
    }

    /// The figure as PNG, 1600 pixels wide (240 dots per inch at 17 cm).
    ///
    /// # Errors
    /// When the rasteriser fails.
    pub fn to_png(&self) -> Result<Vec<u8>, PlotError> {
        self.to_png_scaled(2.0)
    }

    /// The figure as PNG, `800 * scale` pixels wide.
    ///
    /// # Errors
    /// For a scale outside 0.1 to 20, and when the rasteriser fails.
    pub fn to_png_scaled(&self, scale: f64) -> Result<Vec<u8>, PlotError> {
        if !(0.1..=20.0).contains(&scale) {
            return Err(PlotError::Scale(scale));
        }
        self.draw().into_png(scale)
    }

    fn draw(&self) -> Canvas {
        let colours: Vec<Rgb> = self.colours();
        let named = self.series.iter().zip(&colours).filter(|(s, _)| !s.name.is_empty());
        let entries: Vec<Entry> = match self.legend {
            Legend::None => Vec::new(),
            _ => named.map(|(s, c)| Entry::new(&s.name, s.style, *c)).collect(),
        };
        let size = legend::size(&entries);
        let mut layout = Layout::new(self, 0.0);
        let mut place = match self.legend {
            Legend::Auto if !entries.is_empty() => {
                let (lines, markers) = layout.drawn(&self.series);
                legend::free_corner(layout.frame, size, &lines, &markers)
            }
            _ => None,
        };
        if place.is_none() && !entries.is_empty() {
            layout = Layout::new(self, size.0 + 14.0);
            let (left, top) = (layout.frame.right + 14.0, layout.frame.top);
            place = Some(Box2 { left, top, right: left + size.0, bottom: top + size.1 });
        }

        let mut canvas = Canvas::new(PAGE.0, PAGE.1);
        layout.draw_axes(&mut canvas, self);
        for (s, c) in self.series.iter().zip(&colours) {
            if !matches!(s.style, Style::Markers(_)) {
                layout.draw_line(&mut canvas, s, *c);
            }
        }
        for (s, c) in self.series.iter().zip(&colours) {
            if let Style::Markers(kind) = s.style {
                for at in layout.marks(s) {
                    canvas.marker(at, kind, *c, RADIUS, MARKER_WIDTH);
                }
            }
        }
        if let Some(place) = place {
            legend::draw(&mut canvas, place, &entries);
        }
        canvas
    }

    fn colours(&self) -> Vec<Rgb> {
        let mut next = PALETTE.iter().copied().cycle();
        let mut auto = || next.next().unwrap_or(Rgb::BLACK);
        self.series.iter().map(|s| s.colour.unwrap_or_else(&mut auto)).collect()
    }
}

/// The axes with their place on the page.
struct Layout {
    frame: Box2,
    x: Ruler,
    y: Ruler,
}

impl Layout {
    /// `right`: what is kept free on the right for the legend.
    fn new(figure: &LineFigure, right: f64) -> Self {
        let points = || figure.series.iter().flat_map(|s| s.points.iter().copied());
        let whole = |p: &(f64, f64)| {
            let fits = |axis: &Axis, v: f64| Ruler::shows(axis, v);
            fits(&figure.x, p.0) && fits(&figure.y, p.1)
        };
        let y = Ruler::new(&figure.y, points().filter(whole).map(|p| p.1), 8);
        let widest = y.ticks.iter().filter_map(|t| t.label.as_deref()).map(label_width);
        let label = if figure.y.label.is_empty() { 0.0 } else { 1.4 * LABEL_SIZE };
        let left = 18.0 + label + widest.fold(0.0, f64::max) + 10.0;
        let title = if figure.title.is_empty() { 0.0 } else { 1.7 * TITLE_SIZE };
        let factor = if y.factor == 0 { 0.0 } else { 14.0 };
        let below = if figure.x.label.is_empty() { 0.0 } else { 1.35 * LABEL_SIZE };
        let frame = Box2 {
            left,
            top: 20.0 + title + factor,
            // Never less than a readable picture: an overlong legend is cut instead.
            right: (PAGE.0 - 24.0 - right).max(left + 260.0),
            bottom: PAGE.1 - 16.0 - below - 1.9 * TICK_SIZE,
        };
        let labels = (frame.width() / 75.0) as usize;
        let x = Ruler::new(&figure.x, points().filter(whole).map(|p| p.0), labels);
        Layout { frame, x, y }
    }

    fn at(&self, p: (f64, f64)) -> Option<Point> {
        let (u, v) = (self.x.place(p.0)?, self.y.place(p.1)?);
        // Far outside the frame nothing is seen, and numbers stay numbers.
        let f = |t: f64| t.clamp(-1e6, 1e6);
        let b = &self.frame;
        Some((b.left + f(u) * b.width(), b.bottom - f(v) * b.height()))
    }

    /// The line through a series, in pieces, clipped to the frame, without points that lie on top
    /// of each other.
    fn pieces(&self, series: &Series) -> Vec<Vec<Point>> {
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        let mut piece: Vec<Point> = Vec::new();
        let mut last: Option<Point> = None;
        let mut cut = |piece: &mut Vec<Point>| match piece.is_empty() {
            true => {}
            false => pieces.push(std::mem::take(piece)),
        };
        for p in &series.points {
            let Some(q) = self.at(*p) else {
                cut(&mut piece);
                last = None;
                continue;
            };
            match last {
                // Alone so far; drawn as a dot if it stays alone.
                None if self.frame.contains(q) => piece.push(q),
                None => {}
                Some(l) if (q.0 - l.0).hypot(q.1 - l.1) < 0.2 => continue,
                Some(l) => match self.frame.clip(l, q) {
                    Some((a, b)) => {
                        if piece.last() != Some(&a) {
                            cut(&mut piece);
                            piece.push(a);
                        }
                        piece.push(b);
                    }
                    None => cut(&mut piece),
                },
            }
            last = Some(q);
        }
        cut(&mut piece);
        pieces
    }

    fn marks(&self, series: &Series) -> Vec<Point> {
        let seen = |q: &Point| self.frame.grown(0.5).contains(*q);
        let all: Vec<Point> =
            series.points.iter().filter_map(|p| self.at(*p)).filter(seen).collect();
        if all.len() <= FEW {
            return all;
        }
        // A row of overlapping circles is a thick line: one wherever there is room, and the last.
        let mut out: Vec<Point> = Vec::new();
        for q in &all {
            let room = |o: &Point| (q.0 - o.0).hypot(q.1 - o.1) > 2.6 * RADIUS;
            if out.last().is_none_or(room) {
                out.push(*q);
            }
        }
        out
    }

    /// Everything a legend must not cover.
    fn drawn(&self, series: &[Series]) -> (Vec<Vec<Point>>, Vec<Point>) {
        let (mut lines, mut marks) = (Vec::new(), Vec::new());
        for s in series {
            match s.style {
                Style::Markers(_) => marks.extend(self.marks(s)),
                _ => lines.extend(self.pieces(s)),
            }
        }
        (lines, marks)
    }

    fn draw_line(&self, canvas: &mut Canvas, series: &Series, colour: Rgb) {
        for piece in self.pieces(series) {
            match (piece.as_slice(), series.style) {
                ([only], _) => canvas.dot(*only, colour, WIDTH),
                (points, Style::Dashed) => canvas.dashed(points, colour, WIDTH, DASH.0, DASH.1),
                _ => canvas.polyline(piece, colour, WIDTH),
            }
        }
    }

    fn draw_axes(&self, canvas: &mut Canvas, figure: &LineFigure) {
        let b = self.frame;
        let x_at = |t: &Tick| self.x.place(t.value).map(|u| b.left + u * b.width());
        let y_at = |t: &Tick| self.y.place(t.value).map(|v| b.bottom - v * b.height());
        let inside = |at: f64, a: f64, z: f64| at > a + 1.0 && at < z - 1.0;
        for t in self.x.ticks.iter().filter(|t| t.label.is_some()) {
            if let Some(x) = x_at(t).filter(|x| inside(*x, b.left, b.right)) {
                canvas.line((x, b.top), (x, b.bottom), GRID, 1.0);
            }
        }
        for t in self.y.ticks.iter().filter(|t| t.label.is_some()) {
            if let Some(y) = y_at(t).filter(|y| inside(*y, b.top, b.bottom)) {
                canvas.line((b.left, y), (b.right, y), GRID, 1.0);
            }
        }
        frame::ticks(canvas, b, &self.x, &self.y);

        let middle = (0.5 * (b.left + b.right), 0.5 * (b.top + b.bottom));
        let below = (middle.0, PAGE.1 - 16.0);
        canvas.text(below, &text::parse(&figure.x.label), LABEL_SIZE, Anchor::Middle);
        if !figure.y.label.is_empty() {
            let at = (12.0 + LABEL_SIZE, middle.1);
            canvas.text_upwards(at, text::parse(&figure.y.label), LABEL_SIZE);
        }
        let above = (middle.0, 12.0 + TITLE_SIZE);
        canvas.text(above, &text::parse(&figure.title), TITLE_SIZE, Anchor::Middle);
    }
}
