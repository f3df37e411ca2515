//! What a study changes in a case, and what it takes from its results.

use crate::figures::expression::{ExpressionError, check, evaluate};
use crate::figures::table::Table;
use crate::store::TimeName;
use granflow_dict::Reader;
use std::path::{Path, PathBuf};

/// Refuses a name that is no word of letters, digits, `_` and `-`, or that is there already: names become those of files.
pub(super) fn check_name(r: &Reader<'_>, key: &str, name: &str, others: &[&str]) {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() {
        // Missing, which was said.
    } else if !name.chars().all(plain) {
        let help = Some("letters, digits, `_` and `-`: it becomes a part of files' names");
        r.error_at_key(key, format!("`{name}` cannot be a name"), "not a plain word", help);
    } else if others.contains(&name) {
        r.error_at_key(key, format!("`{name}` is there already"), "a name of its own", None);
    }
}

/// An entry of a file of the case with the value it gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The file, relative to the case.
    pub file: String,
    /// Path to the entry, like `NGFCoeffs.d`.
    pub entry: String,
    /// The value as text; `{...}` holds arithmetic on the parameter `x` and, in a family, `y`.
    pub value: String,
}

impl Setting {
    /// Reads the list `set`: `( { file ..; entry ..; value "{x/2}"; } )`; the value is `{x}` by default.
    /// `of_family` says whether there is a `y`.
    pub(super) fn read_all(r: &Reader<'_>, of_family: bool) -> Vec<Setting> {
        let mut out = Vec::new();
        let Some(mut list) = r.list("set") else { return out };
        while !list.is_empty() {
            let Some(one) = list.dict("an entry to set") else { break };
            let setting = Setting {
                file: one.string("file").to_owned(),
                entry: one.string("entry").to_owned(),
                value: match one.raw("value").and_then(|t| t.first()).and_then(|t| t.number()) {
                    Some(value) => granflow_dict::number(value),
                    None => one.opt_string("value", "{x}").to_owned(),
                },
            };
            let outside =
                setting.file.starts_with('/') || setting.file.split('/').any(|p| p == "..");
            if outside {
                let help =
                    Some("write its path within the case, like `constant/transportProperties`");
                one.error_at_key(
                    "file",
                    "only files of the case can be changed",
                    "not of the case",
                    help,
                );
            }
            if let Err(e) = setting.text(1.0, of_family.then_some(1.0)) {
                one.error_at_key("value", e, "cannot be evaluated", None);
            }
            one.finish(granflow_dict::Severity::Error);
            out.push(setting);
        }
        if out.is_empty() {
            let help =
                Some("write `set ( { file constant/transportProperties; entry NGFCoeffs.d; } );`");
            r.error_at_key("set", "nothing is set", "needs one entry at least", help);
        }
        out
    }

    /// The text of the value where the parameter is `x` and that of its family `y`.
    ///
    /// # Errors
    /// What is wrong with its arithmetic.
    pub fn text(&self, x: f64, y: Option<f64>) -> Result<String, String> {
        let names = ["x", "pi", "y"].map(String::from);
        let values = [Some(x), Some(PI), y].into_iter().flatten();
        let columns: Vec<Vec<f64>> = values.map(|v| vec![v]).collect();
        let table = Table { names: names[..columns.len()].to_vec(), columns };
        let mut out = String::new();
        let mut rest = self.value.as_str();
        while let Some((before, inner)) = rest.split_once('{') {
            let (expression, after) =
                inner.split_once('}').ok_or_else(|| format!("`{}` lacks a `}}`", self.value))?;
            let value = evaluate(expression, &table).map_err(|e| match e {
                ExpressionError::Unknown { name, known } => {
                    format!("there is no `{name}` here; known are {}", known.join(", "))
                }
                e => e.to_string(),
            })?;
            out += before;
            out += &value.first().map_or(String::new(), |v| granflow_dict::number(*v));
            rest = after;
        }
        Ok(out + rest)
    }
}

const PI: f64 = std::f64::consts::PI;

/// A number that a finished point has: an expression over the columns of a table it wrote, the last of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// The table, relative to the case; `<time>` is the latest time folder.
    pub file: String,
    /// The expression.
    pub value: String,
}

impl Quantity {
    /// Reads the list `results`: `( { name ..; file ..; value ..; } )`.
    pub(super) fn read_all(r: &Reader<'_>) -> Vec<Quantity> {
        let mut out = Vec::new();
        let Some(mut list) = r.list("results") else { return out };
        while !list.is_empty() {
            let Some(one) = list.dict("a result") else { break };
            let quantity = Quantity {
                name: one.string("name").to_owned(),
                file: one.string("file").to_owned(),
                value: one.string("value").to_owned(),
            };
            let others: Vec<&str> = out.iter().map(|q: &Quantity| q.name.as_str()).collect();
            check_name(&one, "name", &quantity.name, &[&others[..], &["limit"]].concat());
            if let Err(e) = check(&quantity.value) {
                one.error_at_key("value", e.to_string(), "cannot be evaluated", None);
            }
            one.finish(granflow_dict::Severity::Error);
            out.push(quantity);
        }
        out
    }

    /// Its value in the case `root`.
    ///
    /// # Errors
    /// The table is not there, or the expression does not fit it.
    pub fn of(&self, root: &Path) -> Result<f64, String> {
        let column = columns(root, &self.file, &[&self.value])?;
        column[0].last().copied().ok_or_else(|| format!("{} has no rows", self.file))
    }
}

/// Expressions over the columns of a table of the case `root`.
pub(super) fn columns(root: &Path, file: &str, of: &[&str]) -> Result<Vec<Vec<f64>>, String> {
    let path = latest(root, file)?;
    let text = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let table = Table::parse(&String::from_utf8_lossy(&text));
    let one =
        |e: &&str| evaluate(e, &table).map_err(|w| format!("`{e}` of {}: {w}", path.display()));
    of.iter().map(one).collect()
}

/// `file` with the latest time folder in place of `<time>`.
fn latest(root: &Path, file: &str) -> Result<PathBuf, String> {
    let Some((folder, _)) = file.split_once("<time>") else { return Ok(root.join(file)) };
    let folder = root.join(folder);
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let names = entries.flatten().filter_map(|e| e.file_name().into_string().ok());
    let times = names.filter_map(|n| TimeName::parse(&n).map(|t| (t, n)));
    let last = times.max_by(|a, b| a.0.total_cmp(&b.0));
    let (_, name) = last.ok_or_else(|| format!("{} has no times", folder.display()))?;
    Ok(root.join(file.replace("<time>", &name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_computed_inside_braces() {
        let of = |value: &str| {
            let (file, entry) = ("f".to_owned(), "e".to_owned());
            Setting { file, entry, value: value.to_owned() }.text(30.0, None)
        };
        assert_eq!(of("{x}").as_deref(), Ok("30"));
        assert_eq!(of("({2*x} 0 {x/60})").as_deref(), Ok("(60 0 0.5)"));
        let half: f64 = of("{sin(x*pi/180)}").unwrap().parse().unwrap();
        assert!((half - 0.5).abs() < 1e-15);
        assert!(of("{x").is_err() && of("{y}").is_err());
    }
}
