//! Files of points with values: columns, csv, VTK's legacy PolyData, and what gnuplot, Grace and
//! JPlot read.

use super::field::{Components, Rank};
use super::{Named, Written};
use granflow_base::Vec3;
use granflow_dict::{Reader, number};

/// How sets of points are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SetFormat {
    /// `.xy`: columns of numbers below a comment that names them.
    Raw,
    /// `.csv`.
    Csv,
    /// `.vtk`: legacy PolyData.
    Vtk,
    /// `.gplt`: commands of gnuplot with the numbers.
    Gnuplot,
    /// `.agr`: Grace's commands with the numbers.
    Xmgr,
    /// `.dat`: columns below comments that name them.
    Jplot,
}

/// Formats of other programs' tables: their numbers are written as columns.
const AS_COLUMNS: &[&str] = &["ensight", "nastran"];

impl SetFormat {
    /// Reads `setFormat`.
    pub(super) fn read(r: &Reader<'_>, default: SetFormat) -> SetFormat {
        r.ignore("formatOptions");
        if let Some(word) = r.raw("setFormat").and_then(|t| t.first()?.word())
            && AS_COLUMNS.contains(&word)
        {
            let message = format!("`{word}` is served by `raw`: columns of numbers");
            r.warn_at_key("setFormat", message, "not written", None);
            return SetFormat::Raw;
        }
        let known = [
            ("raw", SetFormat::Raw),
            ("csv", SetFormat::Csv),
            ("vtk", SetFormat::Vtk),
            ("gnuplot", SetFormat::Gnuplot),
            ("xmgr", SetFormat::Xmgr),
            ("jplot", SetFormat::Jplot),
        ];
        r.opt_one_of("setFormat", &known, default)
    }

    fn extension(self) -> &'static str {
        match self {
            SetFormat::Raw => "xy",
            SetFormat::Csv => "csv",
            SetFormat::Vtk => "vtk",
            SetFormat::Gnuplot => "gplt",
            SetFormat::Xmgr => "agr",
            SetFormat::Jplot => "dat",
        }
    }
}

/// A point with its place along the line and the values of all fields there.
pub(super) struct Row {
    pub(super) at: Vec3,
    pub(super) values: Vec<Components>,
}

/// A line of points.
pub(super) struct Set<'a> {
    /// Its name.
    pub(super) name: &'a str,
    /// The axis' word.
    pub(super) axis: &'static str,
    /// Heads of the axis' columns.
    pub(super) heads: &'a [&'static str],
    /// The points, in order.
    pub(super) rows: &'a [Row],
    /// The axis' columns, for each point.
    pub(super) along: &'a [Vec<f64>],
    /// The fields, in the order of the values.
    pub(super) fields: &'a [Named],
}

/// The files of a set, one a group of fields of the same rank as OpenFOAM writes them. Where there are
/// several groups, one table with all of them besides: figures take curves from one file.
pub(super) fn files(format: SetFormat, set: &Set<'_>) -> Vec<Written> {
    let mut out = Vec::new();
    let mut ranks: Vec<Rank> = set.fields.iter().map(|f| f.quantity.rank()).collect();
    ranks.sort();
    ranks.dedup();
    for rank in &ranks {
        let mut group: Vec<usize> =
            (0..set.fields.len()).filter(|i| set.fields[*i].quantity.rank() == *rank).collect();
        group.sort_by_key(|i| &set.fields[*i].name);
        out.push(one(format, set, &group));
    }
    if ranks.len() > 1 && matches!(format, SetFormat::Raw | SetFormat::Csv) {
        let all: Vec<usize> = (0..set.fields.len()).collect();
        out.push(Written::File {
            file: file_name(format, set, &all),
            bytes: table(format, set, &all, false).into_bytes(),
        });
    }
    out
}

fn file_name(format: SetFormat, set: &Set<'_>, group: &[usize]) -> String {
    let names: Vec<&str> = group.iter().map(|i| set.fields[*i].name.as_str()).collect();
    format!("{}_{}.{}", set.name, names.join("_"), format.extension())
}

/// The file of one group of fields.
fn one(format: SetFormat, set: &Set<'_>, group: &[usize]) -> Written {
    let text = match format {
        SetFormat::Raw | SetFormat::Csv => table(format, set, group, true),
        SetFormat::Gnuplot => gnuplot(set, group),
        SetFormat::Xmgr => xmgr(set, group),
        SetFormat::Jplot => jplot(set, group),
        SetFormat::Vtk => {
            let line: Vec<usize> = (0..set.rows.len()).collect();
            vtk(set.name, set.rows, set.fields, group, &[line])
        }
    };
    Written::File { file: file_name(format, set, group), bytes: text.into_bytes() }
}

