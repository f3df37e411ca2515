//! Initial fractions by exact geometry.

mod vof_common;

use granflow_flow::vof::{Corners, Round, Shape, fill};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use std::f64::consts::PI;
use vof_common::{disc, square, triangles};

fn fractions(poly: &PolyMesh, shape: &Shape) -> (Mesh, Vec<f64>) {
    let mesh = Mesh::new(poly).expect("a sound mesh");
    let corners = Corners::new(poly, &mesh);
    let mut alpha = vec![0.0; mesh.n_all()];
    fill(&Exec::serial(), &mesh, &corners, shape, &mut alpha);
    (mesh, alpha)
}

fn volume(poly: &PolyMesh, shape: &Shape) -> f64 {
    let (mesh, alpha) = fractions(poly, shape);
    assert!(alpha.iter().all(|a| (0.0..=1.0).contains(a)));
    (0..mesh.n_cells).map(|c| mesh.volume[c] * alpha[c]).sum()
}

#[test]
fn volumes_add_up() {
    let kinds = || shapes::all(PatchKind::Patch);
    let prisms = shapes::prism_box([5, 6, 4], [0.0; 3], [1.0; 3], kinds());
    let ball = Shape::sphere([0.48, 0.51, 0.53], 0.31);
    let tilted = Shape::cylinder([0.5; 3], [1.0, 2.0, -0.5], 0.2);
    let capped = Shape {
        half_spaces: vec![
            ([1.0, 2.0, -0.5], [0.6, 0.7, 0.45]),
            ([-1.0, -2.0, 0.5], [0.4, 0.3, 0.55]),
        ],
        ..tilted.clone()
    };
    // The distance of the two caps along the axis.
    let height = (0.2 + 0.8 + 0.05) / 5.25f64.sqrt();
    for poly in [prisms, shapes::unit_box([7, 5, 6]), shapes::unit_box([1, 1, 1])] {
        assert!((volume(&poly, &ball) - 4.0 / 3.0 * PI * 0.31f64.powi(3)).abs() < 1e-13);
        assert!((volume(&poly, &capped) - PI * 0.04 * height).abs() < 1e-13);
        let plane = Shape::half_space([1.0, 1.0, 1.0], [0.5; 3]);
        assert!((volume(&poly, &plane) - 0.5).abs() < 1e-14);
        let cuboid = Shape::cuboid([0.11, 0.2, 0.33], [0.9, 0.75, 0.71]);
        assert!((volume(&poly, &cuboid) - 0.79 * 0.55 * 0.38).abs() < 1e-14);
    }
    for poly in [square(12, PatchKind::Patch), triangles(12)] {
        let depth = poly.points.iter().map(|p| p[2]).fold(0.0, f64::max);
        let v = volume(&poly, &disc(0.4, 0.45, 0.3)) / depth;
        assert!((v - PI * 0.09).abs() < 1e-13, "{v}");
    }
    assert!(matches!(ball.round, Some(Round::Sphere { .. })));
}

/// A coarse cell holds what its eight children hold: no cell is wrong while the sum is right.
#[test]
fn cells_hold_what_their_children_hold() {
    for shape in [
        Shape::sphere([0.3, 0.62, 0.45], 0.37),
        Shape::cylinder([0.3, 0.6, 0.0], [0.3, -0.2, 1.0], 0.33),
        Shape::sphere([0.3, 0.62, 0.45], 0.37).and(&Shape::cuboid([0.2; 3], [0.8, 0.55, 0.9])),
    ] {
        let (n, m) = (6, 12);
        let (_, coarse) = fractions(&shapes::unit_box([n; 3]), &shape);
        let (_, fine) = fractions(&shapes::unit_box([m; 3]), &shape);
        let mut sums = vec![0.0; n * n * n];
        for (c, a) in fine.iter().enumerate() {
            let [i, j, k] = [c % m / 2, c / m % m / 2, c / (m * m) / 2];
            sums[(k * n + j) * n + i] += a / 8.0;
        }
        for (a, b) in coarse.iter().zip(&sums) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }
}

/// Warped cells, whose facets are triangles about the middle of their faces: the sum is exact.
#[test]
fn warped_cells_leave_no_gaps() {
    let poly = shapes::displaced(&shapes::unit_box([6; 3]), 0.2, 11);
    let mesh = Mesh::new(&poly).expect("a sound mesh");
    let corners = Corners::new(&poly, &mesh);
    let shape = Shape::sphere([0.5; 3], 0.3);
    let mut body = granflow_flow::vof::Body::default();
    let (mut inside, mut all) = (0.0, 0.0);
    for c in 0..mesh.n_cells {
        body.load(&corners, &mesh, c);
        all += body.volume();
        assert!((body.volume() / mesh.volume[c] - 1.0).abs() < 0.05);
        inside += shape.volume_in(&mut body);
    }
    assert!((all - 1.0).abs() < 1e-13);
    assert!((inside - 4.0 / 3.0 * PI * 0.027).abs() < 1e-13);
}
