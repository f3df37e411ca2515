//! Waves that come in through a patch, and those that are let out.

use super::{Condition, PatchClosure, PatchView};
use crate::waves::Source;
use granflow_base::{Vec3, add, norm};

/// Of a volume fraction: the share of each face under the surface of the wave; the cell's value
/// where nothing comes in.
pub struct WaveAlpha {
    /// `None` before the depth of the water is known.
    pub source: Option<Source>,
}

impl Condition<f64> for WaveAlpha {
    fn name(&self) -> &'static str {
        "waveAlpha"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        let Some(source) = self.source.as_mut().filter(|s| s.makes_waves()) else { return };
        source.advance(view.around.time);
        closure.fix(0.0);
        for (i, offset) in closure.offset.iter_mut().enumerate() {
            *offset = source.wet(i);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

/// Of the velocity: that of the wave, and what lets out the difference between the water in front
/// of the patch and the wave.
pub struct WaveVelocity {
    /// `None` before the depth of the water is known.
    pub source: Option<Source>,
}

impl WaveVelocity {
    /// The source, if it needs to know how much water is in front of the patch.
    fn measuring(&self) -> Option<&Source> {
        self.source.as_ref().filter(|s| s.absorbs())
    }
}

impl Condition<Vec3> for WaveVelocity {
    fn name(&self) -> &'static str {
        "waveVelocity"
    }
    fn n_totals(&self) -> usize {
        self.measuring().map_or(0, |s| 2 * s.paddles())
    }
    /// For each paddle its wet area and its whole area.
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        let (Some(source), fraction) = (self.measuring(), view.around.fraction) else { return };
        if fraction.is_empty() {
            return;
        }
        for (i, s) in view.area.iter().enumerate() {
            let (paddle, area) = (source.paddle(i), norm(*s));
            out[2 * paddle] += area * fraction[view.owner[i] as usize];
            out[2 * paddle + 1] += area;
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let Some(source) = &mut self.source else { return };
        let time = view.around.time;
        source.advance(time);
        for (i, offset) in closure.offset.iter_mut().enumerate() {
            *offset = source.velocity(i, time);
            if !source.absorbs() {
                continue;
            }
            let paddle = source.paddle(i);
            let (wet, whole) = (view.totals[2 * paddle], view.totals[2 * paddle + 1]);
            // Without a fraction nothing is known of the water there.
            if whole > 0.0 {
                *offset = add(*offset, source.absorption(i, wet / whole));
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
