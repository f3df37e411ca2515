//! The laws of ARCHITECTURE.md that the flow room can break: the same bits for any number of
//! threads, the same answer for any number of ranks, no allocation after the second step.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;
#[path = "common/counting.rs"]
mod counting;

use common::*;
use counting::ALLOCATIONS;
use granflow_base::{Vec3, norm, sub};
use granflow_flow::{Flow, Numerics, Report};
use granflow_fv::{Convection, LimiterKind};
use granflow_linsolve::Tolerance;
use granflow_mesh::{Mesh, PatchKind, PolyMesh, decompose, partition, shapes};
use granflow_par::{Exec, InProcess, Solo};
use granflow_physics::rheology::{Form, Law, Newtonian, Ngf, NgfNumerics, Rheology};
use std::collections::HashMap;

const RI: f64 = 0.051;
const RO: f64 = 0.063;
const HEIGHT: f64 = 0.01;

/// A sector of the annular cell, 10 mm high.
fn sector(n: [usize; 3]) -> PolyMesh {
    let mut poly = shapes::annular_sector(RI, RO, n, 12);
    poly.points.iter_mut().for_each(|p| p[2] *= HEIGHT);
    poly
}

/// Grains under their own weight and a lid's, sheared by the inner wall, held by the base.
fn annular(exec: Exec, mesh: Mesh, numerics: Numerics, form: Form, own: NgfNumerics) -> Flow {
    let (p, v) = (200.0, 0.02);
    let mut s = Setup::on(exec, mesh, numerics);
    s.gravity.hydrostatic = [0.0, 0.0, -9.81];
    s.p0 = p + RHO_B * 9.81 * HEIGHT;
    // Not axisymmetric, not uniform along the axis: every link of the halo carries something.
    for c in 0..s.mesh.n_cells {
        let [x, y, z] = s.mesh.cell_centre[c];
        let k = 1e-3 * (1.0 + (500.0 * z).sin());
        s.u0[c] = [-k * y / RI, k * x / RI, 0.0];
    }
    let law = Law { grains: BEADS, a: A, form };
    let rheology: Box<dyn Rheology> = Box::new(Ngf::new(law, &s.exec, &s.mesh, Vec::new(), own));
    s.flow(
        rheology,
        |patch| match patch {
            "inner" => turning(v, RI),
            "top" => slip(),
            _ => fixed([0.0; 3]),
        },
        |patch| if patch == "top" { pressure(p) } else { free() },
    )
}

/// How the fluidity is solved: each linear solve by `rel`, Newton down to `residual`.
fn fluidity([name, precond]: [&str; 2], rel: f64, residual: f64) -> NgfNumerics {
    let tolerance = Tolerance { abs: 1e-14, rel, max_iter: 500 };
    NgfNumerics { solver: solver(name, precond), tolerance, residual }
}

/// Walls of the cavity: the lid is `yMax`.
fn square(n: usize) -> PolyMesh {
    shapes::plane_mesh([n, n], [0.0; 2], [1.0; 2], [const { PatchKind::Wall }; 4])
}

/// A Newtonian fluid of unit density in a unit square under a lid of unit speed.
fn cavity(exec: Exec, mesh: Mesh, mut numerics: Numerics) -> Flow {
    let first = mesh.global_cell.iter().position(|&c| c == 0);
    numerics.reference = first.map(|c| (c, 0.0));
    let mut s = Setup::on(exec, mesh, numerics);
    s.rho = 1.0;
    s.flow(
        local(Newtonian { eta: 0.01 }),
        |patch| fixed(if patch == "yMax" { [1.0, 0.0, 0.0] } else { [0.0; 3] }),
        |_| free(),
    )
}

fn run(flow: &mut Flow, dt: f64, steps: usize) -> Report {
    let mut last = Report::default();
    for _ in 0..steps {
        last = flow.step(dt).expect("a step");
    }
    last
}

/// Bits of everything a restart would hold.
fn bits(flow: &Flow) -> [Vec<u64>; 4] {
    let n = flow.mesh.n_cells;
    let of = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    let s = &flow.state;
    let u: Vec<f64> = s.u.cells.data[..n].iter().flatten().copied().collect();
    let g = flow.fluid.rheology.field().map(|g| of(&g.data[..n]));
    [of(&u), of(&s.p.cells.data[..n]), of(&s.phi.data), g.unwrap_or_default()]
}

