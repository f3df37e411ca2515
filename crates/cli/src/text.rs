//! Numbers, times and tables as people read them.

use std::path::Path;

/// Three significant digits: `0.00123`, `1.2e-7`, `12.5`, `1200`.
pub(crate) fn number(x: f64) -> String {
    rounded(x, 3)
}

/// `digits` significant digits, trailing zeros left out.
pub(crate) fn rounded(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..=6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        // Round first, so that 12345 becomes 12300 and not 12345.
        let value: f64 = scientific.parse().unwrap_or(x);
        return trim(&format!("{value:.decimals$}")).to_owned();
    }
    format!("{}e{exponent}", trim(mantissa))
}

fn trim(number: &str) -> &str {
    match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    }
}

/// A residual: `2.1e-9`, `0` when nothing but rounding noise is left.
pub(crate) fn residual(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

/// A time span: `0.4 s`, `12 s`, `3 min 20 s`, `2 h 05 min`, `3 d 4 h`.
pub(crate) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "?".to_owned();
    }
    if seconds < 9.95 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        3600..86_400 => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
        _ => format!("{} d {} h", whole / 86_400, whole % 86_400 / 3600),
    }
}

/// A size: `812 B`, `34 kB`, `1.2 GB`.
pub(crate) fn bytes(n: f64) -> String {
    let mut value = n.max(0.0);
    for unit in ["B", "kB", "MB", "GB"] {
        if value < 999.5 {
            return format!("{} {unit}", rounded(value, 2));
        }
        value /= 1000.0;
    }
    format!("{} TB", rounded(value, 2))
}

/// `1 file`, `2 files`.
pub(crate) fn count(n: usize, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}

/// `rel` in the case `root`, without the `./` of the current directory.
pub(crate) fn place(root: &Path, rel: &str) -> String {
    shown(&root.join(rel))
}

/// A path without the `./` of the current directory.
pub(crate) fn shown(path: &Path) -> String {
    path.strip_prefix(".").unwrap_or(path).display().to_string()
}

/// `text` in lines of at most `width` characters, each behind `indent` spaces.
pub(crate) fn wrap(text: &str, indent: usize, width: usize) -> String {
    let (mut out, mut length) = (String::new(), 0);
    for word in text.split_whitespace() {
        let n = word.chars().count();
        if length > 0 && length + 1 + n > width {
            out.push('\n');
            length = 0;
        }
        if length == 0 {
            out.push_str(&" ".repeat(indent));
        } else {
            out.push(' ');
            length += 1;
        }
        out.push_str(word);
        length += n;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [(0.0, "0"), (1.0, "1"), (0.00123456, "0.00123"), (12.5, "12.5")];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
        assert_eq!(number(12345.0), "12300");
        assert_eq!(number(-1.2e-7), "-1.2e-7");
        assert_eq!(number(9.999e9), "1e10");
        assert_eq!(number(0.99999), "1");
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!(rounded(0.1 + 0.2, 6), "0.3");
    }

    #[test]
    fn durations_and_sizes_are_readable() {
        let all = [0.04, 9.96, 200.0, 7500.0, 300_000.0, f64::NAN].map(duration);
        assert_eq!(all, ["0.0 s", "10 s", "3 min 20 s", "2 h 05 min", "3 d 11 h", "?"]);
        assert_eq!([812.0, 34e3, 1.24e9, 5e15].map(bytes), ["810 B", "34 kB", "1.2 GB", "5000 TB"]);
    }

    #[test]
    fn wrapped_text_keeps_every_word() {
        let text = "one two three four five";
        let wrapped = wrap(text, 2, 9);
        assert_eq!(wrapped, "  one two\n  three\n  four five");
        assert_eq!(wrap("", 2, 9), "");
    }
}
