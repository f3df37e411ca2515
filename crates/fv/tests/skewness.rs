//! Faces whose centre is not where the line between the cells pierces them: what interpolation
//! lacks there, operator by operator, on cells displaced at random, where it does not fade.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod common;

use common::*;
use granflow_base::{Dims, Tensor, Vec3, dot, norm, sub};
use granflow_fv::{
    Condition, Convection, Differentiable, FaceField, Gradient, LeastSquares, Unknown, operators,
};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;

/// Numbers in -1..1 that depend on `i` and `j` alone.
fn noise(i: f64, j: f64) -> f64 {
    let x = (12.9898 * i + 78.233 * j).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// The unit square, points off the boundary moved at random by a fifth of a cell, then all of
/// them leaned over, so that boundary faces lean too. In the plane no face is warped.
fn plane(n: usize) -> Mesh {
    let mut kinds = shapes::all(PatchKind::Patch);
    (kinds[4], kinds[5]) = (PatchKind::Empty, PatchKind::Empty);
    let (h, last) = (1.0 / n as f64, n as f64);
    let map = |[x, y, z]: Vec3| {
        let (i, j) = ((x / h).round(), (y / h).round());
        let edge = i == 0.0 || j == 0.0 || i == last || j == last;
        let k = if edge { 0.0 } else { 0.2 * h };
        let (x, y) = (x + k * noise(i, j), y + k * noise(j + 0.5, i));
        [x + 0.3 * y, y, z]
    };
    mesh(&shapes::mapped_box([n, n, 1], [0.0; 3], [1.0, 1.0, h], kinds, map))
}

/// A box of displaced cells in space, with warped faces.
fn space(n: usize) -> Mesh {
    mesh(&displaced(n))
}

fn displaced(n: usize) -> PolyMesh {
    shapes::displaced(&shapes::unit_box([n; 3]), 0.2, 7)
}

fn f([x, y, _]: Vec3) -> f64 {
    (2.0 * x + 0.3).sin() * (1.5 * y).cos()
}
fn grad_f([x, y, _]: Vec3) -> Vec3 {
    let (a, b) = (2.0 * x + 0.3, 1.5 * y);
    [2.0 * a.cos() * b.cos(), -1.5 * a.sin() * b.sin(), 0.0]
}
fn v(p: Vec3) -> Vec3 {
    [f(p), f([p[1], p[0], p[2]]), 0.0]
}
fn div_v(p: Vec3) -> f64 {
    grad_f(p)[0] + grad_f([p[1], p[0], p[2]])[0]
}

fn of<T: Differentiable>(m: &Mesh, gradient: &Gradient, phi: &Unknown<T>) -> Vec<T::Gradient> {
    let mut g = vec![<T::Gradient as granflow_base::Value>::ZERO; m.n_all()];
    gradient.of(&Exec::serial(), m, phi, &mut g);
    g
}

/// The same mesh, taken for one without skewness.
fn taken_for_straight(mut m: Mesh) -> Mesh {
    (m.max_skew, m.max_nonorth_deg) = (0.0, 0.0);
    m
}

/// Errors on three meshes, with the correction and without: of order `least` at least, and of
/// `most` at most where nothing is corrected, so that the test can fail.
fn corrected_orders(
    what: &str,
    n: [usize; 3],
    (least, most): (f64, f64),
    error: impl Fn(usize, bool) -> f64,
) {
    let [with, without] = [true, false].map(|corrected| n.map(|n| error(n, corrected)));
    println!("{what}: {with:?} {:?}", orders(&with));
    println!("uncorrected: {without:?} {:?}", orders(&without));
    assert!(orders(&with)[1] > least, "{what}: {with:?}");
    assert!(orders(&without)[1] < most, "the test can fail, {what}: {without:?}");
}

#[test]
fn only_skewed_meshes_are_taken_for_skewed() {
    assert!(plane(6).is_skewed() && space(6).is_skewed());
    assert!(!mesh(&leaning([5; 3])).is_skewed(), "leaning cells are not skewed");
    let wedge = shapes::wedge_ring(0.0, 1.0, 1.0, 8, 8, 0.25f64.to_radians());
    assert!(!mesh(&wedge).is_skewed(), "the images behind a wedge's faces do not count");
}

/// Both gradients, values given on two sides and normal gradients on the others.
#[test]
fn gradients_are_exact_for_linear_fields() {
    let exec = Exec::serial();
    let line = |p: Vec3| 4.0 + 2.0 * p[0] - 3.0 * p[1];
    let k: Tensor = [1.0, -2.0, 0.5, 3.0, 0.25, -1.0, 0.0, 0.0, 0.0];
    let vector = |p: Vec3| Vec3::along(k, p);
    let sides = |m: &Mesh, p: usize| -> Box<dyn Condition<f64>> {
        match m.patches[p].name.as_str() {
            "xMin" | "yMax" => dirichlet(line)(m, p),
            _ => neumann(|_| [2.0, -3.0, 0.0])(m, p),
        }
    };
    for (name, m) in [("plane", plane(7)), ("leaning", mesh(&leaning([5; 3]))), ("space", space(5))]
    {
        for gradient in [Gradient::GaussLinear, Gradient::LeastSquares(LeastSquares::new(&m))] {
            let g = of(&m, &gradient, &unknown(&exec, &m, line, sides));
            let e = greatest(&m, |_| true, |c| norm(sub(g[c], [2.0, -3.0, 0.0])));
            let g = of(&m, &gradient, &unknown(&exec, &m, vector, dirichlet(vector)));
            let worst = |c: usize| (0..9).map(|i| (g[c][i] - k[i]).abs()).fold(0.0, f64::max);
            let e_v = greatest(&m, |_| true, worst);
            assert!(e < 1e-11 && e_v < 1e-11, "{name}: {e:.1e} {e_v:.1e}");
        }
    }
}

#[test]
fn gauss_gradient_is_first_order() {
    for (name, on) in [("plane", plane as fn(usize) -> Mesh), ("space", space)] {
        let n = if name == "plane" { [16, 32, 64] } else { [6, 12, 24] };
        corrected_orders(&format!("Gauss gradient, {name}"), n, (0.9, 0.3), |n, corrected| {
            let m = if corrected { on(n) } else { taken_for_straight(on(n)) };
            let phi = unknown(&Exec::serial(), &m, f, dirichlet(f));
            let g = of(&m, &Gradient::GaussLinear, &phi);
            rms(&m, |c| norm(sub(g[c], grad_f(m.cell_centre[c]))))
        });
    }
}

/// The divergence of an interpolated velocity: of order zero without the correction.
#[test]
fn divergence_of_an_interpolated_velocity_is_first_order() {
    let exec = Exec::serial();
    for least_squares in [false, true] {
        corrected_orders("divergence", [16, 32, 64], (0.9, 0.3), |n, corrected| {
            let m = plane(n);
            let gradient = match least_squares {
                true => Gradient::LeastSquares(LeastSquares::new(&m)),
                false => Gradient::GaussLinear,
            };
            let u = unknown(&exec, &m, v, dirichlet(v));
            let mut flux = FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0);
            operators::flux(&exec, &m, &u, &u.cells.data, &mut flux);
            if corrected {
                let g = of(&m, &gradient, &u);
                operators::add_skew_flux(&exec, &m, 1.0, &g, &mut flux);
            }
            let mut d = vec![0.0; m.n_cells];
            operators::divergence(&exec, &m, &flux, &mut d);
            rms(&m, |c| d[c] - div_v(m.cell_centre[c]))
        });
    }
}

