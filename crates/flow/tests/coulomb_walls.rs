//! Walls with Coulomb friction: they hold as far as mu P reaches, and drag with mu P beyond.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;
#[path = "common/counting.rs"]
mod counting;

use common::*;
use counting::ALLOCATIONS;
use granflow_base::Vec3;
use granflow_flow::{Flow, Report, ResidualControl};
use granflow_fv::Condition;
use granflow_fv::conditions::CoulombFriction;
use granflow_mesh::{PatchKind, shapes};
use granflow_physics::rheology::{Bingham, Form, Granular, Newtonian, Rheology};

const RHO: f64 = 1000.0;
/// Pressure on all walls, Pa.
const P: f64 = 800.0;
const ETA: f64 = 125.0;
const CELLS: usize = 32;

/// A channel of unit width along x and z, under the pressure P and a body force of `pull` m/s2
/// along x; velocity conditions of its two walls.
fn channel(
    pull: f64,
    rheology: Box<dyn Rheology>,
    walls: [&dyn Fn(usize) -> Box<dyn Condition<Vec3>>; 2],
) -> Flow {
    let h = 1.0 / CELLS as f64;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([1, CELLS, 1], [0.0; 3], [h, 1.0, h], kinds);
    let mut s = Setup::new(&poly, numerics(60, 1));
    s.rho = RHO;
    s.p0 = P;
    s.gravity.driving = [pull, 0.0, 0.0];
    let n_inner = s.mesh.n_inner;
    let wall = |name: &str| walls[usize::from(name == "yMax")](n_inner);
    s.flow(rheology, wall, |_| pressure(P))
}

fn coulomb(mu: f64, wall_velocity: Vec3) -> impl Fn(usize) -> Box<dyn Condition<Vec3>> {
    move |n_inner| Box::new(CoulombFriction { mu, wall_velocity, n_inner })
}

fn newtonian() -> Box<dyn Rheology> {
    local(Newtonian { eta: ETA })
}

/// Greatest difference of the velocity from `exact(y)`, over `size`.
fn error(flow: &Flow, size: f64, exact: impl Fn(f64) -> Vec3) -> f64 {
    let m = &flow.mesh;
    greatest(m, |c| {
        let d = granflow_base::sub(flow.state.u.cells.data[c], exact(m.cell_centre[c][1]));
        granflow_base::norm(d)
    }) / size
}

fn converged(flow: &mut Flow, dt: f64, steps: usize) -> Report {
    let mut last = Report::default();
    for _ in 0..steps {
        last = flow.step(dt).expect("a step");
        assert!(last.converged, "{last:?}");
    }
    last
}

/// One wall holds, the other has friction. What the body force asks of the latter is rho G H/2 =
/// 500 Pa if it sticks: mu P from 0 to 499 slides, with
/// `u = rho G (H y - y^2/2)/eta - mu P y/eta`, and from 501 sticks, with Poiseuille's profile.
#[test]
fn a_wall_sticks_below_its_threshold_and_slides_above() {
    for traction in [0.0, 100.0, 400.0, 499.0, 501.0, 600.0, 1e9] {
        let still = |_| fixed([0.0; 3]);
        let mut flow = channel(1.0, newtonian(), [&still, &coulomb(traction / P, [0.0; 3])]);
        let report = converged(&mut flow, 1e9, 1);
        let held: f64 = f64::min(traction, 500.0);
        let exact = |y: f64| [(RHO * (y - 0.5 * y * y) - held * y) / ETA, 0.0, 0.0];
        let top = flow.mesh.patches.iter().position(|p| p.name == "yMax").expect("the wall");
        let f = flow.mesh.patches[top].faces.start;
        let slip = flow.state.u.boundary_value(&flow.mesh, f)[0];
        let (wrong, off) = (error(&flow, 1.0, exact), (slip - exact(1.0)[0]).abs());
        println!("mu P = {traction}: {} passes, {wrong:.1e}, slip {slip:.6}", report.outer);
        // Second order: the wall's half cell is off by rho G h^2/(8 eta).
        assert!(wrong < 2e-3 && off < 3e-3, "{wrong} {off}");
        assert!(traction < 500.0 || slip == 0.0, "{slip}");
        assert!(report.outer <= 10, "{report:?}");
    }
}

