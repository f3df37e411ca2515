//! Cases that compute: from dictionaries to time directories and back.
#![allow(clippy::unwrap_used)]

mod common;
use common::*;

#[test]
fn a_cavity_runs_and_writes() {
    let dir = cavity_case(8);
    let run = run(dir.path(), &until(0.1));
    assert!((run.time() - 0.1).abs() < 1e-12);
    let u = read(dir.path(), "0.1/U");
    assert!(u.contains("nonuniform List<vector>"), "{u}");
    assert!(u.contains("noSlip"), "{u}");
    for f in ["0.05/U", "0.1/p", "0.1/phi", "0.1/strainRate", "0.1/viscosity", "0.1/uniform/time"] {
        assert!(dir.path().join(f).exists(), "{f}");
    }
}

#[test]
fn restart_is_exact_to_the_last_bit() {
    let whole = cavity_case(8);
    run(whole.path(), &until(0.1));
    let halves = copy(whole.path());
    run(halves.path(), &until(0.05));
    run(halves.path(), &until(0.1));
    assert_same(whole.path(), halves.path(), "0.1");
}

const RING_CONTROL: &str = "application granflow; startFrom latestTime; endTime 4e-3; deltaT 1e-3;
writeControl timeStep; writeInterval 2; functions { gap { type profile; start (0.0511 0 5e-4);
end (0.0629 0 5e-4); fields (U fluidity stressRatio); } }\n";
const RING_SOLUTION: &str = "PIMPLE { pRefPoint (0.055 0 5e-4); pRefValue 1000; }\n";
const BEADS: &str = "transportModel NGF; rho 1519;
NGFCoeffs { mus 0.3819; mu2 0.6435; I0 0.279; A 0.48; d 0.75e-3; rhos 2450; form steady; }\n";
const RING_U: &str = "dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0);
boundaryField
{
    inner { type rotatingWallVelocity; origin (0 0 0); axis (0 0 1); omega 0.02; }
    outer { type noSlip; }
    \"(bottom|top)\" { type slip; }
    minus { type wedge; }
    plus { type wedge; }
}\n";
const RING_P: &str = "dimensions [1 -1 -2 0 0 0 0]; internalField uniform 1000;
boundaryField { \"(inner|outer|bottom|top)\" { type zeroGradient; } wedge { type wedge; } }\n";

fn ring_case() -> tempfile::TempDir {
    let poly = granflow_mesh::shapes::wedge_ring(0.051, 0.063, 1e-3, 24, 1, 0.01);
    case(
        &[
            ("system/controlDict", RING_CONTROL),
            ("system/fvSolution", RING_SOLUTION),
            ("constant/transportProperties", BEADS),
            ("0/U", RING_U),
            ("0/p", RING_P),
        ],
        Some(&poly),
    )
}

#[test]
fn grains_in_a_ring_shear_next_to_the_wall_that_turns() {
    let dir = ring_case();
    run(dir.path(), &until(2e-3));
    let table = granflow_case::figures::table::Table::parse(&read(
        dir.path(),
        "postProcessing/gap/0.002/gap_U_fluidity_stressRatio.xy",
    ));
    let u = &table.columns[table.column("U_y").unwrap()];
    let wall = 0.02 * 0.051;
    assert!(u[0] > 0.5 * wall && u[0] < wall, "{u:?}");
    assert!(u[u.len() - 1].abs() < 1e-2 * wall, "{u:?}");
    let g = &table.columns[table.column("fluidity").unwrap()];
    assert!(g.iter().all(|g| *g > 0.0));
    for f in ["fluidity", "stressRatio", "inertialNumber"] {
        assert!(dir.path().join("0.002").join(f).exists(), "{f}");
    }
}

#[test]
fn restart_of_nonlocal_grains_is_exact_to_the_last_bit() {
    let whole = ring_case();
    run(whole.path(), &until(4e-3));
    let halves = copy(whole.path());
    run(halves.path(), &until(2e-3));
    run(halves.path(), &until(4e-3));
    assert_same(whole.path(), halves.path(), "0.004");
}

#[test]
fn restart_with_backward_differences_kinematic_pressure_and_adjusted_steps() {
    let dir = cavity_case(6);
    put(dir.path(), "system/fvSchemes", "ddtSchemes { default backward; }\n");
    put(
        dir.path(),
        "constant/transportProperties",
        "transportModel Newtonian; nu 0.01; rho 1.3;\n",
    );
    put(
        dir.path(),
        "system/controlDict",
        "endTime 0.1; deltaT 1e-3; adjustTimeStep yes; maxCo 0.3; writeControl adjustableRunTime;
         writeInterval 0.05; writeFormat binary; writeCompression on;",
    );
    run(dir.path(), &until(0.1));
    let halves = copy(dir.path());
    run(halves.path(), &until(0.05));
    assert!(halves.path().join("0.05/U_0.gz").exists());
    run(halves.path(), &until(0.1));
    assert_same(dir.path(), halves.path(), "0.1");
}

#[test]
fn three_ranks_agree_with_one() {
    let (one, three) = (cavity_case(9), cavity_case(9));
    let control = "endTime 0.05; deltaT 0.01; functions { forces { type forces; patches (yMax); }
        line { type sets; fields (U p); interpolationScheme cell; sets ( mid { type midPoint;
        axis y; start (0.5 0 0.05); end (0.5 1 0.05); } ); } here { type probes; fields (U);
        probeLocations ((0.5 0.5 0.05)); } }";
    let solution =
        "solvers { \"(U|p)\" { solver PBiCGStab; preconditioner DILU; tolerance 1e-13; } }";
    for dir in [&one, &three] {
        put(dir.path(), "system/controlDict", control);
        put(dir.path(), "system/fvSolution", solution);
    }
    run(one.path(), &until(0.05));
    run(three.path(), &granflow_case::Options { ranks: 3, ..until(0.05) });
    let files = [
        "0.05/U",
        "0.05/p",
        "0.05/phi",
        "postProcessing/forces/0/force.dat",
        "postProcessing/here/0/U",
        "postProcessing/line/0.05/mid_U_p.xy",
    ];
    for f in files {
        let numbers = |root: &std::path::Path| -> Vec<f64> {
            let text = read(root, f).replace(['(', ')', ';'], " ");
            text.split_whitespace().filter_map(|w| w.parse().ok()).collect()
        };
        let (a, b) = (numbers(one.path()), numbers(three.path()));
        assert_eq!(a.len(), b.len(), "{f}");
        assert!(a.len() > 8, "{f}");
        let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let off = a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-8 * size, "{f}: {off:e} of {size:e}");
    }
}

