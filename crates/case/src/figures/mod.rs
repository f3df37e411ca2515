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
//! `type slice;` and `type volume;` draw fields instead: see the book, "Figures".
//!
//! `reference` is a file like any other, drawn with markers. Columns have the names that the
//! file's header gives, and `col1`, `col2`, ...; see [`expression`] and [`table`].

pub mod expression;
mod field;
mod gaps;
mod limits;
mod shades;
mod slice;
mod solid;
mod stream;
pub mod table;

use crate::CaseError;
use crate::files;
use crate::output::POST;
use crate::plot::{
    Axis, Legend, LineFigure, Marker, Scale, Series, SliceFigure, SolidFigure, Style,
};
use crate::store::{Operation, StoreError, TimeName, write_atomic};
use gaps::Gaps;
use granflow_dict::{Reader, Severity, Sink};
use std::path::{Path, PathBuf};
use table::Table;

/// Looks for mistakes in `system/plotDict` before there are data; they go to the sink.
///
/// # Errors
/// The file is there and cannot be read.
pub fn check(root: &Path, sink: &Sink) -> Result<(), CaseError> {
    check_in(root, PLOT, sink)
}

/// The dictionary of a case's figures.
const PLOT: &str = "system/plotDict";

/// The same for the `figures` of another dictionary, whose other entries are its own.
///
/// # Errors
/// The file is there and cannot be read.
pub(crate) fn check_in(root: &Path, dict: &str, sink: &Sink) -> Result<(), CaseError> {
    read(root, dict, Look::AtForm, sink).map(drop)
}

/// What a figure is.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Lines,
    Slice,
    Volume,
}

/// What reading a figure looks at.
#[derive(Clone, Copy, PartialEq)]
enum Look {
    /// The dictionary only: the data need not be there yet.
    AtForm,
    /// The data as well.
    AtData,
}

/// Draws the figures of `system/plotDict` and returns the files made; none without that file.
/// Curves whose data are not there are left out with a warning.
///
/// # Errors
/// [`CaseError::Invalid`] with the mistakes in the sink; a figure cannot be drawn or written.
pub fn draw(root: &Path, sink: &Sink) -> Result<Vec<PathBuf>, CaseError> {
    draw_in(root, PLOT, sink)
}

/// The same for the `figures` of another dictionary.
///
/// # Errors
/// As [`draw`].
pub(crate) fn draw_in(root: &Path, dict: &str, sink: &Sink) -> Result<Vec<PathBuf>, CaseError> {
    let before = sink.n_errors();
    let drawn = read(root, dict, Look::AtData, sink)?;
    if sink.n_errors() > before {
        return Err(CaseError::Invalid);
    }
    let mut out = Vec::new();
    for (name, figure) in &drawn {
        let (drawing, picture) = match figure {
            Figure::Lines(f) if f.series.is_empty() => continue,
            Figure::Lines(f) => (f.to_svg(), f.to_png()?),
            Figure::Slice(f) => f.render()?,
            Figure::Solid(f) => f.render()?,
        };
        let file = |ending: &str| root.join(POST).join("figures").join(format!("{name}.{ending}"));
        let (svg, png) = (file("svg"), file("png"));
        write_atomic(&svg, drawing.as_bytes())?;
        write_atomic(&png, &picture)?;
        out.extend([png, svg]);
    }
    Ok(out)
}

/// A figure of any kind.
enum Figure {
    Lines(LineFigure),
    Slice(SliceFigure),
    Solid(SolidFigure),
}

