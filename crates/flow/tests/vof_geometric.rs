//! Shapes carried by known flows, geometric method: shape error, bounds, volume.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_flow::vof::{GeometricParams, Params, Reconstruct, Shape};
use granflow_mesh::{PatchKind, shapes};
use granflow_par::{Exec, Solo};
use std::f64::consts::PI;
use vof_common::*;

fn by(reconstruction: Reconstruct) -> Params {
    Params::Geometric(GeometricParams { reconstruction, ..GeometricParams::default() })
}

const ALL: [Reconstruct; 3] = [Reconstruct::IsoAlpha, Reconstruct::GradAlpha, Reconstruct::PlicRdf];

fn bench(n: usize) {
    for r in ALL {
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, n, |_| 1.0);
        println!("{}", run.line(&format!("disc, square {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), triangles(n), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, 2 * n, |_| 1.0);
        println!("{}", run.line(&format!("disc, triangle {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), rotation())
            .start(&slotted());
        let exact = run.exact(&slotted());
        run.go(1.0, 8 * n, |_| 1.0);
        println!("{}", run.line(&format!("slotted, square {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), vortex())
            .start(&[(1.0, disc(0.5, 0.75, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.5, 0.75, 0.15))]);
        run.go(8.0, 16 * n, |t| (PI * t / 8.0).cos());
        println!("{}", run.line(&format!("vortex, square {n}, {r:?}"), run.error(&exact)));
    }
}

#[test]
#[ignore = "tables"]
fn tables_2d() {
    for n in [32, 64, 128] {
        bench(n);
    }
}

#[test]
#[ignore = "tables"]
fn tables_3d() {
    for n in [32, 64] {
        for r in ALL {
            let ball = Shape::sphere([0.35; 3], 0.15);
            let mut run = Run::new(Exec::new(2, Box::new(Solo)), shapes::unit_box([n; 3]), &by(r), deformation)
                .start(&[(1.0, ball.clone())]);
            let exact = run.exact(&[(1.0, ball)]);
            run.go(3.0, 12 * n, |t| (PI * t / 3.0).cos());
            println!("{}", run.line(&format!("sphere, {n}, {r:?}"), run.error(&exact)));
        }
    }
}

#[test]
fn smoke() {
    bench(32);
}
