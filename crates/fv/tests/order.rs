//! Order of accuracy of every operator by manufactured solutions (P. J. Roache, J. Fluids Eng.
//! 124 (2002) 4), on regular and on bad meshes, and across every kind of coupled patch.

#![allow(
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::type_complexity,
    reason = "tests print what they measured, loops name their faces"
)]

mod common;

use common::*;
use granflow_base::{Dims, Tensor, Value, Vec3, cross, dot, norm, scale, sub, unit};
use granflow_fv::conditions::ZeroGradient;
use granflow_fv::{
    CellField, Convection, Ddt, Differentiable, Equation, FaceField, Gradient, LeastSquares,
    LimiterKind, Unknown, ddt, div, div_explicit, laplacian, operators, source, sp,
};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use std::f64::consts::TAU;

/// The manufactured scalar, its gradient and its Laplacian.
fn f([x, y, z]: Vec3) -> f64 {
    (2.0 * x + 0.3).sin() * (1.5 * y).cos() * (0.7 * z).exp()
}
fn grad_f([x, y, z]: Vec3) -> Vec3 {
    let (a, b, c) = (2.0 * x + 0.3, 1.5 * y, (0.7 * z).exp());
    [2.0 * a.cos() * b.cos() * c, -1.5 * a.sin() * b.sin() * c, 0.7 * a.sin() * b.cos() * c]
}
fn lap_f(p: Vec3) -> f64 {
    (-4.0 - 2.25 + 0.49) * f(p)
}
/// A manufactured vector and its divergence.
fn v(p: Vec3) -> Vec3 {
    [f(p), f([p[1], p[2], p[0]]), p[0] * p[2] - p[1] * p[1]]
}
fn div_v(p: Vec3) -> f64 {
    grad_f(p)[0] + grad_f([p[1], p[2], p[0]])[0] + p[0]
}

/// Greatest and mean error of the gradient in the cells off the boundary.
fn gradient_error(gradient: &Gradient, m: &Mesh) -> [f64; 2] {
    let exec = Exec::serial();
    let phi = unknown(&exec, m, f, dirichlet(f));
    let mut g = vec![[0.0; 3]; m.n_all()];
    gradient.of(&exec, m, &phi, &mut g);
    let error = |c: usize| norm(sub(g[c], grad_f(m.cell_centre[c])));
    let within: Vec<f64> = (0..m.n_cells).filter(|c| inside(m, *c)).map(error).collect();
    let mean = (within.iter().map(|e| e * e).sum::<f64>() / within.len() as f64).sqrt();
    [within.iter().copied().fold(0.0, f64::max), mean]
}

#[test]
fn gauss_gradient_is_second_order_inside_regular_hexahedra() {
    let errors: Vec<f64> = [8, 16, 32]
        .map(|n| {
            let m = mesh(&shapes::unit_box([n; 3]));
            gradient_error(&Gradient::GaussLinear, &m)[0]
        })
        .to_vec();
    println!("Gauss gradient inside: {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}");
}

#[test]
fn least_squares_gradient_orders() {
    for shape in 0..4 {
        let mut name = "";
        let errors: Vec<f64> = [6, 12, 24]
            .map(|n| {
                let (what, poly) = boxes(n).swap_remove(shape);
                name = what;
                let m = mesh(&poly);
                let least_squares = Gradient::LeastSquares(LeastSquares::new(&m));
                let [most, mean] = gradient_error(&least_squares, &m);
                // Random cells: the more of them, the worse the worst.
                if what == "displaced" { mean } else { most }
            })
            .to_vec();
        println!("least squares on {name}: {errors:?} {:?}", orders(&errors));
        // First order on any mesh, second where neighbours lie opposite each other.
        let least = if name == "hexahedra" || name == "leaning" { 1.75 } else { 0.9 };
        assert!(orders(&errors)[1] > least, "{name}: {errors:?}");
    }
}

