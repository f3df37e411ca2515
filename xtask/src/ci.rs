//! Everything a change must pass, in one go. Every check runs, whatever the others found; the last
//! line is `N passed, N failed`.

use crate::run::{self, Heard};
use crate::totals::{self, Totals};
use crate::{docs, links};
use std::process::Command;
use std::time::Instant;

/// One check.
struct Outcome {
    name: &'static str,
    passed: bool,
    seconds: f64,
    /// What to look at.
    details: Vec<String>,
}

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    if let Some(unknown) = args.first() {
        return Err(format!("`ci` takes no options, found `{unknown}`"));
    }
    let begun = Instant::now();
    let mut tests = Totals::default();
    let lints = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    let mut rustdoc = run::cargo(&["doc", "--workspace", "--no-deps"]);
    rustdoc.env("RUSTDOCFLAGS", "-D warnings");
    let outcomes = [
        check("format", || command(run::cargo(&["fmt", "--all", "--check"]))),
        check("lints", || command(run::cargo(&lints))),
        check("tests", || unit_tests(&mut tests)),
        check("doc tests", || {
            let mut doc = run::cargo(&["test", "--workspace", "--doc", "--no-fail-fast"]);
            counted(&mut doc, totals::of_libtest, &mut tests)
        }),
        check("rustdoc", || command(rustdoc)),
        check("book", book),
    ];
    println!("\n{:-<72}", "");
    for o in &outcomes {
        let verdict = if o.passed { "ok" } else { "FAILED" };
        println!("{verdict:7} {:10} {:8.1} s", o.name, o.seconds);
        for line in &o.details {
            println!("          {line}");
        }
    }
    println!("{:7} {:10} {:8.1} s\n", "", "in all", begun.elapsed().as_secs_f64());
    // A check that is no test counts as one, so that the last line never hides a failure.
    let others = outcomes.iter().filter(|o| !o.passed && !o.name.ends_with("tests")).count();
    let unexplained = outcomes.iter().any(|o| !o.passed && o.name.ends_with("tests"));
    tests.failed = match tests.failed {
        0 if unexplained => others + 1,
        n => n + others,
    };
    println!("{tests}");
    Ok(outcomes.iter().all(|o| o.passed))
}

fn check(name: &'static str, run: impl FnOnce() -> Result<(), Vec<String>>) -> Outcome {
    println!("\n=== {name}");
    let begun = Instant::now();
    let result = run();
    let seconds = begun.elapsed().as_secs_f64();
    Outcome { name, passed: result.is_ok(), seconds, details: result.err().unwrap_or_default() }
}

/// Runs `command`; when it fails, the details are the command to repeat.
fn command(mut command: Command) -> Result<(), Vec<String>> {
    let repeat = vec![run::shown(&command)];
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(repeat),
        Err(e) => Err(vec![format!("{}: {e}", repeat[0])]),
    }
}

/// All tests but those in documentation, by nextest where it is installed.
fn unit_tests(tests: &mut Totals) -> Result<(), Vec<String>> {
    let probe = run::cargo(&["nextest", "--version"]).output();
    if probe.is_ok_and(|o| o.status.success()) {
        let args = ["nextest", "run", "--workspace", "--profile", "ci", "--no-tests", "pass"];
        return counted(&mut run::cargo(&args), totals::of_nextest, tests);
    }
    println!("cargo-nextest is not installed: `cargo test` does as well");
    let kinds = ["--lib", "--bins", "--tests", "--examples", "--no-fail-fast"];
    let mut plain = run::cargo(&["test", "--workspace"]);
    counted(plain.args(kinds), totals::of_libtest, tests)
}

fn counted(
    command: &mut Command,
    count: fn(&[String]) -> Totals,
    tests: &mut Totals,
) -> Result<(), Vec<String>> {
    // Snapshots are compared, never written: a check changes nothing.
    command.env("INSTA_UPDATE", "no");
    let Heard { success, lines } = run::tee(command).map_err(|e| vec![e])?;
    let found = count(&lines);
    let mut details = found.failures.clone();
    let failed = found.failed;
    *tests += found;
    if success && failed == 0 {
        return Ok(());
    }
    details.push(run::shown(command));
    Err(details)
}

/// The book: a page for every entry of every registry, and no link that leads nowhere.
fn book() -> Result<(), Vec<String>> {
    let mut faults = match run::build_granflow("test").and_then(|g| docs::faults(&g)) {
        Ok(faults) => faults,
        Err(e) => vec![e],
    };
    faults.extend(links::faults(&run::root()));
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}
