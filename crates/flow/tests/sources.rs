//! Forces on the bulk beside gravity: given ones, porous bodies, held mean velocities.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Vec3, norm, sub};
use granflow_flow::{Flow, MeanVelocity, Porous, SemiImplicit, Source, TimeScheme, Zone};
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::{Bingham, Newtonian};

const RHO: f64 = 2.5;

fn held(mean: Vec3) -> Box<dyn Source> {
    Box::new(MeanVelocity {
        name: "channel".into(),
        zone: Zone::All,
        direction: granflow_base::unit(mean),
        mean: norm(mean),
        relaxation: 1.0,
        gradient: 0.0,
        start: 0.0,
        last: None,
        response: None,
    })
}

/// A channel one high, `n` cells across, with cyclic ends.
fn channel(n: usize, ddt: TimeScheme, outer: usize) -> Setup {
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([3, n, 1], [0.0; 3], [0.3, 1.0, 0.1], kinds);
    let mut s = Setup::new(&poly, numerics(outer, 2));
    s.rho = RHO;
    s.numerics.ddt = ddt;
    s
}

fn still(_: &str) -> Box<dyn granflow_fv::Condition<Vec3>> {
    fixed([0.0; 3])
}

fn mean(flow: &Flow) -> f64 {
    let (mesh, u) = (&flow.mesh, &flow.state.u.cells.data);
    let volume: f64 = mesh.volume[..mesh.n_cells].iter().sum();
    (0..mesh.n_cells).map(|c| mesh.volume[c] * u[c][0]).sum::<f64>() / volume
}

/// Between plates `H` apart the gradient of a mean velocity is `12 eta U/H^2`: directly, and by marching
/// with one pass a step and with several.
#[test]
fn a_channel_with_a_held_mean_velocity_has_poiseuilles_gradient() {
    let eta = 0.4;
    let ways = [
        ("steady", TimeScheme::Steady, 40, 1),
        ("one pass", TimeScheme::Euler, 1, 400),
        ("several", TimeScheme::Euler, 20, 400),
    ];
    for (what, ddt, outer, steps) in ways {
        let errors = [8, 16, 32].map(|n| {
            let mut flow = channel(n, ddt, outer).flow(local(Newtonian { eta }), still, |_| free());
            flow.sources = vec![held([1.7, 0.0, 0.0])];
            for _ in 0..steps {
                flow.step(0.1).expect("a step");
            }
            assert!((mean(&flow) / 1.7 - 1.0).abs() < 1e-7, "{what}: {}", mean(&flow));
            // The discrete parabola's mean, with half a cell to the walls.
            let cells = 1.0 - 1.0 / (0.5 * (n * n) as f64 + 1.0);
            let ratio = flow.mean_gradients()[0] / (12.0 * eta * 1.7);
            assert!((ratio - cells).abs() < 1e-6, "{what}, {n}: {ratio} and not {cells}");
            (ratio - 1.0).abs()
        });
        println!("{what}: gradient off by {errors:?} {:?}", orders(&errors));
    }
}

/// With a yield stress the response is no straight line: the secant finds the gradient that a given
/// one comes back from.
#[test]
fn a_yield_stress_fluid_is_held_too() {
    let make = || {
        let law = Bingham { tau0: 1.0 / RHO, nu: 0.4 / RHO, nu0: 4000.0, density: RHO };
        channel(24, TimeScheme::Steady, 100).flow(local(law), still, |_| free())
    };
    let mut driven = make();
    driven.sources = vec![Box::new(SemiImplicit {
        name: "push".into(),
        zone: Zone::All,
        force: [6.0, 0.0, 0.0],
        drag: 0.0,
        window: [f64::NEG_INFINITY, f64::INFINITY],
    })];
    driven.step(1.0).expect("a step");
    let speed = mean(&driven);
    let mut flow = make();
    flow.sources = vec![held([speed, 0.0, 0.0])];
    flow.step(1.0).expect("a step");
    println!("mean {speed}, gradient {}", flow.mean_gradients()[0]);
    assert!((flow.mean_gradients()[0] / 6.0 - 1.0).abs() < 1e-6);
}

/// A failed or abandoned step leaves the gradient as it was.
#[test]
fn a_step_taken_back_takes_the_gradient_back() {
    let mut flow =
        channel(8, TimeScheme::Euler, 1).flow(local(Newtonian { eta: 0.4 }), still, |_| free());
    flow.sources = vec![held([1.0, 0.0, 0.0])];
    flow.step(0.1).expect("a step");
    let before = flow.mean_gradients();
    flow.step(0.1).expect("a step");
    assert!(flow.mean_gradients() != before);
    flow.rollback();
    assert!(flow.mean_gradients() == before);
    // To look at residuals changes nothing.
    flow.step(0.1).expect("a step");
    let after = flow.mean_gradients();
    flow.residuals().expect("residuals");
    assert!(flow.mean_gradients() == after);
}