#[test]
fn a_stop_flag_writes_and_stops() {
    use granflow_case::{End, Event, Notices, Options, Run};
    use std::sync::atomic::Ordering;
    let dir = cavity_case(4);
    let options = Options::default();
    let sink = granflow_dict::Sink::new();
    let mut run = Run::load(dir.path(), &options, &sink, &Notices::new()).unwrap();
    let Event::Step(step) = run.advance().unwrap() else { panic!("a step") };
    assert_eq!((step.wrote, step.step), (None, 1));
    assert!(step.progress > 0.0 && step.left.is_some());
    options.stop.store(true, Ordering::Relaxed);
    assert!(matches!(run.advance().unwrap(), Event::Done(End::Stopped)));
    assert!(dir.path().join("0.01/U").exists());
}

#[test]
fn a_failed_step_leaves_the_state_before_it() {
    let dir = cavity_case(4);
    let u = CAVITY_U.replace("uniform (1 0 0)", "uniform (1 0 0); } ");
    let u = u.replace(
        "type fixedValue; value uniform (1 0 0); } ;",
        "type uniformFixedValue; \
        uniformValue table ((0 (1 0 0)) (0.025 (1 0 0)) (0.03 (1e200 0 0)));",
    );
    put(dir.path(), "0/U", &u);
    let (sink, notices) = (granflow_dict::Sink::new(), granflow_case::Notices::new());
    let result = try_run(dir.path(), &until(0.1), &sink, &notices);
    match result {
        Err(granflow_case::CaseError::Step { kept, .. }) => {
            assert_eq!(kept.as_deref(), Some("0.02"));
            assert!(!read(dir.path(), "0.02/U").contains("nan"));
            assert!(read(dir.path(), "log.jsonl").contains("\"event\":\"error\""));
        }
        Err(e) => panic!("{e} {}", sink.take()),
        Ok(_) => panic!("a velocity of 1e200 should fail"),
    }
}

/// The lid is mad at 0.025 s, where a step of the longest length ends: shorter ones pass it by.
#[test]
fn an_adjusted_step_that_fails_is_taken_again_shorter() {
    let dir = cavity_case(4);
    let lid = "type uniformFixedValue; uniformValue table ((0 (1 0 0)) (0.02499 (1 0 0)) \
               (0.025 (1e200 0 0)) (0.02501 (1 0 0)) (1 (1 0 0)));";
    put(dir.path(), "0/U", &CAVITY_U.replace("type fixedValue; value uniform (1 0 0);", lid));
    let (sink, notices) = (granflow_dict::Sink::new(), granflow_case::Notices::new());
    let adjusted = "adjustTimeStep yes; maxCo 1000; maxDeltaT 0.005;";
    put(dir.path(), "system/controlDict", &format!("{CONTROL} {adjusted}"));
    let run = try_run(dir.path(), &until(0.05), &sink, &notices).unwrap();
    assert!((run.time() - 0.05).abs() < 1e-12 && run.flow().state.step > 10);
    let log = read(dir.path(), "log.jsonl");
    let again: Vec<&str> = log.lines().filter(|l| l.contains("\"again\":0.00125")).collect();
    assert_eq!(again.len(), 1, "{log}");
    assert!(again[0].contains("\"dt\":0.005"), "{}", again[0]);
}

#[test]
fn a_case_without_a_mesh_makes_it_and_starts_from_0_orig() {
    let dir = cavity_case(4);
    std::fs::remove_dir_all(dir.path().join("constant/polyMesh")).unwrap();
    std::fs::rename(dir.path().join("0"), dir.path().join("0.orig")).unwrap();
    put(
        dir.path(),
        "system/blockMeshDict",
        "convertToMeters 0.1;
         vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 0.1) (1 0 0.1) (1 1 0.1) (0 1 0.1));
         blocks (hex (0 1 2 3 4 5 6 7) (5 5 1) simpleGrading (1 1 1));
         boundary
         (
             yMax { type wall; faces ((3 7 6 2)); }
             xAll { type wall; faces ((0 4 7 3) (2 6 5 1)); }
             yMin { type wall; faces ((1 5 4 0)); }
             zAll { type empty; faces ((0 3 2 1) (4 5 6 7)); }
         );",
    );
    let run = run(dir.path(), &until(0.05));
    assert_eq!(run.flow().mesh.n_cells, 25);
    assert!(dir.path().join("constant/polyMesh/owner").exists());
    assert!(dir.path().join("0.orig/U").exists() && dir.path().join("0.05/U").exists());
}
