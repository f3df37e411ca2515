//! Forces on the bulk beside gravity: what OpenFOAM calls fvOptions.
//!
//! Every source adds a force per volume `body - sink U` to momentum: the sink is implicit. To add one:
//! a file here with its [`Entry`], and a line in [`ALL`].

mod axes;
mod frame;
mod given;
mod mean_velocity;
mod porous;
mod semi_implicit;

pub use axes::axes_of;
pub use frame::RotatingFrame;
pub use given::Given;
pub use mean_velocity::MeanVelocity;
pub use porous::Porous;
pub use semi_implicit::SemiImplicit;

use crate::Flow;
use granflow_base::{Value, Vec3};

/// A source in a case: the names of its type, and what reads it.
pub struct Entry {
    /// The types in `fvOptions` that it serves, the usual one first.
    pub names: &'static [&'static str],
    /// One line for lists and the book.
    pub summary: &'static str,
    /// The force per volume (per density of it with one fluid), `U` the velocity.
    pub formula: &'static str,
    /// Where it comes from.
    pub reference: &'static str,
    /// Reads one entry of `fvOptions`: a source for every force in it. Mistakes go to the reader's sink.
    pub read: fn(&Given<'_, '_>) -> Vec<Box<dyn Source>>,
}

/// All sources.
pub const ALL: &[Entry] = &[semi_implicit::ENTRY, porous::ENTRY, mean_velocity::ENTRY];

/// The cells that a source acts on, by their numbers on this rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Zone {
    /// All.
    All,
    /// Some.
    Cells(Vec<u32>),
}

impl Zone {
    /// Calls `f` for every cell of a mesh with `n` cells.
    pub(crate) fn each(&self, n: usize, mut f: impl FnMut(usize)) {
        match self {
            Zone::All => (0..n).for_each(f),
            Zone::Cells(cells) => cells.iter().for_each(|c| f(*c as usize)),
        }
    }
    /// Whether both have a cell in common.
    pub fn meets(&self, other: &Zone) -> bool {
        match (self, other) {
            (Zone::Cells(a), Zone::Cells(b)) => {
                let of: std::collections::HashSet<u32> = a.iter().copied().collect();
                b.iter().any(|c| of.contains(c))
            }
            (Zone::All, Zone::Cells(c)) | (Zone::Cells(c), Zone::All) => !c.is_empty(),
            (Zone::All, Zone::All) => true,
        }
    }
}

/// A force on the bulk.
pub trait Source: Send + Sync {
    /// The name of its entry.
    fn name(&self) -> &str;
    /// Its type, as `fvOptions` has it.
    fn kind(&self) -> &'static str;
    /// Where it acts.
    fn zone(&self) -> &Zone;
    /// The same, to be made that of one rank.
    fn zone_mut(&mut self) -> &mut Zone;
    /// What it does, for a person: `a force of (1 0 0) N/m3`, with numbers as `number` writes them.
    fn says(&self, number: &dyn Fn(f64) -> String) -> String;
    /// Adds force per volume (N/m3) and sink (kg/(m3 s)) in its zone, of a mesh with `n` cells.
    fn add(&self, seen: &Seen<'_>, n: usize, body: &mut [Vec3], sink: &mut [f64]);
    /// Whether it stays as it is from one time to another, s.
    fn stays(&self, _from: f64, _to: f64) -> bool {
        true
    }
    /// The held mean velocity, where it is one: its force follows from the flow.
    fn held(&self) -> Option<&MeanVelocity> {
        None
    }
    /// The same, to be moved.
    fn held_mut(&mut self) -> Option<&mut MeanVelocity> {
        None
    }
    /// The turning frame, where it is one: fluxes and walls turn too.
    fn frame(&self) -> Option<&RotatingFrame> {
        None
    }
    /// A copy.
    fn boxed(&self) -> Box<dyn Source>;
}

impl Clone for Box<dyn Source> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// What a source sees.
pub struct Seen<'a> {
    /// Time, s.
    pub time: f64,
    /// Velocity in the cells, m/s.
    pub u: &'a [Vec3],
    /// Density, kg/m3.
    pub rho: &'a [f64],
    /// Viscosity, Pa s.
    pub eta: &'a [f64],
    /// Whether the forms are those of OpenFOAM ([`crate::Numerics::compatible`]).
    pub compatible: bool,
}

/// A vector for a person.
fn three(v: Vec3, number: &dyn Fn(f64) -> String) -> String {
    let [x, y, z] = v.map(number);
    format!("({x} {y} {z})")
}

impl Flow {
    /// Whether there are forces on the bulk beside gravity.
    pub(crate) fn has_sources(&self) -> bool {
        !self.sources.is_empty()
    }

    /// Force per volume and sink of the flow as it stands, into `work.body` and `work.sink`.
    pub(crate) fn apply_sources(&mut self) {
        if !self.has_sources() && !self.has_compatible_viscosity() {
            return;
        }
        let compatible = self.numerics.compatible;
        let Flow { exec, mesh, state, work: w, sources, gravity, .. } = self;
        let n = mesh.n_cells;
        let (body, sink) = (&mut w.body.data, &mut w.sink.data);
        let rho = &w.rho.data;
        exec.for_each2(&mut body[..n], &mut sink[..n], |first, body, sink| {
            for (i, (body, sink)) in body.iter_mut().zip(sink).enumerate() {
                (*body, *sink) = (gravity.driving.scaled(rho[first + i]), 0.0);
            }
        });
        let seen = Seen {
            time: state.time,
            u: &state.u.cells.data,
            rho: &w.rho.data,
            eta: &w.eta.data,
            compatible,
        };
        sources.iter().for_each(|s| s.add(&seen, n, body, sink));
    }

    /// At the beginning of a step: what holds a mean velocity remembers where it stood.
    pub(crate) fn begin_sources(&mut self) {
        for m in self.sources.iter_mut().filter_map(|s| s.held_mut()) {
            // What a restart does not know the next step may not either.
            (m.start, m.last, m.response) = (m.gradient, None, None);
        }
    }

    /// Lets `before` be what a step that is taken back goes back to.
    pub(crate) fn remember_sources(&mut self, before: &[Box<dyn Source>]) {
        for (now, before) in self.sources.iter_mut().zip(before) {
            if let (Some(now), Some(before)) = (now.held_mut(), before.held()) {
                now.start = before.gradient;
            }
        }
    }

    /// Back to the beginning of the step.
    pub(crate) fn rollback_sources(&mut self) {
        for m in self.sources.iter_mut().filter_map(|s| s.held_mut()) {
            (m.gradient, m.last) = (m.start, None);
        }
    }

    /// Whether the sources stay as they are from now to the time `end`.
    pub(crate) fn sources_stay(&self, end: f64) -> bool {
        let now = self.state.time;
        self.sources.iter().all(|s| s.stays(now, end))
    }

    /// Pressure gradients that hold mean velocities, in the order of the sources, Pa/m.
    pub fn mean_gradients(&self) -> Vec<f64> {
        self.sources.iter().filter_map(|s| s.held()).map(|m| m.gradient).collect()
    }
}
