//! Figures of a case: `system/plotDict`, drawn by `granflow plot` and at the end of a run.
//!
//! ```text
//! figures
//! {
//!     velocity                                      // postProcessing/figures/velocity.{png,svg}
//!     {
//!         title   "Velocity across the gap";        // optional, as all but `curves`
//!         xLabel  "(r - R_i)/d";    yLabel "V/V_{wall}";
//!         xScale  linear;           yScale log;     // default linear
//!         xRange  (0 16);           yRange (1e-4 1);
//!         legend  auto;                             // outside, none
//!         curves
//!         (
//!             {
//!                 file   "postProcessing/gap/<time>/gap_U.xy";   // <time>: each of `time`
//!                 time   latest;                    // first, all, 0.5, (0.1 0.2)
//!                 label  "t = <time> s";            // or labels ("slow" "fast") for a list
//!                 x      "(distance)/0.00075";      // arithmetic on columns
//!                 y      "U_y/max(U_y)";            // max min mean first last: of the column
//!                 style  line;                      // dashed, markers
//!             }
//!             { reference "reference/annular.csv"; label "reference"; x r_over_d; y V_over_Vw; }
//!         );
//!     }
//! }
//! ```
//!
//! `reference` is a file like any other, drawn with markers. Columns have the names that the
//! file's header gives, and `col1`, `col2`, ...; see [`expression`] and [`table`].

pub mod expression;
pub mod table;

use crate::CaseError;
use crate::files;
use crate::output::POST;
use crate::plot::{Axis, Legend, LineFigure, Marker, Scale, Series, Style};
use crate::store::{Operation, StoreError, TimeName, write_atomic};
use granflow_dict::{Diag, Reader, Severity, Sink, Span};
use std::path::{Path, PathBuf};
use table::Table;

/// Draws the figures of `system/plotDict` and returns the files made; none without that file.
/// Curves whose data are not there are left out with a warning.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink; a figure cannot be drawn or written.
pub fn draw(root: &Path, sink: &Sink) -> Result<Vec<PathBuf>, CaseError> {
    let before = sink.n_errors();
    let Some(dict) = files::dict(root, "system/plotDict", sink)? else { return Ok(Vec::new()) };
    let r = Reader::new(&dict, sink);
    let mut drawn = Vec::new();
    for (name, figure) in r.sub("figures").map_or(Vec::new(), |f| f.subs()) {
        drawn.push((name.to_owned(), read_figure(root, &figure)?));
    }
    r.finish(Severity::Error);
    if sink.n_errors() > before {
        return Err(CaseError::Invalid);
    }
    let mut out = Vec::new();
    for (name, figure) in drawn.iter().filter(|(_, f)| !f.series.is_empty()) {
        let stem = root.join(POST).join("figures").join(name);
        let (svg, png) = (stem.with_extension("svg"), stem.with_extension("png"));
        write_atomic(&svg, figure.to_svg().as_bytes())?;
        write_atomic(&png, &figure.to_png()?)?;
        out.extend([png, svg]);
    }
    Ok(out)
}

fn read_figure(root: &Path, r: &Reader<'_>) -> Result<LineFigure, CaseError> {
    let scales = [("linear", Scale::Linear), ("log", Scale::Log)];
    let axis = |label: &str, scale: &str, range: &str| Axis {
        label: r.opt_string(label, "").to_owned(),
        scale: r.opt_one_of(scale, &scales, Scale::Linear),
        range: r.maybe_scalars(range).and_then(|v| match v[..] {
            [a, b] if a < b => Some((a, b)),
            _ => {
                let help = Some("write `(0 16)`");
                r.error_at_key(range, "a range is two growing numbers", "not a range", help);
                None
            }
        }),
    };
    let mut figure = LineFigure {
        title: r.opt_string("title", "").to_owned(),
        x: axis("xLabel", "xScale", "xRange"),
        y: axis("yLabel", "yScale", "yRange"),
        series: Vec::new(),
        legend: r.opt_one_of(
            "legend",
            &[("auto", Legend::Auto), ("outside", Legend::Outside), ("none", Legend::None)],
            Legend::Auto,
        ),
    };
    let Some(mut list) = r.list("curves") else { return Ok(figure) };
    let mut markers = 0;
    while !list.is_empty() {
        let left = list.rest().len();
        if let Some(curve) = list.dict("a curve `{ ... }`") {
            figure.series.extend(read_curve(root, &curve, &mut markers)?);
        }
        if list.rest().len() == left {
            break;
        }
    }
    Ok(figure)
}

