//! Shapes carried by known flows, geometric method: shape error, bounds, volume.

#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod vof_common;

use granflow_flow::vof::{GeometricParams, Params, Reconstruct, Shape};
use granflow_mesh::{PatchKind, shapes};
use granflow_par::{Exec, Solo};
use std::f64::consts::PI;
use vof_common::*;

fn by(reconstruction: Reconstruct) -> Params {
    Params::Geometric(GeometricParams { reconstruction, ..GeometricParams::default() })
}

const ALL: [Reconstruct; 3] = [Reconstruct::IsoAlpha, Reconstruct::GradAlpha, Reconstruct::PlicRdf];

fn bench(n: usize) {
    for r in ALL {
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, n, |_| 1.0);
        println!("{}", run.line(&format!("disc, square {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), triangles(n), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, 2 * n, |_| 1.0);
        println!("{}", run.line(&format!("disc, triangle {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), rotation())
            .start(&slotted());
        let exact = run.exact(&slotted());
        run.go(1.0, 8 * n, |_| 1.0);
        println!("{}", run.line(&format!("slotted, square {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), vortex())
            .start(&[(1.0, disc(0.5, 0.75, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.5, 0.75, 0.15))]);
        run.go(8.0, 16 * n, |t| (PI * t / 8.0).cos());
        println!("{}", run.line(&format!("vortex, square {n}, {r:?}"), run.error(&exact)));
    }
}

#[test]
#[ignore = "tables"]
fn tables_2d() {
    for n in [32, 64, 128] {
        bench(n);
    }
}

#[test]
#[ignore = "tables"]
fn tables_3d() {
    for n in [32, 64] {
        for r in ALL {
            let ball = Shape::sphere([0.35; 3], 0.15);
            let mut run = Run::new(Exec::new(2, Box::new(Solo)), shapes::unit_box([n; 3]), &by(r), deformation)
                .start(&[(1.0, ball.clone())]);
            let exact = run.exact(&[(1.0, ball)]);
            run.go(3.0, 12 * n, |t| (PI * t / 3.0).cos());
            println!("{}", run.line(&format!("sphere, {n}, {r:?}"), run.error(&exact)));
        }
    }
}

fn show(e: [f64; 4]) -> String {
    e.map(|x| format!("{x:.2e}")).join(" ")
}

fn normals(poly: &granflow_mesh::PolyMesh, r: Reconstruct, exact: &Shape, centre: [f64; 3], radius: f64) -> [f64; 4] {
    use granflow_base::{add, norm, sub, unit, scale};
    let flat = poly.patches.iter().any(|p| p.kind == PatchKind::Empty);
    let mut run = Run::new(Exec::serial(), poly.clone(), &by(r), uniform([0.0; 3])).start(&[(1.0, exact.clone())]);
    let Run { vof, exec, mesh, alpha, .. } = &mut run;
    let granflow_flow::vof::Vof::Geometric(g) = vof else { unreachable!() };
    g.reconstruct(exec, mesh, &alpha.cells.data);
    let i = g.interface();
    let (mut e, mut n) = ([0.0f64; 4], 0.0);
    for c in 0..mesh.n_cells {
        if i.normal[c] == [0.0; 3] { continue; }
        let x = add(mesh.cell_centre[c], i.offset[c]);
        let mut d = sub(x, centre);
        if flat { d[2] = 0.0; }
        let wrong = norm(sub(unit(d), i.normal[c]));
        let _ = scale;
        e[0] += wrong; e[1] = e[1].max(wrong);
        let away = (norm(d) - radius).abs();
        e[2] += away; e[3] = e[3].max(away);
        n += 1.0;
    }
    e[0] /= n; e[2] /= n;
    e
}

#[test]
#[ignore = "tables"]
fn tables_reconstruction() {
    for r in ALL {
        for n in [16, 32, 64, 128] {
            println!("square {n} {r:?} {}", show(normals(&square(n, PatchKind::Patch), r, &disc(0.511, 0.493, 0.25), [0.511, 0.493, 0.0], 0.25)));
        }
        for n in [16, 32, 64, 128] {
            println!("triangle {n} {r:?} {}", show(normals(&triangles(n), r, &disc(0.511, 0.493, 0.25), [0.511, 0.493, 0.0], 0.25)));
        }
        for n in [16, 32] {
            let c = [0.511, 0.493, 0.507];
            println!("cubes {n} {r:?} {}", show(normals(&shapes::unit_box([n; 3]), r, &Shape::sphere(c, 0.25), c, 0.25)));
            println!("warped {n} {r:?} {}", show(normals(&shapes::displaced(&shapes::unit_box([n; 3]), 0.2, 3), r, &Shape::sphere(c, 0.25), c, 0.25)));
        }
    }
}

#[test]
#[ignore = "tables"]
fn tables_courant() {
    for (snap, clip) in [(1e-12, true), (1e-16, true), (0.0, false)] {
    for r in [Reconstruct::IsoAlpha, Reconstruct::PlicRdf] {
        for n in [64, 128] {
            for k in [16, 32, 64] {
                if k != 16 && !clip { continue; }
                if k != 16 && snap != 1e-12 { continue; }
                let p = Params::Geometric(GeometricParams { reconstruction: r, snap_tol: snap, clip, ..GeometricParams::default() });
                let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &p, vortex())
                    .start(&[(1.0, disc(0.5, 0.75, 0.15))]);
                let exact = run.exact(&[(1.0, disc(0.5, 0.75, 0.15))]);
                run.go(8.0, k * n, |t| (PI * t / 8.0).cos());
                println!("{}", run.line(&format!("vortex {n}, {r:?}, {snap} {clip}"), run.error(&exact)));
                let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &p, uniform([1.0, 0.5, 0.0]))
                    .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
                let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
                run.go(0.5, k * n / 16, |_| 1.0);
                println!("{}", run.line(&format!("disc {n}, {r:?}"), run.error(&exact)));
            }
        }
    }
    }
}

#[test]
#[ignore = "tables"]
fn variants() {
    let r = Reconstruct::PlicRdf;
    for n in [32, 64, 128] {
        println!("square {n} {r:?} {}", show(normals(&square(n, PatchKind::Patch), r, &disc(0.511, 0.493, 0.25), [0.511, 0.493, 0.0], 0.25)));
        println!("triangle {n} {r:?} {}", show(normals(&triangles(n), r, &disc(0.511, 0.493, 0.25), [0.511, 0.493, 0.0], 0.25)));
    }
    for (n, k) in [(64, 16), (64, 64), (128, 16)] {
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), vortex())
            .start(&[(1.0, disc(0.5, 0.75, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.5, 0.75, 0.15))]);
        run.go(8.0, k * n, |t| (PI * t / 8.0).cos());
        println!("{}", run.line(&format!("vortex {n}, {r:?}"), run.error(&exact)));
    }
    for n in [64, 128] {
        let mut run = Run::new(Exec::serial(), square(n, PatchKind::Patch), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, 4 * n, |_| 1.0);
        println!("{}", run.line(&format!("disc {n}, {r:?}"), run.error(&exact)));
        let mut run = Run::new(Exec::serial(), triangles(n), &by(r), uniform([1.0, 0.5, 0.0]))
            .start(&[(1.0, disc(0.25, 0.25, 0.15))]);
        let exact = run.exact(&[(1.0, disc(0.75, 0.5, 0.15))]);
        run.go(0.5, 8 * n, |_| 1.0);
        println!("{}", run.line(&format!("disc, triangle {n}, {r:?}"), run.error(&exact)));
    }
    let n = 32;
    let ball = Shape::sphere([0.35; 3], 0.15);
    let mut run = Run::new(Exec::serial(), shapes::unit_box([n; 3]), &by(r), deformation)
        .start(&[(1.0, ball.clone())]);
    let exact = run.exact(&[(1.0, ball)]);
    run.go(3.0, 12 * n, |t| (PI * t / 3.0).cos());
    println!("{}", run.line(&format!("sphere, {n}, {r:?}"), run.error(&exact)));
}
