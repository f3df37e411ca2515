//! Points from columns of a text file.

use super::{Form, Settings, of_components, table};
use granflow_base::Value;
use granflow_dict::Diag;
use std::sync::Arc;

/// Settings of the form.
pub(super) const KEYS: &[&str] = &[
    "nHeaderLine",
    "refColumn",
    "componentColumns",
    "separator",
    "mergeSeparators",
    "file",
    "outOfBounds",
    "interpolationScheme",
];

/// `csvFile`: time in column `refColumn`, components of the value in `componentColumns`, counted
/// from 0, after `nHeaderLine` lines.
pub(super) fn read<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    let r = &s.r;
    let skip = r.opt_label_in("nHeaderLine", 0..=i64::MAX, 0) as usize;
    let time_column = r.label_in("refColumn", 0..=9999) as usize;
    let columns = r.labels("componentColumns");
    if columns.len() != T::N || columns.iter().any(|c| *c < 0) {
        let message = format!("`componentColumns` needs {} column numbers from 0", T::N);
        r.error_at_key("componentColumns", message, "which columns hold the value", None);
        return None;
    }
    let merge = r.opt_switch("mergeSeparators", false);
    let separator = r.opt_string("separator", ",").chars().next().unwrap_or(',');
    let (path, text) = s.file("file")?;
    let mut points: Vec<(f64, T)> = Vec::new();
    for (i, line) in text.lines().enumerate().skip(skip) {
        if line.trim().is_empty() {
            continue;
        }
        let mut cells: Vec<&str> = line.split(separator).map(str::trim).collect();
        if merge {
            cells.retain(|c| !c.is_empty());
        }
        let number = |column: usize| {
            let cell = cells.get(column).copied().unwrap_or("");
            cell.trim_matches('"').parse::<f64>().map_err(|_| (column, cell.to_owned()))
        };
        let row = number(time_column).and_then(|t| {
            let parts: Result<Vec<f64>, _> = columns.iter().map(|c| number(*c as usize)).collect();
            Ok((t, of_components(&parts?)))
        });
        match row {
            Ok(row) => points.push(row),
            Err((column, cell)) => {
                let message =
                    format!("line {}: column {column} holds `{cell}`, which is no number", i + 1);
                let help = "`nHeaderLine` lines are left out; columns are counted from 0";
                r.sink().push(Diag::file(path, message).help(help));
                return None;
            }
        }
    }
    if let Some(w) = points.windows(2).find(|w| w[1].0 <= w[0].0) {
        let message = format!("the times do not increase: {} after {}", w[1].0, w[0].0);
        s.r.sink().push(Diag::file(path, message));
        return None;
    }
    table::finish(points, s)
}
