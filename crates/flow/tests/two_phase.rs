//! Two fluids: balance, conservation, and the laws of the house.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod two_common;

use granflow_base::{Vec3, dot, scale};
use granflow_flow::vof::Shape;
use granflow_flow::{Mixing, NormalDerivative};
use granflow_fv::conditions::FixedValue;
use granflow_mesh::shapes;
use two_common::*;

/// Water up to y = 0.47 in a tank whose mesh is sheared by `degrees`, upwards or sideways, with our forms or OpenFOAM's.
fn still(degrees: f64, upwards: bool, geometric: bool, compatible: bool) -> f64 {
    let t = degrees.to_radians().tan();
    let mut poly = tank([20, 20], [0.0; 2], [1.0; 2]);
    for p in &mut poly.points {
        let [x, y, _] = *p;
        // Walls stay where they are below and above, as far as a slanted mesh has any there.
        if upwards { p[1] = y + t * x } else { p[0] = x + t * y }
    }
    let level = if upwards { 0.47 + 0.5 * t } else { 0.47 };
    let shape = Shape::half_space([0.0, 1.0, 0.0], [0.0, level, 0.0]);
    let mut two = water_and_air(&poly, shape);
    (two.geometric, two.numerics.compatible) = (geometric, compatible);
    let mut flow = two.flow(|_| wall());
    let mut most: f64 = 0.0;
    let steps = 400;
    for _ in 0..steps {
        flow.step(1.0 / steps as f64).expect("a step");
        most = most.max(fastest(&flow));
    }
    most
}

#[test]
fn still_water_stays_still_on_skewed_meshes() {
    for degrees in [0.0, 4.0, 15.0, 30.0, 60.0] {
        for upwards in [false, true] {
            for geometric in [false, true] {
                // Algebraic transport does not know where in a cell the interface is: rounding
                // grows there by e in 60 ms, faster the steeper the cells are.
                if !geometric && upwards && degrees > 4.0 {
                    continue;
                }
                let of = |compatible| still(degrees, upwards, geometric, compatible);
                for most in [false, true].map(of) {
                    println!(
                        "{degrees} degrees, up {upwards}, geometric {geometric}: {most:e} m/s"
                    );
                    assert!(most <= 1e-10, "{degrees} degrees: {most:e} m/s");
                }
            }
        }
    }
}

/// Fastest flow of water that should be still, on a mesh that leans by 15 degrees, with the normal
/// derivatives of density on faces taken as `sn_grad` says, with a momentum predictor or without.
fn still_with(sn_grad: Option<NormalDerivative>, predictor: bool) -> f64 {
    let mut poly = tank([10, 10], [0.0; 2], [1.0; 2]);
    let t = 15f64.to_radians().tan();
    poly.points.iter_mut().for_each(|p| p[1] += t * p[0]);
    let shape = Shape::half_space([0.0, 1.0, 0.0], [0.0, 0.47 + 0.5 * t, 0.0]);
    let mut two = water_and_air(&poly, shape);
    (two.geometric, two.numerics.sn_grad, two.numerics.predictor) = (true, sn_grad, predictor);
    let mut flow = two.flow(|_| wall());
    for _ in 0..10 {
        flow.step(2.5e-3).expect("a step");
    }
    fastest(&flow)
}

/// Pressure and density that are not taken alike on faces do not balance there.
#[test]
fn density_on_faces_has_a_scheme_of_its_own() {
    let how = |limit| Some(NormalDerivative { limit, orthogonal: false });
    for predictor in [false, true] {
        let of = |sn_grad| still_with(sn_grad, predictor);
        let [alike, none, limited] = [None, how(0.0), how(0.2)].map(of);
        println!(
            "predictor {predictor}: alike {alike:e}, uncorrected {none:e}, limited {limited:e} m/s"
        );
        assert_eq!(alike.to_bits(), of(how(1.0)).to_bits(), "that of the Laplacian");
        // A predictor's velocity is as good as its solver.
        assert!(alike < if predictor { 1e-4 } else { 1e-10 });
        assert!(none > 0.1 && limited > 0.1 && limited != none);
    }
}