/// Both walls have friction: beyond it the channel moves off as a whole, and each second it gains
/// G - 2 mu P/(rho H).
#[test]
fn what_no_wall_holds_gathers_speed() {
    let wall = coulomb(0.5, [0.0; 3]);
    let mut flow = channel(0.75, newtonian(), [&wall, &wall]);
    converged(&mut flow, 1e3, 1);
    assert!(error(&flow, 1.0, |y| [0.375 * RHO * y * (1.0 - y) / ETA, 0.0, 0.0]) < 1e-3);
    let mut flow = channel(1.0, newtonian(), [&wall, &wall]);
    converged(&mut flow, 20.0, 4);
    let mean = |f: &Flow| f.state.u.cells.data.iter().take(CELLS).map(|u| u[0]).sum::<f64>();
    let before = mean(&flow) / CELLS as f64;
    converged(&mut flow, 20.0, 1);
    let gained = mean(&flow) / CELLS as f64 - before;
    println!("gained {gained}");
    assert!((gained - 20.0 * (1.0 - 0.8)).abs() < 1e-6, "{gained}");
    // The walls stop it again.
    flow.gravity.driving = [0.0; 3];
    let mut stopping = channel(0.0, newtonian(), [&wall, &wall]);
    stopping.state.u.cells.data.copy_from_slice(&flow.state.u.cells.data);
    converged(&mut stopping, 100.0, 5);
    let left = greatest(&stopping.mesh, |c| granflow_base::norm(stopping.state.u.cells.data[c]));
    println!("left {left:.1e}");
    assert!(left < 1e-6, "{left}");
}

/// A wall that moves askew drags along its own velocity, wherever the start pointed.
#[test]
fn the_drag_points_along_the_sliding() {
    let still = |_| fixed([0.0; 3]);
    for rheology in
        [newtonian, || local(Bingham { tau0: 0.02, nu: ETA / RHO, nu0: 1e3, density: RHO })]
    {
        let mut flow = channel(0.0, rheology(), [&still, &coulomb(0.25, [3.0, 7.0, 4.0])]);
        for u in &mut flow.state.u.cells.data {
            *u = [-20.0, 0.0, 9.0];
        }
        let report = converged(&mut flow, 1e9, 1);
        let tau0 = if flow.fluid.rheology.is_constant() { 0.0 } else { 20.0 };
        let exact = |y: f64| [0.6, 0.0, 0.8].map(|e| e * y * (0.25 * P - tau0) / ETA);
        let wrong = error(&flow, 1.6, exact);
        println!("askew: {} passes, {wrong:.1e}", report.outer);
        assert!(wrong < 1e-6, "{wrong}");
    }
}

/// Half of the heap of `cases/heap_dry`, `per_grain` cells a grain, after one endless step.
fn heap(per_grain: usize, dt: f64, control: ResidualControl) -> (Flow, Report) {
    let grains = Granular { d: D, ..BEADS };
    let (n, h) = ([1, 19 * per_grain / 2, 20 * per_grain], D / per_grain as f64);
    let mut kinds = shapes::periodic_kinds([true, false, false], PatchKind::Wall);
    kinds[5] = PatchKind::Patch;
    let poly = shapes::box_mesh(n, [0.0; 3], [h, 9.5 * D, 20.0 * D], kinds);
    let mut s = Setup::new(&poly, numerics(150, 1));
    s.numerics.control = control;
    let (sin, cos) = 28f64.to_radians().sin_cos();
    s.rho = 1519.0;
    s.gravity.driving = [9.81 * sin, 0.0, 0.0];
    s.gravity.hydrostatic = [0.0, 0.0, -9.81 * cos];
    s.p0 = s.rho * 9.81 * cos * 20.0 * D;
    let (rheology, n_inner) = (ngf(&s.exec, &s.mesh, grains, Form::Steady), s.mesh.n_inner);
    let mut flow = s.flow(
        rheology,
        |patch| match patch {
            "yMin" => slip(),
            "yMax" => coulomb(0.32, [0.0; 3])(n_inner),
            "zMin" => fixed([0.0; 3]),
            _ => free(),
        },
        |patch| if patch == "zMax" { pressure(0.0) } else { free() },
    );
    let report = flow.step(dt).expect("a step");
    (flow, report)
}

const D: f64 = 0.5e-3;
/// `sqrt(phi G cos(theta) d)`, m/s.
const UNIT: f64 = 0.0518182586;

/// Velocity over [`UNIT`], of the cells beside the middle and of the faces on the wall, by depth
/// over d; the mean; and the depth below which the wall holds.
fn profiles(flow: &Flow) -> (Vec<[f64; 3]>, f64, f64) {
    let (m, u) = (&flow.mesh, &flow.state.u);
    let depth = |z: f64| 20.0 - z / D;
    let first = greatest(m, |c| -m.cell_centre[c][1] + 1.0);
    let mut rows = Vec::new();
    let middle = (0..m.n_cells).filter(|&c| (1.0 - m.cell_centre[c][1] - first).abs() < 1e-3 * D);
    for c in middle {
        rows.push([depth(m.cell_centre[c][2]), u.cells.data[c][0] / UNIT, 0.0]);
    }
    let wall = m.patches.iter().find(|p| p.name == "yMax").expect("the wall");
    let mut sticks = 20.0_f64;
    for f in wall.faces.clone() {
        let (s, slip) = (depth(m.face_centre[f][2]), u.boundary_value(m, f)[0] / UNIT);
        let row = rows.iter_mut().find(|r| (r[0] - s).abs() < 1e-6).expect("its row");
        row[2] = slip;
        if slip == 0.0 {
            sticks = sticks.min(s);
        }
    }
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let sum: f64 = (0..m.n_cells).map(|c| m.volume[c] * u.cells.data[c][0]).sum();
    let half = 0.5 * (rows[1][0] - rows[0][0]);
    (rows, sum / m.volume[..m.n_cells].iter().sum::<f64>() / UNIT, sticks - half)
}

