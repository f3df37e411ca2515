//! Waves that come in through a patch, and those that are let out.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::waves::Source;
use granflow_base::{Vec3, add, norm};
use granflow_dict::Reader;

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

pub(super) const ALPHA: Entry = Entry {
    name: "waveAlpha",
    summary: "of a volume fraction: the share of each face under the surface of the wave that \
              `constant/waveProperties` gives for the patch",
    formula: "alpha_f = share of the face below z = depth + eta(x, y, t)",
    keys: &[],
    reference: "P. Higuera, J. L. Lara, I. J. Losada, Coastal Eng. 71 (2013) 102",
    scalar: Some(wave_alpha),
    vector: None,
};
pub(super) const VELOCITY: Entry = Entry {
    name: "waveVelocity",
    summary: "the velocity of the wave that `constant/waveProperties` gives for the patch, and \
              absorption of what arrives",
    formula: "U_f = w u(x, y, z, t), u: the wave's velocity in the middle of the wet part of the face, w: that \
              part; with activeAbsorption + (h_wave - h) sqrt(g/h) inwards, h: depth of the water in front \
              of the paddle",
    keys: &[],
    reference: "P. Higuera, J. L. Lara, I. J. Losada, Coastal Eng. 71 (2013) 102",
    scalar: None,
    vector: Some(wave_velocity),
};

fn wave_alpha(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_wave(r);
    Box::new(WaveAlpha { source: c.wave.map(|w| w.source()) })
}
fn wave_velocity(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_wave(r);
    Box::new(WaveVelocity { source: c.wave.map(|w| w.source()) })
}
/// What waves are is in `constant/waveProperties`, whatever the condition's name for that is.
fn leave_wave(r: &Reader<'_>) {
    leave_value(r);
    if r.opt_word("waveDictName", "waveProperties") != "waveProperties" {
        let message = "waves are read from `constant/waveProperties` only";
        r.error_at_key("waveDictName", message, "another file", None);
    }
}
