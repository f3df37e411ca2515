//! Outer iterations where convection rules: cells of triangles that the flow crosses faster than
//! viscosity does, by every scheme, with steps from the time a cell is crossed in to endless ones.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_flow::{Flow, ResidualControl, Solve};
use granflow_fv::{Convection, LimiterKind};
use granflow_linsolve::{SolverSpec, build};
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::Newtonian;

/// A chamber of 16 by 16 squares of unit size, two triangles each, that is flown through from left
/// to right at unit speed over a floor that moves three times as fast.
fn chamber(convection: Convection, eta: f64, solver: &str) -> Flow {
    let mut kinds = shapes::periodic_kinds([false, false, true], PatchKind::Wall);
    (kinds[0], kinds[1]) = (PatchKind::Patch, PatchKind::Patch);
    let poly = shapes::prism_box([16, 16, 1], [0.0; 3], [16.0, 16.0, 1.0], kinds);
    let poly = shapes::displaced(&poly, 0.1, 7);
    let mut s = Setup::new(&poly, numerics(50, 1));
    s.rho = 1.0;
    s.numerics.convection = convection;
    s.numerics.control = ResidualControl { u: 1e-8, p: 1e-8, viscosity: 1e-8 };
    if solver == "smoothSolver" {
        let smoother = Some("symGaussSeidel".into());
        let spec = SolverSpec { solver: solver.into(), preconditioner: None, smoother };
        let solver = build(&spec).expect("a known solver");
        s.numerics.u = Solve { solver, tolerance: tight(), last: tight() };
    }
    s.flow(
        local(Newtonian { eta }),
        |patch| match patch {
            "xMin" => fixed([1.0, 0.0, 0.0]),
            "xMax" => free(),
            "yMin" => fixed([3.0, 0.0, 0.0]),
            _ => fixed([0.0; 3]),
        },
        |patch| if patch == "xMax" { fixed(0.0) } else { free() },
    )
}

fn limited(name: &str) -> Convection {
    Convection::Limited(LimiterKind::parse(name, 1.0).expect("a known limiter"))
}

fn converges(convection: Convection, eta: f64, solver: &str, dt: f64) -> usize {
    let mut most = 0;
    let mut flow = chamber(convection, eta, solver);
    for _ in 0..2 {
        let what = format!("{} {solver} eta {eta} dt {dt}", convection.name());
        let r = flow.step(dt).unwrap_or_else(|e| panic!("{what}: {e}"));
        println!("{what}: {} passes {:?}", r.outer, r.residuals);
        assert!(r.converged, "{what}: {r:?}");
        assert!(r.solves.iter().all(|s| s.all >= r.outer), "solves are counted: {r:?}");
        most = most.max(r.outer);
    }
    most
}

#[test]
fn every_scheme_converges_with_every_step() {
    let schemes = [Convection::Upwind, Convection::Linear, Convection::LinearUpwind];
    let limited = ["limitedLinear", "vanLeer", "Minmod"].map(limited);
    for convection in schemes.into_iter().chain(limited) {
        for dt in [1.0, 1e3, 1e6] {
            converges(convection, 0.5, "PBiCGStab", dt);
        }
    }
}

/// Where nothing but convection holds a cell back, its mobility must know convection.
#[test]
fn endless_steps_converge_where_convection_rules() {
    for dt in [1e3, 1e6] {
        let passes = converges(Convection::Upwind, 0.02, "PBiCGStab", dt);
        assert!(passes <= 25, "dt {dt}: {passes} passes");
    }
}

/// Sweeps grow without bounds on a matrix of central differences that is far from dominant.
#[test]
fn sweeps_that_diverge_are_replaced() {
    for dt in [1.0, 1e3] {
        converges(Convection::Linear, 0.1, "smoothSolver", dt);
        converges(limited("limitedLinear"), 0.5, "smoothSolver", dt);
    }
}

/// Whatever a step came to, what is transported with its flux is conserved.
#[test]
fn the_flux_of_an_unconverged_step_is_divergence_free() {
    let mut flow = chamber(Convection::Upwind, 0.02, "PBiCGStab");
    flow.numerics.outer = 2;
    let r = flow.step(1e6).expect("a step");
    assert!(!r.converged && r.residuals.p > 1e-6, "{r:?}");
    let (m, phi) = (&flow.mesh, &flow.state.phi.data);
    let net = greatest(m, |c| m.faces_of(c).map(|(f, s)| s * phi[f]).sum::<f64>().abs());
    println!("net flux {net:.1e}, residual of continuity {:.1e}", r.residuals.p);
    assert!(net < 1e-7, "{net:.1e}");
}

/// The mean Courant number is that of the whole volume: cells count by their size.
#[test]
fn the_mean_courant_number_is_a_mean_over_the_volume() {
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let mut poly = shapes::box_mesh([4, 3, 1], [0.0; 3], [4.0, 3.0, 1.0], kinds);
    // Rows of heights 1/9, 8/9 and 2.
    poly.points.iter_mut().for_each(|p| p[1] = [0.0, 1.0 / 9.0, 1.0, 3.0][p[1].round() as usize]);
    let mut s = Setup::new(&poly, numerics(1, 1));
    let slow = |y: f64| if y < 0.1 { 10.0 } else { 1.0 };
    s.u0 = (0..12).map(|c| [slow(s.mesh.cell_centre[c][1]), 0.0, 0.0]).collect();
    // Viscosity and pressure have nothing to say in so short a step.
    let mut flow = s.flow(local(Newtonian { eta: 1e-9 }), |_| slip(), |_| free());
    let (m, u) = (flow.mesh.clone(), flow.state.u.cells.data.clone());
    let through = |f: usize| m.area[f][0] * u[m.owner[f] as usize][0];
    flow.state.phi.data.iter_mut().enumerate().for_each(|(f, phi)| *phi = through(f));
    let dt = 1e-6;
    flow.step(dt).expect("a step");
    let [mean, most] = flow.step(dt).expect("a step").courant;
    // Unit cells along x: u dt each; a ninth of a third of the volume is fast.
    let exact = dt * (10.0 / 27.0 + 26.0 / 27.0);
    assert!((mean / exact - 1.0).abs() < 1e-6 && (most / (10.0 * dt) - 1.0).abs() < 1e-6, "{mean}");
}
