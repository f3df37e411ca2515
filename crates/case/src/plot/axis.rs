//! Axes: ranges, ticks and the map from data to the page.

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their decadic logarithm; values that are not positive are dropped.
    Log,
}

/// One axis of a figure.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// The label, with `_{...}` and `^{...}` for sub- and superscripts.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// First and last value shown; `None`: from the data. A range that cannot be drawn (empty,
    /// not finite, not positive on a logarithmic axis) counts as none.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis, range from the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Linear, range: None }
    }

    /// A logarithmic axis, range from the data.
    pub fn log(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Log, range: None }
    }

    /// The axis with a fixed range.
    #[must_use]
    pub fn ranged(mut self, first: f64, last: f64) -> Self {
        self.range = Some((first, last));
        self
    }
}

/// A tick; without a label it is a minor one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: Option<String>,
}

/// An axis made concrete: range decided, ticks chosen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ruler {
    scale: Scale,
    lo: f64,
    hi: f64,
    pub(super) ticks: Vec<Tick>,
    /// Common factor of the labels of a linear axis, `10^factor`.
    pub(super) factor: i32,
}

impl Ruler {
    /// Whether an axis can show a value at all, wherever its range is.
    pub(super) fn shows(axis: &Axis, v: f64) -> bool {
        // Beyond 1e300 differences of values overflow; nothing of this world is there.
        match axis.scale {
            Scale::Linear => v.abs() <= 1e300,
            Scale::Log => (1e-300..=1e300).contains(&v),
        }
    }

    /// For an axis, the values to be shown on it, and about how many labels fit.
    pub(super) fn new(axis: &Axis, values: impl Iterator<Item = f64>, labels: usize) -> Self {
        let usable = |v: f64| Self::shows(axis, v);
        let given = axis.range.filter(|(a, b)| usable(*a) && usable(*b) && a != b);
        let (lo, hi) = given.unwrap_or_else(|| {
            let ends = values.filter(|v| usable(*v)).fold(None, |ends: Option<(f64, f64)>, v| {
                Some(ends.map_or((v, v), |(lo, hi)| (lo.min(v), hi.max(v))))
            });
            match axis.scale {
                Scale::Linear => linear_range(ends),
                Scale::Log => log_range(ends),
            }
        });
        let (ticks, factor) = match axis.scale {
            Scale::Linear => linear_ticks(lo.min(hi), lo.max(hi), labels),
            Scale::Log => {
                let ticks = log_ticks(lo.min(hi), lo.max(hi), labels);
                // Hardly any extent: no round decades or multiples fall into it.
                match ticks.iter().filter(|t| t.label.is_some()).count() {
                    0 | 1 => linear_ticks(lo.min(hi), lo.max(hi), labels),
                    _ => (ticks, 0),
                }
            }
        };
        Ruler { scale: axis.scale, lo, hi, ticks, factor }
    }

    /// 0 at the first value of the axis, 1 at its last; `None` for what cannot be shown.
    pub(super) fn place(&self, v: f64) -> Option<f64> {
        let at = match self.scale {
            Scale::Linear => (v - self.lo) / (self.hi - self.lo),
            Scale::Log if v > 0.0 => (v / self.lo).log10() / (self.hi / self.lo).log10(),
            Scale::Log => return None,
        };
        at.is_finite().then_some(at)
    }
}

/// Room left beyond the data, relative to its extent.
const MARGIN: f64 = 0.04;

fn linear_range(ends: Option<(f64, f64)>) -> (f64, f64) {
    let Some((lo, hi)) = ends else { return (0.0, 1.0) };
    let span = hi - lo;
    if span <= 1e-12 * hi.abs().max(lo.abs()) {
        // One value (or none that differ): centred.
        let half = if lo == 0.0 { 1.0 } else { 0.1 * lo.abs() };
        return (lo - half, hi + half);
    }
    // Zero is a natural end when the data come near it from one side.
    let near = 0.12 * span;
    let first = if (0.0..near).contains(&lo) { 0.0 } else { lo - MARGIN * span };
    let last = if (-near..=0.0).contains(&hi) { 0.0 } else { hi + MARGIN * span };
    (first, last)
}