/// Greatest differences from the reference, of the speed of its surface: in the middle and at the wall.
fn errors(own: &[[f64; 3]]) -> [f64; 2] {
    let rows = reference("heap_dry/reference/heap_steady_th28_profiles.csv");
    [1, 2].map(|k| {
        own.iter().map(|r| (r[k] - interpolate(&rows, 0, k, r[0])).abs()).fold(0.0, f64::max) / 3.33
    })
}

/// The heap of model.md, section 6, with two cells a grain; `cases/heap_dry` has four.
#[test]
fn heap_between_walls() {
    let (flow, report) = heap(2, 1e9, ResidualControl::default());
    println!("heap: {} passes, {:?}", report.outer, report.residuals);
    let (own, mean, sticks) = profiles(&flow);
    let [middle, wall] = errors(&own);
    println!("middle {middle:.1e} wall {wall:.1e} mean {mean:.5} sticks below {sticks:.3} d");
    assert!(report.converged, "{report:?}");
    // Second order: a quarter of it with four cells a grain.
    assert!(middle < 3.2e-3 && wall < 5e-3, "{middle} {wall}");
    assert!((mean - 0.77947).abs() < 3e-3, "{mean}");
    // Faces hold or slide as a whole: within a cell.
    assert!((sticks - 13.97).abs() <= 0.5, "{sticks}");

    // Neither the tolerances nor the steps on the way there have a say in it.
    let loose = ResidualControl { u: 1e-5, p: 1e-5, viscosity: 1e-4 };
    for (dt, control) in [(1e9, loose), (0.1, ResidualControl::default())] {
        let (mut other, mut report) = heap(2, dt, control);
        for _ in 0..if dt < 1.0 { 40 } else { 0 } {
            report = other.step(dt).expect("a step");
            assert!(report.converged, "{report:?}");
        }
        let (u, v) = (&other.state.u.cells.data, &flow.state.u.cells.data);
        let change = greatest(&flow.mesh, |c| (u[c][0] - v[c][0]).abs()) / (3.33 * UNIT);
        println!("dt {dt} {control:?}: {change:.1e}, last step {:.1e}", report.change);
        assert!(change < 1e-3, "{change}");
    }
}

/// The same with four cells a grain: within 2e-3 of the surface's speed, and of the depth where the wall begins to hold
/// within half a cell.
#[test]
fn heap_between_walls_with_four_cells_a_grain() {
    let (flow, report) = heap(4, 1e9, ResidualControl::default());
    let (own, mean, sticks) = profiles(&flow);
    let [middle, wall] = errors(&own);
    // At the surface, half a cell above the first row.
    let surface = |k: usize| 1.5 * own[0][k] - 0.5 * own[1][k];
    let tops = [surface(1), surface(2)];
    println!(
        "middle {middle:.1e} wall {wall:.1e} mean {mean:.5} sticks below {sticks:.3} d {tops:?}"
    );
    assert!(report.converged, "{report:?}");
    assert!(middle < 2e-3 && wall < 2e-3, "{middle} {wall}");
    assert!((tops[0] - 3.33).abs() < 6.66e-3 && (tops[1] - 2.6704).abs() < 6.66e-3, "{tops:?}");
    assert!((mean - 0.77947).abs() < 2e-3, "{mean}");
    assert!((sticks - 13.97).abs() <= 0.125, "{sticks}");
}

/// Steps that slide, turn round and stick allocate nothing.
#[test]
fn no_allocation_after_the_second_step() {
    let wall = coulomb(0.5, [0.0; 3]);
    let mut flow = channel(1.0, newtonian(), [&wall, &wall]);
    converged(&mut flow, 1.0, 2);
    let before = ALLOCATIONS.get();
    for scale in [1.0, -1.0, 0.0, -20.0, 1.0] {
        for u in &mut flow.state.u.cells.data {
            *u = granflow_base::scale(*u, scale);
        }
        converged(&mut flow, 10.0, 1);
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
}

/// Residuals measured anew, without inertia, are those of the step; and a velocity that is not in
/// balance with the walls does not pass.
#[test]
fn residuals_of_a_heap_are_its_own() {
    let (mut flow, report) = heap(1, 1e30, ResidualControl::default());
    assert!(report.converged, "{report:?}");
    let again = flow.residuals().expect("residuals");
    println!("{:?} {again:?}", report.residuals);
    assert!(again.u < 1e-7 && again.viscosity < 1e-6, "{again:?}");
    // A wall that drags a little more than it does is no longer in balance.
    for u in &mut flow.state.u.cells.data {
        *u = granflow_base::scale(*u, 1.01);
    }
    let off = flow.residuals().expect("residuals");
    assert!(off.u > 1e-4 || off.viscosity > 1e-4, "{off:?}");
}
