//! The project's one task runner: `cargo xtask ci|bench|compare|docs|parseExamples|validate`.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a task runner talks to a person")]

mod bench;
mod ci;
mod compare;
mod docs;
mod finer;
mod foam_field;
mod laminar;
mod links;
mod meshes;
mod moments;
mod parse_examples;
mod race;
mod run;
mod steady;
mod totals;
mod validate;

use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask TASK [OPTIONS]

  ci                      formatting, lints, tests, documentation; what .ci/run runs
  docs [--check]          writes the book's reference pages from the registries; with --check
                          only says which are missing or stale, and which links lead nowhere
       [--granflow PATH]  the program that is asked for its registries; built by default
  bench [PART ...]        timings; PART is kernels, annular, cavity, steady or twoPhases (all of
                          them by default)
        [--case NAME]     of twoPhases only the cases whose names hold one of these
        [--repeat N]      runs of each program, 3 by default; medians are printed
        [--granflow PATH] the program to time; built in release mode by default
  compare [NAME ...]      laminar tutorials of OpenFOAM through both programs, cell by cell;
                          needs OpenFOAM and its examples
        [--again]         only compares what the last runs left
        [--examples DIR]  where they are; Debian's place by default
        [--granflow PATH] the program to run; built in release mode by default
  compareMeshes [PART ...]  every blockMeshDict of OpenFOAM's examples whose path holds a PART (all by
                          default) through blockMesh and granflow mesh; needs OpenFOAM, its examples
                          and m4
        [--examples DIR]  where they are; Debian's place by default
        [--granflow PATH] the program to run; built in release mode by default
  parseExamples [DIR]     every file with a FoamFile header below DIR, OpenFOAM's examples by default,
                          through the parser: parsed, refused by name, failed
  validate [NAME ...]     the catalogue of cases at full resolution against its references";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (task, rest) = args.split_first().map_or(("", &args[..]), |(t, r)| (t.as_str(), r));
    let outcome = match task {
        "ci" => ci::task(rest),
        "compare" => compare::task(rest),
        "compareMeshes" => meshes::task(rest),
        "docs" => docs::task(rest),
        "bench" => bench::task(rest),
        "parseExamples" => parse_examples::task(rest),
        "validate" => validate::task(rest),
        "" | "help" | "-h" | "--help" => {
            println!("{USAGE}");
            Ok(!task.is_empty())
        }
        other => Err(format!("unknown task `{other}`\n\n{USAGE}")),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::from(2)
        }
    }
}
