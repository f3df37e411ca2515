//! A theory at a patch: what conditions of the fraction and of the velocity share.

use super::{ALL, Context, Frame, Place, Wave};
use granflow_base::{Dims, Vec3};
use granflow_dict::Reader;

/// Most paddles of a patch.
const PADDLES: i64 = 1000;

/// Waves that come in through a patch, and how those that arrive are let out.
pub struct Source {
    frame: Frame,
    /// `None` where nothing comes in.
    wave: Option<Box<dyn Wave>>,
    /// Time over which the wave grows to its height, s.
    ramp: f64,
    /// Whether what arrives is let out.
    absorbs: bool,
    /// Parts of the patch, side by side, each with a level of its own.
    paddles: usize,
    /// Lowest and highest point of every face over the patch's lowest, m.
    spans: Vec<[f64; 2]>,
    /// The paddle of every face.
    paddle_of: Vec<u32>,
    /// Depth of the water that comes in, a number for each paddle, m.
    levels: Vec<f64>,
}

impl Source {
    /// Reads the patch's entry of `waveProperties`; mistakes go to the reader's sink.
    pub fn read(r: &Reader<'_>, frame: Frame) -> Source {
        let models: Vec<_> = ALL.iter().map(|e| (e.name, Some(e))).collect();
        let entry = match r.has("waveModel") {
            true => r.opt_one_of("waveModel", &models, None),
            false => {
                r.one_of("waveModel", &models);
                None
            }
        };
        for key in ["U", "alpha", "waterDepthRef", "waterDepth"] {
            r.ignore(key);
        }
        let paddles = r.opt_label_in("nPaddle", 1..=PADDLES, 1) as usize;
        let mut source = Source {
            frame,
            wave: None,
            ramp: 0.0,
            absorbs: true,
            paddles,
            spans: Vec::new(),
            paddle_of: Vec::new(),
            levels: vec![frame.depth; paddles],
        };
        let Some(entry) = entry else {
            // The entries belong to a theory that is not known: nothing can be said of them.
            r.ignore_all();
            return source;
        };
        source.wave = (entry.read)(r, Context { depth: frame.depth, gravity: frame.gravity });
        if entry.ramped {
            source.ramp = r.opt_non_negative("rampTime", Dims::TIME, 0.0);
        }
        if source.wave.is_some() {
            source.absorbs = r.opt_switch("activeAbsorption", false);
        } else {
            r.ignore("activeAbsorption");
        }
        source
    }

    /// Gives the source its faces: `spans` as [`Frame::span`] has them, and the centres.
    #[must_use]
    pub fn on(mut self, spans: Vec<[f64; 2]>, centres: &[Vec3]) -> Source {
        let [low, high] = self.frame.side;
        let width = (high - low).max(f64::MIN_POSITIVE);
        let paddle = |c: &Vec3| {
            let share = (granflow_base::dot(self.frame.y, *c) - low) / width;
            ((share * self.paddles as f64) as usize).min(self.paddles - 1) as u32
        };
        self.paddle_of = centres.iter().map(paddle).collect();
        self.spans = spans;
        self
    }

    /// Whether a wave comes in.
    pub fn makes_waves(&self) -> bool {
        self.wave.is_some()
    }
    /// Number of paddles.
    pub fn paddles(&self) -> usize {
        self.paddles
    }
    /// Whether the level in front of the patch matters.
    pub fn absorbs(&self) -> bool {
        self.absorbs
    }
    /// The paddle of face `i` of the patch.
    pub fn paddle(&self, i: usize) -> usize {
        self.paddle_of[i] as usize
    }

    fn strength(&self, time: f64) -> f64 {
        if self.ramp > 0.0 { (time / self.ramp).clamp(0.0, 1.0) } else { 1.0 }
    }
    fn place(&self, paddle: usize, time: f64) -> Place {
        let [low, high] = self.frame.side;
        let y = low + (paddle as f64 + 0.5) / self.paddles as f64 * (high - low);
        Place { x: self.frame.stands, inside: 0.0, y, time }
    }

