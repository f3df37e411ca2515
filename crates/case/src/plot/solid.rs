//! Surfaces in space: shaded, translucent where asked for, seen from a direction.

use super::canvas::{Anchor, Box2, Canvas};
use super::colour::shaded;
use super::frame::{Bar, GAP, INK, LABEL_SIZE, Shades, TITLE_SIZE};
use super::raster::{Deep, PIXELS, Raster};
use super::{PlotError, Rgb, text};
use granflow_base::{Vec3, add, cross, dot, scale, sub, unit};

/// What a surface is coloured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    /// One colour.
    Plain(Rgb),
    /// The values at its corners.
    Values,
}

/// Place, normal and value of the corners of a triangle.
pub type Facet = [(Vec3, Vec3, f64); 3];

/// A surface of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Its name in the legend; empty: not in it.
    pub label: String,
    /// What it is coloured by.
    pub paint: Paint,
    /// 1: opaque.
    pub opacity: f64,
    /// Its triangles.
    pub triangles: Vec<Facet>,
}

/// Surfaces seen from a direction, without perspective.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SolidFigure {
    /// Above the picture; empty for none.
    pub title: String,
    /// Direction that is upwards in the picture.
    pub up: Vec3,
    /// Direction from what is seen to the eye.
    pub eye: Vec3,
    /// The surfaces.
    pub sheets: Vec<Sheet>,
    /// Edges, drawn as lines.
    pub edges: Vec<(Vec3, Vec3)>,
    /// How values become colours, where a surface is painted with them.
    pub shades: Option<Shades>,
    /// Names of the axes at the triad; none: no triad.
    pub axes: Option<[String; 3]>,
}

/// Room for the picture, and for the triad below it.
const MOST: (f64, f64) = (600.0, 470.0);
const TRIAD: f64 = 44.0;

impl SolidFigure {
    /// The figure as SVG (texts as such, surfaces as a picture in it) and as PNG.
    ///
    /// # Errors
    /// When the rasteriser fails.
    pub fn render(&self) -> Result<(String, Vec<u8>), PlotError> {
        let (canvas, pixels) = self.draw();
        canvas.render(pixels)
    }

    fn draw(&self) -> (Canvas, Raster) {
        let camera = Camera::new(self);
        let title = if self.title.is_empty() { 0.0 } else { 1.6 * TITLE_SIZE };
        let bar = self.shades.as_ref().map(|s| Bar::new(s, 0.6 * MOST.1));
        let named: Vec<&Sheet> = self.sheets.iter().filter(|s| !s.label.is_empty()).collect();
        let width = |s: &&Sheet| text::width(&text::parse(&s.label), LABEL_SIZE) + 32.0;
        let legend = named.iter().map(width).fold(0.0, f64::max);
        let beside = bar.as_ref().map_or(0.0, Bar::width).max(legend);
        let triad = if self.axes.is_some() { 1.2 * TRIAD } else { 0.0 };
        let (left, top) = (20.0 + triad, 16.0 + title);
        let size = (camera.size.0 * camera.scale, camera.size.1 * camera.scale);
        let high = size.1.max(if bar.is_some() { 0.6 * MOST.1 + 30.0 } else { 0.0 });
        let frame = Box2 { left, top, right: left + size.0, bottom: top + high };
        let page = (frame.right + GAP + beside + 16.0, frame.bottom + triad + 16.0);
        let page = (page.0.ceil(), page.1.ceil());
        let mut canvas = Canvas::new(page.0, page.1);
        let mut raster = Raster::new(page, PIXELS);

        let middle = (0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom));
        let place = |p: Vec3| camera.place(p, middle);
        self.draw_surfaces(&mut raster, &camera, bar.as_ref(), place);

        let mut y = frame.top;
        let x = frame.right + GAP;
        for sheet in named {
            if let Paint::Plain(c) = sheet.paint {
                let b = Box2 { left: x, top: y, right: x + 22.0, bottom: y + 16.0 };
                canvas.rect(b, Some(faded(c, sheet.opacity)), Some((INK, 1.0)));
                let at = (x + 32.0, y + 8.0 + 0.36 * LABEL_SIZE);
                canvas.text(at, &text::parse(&sheet.label), LABEL_SIZE, Anchor::Start);
                y += 1.5 * LABEL_SIZE;
            }
        }
        if let Some(bar) = &bar {
            let height = (0.6 * MOST.1).min(frame.bottom - y - bar.above());
            let at = (x, frame.bottom - height);
            bar.draw(&mut canvas, &mut raster, at, height, &[]);
        }
        if let Some(names) = &self.axes {
            let foot = (20.0 + TRIAD, page.1 - 16.0 - TRIAD);
            draw_triad(&mut canvas, &camera, foot, names);
        }
        let above = (middle.0, 12.0 + TITLE_SIZE);
        canvas.text(above, &text::parse(&self.title), TITLE_SIZE, Anchor::Middle);
        (canvas, raster)
    }

    fn draw_surfaces(
        &self,
        raster: &mut Raster,
        camera: &Camera,
        bar: Option<&Bar<'_>>,
        place: impl Fn(Vec3) -> Deep,
    ) {
        let draw = |raster: &mut Raster, sheet: &Sheet, t: &Facet| {
            let light = t.map(|c| camera.light(c.1, sheet.paint));
            let corners = t.map(|c| place(c.0));
            let mix = |s: [f64; 3], v: [f64; 3]| s[0] * v[0] + s[1] * v[1] + s[2] * v[2];
            match (sheet.paint, bar) {
                (Paint::Values, Some(bar)) => {
                    let v = t.map(|c| c.2);
                    raster.triangle(corners, sheet.opacity, |s| {
                        shaded(bar.colour(mix(s, v)), mix(s, light))
                    });
                }
                (Paint::Plain(c), _) => {
                    raster.triangle(corners, sheet.opacity, |s| shaded(c, mix(s, light)));
                }
                (Paint::Values, None) => {}
            }
        };
        for sheet in self.sheets.iter().filter(|s| s.opacity >= 1.0) {
            sheet.triangles.iter().for_each(|t| draw(raster, sheet, t));
        }
        // A line lies in its surface: it must not drown in it.
        let slack = 3.0;
        for (a, b) in &self.edges {
            raster.segment(place(*a), place(*b), Rgb(70, 70, 70), 1.0, slack);
        }
        let mut clear: Vec<(f64, &Sheet, &Facet)> = Vec::new();
        for sheet in self.sheets.iter().filter(|s| s.opacity < 1.0) {
            let depth = |t: &Facet| t.iter().map(|c| place(c.0)[2]).sum::<f64>();
            clear.extend(sheet.triangles.iter().map(|t| (depth(t), sheet, t)));
        }
        clear.sort_by(|a, b| b.0.total_cmp(&a.0));
        clear.into_iter().for_each(|(_, sheet, t)| draw(raster, sheet, t));
    }
}

