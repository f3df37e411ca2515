//! Laminar flows with known profiles: every local rheology, driven by a body force, a wall or the
//! weight of the grains.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Vec3, cross, dot, norm, unit};
use granflow_flow::{Flow, Report, ResidualControl};
use granflow_linsolve::Tolerance;
use granflow_mesh::{PatchKind, PolyMesh, shapes};
use granflow_physics::LocalLaw;
use granflow_physics::rheology::{
    Bingham, HerschelBulkley, MuI, Newtonian, Point, PowerLaw, Rheology,
};

const LONG: f64 = 1e6;

fn run(flow: &mut Flow, dt: f64, steps: usize) -> Report {
    let mut last = Report::default();
    for _ in 0..steps {
        last = flow.step(dt).expect("a step");
    }
    last
}

/// A channel of unit width and density 1000 along x, `n` cells across, driven by 1 m/s2.
fn channel(n: usize, outer: usize, rheology: Box<dyn Rheology>) -> (Flow, Report) {
    channel_to(n, outer, ResidualControl::default(), rheology)
}

fn channel_to(
    n: usize,
    outer: usize,
    control: ResidualControl,
    rheology: Box<dyn Rheology>,
) -> (Flow, Report) {
    let h = 1.0 / n as f64;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [h, 1.0, h], kinds);
    let mut s = Setup::new(&poly, numerics(outer, 1));
    s.numerics.control = control;
    s.rho = 1000.0;
    s.gravity.driving = [1.0, 0.0, 0.0];
    let mut flow = s.flow(rheology, |_| fixed([0.0; 3]), |_| free());
    let report = run(&mut flow, LONG, 2);
    (flow, report)
}

/// Greatest error of the velocity along x against `exact(y)`, over the greatest of `exact`.
fn error(flow: &Flow, exact: impl Fn(f64) -> f64) -> f64 {
    let m = &flow.mesh;
    let y = |c: usize| m.cell_centre[c][1];
    let size = greatest(m, |c| exact(y(c)).abs());
    greatest(m, |c| (flow.state.u.cells.data[c][0] - exact(y(c))).abs()) / size
}

/// Velocity of a Herschel-Bulkley fluid (kinematic tau0, k, n) in the channel.
fn plug(tau0: f64, k: f64, n: f64) -> impl Fn(f64) -> f64 {
    let q = 1.0 + 1.0 / n;
    let shape = move |s: f64| (s - tau0).max(0.0).powf(q);
    move |y: f64| k.powf(-1.0 / n) / q * (shape(0.5) - shape((y - 0.5).abs()))
}

#[test]
fn plane_poiseuille() {
    let nu = 0.125;
    let exact = |y: f64| y * (1.0 - y) / (2.0 * nu);
    let errors: Vec<f64> = [8, 16, 32, 64]
        .map(|n| {
            let (flow, report) = channel(n, 60, local(Newtonian { eta: 1000.0 * nu }));
            assert!(report.converged, "{report:?}");
            error(&flow, exact)
        })
        .to_vec();
    println!("Poiseuille {} orders {:?}", short(&errors), orders(&errors));
    assert!(orders(&errors).iter().all(|o| (o - 2.0).abs() < 0.1), "{errors:?}");
    assert!(errors[3] < 3e-4, "{errors:?}");
}

/// A channel of unit length driven by the pressure of its ends in place of a body force.
fn between_pressures(outer: usize, correctors: usize) -> Flow {
    let mut kinds = shapes::periodic_kinds([false, false, true], PatchKind::Wall);
    (kinds[0], kinds[1]) = (PatchKind::Patch, PatchKind::Patch);
    let poly = shapes::box_mesh([8, 32, 1], [0.0; 3], [1.0, 1.0, 0.1], kinds);
    let mut s = Setup::new(&poly, numerics(outer, correctors));
    s.rho = 1.0;
    s.flow(
        local(Newtonian { eta: 0.125 }),
        |patch| if patch.starts_with('x') { free() } else { fixed([0.0; 3]) },
        |patch| match patch {
            "xMin" => fixed(1.0),
            "xMax" => fixed(0.0),
            _ => free(),
        },
    )
}

/// The pressure falls evenly all the way, half a cell before the outlet too.
#[test]
fn pressure_driven_channel() {
    for (outer, correctors) in [(1, 2), (40, 1)] {
        let mut flow = between_pressures(outer, correctors);
        run(&mut flow, 0.02, 1000);
        let e = error(&flow, |y| 4.0 * y * (1.0 - y));
        let m = &flow.mesh;
        let p = &flow.state.p.cells.data;
        let e_p = greatest(m, |c| (p[c] - (1.0 - m.cell_centre[c][0])).abs());
        println!("pressure-driven channel, {outer} outer: U {e:.1e} p {e_p:.1e}");
        assert!(e < 1.1e-3 && e_p < 1e-6, "{outer} outer: U {e:.1e} p {e_p:.1e}");
    }
}

