//! Order of accuracy of every convection scheme, gradient limiter and normal derivative on
//! hexahedra, prisms, tetrahedra and polyhedra, by a manufactured solution of convection and
//! diffusion (P. J. Roache, J. Fluids Eng. 124 (2002) 4) without extrema, where limiters are of
//! their formal order.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Dims, Vec3, dot, sub};
use granflow_fv::{
    CellField, Convection, Equation, FaceField, Gradient, GradientLimit, GradientLimiter,
    LeastSquares, LimiterKind, Shares, div, div_explicit, laplacian, operators, source,
};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;

const VELOCITY: Vec3 = [1.0, 0.6, 0.4];
const DIFFUSIVITY: f64 = 0.3;

fn exact([x, y, z]: Vec3) -> f64 {
    (0.9 * x + 0.6 * y + 0.5 * z).exp() + 0.4 * (0.5 * x).sin()
}

/// `u . grad phi - D lap phi` in the plane or in space.
fn rhs([x, y, z]: Vec3, space: bool) -> f64 {
    let e = (0.9 * x + 0.6 * y + 0.5 * z).exp();
    let s = 0.4 * (0.5 * x).sin();
    let flat = VELOCITY[0] * (0.9 * e + 0.2 * (0.5 * x).cos()) + VELOCITY[1] * 0.6 * e
        - DIFFUSIVITY * ((0.81 + 0.36) * e - 0.25 * s);
    if space { flat + VELOCITY[2] * 0.5 * e - DIFFUSIVITY * 0.25 * e } else { flat }
}

/// Meshes of the unit box by name, one layer of cells but for tetrahedra.
const SHAPES: [&str; 4] = ["hexahedra", "prisms", "tetrahedra", "polyhedra"];

fn box_of(shape: &str, n: usize) -> (PolyMesh, bool) {
    let p = PatchKind::Patch;
    let flat = [p.clone(), p.clone(), p.clone(), p, PatchKind::Empty, PatchKind::Empty];
    match shape {
        "hexahedra" => {
            // Cells that lean and grow, smoothly.
            let map = |[x, y, z]: Vec3| [x + 0.1 * x * (1.0 - x), y + 0.1 * x * y * (1.0 - y), z];
            (shapes::mapped_box([n, n, 1], [0.0; 3], [1.0, 1.0, 0.1], flat, map), false)
        }
        "prisms" => (shapes::prism_box([n, n, 1], [0.0; 3], [1.0, 1.0, 0.1], flat), false),
        "polyhedra" => (shapes::brick_plane(n), false),
        _ => (shapes::tetrahedra(n / 4), true),
    }
}

/// Root mean square error of the solution with `scheme`, whose gradients are limited by `limiter`.
fn error(m: &Mesh, space: bool, scheme: Convection, limiter: Option<GradientLimiter>) -> f64 {
    let exec = Exec::serial();
    let velocity = if space { VELOCITY } else { [VELOCITY[0], VELOCITY[1], 0.0] };
    // In the plane the layer's middle is where z is constant.
    let here = |p: Vec3| exact(if space { p } else { [p[0], p[1], 0.0] });
    let mut phi = unknown(&exec, m, here, dirichlet(here));
    let flux = uniform_flux(m, velocity);
    let diffusivity = FaceField::new(m, "D", Dims::KINEMATIC_VISCOSITY, DIFFUSIVITY);
    let mut s = CellField::new(m, "s", Dims::RATE, 0.0);
    for c in 0..m.n_cells {
        let [x, y, z] = m.cell_centre[c];
        s.data[c] = rhs([x, y, if space { z } else { 0.0 }], space);
    }
    let mut g = vec![[0.0; 3]; m.n_all()];
    let mut w = FaceField::new(m, "w", Dims::NONE, 0.5);
    let mut correction = FaceField::new(m, "c", Dims::VOLUME_FLUX, 0.0);
    let mut leaning = FaceField::new(m, "q", Dims::VOLUME_FLUX, 0.0);
    let mut eqn = Equation::new(&exec, m);
    let gradient = Gradient::LeastSquares(LeastSquares::new(m));
    for _ in 0..PASSES {
        gradient.of(&exec, m, &phi, &mut g);
        operators::non_orthogonal_flux(&exec, m, &phi, &g, &diffusivity, 1.0, &mut leaning);
        if let Some(limiter) = limiter {
            limiter.apply(&exec, m, &phi, &mut g);
        }
        correction.data.fill(0.0);
        scheme.weigh(&exec, m, &phi, &g, &flux.data, &mut w, &mut correction);
        granflow_fv::defer_to_upwind(&exec, m, &phi, &flux.data, &mut w, &mut correction);
        let terms = div(&flux, &w) + div_explicit(&correction)
            - laplacian(&diffusivity)
            - div_explicit(&leaning)
            - source(&s);
        solve(&exec, m, &mut eqn, &mut phi, &terms);
    }
    rms(m, |c| phi.cells.data[c] - here(m.cell_centre[c]))
}

