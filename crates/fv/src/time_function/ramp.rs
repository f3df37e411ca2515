//! From 0 at `start` to 1 a `duration` later.

use super::{Form, Settings};
use granflow_base::{Dims, Value};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

struct Ramp {
    /// s.
    start: f64,
    /// s.
    duration: f64,
    /// From the share of the time to the share of the rise.
    shape: fn(f64) -> f64,
}

impl<T: Value> Form<T> for Ramp {
    fn at(&self, time: f64) -> T {
        let share = ((time - self.start) / self.duration).clamp(0.0, 1.0);
        super::all::<T>((self.shape)(share))
    }
}

fn read<T: Value>(s: &Settings<'_, '_>, shape: fn(f64) -> f64) -> Option<Arc<dyn Form<T>>> {
    let start = s.r.opt_scalar("start", Dims::TIME, 0.0);
    let duration = s.r.positive("duration", Dims::TIME);
    Some(Arc::new(Ramp { start, duration, shape }))
}

/// A straight line.
pub(super) fn linear<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, |x| x)
}
/// A parabola that begins level.
pub(super) fn quadratic<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, |x| x * x)
}
/// A quarter of a sine, which ends level.
pub(super) fn quarter_sine<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, |x| (FRAC_PI_2 * x).sin())
}
/// A quarter of a cosine, which begins level.
pub(super) fn quarter_cosine<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, |x| 1.0 - (FRAC_PI_2 * x).cos())
}
/// Half a cosine, level at both ends.
pub(super) fn half_cosine<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, |x| 0.5 * (1.0 - (PI * x).cos()))
}