/// The figures of a dictionary with their names.
fn read(
    root: &Path,
    file: &str,
    look: Look,
    sink: &Sink,
) -> Result<Vec<(String, Figure)>, CaseError> {
    // The mistakes of a dictionary that is somebody else's are said there.
    let own = file == PLOT;
    let said = Sink::new();
    let Some(dict) = files::dict(root, file, if own { sink } else { &said })? else {
        return Ok(Vec::new());
    };
    let r = Reader::new(&dict, sink);
    if !own {
        r.keys().into_iter().filter(|k| *k != "figures").for_each(|k| r.ignore(k));
    }
    let (mut out, mut gaps) = (Vec::new(), Gaps::default());
    // The mesh is read once, and only if a figure needs it.
    let mut grid = None;
    for (name, figure) in r.sub("figures").map_or(Vec::new(), |f| f.subs()) {
        let kinds = [("lines", Kind::Lines), ("slice", Kind::Slice), ("volume", Kind::Volume)];
        let before = sink.n_errors();
        let kind = figure.opt_one_of("type", &kinds, Kind::Lines);
        if sink.n_errors() > before {
            // Which of its entries are wrong depends on the type.
            figure.ignore_all();
            continue;
        }
        if kind == Kind::Lines {
            let lines = read_figure(root, look, &figure, &mut gaps)?;
            out.push((name.to_owned(), Figure::Lines(lines)));
            continue;
        }
        let spec = Field::read(kind, &figure);
        let times = match time_given(&figure) {
            Some(times) if look == Look::AtData && sink.n_errors() == before => {
                times_of_fields(root, &times, &figure, &mut gaps)?
            }
            _ => continue,
        };
        if grid.is_none() && !times.is_empty() {
            grid = Some(field::grid(root, sink)?);
        }
        for time in &times {
            let Some(grid) = &grid else { break };
            let drawn = spec.draw(&field::Scene::new(root, time, grid))?;
            if sink.n_errors() > before {
                // It would be said again of every time.
                break;
            }
            let name = if times.len() > 1 { format!("{name}_{time}") } else { name.to_owned() };
            out.extend(drawn.map(|figure| (name, figure)));
        }
    }
    gaps.warn(sink);
    r.finish(Severity::Error);
    Ok(out)
}

/// A figure of fields as the dictionary describes it.
enum Field<'a> {
    Slice(Box<slice::SliceSpec<'a>>),
    Solid(Box<solid::SolidSpec<'a>>),
}

impl<'a> Field<'a> {
    fn read(kind: Kind, r: &Reader<'a>) -> Field<'a> {
        match kind {
            Kind::Volume => Field::Solid(Box::new(solid::SolidSpec::read(r))),
            _ => Field::Slice(Box::new(slice::SliceSpec::read(r))),
        }
    }

    fn draw(&self, scene: &field::Scene<'_>) -> Result<Option<Figure>, CaseError> {
        Ok(match self {
            Field::Slice(s) => s.draw(scene)?.map(Figure::Slice),
            Field::Solid(s) => Some(Figure::Solid(s.draw(scene)?)),
        })
    }
}

fn read_figure(
    root: &Path,
    look: Look,
    r: &Reader<'_>,
    gaps: &mut Gaps,
) -> Result<LineFigure, CaseError> {
    let scales = [("linear", Scale::Linear), ("log", Scale::Log)];
    let axis = |label: &str, scale: &str, range: &str| Axis {
        label: r.opt_string(label, "").to_owned(),
        scale: r.opt_one_of(scale, &scales, Scale::Linear),
        range: shades::range(r, range),
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
        if let Some(curve) = list.dict("curve") {
            figure.series.extend(read_curve(root, look, &curve, &mut markers, gaps)?);
        }
        if list.rest().len() == left {
            break;
        }
    }
    Ok(figure)
}

/// The series of one entry: one for each of its times.
fn read_curve(
    root: &Path,
    look: Look,
    r: &Reader<'_>,
    markers: &mut usize,
    gaps: &mut Gaps,
) -> Result<Vec<Series>, CaseError> {
    #[derive(Clone, Copy)]
    enum Stroke {
        Line,
        Dashed,
        Markers,
    }
    let key = if r.has("reference") { "reference" } else { "file" };
    let file = r.string(key);
    let looks = [("line", Stroke::Line), ("dashed", Stroke::Dashed), ("markers", Stroke::Markers)];
    let usual = if key == "reference" { Stroke::Markers } else { Stroke::Line };
    let stroke = r.opt_one_of("style", &looks, usual);
    let (x, y) = (r.string("x"), r.string("y"));
    let label = r.opt_string("label", "");
    let labels: Option<Vec<String>> = r.maybe_list("labels").map(|mut l| {
        let mut out = Vec::new();
        while l.peek().is_some() {
            out.push(l.string("a label").to_owned());
        }
        out
    });
    if look == Look::AtForm {
        field::check(r, "x", x);
        field::check(r, "y", y);
        time_given(r);
        return Ok(Vec::new());
    }
    let times = wanted_times(root, file, r, gaps)?;
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
            gaps.note(&files::shown(&path), &[], &r.value_span(key));
            continue;
        };
        let table = Table::parse(&text);
        let of = |key: &str, text: &str| {
            expression::evaluate(text, &table).map_err(|e| {
                let message = format!("`{key}` of {}: {e}", files::shown(&path));
                r.error_at_key(key, message, "cannot be evaluated", None);
            })
        };
        let (Ok(xs), Ok(ys)) = (of("x", x), of("y", y)) else { continue };
        let name = match &labels {
            Some(l) => l.get(i).cloned().unwrap_or_default(),
            None => label.replace("<time>", time),
        };
        let points = xs.into_iter().zip(ys).collect();
        let style = match stroke {
            Stroke::Line => Style::Line,
            Stroke::Dashed => Style::Dashed,
            Stroke::Markers => {
                *markers += 1;
                Style::Markers(Marker::nth(*markers - 1))
            }
        };
        out.push(Series { name, points, style, colour: None });
    }
    Ok(out)
}

