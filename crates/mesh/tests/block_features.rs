//! What `blockMeshDict` can say beyond blocks, arcs and patches: B-splines, names, zones, patches
//! that are merged, projections that are refused.
#![allow(clippy::unwrap_used)]

use granflow_dict::{Diags, NoFiles, Source, parse};
use granflow_mesh::check::check;
use granflow_mesh::{Geometry, Mesh, PolyMesh, block};

fn generate(text: &str) -> Result<PolyMesh, Diags> {
    let (dict, found) = parse(Source::new("system/blockMeshDict", text), &mut NoFiles);
    assert!(found.is_empty(), "{}", Diags::from(found));
    block::read(&dict).and_then(|b| b.generate()).map_err(Diags::from)
}

fn message(text: &str) -> String {
    generate(text).err().map_or("no error".into(), |d| d.to_string())
}

const CUBE: &str = "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));\n";

/// Vertices and blocks by name, a zone, a side by its block: numbers of points on the curved edges
/// as OpenFOAM v1912's blockMesh wrote them.
#[test]
fn names_zones_and_b_splines_are_the_reference_tools() {
    let m = generate(
        "scale 2;
        vertices ( name a (0 0 0) (1 0 0) (1 1 0) name d (0 1 0) (0 0 1)(1 0 1)(1 1 1)(0 1 1) );
        blocks ( name one hex (a 1 2 d 4 5 6 7) core (4 3 2) simpleGrading (3 1 1) );
        edges (
            BSpline a 1 ((0.25 0.1 0) (0.5 0.3 0) (0.8 0.1 0))
            spline 4 5 ((0.25 0.1 1) (0.5 0.3 1) (0.8 0.1 1))
        );
        boundary (
            left { type wall; faces ((a 4 7 d)); }
            right { type patch; faces ((one 1)); }
        );
        defaultPatch { name rest; type symmetry; }",
    )
    .unwrap();
    let expected = [
        (1, [0.2897075294395258, 0.1223670875282183, 0.0]),
        (2, [0.6752529957014477, 0.3431558478735997, 0.0]),
        (3, [1.197322944889301, 0.4307424105180192, 0.0]),
        (21, [0.2897075294395258, 0.1120650727578354, 1.0]),
    ];
    for (p, x) in expected {
        let off = (0..3).map(|k| (m.points[p][k] - x[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-14, "point {p}: {:?}", m.points[p]);
    }
    assert_eq!((m.cell_zones[0].name.as_str(), m.cell_zones[0].cells.len()), ("core", 24));
    let patches: Vec<_> = m.patches.iter().map(|p| (p.name.as_str(), p.start, p.len)).collect();
    assert_eq!(patches, [("left", 46, 6), ("right", 52, 6), ("rest", 58, 40)]);
}

#[test]
fn blocks_of_one_zone_name_make_one_zone() {
    let m = generate(
        "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1)(2 0 0)(2 1 0)(2 0 1)(2 1 1)
                   (3 0 0)(3 1 0)(3 0 1)(3 1 1));
        blocks (
            hex (0 1 2 3 4 5 6 7) a (2 1 1) simpleGrading (1 1 1)
            hex (1 8 9 2 5 10 11 6) b (3 1 1) simpleGrading (1 1 1)
            hex (8 12 13 9 10 14 15 11) a (1 1 1) simpleGrading (1 1 1)
        );
        defaultPatch { name walls; type wall; }",
    )
    .unwrap();
    let zones: Vec<_> = m.cell_zones.iter().map(|z| (z.name.as_str(), z.cells.clone())).collect();
    assert_eq!(zones, [("a", vec![0, 1, 5]), ("b", vec![2, 3, 4])]);
    let files = granflow_mesh::poly_io::write(&m, granflow_dict::Format::Binary);
    let text = String::from_utf8(files[5].1.clone()).unwrap();
    assert_eq!(files[5].0, "cellZones");
    let words: Vec<&str> = text.split_whitespace().collect();
    assert!(words.windows(2).any(|w| w == ["class", "regIOobject;"]), "{text}");
    assert!(text.contains("List<label>\n3\n(\n0\n1\n5\n"), "{text}");
}

/// Two unit cubes whose sides meet with `a` and `b` cells across.
fn two_cubes(a: &str, b: &str, merge: &str) -> String {
    format!(
        "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1)
                   (1 0 0)(2 0 0)(2 1 0)(1 1 0)(1 0 1)(2 0 1)(2 1 1)(1 1 1));
        blocks (
            hex (0 1 2 3 4 5 6 7) ({a}) simpleGrading (1 1 1)
            hex (8 9 10 11 12 13 14 15) ({b}) simpleGrading (1 1 1)
        );
        boundary (
            m {{ type patch; faces ((1 2 6 5)); }}
            s {{ type patch; faces ((8 12 15 11)); }}
            rest {{ type wall; faces ((0 4 7 3)(9 10 14 13)(0 1 5 4)(3 7 6 2)(0 3 2 1)(4 5 6 7)
                                      (8 9 13 12)(11 15 14 10)(8 11 10 9)(12 13 14 15)); }}
        );
        {merge}"
    )
}

