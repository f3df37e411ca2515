//! Timings: kernels, the annular cell, and one flow through this program and the reference tool.
//! Runs of different programs alternate in one session; medians are printed.

use crate::{race, run, steady};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

const PARTS: [&str; 5] = ["kernels", "annular", "cavity", "steady", "twoPhases"];

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    let (mut parts, mut cases, mut repeat, mut granflow) = (Vec::new(), Vec::new(), 3, None);
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--repeat" => {
                let n = args.next().and_then(|n| n.parse().ok()).filter(|n| *n > 0);
                repeat = n.ok_or("--repeat needs a number of runs, 1 or more")?;
            }
            "--granflow" => granflow = Some(PathBuf::from(args.next().ok_or("--granflow PATH")?)),
            "--case" => cases.push(args.next().ok_or("--case NAME, of twoPhases")?.as_str()),
            part if PARTS.contains(&part) => parts.push(part),
            other => {
                return Err(format!(
                    "`bench` knows {PARTS:?}, --repeat, --case and --granflow, found `{other}`"
                ));
            }
        }
    }
    if !cases.is_empty() && parts != ["twoPhases"] {
        return Err("--case is for `bench twoPhases`".to_owned());
    }
    let wanted = |part| parts.is_empty() || parts.contains(&part);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{cores} cores; wall-clock times, medians of {repeat} runs unless said otherwise");
    let mut complete = true;
    let mut part = |title: &str, result: Result<(), String>| {
        if let Err(why) = result {
            println!("\n{title}: not measured: {why}");
            complete = false;
        }
    };
    if wanted("kernels") {
        part("kernels", kernels());
    }
    if PARTS[1..].iter().any(|p| wanted(p)) {
        match granflow.map_or_else(|| run::build_granflow("release"), Ok) {
            Err(why) => part("runs", Err(why)),
            Ok(granflow) => {
                if wanted("annular") {
                    part("annular cell", annular(&granflow, repeat, cores));
                }
                if wanted("cavity") {
                    part("lid-driven cavity", cavity(&granflow, repeat));
                }
                if wanted("steady") {
                    part("steady states", steady::steady(&granflow));
                }
                if wanted("twoPhases") {
                    part("two fluids", race::two_phases(&granflow, repeat, cores, &cases));
                }
            }
        }
    }
    Ok(complete)
}

/// The harness of `benches/kernels.rs` as a child; it prints one JSON object a line.
fn kernels() -> Result<(), String> {
    let mut command = run::cargo(&["bench", "-q", "-p", "xtask", "--bench", "kernels"]);
    let output = command.stderr(Stdio::inherit()).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!("`{}` failed", run::shown(&command)));
    }
    println!("\nkernels, ns per cell (medians of batches; structured box of hexahedra)");
    println!("{:44} {:>9} {:>8} {:>9}", "", "cells", "threads", "ns/cell");
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(row) = serde_json::from_str::<Value>(line) else { continue };
        println!(
            "{:44} {:>9} {:>8} {:>9.2}",
            row["kernel"].as_str().unwrap_or_default(),
            row["cells"],
            row["threads"],
            row["ns_per_cell"].as_f64().unwrap_or(f64::NAN),
        );
    }
    Ok(())
}

/// Where the copy of a case has its directory.
pub(crate) fn scratch_place(name: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| run::root().join("target"), PathBuf::from);
    target.join("xtask-bench").join(name)
}

/// A directory of its own for a copy of a case, empty.
fn scratch(name: &str) -> Result<PathBuf, String> {
    let dir = scratch_place(name);
    if dir.exists() {
        fs::remove_dir_all(&dir).map_err(|e| format!("{}: {e}", dir.display()))?;
    }
    Ok(dir)
}

pub(crate) fn copy_case(from: &Path, name: &str) -> Result<PathBuf, String> {
    let dir = scratch(name)?;
    run::copy_dir(from, &dir).map_err(|e| format!("{}: {e}", from.display()))?;
    Ok(dir)
}

/// Runs a program silently and returns its seconds.
fn timed(command: &mut Command) -> Result<f64, String> {
    let begun = Instant::now();
    let output = command.stdin(Stdio::null()).output();
    let seconds = begun.elapsed().as_secs_f64();
    let output = output.map_err(|e| format!("`{}`: {e}", run::shown(command)))?;
    if output.status.success() {
        return Ok(seconds);
    }
    let mut said = String::from_utf8_lossy(&output.stderr).into_owned();
    said += &String::from_utf8_lossy(&output.stdout);
    let last: Vec<&str> = said.lines().rev().filter(|l| !l.trim().is_empty()).take(5).collect();
    let last: Vec<&str> = last.into_iter().rev().collect();
    Err(format!("`{}`: {}: {}", run::shown(command), output.status, last.join(" | ")))
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    match x.len() {
        0 => f64::NAN,
        n => 0.5 * (x[(n - 1) / 2] + x[n / 2]),
    }
}

/// What the logs below a case say of its steps.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Steps {
    pub(crate) steps: usize,
    outer: usize,
}

pub(crate) fn steps_below(case: &Path) -> Steps {
    let mut all = Steps::default();
    for log in run::files_below(case, "log.jsonl") {
        let one = steps_of(&fs::read_to_string(log).unwrap_or_default());
        all.steps += one.steps;
        all.outer += one.outer;
    }
    all
}