/// The series of one entry: one for each of its times.
fn read_curve(root: &Path, r: &Reader<'_>, markers: &mut usize) -> Result<Vec<Series>, CaseError> {
    #[derive(Clone, Copy)]
    enum Look {
        Line,
        Dashed,
        Markers,
    }
    let key = if r.has("reference") { "reference" } else { "file" };
    let file = r.string(key);
    let looks = [("line", Look::Line), ("dashed", Look::Dashed), ("markers", Look::Markers)];
    let usual = if key == "reference" { Look::Markers } else { Look::Line };
    let look = r.opt_one_of("style", &looks, usual);
    let (x, y) = (r.string("x"), r.string("y"));
    let label = r.opt_string("label", "");
    let labels: Option<Vec<String>> = r.maybe_list("labels").map(|mut l| {
        let mut out = Vec::new();
        while l.peek().is_some() {
            out.push(l.string("a label").to_owned());
        }
        out
    });
    let times = wanted_times(root, file, r)?;
    if let Some(given) = &labels
        && given.len() != times.len()
    {
        let message = format!("{} labels for {} times", given.len(), times.len());
        r.error_at_key("labels", message, "one label a time", None);
    }
    let mut out = Vec::new();
    for (i, time) in times.iter().enumerate() {
        let path = root.join(file.replace("<time>", time));
        let Some(text) = read_text(&path)? else {
            let message = format!("there are no data in {}", path.display());
            r.warn_at_key(key, message, "the curve is left out", None);
            continue;
        };
        let table = Table::parse(&text);
        let of = |key: &str, text: &str| {
            expression::evaluate(text, &table).map_err(|e| {
                let message = format!("`{key}` of {}: {e}", path.display());
                r.error_at_key(key, message, "cannot be evaluated", None);
            })
        };
        let (Ok(xs), Ok(ys)) = (of("x", x), of("y", y)) else { continue };
        let name = match &labels {
            Some(l) => l.get(i).cloned().unwrap_or_default(),
            None => label.replace("<time>", time),
        };
        let points = xs.into_iter().zip(ys).collect();
        let style = match look {
            Look::Line => Style::Line,
            Look::Dashed => Style::Dashed,
            Look::Markers => {
                *markers += 1;
                Style::Markers(Marker::nth(*markers - 1))
            }
        };
        out.push(Series { name, points, style, colour: None });
    }
    Ok(out)
}

/// Names of the time folders a curve asks for; one empty name when its file has no `<time>`.
fn wanted_times(root: &Path, file: &str, r: &Reader<'_>) -> Result<Vec<String>, CaseError> {
    let Some((folder, _)) = file.split_once("<time>") else {
        r.ignore("time");
        return Ok(vec![String::new()]);
    };
    let mut there = times_in(&root.join(folder))?;
    there.sort_by(|a, b| a.0.total_cmp(&b.0));
    let names = |v: &[(f64, String)]| v.iter().map(|t| t.1.clone()).collect::<Vec<_>>();
    let one = |t: Option<&(f64, String)>| t.map_or(Vec::new(), |t| vec![t.1.clone()]);
    let found = match r.raw("time").and_then(|t| t.first()) {
        None => one(there.last()),
        Some(token) => match token.word() {
            Some("latest") => one(there.last()),
            Some("first") => one(there.first()),
            Some("all") => names(&there),
            Some(other) => {
                let message = format!("unknown time `{other}`");
                let help = Some("write latest, first, all, a number or a list of numbers");
                r.error_at_key("time", message, "not a time", help);
                return Ok(Vec::new());
            }
            None => {
                let wanted = token.number().map(|t| vec![t]).or_else(|| token.scalars());
                let wanted = wanted.unwrap_or_default();
                let near = |t: f64| {
                    let off = |x: &&(f64, String)| (x.0 - t).abs();
                    let best = there.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
                    (off(&best) <= 1e-6 * t.abs().max(1e-300)).then(|| best.1.clone())
                };
                let span: Span = r.value_span("time");
                wanted
                    .into_iter()
                    .filter_map(|t| {
                        let name = near(t);
                        if name.is_none() {
                            let message = format!("no data for the time {t} in {folder}");
                            let d = Diag::warning(&span, message);
                            r.sink().push(d.label("the curve is left out"));
                        }
                        name
                    })
                    .collect()
            }
        },
    };
    if there.is_empty() {
        let message = format!("there are no data in {}", root.join(folder).display());
        r.warn_at_key("file", message, "the curve is left out", None);
    }
    Ok(found)
}

fn times_in(folder: &Path) -> Result<Vec<(f64, String)>, StoreError> {
    let fail = |e| StoreError::new(Operation::Read, folder, e);
    let entries = match std::fs::read_dir(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.map_err(fail)?,
    };
    let mut out = Vec::new();
    for entry in entries {
        let name = entry.map_err(fail)?.file_name();
        let Some(name) = name.to_str() else { continue };
        if let Some(t) = TimeName::parse(name) {
            out.push((t, name.to_owned()));
        }
    }
    Ok(out)
}

fn read_text(path: &Path) -> Result<Option<String>, StoreError> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(StoreError::new(Operation::Read, path, e)),
    }
}
