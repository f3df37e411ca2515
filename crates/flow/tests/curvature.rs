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
    let run = Run::new(
        Exec::serial(),
        poly.clone(),
        &Params::Geometric(GeometricParams::default()),
        |_| [0.0; 3],
    );
    let mut vof =
        Geometric::new(&run.exec, poly, &run.mesh, GeometricParams::default()).expect("a method");
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

/// Errors for several numbers of cells a radius, printed.
fn table(
    what: &str,
    cells: &[usize],
    ball: bool,
    mesh: impl Fn(usize) -> PolyMesh,
) -> Vec<[f64; 2]> {
    let one = |&k: &usize| {
        // The radius is about 0.3.
        let n = (k as f64 / 0.3).round() as usize;
        errors(&mesh(n), k as f64 / n as f64, ball)
    };
    let all: Vec<[f64; 2]> = cells.iter().map(one).collect();
    let column = |i: usize| short(&all.iter().map(|e| e[i]).collect::<Vec<_>>());
    println!("{what:<10} {cells:?} cells a radius: mean {}, most {}", column(0), column(1));
    all
}

#[test]
fn circles_and_balls() {
    let cells = [4, 8, 16, 32];
    let squares = table("squares", &cells, false, |n| square(n, PatchKind::Patch));
    let bent = table("bent", &cells, false, bent);
    let triangles = table("triangles", &cells, false, triangles);
    let cubes = table("cubes", &cells[..3], true, |n| shapes::unit_box([n; 3]));
    for (all, limits) in [
        (&squares, [6e-3, 1.2e-3, 6e-4, 2.5e-4]),
        (&bent, [7e-3, 1.6e-3, 8e-4, 3e-4]),
        (&triangles, [5e-3, 1e-3, 1.2e-3, 1.5e-3]),
    ] {
        assert!(all.iter().zip(limits).all(|(e, limit)| e[0] < limit), "{all:?}");
    }
    assert!(cubes.iter().zip([1.2e-2, 2.2e-3, 6e-4]).all(|(e, limit)| e[0] < limit), "{cubes:?}");
}

#[test]
fn an_ellipse_is_curved_more_at_its_tips() {
    // Of x^2/a^2 + y^2/b^2 = 1: K = a b/(a^2 sin^2 + b^2 cos^2)^1.5. The map stretches a disc's mesh.
    let (n, radius, stretch) = (54, 0.3, 1.5);
    let mut poly = square(n, PatchKind::Patch);
    poly.points.iter_mut().for_each(|p| p[0] *= stretch);
    let params = GeometricParams::default();
    let run =
        Run::new(Exec::serial(), poly.clone(), &Params::Geometric(params.clone()), |_| [0.0; 3]);
    let unit = Run::new(
        Exec::serial(),
        square(n, PatchKind::Patch),
        &Params::Geometric(params.clone()),
        |_| [0.0; 3],
    );
    let alpha = unit.exact(&[(1.0, disc(0.5, 0.5, radius))]);
    let mut vof = Geometric::new(&run.exec, &poly, &run.mesh, params).expect("a method");
    let free = vec![f64::NAN; run.mesh.n_faces()];
    let (curvature, area) = vof.curvature(&run.exec, &run.mesh, &alpha, &free);
    let (a, b) = (stretch * radius, radius);
    let mut most = 0.0f64;
    for c in (0..run.mesh.n_cells).filter(|&c| area[c] > 0.0) {
        let x = run.mesh.cell_centre[c];
        let t = ((x[1] - 0.5) / b).atan2((x[0] - 0.5 * stretch) / a);
        let exact = a * b / ((a * t.sin()).powi(2) + (b * t.cos()).powi(2)).powf(1.5);
        most = most.max((curvature[c] / exact - 1.0).abs());
    }
    println!("ellipse: greatest error {most:e}");
    assert!(most < 0.03, "{most}");
}
