//! Momentum feels no more than some viscosity of grains beside a fluid: no result may hang on how much.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod two_common;

use granflow_flow::vof::Shape;
use granflow_flow::{Stiffest, TimeScheme};
use granflow_fv::conditions::CoulombFriction;
use granflow_linsolve::Tolerance;
use granflow_mesh::{Mesh, PatchKind, shapes};
use granflow_par::Exec;
use granflow_physics::rheology::{Floors, Form, Granular, Law, Ngf, NgfNumerics, Rheology};
use two_common::*;

/// Diameter of a grain, m, and of a cell.
const D: f64 = 0.5e-3;

fn ngf(exec: &Exec, mesh: &Mesh) -> Box<dyn Rheology> {
    let floors = Floors::DEFAULT;
    let grains = Granular { mu_s: 0.3819, mu_2: 0.6435, i0: 0.279, d: D, rho_s: 2450.0, floors };
    let numerics = NgfNumerics {
        solver: solver("PBiCGStab", "DILU"),
        tolerance: Tolerance { abs: 1e-12, rel: 1e-10, max_iter: 500 },
        residual: 1e-10,
    };
    Box::new(Ngf::new(
        Law { grains, a: 0.48, form: Form::Steady },
        exec,
        mesh,
        Vec::new(),
        numerics,
    ))
}

/// Half of the heap of `cases/heap_flow` in its steady state, one cell a grain: velocities of the grains over the
/// greatest, with `part` of the usual greatest viscosity that momentum feels.
fn heap(part: f64) -> Vec<f64> {
    let (half, deep, all) = (9.5 * D, 20.0 * D, 24.0 * D);
    let kinds = shapes::periodic_kinds([true, false, false], PatchKind::Wall);
    let poly = shapes::box_mesh([1, 10, 24], [0.0; 3], [D, half, all], kinds);
    let n_inner = Mesh::new(&poly).expect("a sound mesh").n_inner;
    let mut two = water_and_air(&poly, Shape::cuboid([-1.0; 3], [1.0, 1.0, deep]));
    let (sin, cos) = 28f64.to_radians().sin_cos();
    (two.driving, two.gravity) = ([9.81 * sin, 0.0, 0.0], [0.0, 0.0, -9.81 * cos]);
    (two.rho, two.eta[1]) = ([1519.0, 15.3125], 4.796e-3);
    (two.geometric, two.rheology) = (true, Some(ngf as Model));
    let Stiffest { beside, own } = Stiffest::DEFAULT;
    two.stiffest = Stiffest { beside: part * beside, own: part * own };
    (two.numerics.ddt, two.numerics.outer) = (TimeScheme::Steady, 150);
    let mut flow = two.flow(|patch| match patch {
        "yMin" | "zMax" => slip(),
        "yMax" => Box::new(CoulombFriction { mu: 0.32, wall_velocity: [0.0; 3], n_inner }),
        _ => wall(),
    });
    let report = flow.step(1.0).expect("a step");
    assert!(report.converged, "{part}: {:?}", report.residuals);
    let full = |c: &usize| alpha(&flow)[*c] > 0.5;
    let of_grains = (0..flow.mesh.n_cells).filter(full);
    let u: Vec<f64> = of_grains.map(|c| flow.state.u.cells.data[c][0]).collect();
    let most = u.iter().copied().fold(0.0, f64::max);
    u.iter().map(|u| u / most).collect()
}

/// A thousand times more or less makes no difference, nor does all that is above the stiffest grains (450 Pa s); below
/// them it shows.
#[test]
fn what_momentum_feels_at_most_does_not_show_in_the_heap() {
    let usual = heap(1.0);
    let off = |part: f64| {
        let with = heap(part);
        let off = usual.iter().zip(&with).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{part:.0e} of the usual: {off:.1e}");
        off
    };
    for part in [1e3, 1e-3, 1e-4, 1e-7] {
        assert!(off(part) < 1e-4, "{part}");
    }
    assert!(off(1e-8) > 1e-3);
}
