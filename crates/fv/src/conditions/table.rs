//! Values that depend on time.

use super::basic::text;
use super::{Condition, PatchClosure, PatchView};
use granflow_base::{Dims, Value};
use granflow_dict::{Reader, TokenReader, number};

/// A constant, or a table of (time, value) with linear interpolation, constant beyond its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeTable<T> {
    points: Vec<(f64, T)>,
}

impl<T: Value> TimeTable<T> {
    /// The constant `v`.
    pub fn constant(v: T) -> Self {
        TimeTable { points: vec![(0.0, v)] }
    }
    /// A table; `None` when it is empty or its times do not increase.
    pub fn new(points: Vec<(f64, T)>) -> Option<Self> {
        let sorted = points.windows(2).all(|w| w[0].0 < w[1].0);
        (sorted && !points.is_empty()).then_some(TimeTable { points })
    }
    /// The value at `time`.
    pub fn at(&self, time: f64) -> T {
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
    /// As a dictionary writes it.
    pub fn text(&self) -> String {
        if let [(_, v)] = self.points[..] {
            return text(v);
        }
        let rows: Vec<String> =
            self.points.iter().map(|(t, v)| format!("({} {})", text(*t), text(*v))).collect();
        format!("table ({})", rows.join(" "))
    }
    /// Reads `v`, `constant v`, `uniform v` or `table ((t v) ...)` under `key`.
    pub fn read(r: &Reader<'_>, key: &str, dims: Dims) -> Self {
        let zero = TimeTable::constant(T::ZERO);
        // `[dims]` before a plain number is accepted by the scalar reader only.
        if r.raw(key).is_some_and(|t| t.len() == 2 && t[1].number().is_some()) && T::N == 1 {
            let mut v = T::ZERO;
            let words = r.raw(key).is_some_and(|t| t[0].word().is_some());
            if !words {
                v.set_comp(0, r.scalar(key, dims));
                return TimeTable::constant(v);
            }
        }
        let Some(mut t) = r.tokens(key) else { return zero };
        match t.opt_word() {
            None | Some("constant" | "uniform") => {
                let v = value(&mut t);
                t.finish();
                TimeTable::constant(v)
            }
            Some("table") => {
                let before = r.sink().n_errors();
                let Some(mut rows) = t.list("the table") else { return zero };
                let mut points: Vec<(f64, T)> = Vec::new();
                while !rows.is_empty() {
                    let Some(mut row) = rows.list("a row `(time value)`") else { return zero };
                    let at = row.here();
                    let time = row.number("the time");
                    if let Some((last, _)) = points.last()
                        && time <= *last
                    {
                        let message = format!("the times of table `{key}` do not increase");
                        let label = format!("not after {}", number(*last));
                        r.error_at(&at, message, label, Some("sort the rows by time"));
                    }
                    points.push((time, value(&mut row)));
                    row.finish();
                }
                t.finish();
                if points.is_empty() {
                    r.error_at_key(key, format!("table `{key}` is empty"), "no rows", TABLE);
                }
                if r.sink().n_errors() > before {
                    return zero;
                }
                TimeTable::new(points).unwrap_or(zero)
            }
            Some(other) => {
                let label = format!("`{other}` is not known here");
                r.error_at_key(key, format!("`{key}` is no function of time"), label, TABLE);
                zero
            }
        }
    }
}

/// How a value that depends on time is written.
const TABLE: Option<&str> = Some("write a value `v`, `constant v` or `table ((time v) ...)`");

/// One value of the type of the field: a number or a vector.
fn value<T: Value>(t: &mut TokenReader<'_>) -> T {
    let mut v = T::ZERO;
    if T::N == 1 {
        v.set_comp(0, t.number("the value"));
    } else {
        let x = t.vector("the value");
        (0..T::N.min(3)).for_each(|c| v.set_comp(c, x[c]));
    }
    v
}

/// A uniform value that depends on time.
pub struct UniformFixedValue<T> {
    /// The value against time.
    pub value: TimeTable<T>,
}
impl<T: Value> Condition<T> for UniformFixedValue<T> {
    fn name(&self) -> &'static str {
        "uniformFixedValue"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(self.value.at(view.around.time));
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("uniformValue".into(), self.value.text())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_dict::{Sink, parse_str};

    #[test]
    fn a_table_interpolates_and_holds_its_ends() {
        let (dict, diags) = parse_str("omega table ((1 2) (3 6));  c 4; k constant 7;");
        assert!(diags.is_empty());
        let sink = Sink::new();
        let r = Reader::new(&dict, &sink);
        let t = TimeTable::<f64>::read(&r, "omega", Dims::RATE);
        assert_eq!([t.at(0.0), t.at(2.0), t.at(9.0)], [2.0, 4.0, 6.0]);
        assert_eq!(t.text(), "table ((1 2) (3 6))");
        assert_eq!(TimeTable::<f64>::read(&r, "c", Dims::RATE).at(5.0), 4.0);
        assert_eq!(TimeTable::<f64>::read(&r, "k", Dims::RATE).at(5.0), 7.0);
        assert!(!sink.has_errors());
    }
}
