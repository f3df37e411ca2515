//! blockMeshDict: what comes out, and what is said about mistakes.
#![allow(clippy::unwrap_used)]

use granflow_dict::{Diags, NoFiles, Source, parse};
use granflow_mesh::{Geometry, Mesh, PatchKind, PolyMesh, block, check};

fn read(text: &str) -> Result<block::BlockMesh, Diags> {
    let (dict, found) = parse(Source::new("system/blockMeshDict", text), &mut NoFiles);
    assert!(found.is_empty(), "{}", Diags::from(found));
    block::read(&dict).map_err(Diags::from)
}

fn generate(text: &str) -> Result<PolyMesh, Diags> {
    read(text)?.generate().map_err(Diags::from)
}

fn message(text: &str) -> String {
    match generate(text) {
        Ok(_) => "no error".into(),
        Err(d) => d.to_string(),
    }
}

const CUBE: &str = "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));\n";

#[test]
fn one_block_in_blockmesh_order() {
    let text = "scale 0.1; vertices ((0 0 0)(2 0 0)(2 1 0)(0 1 0)(0 0 1)(2 0 1)(2 1 1)(0 1 1));
        blocks (hex (0 1 2 3 4 5 6 7) (2 2 1) simpleGrading (3 1 1)); edges ();
        boundary (
            lid { type wall; faces ((3 7 6 2)); }
            walls { type wall; inGroups (solid); faces ((0 4 7 3) (2 6 5 1) (1 5 4 0)); }
            frontAndBack { type empty; faces ((0 3 2 1) (4 5 6 7)); }
        );";
    let m = generate(text).unwrap();
    assert_eq!((m.n_cells(), m.points.len(), m.n_inner(), m.n_faces()), (4, 18, 4, 20));
    assert_eq!(m.owner[..4], [0, 0, 1, 2]);
    assert_eq!(m.neighbour, [1, 2, 3, 3]);
    assert_eq!(m.face(0), [1, 4, 13, 10]);
    assert!((m.points[1][0] - 0.05).abs() < 1e-15);
    let patches: Vec<_> = m.patches.iter().map(|p| (p.name.as_str(), p.start, p.len)).collect();
    assert_eq!(patches, [("lid", 4, 2), ("walls", 6, 6), ("frontAndBack", 12, 8)]);
    assert_eq!(m.patches[1].in_groups, ["solid"]);
    assert_eq!(m.face(4), [6, 15, 16, 7]);
    assert!(check::check(&m).ok());
    assert_eq!(Mesh::new(&m).unwrap().solved_dirs, [true, true, false]);
}

#[test]
fn a_wedge_collapses_on_its_axis() {
    let text = "vertices ((0 0 0)(1 -0.05 0)(1 -0.05 2)(0 0 2)(1 0.05 0)(1 0.05 2));
        blocks (hex (0 1 4 0 3 2 5 3) (3 1 4) simpleGrading (1 1 1));
        boundary (
            minus { type wedge; faces ((0 1 2 3)); } plus { type wedge; faces ((0 4 5 3)); }
            outer { type wall; faces ((1 4 5 2)); }
            ends { type patch; faces ((0 1 4 0) (3 2 5 3)); } axis { type empty; faces ((0 3 3 0)); }
        );";
    let m = generate(text).unwrap();
    let report = check::check(&m);
    assert_eq!((report.shapes.prisms, report.shapes.hexahedra), (4, 8));
    assert_eq!(m.patches[4].len, 0);
    assert_eq!(m.points.len(), 5 * (1 + 3 * 2));
    assert!(report.ok(), "{report}");
    let volume: f64 = Geometry::new(&m).volume.iter().sum();
    assert!((volume - 0.1).abs() < 1e-15);
    assert_eq!(Mesh::new(&m).unwrap().n_ghosts, 24);
}

#[test]
fn blocks_turned_against_each_other_merge() {
    // The second block's first direction runs along y, its second along -x.
    let text = "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1)
                          (2 0 0)(2 1 0)(2 0 1)(2 1 1));
        blocks (hex (0 1 2 3 4 5 6 7) (3 2 2) simpleGrading (1 4 1)
                hex (8 9 2 1 10 11 6 5) (2 3 2) simpleGrading (4 1 1));
        edges (arc 1 2 (1.1 0.5 0) arc 5 6 (1.1 0.5 1));
        defaultPatch { name rest; type wall; }";
    let m = generate(text).unwrap();
    assert_eq!((m.n_cells(), m.points.len(), m.patches.len()), (24, 63, 1));
    assert_eq!((m.patches[0].name.as_str(), &m.patches[0].kind), ("rest", &PatchKind::Wall));
    let report = check::check(&m);
    assert!(report.ok() && (report.quality.total_volume - 2.0).abs() < 1e-12, "{report}");
}

