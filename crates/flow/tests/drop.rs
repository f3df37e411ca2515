//! Drops at rest under surface tension.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod two_common;

use granflow_base::{dot, sub};
use granflow_flow::Flow;
use granflow_flow::vof::Shape;
use two_common::*;

/// A drop of radius 0.25 in the unit square with slip walls, `n` cells a side.
fn drop(n: usize, geometric: bool, la: f64) -> Flow {
    let poly = tank([n, n], [0.0; 2], [1.0; 2]);
    let shape = Shape::cylinder([0.507, 0.496, 0.0], [0.0, 0.0, 1.0], 0.25);
    let mut two = water_and_air(&poly, shape);
    // Laplace number rho sigma D/eta^2.
    let eta = (0.5 / la).sqrt();
    (two.gravity, two.rho, two.eta, two.sigma) = ([0.0; 3], [1.0; 2], [eta; 2], 1.0);
    two.geometric = geometric;
    two.flow(|_| slip())
}

/// Mean pressure within half the radius less that beyond one and a half, over sigma/R.
fn jump(flow: &Flow) -> f64 {
    let m = &flow.mesh;
    let mean = |inside: bool| {
        let (mut sum, mut n) = (0.0, 0.0);
        for c in 0..m.n_cells {
            let d = sub(m.cell_centre[c], [0.507, 0.496, m.cell_centre[c][2]]);
            let r = dot(d, d).sqrt();
            if (inside && r < 0.125) || (!inside && r > 0.375) {
                sum += flow.state.p.cells.data[c];
                n += 1.0;
            }
        }
        sum / n
    };
    (mean(true) - mean(false)) * 0.25
}

#[test]
#[ignore]
fn table() {
    for geometric in [true, false] {
        for n in [16, 32, 64] {
            let mut flow = drop(n, geometric, 12000.0);
            // Brackbill's limit: sqrt(rho h^3/(2 pi sigma)) with the mean density.
            let h = 1.0 / n as f64;
            let dt = 0.5 * (h.powi(3) / std::f64::consts::TAU).sqrt();
            // Time in D^2/nu... capillary time sqrt(rho D^3/sigma) = 0.354.
            let end = 4.0;
            let steps = (end / dt).ceil() as usize;
            let clock = std::time::Instant::now();
            flow.step(dt).expect("a step");
            println!("geometric {geometric} n {n} jump-1 {:.2e}", jump(&flow) - 1.0);
            let mut next = 0.0;
            for i in 1..steps {
                flow.step(dt).expect("a step");
                if i as f64 * dt > next {
                    next += 0.5;
                    // U* = u sqrt(rho D/sigma).
                    println!("   t {:.3} jump-1 {:.2e} U {:.2e}", i as f64 * dt, jump(&flow) - 1.0, fastest(&flow) * 0.5f64.sqrt());
                }
            }
            println!("   {:.2} s, {} steps", clock.elapsed().as_secs_f64(), steps);
        }
    }
}
