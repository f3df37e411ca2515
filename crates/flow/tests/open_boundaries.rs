//! Flows through open ends: what their steady states may depend on.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{norm, sub};
use granflow_flow::{Flow, ResidualControl, TimeScheme};
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::Newtonian;

/// A short channel of warped cells, so that the pressure at its ends is no straight line.
fn channel(ends: Ends, ddt: TimeScheme, outer: usize) -> Flow {
    let mut kinds = shapes::periodic_kinds([false, false, true], PatchKind::Wall);
    (kinds[0], kinds[1]) = (PatchKind::Patch, PatchKind::Patch);
    let mut poly = shapes::box_mesh([8, 6, 1], [0.0; 3], [1.0, 1.0, 0.1], kinds);
    for [x, y, _] in &mut poly.points {
        let bump = 0.03 * (7.0 * *x + 1.0).sin() * (6.0 * *y).sin();
        (*x, *y) = (*x + bump * *x * (1.0 - *x), *y + bump * *y * (1.0 - *y));
    }
    let mut s = Setup::new(&poly, numerics(outer, 2));
    s.rho = 1.0;
    s.numerics.ddt = ddt;
    s.numerics.control = ResidualControl { u: 1e-12, p: 1e-12, viscosity: 1e-12 };
    s.numerics.non_orthogonal_correctors = 1;
    let plug = move |patch: &str| ends == Ends::VelocityAndPressure && patch == "xMin";
    s.flow(
        local(Newtonian { eta: 0.05 }),
        |patch| match patch {
            _ if plug(patch) => fixed([1.0, 0.0, 0.0]),
            _ if patch.starts_with('x') => free(),
            _ => fixed([0.0; 3]),
        },
        |patch| match patch {
            _ if plug(patch) => free(),
            "xMin" => fixed(1.0),
            "xMax" => fixed(0.0),
            _ => free(),
        },
    )
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Ends {
    VelocityAndPressure,
    TwoPressures,
}

/// Steps of `dt` until nothing changes; the greatest difference of two velocities is over the
/// greatest velocity.
fn steady(mut flow: Flow, dt: f64) -> Flow {
    for _ in 0..3000 {
        let report = flow.step(dt).expect("a step");
        // What is left to come is as many such changes as the slowest mode takes steps.
        if report.change < 1e-11 * dt.min(1.0) {
            return flow;
        }
    }
    panic!("no steady state with steps of {dt}");
}

fn differ(a: &Flow, b: &Flow) -> [f64; 2] {
    let (u, v) = (&a.state.u.cells.data, &b.state.u.cells.data);
    let most = greatest(&a.mesh, |c| norm(u[c]));
    let (phi, psi) = (&a.state.phi.data, &b.state.phi.data);
    let through = phi.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let change = phi.iter().zip(psi).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    [greatest(&a.mesh, |c| norm(sub(u[c], v[c]))) / most, change / through]
}

#[test]
fn steady_states_know_nothing_of_the_time_step() {
    for ends in [Ends::VelocityAndPressure, Ends::TwoPressures] {
        let long = steady(channel(ends, TimeScheme::Euler, 60), 1000.0);
        for (ddt, outer) in
            [(TimeScheme::Euler, 60), (TimeScheme::Backward, 60), (TimeScheme::Euler, 1)]
        {
            let short = steady(channel(ends, ddt, outer), 0.05);
            let change = differ(&long, &short);
            println!("{ends:?} {ddt:?} {outer} outer: U {:.1e} phi {:.1e}", change[0], change[1]);
            assert!(change[0] < 1e-8 && change[1] < 1e-8, "{ends:?} {ddt:?} {outer}: {change:?}");
        }
    }
}