/// Counted by hand: where 2 x 3 and 3 x 2 faces meet, 4 x 4 parts; compared with OpenFOAM v1912's
/// tool as well (`cargo xtask compareMeshes`).
#[test]
fn merged_patches_are_cut_by_one_another() {
    let m = generate(&two_cubes("2 2 3", "2 3 2", "mergePatchPairs ((m s));")).unwrap();
    // Inner faces of the blocks: 6 + 6 + 8 and 6 + 8 + 6; parts of the interface: 4 x 4.
    assert_eq!((m.n_cells(), m.n_inner()), (24, 20 + 20 + 16));
    // Points: 36 and 36, less the 4 shared corners; those on edges and inside: crossings of one line
    // of each family with two of the other, 1 x 1 + 2 x 2.
    assert_eq!(m.points.len(), 36 + 36 - 4 + 5);
    let names: Vec<_> = m.patches.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["rest"], "merged patches without faces are left out");
    let report = check(&m);
    assert!(report.ok(), "{report}");
    assert!((report.quality.total_volume - 2.0).abs() < 1e-14);
    assert!(report.quality.max_openness < 1e-15);
    Mesh::new(&m).unwrap();
    // The interface is whole.
    let g = Geometry::new(&m);
    let across =
        |f: &usize| (g.face_centre[*f][0] - 1.0).abs() < 1e-12 && g.area[*f][0].abs() > 0.0;
    let area: f64 = (0..m.n_inner()).filter(across).map(|f| g.area[f][0].abs()).sum();
    assert!((area - 1.0).abs() < 1e-14, "{area}");
}

#[test]
fn faces_that_match_merge_one_to_one_and_keep_what_is_outside() {
    // The second block is half as wide.
    let text = two_cubes("2 2 2", "2 1 2", "mergePatchPairs ((m s));")
        .replace("(2 1 0)(1 1 0)", "(2 0.5 0)(1 0.5 0)")
        .replace("(2 1 1)(1 1 1));", "(2 0.5 1)(1 0.5 1));");
    let m = generate(&text).unwrap();
    assert_eq!((m.n_cells(), m.n_inner()), (12, 12 + 4 + 2));
    let patches: Vec<_> = m.patches.iter().map(|p| (p.name.as_str(), p.len)).collect();
    assert_eq!(patches[0], ("m", 2));
    assert!(check(&m).ok());
}

