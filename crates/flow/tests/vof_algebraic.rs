//! Shapes carried by known flows, algebraic method: shape error, bounds, volume.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_flow::vof::{AlgebraicParams, Params, Shape};
use granflow_mesh::{PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use std::f64::consts::PI;
use vof_common::*;

fn variants() -> [(&'static str, AlgebraicParams); 6] {
    let d = AlgebraicParams::default;
    [
        ("default", d()),
        ("3 sub-cycles", AlgebraicParams { n_alpha_sub_cycles: 3, ..d() }),
        ("2 correctors", AlgebraicParams { n_alpha_corr: 2, ..d() }),
        ("MULESCorr", AlgebraicParams { mules_corr: true, n_alpha_corr: 2, ..d() }),
        ("no compression", AlgebraicParams { c_alpha: 0.0, ..d() }),
        ("icAlpha 0.1", AlgebraicParams { ic_alpha: 0.1, ..d() }),
    ]
}

fn disc_in_flow(poly: PolyMesh, p: &AlgebraicParams, steps: usize) -> (Run, f64) {
    let p = Params::Algebraic(p.clone());
    let mut run = Run::new(Exec::serial(), poly, &p, uniform([1.0, 0.5, 0.0]))
        .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
    let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
    run.go(0.5, steps, |_| 1.0);
    let e = run.error(&exact);
    (run, e)
}

/// What left through the boundary is in the balance of every step.
fn sound(run: &Run, what: &str, e: f64, limit: f64) {
    println!("{}", run.line(what, e));
    assert!(e < limit, "{what}: {e}");
    assert!(run.beyond < 1e-8, "{what}: beyond bounds by {}", run.beyond);
    assert!(run.volume_error < 1e-13 * run.steps.max(10) as f64 / 10.0, "{what}: volume");
}

#[test]
fn disc_in_constant_flow() {
    for (name, p) in variants() {
        let limit = if p.c_alpha > 0.0 { 0.2 } else { 0.35 };
        let (run, e) = disc_in_flow(square(32, PatchKind::Patch), &p, 128);
        sound(&run, &format!("disc, squares 32, {name}"), e, limit);
        let (run, e) = disc_in_flow(triangles(32), &p, 256);
        sound(&run, &format!("disc, triangles 32, {name}"), e, limit);
    }
}

/// Courant number 3: only the implicit predictor stays within bounds.
#[test]
fn big_steps_stay_within_bounds() {
    let p = AlgebraicParams { mules_corr: true, n_alpha_corr: 2, ..AlgebraicParams::default() };
    for poly in [square(32, PatchKind::Patch), triangles(32)] {
        let (run, e) = disc_in_flow(poly, &p, 8);
        assert!(run.courant > 2.0);
        sound(&run, "disc in big steps", e, 1.0);
    }
}

#[test]
fn sphere_through_the_corner_of_a_periodic_box() {
    let poly = shapes::displaced(&shapes::periodic_box([14; 3], [true; 3]), 0.2, 5);
    let start = [(1.0, Shape::sphere([0.5; 3], 0.3))];
    let p = Params::Algebraic(AlgebraicParams { n_alpha_corr: 2, ..AlgebraicParams::default() });
    let mut run = Run::new(Exec::serial(), poly, &p, uniform([1.0; 3])).start(&start);
    let exact = run.exact(&start);
    run.go(1.0, 112, |_| 1.0);
    let e = run.error(&exact);
    sound(&run, "sphere, periodic, warped 14", e, 0.5);
    assert!(run.drift() < 1e-13, "volume drifts by {}", run.drift());
}

#[test]
fn inflow_and_outflow() {
    for (name, p) in variants() {
        let p = Params::Algebraic(p);
        let poly = square(24, PatchKind::Patch);
        let mut run = Run::new(Exec::serial(), poly, &p, uniform([1.0, 0.3, 0.0]))
            .start(&[(1.0, Shape::half_space([1.0, 0.2, 0.0], [0.4, 0.5, 0.0]))]);
        let report = run.go(1.5, 160, |_| 1.0);
        println!("{}", run.line(&format!("filling, {name}"), 0.0));
        assert!(run.beyond < 1e-8 && run.volume_error < 1e-12);
        assert!((report.volume * 24.0 - 1.0).abs() < 1e-3, "{}", report.volume);
    }
}

#[test]
#[ignore = "minutes; prints tables"]
fn tables() {
    for (name, p) in variants() {
        for n in [32, 64, 128] {
            for (what, poly, k) in
                [("squares", square(n, PatchKind::Patch), 4), ("triangles", triangles(n), 8)]
            {
                let (run, e) = disc_in_flow(poly, &p, k * n);
                println!("{}", run.line(&format!("disc, {what} {n}, {name}"), e));
            }
            let (poly, q) = (square(n, PatchKind::Patch), Params::Algebraic(p.clone()));
            let mut run = Run::new(Exec::serial(), poly.clone(), &q, rotation()).start(&slotted());
            let exact = run.exact(&slotted());
            run.go(1.0, 16 * n, |_| 1.0);
            println!("{}", run.line(&format!("slotted {n}, {name}"), run.error(&exact)));
            let start = [(1.0, disc(0.5, 0.75, 0.15))];
            let mut run = Run::new(Exec::serial(), poly, &q, vortex()).start(&start);
            let exact = run.exact(&start);
            run.go(8.0, 32 * n, |t| (PI * t / 8.0).cos());
            println!("{}", run.line(&format!("vortex {n}, {name}"), run.error(&exact)));
        }
    }
}
