//! Guards against divisions by zero act like caps on the viscosity, and no result may hang on them:
//! each is varied a thousandfold both ways (`granflow_physics::rheology::Floors`).

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;
use common::*;
use granflow_flow::Flow;
use granflow_fv::Condition;
use granflow_fv::conditions::CoulombFriction;
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::{Floors, Form, Granular, MuI, Rheology};

const RI: f64 = 0.051;
const RO: f64 = 0.063;
const PRIMITIVE: Form = Form::Primitive { t0: 1e-3 };

/// The annular cell at I = 1e-3: velocity over that of the wall.
fn annular(rheology: impl Fn(&Setup) -> Box<dyn Rheology>) -> Vec<f64> {
    let poly = shapes::wedge_ring(RI, RO, 0.01, 64, 1, 0.5f64.to_radians());
    let mut s = Setup::new(&poly, numerics(150, 1));
    let p = 1000.0;
    let v = 2.9256998922e-3 * (p / BEADS.rho_s).sqrt();
    s.p0 = p;
    let rheology = rheology(&s);
    let mut flow = s.flow(
        rheology,
        |patch| match patch {
            "inner" => turning(v, RI),
            "outer" => turning(0.0, RO),
            _ => slip(),
        },
        |patch| if patch == "outer" { fixed(p) } else { free() },
    );
    settle(&mut flow, 1e6, 3);
    (0..flow.mesh.n_cells).map(|c| flow.state.u.cells.data[c][1] / v).collect()
}

/// Half of the heap of `cases/heap_dry`, two cells a grain: velocity over that of the surface.
fn heap(form: Form, floors: Floors) -> Vec<f64> {
    let d = 0.5e-3;
    let grains = Granular { d, floors, ..BEADS };
    let mut kinds = shapes::periodic_kinds([true, false, false], PatchKind::Wall);
    kinds[5] = PatchKind::Patch;
    let poly = shapes::box_mesh([1, 19, 40], [0.0; 3], [0.5 * d, 9.5 * d, 20.0 * d], kinds);
    let mut s = Setup::new(&poly, numerics(150, 1));
    let (sin, cos) = 28f64.to_radians().sin_cos();
    s.gravity.driving = [9.81 * sin, 0.0, 0.0];
    s.gravity.hydrostatic = [0.0, 0.0, -9.81 * cos];
    s.p0 = s.rho * 9.81 * cos * 20.0 * d;
    let (rheology, n_inner) = (ngf(&s.exec, &s.mesh, grains, form), s.mesh.n_inner);
    let wall = || -> Box<dyn Condition<_>> {
        Box::new(CoulombFriction { mu: 0.32, wall_velocity: [0.0; 3], n_inner })
    };
    let mut flow = s.flow(
        rheology,
        |patch| match patch {
            "yMin" => slip(),
            "yMax" => wall(),
            "zMin" => fixed([0.0; 3]),
            _ => free(),
        },
        |patch| if patch == "zMax" { pressure(0.0) } else { free() },
    );
    settle(&mut flow, 1e6, 2);
    (0..flow.mesh.n_cells).map(|c| flow.state.u.cells.data[c][0] / (3.33 * 0.0518182586)).collect()
}

fn settle(flow: &mut Flow, dt: f64, steps: usize) {
    for _ in 0..steps {
        let report = flow.step(dt).expect("a step");
        assert!(report.converged, "{report:?}");
    }
}

/// Every floor that a form of the fluidity equation has, a thousand times lower and higher.
fn varied(form: Form) -> Vec<(&'static str, Floors)> {
    let mut all = Vec::new();
    for k in [1e-3, 1e3] {
        let Floors { loose, creep, first_guess, still, fluidity, .. } = Floors::DEFAULT;
        all.extend([
            ("loose", Floors { loose: k * loose, ..Floors::DEFAULT }),
            ("creep", Floors { creep: k * creep, ..Floors::DEFAULT }),
            ("first guess", Floors { first_guess: k * first_guess, ..Floors::DEFAULT }),
        ]);
        if form != Form::Steady {
            all.extend([
                ("still", Floors { still: k * still, ..Floors::DEFAULT }),
                ("fluidity", Floors { fluidity: k * fluidity, ..Floors::DEFAULT }),
            ]);
        }
    }
    all
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What the issue asks for: less than 1e-4 of the wall's or the surface's speed.
const MOST: f64 = 1e-4;

#[test]
fn no_floor_of_the_fluidity_shows_in_the_annular_cell() {
    for form in [Form::Steady, PRIMITIVE] {
        let with = |floors| annular(|s| ngf(&s.exec, &s.mesh, Granular { floors, ..BEADS }, form));
        let usual = with(Floors::DEFAULT);
        for (name, floors) in varied(form) {
            let off = apart(&with(floors), &usual);
            println!("annular {form:?}, {name}: {off:.1e}");
            assert!(off < MOST, "{name}: {off}");
        }
    }
}

#[test]
fn no_floor_of_the_fluidity_shows_in_the_heap() {
    for form in [Form::Steady, PRIMITIVE] {
        let usual = heap(form, Floors::DEFAULT);
        for (name, floors) in varied(form) {
            let off = apart(&heap(form, floors), &usual);
            println!("heap {form:?}, {name}: {off:.1e}");
            assert!(off < MOST, "{name}: {off}");
        }
    }
}

/// The local law has one more: material at rest creeps at an inertial number of `rest` at most. A
/// chute 20 grains wide with a plug in its middle: the effect is in proportion to `rest`, so that of
/// the usual one is a thousandth of what a thousandfold shows. (Downwards nothing is compared: with
/// `rest` at 1e-12 the outer iterations of a plug do not converge.)
#[test]
fn no_floor_of_the_local_law_shows_in_the_chute() {
    let with = |floors| {
        let (d, n, p) = (BEADS.d, 80, 1000.0);
        let h = 20.0 * d / n as f64;
        let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
        let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [h, 20.0 * d, h], kinds);
        let mut s = Setup::new(&poly, numerics(200, 1));
        s.gravity.driving = [0.45 * 2.0 * p / (RHO_B * 20.0 * d), 0.0, 0.0];
        s.p0 = p;
        let law = local(MuI(Granular { floors, ..BEADS }));
        let mut flow = s.flow(law, |_| fixed([0.0; 3]), |_| fixed(p));
        // The first steps from rest, where all the grains are at yield, may end unconverged.
        for _ in 0..10 {
            flow.step(0.1).expect("a step");
        }
        settle(&mut flow, 0.1, 5);
        let u: Vec<f64> = (0..n).map(|c| flow.state.u.cells.data[c][0]).collect();
        let most = u.iter().copied().fold(0.0, f64::max);
        u.iter().map(|u| u / most).collect::<Vec<_>>()
    };
    let Floors { rest, loose, .. } = Floors::DEFAULT;
    let usual = with(Floors::DEFAULT);
    for (name, floors) in [
        ("rest * 1000", Floors { rest: 1e3 * rest, ..Floors::DEFAULT }),
        ("loose * 1000", Floors { loose: 1e3 * loose, ..Floors::DEFAULT }),
        ("loose / 1000", Floors { loose: 1e-3 * loose, ..Floors::DEFAULT }),
    ] {
        let off = apart(&with(floors), &usual);
        println!("chute mu(I), {name}: {off:.1e}");
        assert!(off < MOST, "{name}: {off}");
    }
}