#[test]
fn patches_that_do_not_fit_are_named() {
    let text = two_cubes("2 2 2", "2 1 2", "\nmergePatchPairs ((m s));")
        .replace("(2 1 0)(1 1 0)", "(2 0.7 0)(1 0.7 0)")
        .replace("(2 1 1)(1 1 1));", "(2 0.7 1)(1 0.7 1));");
    insta::assert_snapshot!(message(&text), @r#"
        error: the patches `m` and `s` do not fit each other
          --> system/blockMeshDict:14:18
           |
        14 | mergePatchPairs ((m s));
           |                  ^^^^^ 40.0 % of the face at (1, 0.75, 0.25) is covered
           |
           = help: let faces begin and end where the smaller patch does: every face must be covered as a whole or not at all
        "#);
    insta::assert_snapshot!(
        message(&two_cubes("2 2 2", "2 1 2", "\nmergePatchPairs ((m slave)(m rest));")),
        @r#"
        error: there is no patch `slave` to merge
          --> system/blockMeshDict:14:21
           |
        14 | mergePatchPairs ((m slave)(m rest));
           |                     ^^^^^ not in `boundary`
        "#
    );
}

#[test]
fn projections_are_refused_one_by_one() {
    let text = format!(
        "geometry {{ ball {{ type searchableSphere; centre (0 0 0); radius 1; }} }}
{}
blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));
edges (project 0 1 (ball) arc 1 2 (1.1 0.5 0) project 2 3 (ball));
faces (project (0 4 7 3) ball);",
        CUBE.trim().replace("(1 0 0)", "project (1 0 0) (ball)")
    );
    insta::assert_snapshot!(message(&text), @r#"
        error: vertices of type `project` are not supported
         --> system/blockMeshDict:2:18
          |
        2 | vertices ((0 0 0)project (1 0 0) (ball)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));
          |                  ^^^^^^^^^^^^^^^^^^^^^^ this vertex
          |
          = help: projection onto surfaces is not supported: use arc, polyLine, spline or BSpline edges, or import the mesh (`granflow mesh --from FILE`)

        error: edges of type `project` are not supported
         --> system/blockMeshDict:4:8
          |
        4 | edges (project 0 1 (ball) arc 1 2 (1.1 0.5 0) project 2 3 (ball));
          |        ^^^^^^^^^^^^^^^^^^ this edge
          |
          = help: projection onto surfaces is not supported: use arc, polyLine, spline or BSpline edges, or import the mesh (`granflow mesh --from FILE`)

        error: edges of type `project` are not supported
         --> system/blockMeshDict:4:47
          |
        4 | edges (project 0 1 (ball) arc 1 2 (1.1 0.5 0) project 2 3 (ball));
          |                                               ^^^^^^^^^^^^^^^^^^ this edge
          |
          = help: projection onto surfaces is not supported: use arc, polyLine, spline or BSpline edges, or import the mesh (`granflow mesh --from FILE`)

        error: faces of type `project` are not supported
         --> system/blockMeshDict:5:8
          |
        5 | faces (project (0 4 7 3) ball);
          |        ^^^^^^^^^^^^^^^^^^^^^^ this face
          |
          = help: projection onto surfaces is not supported: use arc, polyLine, spline or BSpline edges, or import the mesh (`granflow mesh --from FILE`)
        "#);
    // Surfaces that nothing is projected onto do no harm.
    let harmless = format!(
        "geometry {{ ball {{ type searchableSphere; centre (0 0 0); radius 1; }} }}
        {CUBE} blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));
        defaultPatch {{ name walls; type wall; }}"
    );
    assert_eq!(generate(&harmless).unwrap().n_cells(), 8);
}

#[test]
fn unknown_names_are_reported_with_the_nearest() {
    let text = "vertices ( name left (0 0 0) (1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));
blocks (hex (lefd 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));";
    insta::assert_snapshot!(message(text), @r#"
        error: expected the block's vertices, vertex numbers in parentheses
         --> system/blockMeshDict:2:13
          |
        2 | blocks (hex (lefd 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));
          |             ^^^^^^^^^^^^^^^^^^^^ not a list of vertices
          |
          = help: no vertex is called `lefd`; did you mean `left`?
        "#);
}
