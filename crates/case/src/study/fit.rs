//! `system/fitDict`: the parameters behind measured profiles.
//!
//! ```text
//! parameters
//! (
//!     { name mus; start 0.36; range (0.2 0.6);
//!       set ( { file constant/transportProperties; entry NGFCoeffs.mus; } ); }
//! );
//! data
//! (
//!     {
//!         name     profile;
//!         measured "measured/profile.csv";  x r;  y V;  error sigma;      // columns or arithmetic; error optional
//!         file     "postProcessing/profile/<time>/radius_U.csv";          // what the case writes
//!         modelX   x;   modelY "U_y/0.0005";
//!         scale    linear;                                                // logarithmic: relative differences
//!     }
//! );
//! confidence 0.95;
//! ```
//!
//! Points are cases below `fit/`; the table is `fit/parameters.csv`.

use super::least_squares::{Bounds, Minimum, minimise};
use super::setting::{check_name, columns};
use super::{Point, Setting, begin};
use crate::expect::interpolate;
use crate::output::POST;
use crate::plot::{Axis, LineFigure, Marker, PALETTE, Scale, Series};
use crate::store::write_atomic;
use crate::{CaseError, Options, files};
use distrs::StudentsT;
use granflow_base::Dims;
use granflow_dict::{Diag, Diags, Reader, Severity, Sink, number};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A parameter to find.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Where to begin.
    pub start: f64,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// What it changes.
    pub settings: Vec<Setting>,
}

/// Measured values and what the case says of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// Their name.
    pub name: String,
    /// Places.
    pub x: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
    /// Standard errors; none where they are not known.
    pub error: Option<Vec<f64>>,
    /// The table of the case and the expressions of place and value.
    pub model: [String; 3],
    /// Whether differences are relative.
    pub relative: bool,
}

/// A fit as the dictionary describes it.
#[derive(Clone, Debug)]
pub struct Fit {
    /// What to find.
    pub parameters: Vec<Parameter>,
    /// From what.
    pub data: Vec<Data>,
    /// Probability of the intervals.
    pub confidence: f64,
}

/// A parameter that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Half of its interval; none where the data do not tell.
    pub half: Option<f64>,
    /// Whether it ended at a bound of its range.
    pub at_bound: bool,
}

/// What a fit came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The parameters.
    pub parameters: Vec<Found>,
    /// Their correlations, row by row.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Sum of squared differences over their errors, and how many more data there are than parameters.
    pub chi2: f64,
    /// See `chi2`.
    pub freedom: usize,
    /// Whether the errors of the data were given; else they are what the fit leaves.
    pub errors_known: bool,
    /// Whether the search came to its end.
    pub converged: bool,
    /// Solutions of the case that it took.
    pub points: usize,
    /// The table and the figures.
    pub files: Vec<PathBuf>,
    /// Where an earlier fit was put.
    pub set_aside: Option<PathBuf>,
}

/// Why a fit ended without parameters.
#[derive(Debug)]
pub enum FitError {
    /// As of any case.
    Case(CaseError),
    /// The case has no solution at the start.
    NoStart(String),
    /// Its results are not where the data are.
    NoData(String),
    /// Asked to stop.
    Stopped,
}

/// A point with its differences over their errors, or why there are none.
type Residuals = (Point, Result<Vec<f64>, Missing>);

/// What a point lacks, and why.
#[derive(Debug)]
enum Missing {
    Solution(String),
    Data(String),
}

impl<E: Into<CaseError>> From<E> for FitError {
    fn from(e: E) -> Self {
        FitError::Case(e.into())
    }
}

impl Fit {
    /// Reads `rel` of the case and the measured tables; mistakes go to the sink.
    ///
    /// # Errors
    /// The file is there and cannot be read; [`CaseError::Invalid`] with mistakes in the sink.
    pub fn read(root: &Path, rel: &str, sink: &Sink) -> Result<Fit, CaseError> {
        let Some(dict) = files::dict(root, rel, sink)? else {
            let d = Diag::file(root.join(rel).display().to_string(), "this file is missing");
            sink.push(d.help("it says what to fit to what: see the book, \"Fits\""));
            return Err(CaseError::Invalid);
        };
        let r = Reader::new(&dict, sink);
        let mut parameters = Vec::new();
        if let Some(mut list) = r.list("parameters") {
            while !list.is_empty() {
                let Some(one) = list.dict("a parameter") else { break };
                let names: Vec<String> =
                    parameters.iter().map(|p: &Parameter| p.name.clone()).collect();
                parameters.push(read_parameter(&one, &names));
            }
        }
        let mut data = Vec::new();
        if let Some(mut list) = r.list("data") {
            while !list.is_empty() {
                let Some(one) = list.dict("measured data") else { break };
                let names: Vec<String> = data.iter().map(|d: &Data| d.name.clone()).collect();
                data.extend(read_data(root, &one, &names));
            }
        }
        let confidence = r.opt_in_range("confidence", Dims::NONE, 0.5..=0.9999, 0.95);
        r.finish(Severity::Error);
        let n: usize = data.iter().map(|d: &Data| d.x.len()).sum();
        if !sink.has_errors() && parameters.is_empty() {
            r.error_at_key("parameters", "there is no parameter", "needs one at least", None);
        }
        if !sink.has_errors() && n <= parameters.len() {
            let message = format!("{n} data for {} parameters", parameters.len());
            r.error_at_key("data", message, "more data than parameters are needed", None);
        }
        if sink.has_errors() {
            return Err(CaseError::Invalid);
        }
        Ok(Fit { parameters, data, confidence })
    }

