//! Where the time of a run goes.

use std::time::{Duration, Instant};

/// Accumulated wall time of the named stages of a step. Fixed names, no allocation while timing.
#[derive(Clone, Debug)]
pub struct Stages<const N: usize> {
    names: [&'static str; N],
    spent: [Duration; N],
}

impl<const N: usize> Stages<N> {
    /// All stages at zero.
    pub const fn new(names: [&'static str; N]) -> Self {
        Stages { names, spent: [Duration::ZERO; N] }
    }
    /// Adds the time since `since` to `stage` and returns the present moment.
    pub fn lap(&mut self, stage: usize, since: Instant) -> Instant {
        let now = Instant::now();
        self.spent[stage] += now - since;
        now
    }
    /// Name and seconds of each stage.
    pub fn seconds(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.names.iter().zip(&self.spent).map(|(n, d)| (*n, d.as_secs_f64()))
    }
}

/// Wall time since its creation.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Stopwatch(Instant::now())
    }
    /// Seconds since the start.
    pub fn seconds(self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
