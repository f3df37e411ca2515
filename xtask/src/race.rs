//! Two fluids through this program and the reference tool on the same mesh, with the tutorial's own schemes,
//! tolerances and control of the time step: seconds, steps and memory, on one core and on two.

use crate::compare::{Start, Tutorial};
use crate::{bench, run};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

struct Race {
    of: Tutorial,
    /// Cells of the tutorial's mesh, per direction that has more than one, are this many times as many.
    refined: usize,
}

const fn race(path: &'static str, prepare: &'static [&'static str], end: f64, n: usize) -> Race {
    let of =
        Tutorial { path, prepare, start: Start::Own, changes: &[], end, interval: end, axis: 0 };
    Race { of, refined: n }
}

const FLUX_CORRECTED: &str = "interFoam/laminar/damBreak/damBreak";
const GEOMETRIC: &str = "interIsoFoam/damBreak";
const FILLED: &[&str] = &["blockMesh", "setFields"];
const COPIED: &[&str] = &["cp -r 0.orig 0", "blockMesh", "setFields"];
const RACES: &[Race] = &[
    race(FLUX_CORRECTED, FILLED, 0.2, 1),
    race(FLUX_CORRECTED, FILLED, 0.1, 2),
    race(FLUX_CORRECTED, FILLED, 0.05, 4),
    race(GEOMETRIC, COPIED, 0.05, 1),
];

/// Prints the table.
pub(crate) fn two_phases(granflow: &Path, repeat: usize, cores: usize) -> Result<(), String> {
    let granflow = granflow.canonicalize().map_err(|e| format!("{}: {e}", granflow.display()))?;
    println!(
        "\ntwo fluids beside the reference tool (its solver alone; ours with mesh and first fields)"
    );
    println!(
        "| case | cells | cores | granflow s (steps, MB) | peer s (steps, MB) | peer/granflow |"
    );
    println!("|---|---|---|---|---|---|");
    RACES.iter().try_for_each(|race| race.run(&granflow, repeat, cores))
}

impl Race {
    fn run(&self, granflow: &Path, repeat: usize, cores: usize) -> Result<(), String> {
        let from = Path::new("/usr/share/doc/openfoam-examples/examples/multiphase");
        let from = from.join(self.of.path);
        if !from.is_dir() {
            return Err(format!("{} is not there", from.display()));
        }
        let solver = self.of.solver();
        for threads in if cores > 1 { vec![1, 2] } else { vec![1] } {
            let (mut mine, mut other) = (Vec::new(), Vec::new());
            for _ in 0..repeat {
                let theirs = self.prepared(&from, threads)?;
                let parallel = ["mpirun", "--allow-run-as-root", "-np", "2", solver, "-parallel"];
                let words = if threads == 1 { &[solver][..] } else { &parallel };
                other.push(watched(words, None, &theirs, solver)?);
                let ours = bench::copy_case(&from, "race-ours")?;
                self.edit(&ours)?;
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
                self.of.path,
                other.seconds / mine.seconds
            );
        }
        Ok(())
    }

    fn edit(&self, case: &Path) -> Result<(), String> {
        self.of.edit(case)?;
        let file = ["system/blockMeshDict", "constant/polyMesh/blockMeshDict"]
            .map(|f| case.join(f))
            .into_iter()
            .find(|f| f.is_file())
            .ok_or("no blockMeshDict")?;
        let text = fs::read_to_string(&file).map_err(|e| e.to_string())?;
        fs::write(&file, refined(&text, self.refined)).map_err(|e| e.to_string())
    }

    /// The peer's case, ready for its solver.
    fn prepared(&self, from: &Path, ranks: usize) -> Result<std::path::PathBuf, String> {
        let case = bench::copy_case(from, "race-theirs")?;
        self.edit(&case)?;
        for line in self.of.prepare {
            let words: Vec<&str> = line.split(' ').collect();
            watched(&words, None, &case, "")?;
        }
        if ranks > 1 {
            let text = "FoamFile { version 2.0; format ascii; class dictionary; object decomposeParDict; }\n\
                        numberOfSubdomains 2; method simple; simpleCoeffs { n (2 1 1); delta 0.001; }\n";
            fs::write(case.join("system/decomposeParDict"), text).map_err(|e| e.to_string())?;
            watched(&["decomposePar", "-force"], None, &case, "")?;
        }
        Ok(case)
    }
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