#[test]
fn least_squares_gradient_is_exact_for_linear_fields_on_any_mesh() {
    let exec = Exec::serial();
    let k: Tensor = [1.0, -2.0, 0.5, 3.0, 0.25, -1.0, 2.0, 1.5, -0.75];
    let scalar = |p: Vec3| 4.0 + 2.0 * p[0] - 3.0 * p[1] + 0.5 * p[2];
    // U_j = x_i k_ij, so that d_i U_j = k_ij.
    let vector = |p: Vec3| Vec3::along(k, p);
    for (name, poly) in boxes(5) {
        let m = mesh(&shapes::shuffled(&poly, 3));
        let least_squares = Gradient::LeastSquares(LeastSquares::new(&m));
        let s = unknown(&exec, &m, scalar, dirichlet(scalar));
        let mut g = vec![[0.0; 3]; m.n_all()];
        least_squares.of(&exec, &m, &s, &mut g);
        let e = greatest(&m, |_| true, |c| norm(sub(g[c], [2.0, -3.0, 0.5])));
        let u = unknown(&exec, &m, vector, dirichlet(vector));
        let mut g = vec![[0.0; 9]; m.n_all()];
        least_squares.of(&exec, &m, &u, &mut g);
        let worst = |c: usize| (0..9).map(|i| (g[c][i] - k[i]).abs()).fold(0.0, f64::max);
        let e_v = greatest(&m, |_| true, worst);
        assert!(e < 1e-12 && e_v < 1e-12, "{name}: {e:.1e} {e_v:.1e}");
    }
    // In the plane: nothing is known, and nothing asked, along z.
    let plane = shapes::plane_mesh([6, 5], [0.0; 2], [1.0; 2], [const { PatchKind::Wall }; 4]);
    let m = mesh(&plane);
    let flat = |p: Vec3| 4.0 + 2.0 * p[0] - 3.0 * p[1];
    let s = unknown(&exec, &m, flat, dirichlet(flat));
    let mut g = vec![[0.0; 3]; m.n_all()];
    Gradient::LeastSquares(LeastSquares::new(&m)).of(&exec, &m, &s, &mut g);
    assert!(greatest(&m, |_| true, |c| norm(sub(g[c], [2.0, -3.0, 0.0]))) < 1e-12);
}

#[test]
fn gauss_gradient_across_periodic_patches() {
    let wave = |[x, y, _]: Vec3| (TAU * x).sin() * (TAU * y).cos();
    let exec = Exec::serial();
    let errors: Vec<f64> = [16, 32]
        .map(|n| {
            let m = mesh(&shapes::periodic_box([n, n, 1], [true; 3]));
            let phi = unknown(&exec, &m, wave, dirichlet(wave));
            let mut g = vec![[0.0; 3]; m.n_all()];
            Gradient::GaussLinear.of(&exec, &m, &phi, &mut g);
            greatest(
                &m,
                |_| true,
                |c| {
                    let [x, y, _] = m.cell_centre[c];
                    let (a, b) = (TAU * x, TAU * y);
                    norm(sub(g[c], [TAU * a.cos() * b.cos(), -TAU * a.sin() * b.sin(), 0.0]))
                },
            )
        })
        .to_vec();
    assert!((orders(&errors)[0] - 2.0).abs() < 0.05, "{errors:?}");
}

#[test]
fn divergence_of_a_flux() {
    let exec = Exec::serial();
    // Displaced hexahedra have warped faces, for which one point a face is no rule of any order;
    // what does not vary leaves nothing behind on any mesh.
    for (name, poly) in boxes(6) {
        let m = mesh(&poly);
        let mut d = vec![0.0; m.n_cells];
        operators::divergence(&exec, &m, &uniform_flux(&m, [1.0, -2.0, 0.5]), &mut d);
        assert!(greatest(&m, |_| true, |c| d[c].abs()) < 1e-12, "{name}");
    }
    for (shape, least) in [(3, 1.85), (1, 1.85), (2, 0.8)] {
        let mut name = "";
        let errors: Vec<f64> = [6, 12, 24]
            .map(|n| {
                let (what, poly) = boxes(n).swap_remove(shape);
                name = what;
                let m = mesh(&poly);
                // Exact values on faces: what is left is the quadrature of one point a face.
                let mut flux = FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0);
                for i in 0..m.n_faces() {
                    flux.data[i] = dot(v(m.face_centre[i]), m.area[i]);
                }
                let mut d = vec![0.0; m.n_cells];
                operators::divergence(&exec, &m, &flux, &mut d);
                rms(&m, |c| d[c] - div_v(m.cell_centre[c]))
            })
            .to_vec();
        println!("divergence on {name}: {errors:?} {:?}", orders(&errors));
        assert!(orders(&errors)[1] > least, "{name}: {errors:?}");
    }
    // Interpolated from cells, inside regular hexahedra.
    let errors: Vec<f64> = [8, 16, 32]
        .map(|n| {
            let m = mesh(&shapes::unit_box([n; 3]));
            let u = unknown(&exec, &m, v, dirichlet(v));
            let mut flux = FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0);
            operators::flux(&exec, &m, &u, &u.cells.data, &mut flux);
            let mut d = vec![0.0; m.n_cells];
            operators::divergence(&exec, &m, &flux, &mut d);
            greatest(&m, |c| inside(&m, c), |c| (d[c] - div_v(m.cell_centre[c])).abs())
        })
        .to_vec();
    println!("divergence of interpolated velocity: {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}");
}