#[test]
fn cyclic_entries_are_read() {
    let text = format!(
        "{CUBE} blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));
        boundary (
            a {{ type cyclic; neighbourPatch b; transform translational; separationVector (1 0 0); faces ((0 4 7 3)); }}
            b {{ type cyclic; neighbourPatch a; faces ((0 1)); }}
            rest {{ type wall; faces ((0 1 5 4)(3 7 6 2)(0 3 2 1)(4 5 6 7)); }}
        );"
    );
    let m = Mesh::new(&generate(&text).unwrap()).unwrap();
    assert_eq!((m.n_ghosts, m.patches[1].coupled_faces.len()), (8, 4));
}

#[test]
fn gradings_are_exact() {
    let text = "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));
        blocks (hex (0 1 2 3 4 5 6 7) (10 6 4) simpleGrading (8 ((0.2 0.3 4)(0.6 0.4 1)(0.2 0.3 0.25)) -5));
        defaultPatch { name walls; type wall; }";
    let m = generate(text).unwrap();
    let x = |i: usize| m.points[i][0];
    assert!(((x(10) - x(9)) / (x(1) - x(0)) - 8.0).abs() < 1e-12);
    let growth = 8f64.powf(1.0 / 9.0);
    assert!((0..9).all(|i| ((x(i + 2) - x(i + 1)) / (x(i + 1) - x(i)) - growth).abs() < 1e-12));
    let y = |j: usize| m.points[11 * j][1];
    assert!((y(2) - 0.2).abs() < 1e-15 && (y(4) - 0.8).abs() < 1e-15);
    assert!(((y(2) - y(1)) / y(1) - 4.0).abs() < 1e-12);
    let z = |k: usize| m.points[77 * k][2];
    assert!((z(1) / (z(4) - z(3)) - 5.0).abs() < 1e-12);
}

