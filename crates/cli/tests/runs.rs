//! Whole runs through the program: exit codes, signals, restart, what is printed.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{Case, cavity, granflow, ring, text};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

/// Time directories of a case, in order.
fn times(case: &Case) -> Vec<f64> {
    let names = fs::read_dir(case.path()).unwrap().map(|e| e.unwrap().file_name());
    let mut times: Vec<f64> = names.filter_map(|n| n.to_str()?.parse().ok()).collect();
    times.sort_by(f64::total_cmp);
    times
}

#[test]
fn a_case_is_meshed_initialised_solved_and_written() {
    let case = ring();
    let out = case.run(&["run", "-j", "1"]);
    let said = text(&out.stdout);
    assert_eq!((out.status.code(), text(&out.stderr)), (Some(0), String::new()), "{said}");
    assert_eq!(times(&case), [0.0, 0.1, 0.2, 0.3]);
    assert!(case.path().join("constant/polyMesh/owner").is_file());
    assert_eq!(case.read("0/U"), case.read("0.orig/U"));
    for file in ["0.3/fluidity", "0.3/viscosity", "0.3/uniform/time", "log.jsonl"] {
        assert!(case.path().join(file).is_file(), "{file}");
    }
    let lines: Vec<&str> = said.lines().collect();
    let intro =
        "8 cells, NGF, t 0 to 0.3 s, 1 thread, meshed from blockMeshDict, 0 made from 0.orig";
    assert!(lines.contains(&intro), "{said}");
    assert!(
        lines.iter().any(|l| l.starts_with("100 %  t 0.3 s  ") && l.contains("step 3  U ")),
        "{said}"
    );
    assert!(lines.iter().any(|l| l.starts_with("t 0.3 s after 3 steps, ")), "{said}");
    assert!(lines.contains(&"results  0.1 to 0.3 (3 times)"), "{said}");
    assert!(lines.contains(&"         postProcessing"), "{said}");
    assert!(!said.contains('\u{1b}'), "no colours off a terminal");

    let again = case.run(&["run"]);
    assert_eq!(again.status.code(), Some(0));
    let said = text(&again.stdout);
    assert!(
        said.contains("nothing to compute: the start is at t 0.3 s, the end at 0.3 s"),
        "{said}"
    );
    assert_eq!(times(&case), [0.0, 0.1, 0.2, 0.3]);
}

#[test]
fn quiet_means_quiet() {
    let out = cavity().run(&["run", "--quiet"]);
    assert_eq!((out.status.code(), out.stdout, out.stderr), (Some(0), Vec::new(), Vec::new()));
}

