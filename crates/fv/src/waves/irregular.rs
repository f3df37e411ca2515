//! A sea of many small waves of their own heights, periods, phases and directions.

use super::progressive::{ratios, wave_number};
use super::{Context, Entry, Place, Wave};
use granflow_base::Vec3;
use granflow_dict::Reader;
use std::f64::consts::TAU;

pub(super) const ENTRY: Entry = Entry {
    name: "irregularMultiDirectional",
    summary: "the sum of small waves given one by one: `wavePeriods`, `waveHeights`, `wavePhases` \
              and `waveDirs` (degrees), each a list of lists",
    formula: "eta = sum_i (H_i/2) cos(k_i (x cos a_i + y sin a_i) - omega_i t + phi_i), \
              omega_i^2 = g k_i tanh(k_i h)",
    reference: "R. G. Dean, R. A. Dalrymple, Water Wave Mechanics for Engineers and Scientists, \
                1991, ch. 7",
    ramped: true,
    read: |r, context| Some(Box::new(Sea::read(r, context))),
};

struct Component {
    amplitude: f64,
    omega: f64,
    k: f64,
    phase: f64,
    direction: [f64; 2],
}

struct Sea {
    h: f64,
    components: Vec<Component>,
}

/// The numbers of a list of lists, and the lengths of the inner ones.
fn rows(r: &Reader<'_>, key: &str) -> (Vec<f64>, Vec<usize>) {
    let (mut all, mut lengths) = (Vec::new(), Vec::new());
    let Some(mut outer) = r.list(key) else { return (all, lengths) };
    while !outer.is_empty() {
        // `3 (a b c)` is a list as well.
        outer.opt_label();
        let Some(mut inner) = outer.list("a list of numbers") else { break };
        let before = all.len();
        while !inner.is_empty() {
            all.push(inner.number("a number"));
        }
        lengths.push(all.len() - before);
    }
    (all, lengths)
}

impl Sea {
    fn read(r: &Reader<'_>, context: Context) -> Sea {
        let (periods, shape) = rows(r, "wavePeriods");
        let mut others = Vec::new();
        for key in ["waveHeights", "wavePhases", "waveDirs"] {
            let (numbers, found) = rows(r, key);
            if found != shape && !found.is_empty() {
                let message = format!("`{key}` and `wavePeriods` need lists of the same lengths");
                let label = format!("{} numbers, not {}", numbers.len(), periods.len());
                r.error_at_key(key, message, label, None);
            }
            others.push(numbers);
        }
        if let Some(wrong) = periods.iter().find(|t| **t <= 0.0) {
            r.error_at_key("wavePeriods", "a period is above zero", format!("has {wrong}"), None);
        }
        let get = |list: usize, i: usize| others[list].get(i).copied().unwrap_or(0.0);
        let component = |(i, period): (usize, &f64)| {
            let angle = get(2, i).to_radians();
            Component {
                amplitude: 0.5 * get(0, i),
                omega: TAU / period,
                k: wave_number(*period, context),
                phase: get(1, i),
                direction: [angle.cos(), angle.sin()],
            }
        };
        let all = periods.iter().enumerate().map(component);
        // What has no height does nothing.
        Sea { h: context.depth, components: all.filter(|c| c.amplitude != 0.0).collect() }
    }
}

impl Component {
    fn theta(&self, at: Place) -> f64 {
        let [c, s] = self.direction;
        self.k * (c * at.x + s * at.y) - self.omega * at.time + self.phase
    }
}

impl Wave for Sea {
    fn elevation(&self, at: Place) -> f64 {
        self.components.iter().map(|c| c.amplitude * c.theta(at).cos()).sum()
    }
    fn velocity(&self, at: Place, z: f64) -> Vec3 {
        let mut u = [0.0; 3];
        for c in &self.components {
            let [cosh, sinh] = ratios(c.k, z.min(self.h), self.h);
            let (sin, cos) = c.theta(at).sin_cos();
            let along = c.amplitude * c.omega * cosh * cos;
            u[0] += along * c.direction[0];
            u[1] += along * c.direction[1];
            u[2] += c.amplitude * c.omega * sinh * sin;
        }
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::progressive::Progressive;
    use crate::waves::source::tests::at;
    use crate::waves::stokes::Stokes;
    use granflow_dict::{Sink, parse_str};

    const STILL: Context = Context { depth: 2.0, gravity: 9.81 };

    #[test]
    fn two_components_are_two_small_waves() {
        let text = "wavePeriods 1 ( (3 2) ); waveHeights ((0.02 0.01)); \
                    wavePhases 1 (2(0.4 1)); waveDirs ((0 30));";
        let (dict, _) = parse_str(text);
        let sink = Sink::new();
        let sea = Sea::read(&Reader::new(&dict, &sink), STILL);
        assert!(!sink.has_errors());
        let one = |height, period, phase, angle: f64| {
            let direction = [angle.to_radians().cos(), angle.to_radians().sin()];
            let wave = Progressive { height, period, direction, phase };
            Stokes::new(wave, STILL, false)
        };
        let (a, b) = (one(0.02, 3.0, 0.4, 0.0), one(0.01, 2.0, 1.0, 30.0));
        for i in 0..5 {
            let p = Place { y: 0.6, ..at(0.2, 0.5 * f64::from(i)) };
            let off = sea.elevation(p) - a.elevation(p) - b.elevation(p);
            assert!(off.abs() < 1e-16);
            let (u, v, w) = (sea.velocity(p, 1.1), a.velocity(p, 1.1), b.velocity(p, 1.1));
            assert!((0..3).all(|c| (u[c] - v[c] - w[c]).abs() < 1e-15));
        }
    }

    #[test]
    fn lists_of_other_lengths_are_refused() {
        let text = "wavePeriods ((3 2)); waveHeights ((1)); wavePhases ((0 0)); waveDirs ((0 0));";
        let (dict, _) = parse_str(text);
        let sink = Sink::new();
        Sea::read(&Reader::new(&dict, &sink), STILL);
        assert!(sink.take().to_string().contains("1 numbers, not 2"));
    }
}