    /// Sets the levels to those of the wave at `time`.
    pub fn advance(&mut self, time: f64) {
        let Some(wave) = &self.wave else { return };
        let strength = self.strength(time);
        for paddle in 0..self.paddles {
            let rise = strength * wave.elevation(self.place(paddle, time));
            self.levels[paddle] = (self.frame.depth + rise).max(0.0);
        }
    }

    /// The share of face `i` that is under the wave's surface at the time of [`Self::advance`].
    pub fn wet(&self, i: usize) -> f64 {
        let [low, high] = self.spans[i];
        let above = self.levels[self.paddle(i)] - low;
        // A face that lies flat is wet or dry.
        let height = (high - low).max(f64::MIN_POSITIVE);
        (above / height).clamp(0.0, 1.0)
    }

    /// Velocity on face `i`, m/s: the wave's in the middle of what is wet, over the whole face.
    pub fn velocity(&self, i: usize, time: f64) -> Vec3 {
        let (Some(wave), wet) = (&self.wave, self.wet(i)) else { return [0.0; 3] };
        if wet == 0.0 {
            return [0.0; 3];
        }
        let (paddle, [low, high]) = (self.paddle(i), self.spans[i]);
        let middle = low + 0.5 * wet * (high - low);
        let u = wave.velocity(self.place(paddle, time), middle);
        let k = wet * self.strength(time);
        self.frame.vector(u.map(|u| k * u))
    }

    /// What lets the difference to a measured depth of water out, m/s: a long wave that leaves,
    /// `u = (h - h') sqrt(g/h')`, on the wet part of the patch.
    pub fn absorption(&self, i: usize, wet: f64) -> Vec3 {
        let measured = self.frame.level(wet);
        let target = self.levels[self.paddle(i)];
        let surface = if self.wave.is_some() { target } else { measured };
        if measured <= 0.0 || self.spans[i][0] >= surface {
            return [0.0; 3];
        }
        let u = (target - measured) * (self.frame.gravity / measured).sqrt();
        self.frame.vector([u, 0.0, 0.0])
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use granflow_dict::{Sink, parse_str};

    /// `x` inside of a patch that stands at the origin.
    pub(in crate::waves) fn at(x: f64, time: f64) -> Place {
        Place { x, inside: x, y: 0.0, time }
    }

    /// Greatest less least head on the surface in the frame of a wave of speed `c`, m, at the
    /// places and times that `when` gives for 0 to 64.
    pub(in crate::waves) fn bernoulli(
        wave: &dyn Wave,
        c: f64,
        context: Context,
        when: impl Fn(f64) -> Place,
    ) -> f64 {
        let heads = (0..=64).map(|i| {
            let place = when(f64::from(i));
            let e = wave.elevation(place);
            let [u, _, w] = wave.velocity(place, context.depth + e);
            e + 0.5 * ((u - c).powi(2) + w * w) / context.gravity
        });
        let (low, high) = heads.fold((f64::MAX, f64::MIN), |(l, h), q| (q.min(l), q.max(h)));
        high - low
    }

    /// Volume per second and metre of width under the surface, m2/s.
    pub(in crate::waves) fn flux(wave: &dyn Wave, depth: f64, place: Place) -> f64 {
        const N: usize = 100;
        let top = depth + wave.elevation(place);
        let simpson = (0..=2 * N).map(|i| {
            let weight = [2.0, 4.0][i % 2] - if i == 0 || i == 2 * N { 1.0 } else { 0.0 };
            weight * wave.velocity(place, top * i as f64 / (2 * N) as f64)[0]
        });
        simpson.sum::<f64>() * top / (6 * N) as f64
    }

    /// Greatest divergence in the water, 1/s.
    pub(in crate::waves) fn divergence(wave: &dyn Wave, depth: f64, place: Place) -> f64 {
        let d = 1e-4 * depth;
        let along = |x: f64, z: f64| {
            let p = Place { x: place.x + x, inside: place.inside + x, ..place };
            wave.velocity(p, z)
        };
        let one = |i: i32| {
            let z = depth * f64::from(i) / 10.0;
            let x = (along(d, z)[0] - along(-d, z)[0]) / (2.0 * d);
            x + (along(0.0, z + d)[2] - along(0.0, z - d)[2]) / (2.0 * d)
        };
        (1..10).map(|i| one(i).abs()).fold(0.0, f64::max)
    }

    fn source(text: &str) -> (Source, Sink) {
        let corners = [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 4.0, 1.0], [0.0, 0.0, 1.0]];
        let (g, area) = ([0.0, 0.0, -9.81], [-4.0, 0.0, 0.0]);
        let mut frame = Frame::new(g, area, [0.0, 2.0, 0.5], corners.into_iter()).unwrap();
        frame.depth = 0.5;
        let (dict, _) = parse_str(text);
        let sink = Sink::new();
        let spans = vec![[0.0, 0.4], [0.4, 0.8], [0.8, 1.0]];
        let centres = [[0.0, 1.0, 0.2], [0.0, 3.0, 0.6], [0.0, 3.0, 0.9]];
        (Source::read(&Reader::new(&dict, &sink), frame).on(spans, &centres), sink)
    }

