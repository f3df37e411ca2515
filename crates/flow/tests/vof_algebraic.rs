//! Shapes carried by known flows, algebraic method: shape error, bounds, volume.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_flow::vof::{AlgebraicParams, Params};
use granflow_mesh::PatchKind;
use granflow_par::Exec;
use std::f64::consts::PI;
use vof_common::*;

#[test]
#[ignore = "tables"]
fn tables() {
    let d = AlgebraicParams::default;
    for (name, p, few) in [
        ("default", d(), 1),
        ("3 sub-cycles", AlgebraicParams { n_alpha_sub_cycles: 3, ..d() }, 1),
        ("2 correctors", AlgebraicParams { n_alpha_corr: 2, ..d() }, 1),
        ("MULESCorr", AlgebraicParams { mules_corr: true, n_alpha_corr: 2, ..d() }, 1),
        ("MULESCorr big steps", AlgebraicParams { mules_corr: true, n_alpha_corr: 2, ..d() }, 8),
        ("no compression", AlgebraicParams { c_alpha: 0.0, ..d() }, 1),
        ("icAlpha 0.1", AlgebraicParams { ic_alpha: 0.1, ..d() }, 1),
        ("1 pass", AlgebraicParams { n_limiter_iter: 1, ..d() }, 1),
    ] {
        for n in [32, 64] {
            let p = Params::Algebraic(p.clone());
            for poly in [square(n, PatchKind::Patch), triangles(n)] {
                let k = 4 / few.min(4) * if poly.n_cells() > n * n { 2 } else { 1 };
                let mut run = Run::new(Exec::serial(), poly, &p, uniform([1.0, 0.5, 0.0]))
                    .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
                let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
                run.go(0.5, (k * n / few.max(4) * 4).max(4), |_| 1.0);
                println!("{}", run.line(&format!("disc {n}, {name}"), run.error(&exact)));
            }
            let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &p, rotation())
                .start(&slotted());
            let exact = run.exact(&slotted());
            run.go(1.0, 16 * n / few, |_| 1.0);
            println!("{}", run.line(&format!("slotted {n}, {name}"), run.error(&exact)));
            let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &p, vortex())
                .start(&[(1.0, disc(0.5, 0.75, 0.15))]);
            let exact = run.exact(&[(1.0, disc(0.5, 0.75, 0.15))]);
            run.go(8.0, 32 * n / few, |t| (PI * t / 8.0).cos());
            println!("{}", run.line(&format!("vortex {n}, {name}"), run.error(&exact)));
        }
    }
}