/// From rest in one endless step: material enters through a zero-gradient inlet faster than it
/// leaves while continuity is not met, and the diagonal of momentum may turn negative. That may
/// fail, but with an error and not with a panic.
#[test]
fn pressure_driven_channel_from_rest_in_one_step() {
    let mut flow = between_pressures(300, 1);
    if let Err(e) = flow.step(LONG) {
        println!("refused: {e}");
    }
}

/// One pass with the pressure-velocity coupling of PISO meets the same profile.
#[test]
fn plane_poiseuille_by_piso() {
    let h = 1.0 / 32.0;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([4, 32, 1], [0.0; 3], [4.0 * h, 1.0, h], kinds);
    let mut s = Setup::new(&poly, numerics(1, 2));
    s.rho = 1000.0;
    s.gravity.driving = [1.0, 0.0, 0.0];
    let mut flow = s.flow(local(Newtonian { eta: 125.0 }), |_| fixed([0.0; 3]), |_| free());
    run(&mut flow, 0.5, 60);
    let e = error(&flow, |y| 4.0 * y * (1.0 - y));
    println!("Poiseuille by PISO {e:.1e}");
    assert!(e < 1.1e-3, "{e:.2e}");
}

/// Errors against the analytic profile on 20, 40 and 80 cells. A face beside the yield surface sees
/// a tenth of the rates of its neighbours, one of which does not yield: the plug is then a little
/// slow, by an amount that falls with the first power of the cell where the rate rises steeply
/// (n > 1).
fn yielding(what: &str, exact: impl Fn(f64) -> f64, law: impl Fn() -> Box<dyn Rheology>) {
    let mut errors = Vec::new();
    for n in [20, 40, 80] {
        let (flow, report) = channel(n, 300, law());
        let e = error(&flow, &exact);
        let most = greatest(&flow.mesh, |c| flow.state.u.cells.data[c][0]);
        let plug = (most - exact(0.5)).abs() / exact(0.5);
        println!(
            "{what} {n}: profile {e:.2e} plug {plug:.2e}, outer {}, {:?}",
            report.outer, report.residuals
        );
        assert!(report.converged, "{what} {n}: {report:?}");
        errors.push(e);
    }
    println!("{what}: orders {:?}", orders(&errors));
    assert!(errors[1] < 1e-2 && errors[2] < 3e-3, "{what}: {errors:?}");
    assert!((errors[0] / errors[2]).log(4.0) > 1.1, "{what}: {errors:?}");
}

/// Laws with a yield on meshes of several cells along the flow, where the columns are free to
/// differ: any step converges, and all columns are the same. (In one endless step from rest ten
/// columns of cells ten times as high as long do not: the linear problem is not solved well enough.)
fn columns_agree(what: &str, law: impl Fn() -> Box<dyn Rheology>) {
    for columns in [2, 5, 10] {
        let steps = if columns < 10 { &[1e-3, 1.0, LONG][..] } else { &[1e-3, 1.0] };
        for &dt in steps {
            let h = 1.0 / 40.0;
            let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
            let size = [h, 1.0, h];
            let poly = shapes::box_mesh([columns, 40, 1], [0.0; 3], size, kinds);
            let mut s = Setup::new(&poly, numerics(150, 1));
            s.rho = 1000.0;
            s.gravity.driving = [1.0, 0.0, 0.0];
            let mut flow = s.flow(law(), |_| fixed([0.0; 3]), |_| free());
            for step in 0..3 {
                let report = flow.step(dt).expect("a step");
                let residuals = report.residuals;
                println!(
                    "{what} {columns} dt {dt:.0e} step {step}: {} {residuals:?}",
                    report.outer
                );
                assert!(report.converged, "{what} {columns} columns, dt {dt}: {residuals:?}");
            }
            let u = &flow.state.u.cells.data;
            let most = u[..flow.mesh.n_cells].iter().map(|u| u[0]).fold(0.0, f64::max);
            let apart = greatest(&flow.mesh, |c| (u[c][0] - u[c / columns * columns][0]).abs());
            assert!(
                most > 0.0 && apart < 1e-5 * most,
                "{what} {columns}: {apart:.1e} of {most:.1e}"
            );
        }
    }
}