/// Enough for the explicit parts to be in balance far below the error.
const PASSES: usize = 30;

/// Observed order between the two finest of three meshes.
fn order(shape: &str, scheme: Convection, limiter: Option<GradientLimiter>) -> f64 {
    // First order shows later than second: its error is that of a longer series.
    let finer = if scheme == Convection::Upwind && shape == "polyhedra" { 4 } else { 1 };
    let errors = [16, 32, 64].map(|n| {
        let n = n * finer;
        let (poly, space) = box_of(shape, n);
        error(&mesh(&poly), space, scheme, limiter)
    });
    let observed = orders(&errors)[1];
    println!("{:14} {shape:11} {errors:?} {observed:.3} {limiter:?}", scheme.name());
    observed
}

/// All schemes with their formal order.
fn schemes() -> Vec<(Convection, f64)> {
    let linear = Shares { linear: 1.0, ..Shares::default() };
    let upwind = Shares { linear_upwind: 1.0, ..Shares::default() };
    let mut all = vec![
        (Convection::Upwind, 1.0),
        (Convection::Linear, 2.0),
        (Convection::LinearUpwind, 2.0),
        (Convection::LinearUpwindV, 2.0),
        (Convection::Mixed(Shares::CUBIC), 2.0),
        (Convection::Mixed(Shares::LUST), 2.0),
        (Convection::Mixed(Shares::blend(0.6, linear, upwind)), 2.0),
    ];
    let limiter = |name: &&str| Convection::Limited(LimiterKind::parse(name, 1.0).expect("listed"));
    all.extend(LimiterKind::NAMES.iter().map(|name| (limiter(name), 2.0)));
    all
}

fn convection_on(shape: &str) {
    for (scheme, formal) in schemes() {
        let observed = order(shape, scheme, None);
        assert!((observed - formal).abs() <= 0.1, "{} on {shape}: {observed:.3}", scheme.name());
    }
}

fn limiters() -> [GradientLimiter; 4] {
    GradientLimiter::NAMES.map(|(_, limit)| GradientLimiter { limit, k: 1.0 })
}

#[test]
#[ignore = "prints the table"]
fn table() {
    for shape in SHAPES {
        for (scheme, _) in schemes() {
            order(shape, scheme, None);
        }
        for limiter in limiters() {
            order(shape, Convection::LinearUpwind, Some(limiter));
        }
    }
}

/// Where nothing overshoots, limiters leave the order of the extrapolation as it is.
#[test]
fn limited_gradients_keep_the_order() {
    for limiter in limiters() {
        for shape in SHAPES {
            let observed = order(shape, Convection::LinearUpwind, Some(limiter));
            // Where two cells of a face lie across the gradient their values alone say nothing of the
            // face's, and bounds of these two make the extrapolation upwind.
            let of_two = matches!(limiter.limit, GradientLimit::Face | GradientLimit::FaceMd);
            let formal = match of_two && matches!(shape, "tetrahedra" | "polyhedra") {
                true => 0.9..=2.1,
                false => 1.9..=2.1,
            };
            assert!(formal.contains(&observed), "{limiter:?} on {shape}: {observed:.3}");
        }
    }
}

/// Root mean square error of the gradient in cells without boundary faces, and of the normal derivative with
/// its non-orthogonal correction on faces between such cells.
fn slopes(m: &Mesh, space: bool, gradient: &Gradient) -> [f64; 2] {
    let exec = Exec::serial();
    let here = |p: Vec3| exact(if space { p } else { [p[0], p[1], 0.0] });
    let slope = |[x, y, z]: Vec3| {
        let e = (0.9 * x + 0.6 * y + if space { 0.5 * z } else { 0.0 }).exp();
        [0.9 * e + 0.2 * (0.5 * x).cos(), 0.6 * e, if space { 0.5 * e } else { 0.0 }]
    };
    let phi = unknown(&exec, m, here, dirichlet(here));
    let mut g = vec![[0.0; 3]; m.n_all()];
    gradient.of(&exec, m, &phi, &mut g);
    let off = |c: usize| {
        let d = sub(g[c], slope(m.cell_centre[c]));
        if inside(m, c) { dot(d, d).sqrt() } else { 0.0 }
    };
    let (mut sum, mut area) = (0.0, 0.0);
    let within = |f: &usize| [m.owner[*f], m.neighbour[*f]].iter().all(|c| inside(m, *c as usize));
    for f in (0..m.n_inner).filter(within) {
        let normal = m.normal(f);
        let ours = operators::normal_derivative(m, &phi, Some(&g), f);
        sum += m.mag_area[f] * (ours - dot(slope(m.face_centre[f]), normal)).powi(2);
        area += m.mag_area[f];
    }
    [rms(m, off), (sum / area).sqrt()]
}

