//! Runs that cannot be: what they say, with which exit code.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{cavity, granflow, ring, text};

#[test]
fn an_end_before_the_start_is_refused() {
    let case = ring();
    assert_eq!(case.run(&["run"]).status.code(), Some(0));
    let before = case.tree();
    for until in ["0.1", "0.26"] {
        let out = case.run(&["run", "--until", until]);
        let said = text(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{said}");
        let message =
            format!("error: --until {until} lies before the start at 0.3 s (directory 0.3)");
        assert!(said.contains(&message) && said.contains("= help: give a later --until"), "{said}");
        assert!(case.tree() == before, "--until {until} changed something");
    }
}

#[test]
fn a_formula_that_fails_in_time_is_named_with_its_patch() {
    let lid = "type        fixedValue;\n        value       uniform (1 0 0);";
    for (condition, told) in [
        (
            "exprMixed; valueExpr \"vector(1, 0, 0)\"; fractionExpr \"0.5 + 10*time()\";",
            "error: U on patch `lid`: the formula `0.5 + 10*time()` is 1.05, a share from 0 to 1 is needed, at (0.0125 0.1 0.005) m, time 0.055 s; the state before this step is in `0.05`",
        ),
        (
            "exprFixedValue; valueExpr \"vector(sqrt(0.05 - time()), 0, 0)\";",
            "error: U on patch `lid`: the formula `vector(sqrt(0.05 - time()), 0, 0)` is not finite at (0.0125 0.1 0.005) m, time 0.055 s",
        ),
    ] {
        let case = cavity().edit("0/U", lid, &format!("type {condition}"));
        let out = case.run(&["run"]);
        let said = text(&out.stderr);
        assert_eq!(out.status.code(), Some(3), "{said}");
        assert!(said.contains(told), "{said}");
    }
}

#[test]
fn friction_that_is_used_up_is_the_reason_given() {
    // Down a slope of 37 degrees, tan 0.75, for a thousand seconds: nothing holds the grains.
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path().join("slope");
    let new = granflow(&["new", "bagnold", "slope"]).current_dir(dir.path()).output().unwrap();
    assert_eq!(new.status.code(), Some(0), "{}", text(&new.stderr));
    let edit = |file: &str, from: &str, to: &str| {
        let old = std::fs::read_to_string(at.join(file)).unwrap();
        assert_eq!(old.matches(from).count(), 1, "{file}: {from}");
        std::fs::write(at.join(file), old.replace(from, to)).unwrap();
    };
    edit("constant/g", "(3.99008646857 -8.96188093947 0)", "(5.886 -7.848 0)");
    edit("system/controlDict", "endTime         100;", "endTime 1000;");
    edit("system/controlDict", "deltaT          5;", "deltaT 1000;");
    let out = granflow(&["run", "-j", "1"]).current_dir(&at).output().unwrap();
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(3), "{said}\n{}", text(&out.stdout));
    let sign = "error: the friction of the grains is used up at time 1000: mu = ";
    let mu = said.split(sign).nth(1).and_then(|s| s.split(' ').next()).unwrap_or("");
    let mu: f64 = mu.parse().unwrap_or(f64::NAN);
    assert!((mu - 0.6435).abs() < 0.03 * (0.6435 - 0.3819), "{said}");
    assert!(said.contains("and mu_2 = 0.6435 is all they have"), "{said}");
    assert!(said.contains("= help: lower the wall speed"), "{said}");
}

#[test]
fn an_iteration_that_diverged_is_not_blamed_on_friction() {
    // At 2 km/s from rest in one step.
    let case = ring().edit("0.orig/U", "omega   0.2;", "omega   40000;");
    let out = case.run(&["run"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(3), "{said}\n{}", text(&out.stdout));
    assert!(
        said.contains("error: the outer iteration diverged at time 0.1 (residuals: "),
        "{said}"
    );
    assert!(!said.contains("friction"), "{said}");
}
