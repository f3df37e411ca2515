//! The page: a kuva scene with what figures need and kuva's own layout does not give.
//!
//! kuva supplies the SVG writer, the rasteriser and the embedded font. Layout is ours (its log
//! axes label 2 and 5, its legends cover data, its labels have no sub- and superscripts), and so
//! are dashes (kuva's start anew at every point of a raster line) and vertical text (kuva's has
//! no anti-aliasing: it is drawn flat here and turned by exactly 90 degrees).

use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::image::{Image, base64};
use super::raster::Raster;
use super::text::{self, Run};
use super::{Marker, PlotError, Rgb};
use std::fmt::Write;

/// A place on the page: right, down.
pub(super) type Point = (f64, f64);

/// Which point of a text is at the given place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn shift(self, width: f64) -> f64 {
        match self {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * width,
            Anchor::End => -width,
        }
    }
}

/// A rectangle on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Box2 {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Box2 {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(super) fn contains(&self, p: Point) -> bool {
        (self.left..=self.right).contains(&p.0) && (self.top..=self.bottom).contains(&p.1)
    }

    pub(super) fn grown(&self, by: f64) -> Box2 {
        Box2 {
            left: self.left - by,
            top: self.top - by,
            right: self.right + by,
            bottom: self.bottom + by,
        }
    }

    /// The part of a segment inside the rectangle (Liang and Barsky 1984).
    pub(super) fn clip(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (p, q) in [
            (-dx, a.0 - self.left),
            (dx, self.right - a.0),
            (-dy, a.1 - self.top),
            (dy, self.bottom - a.1),
        ] {
            if p == 0.0 {
                if q < 0.0 {
                    return None;
                }
            } else if p < 0.0 {
                enter = enter.max(q / p);
            } else {
                leave = leave.min(q / p);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        (enter <= leave).then(|| (at(enter), at(leave)))
    }
}

/// Text that runs upwards, kept apart for the rasteriser.
struct Vertical {
    runs: Vec<Run>,
    x: f64,
    y: f64,
    size: f64,
}

/// A page under construction.
pub(super) struct Canvas {
    scene: Scene,
    vertical: Vec<Vertical>,
    /// What is drawn on the pixels of a field, in order.
    over: Vec<Over>,
}

/// Something between the pixels of a field and the other lines and texts.
enum Over {
    Line(Vec<Point>, Rgb, f64),
    /// White: room for a text.
    Blank(Box2),
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some("DejaVu Sans, Verdana, Arial, sans-serif".to_owned());
        scene.text_color = Some("#1a1a1a".to_owned());
        Canvas { scene, vertical: Vec::new(), over: Vec::new() }
    }

    /// A line on the pixels of a field: light ones are seen, too.
    pub(super) fn line_over(&mut self, points: Vec<Point>, colour: Rgb, width: f64) {
        self.over.push(Over::Line(points, colour, width));
    }

    /// A white patch on the pixels of a field and the lines drawn on them so far.
    pub(super) fn blank_over(&mut self, b: Box2) {
        self.over.push(Over::Blank(b));
    }

    /// A horizontal text with its baseline at `at`.
    pub(super) fn text(&mut self, at: Point, runs: &[Run], size: f64, anchor: Anchor) {
        let mut x = at.0 + anchor.shift(text::width(runs, size));
        for run in runs {
            let own = run.level.size(size);
            let y = at.1 - run.level.rise() * size;
            self.scene.add(plain(x, y, &run.text, own, None));
            x += text::plain_width(&run.text, own);
        }
    }

    /// A text that runs upwards, centred at `at`; its baseline is at `at.0`.
    pub(super) fn text_upwards(&mut self, at: Point, runs: Vec<Run>, size: f64) {
        self.vertical.push(Vertical { runs, x: at.0, y: at.1, size });
    }

    pub(super) fn line(&mut self, a: Point, b: Point, colour: Rgb, width: f64) {
        self.scene.add(Primitive::Line {
            x1: a.0,
            y1: a.1,
            x2: b.0,
            y2: b.1,
            stroke: paint(colour),
            stroke_width: width,
            stroke_dasharray: None,
        });
    }

    pub(super) fn polyline(&mut self, points: Vec<Point>, colour: Rgb, width: f64) {
        self.scene.add(Primitive::PolyLine {
            points,
            stroke: paint(colour),
            stroke_width: width,
            stroke_dasharray: None,
        });
    }

    /// A polyline with dashes that run on over its points.
    pub(super) fn dashed(&mut self, points: &[Point], colour: Rgb, width: f64, on: f64, off: f64) {
        for dash in dashes(points, on, off) {
            self.polyline(dash, colour, width);
        }
    }

    pub(super) fn rect(&mut self, b: Box2, fill: Option<Rgb>, stroke: Option<(Rgb, f64)>) {
        self.scene.add(Primitive::Rect {
            x: b.left,
            y: b.top,
            width: b.width(),
            height: b.height(),
            fill: fill.map_or(Color::None, paint),
            stroke: stroke.map(|(c, _)| paint(c)),
            stroke_width: stroke.map(|(_, w)| w),
            opacity: None,
        });
    }

    pub(super) fn marker(&mut self, at: Point, kind: Marker, colour: Rgb, radius: f64, width: f64) {
        let (x, y) = at;
        let mut polygon = |corners: &[Point]| {
            let points = corners.iter().map(|(u, v)| (x + radius * u, y + radius * v)).collect();
            self.polyline(points, colour, width);
        };
        const S: f64 = 0.88; // a square that looks as large as the circle
        const T: f64 = 1.15;
        match kind {
            Marker::Circle => self.scene.add(Primitive::Circle {
                cx: x,
                cy: y,
                r: radius,
                fill: Color::None,
                fill_opacity: None,
                stroke: Some(paint(colour)),
                stroke_width: Some(width),
            }),
            // The first side is drawn twice, so that the last corner is joined like the others.
            Marker::Square => polygon(&[(-S, -S), (S, -S), (S, S), (-S, S), (-S, -S), (S, -S)]),
            Marker::Triangle => polygon(&[
                (0.0, -T),
                (0.866 * T, 0.5 * T),
                (-0.866 * T, 0.5 * T),
                (0.0, -T),
                (0.866 * T, 0.5 * T),
            ]),
            Marker::Diamond => {
                polygon(&[(0.0, -T), (T, 0.0), (0.0, T), (-T, 0.0), (0.0, -T), (T, 0.0)]);
            }
            Marker::Plus => {
                polygon(&[(-T, 0.0), (T, 0.0)]);
                polygon(&[(0.0, -T), (0.0, T)]);
            }
            Marker::Cross => {
                polygon(&[(-S, -S), (S, S)]);
                polygon(&[(-S, S), (S, -S)]);
            }
        }
    }

    /// A filled disc.
    pub(super) fn dot(&mut self, at: Point, colour: Rgb, radius: f64) {
        self.scene.add(Primitive::Circle {
            cx: at.0,
            cy: at.1,
            r: radius,
            fill: paint(colour),
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        });
    }

    /// The page as SVG and as PNG with the pixels of a field under it, at their scale.
    ///
    /// # Errors
    /// When the rasteriser fails.
    pub(super) fn render(self, mut pixels: Raster) -> Result<(String, Vec<u8>), PlotError> {
        let picture = Image::from(&pixels);
        let scale = picture.width as f64 / self.scene.width;
        pixels.release();
        for over in &self.over {
            match over {
                Over::Line(points, colour, width) => pixels.stroke(points, *colour, *width),
                Over::Blank(b) => pixels.blank(*b),
            }
        }
        let png = self.png(Some(&Image::from(&pixels)), scale)?;
        let data = base64(&picture.encode(scale)?);
        let (w, h) = (self.scene.width, self.scene.height);
        let svg = self.svg(&format!(
            "  <image x=\"0\" y=\"0\" width=\"{w}\" height=\"{h}\" \
             href=\"data:image/png;base64,{data}\" />\n"
        ));
        Ok((svg, png))
    }

    /// The page as SVG.
    pub(super) fn into_svg(self) -> String {
        self.svg("")
    }

    fn svg(mut self, picture: &str) -> String {
        for v in std::mem::take(&mut self.vertical) {
            let mut y = v.y + 0.5 * text::width(&v.runs, v.size);
            for run in &v.runs {
                let own = run.level.size(v.size);
                let x = v.x - run.level.rise() * v.size;
                self.scene.add(plain(x, y, &run.text, own, Some(-90.0)));
                y -= text::plain_width(&run.text, own);
            }
        }
        let (w, h) = (self.scene.width, self.scene.height);
        // Without a viewBox a browser or LaTeX cannot scale the picture.
        let mut svg = SvgBackend::new().with_pretty(true).render_scene(&self.scene).replacen(
            " width=",
            &format!(" viewBox=\"0 0 {w} {h}\" width="),
            1,
        );
        let mut under = picture.to_owned();
        for over in &self.over {
            // Writing to a string does not fail.
            let _ = match over {
                Over::Line(points, Rgb(r, g, b), width) => {
                    let points: Vec<String> =
                        points.iter().map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
                    writeln!(
                        under,
                        "  <polyline points=\"{}\" fill=\"none\" stroke=\"#{r:02x}{g:02x}{b:02x}\" \
                         stroke-width=\"{width}\" stroke-linejoin=\"round\" />",
                        points.join(" ")
                    )
                }
                Over::Blank(b) => writeln!(
                    under,
                    "  <rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" \
                     fill=\"white\" stroke=\"none\" />",
                    b.left,
                    b.top,
                    b.width(),
                    b.height()
                ),
            };
        }
        // Behind the white sheet, which comes first.
        const SHEET: &str = "fill=\"white\" />\n";
        if let Some(at) = svg.find(SHEET) {
            svg.insert_str(at + SHEET.len(), &under);
        }
        svg
    }

    /// Renders at `scale` pixels per unit of the page.
    ///
    /// # Errors
    /// When the rasteriser fails.
    pub(super) fn into_png(self, scale: f64) -> Result<Vec<u8>, PlotError> {
        self.png(None, scale)
    }

    fn png(&self, under: Option<&Image>, scale: f64) -> Result<Vec<u8>, PlotError> {
        let mut page = Image::of(&self.scene, scale)?;
        if let Some(under) = under {
            page.multiply(under);
        }
        for v in &self.vertical {
            let (length, height) = (text::width(&v.runs, v.size) + 8.0, 2.0 * v.size);
            let (mid, base) = (0.5 * length, 1.4 * v.size);
            let mut flat = Canvas::new(length.ceil(), height.ceil());
            flat.scene.text_color.clone_from(&self.scene.text_color);
            flat.text((mid, base), &v.runs, v.size, Anchor::Middle);
            let label = Image::of(&flat.scene, scale)?;
            let pixel = |units: f64| (units * scale).round() as i64;
            page.multiply_turned(&label, (pixel(v.x), pixel(v.y)), (pixel(mid), pixel(base)));
        }
        page.encode(scale)
    }
}