    /// Finds the parameters; `tell` hears of each step: its number, the parameters and the sum of squares.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn run(
        &self,
        case: &Path,
        options: &Options,
        sink: &Sink,
        tell: &mut dyn FnMut(usize, &[f64], f64),
    ) -> Result<Outcome, FitError> {
        let (_lock, set_aside) = begin(case, "fit")?;
        let bounds: Vec<Bounds> = self
            .parameters
            .iter()
            .map(|p| Bounds { start: p.start, least: p.range[0], most: p.range[1] })
            .collect();
        let (mut points, mut why, mut best) = (0, String::new(), None::<(f64, Point)>);
        let mut solved_at: Vec<(Vec<f64>, Point)> = Vec::new();
        let mut no_data = None;
        let mut model = |at: &[Vec<f64>]| -> Result<Vec<Option<Vec<f64>>>, FitError> {
            let from = best.as_ref().map(|b| b.1.clone());
            let solved = self.solve(case, (points, at), from.as_ref(), options, sink)?;
            points += at.len();
            let mut out = Vec::new();
            for ((point, result), x) in solved.into_iter().zip(at) {
                solved_at.push((x.clone(), point.clone()));
                out.push(match result {
                    Ok(residuals) => {
                        let sum: f64 = residuals.iter().map(|r| r * r).sum();
                        if best.as_ref().is_none_or(|(least, _)| sum <= *least) {
                            best = Some((sum, point));
                        }
                        Some(residuals)
                    }
                    Err(Missing::Solution(e)) => {
                        why = e;
                        None
                    }
                    Err(Missing::Data(e)) => {
                        no_data = Some(e);
                        None
                    }
                });
            }
            Ok(out)
        };
        let found = minimise(&bounds, &mut model, tell)?;
        let found = match (found, no_data) {
            (Some(found), _) => found,
            (None, Some(e)) => return Err(FitError::NoData(e)),
            (None, None) => return Err(FitError::NoStart(why)),
        };
        let at_end = solved_at.into_iter().rev().find(|(x, _)| *x == found.at);
        let mut out = self.judge(&found);
        (out.points, out.set_aside) = (points, set_aside);
        if let Some((_, point)) = at_end {
            self.write(case, &point, &mut out)?;
        }
        Ok(out)
    }

    /// Cases with these parameters, several at once.
    fn solve(
        &self,
        case: &Path,
        (first, at): (usize, &[Vec<f64>]),
        from: Option<&Point>,
        options: &Options,
        sink: &Sink,
    ) -> Result<Vec<Residuals>, FitError> {
        let alone = at.len() == 1;
        let share = Options { threads: if alone { options.threads } else { 1 }, ..options.clone() };
        let mut out = Vec::new();
        for (k, batch) in at.chunks(if alone { 1 } else { options.threads.max(1) }).enumerate() {
            let begin = first + k * options.threads.max(1);
            let solved: Vec<_> = std::thread::scope(|scope| {
                let running: Vec<_> = batch
                    .iter()
                    .enumerate()
                    .map(|(i, p)| {
                        let (share, name) = (&share, format!("point_{}", begin + i));
                        scope.spawn(move || {
                            let own = Sink::new();
                            let one =
                                self.one(&case.join("fit").join(name), case, p, from, share, &own);
                            (one, own.take())
                        })
                    })
                    .collect();
                let wait = |r: std::thread::ScopedJoinHandle<'_, _>| match r.join() {
                    Ok(done) => done,
                    Err(panic) => std::panic::resume_unwind(panic),
                };
                running.into_iter().map(wait).collect()
            });
            for one in solved {
                let (one, said): (Result<Residuals, FitError>, Diags) = one;
                // What the first point has to say the others would say again.
                if one.is_err() || first == 0 && out.is_empty() {
                    sink.extend(said.0);
                }
                out.push(one?);
            }
        }
        Ok(out)
    }

    fn one(
        &self,
        root: &Path,
        case: &Path,
        at: &[f64],
        from: Option<&Point>,
        options: &Options,
        sink: &Sink,
    ) -> Result<Residuals, FitError> {
        let point = Point::copy(case, root)?;
        for (p, x) in self.parameters.iter().zip(at) {
            if let Err(e) = point.set(&p.settings, *x, None) {
                sink.push(Diag::file(root.display().to_string(), e.to_string()));
                return Err(FitError::Case(CaseError::Invalid));
            }
        }
        let solution = point.run(from, options, sink)?;
        if solution.stopped {
            return Err(FitError::Stopped);
        }
        let result = match (solution.found(), solution.failure) {
            (true, _) => self.residuals(root).map_err(Missing::Data),
            (false, Some(why)) => Err(Missing::Solution(why)),
            (false, None) => {
                Err(Missing::Solution("a step did not converge, or none was taken".into()))
            }
        };
        Ok((point, result))
    }

    /// Differences over their errors, of all data.
    fn residuals(&self, root: &Path) -> Result<Vec<f64>, String> {
        let mut out = Vec::new();
        for d in &self.data {
            let (x, y) = d.curve(root).map_err(|e| format!("`{}`: {e}", d.name))?;
            for (i, (at, measured)) in d.x.iter().zip(&d.y).enumerate() {
                let error = d.error.as_ref().map_or(1.0, |e| e[i]);
                let model = value_at(&x, &y, *at);
                out.push(match (d.relative, d.error.is_some()) {
                    (false, _) => (model - measured) / error,
                    (true, true) => (model / measured).ln() * measured / error,
                    (true, false) => (model / measured).ln(),
                });
            }
        }
        let places = self.data.iter().flat_map(|d| d.x.iter().map(move |x| (&d.name, x)));
        match out.iter().zip(places).find(|(r, _)| !r.is_finite()) {
            None => Ok(out),
            Some((_, (name, x))) => {
                Err(format!("`{name}`: the case has no value at {x}, where something was measured"))
            }
        }
    }

    fn judge(&self, found: &Minimum) -> Outcome {
        let chi2: f64 = found.residuals.iter().map(|r| r * r).sum();
        let freedom = found.residuals.len() - self.parameters.len();
        let errors_known = self.data.iter().all(|d| d.error.is_some());
        // Where errors are not known they are what the fit leaves.
        let unit = if errors_known { 1.0 } else { chi2 / freedom as f64 };
        let quantile = StudentsT::ppf(0.5 + 0.5 * self.confidence, freedom as f64);
        let deviation = |i: usize| Some((found.covariance.as_ref()?[i][i] * unit).sqrt());
        let each = self.parameters.iter().zip(&found.at).enumerate();
        let parameters = each
            .map(|(i, (p, x))| Found {
                name: p.name.clone(),
                value: *x,
                half: deviation(i).map(|s| quantile * s).filter(|h| h.is_finite()),
                at_bound: p.range.contains(x),
            })
            .collect();
        let correlation = found.covariance.as_ref().map(|c| {
            let n = c.len();
            let of = |i: usize, j: usize| c[i][j] / (c[i][i] * c[j][j]).sqrt();
            (0..n).map(|i| (0..n).map(|j| of(i, j)).collect()).collect()
        });
        Outcome {
            parameters,
            correlation,
            chi2,
            freedom,
            errors_known,
            converged: found.converged,
            points: 0,
            files: Vec::new(),
            set_aside: None,
        }
    }

    fn write(&self, case: &Path, best: &Point, out: &mut Outcome) -> Result<(), CaseError> {
        let mut text = format!("parameter,value,half_interval_{}\n", self.confidence);
        for p in &out.parameters {
            let half = p.half.map_or("nan".into(), number);
            let _ = writeln!(text, "{},{},{half}", p.name, number(p.value));
        }
        let table = case.join("fit/parameters.csv");
        write_atomic(&table, text.as_bytes())?;
        out.files.push(table);
        for d in &self.data {
            let Ok((x, y)) = d.curve(&best.root) else { continue };
            let measured = d.x.iter().copied().zip(d.y.iter().copied()).collect();
            let scale = if d.relative { Scale::Log } else { Scale::Linear };
            let axis = |label: &str, scale| Axis { label: label.to_owned(), scale, range: None };
            let mut series = vec![
                Series::markers("measured", Marker::nth(0), measured).coloured(PALETTE[0]),
                Series::line("fit", x.into_iter().zip(y).collect()).coloured(PALETTE[1]),
            ];
            if let Some(error) = &d.error {
                for sign in [-1.0, 1.0] {
                    let edge = d.x.iter().zip(&d.y).zip(error);
                    let edge = edge.map(|((x, y), e)| (*x, y + sign * e)).collect();
                    let name = if sign < 0.0 { "measured, +- its error" } else { "" };
                    series.push(Series::dashed(name, edge).coloured(PALETTE[0]));
                }
            }
            let figure = LineFigure {
                x: axis(&d.model[1], Scale::Linear),
                y: axis(&d.model[2], scale),
                series,
                ..LineFigure::default()
            };
            let file =
                |end: &str| case.join(POST).join("figures").join(format!("fit_{}.{end}", d.name));
            let (svg, png) = (file("svg"), file("png"));
            write_atomic(&svg, figure.to_svg().as_bytes())?;
            write_atomic(&png, &figure.to_png()?)?;
            out.files.extend([png, svg]);
        }
        Ok(())
    }
}