/// Columns; `numbered` names components as OpenFOAM's csv does, `U_0 U_1 U_2`.
fn table(format: SetFormat, set: &Set<'_>, group: &[usize], numbered: bool) -> String {
    let csv = format == SetFormat::Csv;
    let (separator, start) = if csv { (",", "") } else { ("\t", "# ") };
    let mut heads: Vec<String> = set.heads.iter().map(|h| (*h).to_owned()).collect();
    for f in group.iter().map(|i| &set.fields[*i]) {
        match f.quantity.n() {
            n if n > 1 && csv && numbered => {
                heads.extend((0..n).map(|k| format!("{}_{k}", f.name)));
            }
            _ => heads.extend(f.columns()),
        }
    }
    format!("{start}{}\n{}", heads.join(separator), numbers(set, group, separator))
}

fn numbers(set: &Set<'_>, group: &[usize], separator: &str) -> String {
    let mut text = String::new();
    for (row, along) in set.rows.iter().zip(set.along) {
        let values = group.iter().flat_map(|i| &row.values[*i][..set.fields[*i].quantity.n()]);
        let cells: Vec<String> = along.iter().chain(values).map(|x| number(*x)).collect();
        text.push_str(&cells.join(separator));
        text.push('\n');
    }
    text
}

fn gnuplot(set: &Set<'_>, group: &[usize]) -> String {
    let name = |i: &usize| set.fields[*i].name.as_str();
    // As OpenFOAM has it: a second axis for whatever follows the first field.
    let mut text = format!("set term postscript color\nset output \"{}.ps\"\n", set.name);
    let mut axes = ["", ""];
    if let [first, second, ..] = group {
        text += &format!("set ylabel \"{}\"\nset y2label \"{}\"\n", name(first), name(second));
        text += "set ytics nomirror\nset y2tics\n";
        axes = [" axes x1y1", " axes x1y2"];
    }
    let plot = |(k, i): (usize, &usize)| {
        format!("\"-\" title \"{}\" with lines{}", name(i), axes[k.min(1)])
    };
    let plots: Vec<String> = group.iter().enumerate().map(plot).collect();
    text += &format!("plot {}\n", plots.join(", "));
    // A block of numbers for each `-`.
    for i in group {
        text += &numbers(set, &[*i], "\t");
        text += "e\n";
    }
    text
}

fn xmgr(set: &Set<'_>, group: &[usize]) -> String {
    let mut text = format!(
        "@g0 on\n@with g0\n@    title \"{}\"\n@    xaxis label \"{}\"\n",
        set.name, set.axis
    );
    for (k, i) in group.iter().enumerate() {
        let name = &set.fields[*i].name;
        text += &format!("@    s{k} legend \"{name}\"\n@target G0.S{k}\n");
        text += &numbers(set, &[*i], "\t");
        text += "&\n";
    }
    text
}

fn jplot(set: &Set<'_>, group: &[usize]) -> String {
    let mut text = format!("# JPlot file\n# column 1: {}\n", set.name);
    for (k, i) in group.iter().enumerate() {
        text += &format!("# column {}: {}\n", k + 2, set.fields[*i].name);
    }
    text + &numbers(set, group, "\t")
}

/// Legacy PolyData of the fields in `group` at points, joined by lines where there are several.
pub(super) fn vtk(
    name: &str,
    rows: &[Row],
    fields: &[Named],
    group: &[usize],
    lines: &[Vec<usize>],
) -> String {
    let mut text = format!(
        "# vtk DataFile Version 2.0\n{name}\nASCII\nDATASET POLYDATA\nPOINTS {} double\n",
        rows.len()
    );
    let join = |x: &mut dyn Iterator<Item = f64>| x.map(number).collect::<Vec<_>>().join(" ");
    for row in rows {
        text += &join(&mut row.at.iter().copied());
        text.push('\n');
    }
    if lines.iter().any(|l| l.len() > 1) {
        let size: usize = lines.iter().map(|l| l.len() + 1).sum();
        text += &format!("LINES {} {size}\n", lines.len());
        for line in lines {
            let points: Vec<String> = line.iter().map(usize::to_string).collect();
            text += &format!("{} {}\n", line.len(), points.join(" "));
        }
    }
    text += &format!("POINT_DATA {}\nFIELD attributes {}\n", rows.len(), group.len());
    for i in group {
        let n = fields[*i].quantity.n();
        text += &format!("{} {n} {} double\n", fields[*i].name, rows.len());
        for row in rows {
            text += &join(&mut row.values[*i][..n].iter().copied());
            text.push('\n');
        }
    }
    text
}
