//! Colour maps: numbers to colours that people read in the right order.

use super::Rgb;

/// A map from [0, 1] to colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Perceptually uniform, dark blue to yellow; readable without colours and with a colour
    /// vision deficiency (van der Walt & Smith, viridis, 2015).
    #[default]
    Viridis,
    /// Diverging, blue to white to red, for what has two signs (Moreland 2009).
    CoolWarm,
}

/// Colours of a table: finer than eight bits a channel can show.
const ENTRIES: usize = 512;

/// A colour map worked out.
pub(super) struct Table(Vec<Rgb>);

impl Table {
    pub(super) fn new(map: ColourMap) -> Table {
        let at = match map {
            ColourMap::Viridis => viridis,
            ColourMap::CoolWarm => cool_warm,
        };
        Table((0..ENTRIES).map(|i| at(i as f64 / (ENTRIES - 1) as f64)).collect())
    }

    /// The colour at `t`, of the nearer end outside [0, 1].
    pub(super) fn at(&self, t: f64) -> Rgb {
        let i = (t.clamp(0.0, 1.0) * (ENTRIES - 1) as f64).round();
        self.0[if i.is_finite() { i as usize } else { 0 }]
    }
}

/// Relative luminance, 0 for black and 1 for white (IEC 61966-2-1).
pub(super) fn luminance(c: Rgb) -> f64 {
    let [r, g, b] = [c.0, c.1, c.2].map(|v| linear(f64::from(v) / 255.0));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The colour darkened: 1 leaves it, 0 is black.
pub(super) fn shaded(c: Rgb, by: f64) -> Rgb {
    let f = |v: u8| (f64::from(v) * by.clamp(0.0, 1.0)).round() as u8;
    Rgb(f(c.0), f(c.1), f(c.2))
}

/// Viridis at ten even places; between them the map is straight within what an eye can tell.
const VIRIDIS: [[u8; 3]; 10] = [
    [68, 1, 84],
    [72, 40, 120],
    [62, 73, 137],
    [49, 104, 142],
    [38, 130, 142],
    [31, 158, 137],
    [53, 183, 121],
    [110, 206, 88],
    [181, 222, 43],
    [253, 231, 37],
];

fn viridis(t: f64) -> Rgb {
    let s = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (s as usize).min(VIRIDIS.len() - 2);
    let f = |k: usize| {
        let (a, b) = (f64::from(VIRIDIS[i][k]), f64::from(VIRIDIS[i + 1][k]));
        (a + (s - i as f64) * (b - a)).round() as u8
    };
    Rgb(f(0), f(1), f(2))
}

/// The two ends of the diverging map.
const COOL: Rgb = Rgb(59, 76, 192);
const WARM: Rgb = Rgb(180, 4, 38);

/// Interpolation in polar CIELAB through white (K. Moreland, Diverging color maps for scientific
/// visualization, ISVC 2009, sections 5 and 6).
fn cool_warm(t: f64) -> Rgb {
    const WHITE: f64 = 88.0;
    let (cool, warm) = (to_msh(COOL), to_msh(WARM));
    let middle = WHITE.max(cool[0]).max(warm[0]);
    let (end, t) = if t < 0.5 { (cool, 2.0 * t) } else { (warm, 2.0 - 2.0 * t) };
    let hue = turned_hue(end, middle);
    from_msh([end[0] + t * (middle - end[0]), end[1] * (1.0 - t), end[2] + t * (hue - end[2])])
}

/// Hue with which a saturated colour approaches white evenly.
fn turned_hue([m, s, h]: [f64; 3], white: f64) -> f64 {
    if m >= white {
        return h;
    }
    let spin = s * (white * white - m * m).sqrt() / (m * s.sin());
    if h > -std::f64::consts::FRAC_PI_3 { h + spin } else { h - spin }
}

fn linear(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn gamma(v: f64) -> f64 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Reference white D65.
const D65: [f64; 3] = [0.950_47, 1.0, 1.088_83];

/// Magnitude, saturation and hue of a colour in polar CIELAB.
fn to_msh(c: Rgb) -> [f64; 3] {
    let [r, g, b] = [c.0, c.1, c.2].map(|v| linear(f64::from(v) / 255.0));
    let xyz = [
        0.412_4 * r + 0.357_6 * g + 0.180_5 * b,
        0.212_6 * r + 0.715_2 * g + 0.072_2 * b,
        0.019_3 * r + 0.119_2 * g + 0.950_5 * b,
    ];
    let f = |k: usize| {
        let v: f64 = xyz[k] / D65[k];
        if v > 0.008_856 { v.cbrt() } else { 7.787 * v + 16.0 / 116.0 }
    };
    let (x, y, z) = (f(0), f(1), f(2));
    let (l, a, b) = (116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z));
    let m = (l * l + a * a + b * b).sqrt();
    [m, (l / m).acos(), b.atan2(a)]
}

fn from_msh([m, s, h]: [f64; 3]) -> Rgb {
    let (l, a, b) = (m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin());
    let y = (l + 16.0) / 116.0;
    let f = |v: f64, k: usize| {
        let cube = v * v * v;
        D65[k] * if cube > 0.008_856 { cube } else { (v - 16.0 / 116.0) / 7.787 }
    };
    let (x, y, z) = (f(y + a / 500.0, 0), f(y, 1), f(y - b / 200.0, 2));
    let byte = |v: f64| (gamma(v.clamp(0.0, 1.0)) * 255.0).round() as u8;
    Rgb(
        byte(3.240_6 * x - 1.537_2 * y - 0.498_6 * z),
        byte(-0.968_9 * x + 1.875_8 * y + 0.041_5 * z),
        byte(0.055_7 * x - 0.204_0 * y + 1.057_0 * z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_brightens_all_the_way() {
        let table = Table::new(ColourMap::Viridis);
        assert_eq!((table.at(-1.0), table.at(2.0)), (Rgb(68, 1, 84), Rgb(253, 231, 37)));
        let light: Vec<f64> = (0..=40).map(|i| luminance(table.at(f64::from(i) / 40.0))).collect();
        assert!(light.windows(2).all(|w| w[1] > w[0]), "{light:?}");
        assert_eq!(table.at(f64::NAN), table.at(0.0));
    }

    #[test]
    fn cool_and_warm_meet_in_a_light_grey() {
        let near = |a: Rgb, b: Rgb| {
            let off = [a.0.abs_diff(b.0), a.1.abs_diff(b.1), a.2.abs_diff(b.2)];
            assert!(off.iter().all(|d| *d <= 2), "{a:?} is not {b:?}");
        };
        near(cool_warm(0.0), COOL);
        near(cool_warm(1.0), WARM);
        near(cool_warm(0.5), Rgb(221, 221, 221));
        let light = |t: f64| luminance(cool_warm(t));
        assert!(light(0.5) > light(0.25) && light(0.25) > light(0.0));
        assert!(light(0.5) > light(0.75) && light(0.75) > light(1.0));
    }
}
