//! Curvature of circles and balls from exact fractions.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_base::Vec3;
use granflow_flow::vof::{Corners, Geometric, GeometricParams, Params, Shape, fill};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, decompose, partition, shapes};
use granflow_par::{Exec, InProcess};
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

/// A cap that meets the wall below at an angle whose cosine is 1/3, and is told `cosine`: curvature of
/// its cells at the wall over the exact one, least and greatest.
fn at_the_wall(cosine: f64) -> [f64; 2] {
    let (n, radius) = (54, 0.3);
    let poly = square(n, PatchKind::Patch);
    let params = GeometricParams::default();
    let run = Run::new(Exec::serial(), poly, &Params::Geometric(params.clone()), |_| [0.0; 3]);
    let mut vof = Geometric::new(&run.exec, &run.poly, &run.mesh, params).expect("a method");
    let alpha = run.exact(&[(1.0, disc(0.507, -0.1, radius))]);
    let angles: Vec<f64> = (run.mesh.n_inner..run.mesh.n_faces())
        .map(|f| if run.mesh.normal(f)[1] < -0.5 { cosine } else { f64::NAN })
        .collect();
    let (curvature, area) = vof.curvature(&run.exec, &run.mesh, &alpha, &angles);
    let low = |c: &usize| area[*c] > 0.0 && run.mesh.cell_centre[*c][1] < 1.0 / n as f64;
    let all = (0..run.mesh.n_cells).filter(low).map(|c| curvature[c] * radius);
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], k| [a.min(k), b.max(k)])
}

#[test]
fn walls_bend_the_interface_that_meets_them() {
    let right = at_the_wall(1.0 / 3.0);
    let [repelled, drawn] = [0.2, 0.5].map(at_the_wall);
    println!("right {right:?}, repelled {repelled:?}, drawn {drawn:?}");
    assert!(right[0] > 0.99 && right[1] < 1.01, "{right:?}");
    // A wall that the fluid likes less than its cap shows pushes it off: more pressure at the wall.
    assert!(repelled[0] > 1.2 && drawn[1] < 0.8, "{repelled:?} {drawn:?}");
}

/// Curvature of a ball in the cells of the whole mesh, from several ranks.
fn on_ranks(poly: &PolyMesh, part: &[u32]) -> Vec<f64> {
    let meshes = decompose(poly, part).expect("parts");
    let one = |comm: InProcess, mesh: &Mesh| {
        let exec = Exec::new(1, Box::new(comm));
        let mut vof =
            Geometric::new(&exec, poly, mesh, GeometricParams::default()).expect("a method");
        let mut alpha = vec![0.0; mesh.n_all()];
        let shape = Shape::sphere([0.15, 0.4, 0.45], 0.3);
        fill(&exec, mesh, &Corners::new(poly, mesh), &shape, &mut alpha);
        let angles = vec![0.0; mesh.n_faces()];
        let curvature = vof.curvature(&exec, mesh, &alpha, &angles).0;
        mesh.global_cell.iter().copied().zip(curvature.iter().copied()).collect::<Vec<_>>()
    };
    let parts: Vec<_> = std::thread::scope(|s| {
        let one = &one;
        let ranks: Vec<_> = InProcess::world(meshes.len())
            .into_iter()
            .zip(&meshes)
            .map(|(comm, mesh)| s.spawn(move || one(comm, mesh)))
            .collect();
        ranks.into_iter().map(|r| r.join().expect("a rank")).collect()
    });
    let mut whole = vec![f64::NAN; part.len()];
    parts.iter().flatten().for_each(|(c, k)| whole[*c as usize] = *k);
    whole
}

#[test]
fn ranks_agree_with_one() {
    let poly = shapes::displaced(&shapes::periodic_box([10; 3], [true, false, true]), 0.15, 1);
    let serial = on_ranks(&poly, &vec![0; 1000]);
    let size = serial.iter().map(|k| k.abs()).fold(0.0, f64::max);
    assert!(size > 2.0, "a ball is curved: {size}");
    for ranks in [2, 3, 5] {
        let parallel = on_ranks(&poly, &partition(&poly, ranks));
        let differ = serial.iter().zip(&parallel).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{ranks} ranks: {differ:e} of {size}");
        assert!(differ < 1e-7 * size, "{ranks} ranks: {differ}");
    }
}
