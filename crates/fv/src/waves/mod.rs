//! Water waves that come in through a patch, by theory.
//!
//! Coordinates are those of the patch: x along its inward normal, y along it, z up from its lowest
//! point. A theory says how high the surface stands above still water and how the water below it
//! moves; [`Source`] makes conditions of that.
//!
//! To add a theory: one file here, and one line in [`ALL`].

mod absorption;
mod boussinesq;
mod cnoidal;
mod elliptic;
mod fifth;
mod frame;
mod grimshaw;
mod irregular;
mod mccowan;
mod progressive;
mod solitary;
mod source;
mod stokes;
mod stream;

pub use frame::Frame;
pub use source::Source;

use granflow_base::Vec3;
use granflow_dict::Reader;

/// Where and when a theory is asked.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Along the inward normal of the patch, m, from the origin of the case.
    pub x: f64,
    /// Distance into the domain from the patch, m.
    pub inside: f64,
    /// Along the patch, m, from the origin of the case.
    pub y: f64,
    /// Time, s.
    pub time: f64,
}

/// A wave as a theory has it.
pub trait Wave: Send + Sync {
    /// Height of the surface above still water, m.
    fn elevation(&self, at: Place) -> f64;
    /// Velocity along x, along y and upwards at `z` above the bottom, m/s.
    fn velocity(&self, at: Place, z: f64) -> Vec3;
}

/// What a theory is told beside its own entries.
#[derive(Clone, Copy, Debug)]
pub struct Context {
    /// Depth of still water, m.
    pub depth: f64,
    /// Gravity, m/s2.
    pub gravity: f64,
}

/// One theory of the registry.
pub struct Entry {
    /// The word behind `waveModel`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// The surface it makes: `H` the height from trough to crest, `h` the depth, `a` the angle, `X` the
    /// distance from the crest, `theta` the phase.
    pub formula: &'static str,
    /// Where the theory comes from.
    pub reference: &'static str,
    /// Whether the wave grows over `rampTime`.
    pub ramped: bool,
    /// Reader; `None` where nothing comes in.
    pub read: fn(&Reader<'_>, Context) -> Option<Box<dyn Wave>>,
}

/// Every theory, by its OpenFOAM name.
pub const ALL: &[Entry] = &[
    stokes::FIRST,
    stokes::SECOND,
    fifth::ENTRY,
    cnoidal::ENTRY,
    stream::ENTRY,
    irregular::ENTRY,
    boussinesq::ENTRY,
    grimshaw::ENTRY,
    mccowan::ENTRY,
    absorption::ENTRY,
];
