//! Zones in turning frames: rigid rotation, and the flow between cylinders with the zone's end in the gap,
//! beside the exact profile and the same flow without a frame.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{cross, norm, sub};
use granflow_flow::sources::{RotatingFrame, Zone};
use granflow_flow::{Flow, TimeScheme};
use granflow_fv::{Convection, TimeFunction};
use granflow_mesh::shapes;
use granflow_physics::rheology::Newtonian;

const RHO: f64 = 1.5;
const INNER: f64 = 0.5;
const OUTER: f64 = 1.0;
const OMEGA: f64 = 2.0;

/// A quarter of the ring between two cylinders, with rotational periodicity.
fn ring(n: usize, ddt: TimeScheme, outer: usize) -> Setup {
    let poly = shapes::annular_sector(INNER, OUTER, [n, 2 * n, 1], 4);
    let mut s = Setup::new(&poly, numerics(outer, 3));
    s.numerics.ddt = ddt;
    s.numerics.convection = Convection::Linear;
    s.rho = RHO;
    s
}

/// A frame about the z axis over the cells within `radius`.
fn turn(flow: &mut Flow, radius: f64, omega: TimeFunction<f64>) {
    let m = &flow.mesh;
    let within = |c: &usize| {
        let [x, y, _] = m.cell_centre[*c];
        x.hypot(y) < radius
    };
    flow.sources = vec![Box::new(RotatingFrame {
        name: "MRF".into(),
        zone: Zone::Cells((0..m.n_cells).filter(within).map(|c| c as u32).collect()),
        origin: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        omega,
        still: Vec::new(),
    })];
    flow.turn_frames(true);
}

/// The flow with walls that turn as `walls` says, from rest.
fn between(s: Setup, eta: f64, walls: [f64; 2]) -> Flow {
    s.flow(
        local(Newtonian { eta }),
        |patch| match patch {
            "inner" => turning(walls[0] * INNER, INNER),
            "outer" => turning(walls[1] * OUTER, OUTER),
            _ => slip(),
        },
        |_| free(),
    )
}

/// Greatest distance from a speed around the axis, a function of the radius.
fn off(flow: &Flow, around: impl Fn(f64) -> f64) -> f64 {
    let m = &flow.mesh;
    greatest(m, |c| {
        let x = m.cell_centre[c];
        let r = x[0].hypot(x[1]);
        let exact = cross([0.0, 0.0, around(r) / r], [x[0], x[1], 0.0]);
        norm(sub(flow.state.u.cells.data[c], exact))
    })
}

/// All turns with the frame, walls too: nothing moves against it, and what the mesh leaves is less than without a
/// frame, where rigid rotation is carried through the cells.
#[test]
fn rigid_rotation_stays() {
    let [still, turned] = [false, true].map(|turns| {
        [8, 16].map(|n| {
            let walls = if turns { [0.0; 2] } else { [OMEGA; 2] };
            let mut flow = between(ring(n, TimeScheme::Steady, 60), 0.05, walls);
            if turns {
                turn(&mut flow, 2.0, TimeFunction::constant(OMEGA));
            }
            let report = flow.step(1.0).expect("a step");
            assert!(report.converged, "{report:?}");
            let m = &flow.mesh;
            let flux: f64 = flow.state.phi.data.iter().map(|f| f.abs()).sum();
            let all: f64 = (0..m.n_faces()).map(|f| OMEGA * norm(m.area[f])).sum();
            println!("rigid, {n}, frame {turns}: flux {:.1e} of the frame's", flux / all);
            assert!(!turns || flux < 2e-3 * all, "{flux:e} of {all:e}");
            off(&flow, |r| OMEGA * r) / OMEGA
        })
    });
    println!("rigid: without {still:?}, with a frame {turned:?} {:?}", orders(&turned));
    assert!(turned[1] < 1.1 * still[1] && orders(&turned)[0] > 1.9, "{turned:?} and {still:?}");
}