#[test]
fn a_drop_has_laplaces_pressure() {
    let poly = tank([64, 64], [0.0; 2], [1.0; 2]);
    let radius = 0.25;
    let shape = Shape::cylinder([0.5, 0.5, 0.0], [0.0, 0.0, 1.0], radius);
    let mut two = water_and_air(&poly, shape);
    (two.gravity, two.rho, two.eta, two.sigma) = ([0.0; 3], [1.0; 2], [0.05; 2], 1.0);
    let mut flow = two.flow(|_| slip());
    for _ in 0..20 {
        flow.step(1e-4).expect("a step");
    }
    let p = |x: Vec3| {
        let m = &flow.mesh;
        let far = |c: usize| {
            let d = granflow_base::sub(m.cell_centre[c], x);
            dot([d[0], d[1], 0.0], [d[0], d[1], 0.0])
        };
        let c = (0..m.n_cells).min_by(|a, b| far(*a).total_cmp(&far(*b))).expect("a cell");
        flow.state.p.cells.data[c]
    };
    let jump = (p([0.5, 0.5, 0.0]) - p([0.05, 0.05, 0.0])) * radius;
    println!("jump over sigma/R: {jump}, greatest speed {:e}", fastest(&flow));
    assert!((jump - 1.0).abs() < 0.06, "{jump}");
    // Speeds are small beside sigma/eta = 20 m/s.
    assert!(fastest(&flow) < 0.1, "{}", fastest(&flow));
}

fn collapsing(threads: usize, geometric: bool) -> granflow_flow::Flow {
    let poly = tank([24, 16], [0.0; 2], [0.6, 0.4]);
    let shape = Shape::cuboid([-1.0; 3], [0.15, 0.3, 1.0]);
    let mut two = water_and_air(&poly, shape);
    (two.threads, two.geometric, two.sigma) = (threads, geometric, 0.07);
    two.flow(|_| wall())
}

