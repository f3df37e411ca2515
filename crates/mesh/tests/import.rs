//! Meshes of Gmsh, Fluent and VTK. The files in `data` were written by Gmsh 4.15 and VTK 9.7; all of
//! one name hold the same mesh.
#![allow(clippy::unwrap_used)]

use granflow_dict::{Diags, Source};
use granflow_mesh::check::{CheckReport, check};
use granflow_mesh::import::{Imported, Options, read};
use granflow_mesh::{Mesh, PatchKind};

fn file(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn import(name: &str, bytes: impl Into<Vec<u8>>, options: &Options) -> Result<Imported, Diags> {
    read(&Source::new(name, bytes), options).map_err(Diags::from)
}

fn imported(name: &str) -> (Imported, CheckReport) {
    let found = import(name, file(name), &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    let report = check(&found.mesh);
    assert!(report.ok(), "{name}: {report}");
    (found, report)
}

fn patches(found: &Imported) -> Vec<(&str, &'static str, usize)> {
    found.mesh.patches.iter().map(|p| (p.name.as_str(), p.kind.word(), p.len)).collect()
}

fn message(name: &str, bytes: impl Into<Vec<u8>>) -> String {
    import(name, bytes, &Options::default()).err().map_or("no error".into(), |d| d.to_string())
}

/// A box of 1 x 1 x 2 m in tetrahedra, in every version and form.
#[test]
fn gmsh_files_of_all_versions_give_one_mesh() {
    let (first, report) = imported("box_2.2.msh");
    assert_eq!((report.cells, report.shapes.tetrahedra), (24, 24));
    assert!((report.quality.total_volume - 2.0).abs() < 1e-12);
    assert_eq!(
        patches(&first),
        [("side_walls", "wall", 16), ("inlet", "patch", 4), ("outlet", "patch", 4)]
    );
    let area = |name: &str| report.patches.iter().find(|p| p.name == name).unwrap().area;
    assert!((area("inlet") - 1.0).abs() < 1e-12 && (area("side_walls") - 8.0).abs() < 1e-12);
    assert_eq!(first.mesh.cell_zones[0].name, "pipe");
    assert_eq!(first.mesh.cell_zones[0].cells, (0..24).collect::<Vec<u32>>());
    for name in ["box_2.2_binary.msh", "box_4.0.msh", "box_4.1.msh", "box_4.1_binary.msh"] {
        let (other, _) = imported(name);
        assert_eq!(other.mesh.n_faces(), first.mesh.n_faces(), "{name}");
        assert_eq!(other.mesh.cell_zones, first.mesh.cell_zones, "{name}");
        assert_eq!(patches(&other), patches(&first), "{name}");
        let off = first.mesh.points.iter().zip(&other.mesh.points);
        let off = off.flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs())).fold(0.0, f64::max);
        assert!(off < 1e-12, "{name}: {off}");
        assert_eq!(other.mesh.owner, first.mesh.owner, "{name}");
    }
}

