//! The laminar tutorials of OpenFOAM through both programs, compared cell by cell: here those of two
//! phases, in `laminar` the others. Needs OpenFOAM and its examples; nothing of either is kept here.
//!
//! Both programs get the tutorial's own files. Only when to end and what to write is set, and what
//! a tutorial's `changes` say. Where a mesh or the first fields come from a utility that we have no
//! match for, ours reads the peer's.

use crate::moments::{Cells, Moment};
use crate::{bench, foam_field as field, laminar, run};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the second program starts from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Start {
    /// The tutorial's files alone.
    Own,
    /// The peer's fields of the first time, on a mesh of its own.
    Fields,
    /// The peer's mesh and fields.
    Mesh,
}

#[derive(Clone, Copy)]
pub(crate) struct Tutorial {
    /// Below `multiphase` or `incompressible` in the examples; the last part is its name.
    pub(crate) path: &'static str,
    /// The peer's utilities between copying and solving, a command line each.
    pub(crate) prepare: &'static [&'static str],
    pub(crate) start: Start,
    /// Entries that differ from the tutorial's in both runs: file, keyword, value.
    pub(crate) changes: &'static [(&'static str, &'static str, &'static str)],
    pub(crate) end: f64,
    pub(crate) interval: f64,
    /// Direction in which the front is looked for.
    pub(crate) axis: usize,
    /// What tells it from others of the same path.
    pub(crate) label: &'static str,
}

const STATIC: (&str, &str, &str) = ("constant/dynamicMeshDict", "dynamicFvMesh", "staticFvMesh");
const OBSTACLE: &[&str] = &[
    "cp -r 0.orig 0",
    "blockMesh",
    "topoSet",
    "subsetMesh -overwrite c0 -patch walls",
    "setFields",
];

const WAVES: &[&str] = &["cp -r 0.orig 0", "blockMesh", "setFields"];

/// A tutorial of waves, the first fields from `setFields` of either.
const fn waves(path: &'static str, end: f64, interval: f64) -> Tutorial {
    Tutorial {
        path,
        prepare: WAVES,
        start: Start::Own,
        changes: &[],
        end,
        interval,
        axis: 0,
        label: "",
    }
}

/// The solitary waves in three dimensions, 4 cells across in place of 28.
const NARROW: &[(&str, &str, &str)] =
    &[("system/blockMeshDict", "hex", "hex (0 1 2 3 4 5 6 7) (350 4 42) simpleGrading (1 1 1)")];

/// The waves by a stream function, 500 cells along the flume in place of 2000.
const COARSE: &[(&str, &str, &str)] =
    &[("system/blockMeshDict", "hex", "hex (0 1 2 3 4 5 6 7) (500 1 80) simpleGrading (1 1 1)")];