#[test]
fn quiet_runs_do_not_talk_of_figures_either() {
    let plot = "FoamFile { version 2.0; format ascii; class dictionary; object plotDict; }
        figures { gap { curves ( { file \"postProcessing/none/<time>/a.csv\"; x \"x\"; y \"U_x\"; } ); } }";
    for (flag, silent) in [("--quiet", true), ("--share=64", false)] {
        let case = cavity();
        case.put("system/plotDict", plot.as_bytes());
        let out = case.run(&["run", flag]);
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        assert_eq!(out.stderr.is_empty(), silent, "{}", text(&out.stderr));
    }
}

#[test]
fn a_finished_run_is_at_a_hundred_percent() {
    // It ends within half a step of its end.
    let out =
        ring().edit("system/controlDict", "endTime         0.3;", "endTime 0.32;").run(&["run"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(said.lines().any(|l| l.starts_with("100 %  t 0.3 s  ")), "{said}");
}

#[test]
fn mesh_and_init_do_their_part_and_nothing_else() {
    let case = ring();
    let out = case.run(&["mesh"]);
    assert_eq!(out.status.code(), Some(0), "{out:?}");
    assert!(text(&out.stdout).ends_with("mesh ok\nwritten to constant/polyMesh\n"), "{out:?}");
    assert!(!case.path().join("0").exists());
    let out = case.run(&["init"]);
    assert_eq!(text(&out.stdout), "0 made from 0.orig\n", "{out:?}");
    let before = case.tree();
    assert_eq!(case.run(&["init"]).status.code(), Some(2), "0 is not overwritten");
    assert!(case.tree() == before);
    let out = case.run(&["run"]);
    assert!(!text(&out.stdout).contains("made"), "{out:?}");
}

#[test]
fn check_tells_what_a_run_would_meet() {
    let out = ring().run(&["check"]);
    let said = text(&out.stdout);
    for line in [
        "cells              8 (8 hexahedra)",
        "model              NGF, rho 1519 kg/m3",
        "speed              0.0102 m/s at patch inner",
        "cells a grain      0.5 at the finest, 0.5 at the coarsest",
        "pressure           75 Pa at the start",
        "pressure level     75 in cell 0 (pRefValue)",
        "== Time step",
        "the case can be run",
    ] {
        assert!(said.lines().any(|l| l == line), "{line}\n is not in\n{said}");
    }
    // V/(5 d) d/sqrt(P/rhos) at V = 0.0102 m/s.
    let inertial = said.lines().find(|l| l.starts_with("inertial number")).unwrap();
    assert!(inertial.contains("to 0.0117 at the driven patches (dense flow)"), "{inertial}");
    assert!(
        said.contains("warning            the shear at inner decays over a few grains"),
        "{said}"
    );
}

#[test]
fn a_run_that_blows_up_keeps_a_state_to_go_on_from() {
    let case = cavity().edit(
        "0/U",
        "type        fixedValue;\n        value       uniform (1 0 0);",
        "type uniformFixedValue; uniformValue table ((0 (1 0 0)) (0.02 (1 0 0)) (0.03 (1e200 0 0)));",
    );
    let out = case.run(&["run"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(3), "{said}");
    assert!(said.contains("the state before this step is in `0.02`"), "{said}");
    assert!(said.contains("help: shorten deltaT"), "{said}");
    assert_eq!(times(&case), [0.0, 0.02]);
    let case = case.edit("0.02/U", "1e200", "1");
    let out = case.run(&["run", "--from", "latest"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(times(&case), [0.0, 0.02, 0.05, 0.1]);
}

#[test]
fn a_full_disk_is_exit_code_4() {
    let case = cavity();
    std::os::unix::fs::symlink("/dev/full", case.path().join("log.jsonl")).unwrap();
    let out = case.run(&["run"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(4), "{said}");
    assert!(said.contains("log.jsonl: disk full"), "{said}");
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let out = granflow(&["list"]).stdout(full).output().unwrap();
    assert_eq!(out.status.code(), Some(4), "{out:?}");
}

#[test]
fn a_file_where_a_directory_should_be_is_named() {
    let case = cavity();
    case.put("constant/polyMesh", b"not a directory");
    let before = case.tree();
    for command in ["mesh", "run"] {
        let out = case.run(&[command]);
        let said = text(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(said.contains("constant/polyMesh"), "{said}");
    }
    assert!(case.tree() == before);
}

/// Starts a run and waits until it prints `sign`.
#[expect(clippy::zombie_processes, reason = "the callers wait")]
fn start(case: &Case, sign: &str) -> (Child, BufReader<ChildStdout>) {
    let mut command = granflow(&["run"]);
    command.current_dir(case.path()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    loop {
        let mut line = String::new();
        assert_ne!(lines.read_line(&mut line).unwrap(), 0, "the run ended before `{sign}`");
        if line.contains(sign) {
            return (child, lines);
        }
    }
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

#[test]
fn a_signal_writes_and_stops_and_a_restart_goes_on() {
    for (name, code) in [("-TERM", 143), ("-INT", 130)] {
        let case = cavity()
            .edit("system/controlDict", "endTime         0.1;", "endTime 1e9;")
            .edit("system/controlDict", "writeInterval   10;", "writeInterval 1000000000;")
            .edit("system/controlDict", "startTime;", "latestTime;");
        let (mut child, _lines) = start(&case, "step 1 ");
        signal(&child, name);
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let stopped = times(&case);
        assert_eq!(stopped.len(), 2, "the state was written once: {stopped:?}");
        let more = (stopped[1] + 0.05).to_string();
        let out = case.run(&["run", "--until", &more]);
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        let after = times(&case);
        assert_eq!(after.len(), 3, "{after:?}");
        assert!((after[2] - stopped[1] - 0.05).abs() < 1e-3, "{after:?}");
    }
}

#[test]
fn the_second_signal_stops_at_once() {
    // One step of this case takes longer than anybody waits.
    let case = cavity().edit("system/fvSolution", "nCorrectors     2;", "nCorrectors 100000000;");
    let (mut child, _lines) = start(&case, "16 cells");
    let code = loop {
        // Two signals that meet before the program is scheduled are one: send until it hears.
        signal(&child, "-TERM");
        std::thread::sleep(std::time::Duration::from_millis(20));
        if let Some(status) = child.try_wait().unwrap() {
            break status.code();
        }
    };
    assert_eq!(code, Some(143));
    assert_eq!(times(&case), [0.0]);
}

#[test]
fn a_signal_ends_a_step_that_would_never_end() {
    // The residuals asked for are below rounding: the outer iterations go on until they are given up,
    // which on eight thousand cells takes its time.
    let case = ring().edit("system/blockMeshDict", "(8 1 1)", "(80 1 100)").edit(
        "system/fvSolution",
        "    pRefCell    0;",
        "    nOuterCorrectors 100000000;\n    residualControl { U 1e-300; p 1e-300; viscosity 1e-300; }\n    pRefCell    0;",
    );
    let (mut child, _lines) = start(&case, "8000 cells");
    std::thread::sleep(std::time::Duration::from_millis(300));
    signal(&child, "-TERM");
    let asked = std::time::Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(asked.elapsed().as_secs() < 20, "{:?}", asked.elapsed());
    assert_eq!(times(&case), [0.0], "no step was whole");
    let log = case.read("log.jsonl");
    assert!(log.lines().last().unwrap().contains("\"reason\":\"stopped\""), "{log}");
}

#[test]
fn rounding_of_the_clock_is_no_step() {
    // Ten steps of 0.05 s add up to a little less than 0.5 s.
    let case = cavity()
        .edit("system/controlDict", "endTime         0.1;", "endTime 0.5;")
        .edit("system/controlDict", "deltaT          0.005;", "deltaT 0.05;")
        .edit("system/controlDict", "writeControl    timeStep;", "writeControl adjustableRunTime;");
    let out = case.run(&["run"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let steps = case.read("log.jsonl").matches("\"step\":").count();
    assert_eq!(steps, 10);
}

#[test]
fn one_run_a_case_at_a_time() {
    let case = cavity().edit("system/controlDict", "endTime         0.1;", "endTime 1e9;");
    let (mut child, _lines) = start(&case, "step 1 ");
    for command in ["run", "mesh"] {
        let out = case.run(&[command]);
        let said = text(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{said}");
        let who = format!("the case is in use by granflow (process {})", child.id());
        assert!(said.contains(&who) && said.contains(".granflow.lock"), "{said}");
    }
    assert_eq!(case.run(&["check"]).status.code(), Some(0), "reading is free");
    // Killed, it cannot take its lock away; that is in nobody's way.
    signal(&child, "-KILL");
    child.wait().unwrap();
    assert!(case.path().join(".granflow.lock").is_file());
    let out = case.run(&["run", "--from", "0", "--until", "0.01"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(!case.path().join(".granflow.lock").exists());
}

#[test]
fn grains_that_are_pulled_apart_are_said_once() {
    let case = ring().edit("system/fvSolution", "pRefValue   75;", "pRefValue   -5;");
    let out = case.run(&["run"]);
    let said = text(&out.stderr);
    let sign = "warning: the pressure is not positive in 8 cells at t 0.1 s, the least -5";
    assert_eq!(said.matches("not positive").count(), 1, "{said}");
    assert!(said.contains(sign) && said.contains(" in cell "), "{said}");
    assert!(said.contains("= help: likely the pressure given at a boundary or by pRefValue"));
    assert!(case.read("log.jsonl").contains("\"message\":\"the pressure is not positive\""));
}

#[test]
fn systems_that_were_not_solved_are_counted() {
    let case = cavity().edit(
        "system/fvSolution",
        "tolerance       1e-08;\n        relTol          0.01;",
        "tolerance 1e-08; relTol 0.01; maxIter 2;",
    );
    // Multigrid would solve them.
    let case = case.edit("system/fvSolution", "preconditioner  DIC;", "preconditioner  none;");
    let out = case.run(&["run"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{said}");
    let line = said.lines().find(|l| l.starts_with("warning: p: ")).unwrap_or("");
    assert!(line.contains(" of 40 solves ended unconverged; raise maxIter or use GAMG"), "{said}");
    let tail = said.lines().find(|l| l.contains("step 1 ")).unwrap_or("");
    assert!(tail.ends_with("solves unconverged"), "{tail}");
    let log = case.read("log.jsonl");
    let step = log.lines().nth(1).and_then(|l| serde_json::from_str(l).ok());
    let step: serde_json::Value = step.unwrap();
    assert!(step["solves"][1]["unconverged"].as_u64().is_some_and(|n| n > 0), "{step}");
    assert_eq!(step["solves"][0]["unconverged"], 0, "{step}");
}

#[test]
fn the_constraint_types_of_openfoam_are_known() {
    let include = "#includeEtc \"caseDicts/setConstraintTypes\"";
    let case = ring()
        .edit(
            "0.orig/U",
            "    minus   { type wedge; }\n    plus    { type wedge; }\n",
            &format!("    {include}\n"),
        )
        .edit("0.orig/p", "    \"(minus|plus)\" { type wedge; }\n", &format!("    {include}\n"));
    let out = case.run(&["run", "--until", "0.1"]);
    assert_eq!((out.status.code(), text(&out.stderr)), (Some(0), String::new()));
}

#[test]
fn what_an_earlier_run_wrote_behind_the_start_is_set_aside() {
    let case = ring();
    assert_eq!(case.run(&["run"]).status.code(), Some(0));
    let (old, log) = (case.read("0.3/U"), case.read("log.jsonl"));
    let out = case.run(&["run", "--from", "0", "--until", "0.1"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(
        said.contains(
            "note: the 3 times 0.1 to 0.3 of an earlier run lie behind the start of this one: set \
             aside in superseded/1, to keep or to remove"
        ),
        "{said}"
    );
    assert_eq!(times(&case), [0.0, 0.1], "the latest time is this run's");
    assert_eq!(case.read("superseded/1/0.3/U"), old, "nothing is lost");
    assert_eq!(case.read("superseded/1/log.jsonl"), log);
    assert!(case.path().join("superseded/1/postProcessing/profile/0.3").is_dir());
    assert!(!case.path().join("postProcessing/profile/0.3").exists());
    let out = case.run(&["run", "--from", "latest", "--until", "0.2"]);
    assert!(!text(&out.stdout).contains("superseded"), "{out:?}");
    let out = case.run(&["run", "--from", "0.1", "--until", "0.2"]);
    assert!(text(&out.stdout).contains("the time 0.2 of an earlier run lies"), "{out:?}");
    assert_eq!(case.read("0.2/U"), case.read("superseded/2/0.2/U"), "and it is the same again");
}

#[test]
fn data_that_figures_lack_are_said_once() {
    let curve =
        "{ file \"postProcessing/profile/<time>/radius_U_fluidity.xy\"; x col1; y col2; time ";
    let curves = format!("{curve} (0.1 0.5 0.6); }} {curve} 0.7; }} {curve} 0.5; }}");
    let case =
        ring().write("system/plotDict", &format!("figures {{ a {{ curves ( {curves} ); }} }}"));
    let out = case.run(&["run"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{said}");
    assert_eq!(said.matches("warning").count(), 1, "{said}");
    assert!(said.contains("no data for the times 0.5, 0.6, 0.7 in postProcessing/profile/"));
    assert!(said.contains("4 curves are left out"), "{said}");
}

#[test]
fn a_run_can_be_exported() {
    let case = ring();
    assert_eq!(case.run(&["run"]).status.code(), Some(0));
    let out = case.run(&["export"]);
    let fields = "U, p, fluidity, inertialNumber, strainRate, stressRatio, viscosity";
    let said = format!("VTK/case.pvd: 4 times of {fields}\n");
    assert_eq!((out.status.code(), text(&out.stdout)), (Some(0), said));
    assert!(case.path().join("VTK/0.3.vtu").is_file());
    assert_eq!(case.read("VTK/case.pvd").matches("<DataSet ").count(), 4);
}

/// Bagnold's layer at tan(theta) = 0.385 flows at I = 0.0034, where mu(I) is ill-posed.
#[test]
fn where_mu_of_i_is_ill_posed_is_said_once() {
    let here = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| granflow(args).current_dir(here.path()).output().unwrap();
    assert!(run(&["new", "bagnold", "slope"]).status.success());
    let said = text(&run(&["run", "slope", "--until", "10"]).stdout);
    assert!(!said.contains("ill-posed"), "{said}");
    let file = here.path().join("slope/constant/g");
    let steep = "(3.99008646857 -8.96188093947 0)";
    let old = fs::read_to_string(&file).unwrap();
    assert!(old.contains(steep));
    fs::write(&file, old.replace(steep, "(3.524651947 -9.154940123 0)")).unwrap();
    let out = run(&["run", "slope", "--from", "start", "--until", "10"]);
    let (said, log) = (text(&out.stdout), here.path().join("slope/log.jsonl"));
    let warning = "warning: mu(I) is ill-posed in 80 of 80 cells that yield (100 %) at the end";
    assert_eq!(said.matches(warning).count(), 1, "{said}{}", text(&out.stderr));
    let log = fs::read_to_string(log).unwrap();
    let line = r#"{"cells":80,"event":"warning","message":"mu(I) is ill-posed","time":10.0,"#;
    assert_eq!(log.matches(line).count(), 1, "{log}");
}

#[test]
fn a_case_is_validated_and_reported_on() {
    let here = tempfile::tempdir().unwrap();
    let out = granflow(&["validate", "bagnold", "-o", "out"]).current_dir(here.path()).output();
    let out = out.unwrap();
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{said}{}", text(&out.stderr));
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[1].starts_with("bagnold ") && lines[1].ends_with(" pass"), "{said}");
    assert_eq!(lines.last(), Some(&"report  out/report.md"));
    let report = fs::read_to_string(here.path().join("out/report.md")).unwrap();
    assert!(report.contains("## bagnold") && report.contains("| pass |"), "{report}");
    assert!(here.path().join("out/bagnold_velocity.png").is_file());
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1, "the scratch is elsewhere");
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let mut child =
        granflow(&["list"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let out = child.wait_with_output().unwrap();
    assert_eq!((out.status.code(), text(&out.stderr)), (Some(0), String::new()));
}

#[test]
fn lists_are_json_for_programs() {
    for what in ["rheologies", "conditions", "waves", "schemes", "solvers", "functions", "cases"] {
        let out = granflow(&["list", "--json", what]).output().unwrap();
        let all: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
        for entry in all.as_array().unwrap() {
            for key in ["name", "summary", "reference"] {
                assert!(entry[key].as_str().is_some_and(|t| !t.is_empty()), "{what}: {entry}");
            }
            let name = entry["name"].as_str().unwrap();
            let plain = granflow(&["list", what]).output().unwrap();
            assert!(text(&plain.stdout).contains(name), "{name}");
        }
        if what == "rheologies" {
            let formula = |e: &&serde_json::Value| e["formula"].as_str().is_some();
            let all = all.as_array().unwrap();
            assert_eq!(all.iter().filter(formula).count(), all.len());
        }
    }
}

#[test]
fn every_built_in_case_is_written_and_sound_and_not_overwritten() {
    let out = granflow(&["list", "--json", "cases"]).output().unwrap();
    let all: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let here = tempfile::tempdir().unwrap();
    for entry in all.as_array().unwrap() {
        let name = entry["name"].as_str().unwrap();
        let new = |dir: &[&str]| {
            let args = [&["new", name], dir].concat();
            granflow(&args).current_dir(here.path()).output().unwrap()
        };
        assert_eq!(new(&[]).status.code(), Some(0), "{name}");
        assert_eq!(new(&[]).status.code(), Some(2), "{name} exists");
        let other = format!("deep/er/{name}");
        assert_eq!(new(&[&other]).status.code(), Some(0), "{name}");
        let check = granflow(&["check", name]).current_dir(here.path()).output().unwrap();
        assert_eq!(check.status.code(), Some(0), "{name}: {}", text(&check.stderr));
    }
}

#[test]
fn the_built_in_cavity_runs() {
    let here = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| granflow(args).current_dir(here.path()).output().unwrap();
    assert_eq!(run(&["new", "cavity", "c"]).status.code(), Some(0));
    let control = fs::read_to_string(here.path().join("c/system/controlDict")).unwrap();
    let dt = control.lines().find_map(|l| l.trim().strip_prefix("deltaT")).unwrap();
    let dt: f64 = dt.trim().trim_end_matches(';').trim().parse().unwrap();
    let out = run(&["run", "c", "--until", &(2.0 * dt).to_string()]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(PathBuf::from(here.path()).join("c/log.jsonl").is_file());
}

#[test]
fn one_thread_and_three_write_the_same_bytes() {
    let (one, three) = (ring(), ring());
    assert!(one.run(&["run", "-j", "1"]).status.success());
    assert!(three.run(&["run", "-j", "3"]).status.success());
    for file in ["0.3/U", "0.3/p", "0.3/phi", "0.3/fluidity", "0.3/viscosity"] {
        assert_eq!(one.read(file), three.read(file), "{file}");
    }
}