fn faded(c: Rgb, opacity: f64) -> Rgb {
    let f = |v: u8| (255.0 - opacity * (255.0 - f64::from(v))).round() as u8;
    Rgb(f(c.0), f(c.1), f(c.2))
}

/// The projection: right, up and towards the eye.
struct Camera {
    right: Vec3,
    top: Vec3,
    eye: Vec3,
    lamp: Vec3,
    centre: Vec3,
    /// Extent in the picture, m.
    size: (f64, f64),
    /// Units of the page per metre.
    scale: f64,
}

impl Camera {
    fn new(figure: &SolidFigure) -> Camera {
        let eye = unit(figure.eye);
        let right = unit(cross(figure.up, eye));
        let top = cross(eye, right);
        let lamp = unit(add(add(scale(eye, 0.75), scale(top, 0.6)), scale(right, -0.35)));
        let base = [right, top, eye];
        let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        let corners = figure.sheets.iter().flat_map(|s| s.triangles.iter().flatten().map(|c| c.0));
        for p in corners.chain(figure.edges.iter().flat_map(|e| [e.0, e.1])) {
            for (e, axis) in ends.iter_mut().zip(base) {
                let v = dot(p, axis);
                *e = (e.0.min(v), e.1.max(v));
            }
        }
        let mut centre = [0.0; 3];
        let mut extent = [1.0; 3];
        for (k, (lo, hi)) in ends.into_iter().enumerate().filter(|(_, e)| e.0 <= e.1) {
            centre = add(centre, scale(base[k], 0.5 * (lo + hi)));
            extent[k] = hi - lo;
        }
        let tiny = 1e-12 * extent.iter().fold(1e-30, |a: f64, b| a.max(*b));
        let size = (extent[0].max(tiny), extent[1].max(tiny));
        let scale = (MOST.0 / size.0).min(MOST.1 / size.1);
        Camera { right, top, eye, lamp, centre, size, scale }
    }

    fn place(&self, p: Vec3, middle: (f64, f64)) -> Deep {
        let d = sub(p, self.centre);
        let f = |axis: Vec3| self.scale * dot(d, axis);
        [middle.0 + f(self.right), middle.1 - f(self.top), -f(self.eye)]
    }

    /// How bright a surface is, both sides alike (Lambert's law over some light from everywhere).
    fn light(&self, normal: Vec3, paint: Paint) -> f64 {
        let n = unit(normal);
        let towards = if dot(n, self.eye) < 0.0 { -1.0 } else { 1.0 };
        let direct = (towards * dot(n, self.lamp)).max(0.0);
        match paint {
            Paint::Plain(_) => 0.6 + 0.4 * direct,
            // Colours that are read must stay what they are.
            Paint::Values => 0.75 + 0.25 * direct,
        }
    }
}

fn draw_triad(canvas: &mut Canvas, camera: &Camera, foot: (f64, f64), names: &[String; 3]) {
    for (k, name) in names.iter().enumerate() {
        let (u, v) = (camera.right[k], -camera.top[k]);
        let long = u.hypot(v);
        let tip = (foot.0 + 0.75 * TRIAD * u, foot.1 + 0.75 * TRIAD * v);
        if long < 0.05 {
            // Straight at the eye.
            canvas.dot(foot, INK, 3.0);
            continue;
        }
        canvas.line(foot, tip, INK, 1.8);
        let (eu, ev) = (u / long, v / long);
        for side in [-1.0, 1.0] {
            let wing = (tip.0 - 7.0 * eu - side * 3.2 * ev, tip.1 - 7.0 * ev + side * 3.2 * eu);
            canvas.line(wing, tip, INK, 1.8);
        }
        let at = (tip.0 + 12.0 * eu, tip.1 + 12.0 * ev + 0.34 * LABEL_SIZE);
        canvas.text(at, &text::parse(name), LABEL_SIZE, Anchor::Middle);
    }
}
