//! The steady state found directly: beside marching, over speeds and meshes, with inertia, and where there is none.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_flow::{Flow, Report, ResidualControl, StepError, TimeScheme};
use granflow_fv::TimeFunction;
use granflow_fv::conditions::{CoulombFriction, UniformFixedValue};
use granflow_fv::{Condition, Convection};
use granflow_linsolve::Tolerance;
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::{
    Bingham, Form, Granular, HerschelBulkley, Law, LocalLaw, MuI, Newtonian, Ngf, NgfNumerics,
    Point, PowerLaw, Rheology,
};

const TIGHT: ResidualControl = ResidualControl { u: 1e-8, p: 1e-8, viscosity: 1e-8 };

fn steady(outer: usize) -> granflow_flow::Numerics {
    let mut n = numerics(outer, 1);
    (n.ddt, n.control) = (TimeScheme::Steady, TIGHT);
    n
}

fn found(flow: &mut Flow, what: &str) -> Report {
    let report = flow.step(1.0).unwrap_or_else(|e| panic!("{what}: {e}"));
    println!("{what}: {} passes, {:?}", report.outer, report.residuals);
    assert!(report.converged && report.steady, "{what}: {:?}", report.residuals);
    assert!(report.residuals.within(&TIGHT), "{what}");
    // Measured once more on the fields alone.
    let again = flow.residuals().expect("residuals");
    assert!(again.u < 1e-7 && again.p < 1e-7 && again.viscosity < 1e-5, "{what}: {again:?}");
    report
}

/// The annular cell on `n` cells over 16 grains, the wall at `v`.
fn annular(n: usize, v: f64, form: Form) -> Flow {
    let poly = shapes::wedge_ring(0.051, 0.063, 0.0001, n, 1, 0.5f64.to_radians());
    let mut s = Setup::new(&poly, steady(150));
    s.p0 = 1000.0;
    // What the fluidity's own equation leaves is noise of the viscosity.
    let numerics = NgfNumerics {
        solver: solver("PBiCGStab", "DILU"),
        tolerance: Tolerance { abs: 1e-12, rel: 1e-2, max_iter: 500 },
        residual: 1e-12,
    };
    let law = Law { grains: BEADS, a: A, form };
    let rheology = Box::new(Ngf::new(law, &s.exec, &s.mesh, Vec::new(), numerics));
    s.flow(
        rheology,
        |patch| match patch {
            "inner" => fixed([0.0, v, 0.0]),
            "outer" => fixed([0.0; 3]),
            _ => slip(),
        },
        |patch| if patch == "outer" { fixed(1000.0) } else { free() },
    )
}

/// From rest, every speed by itself, both forms: with four times the cells the passes grow by less than half.
#[test]
fn the_annular_cell_at_any_speed_and_mesh() {
    for form in [Form::Steady, Form::Primitive { t0: 1e-3 }] {
        for v in [1e-6, 1e-4, 1e-2, 1e-1] {
            let [coarse, fine] = [32, 128].map(|n| {
                found(&mut annular(n, v, form), &format!("{form:?}, {v:.0e} m/s, {n} cells")).outer
            });
            assert!(2 * fine < 3 * coarse, "{v}: {coarse} and {fine} passes");
        }
    }
}

/// What is found is what marching ends on.
#[test]
fn marching_ends_there() {
    let v = 1e-3;
    let mut direct = annular(64, v, Form::Steady);
    found(&mut direct, "directly");
    let mut marched = annular(64, v, Form::Steady);
    marched.numerics.ddt = TimeScheme::Euler;
    for _ in 0..60 {
        assert!(marched.step(0.05).expect("a step").converged);
    }
    let (a, b) = (&direct.state.u.cells.data, &marched.state.u.cells.data);
    let apart = greatest(&direct.mesh, |c| granflow_base::norm(granflow_base::sub(a[c], b[c])));
    println!("apart by {:.1e} of the wall's speed", apart / v);
    assert!(apart < 1e-6 * v, "{apart}");
}

/// A plane channel 1 m wide under a pull along it: of laws without a memory.
fn channel(rheology: Box<dyn Rheology>, rho: f64, pull: f64, p: f64) -> Flow {
    let h = 1.0 / 40.0;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([1, 40, 1], [0.0; 3], [h, 1.0, h], kinds);
    let mut s = Setup::new(&poly, steady(150));
    (s.rho, s.p0) = (rho, p);
    s.gravity.driving = [pull, 0.0, 0.0];
    s.flow(rheology, |_| fixed([0.0; 3]), |_| pressure(p))
}

/// A power law whose kinematic viscosity is its dynamic one.
struct OfUnitDensity(PowerLaw);
impl LocalLaw for OfUnitDensity {
    fn viscosity(&self, at: Point) -> f64 {
        self.0.nu(at.strain_rate)
    }
}

