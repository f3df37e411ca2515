//! Time values and the names of their directories.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::error::{Context, Operation, StoreError};

/// `timeFormat` of `controlDict`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeFormat {
    /// The shorter of the two others, without trailing zeros: `0.5`, `1e-05`.
    #[default]
    General,
    /// `0.500000`; the precision counts decimals.
    Fixed,
    /// `5.000000e-01`; the precision counts decimals.
    Scientific,
}

impl FromStr for TimeFormat {
    type Err = ();

    fn from_str(s: &str) -> Result<Self, ()> {
        match s {
            "general" => Ok(TimeFormat::General),
            "fixed" => Ok(TimeFormat::Fixed),
            "scientific" => Ok(TimeFormat::Scientific),
            _ => Err(()),
        }
    }
}

/// No `f64` needs more significant digits to be told from its neighbours.
pub const MAX_PRECISION: usize = 17;

/// How time values are turned into directory names (`timeFormat`, `timePrecision`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeName {
    /// The notation.
    pub format: TimeFormat,
    /// Significant digits (general) or decimals (fixed, scientific).
    pub precision: usize,
}

impl Default for TimeName {
    fn default() -> Self {
        TimeName { format: TimeFormat::General, precision: 6 }
    }
}

impl TimeName {
    /// The name of the directory of time `t` (s). Zero is `0` in every format, as the start
    /// directory is called.
    pub fn of(&self, t: f64) -> String {
        if t == 0.0 {
            return "0".to_owned();
        }
        let p = self.precision;
        match self.format {
            TimeFormat::General => general(t, p.max(1)),
            TimeFormat::Fixed => format!("{t:.p$}"),
            TimeFormat::Scientific => c_exponent(&format!("{t:.p$e}")),
        }
    }

    /// The name of `t`, with the precision raised (for good) until it differs from the name of
    /// the `previous` written time and reads back to `t` within a tenth of the time `step` (s).
    pub fn distinct(&mut self, t: f64, previous: Option<f64>, step: f64) -> String {
        loop {
            let name = self.of(t);
            let same = previous.is_some_and(|p| p != t && self.of(p) == name);
            let off = Self::parse(&name).is_none_or(|v| (v - t).abs() > 0.1 * step.abs());
            if !(same || off) || self.precision >= MAX_PRECISION {
                return name;
            }
            self.precision += 1;
        }
    }

    /// The value of a directory name; `None` when it is not a plain finite decimal number
    /// (`constant`, `0.orig`, `inf`, `processor0`).
    pub fn parse(name: &str) -> Option<f64> {
        let plain = name.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
        let value: f64 = if plain { name.parse().ok()? } else { return None };
        value.is_finite().then_some(value)
    }
}

/// C's `%g`: significant digits, trailing zeros dropped, an exponent only where it is needed.
fn general(t: f64, digits: usize) -> String {
    let sci = format!("{t:.*e}", digits - 1);
    let exponent: i32 = sci.rsplit_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    let last = digits as i32 - 1;
    if exponent < -4 || exponent > last {
        let (mantissa, e) = sci.split_once('e').unwrap_or((&sci, "0"));
        return c_exponent(&format!("{}e{e}", trim(mantissa)));
    }
    trim(&format!("{t:.*}", (last - exponent) as usize)).to_owned()
}

fn trim(number: &str) -> &str {
    match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    }
}

/// Rust writes `1e-5`, C (and OpenFOAM) `1e-05`.
fn c_exponent(number: &str) -> String {
    let Some((mantissa, e)) = number.split_once('e') else { return number.to_owned() };
    let (sign, digits) = e.strip_prefix('-').map_or(('+', e), |d| ('-', d));
    format!("{mantissa}e{sign}{digits:0>2}")
}

/// The time directories of a case in ascending order. Everything that is not a directory with a
/// number for a name is ignored.
pub fn list_times(case: &Path) -> Result<Vec<(f64, PathBuf)>, StoreError> {
    let mut times = Vec::new();
    for entry in fs::read_dir(case).at(Operation::Read, case)? {
        let entry = entry.at(Operation::Read, case)?;
        let Some(t) = entry.file_name().to_str().and_then(TimeName::parse) else { continue };
        let path = entry.path();
        match fs::metadata(&path) {
            Ok(m) if m.is_dir() => times.push((t, path)),
            // A dangling link, or purged by the run whose times another program lists.
            Err(e) if e.kind() != io::ErrorKind::NotFound => {
                return Err(StoreError::new(Operation::Read, path, e));
            }
            _ => {}
        }
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    Ok(times)
}

/// The last time directory of a case, if it has any.
pub fn latest(case: &Path) -> Result<Option<(f64, PathBuf)>, StoreError> {
    Ok(list_times(case)?.pop())
}

/// The time directory nearest to `t`; of two equally near ones the earlier.
pub fn nearest_time(case: &Path, t: f64) -> Result<Option<(f64, PathBuf)>, StoreError> {
    let times = list_times(case)?;
    Ok(times.into_iter().min_by(|a, b| (a.0 - t).abs().total_cmp(&(b.0 - t).abs())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn general_names_are_those_of_c() {
        let name = TimeName::default();
        for (t, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.5, "0.5"),
            (1.0, "1"),
            (1e-5, "1e-05"),
            (0.0001, "0.0001"),
            (0.1 + 0.2, "0.3"),
            (123456.0, "123456"),
            (1234567.0, "1.23457e+06"),
            (999999.9, "1e+06"),
            (0.00012345678, "0.000123457"),
            (100.0, "100"),
            (-0.25, "-0.25"),
            (2.5e-120, "2.5e-120"),
        ] {
            assert_eq!(name.of(t), expected);
        }
    }

    #[test]
    fn fixed_and_scientific() {
        let name = |format| TimeName { format, precision: 3 };
        assert_eq!(name(TimeFormat::Fixed).of(0.5), "0.500");
        assert_eq!(name(TimeFormat::Fixed).of(0.0), "0");
        assert_eq!(name(TimeFormat::Scientific).of(0.00125), "1.250e-03");
        assert_eq!("fixed".parse(), Ok(TimeFormat::Fixed));
        assert_eq!("Fixed".parse::<TimeFormat>(), Err(()));
    }

    #[test]
    fn names_read_back_and_others_do_not() {
        for t in [0.0, 0.5, 1e-5, 1.23457e6, 3.0] {
            assert_eq!(TimeName::parse(&TimeName::default().of(t)), Some(t));
        }
        for other in ["", ".", "constant", "0.orig", "inf", "nan", "1_0", "processor0", "e", "0x1"]
        {
            assert_eq!(TimeName::parse(other), None, "{other}");
        }
    }

    #[test]
    fn precision_grows_until_times_differ() {
        let mut name = TimeName::default();
        assert_eq!(name.distinct(0.3 + 1e-17, Some(0.2), 0.1), "0.3");
        assert_eq!(name.precision, 6);
        assert_eq!(name.distinct(1.0000001, Some(1.0), 1e-7), "1.0000001");
        assert_eq!(name.precision, 8);
        // Grown for good: a later round time keeps its short name.
        assert_eq!(name.distinct(2.0, Some(1.0000001), 1e-7), "2");
        // The next f64 after 1 needs all the digits there are, and the search ends.
        let next = 1.0 + f64::EPSILON;
        let last = name.distinct(next, Some(1.0), 0.0);
        assert_eq!(TimeName::parse(&last), Some(next));
    }
}
