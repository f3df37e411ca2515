//! What a sweep leaves: its table, the limits of its family, and their figures.

use super::sweep::{Ends, Outcome, Row, Sweep};
use crate::CaseError;
use crate::output::POST;
use crate::plot::{Axis, LineFigure, Marker, PALETTE, Scale, Series};
use crate::store::write_atomic;
use granflow_dict::{Sink, number};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Points of a line.
type Points = Vec<(f64, f64)>;

impl Sweep {
    /// The table, and a figure for each result.
    pub(super) fn write(
        &self,
        case: &Path,
        sink: &Sink,
        out: &mut Outcome,
    ) -> Result<(), CaseError> {
        let mut text = String::new();
        if let Some(family) = &self.family {
            let _ = write!(text, "{},", family.parameter);
        }
        text += &self.parameter;
        self.results.iter().for_each(|q| text += &format!(",{}", q.name));
        text += ",converged,steady,passes\n";
        for row in &out.rows {
            if let Some(y) = row.y {
                let _ = write!(text, "{},", number(y));
            }
            text += &number(row.x);
            for result in &row.results {
                // What is missing is no number.
                let _ = write!(text, ",{}", result.as_ref().map_or("nan".into(), |v| number(*v)));
            }
            let s = &row.solution;
            let [converged, steady] = [s.found(), s.steady].map(u8::from);
            let _ = writeln!(text, ",{converged},{steady},{}", s.passes);
        }
        let table = case.join("sweep").join(format!("{}.csv", self.parameter));
        write_atomic(&table, text.as_bytes())?;
        out.files.push(table);
        if let Some(dict) = &self.figures {
            out.files.extend(crate::figures::draw_in(case, dict, sink)?);
            return Ok(());
        }
        let labelled = |name: &str, unit: &str| match unit {
            "" => name.to_owned(),
            unit => format!("{name}, {unit}"),
        };
        let own = labelled(&self.parameter, &self.unit);
        let members = |row: &Row| row.y.map_or(0, f64::to_bits);
        for (i, result) in self.results.iter().enumerate() {
            let flowing = out.rows.iter().filter(|r| self.flows(r));
            let mut lines: Vec<(Option<f64>, Points)> = Vec::new();
            let mut last = None;
            for row in flowing {
                let Ok(value) = row.results[i] else { continue };
                if last != Some(members(row)) {
                    lines.push((row.y, Vec::new()));
                    last = Some(members(row));
                }
                lines.last_mut().expect("one was pushed").1.push((row.x, value));
            }
            let name = |y: Option<f64>| match (&self.family, y) {
                (Some(f), Some(y)) => format!("{} {} {}", f.parameter, number(y), f.unit),
                _ => String::new(),
            };
            let lines = lines.into_iter().map(|(y, points)| (name(y), points)).collect();
            out.files.extend(draw(case, &result.name, (&own, &result.name), lines)?);
        }
        if let (Some(family), false) = (&self.family, out.limits.is_empty()) {
            let middle = |e: &Ends| (e.y.unwrap_or(f64::NAN), 0.5 * (e.flows + e.stands));
            let points: Vec<(f64, f64)> = out.limits.iter().map(middle).collect();
            let mut text = format!("{},limit,flows,stands\n", family.parameter);
            for (e, (y, limit)) in out.limits.iter().zip(&points) {
                let row = [*y, *limit, e.flows, e.stands].map(number);
                let _ = writeln!(text, "{}", row.join(","));
            }
            let table = case.join("sweep/limit.csv");
            write_atomic(&table, text.as_bytes())?;
            out.files.push(table);
            let outer = labelled(&family.parameter, &family.unit);
            let lines = vec![(String::new(), points)];
            out.files.extend(draw(case, "limit", (&outer, &format!("limit of {own}")), lines)?);
        }
        Ok(())
    }
}

/// A figure of lines with markers, as PNG and SVG.
fn draw(
    case: &Path,
    name: &str,
    (x, y): (&str, &str),
    lines: Vec<(String, Points)>,
) -> Result<Vec<PathBuf>, CaseError> {
    let all = || lines.iter().flat_map(|l| l.1.iter());
    if all().next().is_none() {
        return Ok(Vec::new());
    }
    let axis = |label: &str, values: Vec<f64>| Axis {
        label: label.to_owned(),
        scale: scale(&values),
        range: None,
    };
    let x = axis(x, all().map(|p| p.0).collect());
    let y = axis(y, all().map(|p| p.1).collect());
    let mut series = Vec::new();
    for (i, (name, points)) in lines.into_iter().enumerate() {
        let colour = PALETTE[i % PALETTE.len()];
        let markers = Series::markers("", Marker::nth(i), points.clone());
        series.extend([Series::line(name, points).coloured(colour), markers.coloured(colour)]);
    }
    let figure = LineFigure { x, y, series, ..LineFigure::default() };
    let file = |end: &str| case.join(POST).join("figures").join(format!("sweep_{name}.{end}"));
    let (svg, png) = (file("svg"), file("png"));
    write_atomic(&svg, figure.to_svg().as_bytes())?;
    write_atomic(&png, &figure.to_png()?)?;
    Ok(vec![png, svg])
}

/// Logarithmic where values span two decades or more.
pub(super) fn scale(values: &[f64]) -> Scale {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    if least > 0.0 && most >= 100.0 * least { Scale::Log } else { Scale::Linear }
}