pub(crate) const TUTORIALS: &[Tutorial] = &[
    Tutorial {
        path: "interFoam/laminar/damBreak/damBreak",
        prepare: &["blockMesh", "setFields"],
        start: Start::Own,
        changes: &[],
        end: 0.2,
        interval: 0.05,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interFoam/laminar/damBreakWithObstacle",
        prepare: OBSTACLE,
        start: Start::Mesh,
        changes: &[STATIC],
        end: 0.3,
        interval: 0.1,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interFoam/laminar/capillaryRise",
        prepare: &["blockMesh", "cp 0/alpha.water.orig 0/alpha.water", "setFields"],
        start: Start::Fields,
        changes: &[],
        end: 0.05,
        interval: 0.01,
        axis: 1,
        label: "",
    },
    Tutorial {
        path: "interFoam/laminar/mixerVessel2D",
        prepare: &[
            "gunzip -kf system/blockMeshDict.m4.gz",
            "sh ./makeMesh",
            "cp 0/alpha.water.orig 0/alpha.water",
            "setFields",
        ],
        start: Start::Mesh,
        changes: &[],
        end: 0.5,
        interval: 0.125,
        axis: 1,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/damBreak",
        prepare: &["cp -r 0.orig 0", "blockMesh", "setFields"],
        start: Start::Own,
        changes: &[],
        end: 0.16,
        interval: 0.04,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/damBreakWithObstacle",
        prepare: OBSTACLE,
        start: Start::Mesh,
        changes: &[STATIC],
        end: 0.3,
        interval: 0.1,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/iobasin",
        prepare: &["cp -r 0.orig 0", "blockMesh", "createPatch -overwrite", "setFields"],
        start: Start::Mesh,
        changes: &[],
        end: 0.5,
        interval: 0.1,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/standingWave",
        prepare: &[
            "cp -r 0.orig 0",
            "blockMesh",
            "topoSet -dict system/topoSetDict1",
            "refineMesh -dict system/refineMeshDict1 -overwrite",
            "topoSet -dict system/topoSetDict2",
            "refineMesh -dict system/refineMeshDict2 -overwrite",
            "setAlphaField",
        ],
        start: Start::Mesh,
        changes: &[],
        end: 1.0,
        interval: 0.25,
        axis: 2,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/discInConstantFlow",
        prepare: &["cp -r 0.orig 0", "blockMesh", "setAlphaField"],
        start: Start::Fields,
        changes: &[],
        end: 4.0,
        interval: 1.0,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/discInConstantFlowCyclicBCs",
        prepare: &["cp -r 0.orig 0", "blockMesh", "setAlphaField"],
        start: Start::Fields,
        changes: &[],
        end: 5.0,
        interval: 1.0,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/notchedDiscInSolidBodyRotation",
        prepare: &[
            "cp -r 0.orig 0",
            "blockMesh",
            "interIsoFoam -postProcess -time 0",
            "setAlphaField",
            "setFields",
        ],
        start: Start::Fields,
        changes: &[],
        end: 2.0,
        interval: 0.5,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/discInReversedVortexFlow",
        prepare: &[
            "cp -r 0.orig 0",
            "blockMesh",
            "topoSet",
            "refineMesh -overwrite",
            "topoSet -dict system/topoSetDict2",
            "refineMesh -overwrite",
            "setAlphaField",
        ],
        start: Start::Mesh,
        changes: &[],
        end: 8.0,
        interval: 2.0,
        axis: 0,
        label: "",
    },
    Tutorial {
        path: "interIsoFoam/sphereInReversedVortexFlow",
        prepare: &["cp -r 0.orig 0", "blockMesh", "setAlphaField"],
        start: Start::Fields,
        changes: &[],
        end: 1.5,
        interval: 0.5,
        axis: 0,
        label: "",
    },
    waves("interFoam/laminar/waves/stokesI", 6.0, 2.0),
    waves("interFoam/laminar/waves/stokesII", 6.0, 2.0),
    waves("interFoam/laminar/waves/stokesV", 4.0, 2.0),
    waves("interFoam/laminar/waves/cnoidal", 4.0, 2.0),
    Tutorial { changes: COARSE, ..waves("interFoam/laminar/waves/streamFunction", 4.0, 2.0) },
    waves("interFoam/laminar/waves/irregularMultiDirection", 3.0, 1.5),
    waves("interFoam/laminar/waves/solitary", 1.5, 0.5),
    Tutorial { changes: NARROW, ..waves("interFoam/laminar/waves/solitaryGrimshaw", 1.0, 0.5) },
    Tutorial { changes: NARROW, ..waves("interFoam/laminar/waves/solitaryMcCowan", 1.0, 0.5) },
    Tutorial { changes: COARSE, ..waves("interIsoFoam/waveExampleStreamFunction", 4.0, 2.0) },
];

