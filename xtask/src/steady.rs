//! The steady state found directly beside marching to it: seconds, and how far apart the two are.

use crate::{bench, run};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

struct Case {
    name: &'static str,
    what: &'static str,
    /// File, text and what takes its place, in both runs.
    edits: &'static [(&'static str, &'static str, &'static str)],
    /// Steps and ends of marching, s.
    marches: &'static [(&'static str, &'static str)],
    /// Its profile's file, and the column of velocity there.
    profile: (&'static str, usize),
}

const CASES: &[Case] = &[
    Case {
        name: "annular_shear_cell",
        what: "annular cell, 64 cells",
        edits: &[
            ("system/blockMeshDict", "(128 1 1)", "(64 1 1)"),
            ("system/controlDict", "endTime         5;", "endTime         1;"),
        ],
        marches: &[("0.1", "1"), ("0.001", "1")],
        profile: ("radius_U_fluidity_stressRatio.csv", 2),
    },
    Case {
        name: "heap_dry",
        what: "heap, 8 cells a grain",
        edits: &[("system/blockMeshDict", "(1 38 80)", "(1 76 160)")],
        marches: &[("0.05", "6")],
        profile: ("centre_U_fluidity_stressRatio.csv", 1),
    },
];

/// Prints the table.
pub(crate) fn steady(granflow: &Path) -> Result<(), String> {
    println!("\nsteady states, directly and by marching (one thread, seconds of the steps)");
    println!("| case | how | s | apart, of the greatest velocity | marching/direct |");
    println!("|---|---|---|---|---|");
    for case in CASES {
        let direct = bench::copy_case(&run::root().join("cases").join(case.name), "steady-direct")?;
        case.edit(&direct)?;
        let seconds = timed(granflow, &direct)?;
        println!("| {} | directly | {seconds:.3} | | |", case.what);
        let there = case.velocity(&direct, "1")?;
        let most = there.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
        for (dt, end) in case.marches {
            let marched =
                bench::copy_case(&run::root().join("cases").join(case.name), "steady-marched")?;
            case.edit(&marched)?;
            replace(&marched.join("system/fvSchemes"), "steadyState", "Euler")?;
            let control = marched.join("system/controlDict");
            for (key, value) in [("deltaT", dt), ("endTime", end), ("writeInterval", end)] {
                let text = fs::read_to_string(&control).map_err(|e| e.to_string())?;
                let line = text.lines().find(|l| l.starts_with(key)).ok_or(key)?.to_owned();
                replace(&control, &line, &format!("{key} {value};"))?;
            }
            replace_if(&control, "writeControl    timeStep;", "writeControl runTime;")?;
            let took = timed(granflow, &marched)?;
            let here = case.velocity(&marched, end)?;
            let apart = there.iter().zip(&here).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!(
                "| {} | steps of {dt} s to {end} s | {took:.3} | {:.1e} | {:.1} |",
                case.what,
                apart / most,
                took / seconds
            );
        }
    }
    Ok(())
}

impl Case {
    fn edit(&self, root: &Path) -> Result<(), String> {
        self.edits.iter().try_for_each(|(file, from, to)| replace(&root.join(file), from, to))
    }

    fn velocity(&self, root: &Path, time: &str) -> Result<Vec<f64>, String> {
        let path = root.join("postProcessing/profile").join(time).join(self.profile.0);
        let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let rows = text.lines().skip(1);
        Ok(rows.filter_map(|l| l.split(',').nth(self.profile.1)?.parse().ok()).collect())
    }
}

fn replace(path: &Path, from: &str, to: &str) -> Result<(), String> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    if !text.contains(from) {
        return Err(format!("{} has no `{from}`", path.display()));
    }
    fs::write(path, text.replacen(from, to, 1)).map_err(|e| e.to_string())
}

fn replace_if(path: &Path, from: &str, to: &str) -> Result<(), String> {
    replace(path, from, to).or(Ok(()))
}

/// Seconds that the steps took, output at their ends included, by the case's own log.
fn timed(granflow: &Path, case: &Path) -> Result<f64, String> {
    let mut command = Command::new(granflow);
    command.arg("run").arg(case).args(["-j", "1", "-q"]).stdin(Stdio::null());
    let status = command.status().map_err(|e| e.to_string())?;
    match status.success() {
        true => {
            let path = case.join("log.jsonl");
            let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let mut wall = text.lines().filter_map(|l| {
                let line: serde_json::Value = serde_json::from_str(l).ok()?;
                line["wall"].as_f64()
            });
            wall.next_back().ok_or_else(|| format!("{} has no steps", path.display()))
        }
        false => Err(format!("`{}`: {status}", run::shown(&command))),
    }
}