fn log_range(ends: Option<(f64, f64)>) -> (f64, f64) {
    let Some((lo, hi)) = ends else { return (0.1, 1.0) };
    let span = (hi / lo).log10();
    if span <= 1e-6 {
        return (lo / 2.0, hi * 2.0);
    }
    let margin = 10f64.powf(MARGIN * span);
    (lo / margin, hi * margin)
}

/// Round values within a range, without its ends: as near to `n` of them as there are.
pub fn round_levels((lo, hi): (f64, f64), n: usize) -> Vec<f64> {
    if !(lo < hi && (hi - lo).is_finite()) {
        return Vec::new();
    }
    let decade = 10f64.powf(((hi - lo) / (n as f64 + 1.0)).log10().floor());
    let slack = 1e-9 * (hi - lo);
    let ends =
        |step: f64| (((lo + slack) / step).ceil() as i64, ((hi - slack) / step).floor() as i64);
    let off = |step: f64| {
        let (first, last) = ends(step);
        (last - first + 1).abs_diff(n as i64)
    };
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * decade);
    // The first of equals: lines are better too many than too few.
    let best = steps.into_iter().min_by_key(|s| off(*s)).unwrap_or(decade);
    let (first, last) = ends(best);
    (first..=last).map(|i| i as f64 * best).collect()
}

fn linear_ticks(lo: f64, hi: f64, labels: usize) -> (Vec<Tick>, i32) {
    let raw = (hi - lo) / labels.max(2) as f64;
    let decade = 10f64.powf(raw.log10().floor());
    // Label distance and minor ticks between two labels.
    let (nice, minor) = [(1.0, 5), (2.0, 4), (5.0, 5), (10.0, 5)]
        .into_iter()
        .find(|(n, _)| n * decade >= raw * 0.8)
        .unwrap_or((10.0, 5));
    let step = nice * decade;
    let largest = lo.abs().max(hi.abs());
    let exponent = largest.log10().floor() as i32;
    let factor = if (-3..5).contains(&exponent) { 0 } else { exponent };
    let unit = 10f64.powi(factor);
    let decimals = ((step / unit).log10() + 1e-9).floor().min(0.0).abs() as usize;
    let fine = step / f64::from(minor);
    let slack = 1e-9 * (hi - lo);
    let first = ((lo - slack) / fine).ceil() as i64;
    let last = ((hi + slack) / fine).floor() as i64;
    let ticks = (first..=last)
        .map(|i| {
            let value = i as f64 * fine;
            let major = i % i64::from(minor) == 0;
            Tick { value, label: major.then(|| fixed(value / unit, decimals)) }
        })
        .collect();
    (ticks, factor)
}

/// With a minus sign instead of a hyphen, and no negative zero.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().any(|b| b.is_ascii_digit() && b != b'0') => format!("−{rest}"),
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

fn log_ticks(lo: f64, hi: f64, labels: usize) -> Vec<Tick> {
    let (first, last) = (lo.log10().floor() as i32, hi.log10().ceil() as i32);
    let slack = 1.0 + 1e-9;
    let inside = |v: f64| v >= lo / slack && v <= hi * slack;
    let whole = (first..=last).filter(|e| inside(10f64.powi(*e))).count();
    // Every decade, or every second, third, fifth ... of many.
    let every = [1, 2, 3, 5, 10, 20, 50, 100]
        .into_iter()
        .find(|n| whole <= labels.max(2) * *n as usize)
        .unwrap_or(100);
    // Less than two whole decades: 2 and 5 (or all digits) are labelled as well.
    let digits: &[u32] = match whole {
        0 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
        1 => &[1, 2, 5],
        _ => &[1],
    };
    let mut ticks = Vec::new();
    for e in first..=last {
        for m in 1..10u32 {
            let value = f64::from(m) * 10f64.powi(e);
            if !inside(value) || (every > 1 && m > 1) {
                continue;
            }
            let labelled = digits.contains(&m) && e.rem_euclid(every) == 0;
            let label = labelled.then(|| match digits.len() {
                1 => format!("10^{{{e}}}"),
                _ => multiple(m, e),
            });
            ticks.push(Tick { value, label });
        }
    }
    ticks
}

