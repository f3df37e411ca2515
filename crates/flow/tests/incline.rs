//! A layer on an incline with the primitive form of the fluidity equation and no fluidity at its
//! base: it starts and stops at a thickness h_stop that depends on the angle (model.md section 6).
//! The steady form, and a base that lets fluidity be, have none.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;
use common::*;
use granflow_flow::{Flow, Report};
use granflow_fv::Condition;
use granflow_linsolve::Tolerance;
use granflow_mesh::shapes;
use granflow_physics::rheology::{Form, Law, Ngf, NgfNumerics};
use std::f64::consts::FRAC_PI_2;

const T0: f64 = 1e-3;
/// Cells through the layer. The lowest mode of the discrete equation has the wave number
/// (2N/H) sin(pi/4N): with 32 cells 1.0e-4 below pi/2H, and h_stop as much.
const CELLS: usize = 32;
const ANGLES: [f64; 5] = [22.0, 24.0, 26.0, 28.0, 30.0];
const PRIMITIVE: Form = Form::Primitive { t0: T0 };

/// Thickness in grains at which the lowest mode of the linear equation neither grows nor decays.
fn h_stop(theta: f64) -> f64 {
    let tan = theta.to_radians().tan();
    FRAC_PI_2 * A * ((BEADS.mu_2 - tan) / (BEADS.delta_mu() * (tan - BEADS.mu_s))).sqrt()
}

/// A layer of `h` grains and `n` cells with the fluidity `g(y/H)`, 1/s, on an incline of `theta` degrees.
fn layer(n: usize, theta: f64, h: f64, form: Form, rough: bool, g: impl Fn(f64) -> f64) -> Flow {
    let (depth, step) = (h * BEADS.d, h * BEADS.d / n as f64);
    let kinds = shapes::periodic_kinds([true, false, true], granflow_mesh::PatchKind::Wall);
    let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [step, depth, step], kinds);
    let mut s = Setup::new(&poly, numerics(150, 1));
    let (sin, cos) = theta.to_radians().sin_cos();
    s.gravity.hydrostatic = [0.0, -9.81 * cos, 0.0];
    s.gravity.driving = [9.81 * sin, 0.0, 0.0];
    s.p0 = RHO_B * 9.81 * cos * depth;
    let base = |name: &str| -> Box<dyn Condition<f64>> {
        if rough && name == "yMin" { fixed(0.0) } else { free() }
    };
    let conditions = s.mesh.patches.iter().map(|q| on_patch(&q.kind, base(&q.name))).collect();
    let numerics = NgfNumerics {
        solver: solver("PBiCGStab", "DILU"),
        tolerance: Tolerance { abs: 1e-12, rel: 1e-10, max_iter: 500 },
        residual: 1e-10,
    };
    let law = Law { grains: BEADS, a: A, form };
    let rheology = Box::new(Ngf::new(law, &s.exec, &s.mesh, conditions, numerics));
    let mut flow = s.flow(
        rheology,
        |patch| if patch == "yMin" { fixed([0.0; 3]) } else { free() },
        |patch| if patch == "yMax" { pressure(0.0) } else { free() },
    );
    let heights: Vec<f64> = flow.mesh.cell_centre.iter().map(|c| c[1] / depth).collect();
    let field = flow.fluid.rheology.field_mut().expect("fluidity");
    heights.iter().enumerate().for_each(|(c, y)| field.data[c] = g(*y));
    flow
}

/// Of the cell below the surface, 1/s.
fn fluidity(flow: &Flow) -> f64 {
    flow.fluid.rheology.field().expect("fluidity").data[flow.mesh.n_cells - 1]
}
fn speed(flow: &Flow) -> f64 {
    flow.state.u.cells.data[flow.mesh.n_cells - 1][0]
}

/// Takes steps that must converge.
fn steps(flow: &mut Flow, dt: f64, n: usize) -> Report {
    let mut report = Report::default();
    for k in 0..n {
        report = flow.step(dt).expect("a step");
        assert!(report.converged, "step {k}, g = {:.1e}: {report:?}", fluidity(flow));
    }
    report
}

/// Growth rate times t0 of the lowest mode, from the last of three steps of implicit Euler, each of which
/// multiplies it by 1/(1 - rate dt).
fn growth(theta: f64, h: f64, rough: bool) -> f64 {
    let mode = |y: f64| if rough { 1e-6 * (FRAC_PI_2 * y).sin() } else { 1e-6 };
    let mut flow = layer(CELLS, theta, h, PRIMITIVE, rough, mode);
    let dt = 0.5 * T0;
    steps(&mut flow, dt, 2);
    let before = fluidity(&flow);
    steps(&mut flow, dt, 1);
    (1.0 - before / fluidity(&flow)) * T0 / dt
}