#[test]
fn a_plane_gmsh_mesh_becomes_one_layer_of_cells() {
    let options = Options { scale: 0.001, thickness: Some(2e-4), ..Options::default() };
    let found = import("plane_4.1.msh", file("plane_4.1.msh"), &options).unwrap();
    let report = check(&found.mesh);
    assert!(report.ok(), "{report}");
    assert!((report.quality.total_volume - 2e-6 * 2e-4).abs() < 1e-21);
    assert_eq!(report.shapes.prisms, report.cells);
    assert_eq!(Mesh::new(&found.mesh).unwrap().solved_dirs, [true, true, false]);
    let names: Vec<_> = patches(&found).iter().map(|p| (p.0, p.1)).collect();
    let expected = [
        ("outlet", "patch"),
        ("inlet", "patch"),
        ("frontAndBack", "empty"),
        ("defaultFaces", "patch"),
    ];
    assert_eq!(names, expected);
    assert_eq!(found.mesh.cell_zones[0].name, "fluid");
    insta::assert_snapshot!(found.notes.join("\n"), @r#"
        a plane mesh: made one cell thick, 0.0002 m along z, between `frontAndBack` (empty)
        "#);
}

const SHAPES: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
10
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
9 0.5 0.5 2
40 2 0.5 0.5
$EndNodes
$Elements
5
1 5 2 0 1 1 2 3 4 5 6 7 8
2 7 2 0 1 5 6 7 8 9
3 7 2 0 1 3 2 6 7 40
4 15 2 0 1 1
5 3 2 0 9 1 2 3 4
$EndElements
";

/// By hand: a cube with a pyramid on its top and one on its side; the latter is written inside out.
#[test]
fn shapes_find_each_other_whichever_way_they_are_written() {
    let found = import("shapes.msh", SHAPES, &Options::default()).unwrap();
    let report = check(&found.mesh);
    assert!(report.ok(), "{report}");
    assert_eq!((report.shapes.hexahedra, report.shapes.pyramids), (1, 2));
    assert!((report.quality.total_volume - (1.0 + 2.0 / 3.0)).abs() < 1e-14);
    assert_eq!((report.inner_faces, found.mesh.points.len()), (2, 10));
    assert_eq!(patches(&found), [("surface9", "patch", 1), ("defaultFaces", "patch", 11)]);
    let options = Options { feature_angle: Some(20.0), ..Options::default() };
    let split = import("shapes.msh", SHAPES, &options).unwrap();
    assert_eq!(split.mesh.patches.len(), 1 + 11, "every face is a plane of its own");
}

#[test]
fn what_gmsh_files_may_not_hold_is_named_with_its_place() {
    let changed = |from: &str, to: &str| message("a.msh", SHAPES.replace(from, to));
    insta::assert_snapshot!(changed("1 5 2 0 1 1 2", "1 11 2 0 1 1 2"), @r#"
        error: elements of type 11 (10-node tetrahedron) are not supported
          --> a.msh:19:2
           |
        19 | 1 11 2 0 1 1 2 3 4 5 6 7 8
           |  ^^^^^^^^^^^^^^^^^^^^^^^^^ this element
           |
           = help: make a mesh of first order: `Mesh.ElementOrder = 1`, or `gmsh -order 1`
        "#);
    insta::assert_snapshot!(changed("5 6 7 8 9\n3", "5 6 7 8 99\n3"), @r#"
        error: an element uses node 99, which is not in `$Nodes`
          --> a.msh:20:10
           |
        20 | 2 7 2 0 1 5 6 7 8 99
           |          ^^^^^^^^^^^
        "#);
    insta::assert_snapshot!(changed("2.2 0 8", "3 0 8"), @r#"
        error: Gmsh's format 3 is not supported
         --> a.msh:2:1
          |
        2 | 3 0 8
          | ^
          |
          = help: known are 2, 4.0 and 4.1: save the mesh with `-format msh41`
        "#);
    insta::assert_snapshot!(changed("$EndNodes", "$EndNode"), @r#"
        error: expected `$EndNodes`, found `$EndNode`
          --> a.msh:16:1
           |
        16 | $EndNode
           | ^^^^^^^^
           |
           = help: a number in the section does not say how much follows
        "#);
    insta::assert_snapshot!(changed("40 2 0.5 0.5", "40 2 0.5 x"), @r#"
        error: expected a coordinate, found `x`
          --> a.msh:15:10
           |
        15 | 40 2 0.5 x
           |          ^
        "#);
    insta::assert_snapshot!(message("a.msh", SHAPES.split("$Elements").next().unwrap()), @r#"
        error: the file has no section `$Elements`
          --> a.msh:17:1
           |
        17 |
           | ^
           |
           = help: was it cut off? Save the mesh again
        "#);
    insta::assert_snapshot!(changed("3 7 2 0 1 3 2 6 7 40", "3 5 2 0 1 9 10 3 4 5 6 7 8"), @r#"
        error: an element uses node 10, which is not in `$Nodes`
          --> a.msh:21:10
           |
        21 | 3 5 2 0 1 9 10 3 4 5 6 7 8
           |          ^^^^^^^^^^^^^^^^^
        "#);
}

#[test]
fn files_of_no_known_kind_are_refused() {
    insta::assert_snapshot!(message("a.stl", "solid a\nendsolid\n"), @r#"
        error: this is no mesh of a known format
         --> a.stl:1:1
          |
        1 | solid a
          | ^
          |
          = help: known formats are Gmsh, Fluent, VTU
        "#);
}

/// Cuts and damages everywhere: a message or a mesh, and no panic.
#[test]
fn damaged_files_do_not_panic() {
    let names =
        ["box_4.1_binary.msh", "box_2.2_binary.msh", "cells_raw_zlib.vtu", "cells_base64.vtu"];
    for name in names {
        let bytes = file(name);
        for n in (0..bytes.len()).step_by(7) {
            let cut = import(name, &bytes[..n], &Options::default());
            // The last bytes of appended data are the ends of tags.
            assert!(cut.is_err() || n + 50 > bytes.len(), "{name} cut at {n}");
            let mut odd = bytes.clone();
            odd[n] ^= 0x55;
            let _ = import(name, odd, &Options::default());
        }
    }
}

/// A hexahedron, a voxel, two wedges, a polyhedron and a pyramid on top, with two numbered sides.
#[test]
fn vtu_files_of_all_encodings_give_one_mesh() {
    let (first, report) = imported("cells_ascii.vtu");
    let s = report.shapes;
    assert_eq!((s.hexahedra, s.prisms, s.pyramids, s.polyhedra), (3, 2, 1, 0));
    assert!((report.quality.total_volume - (1.0 + 0.25 * 0.5 / 3.0)).abs() < 1e-14);
    let expected = [("group1", "patch", 2), ("group2", "patch", 2), ("defaultFaces", "patch", 17)];
    assert_eq!(patches(&first), expected);
    let zones: Vec<_> =
        first.mesh.cell_zones.iter().map(|z| (z.name.as_str(), z.cells.len())).collect();
    assert_eq!(zones, [("group7", 4), ("group8", 2)]);
    for form in
        ["base64", "base64_zlib", "raw", "raw_zlib", "appended_base64", "appended_base64_zlib"]
    {
        let (other, _) = imported(&format!("cells_{form}.vtu"));
        assert_eq!(other.mesh, first.mesh, "{form}");
    }
}

#[test]
fn vtu_arrays_and_cells_that_cannot_be_used_are_named() {
    let text = String::from_utf8(file("cells_ascii.vtu")).unwrap();
    let options = Options { group_array: Some("cellentityids".into()), ..Options::default() };
    insta::assert_snapshot!(import("a.vtu", text.clone(), &options).err().unwrap(), @r#"
        error: the file has no array `cellentityids` on cells
         --> a.vtu:6:7
          |
        6 |       <CellData>
          |       ^^^^^^^^^^
          |
          = help: did you mean `CellEntityIds`?
        "#);
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        message("a.vtu", text.replace(from, to))
    };
    insta::assert_snapshot!(changed("12 14 11 13", "25 14 11 13"), @r#"
        error: cell 0 is of VTK's type 25 (cell of second order), which is not supported
          --> a.vtu:34:7
           |
        34 |       <Cells>
           |       ^^^^^^^
           |
           = help: known are triangle, quad, polygon, tetra, voxel, hexahedron, wedge, pyramid and polyhedron
        "#);
    insta::assert_snapshot!(changed("UnstructuredGrid\"", "PolyData\""), @r#"
        error: a VTK file of type PolyData is no mesh
         --> a.vtu:1:1
          |
        1 | <VTKFile type="PolyData" version="2.3" byte_order="LittleEndian" header_type="UInt32">
          | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          |
          = help: save an unstructured grid (.vtu)
        "#);
    insta::assert_snapshot!(changed("</Cells>", ""), @r#"
        error: this is no XML
          --> a.vtu:72:1
           |
        72 |     </Piece>
           | ^^^^^^^^^^^^ expected 'Cells' tag, not 'Piece' at 72:5
        "#);
}

/// Two quadrilaterals side by side, by hand.
const FLUENT: &str = "(0 \"by hand\")
(2 2)
(10 (0 1 6 0 2))
(10 (1 1 6 1 2)(
0 0
1 0
2 0
0 1
1 1
2 1
))
(12 (0 1 2 0))
(12 (9 1 2 1 3))
(13 (0 1 7 0))
(13 (3 1 1 2 2)(
2 5 2 1
))
(13 (4 2 5 3 2)(
2 1 1 0
3 2 2 0
4 5 1 0
5 6 2 0))
(13 (5 6 6 a 2)(
1 4 1 0
))
(13 (6 7 7 5 2)(
6 3 2 0
))
(45 (3 interior inside)())
(45 (4 wall floor)())
(45 (5 velocity-inlet in)())
(45 (6 pressure-outlet out)())
(45 (9 fluid air)())
";

#[test]
fn fluent_files_bring_zones_and_kinds() {
    let options = Options { thickness: Some(0.5), ..Options::default() };
    let found = import("a.msh", FLUENT, &options).unwrap_or_else(|d| panic!("{d}"));
    let report = check(&found.mesh);
    assert!(report.ok(), "{report}");
    assert_eq!((report.cells, report.shapes.hexahedra, report.inner_faces), (2, 2, 1));
    assert!((report.quality.total_volume - 1.0).abs() < 1e-14);
    let expected = [
        ("floor", "wall", 4),
        ("in", "patch", 1),
        ("out", "patch", 1),
        ("frontAndBackPlanes", "empty", 4),
    ];
    assert_eq!(patches(&found), expected);
    assert_eq!(found.mesh.patches[3].kind, PatchKind::Empty);
    assert_eq!(found.mesh.cell_zones[0].name, "air");
    insta::assert_snapshot!(message("a.msh", FLUENT.replace("2 5 2 1", "2 5 2 x")), @r#"
        error: expected a cell, a hexadecimal number
          --> a.msh:16:7
           |
        16 | 2 5 2 x
           |       ^
        "#);
    insta::assert_snapshot!(message("a.msh", FLUENT.replace("6 3 2 0", "6 2 2 0")), @r#"
        error: the sides of cell 2 do not close
         --> a.msh:1:1
          |
        1 | (0 "by hand")
          | ^
        "#);
    insta::assert_snapshot!(message("a.msh", FLUENT.replace("(13 (6 7", "(2013 (6 7")), @r#"
        error: binary sections (2013) are not supported
          --> a.msh:26:2
           |
        26 | (2013 (6 7 7 5 2)(
           |  ^^^^^^^^^^^^^^^^^
           |
           = help: save the mesh as text (ASCII)
        "#);
}

/// A number of points or cells that the arrays do not bear out is said, and nothing of that size is
/// made.
#[test]
fn vtu_numbers_that_fit_nothing_are_refused() {
    let text = String::from_utf8(file("cells_ascii.vtu")).unwrap();
    for key in ["NumberOfPoints", "NumberOfCells"] {
        let (before, after) = text.split_once(&format!("{key}=\"")).unwrap();
        let (_, rest) = after.split_once('"').unwrap();
        for number in ["999999999999999999", "-1", "1e300", "many"] {
            let said = message("a.vtu", format!("{before}{key}=\"{number}\"{rest}"));
            assert!(said.contains(&format!("`{key}` is {number}")), "{said}");
        }
    }
}
