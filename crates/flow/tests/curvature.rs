//! Curvature of circles and balls from exact fractions.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_base::Vec3;
use granflow_flow::vof::{Geometric, GeometricParams, Params, Shape};
use granflow_mesh::{PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use vof_common::*;

/// A mesh along x and y sheared and bent smoothly, then its points shaken by a tenth of a cell.
fn bent(n: usize) -> PolyMesh {
    let mut poly = square(n, PatchKind::Patch);
    let pi = std::f64::consts::PI;
    for p in &mut poly.points {
        let [x, y, _] = *p;
        let inside = (x * (1.0 - x) * y * (1.0 - y)).abs() > 1e-9;
        let bump = (pi * x).sin() * (pi * y).sin();
        let shake = |k: f64| ((x * 917.3 + y * 1531.7) * k).sin() * 0.15 / n as f64;
        p[0] = x + 0.06 * bump + if inside { shake(1.0) } else { 0.0 };
        p[1] = y + 0.08 * bump * (2.0 * x - 1.0) + if inside { shake(1.7) } else { 0.0 };
    }
    poly
}

/// Mean square and greatest relative error over the interface's area, over places of the centre.
fn errors(poly: &PolyMesh, radius: f64, ball: bool) -> [f64; 2] {
    let run = Run::new(Exec::serial(), poly.clone(), &Params::Geometric(GeometricParams::default()), |_| [0.0; 3]);
    let mut vof = Geometric::new(&run.exec, poly, &run.mesh, GeometricParams::default()).expect("a method");
    let free = vec![f64::NAN; run.mesh.n_faces()];
    let (mut sum, mut whole, mut most) = (0.0, 0.0, 0.0f64);
    let places = if ball { 3 } else { 10 };
    for i in 0..places {
        let shift = |k: f64| 0.5 + 0.1 * (f64::from(i) * k).fract();
        let x: Vec3 = [shift(0.618), shift(0.414), if ball { shift(0.732) } else { 0.0 }];
        let shape = if ball { Shape::sphere(x, radius) } else { disc(x[0], x[1], radius) };
        let alpha = run.exact(&[(1.0, shape)]);
        let exact = if ball { 2.0 / radius } else { 1.0 / radius };
        let (curvature, area) = vof.curvature(&run.exec, &run.mesh, &alpha, &free);
        for c in 0..run.mesh.n_cells {
            if area[c] > 0.0 {
                let e = (curvature[c] / exact - 1.0).abs();
                sum += area[c] * e * e;
                whole += area[c];
                most = most.max(e);
            }
        }
    }
    [(sum / whole).sqrt(), most]
}

fn show(what: &str, cells: &[usize], error: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
    let all: Vec<[f64; 2]> = cells.iter().map(|&n| error(n)).collect();
    println!("{what:<12} cells a radius {cells:?}: mean {} most {}", short(&all.iter().map(|e| e[0]).collect::<Vec<_>>()), short(&all.iter().map(|e| e[1]).collect::<Vec<_>>()));
    all
}

#[test]
fn circles_and_balls() {
    let cells = [4, 8, 16, 32, 64];
    // The radius is 0.3.
    let n = |k: usize| (k as f64 / 0.3).round() as usize;
    show("squares", &cells, |k| errors(&square(n(k), PatchKind::Patch), k as f64 / n(k) as f64, false));
    show("bent", &cells, |k| errors(&bent(n(k)), k as f64 / n(k) as f64, false));
    show("triangles", &cells, |k| errors(&triangles(n(k)), k as f64 / n(k) as f64, false));
    let cube = |k: usize| shapes::unit_box([n(k); 3]);
    show("cubes", &cells[..3], |k| errors(&cube(k), k as f64 / n(k) as f64, true));
}
