//! The whole system of momentum and pressure against exact solutions of the Navier-Stokes
//! equations, against the benchmark of the driven cavity, and where viscosity varies a millionfold.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Vec3, dot, norm, sub};
use granflow_flow::{Flow, LocalSteps, Report, ResidualControl, TimeScheme};
use granflow_fv::conditions::{Condition, FixedValue};
use granflow_fv::{CellField, Convection, Gradient, LeastSquares};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_physics::rheology::{
    CrossPowerLaw, FlowView, Newtonian, Rheology, RheologyError, RheologyInfo,
};
use std::f64::consts::{PI, TAU};

const STEADY: f64 = 1e6;

fn run(flow: &mut Flow, dt: f64, steps: usize) -> Report {
    let mut last = Report::default();
    for _ in 0..steps {
        last = flow.step(dt).expect("a step");
    }
    last
}

/// Numbers in -1..1 that depend on `i` and `j` alone.
fn noise(i: f64, j: f64) -> f64 {
    let x = (12.9898 * i + 78.233 * j).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// What is done to the points of a rectangle off its boundary, within the plane.
#[derive(Clone, Copy, PartialEq)]
enum Bent {
    No,
    /// Moved along waves: lines of cells bend, neighbours stay alike.
    Smoothly,
    /// Moved at random by a fifth of a cell: the skewness does not fade as cells shrink.
    AtRandom,
}

/// A plane rectangle.
fn rectangle(n: [usize; 2], lo: [f64; 2], hi: [f64; 2], bent: Bent) -> PolyMesh {
    let h = [0, 1].map(|d| (hi[d] - lo[d]) / n[d] as f64);
    let mut kinds = shapes::all(PatchKind::Wall);
    (kinds[4], kinds[5]) = (PatchKind::Empty, PatchKind::Empty);
    let map = |[x, y, z]: Vec3| {
        let (i, j) = (((x - lo[0]) / h[0]).round(), ((y - lo[1]) / h[1]).round());
        let edge = i == 0.0 || j == 0.0 || i == n[0] as f64 || j == n[1] as f64;
        let wave = (PI * i / n[0] as f64).sin() * (TAU * j / n[1] as f64).sin();
        let step = match bent {
            Bent::AtRandom if !edge => [0.2 * h[0] * noise(i, j), 0.2 * h[1] * noise(j + 0.5, i)],
            Bent::Smoothly => [0.08 * wave * (hi[0] - lo[0]), -0.06 * wave * (hi[1] - lo[1])],
            _ => [0.0; 2],
        };
        [x + step[0], y + step[1], z]
    };
    shapes::mapped_box([n[0], n[1], 1], [lo[0], lo[1], 0.0], [hi[0], hi[1], h[0]], kinds, map)
}

/// The exact velocity at every face of a patch.
fn exact_on(m: &Mesh, patch: &str, u: impl Fn(Vec3) -> Vec3) -> Box<dyn Condition<Vec3>> {
    let patch = &m.patches[m.patch(patch).expect("a patch")];
    Box::new(FixedValue::per_face(patch.faces.clone().map(|f| u(m.face_centre[f])).collect()))
}

/// Root mean square errors of U and of p up to a constant.
fn errors(flow: &Flow, u: impl Fn(Vec3) -> Vec3, p: impl Fn(Vec3) -> f64) -> [f64; 2] {
    let m = &flow.mesh;
    let x = |c: usize| m.cell_centre[c];
    let off = |c: usize| flow.state.p.cells.data[c] - p(x(c));
    let volume: f64 = m.volume[..m.n_cells].iter().sum();
    let mean = (0..m.n_cells).map(|c| m.volume[c] * off(c)).sum::<f64>() / volume;
    [rms(m, |c| norm(sub(flow.state.u.cells.data[c], u(x(c))))), rms(m, |c| off(c) - mean)]
}

/// L. I. G. Kovasznay, Math. Proc. Camb. Phil. Soc. 44 (1948) 58: the wake of a grid, Re 40.
fn kovasznay(n: usize, bent: Bent, gradient: fn(&Mesh) -> Gradient) -> [f64; 2] {
    let re = 40.0;
    let l = 0.5 * re - (0.25 * re * re + 4.0 * PI * PI).sqrt();
    let u = move |[x, y, _]: Vec3| {
        let e = (l * x).exp();
        [1.0 - e * (TAU * y).cos(), l / TAU * e * (TAU * y).sin(), 0.0]
    };
    let p = move |[x, ..]: Vec3| -0.5 * (2.0 * l * x).exp();
    let poly = rectangle([3 * n, 4 * n], [-0.5, -0.5], [1.0, 1.5], bent);
    let mut numerics = numerics(300, 1);
    numerics.convection = Convection::Linear;
    numerics.non_orthogonal_correctors = if bent == Bent::No { 0 } else { 2 };
    numerics.u = solve_loosely("PBiCGStab", "DILU", 1e-3);
    numerics.p = solve_loosely("PCG", "DIC", 1e-3);
    let mut s = Setup::new(&poly, numerics);
    s.numerics.gradient = gradient(&s.mesh);
    s.rho = 1.0;
    let m = s.mesh.clone();
    for c in 0..m.n_cells {
        s.u0[c] = u(m.cell_centre[c]);
    }
    let mut flow =
        s.flow(local(Newtonian { eta: 1.0 / re }), |patch| exact_on(&m, patch, u), |_| free());
    run(&mut flow, 0.2, 3);
    let mut report = run(&mut flow, 1.0, 2);
    println!("{n}: {} outer, {:?}", report.outer, report.residuals);
    for _ in 0..200 {
        if report.change < 1e-6 {
            break;
        }
        report = run(&mut flow, 1.0, 1);
    }
    assert!(report.converged && report.change < 1e-6, "{n}: {report:?}");
    errors(&flow, u, p)
}

fn kovasznay_orders(what: &str, bent: Bent, gradient: fn(&Mesh) -> Gradient, least: [f64; 2]) {
    let e = [4, 8, 16].map(|n| kovasznay(n, bent, gradient));
    let [u, p] = [0, 1].map(|k| e.iter().map(|e| e[k]).collect::<Vec<f64>>());
    println!("Kovasznay, {what}: U {} {:?}", short(&u), orders(&u));
    println!("Kovasznay, {what}: p {} {:?}", short(&p), orders(&p));
    assert!(orders(&u)[1] >= least[0], "{what}: U {u:?}");
    assert!(orders(&p)[1] >= least[1], "{what}: p {p:?}");
}

#[test]
fn kovasznay_flow_on_rectangles() {
    kovasznay_orders("rectangles", Bent::No, |_| Gradient::GaussLinear, [1.8, 1.4]);
}

#[test]
fn kovasznay_flow_on_bent_cells() {
    kovasznay_orders("bent", Bent::Smoothly, |_| Gradient::GaussLinear, [2.0, 1.4]);
}

/// Skewness that does not fade costs no order: the pressure's is what its zero gradient on the
/// boundary leaves of it on rectangles too.
#[test]
fn kovasznay_flow_on_displaced_cells() {
    let gradient = |m: &Mesh| Gradient::LeastSquares(LeastSquares::new(m));
    kovasznay_orders("displaced", Bent::AtRandom, gradient, [2.0, 1.4]);
}

#[test]
fn kovasznay_flow_on_displaced_cells_by_gauss() {
    let gradient = |_: &Mesh| Gradient::GaussLinear;
    kovasznay_orders("displaced, Gauss", Bent::AtRandom, gradient, [2.0, 1.4]);
}

const NU: f64 = 0.05;

/// G. I. Taylor, A. E. Green, Proc. R. Soc. A 158 (1937) 499: vortices that decay.
fn taylor_green(t: f64) -> impl Fn(Vec3) -> Vec3 {
    let decay = (-2.0 * NU * t).exp();
    move |[x, y, _]| [x.sin() * y.cos() * decay, -x.cos() * y.sin() * decay, 0.0]
}

fn vortices(n: usize, scheme: TimeScheme, piso: bool) -> Flow {
    vortices_on(n, scheme, piso, 0.0)
}

/// The same on cells displaced at random by `amount` of their size, alike on both sides.
fn vortices_on(n: usize, scheme: TimeScheme, piso: bool, amount: f64) -> Flow {
    vortices_of(local(Newtonian { eta: NU }), n, scheme, piso, amount)
}

/// The same of another fluid.
fn vortices_of(
    rheology: Box<dyn Rheology>,
    n: usize,
    scheme: TimeScheme,
    piso: bool,
    amount: f64,
) -> Flow {
    let kinds = shapes::periodic_kinds([true; 3], PatchKind::Patch);
    let h = TAU / n as f64;
    let map = |[x, y, z]: Vec3| {
        let [i, j] = [x, y].map(|x| (x / h).round() % n as f64);
        [x + amount * h * noise(i, j), y + amount * h * noise(j + 0.5, i), z]
    };
    let poly = shapes::mapped_box([n, n, 1], [0.0; 3], [TAU, TAU, h], kinds, map);
    let mut numerics = if piso { numerics(1, 3) } else { numerics(60, 1) };
    numerics.control = ResidualControl { u: 1e-10, p: 1e-10, viscosity: 1e-10 };
    numerics.convection = Convection::Linear;
    numerics.ddt = scheme;
    numerics.u = solve_loosely("PBiCGStab", "DILU", 1e-10);
    numerics.p = solve_loosely("PCG", "DIC", 1e-10);
    let mut s = Setup::new(&poly, numerics);
    s.rho = 1.0;
    let u = taylor_green(0.0);
    for c in 0..s.mesh.n_cells {
        s.u0[c] = u(s.mesh.cell_centre[c]);
    }
    let mut flow = s.flow(rheology, |_| free(), |_| free());
    // The flux of a start is the exact velocity's.
    let m = flow.mesh.clone();
    for f in 0..m.n_faces() {
        let at_face = match amount {
            0.0 => flow.state.u.face_value(&m, f),
            _ => u(m.face_centre[f]),
        };
        flow.state.phi.data[f] = dot(at_face, m.area[f]);
    }
    flow
}

#[test]
fn taylor_green_on_displaced_cells() {
    let t = 0.5;
    let pressure =
        |p: Vec3| 0.25 * ((2.0 * p[0]).cos() + (2.0 * p[1]).cos()) * (-4.0 * NU * t).exp();
    // Long steps and short ones: what faces remember must not outlive its cause.
    for steps in [10, 80] {
        let e = [16, 32, 64].map(|n| {
            let mut flow = vortices_on(n, TimeScheme::Backward, false, 0.2);
            flow.numerics.control = ResidualControl { u: 1e-8, p: 1e-8, viscosity: 1e-8 };
            let report = run(&mut flow, t / steps as f64, steps);
            assert!(report.converged, "{n}: {report:?}");
            errors(&flow, taylor_green(t), pressure)
        });
        let [u, p] = [0, 1].map(|k| e.iter().map(|e| e[k]).collect::<Vec<f64>>());
        println!("Taylor-Green, displaced, {steps} steps: U {} {:?}", short(&u), orders(&u));
        println!("Taylor-Green, displaced, {steps} steps: p {} {:?}", short(&p), orders(&p));
        assert!(orders(&u)[1] > 2.0, "{u:?}");
        assert!(orders(&p)[1] > 1.6, "{p:?}");
    }
}

#[test]
fn taylor_green_in_space() {
    let (t, steps) = (0.5, 20);
    let pressure =
        |p: Vec3| 0.25 * ((2.0 * p[0]).cos() + (2.0 * p[1]).cos()) * (-4.0 * NU * t).exp();
    let e = [16, 32, 64].map(|n| {
        let mut flow = vortices(n, TimeScheme::Backward, false);
        let report = run(&mut flow, t / steps as f64, steps);
        assert!(report.converged, "{n}: {report:?}");
        errors(&flow, taylor_green(t), pressure)
    });
    let [u, p] = [0, 1].map(|k| e.iter().map(|e| e[k]).collect::<Vec<f64>>());
    println!("Taylor-Green in space: U {} {:?}", short(&u), orders(&u));
    println!("Taylor-Green in space: p {} {:?}", short(&p), orders(&p));
    // What the interpolation of the flux damps is of third and fourth order.
    assert!(orders(&u).iter().all(|o| *o > 1.9) && u[2] < 3e-4, "{u:?}");
    assert!((p[0] / p[2]).log(4.0) > 1.9, "{p:?}");
}

/// Errors against the finest step of the same scheme on the same mesh.
fn in_time(scheme: TimeScheme, piso: bool) -> Vec<f64> {
    let t = 2.0;
    let solve = |steps: usize| {
        let mut flow = vortices(16, scheme, piso);
        run(&mut flow, t / steps as f64, steps);
        flow
    };
    let finest = solve(1280);
    let of = |flow: Flow| {
        rms(&flow.mesh, |c| norm(sub(flow.state.u.cells.data[c], finest.state.u.cells.data[c])))
    };
    [20, 40, 80].map(|steps| of(solve(steps))).to_vec()
}

#[test]
fn taylor_green_in_time_euler() {
    for piso in [false, true] {
        let e = in_time(TimeScheme::Euler, piso);
        println!("Euler, PISO {piso}: {} {:?}", short(&e), orders(&e));
        assert!((orders(&e)[1] - 1.0).abs() < 0.15, "PISO {piso}: {e:?}");
    }
}

#[test]
fn taylor_green_in_time_backward() {
    let e = in_time(TimeScheme::Backward, false);
    println!("backward: {} {:?}", short(&e), orders(&e));
    assert!((orders(&e)[1] - 2.0).abs() < 0.1, "{e:?}");
}

/// One pass a step takes the carrying flux from the step before: first order, whatever the scheme.
#[test]
fn taylor_green_in_time_backward_by_piso() {
    let e = in_time(TimeScheme::Backward, true);
    println!("backward by PISO: {} {:?}", short(&e), orders(&e));
    assert!(orders(&e)[1] > 0.85, "{e:?}");
}

#[test]
fn taylor_green_in_time_crank_nicolson() {
    let e = in_time(TimeScheme::CrankNicolson(1.0), false);
    println!("Crank-Nicolson: {} {:?}", short(&e), orders(&e));
    assert!((orders(&e)[1] - 2.0).abs() < 0.1, "{e:?}");
    // With OpenFOAM's 0 it is Euler, to the bit.
    let [a, b] = [TimeScheme::Euler, TimeScheme::CrankNicolson(0.0)].map(|scheme| {
        let mut flow = vortices(16, scheme, false);
        run(&mut flow, 0.1, 5);
        flow.state.u.cells.data
    });
    assert!(a == b);
    // Between, the error is the share of Euler's that is left.
    let euler = in_time(TimeScheme::Euler, false)[2];
    let most = in_time(TimeScheme::CrankNicolson(0.9), false)[2];
    println!("Euler {euler:.2e}, Crank-Nicolson 0.9 {most:.2e}");
    assert!((most / euler - 0.1 / 1.9).abs() < 0.02, "{most:e} of {euler:e}");
}

/// The reference tool's forms of a viscosity that varies, linear between cells with the transposed part of the stress
/// explicit, and ours are two approximations of one flow.
#[test]
fn forms_of_a_varying_viscosity_have_one_limit() {
    let e = [16, 32].map(|n| {
        let [ours, theirs] = [false, true].map(|compatible| {
            let law = CrossPowerLaw { nu0: 0.02, nu_inf: 0.2, m: 1.0, n: 2.0, density: 1.0 };
            let mut flow = vortices_of(local(law), n, TimeScheme::Euler, true, 0.0);
            flow.numerics.compatible = compatible;
            run(&mut flow, 0.02, 25);
            flow
        });
        let (u, v) = (&ours.state.u.cells.data, &theirs.state.u.cells.data);
        rms(&ours.mesh, |c| norm(sub(u[c], v[c])))
    });
    println!("forms differ by {:.1e}, {:.1e}", e[0], e[1]);
    assert!(e[0] < 1e-2 && (e[0] / e[1]).log2() > 1.7, "{e:?}");
}

/// All time schemes end on the same flow as steps shrink.
#[test]
fn time_schemes_have_one_limit() {
    let [a, b, c] =
        [TimeScheme::Euler, TimeScheme::Backward, TimeScheme::CrankNicolson(0.9)].map(|scheme| {
            let mut flow = vortices(16, scheme, false);
            run(&mut flow, 0.5 / 400.0, 400);
            flow
        });
    for other in [b, c] {
        let x = &other.state.u.cells.data;
        let d = rms(&a.mesh, |c| norm(sub(a.state.u.cells.data[c], x[c])));
        println!("differ from Euler at small steps by {d:.1e}");
        assert!(d < 1e-4, "{d:.1e}");
    }
}

/// Steps that change in length, as an adjustable time step makes them: still second order.
#[test]
fn crank_nicolson_with_steps_of_changing_length() {
    let t = 2.0;
    let solve = |steps: usize| {
        let mut flow = vortices(16, TimeScheme::CrankNicolson(1.0), false);
        let dt = t / steps as f64;
        for k in 0..steps {
            let share = if k % 4 < 2 { 0.7 } else { 1.3 };
            run(&mut flow, share * dt, 1);
        }
        flow
    };
    let finest = solve(1280);
    let e = [40, 80, 160].map(|steps| {
        let flow = solve(steps);
        let x = &finest.state.u.cells.data;
        rms(&flow.mesh, |c| norm(sub(flow.state.u.cells.data[c], x[c])))
    });
    println!("Crank-Nicolson, steps of 0.7 and 1.3: {} {:?}", short(&e), orders(&e));
    assert!((orders(&e)[1] - 2.0).abs() < 0.2, "{e:?}");
}

/// Cells with steps of their own get to the steady state of the cavity that one step for all gets to.
#[test]
fn local_steps_end_in_the_steady_state() {
    let steady = cavity(16, 100.0, 10.0, 60);
    let poly = rectangle([16, 16], [0.0; 2], [1.0; 2], Bent::No);
    let mut numerics = numerics(1, 2);
    numerics.convection = Convection::Linear;
    numerics.ddt = TimeScheme::Local(LocalSteps { courant: 0.8, longest: 1.0, growth: 0.1 });
    let mut s = Setup::new(&poly, numerics);
    s.rho = 1.0;
    let lid = |patch: &str| fixed(if patch == "yMax" { [1.0, 0.0, 0.0] } else { [0.0; 3] });
    let mut flow = s.flow(local(Newtonian { eta: 0.01 }), lid, |_| free());
    let mut report = Report::default();
    for step in 0..3000 {
        report = run(&mut flow, 1.0, 1);
        if report.change < 1e-10 {
            println!("local steps: settled after {step}");
            break;
        }
    }
    assert!(report.change < 1e-10, "{report:?}");
    let x = &steady.state.u.cells.data;
    let d = rms(&flow.mesh, |c| norm(sub(flow.state.u.cells.data[c], x[c])));
    println!("local steps: {d:.1e} from the steady state");
    assert!(d < 1e-7, "{d:.1e}");
}

/// A cavity of unit side and lid speed, driven to its steady state.
fn cavity(n: usize, re: f64, dt: f64, outer: usize) -> Flow {
    let poly = rectangle([n, n], [0.0; 2], [1.0; 2], Bent::No);
    let mut numerics = numerics(outer, 1);
    numerics.convection = Convection::Linear;
    numerics.u = solve_loosely("PBiCGStab", "DILU", 1e-3);
    numerics.p = solve_loosely("PCG", "DIC", 1e-3);
    numerics.control = ResidualControl { u: 1e-9, p: 1e-9, viscosity: 1e-9 };
    let mut s = Setup::new(&poly, numerics);
    s.rho = 1.0;
    let lid = |patch: &str| fixed(if patch == "yMax" { [1.0, 0.0, 0.0] } else { [0.0; 3] });
    let mut flow = s.flow(local(Newtonian { eta: 1.0 / re }), lid, |_| free());
    let mut report = Report::default();
    for _ in 0..2000 {
        report = run(&mut flow, dt, 1);
        if report.change < 1e-10 * dt.min(1.0) {
            break;
        }
    }
    println!("cavity {n} dt {dt}: t {}, {} outer, {:?}", report.time, report.outer, report.change);
    assert!(report.converged && report.change < 1e-9, "{report:?}");
    flow
}

#[test]
fn driven_cavity_meets_ghia() {
    for (n, most) in [(32, 0.015), (64, 0.006)] {
        let flow = cavity(n, 100.0, 10.0, 60);
        let m = &flow.mesh;
        let h = 1.0 / n as f64;
        let mut rows = vec![vec![0.0, 0.0]];
        for j in 0..n {
            let y = (j as f64 + 0.5) * h;
            let beside = (0..m.n_cells).filter(|&c| {
                let [cx, cy, _] = m.cell_centre[c];
                (cx - 0.5).abs() < 0.6 * h && (cy - y).abs() < 0.1 * h
            });
            rows.push(vec![y, 0.5 * beside.map(|c| flow.state.u.cells.data[c][0]).sum::<f64>()]);
        }
        rows.push(vec![1.0, 1.0]);
        let worst = GHIA
            .iter()
            .map(|[y, u, ..]| (interpolate(&rows, 0, 1, *y) - u).abs())
            .fold(0.0, f64::max);
        println!("cavity {n}: {:.2} % of the lid's speed from Ghia et al.", 100.0 * worst);
        assert!(worst < most, "{n}: {worst}");
    }
}

#[test]
fn the_steady_state_does_not_depend_on_the_time_step() {
    let short = cavity(16, 100.0, 0.1, 40);
    let long = cavity(16, 100.0, 10.0, 40);
    let m = &short.mesh;
    let (a, b) = (&short.state.u.cells.data, &long.state.u.cells.data);
    let u = greatest(m, |c| norm(sub(a[c], b[c])));
    let phi = (0..m.n_faces())
        .map(|f| (short.state.phi.data[f] - long.state.phi.data[f]).abs() / m.mag_area[f])
        .fold(0.0, f64::max);
    println!("100 times the step: U {u:.1e}, flux {phi:.1e}");
    assert!(u < 1e-6 && phi < 1e-6, "{u:.1e} {phi:.1e}");
}

/// A viscosity that depends on the place alone.
struct Placed<F>(F);
impl<F: Fn(Vec3) -> f64 + Send> Rheology for Placed<F> {
    fn update(
        &mut self,
        v: &FlowView<'_>,
        eta: &mut CellField<f64>,
    ) -> Result<RheologyInfo, RheologyError> {
        (0..v.mesh.n_cells).for_each(|c| eta.data[c] = (self.0)(v.mesh.cell_centre[c]));
        Ok(RheologyInfo::default())
    }
}

fn layers(n: usize, eta: fn(Vec3) -> f64) -> Flow {
    let h = 1.0 / n as f64;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([2, n, 1], [0.0; 3], [2.0 * h, 1.0, h], kinds);
    let s = Setup::new(&poly, numerics(60, 1));
    let lid = |patch: &str| fixed(if patch == "yMax" { [1.0, 0.0, 0.0] } else { [0.0; 3] });
    s.flow(Box::new(Placed(eta)), lid, |_| free())
}

fn couette_error(flow: &Flow, exact: impl Fn(f64) -> f64) -> f64 {
    let m = &flow.mesh;
    greatest(m, |c| (flow.state.u.cells.data[c][0] - exact(m.cell_centre[c][1])).abs())
}

/// Viscosity grows a millionfold from wall to wall, as it does where grains creep.
#[test]
fn couette_flow_with_exponential_viscosity() {
    let k = 1e6f64.ln();
    let exact = |y: f64| (1.0 - (-k * y).exp()) / (1.0 - (-k).exp());
    let e: Vec<f64> = [40, 80, 160]
        .map(|n| {
            let mut flow = layers(n, |p| (1e6f64.ln() * p[1]).exp());
            let report = run(&mut flow, STEADY, 2);
            assert!(report.converged, "{report:?}");
            couette_error(&flow, exact)
        })
        .to_vec();
    println!("Couette, exponential viscosity: {} {:?}", short(&e), orders(&e));
    assert!(orders(&e).iter().all(|o| *o > 1.7) && e[2] < 1e-3, "{e:?}");
}

/// Two layers: what shears is the soft one. The geometric mean between cells, exact for
/// exponential change, leaves half a cell of it out: first order where viscosity jumps.
#[test]
fn couette_flow_of_two_layers() {
    let exact = |y: f64| {
        let tau = 1.0 / (0.5 + 0.5e-6);
        if y < 0.5 { tau * y } else { 1.0 - 1e-6 * tau * (1.0 - y) }
    };
    let e: Vec<f64> = [20, 40, 80]
        .map(|n| {
            let mut flow = layers(n, |p| if p[1] < 0.5 { 1.0 } else { 1e6 });
            let report = run(&mut flow, STEADY, 2);
            assert!(report.converged, "{report:?}");
            couette_error(&flow, exact)
        })
        .to_vec();
    println!("Couette, two layers: {} {:?}", short(&e), orders(&e));
    assert!(orders(&e).iter().all(|o| *o > 0.9) && e[2] < 0.02, "{e:?}");
}

#[test]
fn short_steps_with_a_viscosity_contrast_are_stable() {
    for eta in [
        (|p: Vec3| (1e6f64.ln() * p[1]).exp()) as fn(Vec3) -> f64,
        |p| if p[1] < 0.5 { 1.0 } else { 1e6 },
        |p| if p[1] > 0.5 { 1.0 } else { 1e6 },
    ] {
        let mut flow = layers(40, eta);
        flow.numerics.control = ResidualControl { u: 1e-11, p: 1e-11, viscosity: 1e-8 };
        for step in 1..=30 {
            let report = run(&mut flow, 1e-3, 1);
            assert!(report.converged, "{report:?}");
            let u = &flow.state.u.cells.data;
            assert!(u.iter().all(|u| u[0] > -1e-9 && u[0] < 1.0 + 1e-9), "out of bounds");
            // Each step may leave what its residual allows, and hardly anything damps it.
            let across = u.iter().map(|u| u[1].abs()).fold(0.0, f64::max);
            assert!(across < 1e-8 * f64::from(step), "across the shear: {across:.1e}");
            assert!(u.iter().all(|u| u[2].abs() < 1e-12), "out of the plane");
        }
    }
}

fn under_a_lid(what: &str, eta: impl Fn(Vec3) -> f64 + Copy + Send + 'static) {
    let n = 20;
    // Creeping flow in one endless step, and short steps with inertia.
    for (dt, rho) in [(STEADY, 1e-9), (1e-3, 1.0)] {
        let poly = rectangle([n, n], [0.0; 2], [1.0; 2], Bent::No);
        let mut numerics = numerics(400, 1);
        numerics.u = solve_loosely("PBiCGStab", "DILU", 1e-6);
        numerics.p = solve_loosely("PCG", "DIC", 1e-6);
        let mut s = Setup::new(&poly, numerics);
        s.rho = rho;
        let lid = |patch: &str| fixed(if patch == "yMax" { [1.0, 0.0, 0.0] } else { [0.0; 3] });
        let mut flow = s.flow(Box::new(Placed(eta)), lid, |_| free());
        for step in 0..3 {
            let report = run(&mut flow, dt, 1);
            let most = greatest(&flow.mesh, |c| norm(flow.state.u.cells.data[c]));
            println!(
                "{what}, dt {dt:.0e}: {} outer, |U| {most:.2}, change {:.1e}, {:?}",
                report.outer, report.change, report.residuals
            );
            assert!(report.converged, "{what}, dt {dt:.0e}, step {step}: {report:?}");
            // Soft cells between stiff ones are jets.
            assert!(most < 2.5, "{what}, dt {dt:.0e}: {most}");
            assert!(step == 0 || dt < 1.0 || report.change < 1e-5, "{what}: {report:?}");
        }
    }
}

/// Viscosity that grows a millionfold from corner to corner.
#[test]
fn smooth_viscosity_under_a_lid() {
    under_a_lid("smooth", |p| 10f64.powf(6.0 * p[0] * p[1] - 3.0));
}

/// Cells of random viscosity, two decades apart.
#[test]
fn random_viscosity_under_a_lid() {
    under_a_lid("two decades", |p| {
        let [i, j] = [p[0], p[1]].map(|x| (x * 20.0).floor());
        10f64.powf(noise(i, j))
    });
}

/// The same, six decades apart.
#[test]
fn millionfold_random_viscosity_under_a_lid() {
    under_a_lid("six decades", |p| {
        let [i, j] = [p[0], p[1]].map(|x| (x * 20.0).floor());
        10f64.powf(3.0 * noise(i, j))
    });
}
