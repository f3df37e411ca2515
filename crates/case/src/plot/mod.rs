//! Figures: the only place that knows the plotting library (kuva).
//!
//! [`LineFigure`] draws curves and markers over two axes, good enough for a paper: decades on
//! logarithmic axes, sub- and superscripts, a legend that keeps off the data, colours that people
//! with colour vision deficiencies can tell apart (Okabe and Ito 2008), markers that survive
//! black-and-white printing. [`SliceFigure`] draws a field over a plane, [`SolidFigure`] surfaces in
//! space; their colours are pixels of our own under the same axes and texts. The same layout gives SVG
//! and PNG, without any font of the system.

mod axis;
mod canvas;
mod colour;
mod frame;
mod image;
mod labels;
mod legend;
mod line;
mod raster;
mod slice;
mod solid;
mod text;

pub use axis::{Axis, Scale, round_levels};
pub use colour::ColourMap;
pub use frame::Shades;
pub use line::{Legend, LineFigure, Series, Style};
pub use slice::{Arrows, Polyline, SliceFigure};
pub use solid::{Facet, Paint, Sheet, SolidFigure};
pub use text::literal;

/// A colour: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

impl Rgb {
    /// Black; for a reference curve.
    pub const BLACK: Rgb = Rgb(0, 0, 0);
}

/// Colours of series that do not choose one (Okabe and Ito 2008, without the yellow that
/// vanishes on white).
pub const PALETTE: [Rgb; 7] = [
    Rgb(0, 114, 178),
    Rgb(213, 94, 0),
    Rgb(0, 158, 115),
    Rgb(204, 121, 167),
    Rgb(86, 180, 233),
    Rgb(230, 159, 0),
    Rgb(0, 0, 0),
];

/// The shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Open circle.
    Circle,
    /// Open square.
    Square,
    /// Open triangle.
    Triangle,
    /// Open diamond.
    Diamond,
    /// Upright cross.
    Plus,
    /// Diagonal cross.
    Cross,
}

impl Marker {
    /// Every shape, in the order series take them.
    pub const ALL: [Marker; 6] = [
        Marker::Circle,
        Marker::Square,
        Marker::Triangle,
        Marker::Diamond,
        Marker::Plus,
        Marker::Cross,
    ];

    /// A shape for the `i`-th series; they repeat after six.
    pub fn nth(i: usize) -> Marker {
        Self::ALL[i % Self::ALL.len()]
    }
}

/// Why a figure could not be turned into pixels.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The magnification is not a usable number.
    #[error("figures are drawn at 0.1 to 20 pixels per unit, not {0}")]
    Scale(f64),
    /// The rasteriser gave up.
    #[error("cannot draw the figure: {0}")]
    Raster(String),
    /// The picture could not be decoded.
    #[error("cannot draw the figure: {0}")]
    Decode(#[from] png::DecodingError),
    /// The picture could not be encoded.
    #[error("cannot draw the figure: {0}")]
    Encode(#[from] png::EncodingError),
}