/// Second order where neighbours lie opposite each other, first where they do not: there what is left of
/// the second derivative in a cell does not cancel.
#[test]
fn gradients_and_normal_derivatives_on_every_kind_of_cell() {
    for least_squares in [false, true] {
        for shape in SHAPES {
            let errors = [16, 32, 64].map(|n| {
                // Tetrahedra are large yet.
                let finer = if shape == "tetrahedra" { 2 } else { 1 };
                let (poly, space) = box_of(shape, finer * n);
                let m = mesh(&poly);
                let gradient = match least_squares {
                    true => Gradient::LeastSquares(LeastSquares::new(&m)),
                    false => Gradient::GaussLinear,
                };
                slopes(&m, space, &gradient)
            });
            let [gradient, normal] = [0, 1].map(|k| {
                let e = errors.map(|e| e[k]);
                (orders(&e)[1], e[2])
            });
            println!("least squares {least_squares}, {shape}: {gradient:?} {normal:?}");
            let formal = if shape == "hexahedra" { 2.0 } else { 1.0 };
            assert!(gradient.0 > formal - 0.1, "{shape}: {gradient:?}");
            assert!(normal.0 > formal - 0.1, "{shape}: {normal:?}");
        }
    }
}

/// Extrapolated to the faces a limited gradient stays within the values around, at a step as well.
#[test]
fn limited_gradients_stay_within_what_is_around() {
    let exec = Exec::serial();
    let step = |[x, y, _]: Vec3| if x + 0.3 * y > 0.6 { 1.0 } else { 0.0 };
    for shape in SHAPES {
        let m = mesh(&box_of(shape, 12).0);
        let phi = unknown(&exec, &m, step, dirichlet(step));
        let gradient = Gradient::LeastSquares(LeastSquares::new(&m));
        let beyond = |limiter: Option<GradientLimiter>| {
            let mut g = vec![[0.0; 3]; m.n_all()];
            gradient.of(&exec, &m, &phi, &mut g);
            if let Some(limiter) = limiter {
                limiter.apply(&exec, &m, &phi, &mut g);
            }
            let mut most = 0.0f64;
            for (c, g) in g.iter().enumerate().take(m.n_cells) {
                for (f, s) in m.faces_of(c) {
                    let mut arm = sub(m.face_centre[f], m.cell_centre[m.owner[f] as usize]);
                    if s < 0.0 {
                        arm = sub(arm, m.delta[f]);
                    }
                    let value = phi.cells.data[c] + dot(*g, arm);
                    most = most.max(-value).max(value - 1.0);
                }
            }
            most
        };
        assert!(beyond(None) > 0.1, "{shape}: the test can fail");
        // What the parts along several faces leave may add up in the multidimensional ones.
        for limit in [GradientLimit::Cell, GradientLimit::Face] {
            assert!(beyond(Some(GradientLimiter { limit, k: 1.0 })) < 1e-12, "{limit:?} {shape}");
        }
        let half = GradientLimiter { limit: GradientLimit::Cell, k: 0.5 };
        assert!(beyond(Some(half)) > 1e-3, "half a limiter lets more through");
        let none = GradientLimiter { limit: GradientLimit::Cell, k: 0.0 };
        assert!((beyond(Some(none)) - beyond(None)).abs() < 1e-15);
    }
}

/// The cubic's value at the face of a regular mesh, from exact values in the cells.
#[test]
fn the_cubic_is_of_fourth_order_at_a_face() {
    let exec = Exec::serial();
    let wave = |[x, ..]: Vec3| (std::f64::consts::TAU * x).sin();
    let errors = [16, 32, 64].map(|n| {
        let m = mesh(&shapes::periodic_box([n, 1, 1], [true; 3]));
        let phi = unknown(&exec, &m, wave, dirichlet(wave));
        let flux = uniform_flux(&m, [1.0, 0.0, 0.0]);
        let mut g = vec![[0.0; 3]; m.n_all()];
        Gradient::GaussLinear.of(&exec, &m, &phi, &mut g);
        let mut w = FaceField::new(&m, "w", Dims::NONE, 0.5);
        let mut c = FaceField::new(&m, "c", Dims::VOLUME_FLUX, 0.0);
        Convection::Mixed(Shares::CUBIC).weigh(&exec, &m, &phi, &g, &flux.data, &mut w, &mut c);
        let mut most = 0.0f64;
        for f in (0..m.n_inner).filter(|f| flux.data[*f] != 0.0) {
            let x = &phi.cells.data;
            let (o, n) = (x[m.owner[f] as usize], x[m.neighbour[f] as usize]);
            let value = w.data[f] * o + (1.0 - w.data[f]) * n + c.data[f] / flux.data[f];
            most = most.max((value - wave(m.face_centre[f])).abs());
        }
        most
    });
    println!("cubic at faces {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 4.0).abs() < 0.1, "{errors:?}");
}

#[test]
fn convection_on_hexahedra() {
    convection_on("hexahedra");
}

#[test]
fn convection_on_prisms() {
    convection_on("prisms");
}

#[test]
fn convection_on_tetrahedra() {
    convection_on("tetrahedra");
}

#[test]
fn convection_on_polyhedra() {
    convection_on("polyhedra");
}
