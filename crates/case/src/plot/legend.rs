//! The legend: how large it is, where it does not cover data, and how it is drawn.

use super::canvas::{Anchor, Box2, Canvas, Point};
use super::line::{self, Style};
use super::text::{self, Run};
use super::{Marker, Rgb};

/// Size of the text.
const SIZE: f64 = 15.0;
/// From one entry to the next.
const ROW: f64 = 22.0;
/// Length of the sample of a line.
const SAMPLE: f64 = 34.0;
/// Between sample and text.
const GAP: f64 = 9.0;
/// Inside the frame.
const PAD: f64 = 9.0;
/// From the frame of the axes (or of the legend) to the legend (or the data).
const CLEAR: f64 = 8.0;

/// One entry.
pub(super) struct Entry {
    name: Vec<Run>,
    style: Style,
    colour: Rgb,
}

impl Entry {
    pub(super) fn new(name: &str, style: Style, colour: Rgb) -> Self {
        Entry { name: text::parse(name), style, colour }
    }
}

/// Width and height of the legend.
pub(super) fn size(entries: &[Entry]) -> (f64, f64) {
    let widest = entries.iter().map(|e| text::width(&e.name, SIZE)).fold(0.0, f64::max);
    (2.0 * PAD + SAMPLE + GAP + widest, 2.0 * PAD + ROW * entries.len() as f64 - 4.0)
}

/// A corner of the axes' frame where the legend covers nothing that is drawn.
pub(super) fn free_corner(
    frame: Box2,
    (w, h): (f64, f64),
    lines: &[Vec<Point>],
    markers: &[Point],
) -> Option<Box2> {
    if w + 4.0 * CLEAR > frame.width() || h + 4.0 * CLEAR > frame.height() {
        return None;
    }
    let inner = frame.grown(-1.5 * CLEAR);
    let at = |left: f64, top: f64| Box2 { left, top, right: left + w, bottom: top + h };
    [
        at(inner.right - w, inner.top),
        at(inner.left, inner.bottom - h),
        at(inner.right - w, inner.bottom - h),
        at(inner.left, inner.top),
    ]
    .into_iter()
    .find(|corner| {
        let space = corner.grown(CLEAR);
        let crossed = |l: &Vec<Point>| l.windows(2).any(|s| space.clip(s[0], s[1]).is_some());
        let marked = |p: &Point| space.contains(*p);
        !lines.iter().any(crossed) && !markers.iter().any(marked)
    })
}

/// Draws the entries into a box of [`size`].
pub(super) fn draw(canvas: &mut Canvas, place: Box2, entries: &[Entry]) {
    canvas.rect(place, Some(Rgb(255, 255, 255)), Some((Rgb(190, 190, 190), 1.0)));
    let left = place.left + PAD;
    for (i, e) in entries.iter().enumerate() {
        let y = place.top + PAD + ROW * (i as f64 + 0.5) - 2.0;
        let ends = vec![(left, y), (left + SAMPLE, y)];
        match e.style {
            Style::Line => canvas.polyline(ends, e.colour, line::WIDTH),
            Style::Dashed => {
                canvas.dashed(&ends, e.colour, line::WIDTH, line::DASH.0, line::DASH.1);
            }
            Style::Markers(kind) => sample(canvas, (left + 0.5 * SAMPLE, y), kind, e.colour),
        }
        let baseline = (left + SAMPLE + GAP, y + 0.36 * SIZE);
        canvas.text(baseline, &e.name, SIZE, Anchor::Start);
    }
}

fn sample(canvas: &mut Canvas, at: Point, kind: Marker, colour: Rgb) {
    canvas.marker(at, kind, colour, line::RADIUS, line::MARKER_WIDTH);
}