/// What is 3 % thicker grows, what is 3 % thinner decays, and the thickness between that does
/// neither is h_stop. (The rate is linear in 1/h^2.)
#[test]
fn the_neutral_thickness_is_h_stop() {
    let rows = reference("incline_hstop/reference/incline_hstop_primitive.csv");
    for theta in ANGLES {
        let row = rows.iter().find(|r| r[0] == theta).expect("the angle");
        let h = h_stop(theta);
        assert!((h / row[2] - 1.0).abs() < 1e-9, "formula {h}, reference {}", row[2]);
        let [thin, thick] = [0.97 * h, 1.03 * h];
        let [low, high] = [thin, thick].map(|h| growth(theta, h, true));
        let [a, b] = [thin.powi(-2), thick.powi(-2)];
        let neutral = (a - (b - a) * low / (high - low)).powf(-0.5);
        println!(
            "{theta}: h_stop/d {neutral:.5}, exact {h:.5} ({:+.1e}); rate t0 {low:+.3e} {high:+.3e}",
            neutral / h - 1.0
        );
        assert!(low < 0.0 && high > 0.0, "{low} {high}");
        assert!((neutral / h - 1.0).abs() < 3e-4, "{neutral} {h}");
    }
}

/// A uniform fluidity of 1e-12/s, as good as rest, ends in steady flow where the layer is 3 %
/// thicker than h_stop; that flow, put on a layer 3 % thinner, dies away to 1e-30/s with every
/// step converged.
#[test]
fn it_starts_from_rest_and_stops_from_flow() {
    for theta in ANGLES {
        let h = h_stop(theta);
        let mut flow = layer(CELLS, theta, 1.03 * h, PRIMITIVE, true, |_| 1e-12);
        let dt = 0.2 * T0 / growth(theta, 1.03 * h, true);
        let mut n = 0;
        while n < 400 && steps(&mut flow, dt, 1).change > 1e-6 {
            n += 1;
        }
        let (reached, u) = (fluidity(&flow), speed(&flow));
        println!("{theta}: starts in {n} steps, g {reached:.3e} 1/s, u {u:.3e} m/s");
        assert!(n < 400 && reached > 1e-2 && u > 0.0, "{n} {reached} {u}");
        let moving = flow.fluid.rheology.field().expect("fluidity").data.clone();
        let cell = |y: f64| ((y * CELLS as f64) as usize).min(CELLS - 1);
        let mut flow = layer(CELLS, theta, 0.97 * h, PRIMITIVE, true, |y| moving[cell(y)]);
        let dt = -0.2 * T0 / growth(theta, 0.97 * h, true);
        let mut n = 0;
        while n < 600 && fluidity(&flow) > 1e-30 {
            steps(&mut flow, dt, 1);
            n += 1;
        }
        println!("{theta}: stops in {n} steps, u {:.1e} m/s", speed(&flow));
        assert!(n < 600 && speed(&flow) < 1e-30, "{n}");
    }
}

/// One layer, tilted: it flows at 24 degrees, where it is 3 % thicker than h_stop; at 23 degrees
/// it stops, and back at 24 what is left of its fluidity grows to the same flow.
#[test]
fn it_stops_and_starts_as_the_angle_goes() {
    let h = 1.03 * h_stop(24.0);
    let at = |theta: f64, from: &Flow| {
        let mut flow = layer(CELLS, theta, h, PRIMITIVE, true, |_| 0.0);
        flow.state.u.cells.data.copy_from_slice(&from.state.u.cells.data);
        let g = &from.fluid.rheology.field().expect("fluidity").data;
        flow.fluid.rheology.field_mut().expect("fluidity").data.copy_from_slice(g);
        flow
    };
    let mut flow = layer(CELLS, 24.0, h, PRIMITIVE, true, |_| 1e-3);
    steps(&mut flow, 50.0 * T0, 100);
    let moving = speed(&flow);
    flow = at(23.0, &flow);
    steps(&mut flow, 50.0 * T0, 20);
    let stopped = speed(&flow);
    flow = at(24.0, &flow);
    steps(&mut flow, 50.0 * T0, 200);
    println!("{moving:.3e}, at 23 degrees {stopped:.1e}, back at 24 {:.3e} m/s", speed(&flow));
    assert!(moving > 1e-4 && stopped < 1e-6 * moving);
    assert!((speed(&flow) / moving - 1.0).abs() < 1e-3, "{moving} {}", speed(&flow));
}

