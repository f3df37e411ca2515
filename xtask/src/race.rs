//! Two fluids through this program and the reference tool on the same mesh, with the tutorial's own schemes,
//! tolerances and control of the time step: seconds, steps and memory, on one core and on two.

use crate::compare::{Start, TUTORIALS, Tutorial};
use crate::{bench, run};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

struct Race {
    what: What,
    end: f64,
    /// Cells of the mesh, per direction that has more than one, are this many times as many.
    refined: usize,
}

enum What {
    /// A tutorial of the reference tool, by the end of its path.
    Tutorial(&'static str),
    /// A case of ours, the reference tool on our mesh and first fields; both read the schemes and
    /// solvers of `bench_cases/twoFluids`.
    Ours(&'static str),
}
use What::{Ours, Tutorial as Theirs};

const fn race(what: What, end: f64, refined: usize) -> Race {
    Race { what, end, refined }
}

const RACES: &[Race] = &[
    race(Theirs("interFoam/laminar/damBreak/damBreak"), 0.2, 1),
    race(Theirs("interFoam/laminar/damBreak/damBreak"), 0.1, 2),
    race(Theirs("interFoam/laminar/damBreak/damBreak"), 0.05, 4),
    race(Theirs("interIsoFoam/damBreak"), 0.05, 1),
    race(Theirs("interFoam/laminar/damBreakWithObstacle"), 0.1, 1),
    race(Theirs("interFoam/laminar/capillaryRise"), 0.02, 1),
    race(Theirs("interFoam/laminar/waves/stokesI"), 0.5, 1),
    race(Theirs("interIsoFoam/discInConstantFlow"), 1.0, 1),
    race(Theirs("interIsoFoam/notchedDiscInSolidBodyRotation"), 0.1, 1),
    race(Theirs("interIsoFoam/discInReversedVortexFlow"), 0.5, 1),
    race(Theirs("interIsoFoam/sphereInReversedVortexFlow"), 0.5, 1),
    race(Ours("rising_bubble"), 0.3, 1),
    race(Ours("capillary_rise"), 0.02, 1),
    race(Ours("standing_wave"), 0.3, 1),
];

/// Prints the table, of all races or of those whose names contain one of `cases`.
pub(crate) fn two_phases(
    granflow: &Path,
    repeat: usize,
    cores: usize,
    cases: &[&str],
) -> Result<(), String> {
    let is = |race: &Race, case: &str| race.name().contains(case);
    if let Some(stranger) = cases.iter().find(|case| !RACES.iter().any(|race| is(race, case))) {
        return Err(format!("no case is called `{stranger}`"));
    }
    let wanted = |race: &&Race| cases.is_empty() || cases.iter().any(|case| is(race, case));
    let granflow = granflow.canonicalize().map_err(|e| format!("{}: {e}", granflow.display()))?;
    println!(
        "\ntwo fluids beside the reference tool (its solver alone; ours with mesh and first fields)"
    );
    println!(
        "| case | cells | cores | granflow s (steps, MB) | peer s (steps, MB) | peer/granflow |"
    );
    println!("|---|---|---|---|---|---|");
    let mut missing = Vec::new();
    for race in RACES.iter().filter(wanted) {
        if let Err(why) = race.run(&granflow, repeat, cores) {
            missing.push(format!("{}: {why}", race.name()));
        }
    }
    if missing.is_empty() { Ok(()) } else { Err(missing.join("; ")) }
}

impl Race {
    fn run(&self, granflow: &Path, repeat: usize, cores: usize) -> Result<(), String> {
        let tutorial = self.tutorial()?;
        let solver = tutorial.solver();
        for threads in if cores > 1 { vec![1, 2] } else { vec![1] } {
            let (mut mine, mut other) = (Vec::new(), Vec::new());
            for _ in 0..repeat {
                let (ours, theirs) = self.prepared(&tutorial, granflow, threads)?;
                let parallel = ["mpirun", "--allow-run-as-root", "-np", "2", solver, "-parallel"];
                let words = if threads == 1 { &[solver][..] } else { &parallel };
                other.push(watched(words, None, &theirs, solver)?);
                let threads = threads.to_string();
                let words = ["granflow", "run", ".", "-j", &threads];
                mine.push(watched(&words, Some(granflow), &ours, "granflow")?);
            }
            let [mine, other] = [mine, other].map(|mut runs| {
                runs.sort_by(|a: &Run, b| a.seconds.total_cmp(&b.seconds));
                runs.swap_remove(runs.len() / 2)
            });
            let cells = cells_of(&bench::scratch_place("race-theirs"));
            println!(
                "| {} | {cells} | {threads} | {mine} | {other} | {:.2} |",
                self.name(),
                other.seconds / mine.seconds
            );
        }
        Ok(())
    }

    fn name(&self) -> String {
        match self.what {
            Theirs(path) => path.to_owned(),
            Ours(name) => format!("our `{name}`"),
        }
    }

    /// What both run, and when it ends.
    fn tutorial(&self) -> Result<Tutorial, String> {
        let (end, interval) = (self.end, self.end);
        match self.what {
            Theirs(path) => {
                let known = TUTORIALS.iter().find(|t| t.path == path);
                let known = known.ok_or_else(|| format!("no tutorial `{path}`"))?;
                Ok(Tutorial { end, interval, ..*known })
            }
            Ours(_) => Ok(Tutorial {
                path: "interIsoFoam/ours",
                prepare: &[],
                start: Start::Own,
                changes: &[],
                end,
                interval,
                axis: 0,
                label: "",
            }),
        }
    }

    /// The mesh of the case is refined where it makes its own.
    fn refine(&self, case: &Path) -> Result<(), String> {
        if self.refined == 1 {
            return Ok(());
        }
        let file = ["system/blockMeshDict", "constant/polyMesh/blockMeshDict"]
            .map(|f| case.join(f))
            .into_iter()
            .find(|f| f.is_file())
            .ok_or("no blockMeshDict")?;
        let text = fs::read_to_string(&file).map_err(|e| e.to_string())?;
        fs::write(&file, refined(&text, self.refined)).map_err(|e| e.to_string())
    }

    /// Our case and the peer's, each ready for its solver.
    fn prepared(
        &self,
        tutorial: &Tutorial,
        granflow: &Path,
        ranks: usize,
    ) -> Result<(PathBuf, PathBuf), String> {
        let from = match self.what {
            Theirs(path) => {
                Path::new("/usr/share/doc/openfoam-examples/examples/multiphase").join(path)
            }
            Ours(name) => run::root().join("cases").join(name),
        };
        if !from.is_dir() {
            return Err(format!("{} is not there", from.display()));
        }
        let ours = bench::copy_case(&from, "race-ours")?;
        let theirs = bench::copy_case(&from, "race-theirs")?;
        for case in [&ours, &theirs] {
            tutorial.edit(case)?;
            self.refine(case)?;
            if let Ours(_) = self.what {
                let files = run::root().join("xtask/bench_cases/twoFluids");
                run::copy_dir(&files, case).map_err(|e| e.to_string())?;
                without_functions(&case.join("system/controlDict"))?;
            }
        }
        if let Ours(_) = self.what {
            for what in ["mesh", "init"] {
                watched(&["granflow", what, "."], Some(granflow), &theirs, "")?;
            }
        }
        for line in tutorial.prepare {
            let words: Vec<&str> = line.split(' ').collect();
            watched(&words, None, &theirs, "")?;
        }
        tutorial.hand_over(&theirs, &ours)?;
        if ranks > 1 {
            let text = "FoamFile { version 2.0; format ascii; class dictionary; object decomposeParDict; }\n\
                        numberOfSubdomains 2; method simple; simpleCoeffs { n (2 1 1); delta 0.001; }\n";
            fs::write(theirs.join("system/decomposeParDict"), text).map_err(|e| e.to_string())?;
            watched(&["decomposePar", "-force"], None, &theirs, "")?;
        }
        Ok((ours, theirs))
    }
}

/// Leaves out functions of ours, which the peer does not have and which take time, and gives what it asks for.
fn without_functions(control: &Path) -> Result<(), String> {
    let text = fs::read_to_string(control).map_err(|e| e.to_string())?;
    let end = text.find("\nfunctions").map_or(text.len(), |at| at + 1);
    let mut text = format!("{}startTime 0;\n", &text[..end]);
    if !text.contains("maxAlphaCo") {
        // v1912 reads it with fixed steps as well.
        text += "maxAlphaCo 1;\n";
    }
    fs::write(control, text).map_err(|e| e.to_string())
}

/// The numbers of cells of every block times `n`, where there is more than one.
fn refined(text: &str, n: usize) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("hex") {
        let Some(open) = rest[at..].match_indices('(').nth(1).map(|(i, _)| at + i + 1) else {
            break;
        };
        let Some(close) = rest[open..].find(')').map(|i| open + i) else { break };
        let numbers = rest[open..close].split_whitespace().map(|w| match w.parse::<usize>() {
            Ok(k) if k > 1 => (k * n).to_string(),
            _ => w.to_owned(),
        });
        out += &rest[..open];
        out += &numbers.collect::<Vec<_>>().join(" ");
        rest = &rest[close..];
    }
    out + rest
}

/// What a run took.
struct Run {
    seconds: f64,
    steps: usize,
    megabytes: f64,
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2} ({}, {:.0})", self.seconds, self.steps, self.megabytes)
    }
}