#[test]
fn same_bits_for_any_number_of_threads() {
    for geometric in [false, true] {
        let bits = |threads| {
            let mut flow = collapsing(threads, geometric);
            for _ in 0..30 {
                flow.step(2e-3).expect("a step");
            }
            let s = &flow.state;
            let u = s.u.cells.data.iter().flatten();
            let all = u.chain(&s.p.cells.data).chain(&s.phi.data).chain(alpha(&flow));
            all.map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        let serial = bits(1);
        assert!([2, 3].into_iter().all(|threads| bits(threads) == serial), "{geometric}");
    }
}

#[test]
fn a_collapsing_column_keeps_its_volume_and_moves_as_gravity_says() {
    for geometric in [false, true] {
        let mut flow = collapsing(1, geometric);
        let volume = |flow: &granflow_flow::Flow| -> f64 {
            alpha(flow).iter().zip(&flow.mesh.volume).map(|(a, v)| a * v).sum()
        };
        let energy = |flow: &granflow_flow::Flow| -> f64 {
            let one = |c: usize| {
                let rho = 1000.0 * alpha(flow)[c] + 1.0 - alpha(flow)[c];
                let u = flow.state.u.cells.data[c];
                rho * flow.mesh.volume[c] * (0.5 * dot(u, u) + 9.81 * flow.mesh.cell_centre[c][1])
            };
            (0..flow.mesh.n_cells).map(one).sum()
        };
        let (v, e) = (volume(&flow), energy(&flow));
        let centre = |flow: &granflow_flow::Flow| -> f64 {
            let x = |c: usize| alpha(flow)[c] * flow.mesh.volume[c] * flow.mesh.cell_centre[c][0];
            (0..flow.mesh.n_cells).map(x).sum::<f64>() / v
        };
        let before = centre(&flow);
        for _ in 0..100 {
            let report = flow.step(1e-3).expect("a step");
            let vof = report.vof.expect("two fluids");
            assert!(vof.min > -1e-8 && vof.max < 1.0 + 1e-8, "{vof:?}");
        }
        println!(
            "geometric {geometric}: volume {:e}, energy {:e}, centre {:e} -> {:e}",
            volume(&flow) / v - 1.0,
            energy(&flow) / e - 1.0,
            before,
            centre(&flow)
        );
        assert!((volume(&flow) / v - 1.0).abs() < 1e-9);
        assert!(energy(&flow) < e, "no energy out of nothing");
        assert!(centre(&flow) > before + 0.01);
    }
}

/// With one density everywhere the second fluid is a dye: nothing moves, gravity or not.
#[test]
fn a_dye_does_not_move_its_fluid() {
    let poly = tank([12, 12], [0.0; 2], [1.0; 2]);
    let shape = Shape::cylinder([0.4, 0.5, 0.0], [0.0, 0.0, 1.0], 0.2);
    let mut two = water_and_air(&poly, shape);
    two.rho = [1000.0; 2];
    two.gravity = scale([0.6, -0.8, 0.0], 9.81);
    let mut flow = two.flow(|_| wall());
    for _ in 0..10 {
        flow.step(0.01).expect("a step");
    }
    assert!(fastest(&flow) < 1e-14, "{:e}", fastest(&flow));
}

/// A velocity that runs into a wall overfills no cell: what it has of divergence is taken from the
/// flux before the fractions move.
#[test]
fn the_first_flux_is_made_free_of_divergence() {
    for geometric in [false, true] {
        let poly = tank([20, 20], [0.0; 2], [1.0; 2]);
        let mut two = water_and_air(&poly, Shape::half_space([0.0, 1.0, 0.0], [0.0, 0.47, 0.0]));
        two.geometric = geometric;
        let mut flow = two.flow(|_| wall());
        let mesh = flow.mesh.clone();
        for f in 0..mesh.n_inner {
            flow.state.phi.data[f] = mesh.area[f][0];
        }
        let vof = flow.step(0.01).expect("a step").vof.expect("two fluids");
        println!("geometric {geometric}: {:e} to 1 + {:e}", vof.min, vof.max - 1.0);
        assert!(vof.min > -1e-8 && vof.max < 1.0 + 1e-8, "{:e}, {:e}", vof.min, vof.max - 1.0);
    }
}

#[test]
fn a_step_can_be_taken_back() {
    let mut flow = collapsing(1, true);
    for _ in 0..5 {
        flow.step(1e-3).expect("a step");
    }
    let (before, u) = (alpha(&flow).to_vec(), flow.state.u.cells.data.clone());
    flow.step(1e-3).expect("a step");
    assert!(before != alpha(&flow));
    flow.rollback();
    assert!(before == alpha(&flow) && u == flow.state.u.cells.data);
}

/// Two layers between plates, one of which slides: they bear one stress, and the interface lies in the middle of a
/// row of cells. Faces that know which way they look have the exact stress.
#[test]
fn viscosities_mix_as_the_case_says() {
    let stress = |mixing: Mixing| {
        let poly = shapes::periodic_box([2, 9, 2], [true, false, true]);
        let shape = Shape::half_space([0.0, 1.0, 0.0], [0.0, 0.5, 0.0]);
        let mut two = water_and_air(&poly, shape);
        (two.gravity, two.rho, two.eta) = ([0.0; 3], [1.0; 2], [10.0, 0.1]);
        (two.mixing, two.numerics.predictor) = (mixing, true);
        let mut flow = two.flow(|name| match name {
            "yMax" => Box::new(FixedValue::uniform([1.0, 0.0, 0.0])),
            _ => wall(),
        });
        for _ in 0..20 {
            flow.step(100.0).expect("a step");
        }
        let top = (0..flow.mesh.n_cells).find(|&c| flow.mesh.cell_centre[c][1] > 0.9);
        let u = flow.state.u.cells.data[top.expect("a cell")][0];
        0.1 * (1.0 - u) * 18.0
    };
    let exact = 1.0 / (0.5 / 10.0 + 0.5 / 0.1);
    let [harmonic, arithmetic, directed] =
        [Mixing::Harmonic, Mixing::Arithmetic, Mixing::FaceDirection]
            .map(|m| stress(m) / exact - 1.0);
    println!("harmonic {harmonic:.2e}, arithmetic {arithmetic:.2e}, faceDirection {directed:.2e}");
    assert!(directed.abs() < 1e-8, "{directed}");
    assert!(arithmetic > 0.05 && harmonic < 0.5 * arithmetic, "{harmonic} {arithmetic}");
}
