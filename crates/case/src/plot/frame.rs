//! What figures over two axes have in common: the frame with its ticks, the colour bar.

use super::Rgb;
use super::axis::{Axis, Ruler, Tick};
use super::canvas::{Anchor, Box2, Canvas};
use super::colour::{ColourMap, Table, luminance};
use super::raster::Raster;
use super::text;

pub(super) const TITLE_SIZE: f64 = 18.0;
pub(super) const LABEL_SIZE: f64 = 19.0;
pub(super) const TICK_SIZE: f64 = 16.0;
pub(super) const INK: Rgb = Rgb(26, 26, 26);

/// Width of the label of a tick.
pub(super) fn label_width(label: &str) -> f64 {
    text::width(&text::parse(label), TICK_SIZE)
}

/// Width of the widest label of an axis.
pub(super) fn widest(ruler: &Ruler) -> f64 {
    ruler.ticks.iter().filter_map(|t| t.label.as_deref()).map(label_width).fold(0.0, f64::max)
}

/// The frame with ticks that point inwards, on all four sides, and their labels.
pub(super) fn ticks(canvas: &mut Canvas, b: Box2, x: &Ruler, y: &Ruler) {
    let x_at = |t: &Tick| x.place(t.value).map(|u| b.left + u * b.width());
    let y_at = |t: &Tick| y.place(t.value).map(|v| b.bottom - v * b.height());
    for t in &x.ticks {
        let Some(x) = x_at(t) else { continue };
        let long = if t.label.is_some() { 7.0 } else { 4.0 };
        canvas.line((x, b.bottom), (x, b.bottom - long), INK, 1.2);
        canvas.line((x, b.top), (x, b.top + long), INK, 1.2);
        if let Some(label) = &t.label {
            let at = (x, b.bottom + 1.4 * TICK_SIZE);
            canvas.text(at, &text::parse(label), TICK_SIZE, Anchor::Middle);
        }
    }
    for t in &y.ticks {
        let Some(y) = y_at(t) else { continue };
        let long = if t.label.is_some() { 7.0 } else { 4.0 };
        canvas.line((b.left, y), (b.left + long, y), INK, 1.2);
        canvas.line((b.right, y), (b.right - long, y), INK, 1.2);
        if let Some(label) = &t.label {
            let at = (b.left - 9.0, y + 0.36 * TICK_SIZE);
            canvas.text(at, &text::parse(label), TICK_SIZE, Anchor::End);
        }
    }
    canvas.rect(b, None, Some((INK, 1.4)));
    if x.factor != 0 {
        let at = (b.right, b.bottom + 3.1 * TICK_SIZE);
        canvas.text(at, &factor(x.factor), TICK_SIZE, Anchor::End);
    }
    if y.factor != 0 {
        canvas.text((b.left, b.top - 7.0), &factor(y.factor), TICK_SIZE, Anchor::Start);
    }
}

fn factor(exponent: i32) -> Vec<text::Run> {
    text::parse(&format!("×10^{{{exponent}}}"))
}

/// How values become colours, and what the bar says about it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shades {
    /// Colours.
    pub map: ColourMap,
    /// Values of the map's ends.
    pub range: (f64, f64),
    /// Label of the bar.
    pub label: String,
}

impl Shades {
    /// Where in the map a value lies.
    pub(super) fn share(&self, v: f64) -> f64 {
        (v - self.range.0) / (self.range.1 - self.range.0)
    }
}

/// A colour bar made concrete.
pub(super) struct Bar<'a> {
    shades: &'a Shades,
    ruler: Ruler,
    table: Table,
}

const BAR: f64 = 18.0;
/// Room between a frame and the bar beside it.
pub(super) const GAP: f64 = 22.0;

impl<'a> Bar<'a> {
    pub(super) fn new(shades: &'a Shades, height: f64) -> Bar<'a> {
        let axis = Axis::linear("").ranged(shades.range.0, shades.range.1);
        let ruler = Ruler::new(&axis, std::iter::empty(), (height / 55.0) as usize);
        Bar { shades, ruler, table: Table::new(shades.map) }
    }

    pub(super) fn colour(&self, value: f64) -> Rgb {
        self.table.at(self.shades.share(value))
    }

    /// Ink that is seen on the colour of a value.
    pub(super) fn ink_on(&self, value: f64) -> Rgb {
        if luminance(self.colour(value)) > 0.18 { INK } else { Rgb(255, 255, 255) }
    }

    /// A value as the labels of the bar write it, with four digits at most.
    pub(super) fn number(&self, value: f64) -> Vec<text::Run> {
        let v = value / 10f64.powi(self.ruler.factor);
        let size = self.shades.range.0.abs().max(self.shades.range.1.abs())
            / 10f64.powi(self.ruler.factor);
        let decimals = (3.0 - size.log10().floor()).clamp(0.0, 12.0) as usize;
        let text = super::axis::fixed(v, decimals);
        let short = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        text::parse(short)
    }

    /// Width of the bar with its labels.
    pub(super) fn width(&self) -> f64 {
        let label = if self.shades.label.is_empty() { 0.0 } else { 1.6 * LABEL_SIZE };
        BAR + 9.0 + widest(&self.ruler) + label
    }

    /// Room above it for the power of ten.
    pub(super) fn above(&self) -> f64 {
        if self.ruler.factor == 0 { 0.0 } else { 1.5 * TICK_SIZE }
    }

    /// Draws it with its upper left corner at `at`; `levels` are values that get a line.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        raster: &mut Raster,
        at: (f64, f64),
        height: f64,
        levels: &[f64],
    ) {
        let b = Box2 { left: at.0, top: at.1, right: at.0 + BAR, bottom: at.1 + height };
        raster.confine(b);
        let corner = |x: f64, y: f64| [x, y, 0.0];
        let (tl, tr) = (corner(b.left, b.top), corner(b.right, b.top));
        let (bl, br) = (corner(b.left, b.bottom), corner(b.right, b.bottom));
        raster.triangle([tl, tr, bl], 1.0, |s| self.table.at(s[0] + s[1]));
        raster.triangle([tr, br, bl], 1.0, |s| self.table.at(s[0]));
        let y_at = |v: f64| self.ruler.place(v).map(|t| b.bottom - t * height);
        let inside = |y: &f64| (b.top..=b.bottom).contains(y);
        for level in levels {
            if let Some(y) = y_at(*level).filter(inside) {
                let line = vec![(b.left + 1.0, y), (b.right - 1.0, y)];
                canvas.line_over(line, self.ink_on(*level), 1.2);
            }
        }
        canvas.rect(b, None, Some((INK, 1.2)));
        for t in &self.ruler.ticks {
            let (Some(y), Some(label)) = (y_at(t.value), &t.label) else { continue };
            canvas.line((b.right, y), (b.right + 4.0, y), INK, 1.2);
            let at = (b.right + 8.0, y + 0.36 * TICK_SIZE);
            canvas.text(at, &text::parse(label), TICK_SIZE, Anchor::Start);
        }
        if self.ruler.factor != 0 {
            let at = (b.left, b.top - 0.6 * TICK_SIZE);
            canvas.text(at, &factor(self.ruler.factor), TICK_SIZE, Anchor::Start);
        }
        if !self.shades.label.is_empty() {
            let x = b.left + self.width() - 0.2 * LABEL_SIZE;
            let middle = (x, 0.5 * (b.top + b.bottom));
            canvas.text_upwards(middle, text::parse(&self.shades.label), LABEL_SIZE);
        }
    }
}