/// Solves `sink phi - lap phi = s` with deferred non-orthogonal correction.
fn diffuse(m: &Mesh, phi: &mut Unknown<f64>, s: impl Fn(Vec3) -> f64, sink: f64) {
    let exec = Exec::serial();
    let one = ones(m);
    let mut source_field = CellField::new(m, "s", Dims::LENGTH.mul(Dims::LENGTH).inv(), 0.0);
    for c in 0..m.n_cells {
        source_field.data[c] = s(m.cell_centre[c]);
    }
    let k = CellField::new(m, "k", Dims::AREA.inv(), sink);
    let gradient = Gradient::LeastSquares(LeastSquares::new(m));
    let mut g = vec![[0.0; 3]; m.n_all()];
    let mut q = FaceField::new(m, "q", Dims::LENGTH, 0.0);
    let mut eqn = Equation::new(&exec, m);
    let leans = m.nonorth.iter().any(|k| norm(*k) > 1e-6);
    let passes = if leans { 14 } else { 1 };
    for _ in 0..passes {
        gradient.of(&exec, m, phi, &mut g);
        operators::non_orthogonal_flux(&exec, m, phi, &g, &one, 1.0, &mut q);
        let terms = sp(&k) - laplacian(&one) - div_explicit(&q) - source(&source_field);
        solve(&exec, m, &mut eqn, phi, &terms);
    }
}

#[test]
fn laplacian_with_fixed_values() {
    fixed_values(&[0, 2, 3]);
}

/// Cells that lean at the wall: the line from the cell's centre to the face's is not normal.
#[test]
fn laplacian_with_fixed_values_on_leaning_cells() {
    fixed_values(&[1]);
}

fn fixed_values(shapes: &[usize]) {
    let exec = Exec::serial();
    for &shape in shapes {
        let mut name = "";
        let errors: Vec<f64> = [6, 12, 24]
            .map(|n| {
                let (what, poly) = boxes(n).swap_remove(shape);
                name = what;
                let m = mesh(&poly);
                let mut phi = unknown(&exec, &m, |_| 0.0, dirichlet(f));
                diffuse(&m, &mut phi, |p| -lap_f(p), 0.0);
                rms(&m, |c| phi.cells.data[c] - f(m.cell_centre[c]))
            })
            .to_vec();
        println!("Laplacian on {name}: {errors:?} {:?}", orders(&errors));
        match name {
            "hexahedra" => assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}"),
            // Skewness is not corrected: it costs up to one order.
            "displaced" | "prisms" => assert!(orders(&errors)[1] > 1.5, "{name}: {errors:?}"),
            _ => assert!(orders(&errors)[1] > 1.8, "{name}: {errors:?}"),
        }
    }
}

#[test]
fn laplacian_with_fixed_gradients() {
    let exec = Exec::serial();
    let errors: Vec<f64> = [8, 16, 32]
        .map(|n| {
            let m = mesh(&shapes::unit_box([n; 3]));
            let condition = |m: &Mesh, p: usize| match m.patches[p].name.as_str() {
                "xMin" => dirichlet(f)(m, p),
                _ => neumann(grad_f)(m, p),
            };
            let mut phi = unknown(&exec, &m, |_| 0.0, condition);
            diffuse(&m, &mut phi, |p| -lap_f(p), 0.0);
            rms(&m, |c| phi.cells.data[c] - f(m.cell_centre[c]))
        })
        .to_vec();
    println!("Laplacian, Neumann: {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}");
}