fn multiple(m: u32, e: i32) -> String {
    match e {
        0 => format!("{m}"),
        1 => format!("{m}0"),
        -3..0 => format!("{:.*}", (-e) as usize, f64::from(m) * 10f64.powi(e)),
        _ if m == 1 => format!("10^{{{e}}}"),
        _ => format!("{m}×10^{{{e}}}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ruler: &Ruler) -> Vec<&str> {
        ruler.ticks.iter().filter_map(|t| t.label.as_deref()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let r = Ruler::new(&Axis::linear(""), [0.0, 16.0].into_iter(), 8);
        assert_eq!(labels(&r), ["0", "2", "4", "6", "8", "10", "12", "14", "16"]);
        let r = Ruler::new(&Axis::linear("").ranged(-0.5, 0.5), std::iter::empty(), 5);
        assert_eq!(labels(&r), ["−0.4", "−0.2", "0.0", "0.2", "0.4"]);
        let r = Ruler::new(&Axis::linear("").ranged(0.0, 2e-5), std::iter::empty(), 4);
        assert_eq!((labels(&r), r.factor), (vec!["0.0", "0.5", "1.0", "1.5", "2.0"], -5));
    }

    #[test]
    fn levels_are_round_and_about_as_many_as_asked_for() {
        let near = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
            assert!(found.iter().zip(wanted).all(apart), "{found:?}");
        };
        near(round_levels((0.0, 1.0), 4), &[0.2, 0.4, 0.6, 0.8]);
        near(round_levels((-0.3, 2.31), 5), &[0.0, 0.5, 1.0, 1.5, 2.0]);
        near(round_levels((0.0, 1.0), 3), &[0.25, 0.5, 0.75]);
        for n in 1..60 {
            let found = round_levels((0.013, 5.7), n).len() as f64;
            assert!((0.5..=2.0).contains(&(found / n as f64)), "{n}: {found}");
        }
        assert!(
            round_levels((1.0, 1.0), 5).is_empty() && round_levels((0.0, f64::NAN), 5).is_empty()
        );
    }

    #[test]
    fn log_ticks_are_decades() {
        let r = Ruler::new(&Axis::log("").ranged(1e-4, 1.0), std::iter::empty(), 8);
        assert_eq!(labels(&r), ["10^{-4}", "10^{-3}", "10^{-2}", "10^{-1}", "10^{0}"]);
        assert_eq!(r.ticks.len(), 5 + 4 * 8);
        let r = Ruler::new(&Axis::log("").ranged(1e-20, 1.0), std::iter::empty(), 8);
        assert_eq!(labels(&r).len(), 7, "{:?}", labels(&r));
        let r = Ruler::new(&Axis::log("").ranged(2.0, 9.0), std::iter::empty(), 8);
        assert_eq!(labels(&r), ["2", "3", "4", "5", "6", "7", "8", "9"]);
    }

    #[test]
    fn places_are_fractions_of_the_axis() {
        let r = Ruler::new(&Axis::log("").ranged(1e-4, 1.0), std::iter::empty(), 8);
        assert_eq!((r.place(1e-4), r.place(0.0), r.place(f64::NAN)), (Some(0.0), None, None));
        assert!((r.place(1e-2).unwrap() - 0.5).abs() < 1e-12);
        let down = Ruler::new(&Axis::linear("").ranged(10.0, 0.0), std::iter::empty(), 5);
        assert_eq!(down.place(7.5), Some(0.25), "an axis may run backwards");
    }

    #[test]
    fn hopeless_data_and_ranges_still_give_an_axis() {
        for values in [vec![], vec![f64::NAN], vec![3.0], vec![0.0, 0.0], vec![-1.0, -2.0]] {
            for axis in [Axis::linear(""), Axis::log(""), Axis::log("").ranged(-1.0, 1.0)] {
                let r = Ruler::new(&axis, values.iter().copied(), 6);
                assert!(r.lo < r.hi && r.ticks.len() < 200, "{axis:?} {values:?} {r:?}");
                assert!(!labels(&r).is_empty(), "{axis:?} {values:?} {r:?}");
            }
        }
    }
}
