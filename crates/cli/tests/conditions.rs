//! Conditions through a whole run: what is written goes on, and goes on to the same bits.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{Case, cavity, text};

const LID: &str = "type        fixedValue;\n        value       uniform (1 0 0);";

fn succeed(case: &Case, args: &[&str]) {
    let out = case.run(args);
    assert_eq!(out.status.code(), Some(0), "{}\n{}", text(&out.stderr), text(&out.stdout));
}

/// Runs to the end at once, and in two runs.
fn goes_on(make: impl Fn() -> Case) -> Case {
    let (whole, parts) = (make(), make());
    succeed(&whole, &["run", "-j", "1"]);
    succeed(&parts, &["run", "-j", "1", "--until", "0.05"]);
    succeed(&parts, &["run", "-j", "1", "--from", "latest"]);
    for file in ["0.1/U", "0.1/p"] {
        assert_eq!(whole.read(file), parts.read(file), "{file}");
    }
    whole
}

#[test]
fn functions_of_time_go_on_where_they_were() {
    let lid = "type uniformFixedValue; uniformValue { type tableFile; file \"<case>/constant/lid\"; \
               outOfBounds repeat; }";
    let case = goes_on(|| {
        let case = cavity().edit("0/U", LID, lid);
        case.put("constant/lid", b"((0 (0 0 0)) (0.02 (1 0 0)) (0.07 (3 0 0)))");
        case
    });
    let written = case.read("0.1/U");
    assert!(written.contains("file            \"<case>/constant/lid\";"), "{written}");
    // 0.1 s is 0.03 s into the table.
    let value = written.split("value           uniform (").nth(1);
    let x = value.and_then(|v| v.split(' ').next()?.parse::<f64>().ok());
    assert!(x.is_some_and(|x| (x - 1.4).abs() < 1e-12), "{written}");
}

#[test]
fn values_from_files_go_on_where_they_were() {
    let lid = "type timeVaryingMappedFixedValue; setAverage off; offset (1 0 0);";
    let make = || {
        let case = cavity().edit("0/U", LID, lid);
        let put = |name: &str, text: &str| {
            case.put(&format!("constant/boundaryData/lid/{name}"), text.as_bytes());
        };
        put("points", "((0 0.1 0) (0.1 0.1 0) (0 0.1 0.01) (0.1 0.1 0.01))");
        put("0/U", "((0 0 0) (0 0 0) (0 0 0) (0 0 0))");
        put("0.2/U", "4\n(\n(0 0 0)\n(8 0 0)\n(0 0 0)\n(8 0 0)\n)\n");
        case
    };
    let case = goes_on(make);
    // Half of the time, at 1/8, 3/8, 5/8 and 7/8 of the lid.
    let written = case.read("0.1/U");
    let values: Vec<f64> = written
        .lines()
        .skip_while(|l| !l.contains("lid"))
        .filter_map(|l| l.trim().strip_prefix('(')?.split(' ').next()?.parse().ok())
        .take(4)
        .collect();
    assert_eq!(values.len(), 4, "{written}");
    for (found, expected) in values.iter().zip([1.5, 2.5, 3.5, 4.5]) {
        assert!((found - expected).abs() < 1e-12, "{values:?}");
    }
}

#[test]
fn a_pressure_may_carry_its_dimensions() {
    let of = |value: &str| {
        let lid = "    lid\n    {\n        type        zeroGradient;\n    }\n";
        let given = format!("    lid {{ type uniformFixedValue; uniformValue {value}; }}\n");
        let case = cavity().edit("0/p", lid, &given);
        succeed(&case, &["run", "-j", "1"]);
        case.read("0.1/p").split("boundaryField").next().unwrap_or("").to_owned()
    };
    let plain = of("3");
    assert!(!plain.contains("nan"), "{plain}");
    assert_eq!(plain, of("[0 2 -2 0 0 0 0] 3"));
}
