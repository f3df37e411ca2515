//! How many tests passed, read from what the runners say.

use std::fmt;
use std::ops::AddAssign;

/// Counts of tests and the names of those that failed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Totals {
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    pub(crate) skipped: usize,
    pub(crate) failures: Vec<String>,
}

impl AddAssign for Totals {
    fn add_assign(&mut self, o: Totals) {
        self.passed += o.passed;
        self.failed += o.failed;
        self.skipped += o.skipped;
        self.failures.extend(o.failures);
    }
}

impl fmt::Display for Totals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed", self.passed, self.failed)?;
        if self.skipped > 0 { write!(f, ", {} skipped", self.skipped) } else { Ok(()) }
    }
}

/// From nextest's summary and its lines about single tests.
pub(crate) fn of_nextest(lines: &[String]) -> Totals {
    let mut totals = Totals::default();
    for line in lines {
        let line = line.trim();
        if line.starts_with("Summary [") {
            let Some((_, counts)) = line.split_once("run:") else { continue };
            for part in counts.split(',') {
                add(&mut totals, part);
            }
        } else if let Some((word, test)) = line.split_once(" [") {
            let failed = matches!(word, "FAIL" | "TIMEOUT" | "XFAIL" | "LEAK-FAIL")
                || word.starts_with("SIG")
                || word.starts_with("ABORT");
            let name = test.split_once(']').map_or(test, |(_, name)| name).trim();
            // `(  3/120) package test` in newer versions.
            let name = match name.split_once(')') {
                Some((count, rest)) if count.starts_with('(') => rest.trim(),
                _ => name,
            };
            if failed && !totals.failures.iter().any(|f| f == name) {
                totals.failures.push(name.to_owned());
            }
        }
    }
    totals
}

/// From the lines `test result: ...` of the standard harness.
pub(crate) fn of_libtest(lines: &[String]) -> Totals {
    let mut totals = Totals::default();
    for line in lines {
        if let Some((_, counts)) =
            line.strip_prefix("test result: ").and_then(|rest| rest.split_once(". "))
        {
            for part in counts.split(';') {
                add(&mut totals, part);
            }
        } else if let Some(name) =
            line.strip_prefix("test ").and_then(|rest| rest.strip_suffix(" ... FAILED"))
        {
            totals.failures.push(name.to_owned());
        }
    }
    totals
}

/// One `12 passed` of a summary.
fn add(totals: &mut Totals, part: &str) {
    let part = part.trim();
    let Some((number, word)) = part.split_once(' ') else { return };
    let Ok(n) = number.parse::<usize>() else { return };
    let word = word.split('(').next().unwrap_or(word).trim();
    match word {
        "passed" => totals.passed += n,
        "failed" | "timed out" | "exec failed" => totals.failed += n,
        "skipped" | "ignored" => totals.skipped += n,
        _ => (),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(String::from).collect()
    }

    #[test]
    fn nextest_totals_and_failures_are_found() {
        let totals = of_nextest(&lines(
            "        PASS [   0.008s] granflow-dict::laws round_trip
        FAIL [   0.005s] ( 3/12) granflow-mesh::coupling ghosts
     TIMEOUT [ 600.005s] granflow-case::restart to_the_bit
     Summary [   0.026s] 12 tests run: 10 passed (1 slow, 1 leaky), 1 failed, 1 timed out, 3 skipped
        FAIL [   0.005s] ( 3/12) granflow-mesh::coupling ghosts",
        ));
        assert_eq!(totals.to_string(), "10 passed, 2 failed, 3 skipped");
        let failures = ["granflow-mesh::coupling ghosts", "granflow-case::restart to_the_bit"];
        assert_eq!(totals.failures, failures);
    }

    #[test]
    fn results_of_several_binaries_add_up() {
        let totals = of_libtest(&lines(
            "test crates/dict/src/lib.rs - (line 3) ... ok
test result: ok. 1 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out; finished in 0.01s
test src/lib.rs - Halo (line 9) ... FAILED
test result: FAILED. 4 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0s",
        ));
        assert_eq!(totals.to_string(), "5 passed, 1 failed, 2 skipped");
        assert_eq!(totals.failures, ["src/lib.rs - Halo (line 9)"]);
    }
}