/// Ours once more: the name of the copy, and what it says of `compatible`.
const FORMS: [(&str, &str); 2] = [("own", "no"), ("alike", "yes")];

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    let (mut names, mut granflow, mut again) = (Vec::new(), None, false);
    let mut examples = PathBuf::from("/usr/share/doc/openfoam-examples/examples");
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--again" => again = true,
            "--granflow" => granflow = Some(PathBuf::from(args.next().ok_or("--granflow PATH")?)),
            "--examples" => examples = PathBuf::from(args.next().ok_or("--examples DIR")?),
            name => names.push(name),
        }
    }
    let every = || TUTORIALS.iter().chain(laminar::TUTORIALS);
    let known = |n: &&str| every().any(|t| t.path.contains(*n));
    if let Some(stranger) = names.iter().find(|n| !known(n)) {
        let all: Vec<&str> = every().map(|t| t.path).collect();
        return Err(format!("no tutorial `{stranger}`; there are\n  {}", all.join("\n  ")));
    }
    let granflow = match (again, granflow) {
        (true, _) => PathBuf::new(),
        (false, Some(path)) => {
            path.canonicalize().map_err(|e| format!("{}: {e}", path.display()))?
        }
        (false, None) => run::build_granflow("release")?,
    };
    let asked = |t: &&Tutorial| names.is_empty() || names.iter().any(|n| t.path.contains(*n));
    let mut complete = true;
    if laminar::TUTORIALS.iter().any(|t| asked(&t)) {
        complete = laminar::compare(&examples, &granflow, again, asked);
    }
    if !TUTORIALS.iter().any(|t| asked(&t)) {
        return Ok(complete);
    }
    println!(
        "| tutorial | t, s | L1 of alpha | with `compatible no` | with `yes` | volume | front | centroid | p at walls | p_rgh | surface, of what it moved |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for t in TUTORIALS.iter().filter(asked) {
        let from = examples.join("multiphase").join(t.path);
        let ran = if again { Ok(()) } else { t.run(&from, &granflow) };
        if !again && ran.is_ok() {
            for (who, answer) in FORMS {
                if let Err(why) = laminar::run_with(t, (who, answer), &from, &granflow) {
                    eprintln!("{}: not run with `compatible {answer}`: {why}", t.path);
                }
            }
        }
        if let Err(why) = ran.and_then(|()| t.compare()) {
            println!("| {} | not compared: {why} |", t.path);
            complete = false;
        }
    }
    Ok(complete)
}

/// Runs a program in `dir`, its words to `log` there, and returns its seconds.
pub(crate) fn logged(
    words: &[&str],
    program: Option<&Path>,
    dir: &Path,
    log: &str,
) -> Result<f64, String> {
    let mut command = run::logged_command(words, program, dir, log)?;
    let begun = Instant::now();
    let status = command.status().map_err(|e| format!("`{}`: {e}", words.join(" ")))?;
    match status.success() {
        true => Ok(begun.elapsed().as_secs_f64()),
        false => Err(format!("`{}`: {status}, see {}", words.join(" "), dir.join(log).display())),
    }
}

/// Runs the peer. v1912 reads memory that it has not set when it makes a solitary wave, and crashes or
/// not by what it finds there; the length of its environment makes the difference.
fn logged_until_it_runs(solver: &str, dir: &Path) -> Result<f64, String> {
    const TRIES: usize = 16;
    let mut last = String::new();
    for i in 0..TRIES {
        let mut command = run::logged_command(&[solver], None, dir, "log.solver")?;
        command.env("PADDING", "x".repeat(37 * i));
        let begun = Instant::now();
        let status = command.status().map_err(|e| format!("`{solver}`: {e}"))?;
        if status.success() {
            return Ok(begun.elapsed().as_secs_f64());
        }
        last = format!("`{solver}`: {status}, see {}", dir.join("log.solver").display());
        if status.code().is_some() {
            break;
        }
    }
    Err(last)
}

impl Tutorial {
    pub(crate) fn name(&self) -> String {
        format!("{}{}", self.path.replace('/', "_"), self.label.replace([' ', ',', '='], "_"))
    }