fn same_bits(what: &str, flow_of: impl Fn(Exec) -> Flow, dt: f64) {
    let run_with = |threads: usize| {
        let mut flow = flow_of(Exec::new(threads, Box::new(Solo)));
        assert!(flow.mesh.n_cells > 10_000, "too small to be split between threads");
        assert_eq!(flow.exec.threads(), threads);
        run(&mut flow, dt, 3);
        bits(&flow)
    };
    let serial = run_with(1);
    assert!(serial[0].iter().any(|&b| f64::from_bits(b) != 0.0), "{what}: nothing moves");
    for threads in [2, 3] {
        let parallel = run_with(threads);
        for (k, name) in ["U", "p", "phi", "fluidity"].iter().enumerate() {
            let first = serial[k].iter().zip(&parallel[k]).position(|(a, b)| a != b);
            assert_eq!(first, None, "{what}, {threads} threads: {name} differs at this entry");
        }
    }
}

#[test]
fn same_bits_for_any_number_of_threads_ngf() {
    let poly = sector([24, 18, 24]);
    for (form, solver) in
        [(Form::Steady, ["PBiCGStab", "DILU"]), (Form::Primitive { t0: 1e-3 }, ["GAMG", "none"])]
    {
        let flow = |exec| {
            let mesh = Mesh::new(&poly).expect("a sound mesh");
            let mut n = numerics(1, 1);
            n.u = solve_loosely("PBiCGStab", "DILU", 1e-2);
            n.p = solve_loosely("GAMG", "none", 1e-2);
            annular(exec, mesh, n, form, fluidity(solver, 1e-2, 1e-3))
        };
        same_bits(&format!("{form:?} {solver:?}"), flow, 1e-3);
    }
}

#[test]
fn same_bits_for_any_number_of_threads_cavity() {
    let poly = square(104);
    let limited = Convection::Limited(LimiterKind::VanLeer(1.0));
    for (convection, u, p) in [
        (limited, ["PBiCGStab", "DILU"], ["PCG", "DIC"]),
        (Convection::LinearUpwind, ["smoothSolver", "none"], ["GAMG", "none"]),
    ] {
        let flow = |exec| {
            let mut n = numerics(1, 2);
            n.convection = convection;
            n.u = solve_loosely(u[0], u[1], 1e-8);
            n.p = solve_loosely(p[0], p[1], 1e-8);
            cavity(exec, Mesh::new(&poly).expect("a sound mesh"), n)
        };
        same_bits(&format!("{convection:?}"), flow, 0.004);
    }
}

/// Values by cell and flux by face of the undecomposed mesh.
#[derive(Default)]
struct Whole {
    u: Vec<Vec3>,
    p: Vec<f64>,
    g: Vec<f64>,
    phi: HashMap<u32, f64>,
}

impl Whole {
    fn take(&mut self, flow: &Flow, n_cells: usize) {
        self.u.resize(n_cells, [f64::NAN; 3]);
        self.p.resize(n_cells, f64::NAN);
        let g = flow.fluid.rheology.field().map(|g| &g.data);
        self.g.resize(if g.is_some() { n_cells } else { 0 }, f64::NAN);
        let m = &flow.mesh;
        for c in 0..m.n_cells {
            let at = m.global_cell[c] as usize;
            self.u[at] = flow.state.u.cells.data[c];
            self.p[at] = flow.state.p.cells.data[c];
            if let Some(g) = g {
                self.g[at] = g[c];
            }
        }
        for (f, &e) in m.poly_face.iter().enumerate() {
            let sign = if e & 1 == 1 { -1.0 } else { 1.0 };
            let phi = sign * flow.state.phi.data[f];
            // Both sides of a processor face hold the same flux.
            if let Some(other) = self.phi.insert(e >> 1, phi) {
                let size = other.abs().max(phi.abs()).max(1e-300);
                assert!(
                    (other - phi).abs() <= 1e-9 * size + 1e-18,
                    "face {}: {phi} {other}",
                    e >> 1
                );
            }
        }
    }
}