    #[test]
    fn faces_are_wet_up_to_the_wave_and_it_grows_over_its_ramp() {
        let text = "waveModel StokesI; waveHeight 0.2; wavePeriod 4; wavePhase 0; rampTime 2; \
                    activeAbsorption yes; nPaddle 2;";
        let (mut s, sink) = source(text);
        assert!(!sink.has_errors());
        assert_eq!([0, 1, 2].map(|i| s.paddle(i)), [0, 1, 1]);
        s.advance(0.0);
        assert_eq!([s.wet(0), s.wet(2)], [1.0, 0.0]);
        assert!((s.wet(1) - 0.25).abs() < 1e-15);
        assert_eq!(s.velocity(0, 0.0), [0.0; 3]);
        // Four seconds later the crest is there, 0.1 m above still water.
        s.advance(4.0);
        assert!((s.wet(1) - 0.5).abs() < 1e-15);
        let [u, v, w] = s.velocity(0, 4.0);
        assert!(u > 0.0 && v == 0.0 && w.abs() < 1e-12 * u, "{u} {v} {w}");
        // 0.7 m of water in front of a wave of 0.6 m leave as a long wave does.
        let [u, ..] = s.absorption(0, 0.7);
        assert!((u + 0.1 * (9.81f64 / 0.7).sqrt()).abs() < 1e-12);
        assert_eq!(s.absorption(2, 0.7), [0.0; 3]);
    }

    #[test]
    fn absorption_alone_is_wet_up_to_what_arrives() {
        let (s, sink) = source("waveModel shallowWaterAbsorption; nPaddle 1;");
        assert!(!sink.has_errors() && !s.makes_waves() && s.absorbs());
        let [u, ..] = s.absorption(2, 0.9);
        assert!((u + 0.4 * (9.81f64 / 0.9).sqrt()).abs() < 1e-12);
        assert_eq!(s.absorption(2, 0.75), [0.0; 3]);
    }

    #[test]
    fn a_misspelt_theory_is_named_with_its_neighbour() {
        let (_, sink) = source("waveModel StokesIII; waveHeight 0.2;");
        let text = sink.take().to_string();
        assert!(text.contains("unknown value `StokesIII`"), "{text}");
        assert!(text.contains("did you mean `StokesI"), "{text}");
        let (_, sink) = source("waveModel StokesV; waveHeight 0.6; wavePeriod 2;");
        assert!(sink.take().to_string().contains("higher than the water is deep"));
        let (_, sink) = source("waveModel McCowan; waveHeight 0.43;");
        assert!(sink.take().to_string().contains("0.8600 of the depth"));
    }
}
