//! What a case expects of itself: `expect.toml`, and how a run of it compares.
//!
//! ```toml
//! [[check]]
//! what      = "V/V_wall against the exact profile"
//! file      = "postProcessing/profile/3/radius_U.csv"
//! x         = "(x - 0.051)/0.00075"        # expressions over the columns of the file
//! y         = "U_y/5.1e-4"
//! reference = "reference/profile.csv"      # with columns (or expressions) ref_x, ref_y
//! ref_x     = "col1"
//! ref_y     = "col6"
//! tolerance = 1.2e-4                       # greatest |y - reference(x)|
//! source    = "where the reference comes from"
//!
//! # `exact`, an expression over the columns of the file, may stand in place of `reference`.
//!
//! [[check]]
//! what      = "centre velocity"
//! file      = "..."
//! value     = "max(U_x)"                   # its last entry, or that of time `at`
//! expected  = 0.1
//! tolerance = 1e-3
//! source    = "..."
//! ```
//!
//! `slow = true` and `unconverged = 9` at the top: see [`is_slow`] and [`may_not_converge`].

use crate::figures::expression::evaluate;
use crate::figures::table::Table;
use std::path::Path;

/// One quantity of a run beside what it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// What it is.
    pub what: String,
    /// Its value where it is a number; a curve has none, only an error.
    pub value: Option<f64>,
    /// What the value should be.
    pub expected: Option<f64>,
    /// Greatest difference from what it should be.
    pub error: f64,
    /// Greatest difference that is accepted.
    pub tolerance: f64,
    /// Where the expectation comes from.
    pub source: String,
}

impl Quantity {
    /// Whether it is as it should be; what is no number is not.
    pub fn passed(&self) -> bool {
        self.error <= self.tolerance
    }
}

/// Whether the text of an `expect.toml` says `slow = true`: the case takes minutes, and is run when it is asked for by
/// its name.
pub fn is_slow(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|t| t.get("slow").and_then(|s| s.as_bool()) == Some(true))
}

/// How many steps of the run may use up their passes, by the text of an `expect.toml` that says `unconverged = N`: none
/// where it does not.
pub fn may_not_converge(text: &str) -> f64 {
    let n = text.parse::<toml::Table>().ok().and_then(|t| t.get("unconverged")?.as_integer());
    n.unwrap_or(0) as f64
}

/// Compares the run in the case directory `ran` with the `expect.toml` there.
///
/// # Errors
/// What is wrong with that file, or missing of the data it names.
pub fn judge(ran: &Path) -> Result<Vec<Quantity>, String> {
    let path = ran.join("expect.toml");
    let text = read(&path)?;
    let table: toml::Table = text.parse().map_err(|e| format!("{}: {e}", path.display()))?;
    let checks = table.get("check").and_then(|c| c.as_array());
    let checks = checks.filter(|c| !c.is_empty());
    let checks = checks.ok_or_else(|| format!("{} has no [[check]]", path.display()))?;
    checks.iter().map(|c| one(ran, c)).collect()
}