/// Neither the steady form nor a base that lets fluidity be has an h_stop: a layer half as thick
/// flows; in the primitive form with such a base any fluidity grows at the rate of the bulk.
#[test]
fn the_steady_form_and_a_free_base_have_no_h_stop() {
    let rows = reference("incline_hstop/reference/incline_hstop_primitive.csv");
    for theta in ANGLES {
        let h = 0.5 * h_stop(theta);
        let mut flow = layer(CELLS, theta, h, Form::Steady, true, |_| 0.0);
        steps(&mut flow, 1e6, 2);
        let rate = growth(theta, h, false);
        let row = rows.iter().find(|r| r[0] == theta).expect("the angle");
        println!(
            "{theta}: steady {:.2e} m/s; free base {rate:.5e} of {:.5e}",
            speed(&flow),
            row[5]
        );
        assert!(speed(&flow) > 1e-5, "{}", speed(&flow));
        assert!((rate / row[5] - 1.0).abs() < 1e-3, "{rate}");
        assert!(growth(theta, h, true) < 0.0);
    }
}

/// Mean fluidity of the steady flow of a layer half as thick again as h_stop.
fn flowing(n: usize) -> f64 {
    let mut flow = layer(n, 24.0, 1.5 * h_stop(24.0), PRIMITIVE, true, |_| 1.0);
    steps(&mut flow, 1e6, 3);
    flow.fluid.rheology.field().expect("fluidity").data[..n].iter().sum::<f64>() / n as f64
}

/// 1/sqrt(P) below the free surface is taken as the mean of the cell: with the value at its centre
/// the error would fall with the root of the cell's size.
#[test]
fn the_surface_does_not_spoil_the_order() {
    let fine = flowing(256);
    let errors = [8, 16, 32].map(|n| (flowing(n) / fine - 1.0).abs());
    println!("mean g {fine:.5} 1/s; errors {} orders {}", short(&errors), short(&orders(&errors)));
    assert!(errors[2] < 1e-3 && orders(&errors).iter().all(|o| *o > 1.5), "{errors:?}");
}

/// Whatever little fluidity a step finds, it converges; a step so long that growth is faster (its
/// end is steady flow) may take the guess of flowing grains, not that of the old ones.
#[test]
fn any_little_fluidity() {
    for theta in [22.0, 28.0] {
        for k in [0.97, 1.03] {
            for g in [1e-1, 1e-6, 1e-15, 1e-25, 1e-50, 1e-90] {
                for dt in [1e-5, 1e-3, 1e-2] {
                    let mode = |y: f64| g * (FRAC_PI_2 * y).sin();
                    let mut flow = layer(CELLS, theta, k * h_stop(theta), PRIMITIVE, true, mode);
                    let before = fluidity(&flow);
                    steps(&mut flow, dt, 3);
                    let rate = growth(theta, k * h_stop(theta), true);
                    let factor = (1.0 - rate * dt / T0).powi(-3);
                    let off = fluidity(&flow) / before / factor - 1.0;
                    assert!(g > 1e-3 || off.abs() < 1e-3, "{theta} {k} {g:e} {dt:e}: {off:.1e}");
                }
            }
            for g in [1e-6, 1e-12, 1e-50, 1e-99, 1e-300] {
                let mut flow = layer(CELLS, theta, k * h_stop(theta), PRIMITIVE, true, |_| g);
                let report = steps(&mut flow, 1e6, 1);
                println!("{theta} {k} {g:.0e}: {} passes, {:.1e}", report.outer, fluidity(&flow));
                assert!((fluidity(&flow) > 0.1) == (k > 1.0));
            }
        }
    }
}

/// Grains far below what flows keep next to no fluidity, and no floor lifts it: 150 grains below a
/// lid the steady flow has 1e-48 of the lid's.
#[test]
fn deep_grains_keep_next_to_none() {
    for dt in [1e-2, 1.0, 1e6] {
        let (n, depth, v) = (300, 150.0 * BEADS.d, 1e-3);
        let h = depth / n as f64;
        let kinds = shapes::periodic_kinds([true, false, true], granflow_mesh::PatchKind::Wall);
        let poly = shapes::box_mesh([1, n, 1], [0.0; 3], [h, depth, h], kinds);
        let mut s = Setup::new(&poly, numerics(150, 1));
        let p_wall = 20.0 * RHO_B * 9.81 * BEADS.d;
        s.gravity.hydrostatic = [0.0, -9.81, 0.0];
        s.p0 = p_wall + RHO_B * 9.81 * depth;
        let rheology = ngf(&s.exec, &s.mesh, BEADS, PRIMITIVE);
        let mut flow = s.flow(
            rheology,
            |patch| if patch == "yMax" { fixed([v, 0.0, 0.0]) } else { fixed([0.0; 3]) },
            |patch| if patch == "yMax" { pressure(p_wall) } else { free() },
        );
        steps(&mut flow, dt, 40);
        let g = &flow.fluid.rheology.field().expect("fluidity").data;
        println!("deep, dt {dt}: g {:.1e} to {:.1e} 1/s", g[0], g[n - 1]);
        assert!(dt < 1.0 || (1e-49..1e-47).contains(&g[0]), "{:e}", g[0]);
    }
}
