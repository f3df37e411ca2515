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