    /// The peer's program for it: the folder of its tutorials.
    pub(crate) fn solver(&self) -> &'static str {
        self.path.split('/').find(|part| part.ends_with("Foam")).unwrap_or("interFoam")
    }

    /// Both programs on copies of the tutorial.
    pub(crate) fn run(&self, from: &Path, granflow: &Path) -> Result<(), String> {
        if !from.is_dir() {
            return Err(format!("{} is not there", from.display()));
        }
        let theirs = bench::copy_case(from, &format!("{}-theirs", self.name()))?;
        let ours = bench::copy_case(from, &format!("{}-ours", self.name()))?;
        for case in [&theirs, &ours] {
            self.make_ready(case)?;
        }
        for (i, line) in self.prepare.iter().enumerate() {
            let words: Vec<&str> = line.split(' ').collect();
            logged(&words, None, &theirs, &format!("log.prepare{i}"))?;
        }
        self.hand_over(&theirs, &ours)?;
        let solver = self.solver();
        let their_time = logged_until_it_runs(solver, &theirs)?;
        for what in ["writeCellVolumes", "writeCellCentres"] {
            logged(&["postProcess", "-func", what, "-time", "0"], None, &theirs, "log.geometry")?;
        }
        let our_time =
            logged(&["granflow", "run", ".", "-j", "1"], Some(granflow), &ours, "log.run")?;
        eprintln!("{}: granflow {our_time:.1} s, {solver} {their_time:.1} s", self.path);
        Ok(())
    }

    /// A row for each time that both programs wrote.
    fn compare(&self) -> Result<(), String> {
        let name = self.name();
        let place = |who: &str| bench::scratch_place(&format!("{name}-{who}"));
        let (ours, theirs) = (place("ours"), place("theirs"));
        let mesh = Cells::read(&theirs)?;
        let first = field::scalars(&theirs.join("0/alpha.water"), mesh.volume.len())?;
        for k in 1..=(self.end / self.interval).round() as usize {
            let t = k as f64 * self.interval;
            let read = |case: &Path| Moment::read(case, t, mesh.volume.len());
            let (a, b) = (read(&ours)?, read(&theirs)?);
            // Not every tutorial goes with every answer.
            let others = FORMS.map(|(who, _)| read(&place(who)).ok());
            let row = mesh.row(&a, &b, &others, self.axis);
            let moved = match self.path.contains("wave") {
                true => format!("{:.1} %", 100.0 * mesh.surfaces(&a.alpha, &b.alpha, &first)),
                false => "-".into(),
            };
            println!("| {} | {t:.4} | {row} | {moved} |", self.path);
        }
        Ok(())
    }

    /// What every copy of the tutorial has done to it.
    pub(crate) fn make_ready(&self, case: &Path) -> Result<(), String> {
        self.fill_templates(case)?;
        self.edit(case)
    }

    /// Files that a tutorial's script makes of its templates.
    fn fill_templates(&self, case: &Path) -> Result<(), String> {
        for dir in ["constant", "system"] {
            let found = fs::read_dir(case.join(dir)).map_err(|e| format!("{dir}: {e}"))?;
            for path in found.flatten().map(|f| f.path()) {
                if path.extension().is_some_and(|e| e == "template") {
                    let text = fs::read_to_string(&path).map_err(|e| e.to_string())?;
                    let text = text
                        .replace("LAMINAR_MODEL", "Stokes")
                        .replace("END_TIME", &self.end.to_string());
                    fs::write(path.with_extension(""), text).map_err(|e| e.to_string())?;
                }
            }
        }
        Ok(())
    }

    /// What both copies have in common beyond the tutorial.
    pub(crate) fn edit(&self, case: &Path) -> Result<(), String> {
        let (end, interval) = (self.end.to_string(), self.interval.to_string());
        let control = [
            ("startFrom", "startTime"),
            ("startTime", "0"),
            ("endTime", end.as_str()),
            ("writeControl", "adjustableRunTime"),
            ("writeInterval", interval.as_str()),
            ("writeFormat", "ascii"),
            ("writePrecision", "12"),
            ("purgeWrite", "0"),
        ];
        let rewrite = |file: &str, change: &dyn Fn(&str) -> Option<String>| {
            let path = case.join(file);
            let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let lines = text.lines().map(|l| change(l).unwrap_or_else(|| l.to_owned()));
            let lines: Vec<String> = lines.collect();
            fs::write(&path, lines.join("\n") + "\n").map_err(|e| format!("{file}: {e}"))
        };
        // Entries at the top level begin a line.
        rewrite("system/controlDict", &|line| {
            let word = line.split_whitespace().next()?;
            let set = control.iter().find(|c| c.0 == word && line.starts_with(word))?;
            Some(format!("{} {};", set.0, set.1))
        })?;
        for (file, key, value) in self.changes {
            rewrite(file, &|line| {
                let at = line.trim_start().starts_with(key);
                let key = if value.contains(' ') { "" } else { *key };
                // A block is no entry.
                let end = if key.is_empty() && value.starts_with("hex") { "" } else { ";" };
                at.then(|| format!("{key} {value}{end}"))
            })?;
        }
        Ok(())
    }

    /// Gives ours what it starts from.
    pub(crate) fn hand_over(&self, theirs: &Path, ours: &Path) -> Result<(), String> {
        let copy = |what: &str| {
            let to = ours.join(what);
            // The tutorial may have brought its own.
            let _ = fs::remove_dir_all(&to);
            run::copy_dir(&theirs.join(what), &to).map_err(|e| format!("{what}: {e}"))
        };
        if self.start != Start::Own {
            copy("0")?;
        }
        if self.start == Start::Mesh {
            copy("constant/polyMesh")?;
        }
        Ok(())
    }
}