#[test]
fn laplacian_across_periodic_patches() {
    let exec = Exec::serial();
    let wave = |[x, y, z]: Vec3| (TAU * x).sin() * (TAU * y).cos() * (TAU * z + 0.4).sin();
    let bent = |n: usize| -> PolyMesh {
        let hexes = shapes::periodic_box([n; 3], [true; 3]);
        shapes::displaced(&hexes, 0.15, 11)
    };
    let meshes: [(&str, &dyn Fn(usize) -> PolyMesh); 2] =
        [("hexahedra", &|n| shapes::periodic_box([n; 3], [true; 3])), ("displaced", &bent)];
    for (name, poly) in meshes {
        let errors: Vec<f64> = [8, 16, 32]
            .map(|n| {
                let m = mesh(&poly(n));
                let mut phi = unknown(&exec, &m, |_| 0.0, dirichlet(wave));
                diffuse(&m, &mut phi, |p| (1.0 + 3.0 * TAU * TAU) * wave(p), 1.0);
                rms(&m, |c| phi.cells.data[c] - wave(m.cell_centre[c]))
            })
            .to_vec();
        println!("Laplacian, periodic {name}: {errors:?} {:?}", orders(&errors));
        match name {
            "hexahedra" => assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}"),
            _ => assert!(orders(&errors)[1] > 1.5, "{errors:?}"),
        }
    }
}

