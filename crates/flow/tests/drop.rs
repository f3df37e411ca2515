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
    let shape = Shape::cylinder([0.5, 0.5, 0.0], [0.0, 0.0, 1.0], 0.25);
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
            let d = sub(m.cell_centre[c], [0.5, 0.5, m.cell_centre[c][2]]);
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
    for (n, la, share) in [(24, 12000.0, 0.8), (32, 12000.0, 0.8)] {
        let mut flow = drop(n, true, la);
        let h = 1.0 / n as f64;
        let dt = share * (h.powi(3) / std::f64::consts::TAU).sqrt();
        let steps = (2.0 / dt).ceil() as usize;
        print!("n {n} La {la} dt {share}:");
        let mut next = 0.0;
        for i in 0..steps {
            flow.step(dt).expect("a step");
            if i as f64 * dt >= next {
                next += 0.25;
                print!(" {:.1e}/{:.1e}", jump(&flow) - 1.0, fastest(&flow) * 0.5f64.sqrt());
            }
        }
        println!();
        let a = alpha(&flow);
        let mut v: Vec<(f64, usize)> = (0..flow.mesh.n_cells).map(|c| (granflow_base::norm(flow.state.u.cells.data[c]), c)).collect();
        v.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (u, c) in &v[..6] {
            let d = sub(flow.mesh.cell_centre[*c], [0.5, 0.5, 0.0]);
            println!("   u {u:.2e} {:?} at r/R {:.2} angle {:.0} alpha {:.3}", flow.state.u.cells.data[*c].map(|x| (x / u * 100.0).round() / 100.0), (d[0].hypot(d[1])) / 0.25, d[1].atan2(d[0]).to_degrees(), a[*c]);
        }
    }
}