impl Data {
    /// What the case at `root` has: places in rising order, and values.
    fn curve(&self, root: &Path) -> Result<(Vec<f64>, Vec<f64>), String> {
        let [file, x, y] = &self.model;
        let mut both = columns(root, file, &[x, y])?;
        let (y, x) = (both.pop().unwrap_or_default(), both.pop().unwrap_or_default());
        let mut pairs: Vec<(f64, f64)> = x.into_iter().zip(y).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(pairs.into_iter().unzip())
    }
}

/// The value of a curve at a place; a table of one row is a number, whatever its place. Not a number more than a
/// spacing of the ends beyond them.
fn value_at(x: &[f64], y: &[f64], at: f64) -> f64 {
    match x {
        [] => f64::NAN,
        [_] => y[0],
        [first, second, ..] => {
            let n = x.len();
            let beyond = (first - at) > second - first || at - x[n - 1] > x[n - 1] - x[n - 2];
            match n {
                _ if beyond => f64::NAN,
                4.. => interpolate(x, y, at),
                _ => {
                    let k = x.partition_point(|v| *v < at).clamp(1, n - 1);
                    y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1])
                }
            }
        }
    }
}

fn read_parameter(r: &Reader<'_>, others: &[String]) -> Parameter {
    let start = r.scalar("start", Dims::NONE);
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    if let Some(mut list) = r.list("range") {
        range = [list.number("the least value"), list.number("the greatest value")];
        list.finish();
    }
    if !(range[0] < range[1] && range[0] <= start && start <= range[1]) {
        let message =
            format!("start {start} does not lie in the range {} to {}", range[0], range[1]);
        r.error_at_key("start", message, "outside of `range`", None);
    }
    let name = r.word("name").to_owned();
    check_name(r, "name", &name, &others.iter().map(String::as_str).collect::<Vec<_>>());
    let parameter = Parameter { name, start, range, settings: Setting::read_all(r, false) };
    r.finish(Severity::Error);
    parameter
}

