//! Order of accuracy and bounds of the convection schemes (P. J. Roache, J. Fluids Eng. 124 (2002)
//! 4), alone and with diffusion.

#![allow(
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::type_complexity,
    reason = "tests print what they measured, loops name their faces"
)]

mod common;

use common::manufactured::*;
use common::*;
use granflow_base::{Dims, Value, Vec3};
use granflow_fv::{
    CellField, Convection, Ddt, Equation, FaceField, Gradient, LeastSquares, LimiterKind, Unknown,
    ddt, div, div_explicit, laplacian, source,
};
use granflow_mesh::{Mesh, PatchKind, shapes};
use granflow_par::Exec;

/// What a scheme takes for the value at every inner face.
fn face_values(
    m: &Mesh,
    scheme: Convection,
    phi: &Unknown<f64>,
    gradient: &Gradient,
    flux: &FaceField<f64>,
) -> Vec<f64> {
    let exec = Exec::serial();
    let mut g = vec![[0.0; 3]; m.n_all()];
    gradient.of(&exec, m, phi, &mut g);
    let mut w = FaceField::new(m, "w", Dims::NONE, 0.0);
    let mut correction = FaceField::new(m, "c", Dims::VOLUME_FLUX, 0.0);
    scheme.weigh(&exec, m, phi, &g, &flux.data, &mut w, &mut correction);
    let x = &phi.cells.data;
    let value = |f: usize| {
        let (o, n) = (x[m.owner[f] as usize], x[m.neighbour[f] as usize]);
        w.data[f] * o + (1.0 - w.data[f]) * n + correction.data[f] / flux.data[f]
    };
    (0..m.n_inner).map(value).collect()
}

#[test]
fn convection_schemes_are_exact_for_linear_fields() {
    let exec = Exec::serial();
    let line = |p: Vec3| 4.0 + 2.0 * p[0] - 3.0 * p[1] + 0.5 * p[2];
    for u in [[1.0, 0.7, -0.4], [-1.0, -0.3, 0.6]] {
        for (name, poly) in boxes(5) {
            let m = mesh(&poly);
            let least_squares = Gradient::LeastSquares(LeastSquares::new(&m));
            let phi = unknown(&exec, &m, line, dirichlet(line));
            let flux = uniform_flux(&m, u);
            let off = |scheme| {
                let values = face_values(&m, scheme, &phi, &least_squares, &flux);
                (0..m.n_inner)
                    .map(|f| (values[f] - line(m.face_centre[f])).abs())
                    .fold(0.0, f64::max)
            };
            let e = off(Convection::LinearUpwind);
            assert!(e < 1e-12, "linearUpwind on {name}: {e:.1e}");
            if name == "hexahedra" || name == "leaning" {
                let e = off(Convection::Linear);
                assert!(e < 1e-12, "linear on {name}: {e:.1e}");
                for limiter in LimiterKind::NAMES {
                    let kind = LimiterKind::parse(limiter, 1.0).expect("a listed limiter");
                    let e = off(Convection::Limited(kind));
                    assert!(e < 1e-12, "{limiter} on {name}: {e:.1e}");
                }
            }
            assert!(off(Convection::Upwind) > 0.1, "upwind is first order");
        }
    }
    // Unequal cells: central interpolation still hits the face.
    let kinds = shapes::all(PatchKind::Patch);
    let graded = shapes::mapped_box([6, 5, 4], [0.0; 3], [1.0; 3], kinds, |p| p.map(|x| x * x));
    let m = mesh(&graded);
    let phi = unknown(&exec, &m, line, dirichlet(line));
    let flux = uniform_flux(&m, [1.0, 0.7, -0.4]);
    let values = face_values(&m, Convection::Linear, &phi, &Gradient::GaussLinear, &flux);
    for f in 0..m.n_inner {
        assert!((values[f] - line(m.face_centre[f])).abs() < 1e-12);
    }
}

#[test]
fn order_of_convection_and_diffusion() {
    let exec = Exec::serial();
    let (u, gamma) = ([1.0, 0.6, 0.0], 0.05);
    let exact = |[x, y, _]: Vec3| (3.0 * x).sin() * (2.0 * y + 0.5).sin();
    let rhs = |p: Vec3| {
        let [x, y, _] = p;
        let (a, b) = (3.0 * x, 2.0 * y + 0.5);
        u[0] * 3.0 * a.cos() * b.sin() + u[1] * 2.0 * a.sin() * b.cos() + gamma * 13.0 * exact(p)
    };
    let limited = |l: fn(f64) -> LimiterKind| Convection::Limited(l(1.0));
    for (scheme, range) in [
        (Convection::Upwind, 0.8..1.2),
        (Convection::Linear, 1.85..2.15),
        (Convection::LinearUpwind, 1.85..2.2),
        (limited(LimiterKind::LimitedLinear), 1.6..2.3),
        (limited(LimiterKind::VanLeer), 1.6..2.3),
        (limited(LimiterKind::Muscl), 1.6..2.3),
    ] {
        let errors: Vec<f64> = [16, 32, 64]
            .map(|n| {
                let sides = [const { PatchKind::Patch }; 4];
                let m = mesh(&shapes::plane_mesh([n, n], [0.0; 2], [1.0; 2], sides));
                let mut phi = unknown(&exec, &m, |_| 0.0, dirichlet(exact));
                let flux = uniform_flux(&m, u);
                let diffusivity = FaceField::new(&m, "D", Dims::KINEMATIC_VISCOSITY, gamma);
                let mut s = CellField::new(&m, "s", Dims::RATE, 0.0);
                (0..m.n_cells).for_each(|c| s.data[c] = rhs(m.cell_centre[c]));
                let mut g = vec![[0.0; 3]; m.n_all()];
                let mut w = FaceField::new(&m, "w", Dims::NONE, 0.5);
                let mut correction = FaceField::new(&m, "c", Dims::VOLUME_FLUX, 0.0);
                let mut eqn = Equation::new(&exec, &m);
                for _ in 0..25 {
                    Gradient::GaussLinear.of(&exec, &m, &phi, &mut g);
                    scheme.weigh(&exec, &m, &phi, &g, &flux.data, &mut w, &mut correction);
                    let terms = div(&flux, &w) + div_explicit(&correction)
                        - laplacian(&diffusivity)
                        - source(&s);
                    solve(&exec, &m, &mut eqn, &mut phi, &terms);
                }
                rms(&m, |c| phi.cells.data[c] - exact(m.cell_centre[c]))
            })
            .to_vec();
        println!("{}: {errors:?} {:?}", scheme.name(), orders(&errors));
        assert!(range.contains(&orders(&errors)[1]), "{}: {errors:?}", scheme.name());
    }
}

