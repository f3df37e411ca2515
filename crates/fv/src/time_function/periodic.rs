//! Sine and square waves: `amplitude wave(frequency (t - t0)) scale + level`.

use super::{Form, Settings, TimeFunction, ones};
use granflow_base::{Dims, Value};
use std::f64::consts::TAU;
use std::sync::Arc;

/// What repeats.
enum Wave {
    /// `sin(2 pi x)`.
    Sine,
    /// +1 for this share of a period, then -1; +1 before `t0` (as observed of OpenFOAM v1912).
    Square(f64),
}

struct Periodic<T> {
    wave: Wave,
    amplitude: TimeFunction<f64>,
    /// 1/s.
    frequency: TimeFunction<f64>,
    /// s.
    t0: f64,
    scale: TimeFunction<T>,
    level: TimeFunction<T>,
}

impl<T: Value> Form<T> for Periodic<T> {
    fn at(&self, time: f64) -> T {
        let x = self.frequency.at(time) * (time - self.t0);
        let wave = match self.wave {
            Wave::Sine => (TAU * x).sin(),
            Wave::Square(share) if x % 1.0 < share => 1.0,
            Wave::Square(_) => -1.0,
        };
        let amplitude = self.amplitude.at(time) * wave;
        self.level.at(time).axpy(amplitude, self.scale.at(time))
    }
}

fn read<T: Value>(s: &Settings<'_, '_>, wave: Wave) -> Option<Arc<dyn Form<T>>> {
    Some(Arc::new(Periodic {
        wave,
        amplitude: s.opt_function("amplitude", 1.0),
        frequency: s.function("frequency"),
        t0: s.r.opt_scalar("t0", Dims::TIME, 0.0),
        scale: s.opt_function("scale", ones()),
        level: s.opt_function("level", T::ZERO),
    }))
}

/// `sine`.
pub(super) fn sine<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    read(s, Wave::Sine)
}

/// `square`, high for `markSpace` times as long as low.
pub(super) fn square<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    let ratio = s.r.opt_positive("markSpace", Dims::NONE, 1.0);
    read(s, Wave::Square(ratio / (1.0 + ratio)))
}