fn one(ran: &Path, c: &toml::Value) -> Result<Quantity, String> {
    let word = |key: &str| c.get(key).and_then(|v| v.as_str());
    let must = |key: &str| word(key).ok_or_else(|| format!("expect.toml: `{key}` is missing"));
    let number = |key: &str| {
        let v = c.get(key);
        let v = v.and_then(|v| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)));
        v.ok_or_else(|| format!("expect.toml: `{key}` must be a number"))
    };
    let mut out = Quantity {
        what: must("what")?.to_owned(),
        value: None,
        expected: None,
        error: f64::NAN,
        tolerance: number("tolerance")?,
        source: must("source")?.to_owned(),
    };
    let file = must("file")?;
    out.error = if let Some(value) = word("value") {
        let v = columns(ran, file, &[value, "col1"])?;
        let row = match c.get("at") {
            None => v[0].len().checked_sub(1),
            Some(_) => {
                let at = number("at")?;
                v[1].iter().position(|t| (t - at).abs() < 1e-6 * at.abs().max(1.0))
            }
        };
        let row = row.ok_or_else(|| format!("{file} has no row for `{}`", out.what))?;
        let (value, expected) = (v[0][row], number("expected")?);
        (out.value, out.expected) = (Some(value), Some(expected));
        (value - expected).abs()
    } else if let Some(exact) = word("exact") {
        let own = columns(ran, file, &[must("y")?, exact])?;
        greatest(own[0].iter().zip(&own[1]).map(|(y, e)| y - e))
    } else {
        let own = columns(ran, file, &[must("x")?, must("y")?])?;
        let of = columns(ran, must("reference")?, &[must("ref_x")?, must("ref_y")?])?;
        // Few measured points are compared where they are, a curve where we have values.
        let (points, curve) = if of[0].len() < own[0].len() { (&of, &own) } else { (&own, &of) };
        if curve[0].len() < 4 {
            return Err(format!("{file}: a curve of {} points is none", curve[0].len()));
        }
        let each = points[0].iter().zip(&points[1]);
        greatest(each.map(|(x, y)| y - interpolate(&curve[0], &curve[1], *x)))
    };
    Ok(out)
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn columns(root: &Path, file: &str, wanted: &[&str]) -> Result<Vec<Vec<f64>>, String> {
    let table = Table::parse(&read(&root.join(file))?);
    let column = |w: &&str| evaluate(w, &table).map_err(|e| format!("{file}: `{w}`: {e}"));
    wanted.iter().map(column).collect()
}

/// The greatest magnitude; NaN when there is none or one is no number.
fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    let larger = |a: Option<f64>, v: f64| match a {
        _ if !v.is_finite() => Some(f64::NAN),
        Some(a) if a.is_nan() || a > v.abs() => Some(a),
        _ => Some(v.abs()),
    };
    values.fold(None, larger).unwrap_or(f64::NAN)
}

/// Cubic interpolation of the points `(x, y)`, x growing, at `at`.
pub(crate) fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|v| *v < at).clamp(2, x.len() - 2) - 2;
    (k..k + 4)
        .map(|i| {
            let others = (k..k + 4).filter(|&j| j != i);
            y[i] * others.map(|j| (at - x[j]) / (x[i] - x[j])).product::<f64>()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_never_passes() {
        assert!(greatest([1.0, f64::NAN, 0.5].into_iter()).is_nan());
        assert!(greatest([].into_iter()).is_nan());
        assert_eq!(greatest([1.0, -2.0, 0.5].into_iter()), 2.0);
        let nan = Quantity {
            what: String::new(),
            value: None,
            expected: None,
            error: f64::NAN,
            tolerance: 1.0,
            source: String::new(),
        };
        assert!(!nan.passed());
    }

    #[test]
    fn all_steps_converge_unless_a_case_says_otherwise() {
        assert_eq!(may_not_converge("slow = true"), 0.0);
        assert_eq!(may_not_converge("slow = true\nunconverged = 9\n[[check]]\n"), 9.0);
    }

    #[test]
    fn interpolation_is_exact_for_cubics() {
        let x: Vec<f64> = (0..6).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| x * x * x - x).collect();
        assert!((interpolate(&x, &y, 2.5) - (2.5f64.powi(3) - 2.5)).abs() < 1e-12);
    }

    #[test]
    fn values_and_curves_are_compared() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        put("a.csv", "t,u\n1,2\n2,3\n3,4\n4,5\n");
        put(
            "expect.toml",
            "[[check]]\nwhat = \"u\"\nfile = \"a.csv\"\nvalue = \"u\"\nat = 2\nexpected = 3.5\n\
             tolerance = 0.1\nsource = \"s\"\n[[check]]\nwhat = \"u(t)\"\nfile = \"a.csv\"\n\
             x = \"t\"\ny = \"u\"\nexact = \"t + 1\"\ntolerance = 1e-9\nsource = \"s\"\n",
        );
        let all = judge(dir.path()).unwrap();
        assert_eq!((all[0].value, all[0].error, all[0].passed()), (Some(3.0), 0.5, false));
        assert!(all[1].passed() && all[1].value.is_none());
        put("expect.toml", "[[check]]\nwhat = \"u\"\n");
        assert!(judge(dir.path()).unwrap_err().contains("tolerance"));
    }
}
