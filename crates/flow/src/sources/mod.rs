//! Forces on the bulk beside gravity: what OpenFOAM calls fvOptions.
//!
//! Every source adds a force per volume `body - sink U` to momentum: the sink is implicit. To add one:
//! a file here, a line in [`Source`] and where it is applied, and its reader in `case/config/sources.rs`.

mod mean_velocity;
mod porous;
mod semi_implicit;

pub use mean_velocity::MeanVelocity;
pub use porous::Porous;
pub use semi_implicit::SemiImplicit;

use crate::Flow;
use granflow_base::{Value, Vec3};

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
}

/// A force on the bulk.
#[derive(Clone, Debug)]
pub enum Source {
    /// Given, perhaps less a drag.
    SemiImplicit(SemiImplicit),
    /// Drag of a porous body.
    Porous(Porous),
    /// As much as a given mean velocity takes.
    MeanVelocity(MeanVelocity),
}

/// What a source sees.
pub(crate) struct Seen<'a> {
    pub(crate) time: f64,
    /// Velocity in the cells, m/s.
    pub(crate) u: &'a [Vec3],
    /// Density, kg/m3.
    pub(crate) rho: &'a [f64],
    /// Viscosity, Pa s.
    pub(crate) eta: &'a [f64],
}

impl Flow {
    /// Whether there are forces on the bulk beside gravity.
    pub(crate) fn has_sources(&self) -> bool {
        !self.sources.is_empty()
    }

    /// Force per volume and sink of the flow as it stands, into `work.body` and `work.sink`.
    pub(crate) fn apply_sources(&mut self) {
        if !self.has_sources() && !self.numerics.compatible {
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
        let seen =
            Seen { time: state.time, u: &state.u.cells.data, rho: &w.rho.data, eta: &w.eta.data };
        for source in sources {
            match source {
                Source::SemiImplicit(s) => s.add(&seen, n, body, sink),
                Source::Porous(s) => s.add(&seen, n, compatible, body, sink),
                Source::MeanVelocity(s) => s.add(n, body),
            }
        }
    }

    /// At the beginning of a step: what holds a mean velocity remembers where it stood.
    pub(crate) fn begin_sources(&mut self) {
        for source in &mut self.sources {
            if let Source::MeanVelocity(m) = source {
                // What a restart does not know the next step may not either.
                (m.start, m.last, m.response) = (m.gradient, None, None);
            }
        }
    }

    /// Lets `before` be what a step that is taken back goes back to.
    pub(crate) fn remember_sources(&mut self, before: &[Source]) {
        for (now, before) in self.sources.iter_mut().zip(before) {
            if let (Source::MeanVelocity(now), Source::MeanVelocity(before)) = (now, before) {
                now.start = before.gradient;
            }
        }
    }

    /// Back to the beginning of the step.
    pub(crate) fn rollback_sources(&mut self) {
        for source in &mut self.sources {
            if let Source::MeanVelocity(m) = source {
                (m.gradient, m.last) = (m.start, None);
            }
        }
    }

    /// Whether the sources stay as they are from now to the time `end`.
    pub(crate) fn sources_stay(&self, end: f64) -> bool {
        let now = self.state.time;
        self.sources.iter().all(|s| match s {
            Source::SemiImplicit(SemiImplicit { window: [first, last], .. }) => {
                let on = *first <= now && *last >= end;
                on || *last < now || *first > end
            }
            Source::Porous(_) | Source::MeanVelocity(_) => true,
        })
    }

    /// Pressure gradients that hold mean velocities, in the order of the sources, Pa/m.
    pub fn mean_gradients(&self) -> Vec<f64> {
        let of = |s: &Source| match s {
            Source::MeanVelocity(m) => Some(m.gradient),
            _ => None,
        };
        self.sources.iter().filter_map(of).collect()
    }
}
