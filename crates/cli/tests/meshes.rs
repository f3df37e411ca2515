//! Meshes that are made, imported and checked by the commands.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{cavity, text};

/// Two unit cubes in a row; `X` is where the middle of the row's last corner lies.
const ROW: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
2 3 \"left wall\"
$EndPhysicalNames
$Nodes
12
1 0 0 0
2 1 0 0
3 2 0 0
4 0 1 0
5 1 1 0
6 2 1 0
7 0 0 1
8 1 0 1
9 2 0 1
10 0 1 1
11 1 1 1
12 X 1 1
$EndNodes
$Elements
3
1 5 2 0 1 1 2 5 4 7 8 11 10
2 5 2 0 1 2 3 6 5 8 9 12 11
3 3 2 3 1 1 4 10 7
$EndElements
";

/// Lines of a report that an import must keep.
fn kept(report: &str) -> Vec<String> {
    let of =
        |l: &&str| ["cells ", "faces ", "points ", "cell volume"].iter().any(|k| l.starts_with(k));
    report.lines().filter(of).map(str::to_owned).collect()
}

#[test]
fn what_was_exported_comes_back() {
    let case = cavity();
    let made = text(&case.run(&["mesh"]).stdout);
    assert_eq!(case.run(&["export"]).status.code(), Some(0));
    let out = case.run(&["mesh", "--from", "VTK/0.vtu", "--feature-angle", "30"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(kept(&said).len(), 4, "{said}");
    assert_eq!(kept(&said), kept(&made));
    assert!(
        said.contains("VTK/0.vtu: a mesh of VTU") && said.contains("defaultFaces5 (patch)"),
        "{said}"
    );
}

#[test]
fn an_import_replaces_the_mesh_or_nothing() {
    let case = cavity().meshed();
    case.put("constant/polyMesh/cellZones", b"of the mesh before");
    case.put("a.msh", ROW.replace('X', "2").as_bytes());
    case.put("b.msh", ROW.replace("2 3 6 5", "2 3 6 55").as_bytes());
    let before = case.tree();
    for file in ["b.msh", "none.msh", "system/controlDict"] {
        let out = case.run(&["mesh", "--from", file]);
        assert_eq!(out.status.code(), Some(2), "{file}: {}", text(&out.stdout));
        assert!(text(&out.stderr).contains("nothing was changed"));
        assert!(case.tree() == before, "{file} changed something");
    }
    assert_eq!(case.run(&["mesh", "--scale", "2"]).status.code(), Some(2), "of --from alone");
    let out = case.run(&["mesh", "--from", "a.msh", "--scale", "0.001"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(said.contains("together 2e-9 m3"), "{said}");
    assert!(said.contains("needs: left_wall (wall), defaultFaces (patch)"), "{said}");
    assert!(!case.path().join("constant/polyMesh/cellZones").exists(), "it was the old mesh's");
}

#[test]
fn a_mesh_of_an_incomplete_dictionary_is_not_written() {
    let case = cavity().edit("system/blockMeshDict", "blocks", "#include \"none\"\nblocks");
    let before = case.tree();
    let out = case.run(&["mesh"]);
    assert_eq!(out.status.code(), Some(2));
    assert!(text(&out.stderr).contains("cannot include"), "{}", text(&out.stderr));
    assert!(case.tree() == before);
}

#[test]
fn a_broken_mesh_is_refused_and_its_cells_are_shown() {
    let case = cavity();
    // A corner pushed through the cell.
    case.put("a.msh", ROW.replace('X', "-2").as_bytes());
    assert_eq!(case.run(&["mesh", "--from", "a.msh"]).status.code(), Some(0));
    let out = case.run(&["check", "--mesh"]);
    let (said, err) = (text(&out.stdout), text(&out.stderr));
    assert_eq!(out.status.code(), Some(2), "{said}");
    assert!(said.contains("postProcessing/checkMesh/badCells.vtu"), "{said}");
    assert!(err.contains("\n  cell 1 at (") && err.contains("help: "), "{err}");
    assert!(err.contains("the mesh cannot be used"), "{err}");
    let vtu = std::fs::read(case.path().join("postProcessing/checkMesh/badCells.vtu")).unwrap();
    assert!(vtu.windows(11).any(|w| w == b"Name=\"cell\""));
    // A sound mesh takes the file away, and is no reason to exit otherwise than with 0.
    case.put("a.msh", ROW.replace('X', "2").as_bytes());
    assert_eq!(case.run(&["mesh", "--from", "a.msh"]).status.code(), Some(0));
    assert_eq!(case.run(&["check", "--mesh"]).status.code(), Some(0));
    assert!(!case.path().join("postProcessing/checkMesh/badCells.vtu").exists());
    let before = case.tree();
    case.run(&["check", "--mesh"]);
    assert!(case.tree() == before, "a check of a sound mesh changes nothing");
}
