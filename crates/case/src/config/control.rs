//! `system/controlDict`: how long, how often, in what form.

use crate::store::{Compression, TimeFormat, TimeName};
use granflow_base::Dims;
use granflow_dict::{Format, Reader, Span};

/// Values of `application` that are accepted, and what each means here.
pub const APPLICATIONS: &[(&str, &str)] = &[
    ("granflow", "this program"),
    ("icoFoam", "laminar Newtonian flow, PISO"),
    ("pisoFoam", "laminar flow, PISO"),
    ("pimpleFoam", "laminar flow, outer iterations"),
    ("nonNewtonianIcoFoam", "generalised Newtonian flow, PISO"),
    ("interFoam", "two phases, the interface by flux-corrected transport with compression"),
    ("interIsoFoam", "two phases, the interface by isoAdvector"),
];

/// `startFrom`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartFrom {
    /// The time directory nearest to `startTime`.
    Time(f64),
    /// The earliest time directory.
    First,
    /// The latest time directory.
    Latest,
}

/// `writeControl` with `writeInterval`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WriteControl {
    /// Every that many steps, counted from time zero.
    Steps(usize),
    /// At the first step at or behind every multiple of so many seconds.
    Time(f64),
    /// At every multiple of so many seconds exactly: steps are fitted to it.
    Adjustable(f64),
    /// Never by itself.
    Never,
}

/// `adjustTimeStep yes`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adjust {
    /// Greatest Courant number, `maxCo`.
    pub max_co: f64,
    /// Greatest Courant number where there is an interface, `maxAlphaCo`.
    pub max_alpha_co: f64,
    /// Longest step, `maxDeltaT`, s.
    pub max_dt: f64,
}

/// What `controlDict` says.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// `application`; `granflow` where it is missing.
    pub application: String,
    /// `startFrom`; default the latest time.
    pub start: StartFrom,
    /// Where the start is said, for messages.
    pub start_span: Span,
    /// `endTime`, s.
    pub end: f64,
    /// Where the end is said, for messages.
    pub end_span: Span,
    /// `deltaT`, s.
    pub dt: f64,
    /// `writeControl`, `writeInterval`; default: at the end only.
    pub write: WriteControl,
    /// `purgeWrite`: how many written times stay; 0 all.
    pub purge: usize,
    /// `writeFormat`; default ascii.
    pub format: Format,
    /// `writeCompression`; default off.
    pub compression: Compression,
    /// `timeFormat`, `timePrecision`.
    pub time_name: TimeName,
    /// `adjustTimeStep`, `maxCo` (default 1), `maxDeltaT` (default: no limit).
    pub adjust: Option<Adjust>,
}

impl Control {
    /// Reads everything but `functions`. `absent`: the file is missing, which was reported.
    pub(super) fn read(r: &Reader<'_>, absent: bool) -> Control {
        let application = application(r);
        if absent {
            return Control { application, ..Control::idle() };
        }
        let start = match r.opt_one_of(
            "startFrom",
            &[("startTime", 0), ("firstTime", 1), ("latestTime", 2)],
            2,
        ) {
            0 => StartFrom::Time(r.scalar("startTime", Dims::TIME)),
            1 => StartFrom::First,
            _ => StartFrom::Latest,
        };
        let start_key = match start {
            StartFrom::Time(_) => "startTime",
            _ => "startFrom",
        };
        r.ignore("startTime");
        stop_at(r);
        let end = r.scalar("endTime", Dims::TIME);
        let dt = r.positive("deltaT", Dims::TIME);
        let precision = r.opt_label_in("timePrecision", 1..=17, 6);
        let format = r.opt_one_of(
            "timeFormat",
            &[
                ("general", TimeFormat::General),
                ("fixed", TimeFormat::Fixed),
                ("scientific", TimeFormat::Scientific),
            ],
            TimeFormat::General,
        );
        // Shortest text that reads back to the same bits is written: never fewer digits than this.
        r.opt_label("writePrecision", 6);
        for harmless in HARMLESS {
            r.ignore(harmless);
        }
        let compression = r.opt_one_of(
            "writeCompression",
            &[
                ("off", Compression::Plain),
                ("uncompressed", Compression::Plain),
                ("no", Compression::Plain),
                ("false", Compression::Plain),
                ("on", Compression::Gzip),
                ("compressed", Compression::Gzip),
                ("yes", Compression::Gzip),
                ("true", Compression::Gzip),
            ],
            Compression::Plain,
        );
        Control {
            application,
            start,
            start_span: r.value_span(start_key),
            end,
            end_span: r.value_span("endTime"),
            dt,
            write: write_control(r),
            purge: r.opt_label_in("purgeWrite", 0..=i64::MAX, 0) as usize,
            format: r.opt_one_of(
                "writeFormat",
                &[("ascii", Format::Ascii), ("binary", Format::Binary)],
                Format::Ascii,
            ),
            compression,
            time_name: TimeName { format, precision: precision as usize },
            adjust: adjust(r),
        }
    }