fn steps_of(log: &str) -> Steps {
    let objects = log.lines().filter_map(|l| serde_json::from_str::<Value>(l).ok());
    let steps = objects.filter(|o| o["step"].is_u64());
    steps.fold(Steps::default(), |s, o| Steps {
        steps: s.steps + 1,
        outer: s.outer + o["outer"].as_u64().unwrap_or(0) as usize,
    })
}

/// The paper's annular shear cell, as `granflow run` runs it.
fn annular(granflow: &Path, repeat: usize, cores: usize) -> Result<(), String> {
    let case = run::root().join("cases/annular_shear_cell");
    if !case.is_dir() {
        return Err(format!("{} does not exist", case.display()));
    }
    println!("\nannular shear cell, `granflow run` with meshing, output and figures");
    let threads: Vec<usize> = if cores > 1 { vec![1, cores] } else { vec![1] };
    let mut seconds = vec![Vec::new(); threads.len()];
    let mut steps = Steps::default();
    for _ in 0..repeat {
        for (n, seconds) in threads.iter().zip(&mut seconds) {
            let dir = copy_case(&case, "annular_shear_cell")?;
            let mut command = Command::new(granflow);
            command.arg("run").arg(&dir).args(["-j", &n.to_string()]);
            seconds.push(timed(&mut command)?);
            steps = steps_below(&dir);
        }
    }
    println!(
        "{:>8} {:>10} {:>8} {:>8} {:>10}",
        "threads", "s per run", "steps", "outer", "ms/step"
    );
    for (n, seconds) in threads.iter().zip(seconds) {
        let run = median(seconds);
        let step = 1e3 * run / steps.steps.max(1) as f64;
        println!("{n:>8} {run:>10.2} {:>8} {:>8} {step:>10.2}", steps.steps, steps.outer);
    }
    Ok(())
}

/// The lid-driven cavity on 128 x 128 cells, 200 steps of PISO, through both programs.
fn cavity(granflow: &Path, repeat: usize) -> Result<(), String> {
    let files = run::root().join("xtask/bench_cases/cavity");
    let ours = copy_case(&files, "cavity-granflow")?;
    let theirs = copy_case(&files, "cavity-icoFoam")?;
    timed(Command::new(granflow).arg("mesh").arg(&ours))?;
    let foam = |program: &str| {
        let mut command = Command::new(program);
        command.args(["-case"]).arg(&theirs).env("FOAM_SIGFPE", "false");
        if std::env::var_os("WM_PROJECT_DIR").is_none() {
            command.env("WM_PROJECT_DIR", "/usr/share/openfoam");
        }
        command
    };
    let peer = timed(&mut foam("blockMesh"));
    let (mut mine, mut other) = (Vec::new(), Vec::new());
    for _ in 0..repeat {
        mine.push(timed(
            Command::new(granflow).arg("run").arg(&ours).args(["-j", "1", "--from", "start"]),
        )?);
        if peer.is_ok() {
            other.push(timed(&mut foam("icoFoam"))?);
        }
    }
    println!("\nlid-driven cavity, 128 x 128 cells, Re 100, PISO with 2 corrections, one core");
    println!("{:>10} {:>10} {:>8} {:>10}", "", "s per run", "steps", "ms/step");
    let row = |name: &str, seconds: f64, steps: usize| {
        let step = 1e3 * seconds / steps.max(1) as f64;
        println!("{name:>10} {seconds:>10.2} {steps:>8} {step:>10.2}");
    };
    let mine = median(mine);
    row("granflow", mine, CAVITY_STEPS);
    if let Err(why) = peer {
        println!("the reference tool is not installed (blockMesh, icoFoam): {why}");
        return Ok(());
    }
    let other = median(other);
    row("icoFoam", other, CAVITY_STEPS);
    println!("icoFoam / granflow: {:.2}", other / mine);
    match (velocity(&ours), velocity(&theirs)) {
        (Some(a), Some(b)) if a.len() == b.len() => {
            let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("the two velocity fields differ by at most {apart:.2e} of the lid's speed");
        }
        _ => println!("the two velocity fields could not be compared"),
    }
    Ok(())
}

/// Steps of the cavity's controlDict.
const CAVITY_STEPS: usize = 200;

/// Components of the last velocity of a case (ASCII), cell by cell; the lid moves with 1 m/s.
fn velocity(case: &Path) -> Option<Vec<f64>> {
    let text = fs::read_to_string(case.join("0.1/U")).ok()?;
    let field = text.split_once("internalField")?.1;
    let list = field.split_once('(')?.1;
    let list = list.split_once("\n)").or_else(|| list.split_once("))"))?.0;
    Some(list.split(['(', ')', ' ', '\n']).filter_map(|w| w.parse().ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_and_events_are_not() {
        let log = "{\"event\": \"start\"}\n{\"step\": 1, \"outer\": 3, \"wall\": 0.1}\n\
                   {\"step\": 2, \"outer\": 2, \"wall\": 0.2}\nhalf a li";
        assert_eq!(steps_of(log), Steps { steps: 2, outer: 5 });
    }

    #[test]
    fn the_middle_one_is_taken() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
