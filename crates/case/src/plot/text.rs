//! Text of a figure: subscripts and superscripts, and how wide it is.

use std::borrow::Cow;

/// A stretch of text of one size and height.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    pub(super) text: String,
    pub(super) level: Level,
}

/// Where a run sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    Base,
    Sub,
    Super,
}

impl Level {
    /// Size relative to the base.
    pub(super) fn size(self, base: f64) -> f64 {
        match self {
            Level::Base => base,
            Level::Sub | Level::Super => (0.72 * base).round(),
        }
    }

    /// How far the baseline is raised, relative to the base size.
    pub(super) fn rise(self) -> f64 {
        match self {
            Level::Base => 0.0,
            Level::Sub => -0.2,
            Level::Super => 0.36,
        }
    }
}

/// Escapes a name that is to appear as it is (`alpha_water`, a file name) in a label.
pub fn literal(text: &str) -> Cow<'_, str> {
    if !text.contains(['_', '^', '\\']) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 4);
    for c in text.chars() {
        if matches!(c, '_' | '^' | '\\') {
            out.push('\\');
        }
        out.push(c);
    }
    Cow::Owned(out)
}

/// Splits `V_{wall}`, `s^{-1}`, `R_i` into runs. `_` and `^` take a group in braces or one
/// character; a backslash makes the next character ordinary. Hyphens in super- and subscripts
/// become minus signs. Everything is text in the end: there are no errors.
pub(super) fn parse(label: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut push = |level: Level, c: char| match runs.last_mut() {
        Some(run) if run.level == level => run.text.push(c),
        _ => runs.push(Run { text: c.to_string(), level }),
    };
    let mut chars = label.chars().peekable();
    while let Some(c) = chars.next() {
        let level = match c {
            '\\' => {
                push(Level::Base, chars.next().unwrap_or('\\'));
                continue;
            }
            '_' if chars.peek().is_some() => Level::Sub,
            '^' if chars.peek().is_some() => Level::Super,
            _ => {
                push(Level::Base, c);
                continue;
            }
        };
        let minus = |c: char| if c == '-' { '−' } else { c };
        if chars.next_if_eq(&'{').is_some() {
            for c in chars.by_ref().take_while(|c| *c != '}') {
                push(level, minus(c));
            }
        } else if let Some(c) = chars.next() {
            push(level, minus(c));
        }
    }
    runs
}

/// Width of a label at a font size, in the unit of the size.
pub(super) fn width(runs: &[Run], size: f64) -> f64 {
    runs.iter().map(|r| plain_width(&r.text, r.level.size(size))).sum()
}

/// Width of plain text in DejaVu Sans, the font that is embedded for PNG and named first in SVG.
pub(super) fn plain_width(text: &str, size: f64) -> f64 {
    let thousandths: u32 = text.chars().map(|c| u32::from(advance(c))).sum();
    f64::from(thousandths) * 1e-3 * size
}

fn advance(c: char) -> u16 {
    let c = c as usize;
    match c {
        0x20..0x7f => ASCII[c - 0x20],
        0xa0..0x100 => LATIN[c - 0xa0],
        0x391..0x3ca => GREEK[c - 0x391],
        0x2212 => MINUS,
        0x2070..0x20a0 => 401, // superscript and subscript digits
        _ => 640,
    }
}

// Advance widths of DejaVu Sans in thousandths of the font size.
const MINUS: u16 = 838;
#[rustfmt::skip]
const ASCII: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632, 575, 775,
    752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390,
    337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
    635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];
#[rustfmt::skip]
const LATIN: [u16; 96] = [
    318, 401, 636, 636, 636, 636, 337, 500, 500, 1000, 471, 612, 838, 361, 1000, 500, 500, 838, 401, 401,
    500, 636, 636, 318, 500, 401, 471, 612, 969, 969, 969, 531, 684, 684, 684, 684, 684, 684, 974, 698,
    632, 632, 632, 632, 295, 295, 295, 295, 775, 748, 787, 787, 787, 787, 787, 838, 787, 732, 732, 732,
    732, 611, 605, 630, 613, 613, 613, 613, 613, 613, 982, 550, 615, 615, 615, 615, 278, 278, 278, 278,
    612, 634, 612, 612, 612, 612, 612, 838, 612, 634, 634, 634, 634, 592, 635, 592,
];
#[rustfmt::skip]
const GREEK: [u16; 57] = [
    684, 686, 557, 684, 632, 685, 752, 787, 295, 656, 684, 863, 748, 632, 787, 752, 603, 600, 632, 611,
    611, 787, 685, 787, 764, 295, 611, 659, 541, 634, 338, 579, 659, 638, 592, 612, 541, 544, 634, 612,
    338, 589, 592, 636, 559, 558, 612, 602, 635, 587, 634, 602, 579, 660, 578, 660, 837,
];

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(label: &str) -> Vec<(String, Level)> {
        parse(label).into_iter().map(|r| (r.text, r.level)).collect()
    }

    #[test]
    fn subscripts_and_superscripts() {
        use Level::{Base, Sub, Super};
        let run = |t: &str, l| (t.to_owned(), l);
        assert_eq!(
            flat("V_θ/V_{wall}"),
            [run("V", Base), run("θ", Sub), run("/V", Base), run("wall", Sub)]
        );
        assert_eq!(flat("10^{-4}"), [run("10", Base), run("−4", Super)]);
        assert_eq!(flat("s^-1"), [run("s", Base), run("−", Super), run("1", Base)]);
        // Mistakes are drawn, not refused.
        assert_eq!(flat("a_"), [run("a_", Base)]);
        assert_eq!(flat("a^{b"), [run("a", Base), run("b", Super)]);
        assert_eq!(flat(""), []);
    }

    #[test]
    fn literal_names_survive() {
        assert_eq!(literal("plain"), "plain");
        assert_eq!(
            flat(&literal("alpha_water^2\\")),
            [("alpha_water^2\\".to_owned(), Level::Base)]
        );
    }

    #[test]
    fn widths_are_those_of_the_font() {
        assert!((plain_width("0", 10.0) - 6.36).abs() < 0.01);
        assert!(width(&parse("10^{-4}"), 16.0) < width(&parse("10-4"), 16.0) + 4.0);
        assert!(plain_width("iii", 10.0) < plain_width("mmm", 10.0));
    }
}