/// What central differences carry through a face, at the centre of the face.
#[test]
fn central_differences_are_second_order_on_faces() {
    let exec = Exec::serial();
    corrected_orders("central differences", [16, 32, 64], (1.85, 1.3), |n, corrected| {
        let m = if corrected { plane(n) } else { taken_for_straight(plane(n)) };
        let phi = unknown(&exec, &m, f, dirichlet(f));
        let g = of(&m, &Gradient::LeastSquares(LeastSquares::new(&m)), &phi);
        let mut flux = FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0);
        (0..m.n_faces()).for_each(|f| flux.data[f] = dot([1.0, 0.7, 0.0], m.area[f]));
        let mut w = FaceField::new(&m, "w", Dims::NONE, 0.0);
        let mut c = FaceField::new(&m, "c", Dims::VOLUME_FLUX, 0.0);
        let scheme = Convection::Linear;
        assert_eq!(scheme.corrects(&m), corrected);
        scheme.weigh(&exec, &m, &phi, &g, &flux.data, &mut w, &mut c);
        let x = &phi.cells.data;
        let off = |i: usize| {
            let (o, n) = (x[m.owner[i] as usize], x[m.neighbour[i] as usize]);
            let carried = flux.data[i] * (w.data[i] * o + (1.0 - w.data[i]) * n) + c.data[i];
            carried / flux.data[i] - f(m.face_centre[i])
        };
        let sum: f64 = (0..m.n_inner).map(|i| off(i).powi(2)).sum();
        (sum / m.n_inner as f64).sqrt()
    });
}
