//! Slopes steeper than the friction of grains can hold, and what is said of them.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_flow::{Flow, StepError};
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::{Beyond, Form, MuI};

/// Grains 20 deep down an incline of slope `tan`, from rest.
fn incline(tan: f64, nonlocal: bool) -> Flow {
    let (g, depth, n) = (9.81, 20.0 * BEADS.d, 20);
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let h = depth / n as f64;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [h, depth, h], kinds);
    let mut s = Setup::new(&poly, numerics(150, 1));
    s.gravity.hydrostatic = [0.0, -g * cos, 0.0];
    s.gravity.driving = [g * tan * cos, 0.0, 0.0];
    s.p0 = RHO_B * g * cos * depth;
    let rheology =
        if nonlocal { ngf(&s.exec, &s.mesh, BEADS, Form::Steady) } else { local(MuI(BEADS)) };
    s.flow(
        rheology,
        |patch| if patch == "yMax" { slip() } else { fixed([0.0; 3]) },
        |patch| if patch == "yMax" { pressure(0.0) } else { free() },
    )
}

/// No steady flow exists, and inertia makes up for what friction lacks: after a second the grains
/// slide at some metres a second, after ten friction has given all it has.
#[test]
fn a_steep_slope_says_how_much_friction_it_uses() {
    let mut flow = incline(0.75, false);
    let report = flow.step(1.0).expect("a step");
    assert!(report.converged && report.rheology.beyond.is_none(), "{report:?}");
    let mut flow = incline(0.75, false);
    let report = flow.step(1e1).expect("a step");
    let beyond = report.rheology.beyond.expect("friction is used up");
    println!("{beyond:?} {:?}", report.residuals);
    // The tangent of friction all but vanishes there, and the passes end at rounding.
    assert!(report.residuals.u < 1e-7, "{report:?}");
    let delta = BEADS.mu_2 - BEADS.mu_s;
    assert!(beyond.mu > BEADS.mu_2 - 0.03 * delta && beyond.mu < BEADS.mu_2, "{beyond:?}");
    assert!(beyond.inertial < 1e3, "{beyond:?}");
}

/// A start at a million metres a second, up and down from cell to cell, and an endless step: it does
/// not converge, and what is said of friction is no more than grains carry, wherever the iteration
/// has been. (At a viscosity of another trial it once said mu = 1.7e8.)
#[test]
fn an_iteration_that_lost_its_way_says_no_more_than_grains_carry() {
    let mut flow = incline(0.75, false);
    for (c, u) in flow.state.u.cells.data.iter_mut().enumerate() {
        *u = [1e6 * (7.3 * c as f64).sin(), 0.0, 0.0];
    }
    match flow.step(1e6) {
        Ok(report) => {
            println!("{report:?}");
            assert!(report.outer < 150, "nobody waits for what has stopped moving: {report:?}");
            assert!(!report.converged, "{report:?}");
            let sound = |b: &Beyond| b.mu > 0.9 * b.mu_2 && b.mu <= b.mu_2;
            assert!(report.rheology.beyond.as_ref().is_none_or(sound), "{report:?}");
        }
        Err(e) => assert!(!matches!(e, StepError::Beyond { .. }), "{e}"),
    }
}
