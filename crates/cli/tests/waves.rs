//! Waves through the command: they are what theory says at a probe, restarts change no bit, ranks
//! agree.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{Case, flume, text};
use granflow_case::{Event, Notices, Options, Run};
use granflow_dict::Sink;
use std::f64::consts::{PI, TAU};

const CONTROL: &str = "system/controlDict";
const WAVES: &str = "constant/waveProperties";

fn ran(case: &Case, args: &[&str]) {
    let run = case.run(args);
    assert!(run.status.success(), "{}", text(&run.stderr));
}

/// The flume for 0.2 s, with more water than still at the outlet to be let out.
fn short() -> Case {
    flume()
        .edit(CONTROL, "endTime         4.5;", "endTime         0.2;")
        .edit(CONTROL, "writeInterval   0.1875;", "writeInterval   0.1;")
        .edit(CONTROL, "writePrecision  12;", "")
        .edit(WAVES, "rampTime        1.5;", "rampTime        0.1;")
}

fn cells(field: &str) -> Vec<f64> {
    let inside = field.split("boundaryField").next().unwrap();
    inside.lines().filter_map(|l| l.trim().parse().ok()).skip(1).collect()
}

/// Depth of the water in the columns of cells, m.
fn depths(case: &Case, time: &str) -> Vec<f64> {
    let alpha = cells(&case.read(&format!("{time}/alpha.water")));
    assert_eq!(alpha.len(), 80 * 30);
    (0..80).map(|i| (0..30).map(|k| 0.02 * alpha[i + 80 * k]).sum()).collect()
}

/// Where dispersion and reflection have not yet had a chance, a small wave is `H/2 cos(k x - omega t +
/// phase)` with `omega^2 = g k tanh(k h)`.
#[test]
fn a_stokes_wave_passes_a_probe_as_high_as_it_should() {
    let case = flume();
    ran(&case, &["run", "-q"]);
    let (height, omega) = (0.04, TAU / 1.5);
    let (mut low, mut high) = (0.1, 100.0);
    for _ in 0..60 {
        let k: f64 = 0.5 * (low + high);
        if 9.81 * k * (0.4 * k).tanh() < omega * omega { low = k } else { high = k }
    }
    let (mut off, mut extent) = (0.0f64, [f64::MAX, f64::MIN]);
    for i in 17..=24 {
        let t = 0.1875 * f64::from(i);
        // The column from 0.95 to 1 m.
        let risen = depths(&case, &format!("{t}"))[19] - 0.4;
        let theory = 0.5 * height * (low * 0.975 - omega * t + 1.5 * PI).cos();
        off = off.max((risen - theory).abs());
        extent = [extent[0].min(risen), extent[1].max(risen)];
    }
    assert!(off < 0.1 * height, "{off} of {height}");
    let found = extent[1] - extent[0];
    assert!((found / height - 1.0).abs() < 0.1, "{found}");
}

#[test]
fn a_restart_repeats_waves_to_the_bit() {
    for application in ["interFoam", "interIsoFoam"] {
        let case = || short().edit(CONTROL, "interFoam", application);
        let whole = case();
        ran(&whole, &["run", "-j", "1"]);
        let halves = case();
        ran(&halves, &["run", "-j", "1", "--until", "0.1"]);
        ran(&halves, &["run", "-j", "3", "--share", "1"]);
        let uniform = "0.2/uniform/waveProperties.inlet";
        for file in ["0.2/U", "0.2/p_rgh", "0.2/alpha.water", "0.2/phi", uniform] {
            assert_eq!(whole.read(file), halves.read(file), "{application}: {file}");
        }
        // Still water is as deep as it was in the beginning, though the surface has moved.
        let text = whole.read(uniform);
        let depth = text.split("waterDepthRef").nth(1).unwrap().split(';').next().unwrap();
        assert!((depth.trim().parse::<f64>().unwrap() - 0.4).abs() < 1e-12, "{text}");
        assert!((depths(&whole, "0.2")[0] - 0.4).abs() > 1e-3);
    }
}

/// The inlet has faces on several ranks, one paddle has faces on two of them.
#[test]
fn ranks_agree_with_one() {
    let run = |ranks: usize| {
        let case = short()
            .edit("system/blockMeshDict", "(80 1 30)", "(4 12 15)")
            .edit("system/blockMeshDict", "(4 0 0) (4 0.1 0) (0 0.1 0)", "(1 0 0) (1 4 0) (0 4 0)")
            .edit(
                "system/blockMeshDict",
                "(4 0 0.6) (4 0.1 0.6) (0 0.1 0.6)",
                "(1 0 0.6) (1 4 0.6) (0 4 0.6)",
            )
            .edit("system/blockMeshDict", "sides  { type empty;", "sides  { type wall;")
            .edit("system/setFieldsDict", "(4 1 0.4)", "(4 4 0.4)")
            .edit("system/fvSolution", "tolerance 1e-8; relTol 0.01", "tolerance 1e-12; relTol 0")
            .edit(WAVES, "waveAngle       0;", "waveAngle       20;")
            .edit(
                WAVES,
                "waveModel       StokesI;\n    nPaddle         1;",
                "waveModel StokesI; nPaddle 5;",
            )
            .edit("0.orig/U", "sides  { type empty; }", "sides  { type slip; }")
            .edit("0.orig/alpha.water", "sides  { type empty; }", "sides  { type zeroGradient; }")
            .edit("0.orig/p_rgh", "sides  { type empty; }", "sides { type fixedFluxPressure; }");
        ran(&case, &["init"]);
        let options = Options { ranks, ..Options::default() };
        let mut run = Run::load(case.path(), &options, &Sink::new(), &Notices::new()).unwrap();
        while !matches!(run.advance().unwrap(), Event::Done(_)) {}
        ["0/alpha.water", "0.2/alpha.water"].map(|field| cells(&case.read(field)))
    };
    let ([first, one], [_, three]) = (run(1), run(3));
    assert_eq!(one.len(), 4 * 12 * 15);
    let apart = one.iter().zip(&three).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart:e}");
    let moved = one.iter().zip(&first).filter(|(a, b)| (*a - *b).abs() > 0.01).count();
    assert!(moved > 24, "{moved}: the surface has moved");
}