/// M. Couette, Ann. Chim. Phys. 21 (1890) 433: `A r + B/r`. The zone that turns with the inner wall ends in
/// the gap.
#[test]
fn between_cylinders_the_frame_makes_no_difference() {
    let b = OMEGA / (1.0 / (INNER * INNER) - 1.0 / (OUTER * OUTER));
    let exact = |r: f64| b / r - b * r / (OUTER * OUTER);
    let ways = [
        ("steady", TimeScheme::Steady, 60, 1, 1.0),
        ("one pass", TimeScheme::Euler, 1, 400, 0.05),
        ("several", TimeScheme::Backward, 20, 100, 0.2),
    ];
    for (what, ddt, outer, steps, dt) in ways {
        let [still, turned] = [false, true].map(|turns| {
            [8, 16].map(|n| {
                let walls = if turns { [0.0, 0.0] } else { [OMEGA, 0.0] };
                let mut flow = between(ring(n, ddt, outer), 0.05, walls);
                if turns {
                    turn(&mut flow, 0.75, TimeFunction::constant(OMEGA));
                }
                let mut last = 1.0;
                for _ in 0..steps {
                    last = flow.step(dt).expect("a step").change;
                }
                assert!(steps == 1 || last < 1e-6, "{what}: change {last:e}");
                off(&flow, exact) / (OMEGA * INNER)
            })
        });
        println!("{what}: without {still:?}, with a frame {turned:?}");
        assert!(orders(&turned)[0] > 1.8 && orders(&still)[0] > 1.8, "{what}: {turned:?}");
        assert!(turned[1] < 1.5 * still[1], "{what}: {turned:?} and {still:?}");
    }
}

/// Spun up and down again the flow is that of a wall that does so: the frame's flux is that of its time.
#[test]
fn a_frame_whose_speed_changes() {
    let omega = || {
        let points = vec![(0.0, 0.0), (0.5, OMEGA), (1.0, -OMEGA)];
        TimeFunction::table(points).expect("a table")
    };
    for (ddt, outer) in [(TimeScheme::Euler, 1), (TimeScheme::Backward, 20)] {
        let errors = [8, 16].map(|n| {
            let [wall, frame] = [false, true].map(|turns| {
                let mut flow = ring(n, ddt, outer).flow(
                    local(Newtonian { eta: 0.05 }),
                    |patch| match patch {
                        "inner" if !turns => {
                            let axis = [0.0, 0.0, 1.0];
                            let (origin, omega) = ([0.0; 3], omega());
                            Box::new(granflow_fv::conditions::RotatingWall { origin, axis, omega })
                        }
                        "inner" | "outer" => fixed([0.0; 3]),
                        _ => slip(),
                    },
                    |_| free(),
                );
                if turns {
                    turn(&mut flow, 0.75, omega());
                }
                for _ in 0..100 {
                    flow.step(0.01).expect("a step");
                }
                flow
            });
            let (a, b) = (&wall.state.u.cells.data, &frame.state.u.cells.data);
            greatest(&wall.mesh, |c| norm(sub(a[c], b[c]))) / (OMEGA * INNER)
        });
        println!("{ddt:?}: frame and wall apart by {errors:?}");
        assert!(errors[1] < 2e-3 && errors[1] < 0.5 * errors[0], "{ddt:?}: {errors:?}");
    }
}

/// What the frame does to fluxes leaves the continuity of every cell as it is.
#[test]
fn the_frames_flux_has_no_divergence() {
    let mut flow = between(ring(6, TimeScheme::Euler, 1), 0.05, [0.0, 0.0]);
    // Of a flow at rest the relative flux is all the frame's.
    let m = flow.mesh.clone();
    turn(&mut flow, 0.75, TimeFunction::constant(OMEGA));
    let (mut most, mut size) = (0.0f64, 0.0f64);
    for c in 0..m.n_cells {
        most = most.max(m.faces_of(c).map(|(f, s)| s * flow.state.phi.data[f]).sum::<f64>().abs());
        size = m.faces_of(c).map(|(f, _)| flow.state.phi.data[f].abs()).fold(size, f64::max);
    }
    println!("divergence {most:e} of fluxes up to {size:e}");
    assert!(size > 1e-3 && most < 1e-13 * size.max(1.0), "{most:e}");
}