/// Names of the time folders a curve asks for; one empty name when its file has no `<time>`.
fn wanted_times(
    root: &Path,
    file: &str,
    r: &Reader<'_>,
    gaps: &mut Gaps,
) -> Result<Vec<String>, CaseError> {
    let Some((folder, _)) = file.split_once("<time>") else {
        r.ignore("time");
        return Ok(vec![String::new()]);
    };
    let Some(times) = time_given(r) else { return Ok(Vec::new()) };
    let there = times_in(&root.join(folder))?;
    let (found, lacking) = times.among(&there);
    if there.is_empty() {
        gaps.note(&files::shown(&root.join(folder)), &[], &r.value_span("file"));
    } else if !lacking.is_empty() {
        gaps.note(folder, &lacking, &r.value_span("time"));
    }
    Ok(found)
}

/// Names of the time directories of the case that a figure of fields asks for.
fn times_of_fields(
    root: &Path,
    times: &Times,
    r: &Reader<'_>,
    gaps: &mut Gaps,
) -> Result<Vec<String>, CaseError> {
    let there = times_in(root)?;
    let (found, lacking) = times.among(&there);
    if there.is_empty() || !lacking.is_empty() {
        gaps.note_fields(&lacking, &r.value_span("time"));
    }
    Ok(found)
}

/// What `time` of a curve or of a figure asks for.
enum Times {
    Latest,
    First,
    All,
    These(Vec<f64>),
}

impl Times {
    /// The names of those that are there, given in order, and the ones that are not.
    fn among(&self, there: &[(f64, String)]) -> (Vec<String>, Vec<String>) {
        let one = |t: Option<&(f64, String)>| t.map_or(Vec::new(), |t| vec![t.1.clone()]);
        match self {
            Times::Latest => (one(there.last()), Vec::new()),
            Times::First => (one(there.first()), Vec::new()),
            Times::All => (there.iter().map(|t| t.1.clone()).collect(), Vec::new()),
            Times::These(wanted) => {
                let (mut found, mut lacking) = (Vec::new(), Vec::new());
                for t in wanted {
                    let off = |x: &&(f64, String)| (x.0 - t).abs();
                    let best = there.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
                    match best.filter(|b| off(b) <= 1e-6 * t.abs().max(1e-300)) {
                        Some(best) => found.push(best.1.clone()),
                        None => lacking.push(t.to_string()),
                    }
                }
                (found, lacking)
            }
        }
    }
}

/// Reads `time`; `None` when it is wrong, which is reported.
fn time_given(r: &Reader<'_>) -> Option<Times> {
    let Some(token) = r.raw("time").and_then(|t| t.first()) else { return Some(Times::Latest) };
    let given = match token.word() {
        Some("latest") => Some(Times::Latest),
        Some("first") => Some(Times::First),
        Some("all") => Some(Times::All),
        Some(_) => None,
        None => token.number().map(|t| vec![t]).or_else(|| token.scalars()).map(Times::These),
    };
    if given.is_none() {
        let help = Some("write latest, first, all, a number or a list of numbers");
        r.error_at_key("time", format!("{} is not a time", token.describe()), "unknown", help);
    }
    given
}

/// Times in a folder and the names of their folders, in order.
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
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(out)
}

fn read_text(path: &Path) -> Result<Option<String>, StoreError> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(StoreError::new(Operation::Read, path, e)),
    }
}