/// Greatest differences of U, p, phi and the logarithm of fluidity, relative to each field's size.
fn differences(a: &Whole, b: &Whole) -> [f64; 4] {
    let most = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |m: f64, v| m.max(v));
    let u = most(&mut a.u.iter().map(|u| norm(*u)));
    let du = most(&mut a.u.iter().zip(&b.u).map(|(a, b)| norm(sub(*a, *b))));
    let p = most(&mut a.p.iter().map(|p| p.abs()));
    let dp = most(&mut a.p.iter().zip(&b.p).map(|(a, b)| (a - b).abs()));
    let phi = most(&mut a.phi.values().map(|p| p.abs()));
    let dphi = most(&mut a.phi.iter().map(|(f, v)| (v - b.phi[f]).abs()));
    let dg = most(&mut a.g.iter().zip(&b.g).map(|(a, b)| (a / b).ln().abs()));
    assert!(a.u.iter().chain(&b.u).all(|u| u.iter().all(|x| x.is_finite())));
    [du / u, dp / p, dphi / phi, dg]
}

fn ranks_agree(
    poly: &PolyMesh,
    ranks: usize,
    dt: f64,
    steps: usize,
    flow_of: impl Fn(Exec, Mesh) -> Flow + Sync,
) -> [f64; 4] {
    let n = poly.n_cells();
    let mut serial = Whole::default();
    let mut flow = flow_of(Exec::serial(), Mesh::new(poly).expect("a sound mesh"));
    let reference = run(&mut flow, dt, steps);
    println!(
        "serial: converged {} in {} outer, {:?}",
        reference.converged, reference.outer, reference.residuals
    );
    serial.take(&flow, n);
    let part = partition(poly, ranks);
    let parts = decompose(poly, &part).expect("a sound decomposition");
    let mut together = Whole::default();
    let flow_of = &flow_of;
    std::thread::scope(|scope| {
        let runs: Vec<_> = InProcess::world(ranks)
            .into_iter()
            .zip(parts)
            .map(|(comm, mesh)| {
                scope.spawn(move || {
                    let mut flow = flow_of(Exec::new(1, Box::new(comm)), mesh);
                    let report = run(&mut flow, dt, steps);
                    (flow, report)
                })
            })
            .collect();
        for r in runs {
            let (flow, report) = r.join().expect("a rank");
            assert_eq!(report.converged, reference.converged);
            together.take(&flow, n);
        }
    });
    differences(&serial, &together)
}

/// Converged far below what is compared: ranks precondition differently, so only the solution of
/// the equations is the same.
fn to_the_bottom(mut n: Numerics) -> Numerics {
    n.control = granflow_flow::ResidualControl { u: 1e-11, p: 1e-12, viscosity: 1e-10 };
    n.u = solve_loosely("PBiCGStab", "DILU", 1e-3);
    n.p = solve_loosely("PCG", "DIC", 1e-6);
    n
}

fn ranks_agree_ngf(form: Form, dt: f64) {
    // Cut across the shear band, where the velocity falls by decades.
    let ring = granflow_mesh::shapes::wedge_ring(RI, RO, HEIGHT, 24, 3, 0.5f64.to_radians());
    let d = ranks_agree(&ring, 3, dt, 1, |exec, mesh| {
        let own = fluidity(["PBiCGStab", "DILU"], 1e-4, 1e-11);
        annular(exec, mesh, to_the_bottom(numerics(200, 1)), form, own)
    });
    println!("{form:?}: U p phi ln(g) differ by {}", short(&d));
    assert!(d.iter().all(|d| *d < 1e-8), "{form:?}: {}", short(&d));
}

#[test]
fn ranks_agree_steady_ngf() {
    ranks_agree_ngf(Form::Steady, 1e-3);
}

#[test]
fn ranks_agree_primitive_ngf() {
    ranks_agree_ngf(Form::Primitive { t0: 1e-3 }, 1e-4);
}

#[test]
fn ranks_agree_cavity() {
    let poly = square(40);
    for (u, p) in
        [(["PBiCGStab", "DILU"], ["PCG", "DIC"]), (["smoothSolver", "none"], ["GAMG", "none"])]
    {
        let d = ranks_agree(&poly, 3, 0.01, 3, |exec, mesh| {
            let mut n = numerics(1, 3);
            n.convection = Convection::Limited(LimiterKind::LimitedLinear(1.0));
            n.u = solve(u[0], u[1]);
            n.p = solve(p[0], p[1]);
            cavity(exec, mesh, n)
        });
        println!("{u:?} {p:?}: U p phi differ by {}", short(&d));
        assert!(d.iter().all(|d| *d < 1e-8), "{u:?} {p:?}: {}", short(&d));
    }
}