#[test]
fn bingham_on_several_columns() {
    columns_agree("Bingham", || local(Bingham { tau0: 0.2, nu: 0.05, nu0: 1e2, density: 1000.0 }));
}

#[test]
fn herschel_bulkley_on_several_columns() {
    for n in [0.5, 1.4] {
        columns_agree(&format!("Herschel-Bulkley {n}"), || {
            local(HerschelBulkley { tau0: 0.2, k: 0.05, n, nu0: 1e2, density: 1000.0 })
        });
    }
}

/// What a 1000 times higher viscosity of the unyielded plug changes.
fn cap_does_not_matter(what: &str, law: impl Fn(f64) -> Box<dyn Rheology>) {
    let [low, high] = [1e2, 1e5].map(|nu0| {
        // The plug moves at 1 m/s and its viscosity of 1e8 Pa s multiplies velocity differences of
        // 1e-16 m/s in rounding: 4e-9 of the stress at yield, of which the viscosity beside the
        // plug makes 35 times as much. What is left is noise of 1e-6.
        let control = ResidualControl { u: 1e-6, p: 1e-8, viscosity: 1e-5 };
        let (flow, report) = channel_to(40, 300, control, law(nu0));
        println!("{what} nu0 {nu0:.0e}: outer {}, {:?}", report.outer, report.residuals);
        assert!(report.converged, "{what}, nu0 {nu0:.0e}: {report:?}");
        flow.state.u.cells.data
    });
    let most = low[..40].iter().map(|u| u[0]).fold(0.0, f64::max);
    let change = (0..40).map(|c| (low[c][0] - high[c][0]).abs()).fold(0.0, f64::max) / most;
    println!("{what}: 1000 times the cap changes the profile by {change:.1e}");
    // The plug of the lower cap creeps by G/(8 nu0) at most.
    assert!(change < 1e-3, "{what}: the cap changes the profile by {change:.1e}");
}

#[test]
fn bingham_poiseuille() {
    let (tau0, nu) = (0.2, 0.05);
    yielding("Bingham", plug(tau0, nu, 1.0), || {
        local(Bingham { tau0, nu, nu0: 1e2, density: 1000.0 })
    });
}

#[test]
fn bingham_does_not_depend_on_the_cap() {
    let (tau0, nu) = (0.2, 0.05);
    cap_does_not_matter("Bingham", |nu0| local(Bingham { tau0, nu, nu0, density: 1000.0 }));
}

#[test]
fn herschel_bulkley_poiseuille() {
    for n in [0.5, 1.4] {
        let (tau0, k) = (0.2, 0.05);
        yielding(&format!("Herschel-Bulkley n = {n}"), plug(tau0, k, n), || {
            local(HerschelBulkley { tau0, k, n, nu0: 1e2, density: 1000.0 })
        });
    }
}

#[test]
fn herschel_bulkley_does_not_depend_on_the_cap() {
    let (tau0, k, n) = (0.2, 0.05, 0.5);
    cap_does_not_matter("Herschel-Bulkley", |nu0| {
        local(HerschelBulkley { tau0, k, n, nu0, density: 1000.0 })
    });
}

/// The kinematic law of the library with a density.
struct Dynamic(PowerLaw);
impl LocalLaw for Dynamic {
    fn viscosity(&self, at: Point) -> f64 {
        at.density * self.0.nu(at.strain_rate)
    }
}

#[test]
fn power_law_poiseuille() {
    for n in [0.5, 0.8, 1.5] {
        let k = 0.1;
        let exact = plug(0.0, k, n);
        let errors: Vec<f64> = [16, 32, 64]
            .map(|cells| {
                let law = PowerLaw { k, n, nu: [1e-9, 1e9] };
                let (flow, report) = channel(cells, 300, local(Dynamic(law)));
                assert!(report.converged, "n {n}: {report:?}");
                error(&flow, &exact)
            })
            .to_vec();
        println!("power law {n}: {} orders {:?}", short(&errors), orders(&errors));
        assert!(errors[1] < 5e-3, "n {n}: {errors:?}");
        assert!((errors[0] / errors[2]).log(4.0) > 1.5, "n {n}: {errors:?}");
    }
}

const G: f64 = 9.81;
/// 20 grains.
const DEPTH: f64 = 20.0 * BEADS.d;

