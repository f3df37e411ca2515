//! polyMesh files there and back, and what the check says of broken meshes.
#![allow(clippy::unwrap_used)]

use granflow_dict::{Diags, Format, Source};
use granflow_mesh::check::check;
use granflow_mesh::poly_io::{self, PolyFiles};
use granflow_mesh::{CyclicTransform, PatchKind, PolyMesh, shapes};

fn sources(files: &[(&str, Vec<u8>)]) -> PolyFiles {
    let get = |name: &str| {
        let bytes = files.iter().find(|f| f.0 == name).unwrap().1.clone();
        Source::new(format!("constant/polyMesh/{name}"), bytes)
    };
    PolyFiles {
        points: get("points"),
        faces: get("faces"),
        owner: get("owner"),
        neighbour: get("neighbour"),
        boundary: get("boundary"),
    }
}

#[test]
fn a_mesh_survives_its_files() {
    let mut meshes = vec![
        shapes::displaced(&shapes::periodic_box([3, 2, 2], [true, false, true]), 0.2, 9),
        shapes::prism_box([2, 2, 1], [0.0; 3], [1.0; 3], shapes::all(PatchKind::Wall)),
        shapes::wedge_ring(0.0, 1.0, 1.0, 3, 2, 0.04),
        shapes::tetrahedron(),
    ];
    meshes[1].patches[0].in_groups = vec!["a".into(), "b".into()];
    let transform =
        CyclicTransform::Rotational { axis: [0.0, 0.0, 1.0], origin: [0.1, 0.2, 0.3], angle: None };
    meshes[0].patches[0].kind = PatchKind::Cyclic { neighbour: "xMax".into(), transform };
    let transform = CyclicTransform::Translational([0.0, 0.0, 1.0]);
    meshes[0].patches[4].kind = PatchKind::Cyclic { neighbour: "zMax".into(), transform };
    for mesh in &meshes {
        for format in [Format::Ascii, Format::Binary] {
            let files = poly_io::write(mesh, format);
            assert_eq!(files.iter().map(|f| f.0).collect::<Vec<_>>(), poly_io::FILES);
            let read = poly_io::read(&sources(&files)).map_err(Diags::from);
            let read = read.unwrap_or_else(|d| panic!("{d}"));
            assert_eq!(read.mesh, *mesh);
            assert!(read.warnings.is_empty(), "{}", Diags::from(read.warnings));
        }
    }
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let mesh = shapes::unit_box([2, 1, 1]);
    let mut files = poly_io::write(&mesh, Format::Ascii);
    let other = poly_io::write(&shapes::unit_box([3, 1, 1]), Format::Ascii);
    files[2] = other[2].clone();
    insta::assert_snapshot!(Diags::from(poly_io::read(&sources(&files)).err().unwrap()), @r#"
        error: broken mesh topology: 11 faces but 16 owners
        --> constant/polyMesh/owner
        "#);
    let mut files = poly_io::write(&mesh, Format::Ascii);
    let text = String::from_utf8(files[4].1.clone()).unwrap();
    files[4].1 = text.replacen("patch;", "processor;", 1).into();
    insta::assert_snapshot!(Diags::from(poly_io::read(&sources(&files)).err().unwrap()), @r#"
        error: patches of type `processor` are not supported
          --> constant/polyMesh/boundary:14:25
           |
        14 |         type            processor;
           |                         ^^^^^^^^^ unknown patch type
           |
           = help: this is one part of a decomposed mesh: give the whole mesh, it is cut when the run starts
        "#);
}

#[test]
fn a_good_mesh_is_reported_in_numbers() {
    insta::assert_snapshot!(check(&shapes::unit_box([4, 2, 2])), @r#"
        cells              16 (16 hexahedra)
        faces              68 (28 inner)
        points             45
        extent             (0, 0, 0) to (1, 1, 1) m
        cell volume        0.0625 to 0.0625 m3, together 1 m3
        face area          0.125 to 0.25 m2
        non-orthogonality  at most 0.0, mean 0.0 degrees
        skewness           at most 0.00
        aspect ratio       at most 2.0
        volume ratio       at most 1.00 between neighbours
                           smaller over larger at least 1, mean 1
        face weight        at least 0.5, mean 0.5
        edge length        0.25 to 0.5 m
        flatness           at least 1, mean 1
        determinant        at least 0.0877915, mean 0.0883904
        patch              xMin (patch): 4 faces, 1 m2
        patch              xMax (patch): 4 faces, 1 m2
        patch              yMin (patch): 8 faces, 1 m2
        patch              yMax (patch): 8 faces, 1 m2
        patch              zMin (patch): 8 faces, 1 m2
        patch              zMax (patch): 8 faces, 1 m2
        mesh ok
        "#);
}

fn findings(m: &PolyMesh) -> String {
    let report = check(m);
    assert!(!report.ok());
    report.findings.iter().map(|f| f.to_string()).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_crossed_over_point_is_found() {
    let mut m = shapes::unit_box([2, 2, 2]);
    m.points[13] = [1.6, 1.6, 1.6];
    let text = findings(&m);
    assert!(text.contains("no or negative volume"), "{text}");
}

#[test]
fn a_turned_face_and_a_missing_cell_are_found() {
    let mut m = shapes::unit_box([2, 2, 2]);
    let at = m.face_ptr[3] as usize;
    m.face_points[at..at + 4].reverse();
    insta::assert_snapshot!(findings(&m), @r#"
        error: cells that are not closed, or have faces that turn the wrong way (edges that do not pair up): 2
          cell 1 at (0.75, 0.15625, 0.25): 12
          cell 3 at (0.75, 0.84375, 0.25): 12
          help: the points of a face must turn counter-clockwise seen from the neighbour or from outside
        error: cells with an open surface (sum of area vectors relative to the surface): 2
          cell 1 at (0.75, 0.15625, 0.25): 0.333333
          cell 3 at (0.75, 0.84375, 0.25): 0.333333
          help: faces are missing or turn the wrong way: make the mesh again
        error: faces that do not separate the centres of their cells (angle, degrees): 1
          face 3 between cells 1 and 3 at (0.75, 0.5, 0.25): 180
          help: cells overlap or are badly distorted there: smooth or coarsen the mesh
        error: faces that the centre of a cell lies beyond (depth, m): 1
          face 3 between cells 1 and 3 at (0.75, 0.5, 0.25): -0.34375
          help: the cell is folded or very concave: move its points or coarsen the mesh there
        note: concave cells (how far a face lies beyond another's plane, in distances from the centre): 2
          cell 1 at (0.75, 0.15625, 0.25): 1.45455
          cell 3 at (0.75, 0.84375, 0.25): 1.45455
          help: they do no harm as long as no other finding names them
        "#);
    // A boundary face given to the wrong cell leaves both open.
    let mut m = shapes::unit_box([2, 2, 2]);
    let f = m.patches[0].start;
    m.owner[f] = 7;
    let text = findings(&m);
    assert!(
        text.contains(
            "cells with an open surface (sum of area vectors relative to the surface): 2"
        ),
        "{text}"
    );
}

#[test]
fn skewed_stretched_and_loose_meshes_are_warned_of() {
    let sheared =
        shapes::mapped_box([3, 3, 3], [0.0; 3], [1.0; 3], shapes::all(PatchKind::Wall), |p| {
            [p[0] + 6.0 * p[1], p[1], p[2]]
        });
    let report = check(&sheared);
    assert!(report.ok() && report.findings[0].message.contains("steeply"), "{report}");
    let angle = 6f64.atan().to_degrees();
    assert!((report.quality.max_nonorth_deg - angle).abs() < 1e-9);
    let thin =
        shapes::box_mesh([2, 2, 2], [0.0; 3], [1.0, 1e-4, 1.0], shapes::all(PatchKind::Wall));
    assert!(check(&thin).findings[0].message.contains("elongated"));
    let loose = check(&shapes::two_boxes([2, 2, 2]));
    assert!(loose.ok() && loose.findings[0].message.contains("2 pieces"), "{loose}");
    let mut m = shapes::unit_box([2, 2, 2]);
    m.points.push([5.0; 3]);
    assert!(check(&m).findings[0].message.contains("points that belong to no face: 1"));
    let mut kinds = shapes::all(PatchKind::Wall);
    kinds[4] = PatchKind::Empty;
    let report = check(&shapes::box_mesh([2, 2, 3], [0.0; 3], [1.0; 3], kinds));
    assert!(!report.ok() && report.findings[0].message.contains("empty patches"));
}
