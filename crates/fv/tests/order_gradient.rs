//! Order of accuracy of gradients and divergence by manufactured solutions (P. J. Roache, J. Fluids
//! Eng. 124 (2002) 4), on regular and on bad meshes.

#![allow(
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::type_complexity,
    reason = "tests print what they measured, loops name their faces"
)]

mod common;

use common::manufactured::*;
use common::*;
use granflow_base::{Dims, Tensor, Vec3, dot, norm, sub};
use granflow_fv::{Differentiable, FaceField, Gradient, LeastSquares, operators};
use granflow_mesh::{Mesh, PatchKind, shapes};
use granflow_par::Exec;
use std::f64::consts::TAU;

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