/// A layer of grains of the local law on an incline, `n` cells deep.
fn incline(theta: f64, n: usize) -> Flow {
    let h = DEPTH / n as f64;
    let kinds = shapes::periodic_kinds([true, false, true], PatchKind::Wall);
    let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [h, DEPTH, h], kinds);
    let mut s = Setup::new(&poly, numerics(400, 1));
    s.gravity.hydrostatic = [0.0, -G * theta.cos(), 0.0];
    s.gravity.driving = [G * theta.sin(), 0.0, 0.0];
    s.p0 = RHO_B * G * theta.cos() * DEPTH;
    s.flow(
        local(MuI(BEADS)),
        |patch| if patch == "yMax" { slip() } else { fixed([0.0; 3]) },
        |patch| if patch == "yMax" { pressure(0.0) } else { free() },
    )
}

/// Bagnold's profile: grains of the local law down an incline of 24 degrees, 20 grains deep.
#[test]
fn mu_of_i_on_an_incline() {
    let (theta, g, d, depth) = (24f64.to_radians(), G, BEADS.d, DEPTH);
    let tan = theta.tan();
    let i = BEADS.i0 * (tan - BEADS.mu_s) / (BEADS.mu_2 - tan);
    // I = rate d / sqrt(P/rho_s) with P = phi rho_s g cos (h - y).
    let k = 2.0 / 3.0 * i / d * (0.62 * g * theta.cos()).sqrt();
    let exact = |y: f64| k * (depth.powf(1.5) - (depth - y).powf(1.5));
    let mut errors = Vec::new();
    for n in [20, 40, 80] {
        let mut flow = incline(theta, n);
        let report = run(&mut flow, LONG, 3);
        let e = error(&flow, exact);
        println!("incline {n}: {e:.2e}, outer {}, {:?}", report.outer, report.residuals);
        assert!(report.converged, "{n}: {report:?}");
        let m = flow.mesh.clone();
        let pressure = flow.derived().expect("a state").pressure.to_vec();
        let p_error = greatest(&m, |c| {
            let exact = RHO_B * g * theta.cos() * (depth - m.cell_centre[c][1]);
            (pressure[c] - exact).abs() / exact
        });
        assert!(p_error < 1e-6, "{n}: P is off by {p_error:.1e}");
        errors.push(e);
    }
    println!("incline: orders {:?}", orders(&errors));
    assert!(errors[1] < 1e-2, "{errors:?}");
    assert!((errors[0] / errors[2]).log(4.0) > 1.4, "{errors:?}");
}

/// A layer that runs at half its speed: what `nOuterCorrectors 1` balances are forces with the viscosity before the step.
#[test]
fn one_pass_holds_the_viscosity_that_a_step_begins_with() {
    let mut flow = incline(24f64.to_radians(), 20);
    assert!(run(&mut flow, LONG, 3).converged);
    flow.state.u.cells.data.iter_mut().for_each(|u| u[0] *= 0.5);
    let before = flow.state.u.cells.data.clone();
    flow.residuals().expect("residuals");
    let eta = flow.derived().expect("a state").viscosity_f.to_vec();
    flow.numerics.outer = 1;
    let dt = 0.1;
    assert!(!run(&mut flow, dt, 1).converged, "the viscosity is no longer the law's");
    let (m, now) = (flow.mesh.clone(), &flow.state.u.cells.data);
    let weight = RHO_B * flow.gravity.driving[0];
    let off = greatest(&m, |c| {
        let drag = |(f, s): (usize, f64)| {
            let there = match m.neighbour.get(f) {
                Some(&n) if s > 0.0 => now[n as usize][0],
                Some(_) => now[m.owner[f] as usize][0],
                None if m.face_centre[f][1] < 1e-9 => 0.0,
                None => now[c][0],
            };
            let apart = (m.cell_centre[c][1] - m.face_centre[f][1]).abs();
            let apart = if f < m.n_inner { 2.0 * apart } else { apart };
            eta[f] * (there - now[c][0]) * m.mag_area[f] / apart.max(f64::MIN_POSITIVE)
        };
        let drags: f64 = m.faces_of(c).filter(|(f, _)| m.area[*f][1] != 0.0).map(drag).sum();
        let gained = RHO_B * (now[c][0] - before[c][0]) / dt;
        (gained - weight - drags / m.volume[c]).abs() / weight
    });
    println!("forces of one pass are off by {off:.1e}");
    assert!(off < 1e-6, "{off}");
}

const RI: f64 = 0.5;
const RO: f64 = 1.0;

/// Speed between an inner cylinder that turns at unit speed and an outer one at rest.
fn couette(r: f64) -> f64 {
    let b = RI * RO * RO / (RO * RO - RI * RI);
    b / r - b * r / (RO * RO)
}

