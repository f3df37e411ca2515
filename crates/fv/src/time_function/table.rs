//! Points with straight lines between them, inline or from a file.

use super::{Form, Settings, value};
use granflow_base::Value;
use granflow_dict::{Payload, Severity, Source, TokenReader, number, parse_list_file};
use std::sync::Arc;

/// What a table says beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The value at the end.
    Hold,
    /// Itself again behind its last time; before its first time the first value (as observed of
    /// OpenFOAM v1912).
    Repeat,
}

/// Points (time, value), the times increasing.
pub(crate) struct Table<T> {
    points: Vec<(f64, T)>,
    beyond: Beyond,
}

impl<T: Value> Table<T> {
    /// `None` when there are no points or their times do not increase.
    pub(crate) fn new(points: Vec<(f64, T)>, beyond: Beyond) -> Option<Self> {
        let sorted = points.windows(2).all(|w| w[0].0 < w[1].0);
        (sorted && !points.is_empty()).then_some(Table { points, beyond })
    }
}

impl<T: Value> Form<T> for Table<T> {
    fn at(&self, time: f64) -> T {
        let (first, last) = (self.points[0].0, self.points[self.points.len() - 1].0);
        let time = match self.beyond {
            Beyond::Repeat if time > last && last > first => {
                first + (time - first) % (last - first)
            }
            _ => time,
        };
        let k = self.points.partition_point(|p| p.0 <= time);
        if k == 0 {
            return self.points[0].1;
        }
        let (t0, v0) = self.points[k - 1];
        match self.points.get(k) {
            None => v0,
            Some(&(t1, v1)) => v0.axpy((time - t0) / (t1 - t0), v1.minus(v0)),
        }
    }
}

/// `table ((t v) ...)`, or `values ((t v) ...)` in a dictionary.
pub(super) fn inline<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    let rows = s.list("values", "the table")?;
    let points = rows_of(rows, s)?;
    finish(points, s)
}

/// `tableFile; file "<case>/..."`: the list alone in a file.
pub(super) fn file<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    let (path, text) = s.file("file")?;
    let (_, list, diags) = parse_list_file(Source::new(path, text));
    let bad = diags.iter().any(|d| d.severity == Severity::Error);
    s.r.sink().extend(diags);
    if bad {
        return None;
    }
    let tokens = match list {
        Payload::Tokens(t) => t,
        list if list.is_empty() => Vec::new(),
        list => {
            let message = format!("`{}` needs a list of `(time value)`", s.key);
            let label = format!("the file holds {}", list.describe());
            s.r.error_at_key("file", message, label, None);
            return None;
        }
    };
    let end = s.r.value_span("file");
    let sink = s.r.sink().clone();
    let rows = TokenReader::new(&tokens, end, s.key, &sink);
    let points = rows_of(rows, s)?;
    finish(points, s)
}

fn rows_of<T: Value>(mut rows: TokenReader<'_>, s: &Settings<'_, '_>) -> Option<Vec<(f64, T)>> {
    let mut points: Vec<(f64, T)> = Vec::new();
    while !rows.is_empty() {
        let mut row = rows.list("a row `(time value)`")?;
        let at = row.here();
        let time = row.number("the time");
        if let Some((last, _)) = points.last()
            && time <= *last
        {
            let message = format!("the times of table `{}` do not increase", s.key);
            let label = format!("not after {}", number(*last));
            s.r.error_at(&at, message, label, Some("sort the rows by time"));
        }
        points.push((time, value(&mut row)));
        row.finish();
    }
    Some(points)
}

/// A table of these points with the settings beside it.
pub(super) fn finish<T: Value>(
    points: Vec<(f64, T)>,
    s: &Settings<'_, '_>,
) -> Option<Arc<dyn Form<T>>> {
    let r = &s.r;
    let empty = points.is_empty();
    if empty {
        let help = Some("write a value `v`, `constant v` or `table ((time v) ...)`");
        let at = if r.has(s.key) { s.key } else { "file" };
        r.error_at_key(at, format!("table `{}` is empty", s.key), "no rows", help);
    }
    let choices = [("clamp", false), ("warn", false), ("repeat", false), ("error", true)];
    let strict = r.opt_one_of("outOfBounds", &choices, false);
    let beyond = match r.opt_word("outOfBounds", "clamp") {
        "repeat" => Beyond::Repeat,
        _ => Beyond::Hold,
    };
    if r.opt_word("interpolationScheme", "linear") != "linear" {
        let message = "tables are interpolated linearly";
        r.error_at_key("interpolationScheme", message, "not `linear`", None);
    }
    if let (true, Some((from, to))) = (strict && !empty, s.case.times) {
        let (first, last) = (points[0].0, points[points.len() - 1].0);
        if from < first || to > last {
            let message = format!(
                "table `{}` covers {} to {} s and the run {} to {} s",
                s.key,
                number(first),
                number(last),
                number(from),
                number(to)
            );
            let help = "extend the table, or write `outOfBounds clamp;`";
            r.error_at_key("outOfBounds", message, "`error` was asked for", Some(help));
        }
    }
    Some(Arc::new(Table::new(points, beyond)?))
}