/// A step carried once through a periodic line, with every scheme; returns the range of values.
fn carry_a_step(scheme: Convection) -> [f64; 2] {
    let exec = Exec::serial();
    let n = 60;
    let m = mesh(&shapes::periodic_box([n, 1, 1], [true; 3]));
    let step = |[x, ..]: Vec3| if (0.25..0.5).contains(&x) { 1.0 } else { 0.0 };
    let mut phi = unknown(&exec, &m, step, dirichlet(step));
    let flux = uniform_flux(&m, [1.0, 0.0, 0.0]);
    let rho = CellField::new(&m, "1", Dims::NONE, 1.0);
    let mut g = vec![[0.0; 3]; m.n_all()];
    let mut w = FaceField::new(&m, "w", Dims::NONE, 0.5);
    let mut correction = FaceField::new(&m, "c", Dims::VOLUME_FLUX, 0.0);
    let mut eqn = Equation::new(&exec, &m);
    let mut range = [0.0f64, 1.0f64];
    for _ in 0..60 {
        let old = phi.cells.data.clone();
        for _ in 0..12 {
            Gradient::GaussLinear.of(&exec, &m, &phi, &mut g);
            scheme.weigh(&exec, &m, &phi, &g, &flux.data, &mut w, &mut correction);
            let inertia = Ddt {
                rho: &rho,
                rho_old: &rho,
                old: &old,
                older: &old,
                dt: 0.2 / n as f64,
                c: [1.0, 1.0, 0.0],
            };
            let terms = ddt(inertia) + div(&flux, &w) + div_explicit(&correction);
            solve(&exec, &m, &mut eqn, &mut phi, &terms);
        }
        for v in &phi.cells.data[..m.n_cells] {
            range = [range[0].min(*v), range[1].max(*v)];
        }
    }
    let total: f64 = phi.cells.data[..n].iter().sum();
    assert!((total / n as f64 - 0.25).abs() < 1e-8, "{}: conserves", scheme.name());
    range
}

#[test]
fn limited_schemes_stay_within_bounds_at_a_step() {
    let [low, high] = carry_a_step(Convection::Linear);
    assert!(low < -0.02 && high > 1.02, "central differences overshoot: the test can fail");
    let [low, high] = carry_a_step(Convection::Upwind);
    assert!(low > -1e-9 && high < 1.0 + 1e-9);
    for name in LimiterKind::NAMES {
        let kind = LimiterKind::parse(name, 1.0).expect("a listed limiter");
        let [low, high] = carry_a_step(Convection::Limited(kind));
        println!("{name}: {low:.1e} {:.1e}", high - 1.0);
        assert!(low > -1e-6 && high < 1.0 + 1e-6, "{name}: {low:.2e} {:.2e}", high - 1.0);
    }
}

#[test]
fn vectors_are_carried_like_scalars() {
    // A vector whose components are scalars that linear schemes treat alike.
    let exec = Exec::serial();
    let m = mesh(&shapes::unit_box([6; 3]));
    let flux = uniform_flux(&m, [1.0, 0.7, -0.4]);
    let phi = unknown(&exec, &m, f, dirichlet(f));
    let triple = |p: Vec3| [f(p), -2.0 * f(p), 0.5 * f(p)];
    let u = unknown(&exec, &m, triple, dirichlet(triple));
    let mut g = vec![[0.0; 3]; m.n_all()];
    let mut gu = vec![[0.0; 9]; m.n_all()];
    Gradient::GaussLinear.of(&exec, &m, &phi, &mut g);
    Gradient::GaussLinear.of(&exec, &m, &u, &mut gu);
    for scheme in [
        Convection::LinearUpwind,
        Convection::Limited(LimiterKind::VanLeer(1.0)),
        Convection::Limited(LimiterKind::SuperBee(1.0)),
    ] {
        let [mut w, mut wu] = [0, 1].map(|_| FaceField::new(&m, "w", Dims::NONE, 0.0));
        let mut c = FaceField::new(&m, "c", Dims::VOLUME_FLUX, 0.0);
        let mut cu = FaceField::new(&m, "c", Dims::VOLUME_FLUX, [0.0; 3]);
        scheme.weigh(&exec, &m, &phi, &g, &flux.data, &mut w, &mut c);
        scheme.weigh(&exec, &m, &u, &gu, &flux.data, &mut wu, &mut cu);
        for i in 0..m.n_inner {
            assert!((w.data[i] - wu.data[i]).abs() < 1e-9, "{} {i}", scheme.name());
            assert!(
                (cu.data[i].minus([1.0, -2.0, 0.5].scaled(c.data[i]))).inner([1.0; 3]).abs()
                    < 1e-12
            );
        }
    }
}