/// The steady flow between the cylinders and its greatest errors: along, across and pressure.
fn cylinders(poly: &PolyMesh, eta: f64) -> [f64; 3] {
    let mut n = numerics(200, 1);
    n.convection = granflow_fv::Convection::Linear;
    n.p.tolerance = Tolerance { abs: 1e-12, rel: 1e-8, max_iter: 1000 };
    n.p.last = n.p.tolerance;
    n.u.tolerance = n.p.tolerance;
    n.u.last = n.p.tolerance;
    let mut s = Setup::new(poly, n);
    s.rho = 1.0;
    let mut flow = s.flow(
        local(Newtonian { eta }),
        |patch| match patch {
            "inner" => turning(1.0, RI),
            "outer" => turning(0.0, RO),
            _ => slip(),
        },
        |_| free(),
    );
    let report = run(&mut flow, LONG, 2);
    assert!(report.converged, "{report:?}");
    let m = &flow.mesh;
    let at = |c: usize| -> (f64, Vec3, Vec3) {
        let [x, y, _] = m.cell_centre[c];
        let e_r = unit([x, y, 0.0]);
        (norm([x, y, 0.0]), e_r, cross([0.0, 0.0, 1.0], e_r))
    };
    let u = &flow.state.u.cells.data;
    let along = greatest(m, |c| {
        let (r, _, e_t) = at(c);
        (dot(u[c], e_t) - couette(r)).abs()
    });
    let across = greatest(m, |c| dot(u[c], at(c).1).abs().max(u[c][2].abs()));
    // dp/dr = rho V^2/r, integrated from the innermost cell.
    let (a, b) = (-RI / (RO * RO - RI * RI), RI * RO * RO / (RO * RO - RI * RI));
    let p = |r: f64| 0.5 * a * a * r * r + 2.0 * a * b * r.ln() - 0.5 * b * b / (r * r);
    let off = |c: usize| flow.state.p.cells.data[c] - p(at(c).0);
    let shift = (0..m.n_cells).map(|c| m.volume[c] * off(c)).sum::<f64>()
        / m.volume[..m.n_cells].iter().sum::<f64>();
    let pressure = rms(m, |c| off(c) - shift);
    [along, across, pressure]
}

#[test]
fn couette_between_cylinders_on_the_wedge() {
    let mut errors = Vec::new();
    for nr in [8, 16, 32, 64] {
        let poly = shapes::wedge_ring(RI, RO, 0.1, nr, 2, 0.25f64.to_radians());
        let e = cylinders(&poly, 0.1);
        println!("wedge {nr}: {}", short(&e));
        errors.push(e);
    }
    let along: Vec<f64> = errors.iter().map(|e| e[0]).collect();
    let p: Vec<f64> = errors.iter().map(|e| e[2]).collect();
    println!("wedge: orders {:?} {:?}", orders(&along), orders(&p));
    assert!(orders(&along)[..2].iter().all(|o| (o - 2.0).abs() < 0.2), "{along:?}");
    assert!(along[3] < 3e-4, "{along:?}");
    assert!((p[0] / p[3]).log(8.0) > 1.4, "{p:?}");
}

#[test]
fn couette_between_cylinders_in_a_sector() {
    let mut errors = Vec::new();
    for k in [1, 2, 4, 8] {
        let mut poly = shapes::annular_sector(RI, RO, [6 * k, 6 * k, 1], 6);
        poly.points.iter_mut().for_each(|p| p[2] *= 0.1);
        let e = cylinders(&poly, 0.1);
        println!("sector {k}: {}", short(&e));
        errors.push(e);
    }
    for (i, what) in ["along", "across", "pressure"].iter().enumerate() {
        let e: Vec<f64> = errors.iter().map(|e| e[i]).collect();
        println!("sector {what}: orders {:?}", orders(&e));
        // p has zero gradient at walls that turn, where rho V^2/r is right.
        let least = if i < 2 { 1.7 } else { 1.0 };
        assert!((e[1] / e[3]).log(4.0) > least, "{what}: {e:?}");
    }
    assert!(errors[3][0] < 1e-3, "{errors:?}");
}

/// The sector and the wedge have one and the same radial profile.
#[test]
fn sector_meets_the_wedge() {
    let [along, ..] = cylinders(&shapes::wedge_ring(RI, RO, 0.1, 24, 1, 0.25f64.to_radians()), 0.1);
    let mut poly = shapes::annular_sector(RI, RO, [24, 48, 1], 6);
    poly.points.iter_mut().for_each(|p| p[2] *= 0.1);
    let [sector, ..] = cylinders(&poly, 0.1);
    println!("24 cells: wedge {along:.2e}, sector {sector:.2e}");
    assert!((along - sector).abs() < 0.5 * along.max(sector), "{along:.2e} {sector:.2e}");
}