/// A force against a drag ends at their ratio, in its window and its zone only.
#[test]
fn a_force_and_a_drag_balance() {
    let poly = shapes::periodic_box([4, 4, 1], [true; 3]);
    let mut s = Setup::new(&poly, numerics(1, 2));
    s.rho = RHO;
    let mut flow = s.flow(local(Newtonian { eta: 0.1 }), still, |_| free());
    let force = [3.0, -1.0, 0.0];
    let push =
        |window| SemiImplicit { name: "push".into(), zone: Zone::All, force, drag: 2.0, window };
    flow.sources = vec![Box::new(push([0.0, 100.05]))];
    for _ in 0..1000 {
        flow.step(0.1).expect("a step");
    }
    let u = &flow.state.u.cells.data;
    assert!(greatest(&flow.mesh, |c| norm(sub(u[c], [1.5, -0.5, 0.0]))) < 1e-9);
    // Implicit Euler without force and drag: nothing slows it down.
    flow.step(0.1).expect("a step");
    let u = &flow.state.u.cells.data;
    assert!(greatest(&flow.mesh, |c| norm(sub(u[c], [1.5, -0.5, 0.0]))) < 1e-9);
}

/// Plug flow through a porous block: the pressure falls by `(eta D + rho U F/2) U` a length, inside
/// the block and nowhere else. The cells at its ends take the mean of the slopes on either side: the whole
/// is short by a share of a cell.
#[test]
fn a_porous_block_takes_its_pressure() {
    let (eta, speed) = (0.2, 0.8);
    let fall = (eta * 500.0 + 0.5 * RHO * speed * 30.0) * speed;
    for (ddt, outer, steps) in [(TimeScheme::Steady, 40, 1), (TimeScheme::Euler, 1, 200)] {
        let short = [40, 80].map(|n| {
            let mut kinds = shapes::periodic_kinds([false, false, true], PatchKind::Wall);
            (kinds[0], kinds[1]) = (PatchKind::Patch, PatchKind::Patch);
            let poly = shapes::box_mesh([n, 3, 1], [0.0; 3], [4.0, 0.3, 0.1], kinds);
            let mut s = Setup::new(&poly, numerics(outer, 3));
            s.rho = RHO;
            s.numerics.ddt = ddt;
            let mut flow = s.flow(
                local(Newtonian { eta }),
                |patch| match patch {
                    "xMin" => fixed([speed, 0.0, 0.0]),
                    "xMax" => free(),
                    _ => slip(),
                },
                |patch| if patch == "xMax" { fixed(0.0) } else { free() },
            );
            let inside = |c: &usize| (1.0..2.0).contains(&flow.mesh.cell_centre[*c][0]);
            let cells = (0..flow.mesh.n_cells).filter(inside).map(|c| c as u32).collect();
            let (darcy, forchheimer) = ([500.0, 800.0, 800.0], [30.0, 0.0, 0.0]);
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let zone = Zone::Cells(cells);
            flow.sources =
                vec![Box::new(Porous { name: "hold".into(), zone, darcy, forchheimer, axes })];
            for _ in 0..steps {
                flow.step(0.05).expect("a step");
            }
            let p = &flow.state.p.cells.data;
            let at = |x: f64| {
                let near = |c: &usize| (flow.mesh.cell_centre[*c][0] - x).abs();
                let c = (0..flow.mesh.n_cells).min_by(|a, b| near(a).total_cmp(&near(b)));
                p[c.expect("cells")]
            };
            let (h, middle) = (4.0 / n as f64, at(1.25) - at(1.75));
            println!("{ddt:?}, {n}: whole {}, half {middle} of {fall}", at(0.5));
            let cells = ((1.75 - 1.25) / h).round();
            assert!((middle / (fall * cells * h) - 1.0).abs() < 2e-3, "{middle}");
            assert!((at(3.0) / fall).abs() < 1e-3);
            1.0 - at(0.5) / fall
        });
        assert!(short[0] < 0.04 && orders(&short)[0] > 0.9, "{ddt:?}: {short:?}");
    }
}

/// With axes that lean, the weaker drag turns the flow its way.
#[test]
fn a_porous_body_with_leaning_axes_turns_the_flow() {
    let poly = shapes::periodic_box([4, 4, 1], [true; 3]);
    let mut s = Setup::new(&poly, numerics(1, 2));
    s.rho = RHO;
    let eta = 0.5;
    let mut flow = s.flow(local(Newtonian { eta }), still, |_| free());
    let k = 0.5f64.sqrt();
    let axes = [[k, k, 0.0], [-k, k, 0.0], [0.0, 0.0, 1.0]];
    let force = [6.0, 0.0, 0.0];
    flow.sources = vec![
        Box::new(Porous {
            name: "hold".into(),
            zone: Zone::All,
            darcy: [2.0, 8.0, 0.0],
            forchheimer: [0.0; 3],
            axes,
        }),
        Box::new(SemiImplicit {
            name: "push".into(),
            zone: Zone::All,
            force,
            drag: 0.0,
            window: [f64::NEG_INFINITY, f64::INFINITY],
        }),
    ];
    for _ in 0..2000 {
        flow.step(0.1).expect("a step");
    }
    // Along the axes: force over drag.
    let (a, b) = (6.0 * k / (eta * 2.0), -6.0 * k / (eta * 8.0));
    let wanted = [k * (a - b), k * (a + b), 0.0];
    let u = &flow.state.u.cells.data;
    let off = greatest(&flow.mesh, |c| norm(sub(u[c], wanted)));
    assert!(off < 1e-9, "{:?} and not {wanted:?}", u[0]);
}
