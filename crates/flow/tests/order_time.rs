//! Order of accuracy of every time scheme on hexahedra, prisms, tetrahedra and polyhedra: the whole solver
//! under a lid that is set in motion, steps refined on a fixed mesh against fine steps of another scheme of
//! second order on the same mesh, so that the error in space drops out.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Vec3, norm, sub};
use granflow_flow::{Flow, LocalSteps, Numerics, ResidualControl, TimeScheme};
use granflow_fv::conditions::{PatchClosure, PatchView};
use granflow_fv::{Condition, Convection, Gradient, LeastSquares};
use granflow_mesh::{PatchKind, PolyMesh, shapes};
use granflow_physics::rheology::Newtonian;

/// A lid at `y = 1` that is set in motion and slows down again; walls elsewhere.
struct Lid;

impl Condition<Vec3> for Lid {
    fn name(&self) -> &'static str {
        "lid"
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let speed = view.around.time.sin().powi(2);
        for (at, u) in view.centre.iter().zip(closure.offset.iter_mut()) {
            if at[1] > 1.0 - 1e-9 {
                u[0] = 16.0 * speed * (at[0] * (1.0 - at[0])).powi(2);
            }
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

const SHAPES: [&str; 4] = ["hexahedra", "prisms", "tetrahedra", "polyhedra"];

/// The unit square, or cube, of few cells.
fn box_of(shape: &str) -> PolyMesh {
    let mut kinds = shapes::all(PatchKind::Wall);
    (kinds[4], kinds[5]) = (PatchKind::Empty, PatchKind::Empty);
    let (lo, hi) = ([0.0; 3], [1.0, 1.0, 0.1]);
    match shape {
        "hexahedra" => {
            // Cells that lean and grow, smoothly.
            let map = |[x, y, z]: Vec3| [x + 0.1 * x * (1.0 - x), y + 0.1 * x * y * (1.0 - y), z];
            shapes::mapped_box([8, 8, 1], lo, hi, kinds, map)
        }
        "prisms" => shapes::prism_box([6, 6, 1], lo, hi, kinds),
        "polyhedra" => shapes::brick_plane(8),
        _ => shapes::tetrahedra(3),
    }
}

fn under_a_lid(shape: &str, numerics: Numerics) -> Flow {
    let mut s = Setup::new(&box_of(shape), numerics);
    s.numerics.convection = Convection::Linear;
    s.numerics.gradient = Gradient::LeastSquares(LeastSquares::new(&s.mesh));
    s.numerics.u = solve_loosely("PBiCGStab", "DILU", 1e-10);
    s.numerics.p = solve_loosely("PCG", "DIC", 1e-10);
    s.rho = 1.0;
    s.flow(local(Newtonian { eta: 0.02 }), |_| Box::new(Lid), |_| free())
}

/// The velocity at one second, in `steps` steps.
fn velocity(shape: &str, scheme: TimeScheme, steps: usize) -> (Flow, Vec<Vec3>) {
    let mut n = numerics(60, 1);
    n.ddt = scheme;
    n.control = ResidualControl { u: 1e-10, p: 1e-10, viscosity: 1e-10 };
    let mut flow = under_a_lid(shape, n);
    for _ in 0..steps {
        let report = flow.step(1.0 / steps as f64).expect("a step");
        assert!(report.converged, "{shape}, {scheme:?}, {steps}: {report:?}");
    }
    let u = flow.state.u.cells.data.clone();
    (flow, u)
}

/// The scheme that fine steps are made with must not be the one that is looked at.
fn fine(shape: &str, scheme: TimeScheme) -> Vec<Vec3> {
    let other = match scheme {
        TimeScheme::Backward => TimeScheme::CrankNicolson(1.0),
        _ => TimeScheme::Backward,
    };
    velocity(shape, other, 1280).1
}

fn order(shape: &str, scheme: TimeScheme, steps: [usize; 2], finest: &[Vec3]) -> f64 {
    let errors = steps.map(|steps| {
        let (flow, u) = velocity(shape, scheme, steps);
        rms(&flow.mesh, |c| norm(sub(u[c], finest[c])))
    });
    let observed = orders(&errors)[0];
    println!("{scheme:?} on {shape}: {} {observed:.3}", short(&errors));
    observed
}

fn orders_on(shape: &str) {
    let schemes = [
        (TimeScheme::Euler, [80, 160], 1.0),
        (TimeScheme::Backward, [40, 80], 2.0),
        (TimeScheme::CrankNicolson(1.0), [40, 80], 2.0),
        (TimeScheme::CrankNicolson(0.9), [80, 160], 1.0),
    ];
    for (scheme, steps, formal) in schemes {
        let observed = order(shape, scheme, steps, &fine(shape, scheme));
        assert!((observed - formal).abs() <= 0.1, "{scheme:?} on {shape}: {observed:.3}");
    }
}

#[test]
fn hexahedra() {
    orders_on("hexahedra");
}

#[test]
fn prisms() {
    orders_on("prisms");
}

#[test]
fn tetrahedra() {
    orders_on("tetrahedra");
}

#[test]
fn polyhedra() {
    orders_on("polyhedra");
}

/// Steps of their own for every cell end in the steady state that is found directly.
#[test]
fn local_steps_end_in_the_steady_state() {
    for shape in SHAPES {
        let found = |ddt: TimeScheme, passes: usize, steps: usize| {
            let mut n = numerics(passes, 2);
            n.ddt = ddt;
            let mut flow = under_a_lid(shape, n);
            let mut report = None;
            // The lid at rest is no flow, and at half pi its speed has no slope.
            flow.state.time = 0.5 * std::f64::consts::PI;
            for _ in 0..steps {
                let last = flow.step(1e-12).expect("a step");
                report = Some(last);
                if last.change < 1e-10 {
                    break;
                }
            }
            (flow, report.expect("a step"))
        };
        let local = LocalSteps { courant: 0.8, longest: 1.0, growth: 0.1 };
        let (steady, report) = found(TimeScheme::Steady, 100, 1);
        assert!(report.converged, "{shape}: {report:?}");
        let (marched, report) = found(TimeScheme::Local(local), 1, 3000);
        println!("{shape}: {} steps, change {:.1e}", marched.state.step, report.change);
        let (a, b) = (&steady.state.u.cells.data, &marched.state.u.cells.data);
        let off = rms(&steady.mesh, |c| norm(sub(a[c], b[c])));
        println!("{shape}: {off:.1e} from the steady state");
        assert!(report.change < 1e-10 && off < 1e-8, "{shape}: {off:.1e}, {report:?}");
    }
}