/// `on` long strokes with `off` long gaps along a polyline.
fn dashes(points: &[Point], on: f64, off: f64) -> Vec<Vec<Point>> {
    let mut out = Vec::new();
    let (mut drawing, mut left) = (true, on);
    let mut dash: Vec<Point> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let (mut a, b) = (pair[0], pair[1]);
        loop {
            let rest = (b.0 - a.0).hypot(b.1 - a.1);
            if rest <= left {
                left -= rest;
                break;
            }
            let t = left / rest;
            a = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
            if drawing {
                dash.push(a);
                out.push(std::mem::take(&mut dash));
            } else {
                dash.push(a);
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        if drawing {
            dash.push(b);
        }
    }
    if dash.len() > 1 {
        out.push(dash);
    }
    out
}

fn paint(c: Rgb) -> Color {
    Color::Rgb(c.0, c.1, c.2)
}

fn plain(x: f64, y: f64, content: &str, size: f64, rotate: Option<f64>) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: content.replace('$', "\\$"), // kuva: the start of mathematics
        size: size.round() as u32,
        anchor: TextAnchor::Start,
        rotate,
        bold: false,
        color: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_run_on_over_points() {
        // Points much closer than a dash.
        let points: Vec<Point> = (0..=100).map(|i| (f64::from(i), 0.0)).collect();
        let all = dashes(&points, 10.0, 5.0);
        assert_eq!(all.len(), 7);
        assert_eq!((all[1].first(), all[1].last()), (Some(&(15.0, 0.0)), Some(&(25.0, 0.0))));
        // Points much further apart.
        assert_eq!(dashes(&[(0.0, 0.0), (100.0, 0.0)], 10.0, 5.0).len(), 7);
        assert!(dashes(&[], 1.0, 1.0).is_empty());
    }

    #[test]
    fn segments_are_clipped_to_the_box() {
        let b = Box2 { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };
        assert_eq!(b.clip((-5.0, 5.0), (15.0, 5.0)), Some(((0.0, 5.0), (10.0, 5.0))));
        assert_eq!(b.clip((1.0, 1.0), (2.0, 2.0)), Some(((1.0, 1.0), (2.0, 2.0))));
        assert_eq!(b.clip((-5.0, -1.0), (15.0, -1.0)), None);
        assert_eq!(b.clip((-4.0, 4.0), (4.0, -4.0)), Some(((0.0, 0.0), (0.0, 0.0))));
    }

    #[test]
    fn vertical_text_lands_where_it_should() {
        let mut canvas = Canvas::new(60.0, 200.0);
        canvas.text_upwards((30.0, 100.0), text::parse("label of an axis"), 16.0);
        let bytes = canvas.into_png(1.0).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        let dark: Vec<(usize, usize)> =
            (0..60 * 200).filter(|i| data[3 * i] < 128).map(|i| (i % 60, i / 60)).collect();
        let ends = |v: Vec<usize>| (*v.iter().min().unwrap(), *v.iter().max().unwrap());
        let (left, right) = ends(dark.iter().map(|d| d.0).collect());
        let (top, bottom) = ends(dark.iter().map(|d| d.1).collect());
        assert!(left >= 16 && right <= 34, "baseline at 30: {left}..{right}");
        assert!(top.abs_diff(200 - bottom) <= 4, "centred: {top}..{bottom}");
        assert!(bottom - top > 100, "upwards: {top}..{bottom}");
    }
}