fn read_data(root: &Path, r: &Reader<'_>, others: &[String]) -> Option<Data> {
    let text = |key: &str| r.string(key).to_owned();
    let measured = text("measured");
    let (x, y) = (text("x"), text("y"));
    let error = r.maybe_string("error").map(str::to_owned);
    let scales = [("linear", false), ("logarithmic", true)];
    let (name, model) = (r.word("name").to_owned(), ["file", "modelX", "modelY"].map(text));
    check_name(r, "name", &name, &others.iter().map(String::as_str).collect::<Vec<_>>());
    let relative = r.opt_one_of("scale", &scales, false);
    r.finish(Severity::Error);
    let wanted: Vec<&str> =
        [Some(&x), Some(&y), error.as_ref()].into_iter().flatten().map(|s| s.as_str()).collect();
    let mut found = match columns(root, &measured, &wanted) {
        Ok(found) => found.into_iter(),
        Err(e) => {
            r.error_at_key("measured", e, "cannot be read", None);
            return None;
        }
    };
    let (x, y) = (found.next()?, found.next()?);
    let error = found.next();
    if error.as_ref().is_some_and(|e| e.iter().any(|e| !(*e > 0.0 && e.is_finite()))) {
        r.error_at_key("error", "an error of a measurement is not positive", "must be", None);
    }
    if relative && y.iter().any(|y| *y <= 0.0) {
        let help = Some("write `scale linear;` or leave them out");
        r.error_at_key("scale", "measured values are not all positive", "needs them", help);
    }
    Some(Data { name, x, y, error, model, relative })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_have_values_between_their_ends_and_a_spacing_beyond() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let y = x.map(|x| x * x);
        assert!((value_at(&x, &y, 2.5) - 6.25).abs() < 1e-12);
        assert!((value_at(&x, &y, 4.5) - 20.25).abs() < 1e-12);
        assert!(value_at(&x, &y, 5.5).is_nan() && value_at(&x, &y, -1.5).is_nan());
        assert_eq!(value_at(&x[..2], &y[..2], 0.25), 0.25);
        assert_eq!(value_at(&[7.0], &[3.0], 0.0), 3.0);
        assert!(value_at(&[], &[], 0.0).is_nan());
    }
}