/// Runs a command in `case` and watches the memory of the processes called `name`.
fn watched(words: &[&str], program: Option<&Path>, case: &Path, name: &str) -> Result<Run, String> {
    let mut command = run::logged_command(words, program, case, "log.race")?;
    let begun = Instant::now();
    let mut child =
        command.stdin(Stdio::null()).spawn().map_err(|e| format!("`{}`: {e}", words.join(" ")))?;
    let mut peaks = BTreeMap::new();
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            break status;
        }
        if !name.is_empty() {
            note_peaks(name, &mut peaks);
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let seconds = begun.elapsed().as_secs_f64();
    let log = fs::read_to_string(case.join("log.race")).unwrap_or_default();
    if !status.success() {
        let last: Vec<&str> = log.lines().rev().take(3).collect();
        return Err(format!("`{}`: {status}: {}", words.join(" "), last.join(" | ")));
    }
    let steps = match name {
        "granflow" => bench::steps_below(case).steps,
        _ => log.lines().filter(|l| l.starts_with("Time = ")).count(),
    };
    Ok(Run { seconds, steps, megabytes: peaks.values().sum::<f64>() / 1024.0 })
}

/// The greatest resident memory, kB, of every process of that name.
fn note_peaks(name: &str, peaks: &mut BTreeMap<String, f64>) {
    for entry in fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(status) = fs::read_to_string(entry.path().join("status")) else { continue };
        let value = |key: &str| status.lines().find_map(|l| l.strip_prefix(key)).map(str::trim);
        if value("Name:") != Some(name) {
            continue;
        }
        let peak = value("VmHWM:").and_then(|v| v.split(' ').next()).and_then(|v| v.parse().ok());
        if let Some(peak) = peak {
            peaks.insert(entry.file_name().to_string_lossy().into_owned(), peak);
        }
    }
}

/// Cells that blockMesh counted.
fn cells_of(case: &Path) -> String {
    let owner = fs::read_to_string(case.join("constant/polyMesh/owner")).unwrap_or_default();
    let cells = owner.split("nCells:").nth(1).and_then(|t| t.split_whitespace().next());
    cells.unwrap_or("?").trim_end_matches('"').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_more_cells_but_where_there_is_one() {
        let text =
            "blocks ( hex (0 1 2 3 4 5 6 7) (23 8 1) simpleGrading (1 1 1)\n hex (1 2) (4 1 1) );";
        let fine =
            "blocks ( hex (0 1 2 3 4 5 6 7) (46 16 1) simpleGrading (1 1 1)\n hex (1 2) (8 1 1) );";
        assert_eq!(refined(text, 2), fine);
    }
}