#[test]
fn free_sides_and_unused_edges_are_warned_of() {
    let text = format!(
        "{CUBE}blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));
edges (arc 0 6 (0.5 0.5 0.6) arc 0 1 (2 0.5 0));
boundary (top {{ type wall; faces ((4 5 6 7)); }});"
    );
    let warnings = Diags::from(read(&text).ok().unwrap().warnings);
    insta::assert_snapshot!(warnings, @r#"
        warning: no block has an edge between vertices 0 and 6
         --> system/blockMeshDict:3:8
          |
        3 | edges (arc 0 6 (0.5 0.5 0.6) arc 0 1 (2 0.5 0));
          |        ^^^^^^^^^^^^^^^^^^^^^ this curve is not used

        warning: this arc does not pass through its point
         --> system/blockMeshDict:3:30
          |
        3 | edges (arc 0 6 (0.5 0.5 0.6) arc 0 1 (2 0.5 0));
          |                              ^^^^^^^^^^^^^^^^^ the point lies beyond the arc's end
          |
          = help: give a point between the two vertices

        warning: 5 block sides belong to no patch
         --> system/blockMeshDict:4:50
          |
        4 | boundary (top { type wall; faces ((4 5 6 7)); });
          |                                                  ^ they become the patch `defaultFaces` of type empty
          |
          = help: name them in `boundary`, or choose with `defaultPatch { name ..; type ..; }`
        "#);
}

#[test]
fn mistakes_in_blocks_are_named() {
    let block = |b: &str| message(&format!("{CUBE}blocks ({b});"));
    insta::assert_snapshot!(block("hex (4 5 6 7 0 1 2 3) (2 2 2) simpleGrading (1 1 1)"), @r#"
        error: this block is inside out
         --> system/blockMeshDict:2:9
          |
        2 | blocks (hex (4 5 6 7 0 1 2 3) (2 2 2) simpleGrading (1 1 1));
          |         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ volume -1 m3 about (0.5, 0.5, 0.5)
          |
          = help: seen from the last four vertices, the first four must turn counter-clockwise: exchange the two groups
        "#);
    insta::assert_snapshot!(block("hex (0 1 2 3 4 5 6 8) (2 2 2) simpleGrading (1 1 1)"), @r#"
        error: there is no vertex 8
         --> system/blockMeshDict:2:9
          |
        2 | blocks (hex (0 1 2 3 4 5 6 8) (2 2 2) simpleGrading (1 1 1));
          |         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ vertices are numbered 0 to 7
        "#);
    insta::assert_snapshot!(block("hex (0 1 2 3 4 5 6 7) (2 0 2) simpleGrading (1 1 1)"), @r#"
        error: expected the numbers of cells along the three directions, such as (20 20 1)
         --> system/blockMeshDict:2:31
          |
        2 | blocks (hex (0 1 2 3 4 5 6 7) (2 0 2) simpleGrading (1 1 1));
          |                               ^^^^^^^ three positive whole numbers
        "#);
    insta::assert_snapshot!(block("hex (0 1 2 3 4 5 6 7) (2 2 2) simplegrading (1 1 1)"), @r#"
        error: unknown grading `simplegrading`
         --> system/blockMeshDict:2:39
          |
        2 | blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simplegrading (1 1 1));
          |                                       ^^^^^^^^^^^^^ expected simpleGrading or edgeGrading
          |
          = help: did you mean `simpleGrading`?
        "#);
    insta::assert_snapshot!(block("hex (0 1 2 3 4 5 6) (2 2 2) simpleGrading (1 1 1)"), @r#"
        error: a hex has 8 vertices, found 7
         --> system/blockMeshDict:2:13
          |
        2 | blocks (hex (0 1 2 3 4 5 6) (2 2 2) simpleGrading (1 1 1));
          |             ^^^^^^^^^^^^^^^ the vertices of this block
        "#);
    insta::assert_snapshot!(block("hex (0 1 2 3 4 5 6 7) (2 2 2) edgeGrading (1 1 1)"), @r#"
        error: edgeGrading needs 12 expansion ratios, each a number or a list of (length cells ratio)
         --> system/blockMeshDict:2:51
          |
        2 | blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) edgeGrading (1 1 1));
          |                                                   ^^^^^^^ not such a list
        "#);
}

#[test]
fn mistakes_in_patches_are_named() {
    let boundary = |b: &str| {
        message(&format!(
            "{CUBE}blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));\nboundary ({b});"
        ))
    };
    insta::assert_snapshot!(boundary("a { type wal; faces ((0 1 5 4)); }"), @r#"
        error: patches of type `wal` are not supported
         --> system/blockMeshDict:3:20
          |
        3 | boundary (a { type wal; faces ((0 1 5 4)); });
          |                    ^^^ unknown patch type
          |
          = help: did you mean `wall`? known types are patch, wall, empty, symmetry, symmetryPlane, wedge, cyclic
        "#);
    insta::assert_snapshot!(boundary("a { type wall; faces ((0 1 5 7)); }"), @r#"
        error: patch `a`: no block has a side with these vertices
         --> system/blockMeshDict:3:33
          |
        3 | boundary (a { type wall; faces ((0 1 5 7)); });
          |                                 ^^^^^^^^^ not a side of a block
          |
          = help: block 0 has the side (0 1 5 4)
        "#);
    insta::assert_snapshot!(boundary("a { type wall; faces ((0 1 5 4)); } b { type wall; faces ((4 5 1 0)); }"), @r#"
        error: patch `b`: this side already belongs to `a`
         --> system/blockMeshDict:3:69
          |
        3 | boundary (a { type wall; faces ((0 1 5 4)); } b { type wall; faces ((4 5 1 0)); });
          |                                                                     ^^^^^^^^^ named a second time
        "#);
    insta::assert_snapshot!(boundary("a { type cyclicAMI; faces ((0 1 5 4)); }"), @r#"
        error: patches of type `cyclicAMI` are not supported
         --> system/blockMeshDict:3:20
          |
        3 | boundary (a { type cyclicAMI; faces ((0 1 5 4)); });
          |                    ^^^^^^^^^ unknown patch type
          |
          = help: use `cyclic` with faces that match one to one
        "#);
}

#[test]
fn blocks_that_do_not_fit_are_named() {
    let two = |second: &str, edges: &str| {
        message(&format!(
            "vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1)(2 0 0)(2 1 0)(2 0 1)(2 1 1));
blocks (
    hex (0 1 2 3 4 5 6 7) (3 2 2) simpleGrading (1 1 1)
    hex (1 8 9 2 5 10 11 6) {second}
);
edges ({edges});"
        ))
    };
    insta::assert_snapshot!(two("(3 3 2) simpleGrading (1 1 1)", ""), @r#"
        error: blocks 0 and 1 meet with different numbers of cells: 2 x 2 and 3 x 2
         --> system/blockMeshDict:4:5
          |
        4 |     hex (1 8 9 2 5 10 11 6) (3 3 2) simpleGrading (1 1 1)
          |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ its side (1 5 6 2) is the other block's (1 2 6 5)
        "#);
    insta::assert_snapshot!(two("(3 2 2) simpleGrading (1 3 1)", ""), @r#"
        error: blocks 0 and 1 do not fit along their common side
         --> system/blockMeshDict:4:5
          |
        4 |     hex (1 8 9 2 5 10 11 6) (3 2 2) simpleGrading (1 3 1)
          |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ points differ by 0.25 m at (1, 0.25, 0), where cells measure 0.5 m
          |
          = help: give both blocks the same grading along that side, seen in the same direction
        "#);
    insta::assert_snapshot!(two("(3 2 2) simpleGrading (1 1 1)", "arc 1 8 (1.5 0 0)"), @r#"
        error: this edge cannot be drawn
         --> system/blockMeshDict:6:8
          |
        6 | edges (arc 1 8 (1.5 0 0));
          |        ^^^^^^^^^^^^^^^^^ the arc's three points lie on one line
        "#);
    insta::assert_snapshot!(two("(3 2 2) simpleGrading (1 1 1)", "project 1 8 (cylinder)"), @r#"
        error: edges of type `project` are not supported
         --> system/blockMeshDict:6:8
          |
        6 | edges (project 1 8 (cylinder));
          |        ^^^^^^^^^^^^^^^^^^^^^^ this edge
          |
          = help: projection onto surfaces is not supported: use arc, polyLine, spline or BSpline edges, or import the mesh (`granflow mesh --from FILE`)
        "#);
}