/// Allocations of steps 3 to 5.
fn allocations(flow: &mut Flow, dt: f64) -> usize {
    run(flow, dt, 2);
    let before = ALLOCATIONS.get();
    let report = run(flow, dt, 3);
    let counted = ALLOCATIONS.get() - before;
    assert!(report.outer > 0);
    counted
}

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    let v = std::hint::black_box(vec![1.0; 100]);
    assert!(ALLOCATIONS.get() > before && v.len() == 100);
}

fn no_allocation_ngf(form: Form, own: [&str; 2], u: [&str; 2], p: [&str; 2]) {
    let mut n = numerics(12, 1);
    n.u = solve_loosely(u[0], u[1], 1e-2);
    n.p = solve_loosely(p[0], p[1], 1e-4);
    let mesh = Mesh::new(&sector([12, 4, 4])).expect("a sound mesh");
    let mut flow = annular(Exec::serial(), mesh, n, form, fluidity(own, 1e-4, 1e-8));
    let count = allocations(&mut flow, 1e-3);
    assert_eq!(count, 0, "{form:?} {own:?} {u:?} {p:?}: allocations in steps 3 to 5");
}

#[test]
fn no_allocation_after_the_second_step_ngf_krylov() {
    for form in [Form::Steady, Form::Primitive { t0: 1e-3 }] {
        no_allocation_ngf(form, ["PBiCGStab", "DILU"], ["PBiCGStab", "DILU"], ["PCG", "DIC"]);
    }
}

#[test]
fn no_allocation_after_the_second_step_ngf_gamg() {
    no_allocation_ngf(Form::Steady, ["PBiCGStab", "DILU"], ["GAMG", "none"], ["GAMG", "none"]);
}

#[test]
fn no_allocation_after_the_second_step_primitive_ngf_gamg() {
    let form = Form::Primitive { t0: 1e-3 };
    no_allocation_ngf(form, ["PBiCGStab", "DILU"], ["GAMG", "none"], ["PCG", "GAMG"]);
}

#[test]
fn no_allocation_after_the_second_step_piso() {
    let poly = square(40);
    let mut found = Vec::new();
    for (u, p) in [
        (["PBiCGStab", "DILU"], ["PCG", "DIC"]),
        (["smoothSolver", "none"], ["GAMG", "none"]),
        (["GAMG", "none"], ["PCG", "GAMG"]),
    ] {
        let mut n = numerics(1, 2);
        n.convection = Convection::Limited(LimiterKind::Muscl(1.0));
        n.u = solve_loosely(u[0], u[1], 1e-6);
        n.p = solve_loosely(p[0], p[1], 1e-6);
        let mut flow = cavity(Exec::serial(), Mesh::new(&poly).expect("a sound mesh"), n);
        let count = allocations(&mut flow, 0.01);
        println!("{u:?} {p:?}: {count} allocations");
        if count > 0 {
            found.push(format!("{u:?} {p:?}: {count}"));
        }
    }
    assert!(found.is_empty(), "allocations in steps 3 to 5: {found:?}");
}

/// A step that is given up leaves the state as it was, to the bit, and the flow can go on.
#[test]
fn a_step_that_is_stopped_never_was() {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    let mesh = || Mesh::new(&square(8)).expect("a mesh");
    let lid_driven = || cavity(Exec::serial(), mesh(), numerics(1, 2));
    let (mut stopped, mut plain) = (lid_driven(), lid_driven());
    let stop = Arc::new(AtomicBool::new(false));
    stopped.stop = Some(stop.clone());
    stopped.step(1e-3).expect("a step");
    plain.step(1e-3).expect("a step");
    let before = (stopped.state.u.cells.data.clone(), stopped.state.p.cells.data.clone());
    stop.store(true, Ordering::Relaxed);
    let said = stopped.step(1e-3).map(|_| ());
    assert!(matches!(said, Err(granflow_flow::StepError::Interrupted { .. })), "{said:?}");
    assert_eq!((stopped.state.time, stopped.state.step), (plain.state.time, 1));
    assert_eq!(before, (stopped.state.u.cells.data.clone(), stopped.state.p.cells.data.clone()));
    stop.store(false, Ordering::Relaxed);
    stopped.step(1e-3).expect("a step");
    plain.step(1e-3).expect("a step");
    assert_eq!(stopped.state.u.cells.data, plain.state.u.cells.data);
}
