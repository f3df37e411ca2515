//! Steps with two fluids in time: order, and what they leave as it is.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod two_common;

use granflow_base::{dot, norm, sub};
use granflow_flow::vof::{AlgebraicParams, Params, Shape, Vof};
use granflow_flow::{Flow, TimeScheme};
use granflow_mesh::shapes;
use std::f64::consts::PI;
use two_common::*;

const EULER: TimeScheme = TimeScheme::Euler;
const CRANK_NICOLSON: TimeScheme = TimeScheme::CrankNicolson(1.0);

/// A mixture that is heavier below swings in a box with slip walls: an internal wave. Fractions are smooth, and
/// swing so little that what their transport leaves in time, of second order in the swing, is not seen.
fn internal_wave(ddt: TimeScheme) -> Flow {
    let poly = tank([8, 8], [0.0; 2], [1.0; 2]);
    let mut two = water_and_air(&poly, Shape::half_space([0.0, 1.0, 0.0], [0.0, 0.5, 0.0]));
    (two.gravity, two.rho, two.eta) = ([0.0, -10.0, 0.0], [2.0, 1.0], [0.04, 0.01]);
    (two.numerics.ddt, two.numerics.correctors) = (ddt, 5);
    let mut flow = two.flow(|_| slip());
    let plain = AlgebraicParams { c_alpha: 0.0, ..AlgebraicParams::default() };
    let method = Vof::new(&flow.exec, &poly, &flow.mesh, &Params::Algebraic(plain));
    flow.two_phase.as_mut().expect("two fluids").vof = method.expect("a method");
    let alpha = flow.state.alpha.as_mut().expect("two fluids");
    for (a, x) in alpha.cells.data.iter_mut().zip(&flow.mesh.cell_centre) {
        *a = 0.5 + 0.3 * (PI * x[1]).cos() + 1e-5 * (PI * x[0]).cos() * (PI * x[1]).sin();
    }
    flow
}

/// A sharp interface between two unlike fluids that leans, and swings by surface tension.
fn capillary_wave(ddt: TimeScheme) -> Flow {
    let poly = tank([8, 16], [0.0; 2], [0.5, 1.0]);
    let mut two = water_and_air(&poly, Shape::half_space([0.15, 1.0, 0.0], [0.25, 0.5, 0.0]));
    (two.gravity, two.rho, two.eta) = ([0.0; 3], [2.0, 1.0], [0.04, 0.01]);
    (two.sigma, two.geometric) = (1.0, true);
    (two.numerics.ddt, two.numerics.correctors) = (ddt, 5);
    two.flow(|_| slip())
}

type Make = fn(TimeScheme) -> Flow;

fn after((make, ddt): (Make, TimeScheme), end: f64, steps: usize) -> Flow {
    let mut flow = make(ddt);
    for _ in 0..steps {
        flow.step(end / steps as f64).expect("a step");
    }
    flow
}

/// Root mean square over the cells of the differences of velocity and of fraction.
fn apart(a: &Flow, b: &Flow) -> [f64; 2] {
    let n = a.mesh.n_cells;
    let u = |f: &Flow, c: usize| f.state.u.cells.data[c];
    let d_u = (0..n).map(|c| norm(sub(u(a, c), u(b, c))).powi(2)).sum::<f64>();
    let d_a = (0..n).map(|c| (alpha(a)[c] - alpha(b)[c]).powi(2)).sum::<f64>();
    [d_u, d_a].map(|s| (s / n as f64).sqrt())
}

/// What `steps` and twice as many are off the same scheme with very short ones, over what has moved.
fn errors(of: (Make, TimeScheme), end: f64, steps: usize) -> [[f64; 2]; 2] {
    let limit = after(of, end, 64 * steps);
    let moved = apart(&limit, &of.0(of.1));
    let all = [1, 2].map(|k| {
        let off = apart(&after(of, end, k * steps), &limit);
        [off[0] / moved[0], off[1] / moved[1]]
    });
    println!(
        "{:?}: {:.1e} {:.1e}, {:.1e} {:.1e}",
        of.1, all[0][0], all[0][1], all[1][0], all[1][1]
    );
    all
}

/// What is left with Crank-Nicolson falls by the square of the step at first and in proportion to it in the end: the
/// transport of the fraction leaves a share of first order, here a thirtieth of Euler's error and less.
#[test]
fn crank_nicolson_is_nearer_than_euler_by_far() {
    let of = |ddt| errors((internal_wave, ddt), 0.7, 20);
    let (euler, second) = (of(EULER), of(CRANK_NICOLSON));
    let order = (euler[0][1] / euler[1][1]).log2();
    assert!((order - 1.0).abs() < 0.1, "Euler: {order:.2}");
    for k in 0..2 {
        assert!(second[k][0] < euler[k][0], "velocity: {second:?} {euler:?}");
        assert!(second[k][1] < euler[k][1] / 30.0, "fraction: {second:?} {euler:?}");
    }
}

/// A sharp interface moves from cell to cell, and leaves no clean order. With the interface moved by the last flux the velocity
/// was four times as wrong as with Euler's scheme.
#[test]
fn crank_nicolson_is_never_worse_than_euler() {
    let of = |ddt| errors((capillary_wave, ddt), 0.3, 20);
    let (euler, second) = (of(EULER), of(CRANK_NICOLSON));
    for k in 0..2 {
        assert!((0..2).all(|q| second[k][q] < euler[k][q]), "{second:?} {euler:?}");
    }
}

/// Water a thousand times as heavy as the air around it moves with it: mass and momentum of a step go through faces
/// together, whatever the scheme.
#[test]
fn what_moves_alike_moves_on_alike() {
    for ddt in [EULER, TimeScheme::CrankNicolson(0.9), CRANK_NICOLSON] {
        for geometric in [false, true] {
            let poly = shapes::periodic_box([12, 12, 1], [true; 3]);
            let shape = Shape::cylinder([0.5, 0.5, 0.0], [0.0, 0.0, 1.0], 0.25);
            let mut two = water_and_air(&poly, shape);
            (two.gravity, two.geometric, two.numerics.ddt) = ([0.0; 3], geometric, ddt);
            let mut flow = two.flow(|_| slip());
            let u = [1.0, 0.7, 0.0];
            flow.state.u.cells.data.fill(u);
            for f in 0..flow.mesh.n_faces() {
                flow.state.phi.data[f] = dot(u, flow.mesh.area[f]);
            }
            for _ in 0..20 {
                flow.step(0.02).expect("a step");
            }
            let off = |c: usize| norm(sub(flow.state.u.cells.data[c], u));
            let most = (0..flow.mesh.n_cells).map(off).fold(0.0, f64::max);
            println!("{ddt:?}, geometric {geometric}: {most:.1e}");
            assert!(most < 1e-8, "{ddt:?}, geometric {geometric}: {most:e}");
        }
    }
}