#[test]
fn laws_without_a_field_of_their_own() {
    let beads = Granular { d: 0.02, ..BEADS };
    type Law = (&'static str, Box<dyn Rheology>, f64, f64, f64);
    let laws: [Law; 5] = [
        ("Newtonian", local(Newtonian { eta: 2.0 }), 1.0, 8.0, 0.0),
        (
            "power law",
            local(OfUnitDensity(PowerLaw { k: 2.0, n: 0.5, nu: [1e-6, 1e6] })),
            1.0,
            8.0,
            0.0,
        ),
        ("Bingham", local(Bingham { tau0: 1.0, nu: 2.0, nu0: 2e6, density: 1.0 }), 1.0, 8.0, 0.0),
        (
            "Herschel-Bulkley",
            local(HerschelBulkley { tau0: 1.0, k: 2.0, n: 0.6, nu0: 2e6, density: 1.0 }),
            1.0,
            8.0,
            0.0,
        ),
        ("mu(I)", local(MuI(beads)), RHO_B, 0.9 * 1000.0 / RHO_B, 1000.0),
    ];
    for (name, law, rho, pull, p) in laws {
        let mut flow = channel(law, rho, pull, p);
        found(&mut flow, name);
        if name == "Newtonian" {
            let exact = |y: f64| 0.5 * 8.0 / 2.0 * y * (1.0 - y);
            let u = &flow.state.u.cells.data;
            let e = greatest(&flow.mesh, |c| (u[c][0] - exact(flow.mesh.cell_centre[c][1])).abs());
            assert!(e < 2e-3, "{e}");
        }
    }
}

/// A cavity of unit size and density on n x n cells below a lid.
fn cavity(n: usize, nu: f64, lid: f64) -> Flow {
    let kinds = shapes::periodic_kinds([false, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([n, n, 1], [0.0; 3], [1.0, 1.0, 1.0 / n as f64], kinds);
    let mut s = Setup::new(&poly, steady(150));
    s.numerics.convection = Convection::Linear;
    // As a case has it.
    s.numerics.u = solve("GAMG", "none");
    s.numerics.p = solve("GAMG", "none");
    s.numerics.compression = solver("GAMG", "none");
    s.rho = 1.0;
    let velocity = |patch: &str| fixed([if patch == "yMax" { lid } else { 0.0 }, 0.0, 0.0]);
    s.flow(local(Newtonian { eta: nu }), velocity, |_| free())
}

/// A lid-driven cavity with inertia: U_x of the vertical middle at its least, U. Ghia, K. N. Ghia, C. T. Shin, J.
/// Comput. Phys. 48 (1982) 387, table I: -0.21090 at Re 100, -0.32726 at Re 400.
#[test]
fn a_cavity_with_inertia() {
    for (re, least) in [(100.0, -0.2109), (400.0, -0.32726)] {
        let n = 64;
        let mut flow = cavity(n, 1.0 / re, 1.0);
        found(&mut flow, &format!("cavity, Re {re}"));
        let (m, u) = (&flow.mesh, &flow.state.u.cells.data);
        let beside = |c: &usize| (m.cell_centre[*c][0] - 0.5).abs() < 0.6 / n as f64;
        let ours = (0..m.n_cells).filter(beside).map(|c| u[c][0]).fold(0.0, f64::min);
        println!("least U_x {ours}, Ghia {least}");
        assert!((ours / least - 1.0).abs() < 0.03, "{ours} {least}");
    }
}

/// Within 0.5 % of the lid's speed on 128 x 128 cells.
#[test]
fn a_cavity_meets_ghia_on_128_cells() {
    let n = 128;
    for (k, re) in [(1, 100.0), (2, 400.0), (3, 1000.0)] {
        let mut flow = cavity(n, 1.0 / re, 1.0);
        let report = found(&mut flow, &format!("cavity, Re {re}, {n} cells"));
        // With the carrying flux held all the way Re 400 takes 25.
        assert!(report.outer <= 12, "Newton's method is not at work: {} passes", report.outer);
        let (m, u) = (&flow.mesh, &flow.state.u.cells.data);
        // The two columns of cells beside the middle.
        let mut line = vec![0.0; n];
        for c in (0..m.n_cells).filter(|c| (m.cell_centre[*c][0] - 0.5).abs() < 0.6 / n as f64) {
            line[(m.cell_centre[c][1] * n as f64) as usize] += 0.5 * u[c][0];
        }
        let at = |y: f64| {
            let x = y * n as f64 - 0.5;
            let first = (x as usize).saturating_sub(1).min(n - 4);
            let weight = |i: usize| -> f64 {
                let others = (0..4).filter(|j| *j != i);
                others.map(|j| (x - (first + j) as f64) / (i as f64 - j as f64)).product()
            };
            (0..4).map(|i| weight(i) * line[first + i]).sum::<f64>()
        };
        let off = GHIA.iter().map(|row| (at(row[0]) - row[k]).abs()).fold(0.0, f64::max);
        println!("Re {re}: at most {off:.4} of the lid's speed from Ghia et al.");
        assert!(off < 5e-3, "Re {re}: {off}");
    }
}

const D: f64 = 0.5e-3;

/// Half of the heap of model.md, section 6, two cells a grain, at an angle.
fn heap(degrees: f64) -> Flow {
    let grains = Granular { d: D, ..BEADS };
    let mut kinds = shapes::periodic_kinds([true, false, false], PatchKind::Wall);
    kinds[5] = PatchKind::Patch;
    let poly = shapes::box_mesh([1, 19, 40], [0.0; 3], [0.5 * D, 9.5 * D, 20.0 * D], kinds);
    let mut s = Setup::new(&poly, steady(150));
    let (sin, cos) = degrees.to_radians().sin_cos();
    s.gravity.driving = [9.81 * sin, 0.0, 0.0];
    s.gravity.hydrostatic = [0.0, 0.0, -9.81 * cos];
    s.p0 = s.rho * 9.81 * cos * 20.0 * D;
    let (rheology, n_inner) = (ngf(&s.exec, &s.mesh, grains, Form::Steady), s.mesh.n_inner);
    let wall = || -> Box<dyn Condition<_>> {
        Box::new(CoulombFriction { mu: 0.32, wall_velocity: [0.0; 3], n_inner })
    };
    s.flow(
        rheology,
        |patch| match patch {
            "yMin" => slip(),
            "yMax" => wall(),
            "zMin" => fixed([0.0; 3]),
            _ => free(),
        },
        |patch| if patch == "zMax" { pressure(0.0) } else { free() },
    )
}

/// On a heap a steady flow needs tan^2(theta) + mu_wall^2 < mu_2^2: up to 29.17 degrees. What is steeper is
/// refused with the reason, and the state is that before the step.
#[test]
fn a_heap_too_steep_has_no_steady_state() {
    for degrees in [26.0, 29.0] {
        found(&mut heap(degrees), &format!("heap, {degrees} degrees"));
    }
    for degrees in [29.4, 31.0] {
        let mut flow = heap(degrees);
        let e = flow.step(1.0).expect_err("a refusal");
        println!("heap, {degrees} degrees: {e}");
        assert!(matches!(e, StepError::Beyond { .. }), "{degrees}: {e}");
        flow.rollback();
        let fastest = greatest(&flow.mesh, |c| granflow_base::norm(flow.state.u.cells.data[c]));
        assert!(fastest == 0.0 && flow.state.step == 0 && flow.state.time == 0.0, "{fastest}");
    }
}

/// Where too few passes find nothing, what is taken back is all of the pseudo-time, of which some steps were
/// accepted: velocity, pressure and flux are those before the step.
#[test]
fn a_step_that_finds_nothing_is_taken_back_whole() {
    let state = |f: &Flow| {
        let s = &f.state;
        (s.u.cells.data.clone(), s.p.cells.data.clone(), s.phi.data.clone(), (s.time, s.step))
    };
    let mut flow = cavity(20, 1e-2, 1e-4);
    found(&mut flow, "before");
    let before = state(&flow);
    let lid = flow.mesh.patches.iter().position(|p| p.name == "yMax").expect("the lid");
    flow.state.u.conditions[lid] = fixed([1000.0, 0.0, 0.0]);
    flow.numerics.outer = 1;
    let e = flow.step(1.0).expect_err("one pass is too few");
    println!("{e}");
    assert!(matches!(e, StepError::NoSteadyState { .. }), "{e}");
    flow.rollback();
    assert!(state(&flow) == before, "the state is another one");
}

/// The uniform root mu = mu_s of the fluidity equation is no guess that sticks.
#[test]
fn the_spurious_root_is_left() {
    let v = 1e-3;
    let mut right = annular(64, v, Form::Steady);
    found(&mut right, "from rest");
    let mut flow = annular(64, v, Form::Steady);
    let rate = v / 0.012;
    let g = flow.fluid.rheology.field_mut().expect("fluidity");
    g.data.iter_mut().for_each(|g| *g = rate / BEADS.mu_s);
    found(&mut flow, "from mu = mu_s");
    let (a, b) = (&right.state.u.cells.data, &flow.state.u.cells.data);
    let apart = greatest(&flow.mesh, |c| granflow_base::norm(granflow_base::sub(a[c], b[c])));
    assert!(apart < 1e-6 * v, "{apart}");
}

/// Conditions that change with time are seen, constant ones are not.
#[test]
fn conditions_that_stay_are_told_from_those_that_change() {
    let mut flow = annular(16, 1e-3, Form::Steady);
    assert!(flow.conditions_stay(1.0, 100.0));
    let ramp =
        TimeFunction::table(vec![(0.0, [0.0; 3]), (50.0, [0.0, 1e-3, 0.0])]).expect("sorted");
    flow.state.u.conditions[0] = Box::new(UniformFixedValue { value: ramp });
    assert!(!flow.conditions_stay(1.0, 100.0));
}