/// The same on leaning cells, where no boundary is: the correction is second order.
#[test]
fn laplacian_across_periodic_patches_on_leaning_cells() {
    let exec = Exec::serial();
    let (alpha, beta) = (-0.4 * TAU, TAU);
    let wave = |[x, y, _]: Vec3| (TAU * (x - 0.4 * y)).sin() * (TAU * y).cos();
    let minus_lap = |p: Vec3| {
        let (a, b) = (TAU * (p[0] - 0.4 * p[1]), TAU * p[1]);
        (TAU * TAU + alpha * alpha + beta * beta) * wave(p) + 2.0 * alpha * beta * a.cos() * b.sin()
    };
    let errors: Vec<f64> = [16, 32, 64]
        .map(|n| {
            let kinds = shapes::periodic_kinds([true; 3], PatchKind::Patch);
            let (lo, hi) = ([0.0; 3], [1.0, 1.0, 1.0 / n as f64]);
            let lean = |[x, y, z]: Vec3| [x + 0.4 * y, y, z];
            let m = mesh(&shapes::mapped_box([n, n, 1], lo, hi, kinds, lean));
            let mut phi = unknown(&exec, &m, |_| 0.0, dirichlet(wave));
            diffuse(&m, &mut phi, |p| minus_lap(p) + wave(p), 1.0);
            rms(&m, |c| phi.cells.data[c] - wave(m.cell_centre[c]))
        })
        .to_vec();
    println!("Laplacian, periodic leaning: {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 2.0).abs() < 0.15, "{errors:?}");
}

/// `-lap U` of a cell, by the matrix, the boundary and nothing else; per volume.
fn minus_laplacian(m: &Mesh, u: &mut Unknown<Vec3>) -> Vec<Vec3> {
    let exec = Exec::serial();
    let one = ones(m);
    let mut eqn = Equation::new(&exec, m);
    eqn.assemble(&exec, m, u, &-laplacian(&one)).expect("one term");
    let mut r = vec![[0.0; 3]; m.n_cells];
    eqn.a.residual(&exec, &eqn.b, &mut u.cells.data, &mut r);
    (0..m.n_cells).map(|c| scale(r[c], -1.0 / m.volume[c])).collect()
}

/// `V(r)` about the z axis.
fn swirl(speed: impl Fn(f64) -> f64) -> impl Fn(Vec3) -> Vec3 {
    move |[x, y, _]| {
        let r = x.hypot(y);
        scale(cross([0.0, 0.0, 1.0], unit([x, y, 0.0])), speed(r))
    }
}

/// The wedge of half a degree and a sector of a sixth of the circle.
fn rings(n: usize) -> [(&'static str, PolyMesh); 2] {
    let mut sector = shapes::annular_sector(0.5, 1.0, [n, n, 2], 6);
    sector.points.iter_mut().for_each(|p| p[2] *= 0.2);
    [("wedge", shapes::wedge_ring(0.5, 1.0, 0.2, n, 2, 0.25f64.to_radians())), ("sector", sector)]
}

#[test]
fn laplacian_of_solid_rotation_vanishes_to_rounding() {
    let exec = Exec::serial();
    for (name, poly) in rings(8) {
        let m = mesh(&poly);
        let rigid = swirl(|r| r);
        let mut u = unknown(&exec, &m, &rigid, dirichlet(&rigid));
        let l = minus_laplacian(&m, &mut u);
        // Sizes: U/h^2 with the wedge's thickness for h.
        let e = greatest(&m, |_| true, |c| norm(l[c]));
        println!("{name}: lap of rigid rotation {e:.1e}");
        assert!(e < 1e-7, "{name}: {e:.1e}");
        let mut g = vec![[0.0; 9]; m.n_all()];
        Gradient::GaussLinear.of(&exec, &m, &u, &mut g);
        let turning = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let walls: Vec<usize> = ["inner", "outer"]
            .iter()
            .flat_map(|w| m.patches[m.patch(w).expect("a wall")].faces.clone())
            .map(|f| m.owner[f] as usize)
            .collect();
        let e = greatest(
            &m,
            |c| !walls.contains(&c),
            |c| (0..9).map(|i| (g[c][i] - turning[i]).abs()).fold(0.0, f64::max),
        );
        println!("{name}: gradient of rigid rotation off by {e:.1e}");
        assert!(e > 0.0 && e < if name == "wedge" { 2e-3 } else { 0.02 }, "{name}: {e:.1e}");
    }
}

#[test]
fn swirl_of_a_vortex_between_cylinders() {
    let exec = Exec::serial();
    for k in 0..2 {
        let mut name = "";
        let errors: Vec<f64> = [8, 16, 32]
            .map(|n| {
                let (what, poly) = rings(n)[k].clone();
                name = what;
                let m = mesh(&poly);
                let vortex = swirl(|r| 1.0 / r);
                let condition = |m: &Mesh, p: usize| match m.patches[p].name.as_str() {
                    "inner" | "outer" => dirichlet(&vortex)(m, p),
                    _ => Box::new(ZeroGradient),
                };
                let mut u = unknown(&exec, &m, |_| [0.0; 3], condition);
                let one = ones(&m);
                let mut eqn = Equation::new(&exec, &m);
                solve(&exec, &m, &mut eqn, &mut u, &-laplacian(&one));
                greatest(&m, |_| true, |c| norm(sub(u.cells.data[c], vortex(m.cell_centre[c]))))
            })
            .to_vec();
        println!("vortex in the {name}: {errors:?} {:?}", orders(&errors));
        assert!((orders(&errors)[1] - 2.0).abs() < 0.25, "{name}: {errors:?}");
        assert!(errors[2] < 2e-3, "{name}: {errors:?}");
    }
}

/// A scalar of r and z on the wedge, with the axis: the cylindrical Laplacian.
#[test]
fn scalar_on_the_wedge_down_to_the_axis() {
    let exec = Exec::serial();
    let exact = |[x, y, z]: Vec3| (1.0 - x.hypot(y).powi(2)) * (2.0 * z).cos();
    // lap = -4 cos(2 z) - 4 (1 - r^2) cos(2 z)
    let s = |p: Vec3| 4.0 * (2.0 * p[2]).cos() + 4.0 * exact(p);
    let errors: Vec<f64> = [8, 16, 32]
        .map(|n| {
            let m = mesh(&shapes::wedge_ring(0.0, 1.0, 1.0, n, n, 0.25f64.to_radians()));
            let mut phi = unknown(&exec, &m, |_| 0.0, dirichlet(exact));
            diffuse(&m, &mut phi, s, 0.0);
            rms(&m, |c| phi.cells.data[c] - exact(m.cell_centre[c]))
        })
        .to_vec();
    println!("wedge with axis: {errors:?} {:?}", orders(&errors));
    assert!((orders(&errors)[1] - 2.0).abs() < 0.2, "{errors:?}");
}

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

fn uniform_flux(m: &Mesh, u: Vec3) -> FaceField<f64> {
    let mut flux = FaceField::new(m, "phi", Dims::VOLUME_FLUX, 0.0);
    (0..m.n_faces()).for_each(|f| flux.data[f] = dot(u, m.area[f]));
    flux
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