    fn idle() -> Control {
        Control {
            application: "granflow".into(),
            start: StartFrom::Latest,
            start_span: Span::none(),
            end: 0.0,
            end_span: Span::none(),
            dt: 1.0,
            write: WriteControl::Never,
            purge: 0,
            format: Format::Ascii,
            compression: Compression::Plain,
            time_name: TimeName::default(),
            adjust: None,
        }
    }
}

/// Entries of other programs that change nothing here.
const HARMLESS: &[&str] = &[
    "runTimeModifiable",
    "graphFormat",
    "libs",
    "OptimisationSwitches",
    "DebugSwitches",
    "InfoSwitches",
    "writeVersion",
    "cycleWrite",
    "secondaryWriteControl",
    "secondaryWriteInterval",
    "functionObjects",
];

fn application(r: &Reader<'_>) -> String {
    let known: Vec<(&str, &str)> = APPLICATIONS.iter().map(|a| (a.0, a.0)).collect();
    let name = r.opt_one_of("application", &known, "granflow");
    name.to_owned()
}

fn stop_at(r: &Reader<'_>) {
    let word = r.opt_word("stopAt", "endTime");
    if matches!(word, "noWriteNow" | "writeNow" | "nextWrite") {
        let help = "send the run a signal (Ctrl-C, kill): it writes and stops";
        let message = format!("`stopAt {word}` is not supported");
        r.error_at_key("stopAt", message, "write `endTime`", Some(help));
    } else {
        r.opt_one_of("stopAt", &[("endTime", ())], ());
    }
}

fn write_control(r: &Reader<'_>) -> WriteControl {
    #[derive(Clone, Copy, PartialEq)]
    enum How {
        Steps,
        Time,
        Adjustable,
        Never,
    }
    let kinds = [
        ("timeStep", How::Steps),
        ("runTime", How::Time),
        ("adjustableRunTime", How::Adjustable),
        ("adjustable", How::Adjustable),
        ("none", How::Never),
    ];
    if !r.has("writeControl") && !r.has("writeInterval") {
        return WriteControl::Never;
    }
    let how = r.opt_one_of("writeControl", &kinds, How::Steps);
    match how {
        How::Never => {
            r.ignore("writeInterval");
            WriteControl::Never
        }
        How::Steps => {
            let n = r.positive("writeInterval", Dims::NONE);
            if n.fract() != 0.0 {
                let help = "write a whole number of steps, or `writeControl runTime;` for seconds";
                r.error_at_key(
                    "writeInterval",
                    format!("an interval of {n} steps is not a whole number"),
                    "counts time steps",
                    Some(help),
                );
            }
            WriteControl::Steps((n.round() as usize).max(1))
        }
        How::Time => WriteControl::Time(r.positive("writeInterval", Dims::TIME)),
        How::Adjustable => WriteControl::Adjustable(r.positive("writeInterval", Dims::TIME)),
    }
}

fn adjust(r: &Reader<'_>) -> Option<Adjust> {
    let on = r.opt_switch("adjustTimeStep", false);
    let max_co = r.opt_positive("maxCo", Dims::NONE, 1.0);
    let max_dt = r.opt_positive("maxDeltaT", Dims::TIME, f64::INFINITY);
    let max_alpha_co = r.opt_positive("maxAlphaCo", Dims::NONE, max_co);
    on.then_some(Adjust { max_co, max_alpha_co, max_dt })
}
