//! Functions on zones of cells and faces, on points in and beside the mesh, at a distance from shapes, and
//! when they execute. Heads and places are those that OpenFOAM 1912 (Debian's 1912.200626) wrote for the same
//! dictionaries on a mesh of the same shape.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;
use common::*;
use granflow_case::Options;
use granflow_case::figures::table::Table;
use std::path::Path;

const ZONES: &str = "actions (
    { name left; type cellSet; action new; source boxToCell; box (-1 -1 -1) (0.5 2 1); }
    { name left; type cellZoneSet; action new; source setToCellZone; set left; }
    { name mid; type faceSet; action new; source boxToFace; box (0.499 -1 -1) (0.501 1 1); }
    { name mid; type faceZoneSet; action new; source setsToFaceZone; faceSet mid; cellSet left; }
    { name back; type faceZoneSet; action new; source setsToFaceZone; faceSet mid; cellSet left; flip true; }
    { name part; type faceSet; action new; source boxToFace; box (0.499 -1 -1) (0.501 0.3 1); }
    { name part; type faceZoneSet; action new; source setsToFaceZone; faceSet part; cellSet left; }
    { name lid; type faceSet; action new; source patchToFace; patch yMax; }
    { name lid; type faceZoneSet; action new; source setToFaceZone; faceSet lid; }
    { name odd; type faceSet; action new; source normalToFace; normal (1 0 0); cos 0.1; } );";

fn with(functions: &str) -> tempfile::TempDir {
    let dir = cavity_case(10);
    put(dir.path(), "system/topoSetDict", ZONES);
    put(dir.path(), "system/controlDict", &format!("{CONTROL} functions {{ {functions} }}"));
    dir
}

fn lines(root: &Path, file: &str) -> Vec<String> {
    let text = read(root, &format!("postProcessing/{file}"));
    text.lines().map(|l| l.trim_end().to_owned()).collect()
}

fn last(root: &Path, file: &str) -> Vec<f64> {
    let row = lines(root, file).pop().unwrap();
    row.split(['\t', ' ', '(', ')']).filter_map(|w| w.parse().ok()).collect()
}

const REGIONS: &str = "
    all { type volFieldValue; operation volIntegrate; fields (p U); }
    zone { type volFieldValue; regionType cellZone; name left; operation volAverage; fields (p U); }
    set { type volFieldValue; regionType cellSet; name left; operation volIntegrate; fields (p U); }
    mid { type surfaceFieldValue; regionType faceZone; name mid; operation sum; fields (phi); }
    back { type surfaceFieldValue; regionType faceZone; name back; operation sum; fields (phi); }
    part { type surfaceFieldValue; regionType faceZone; name part; operation sum; fields (phi); }
    lid { type surfaceFieldValue; regionType faceZone; name lid; operation areaAverage; fields (p U); }
    patch { type surfaceFieldValue; regionType patch; name yMax; operation areaAverage; fields (p U); }";

#[test]
fn sums_over_zones_of_cells_and_faces() {
    let dir = with(REGIONS);
    run(dir.path(), &until(0.1));
    let root = dir.path();
    let head = lines(root, "zone/0/volFieldValue.dat");
    assert_eq!(head[..2], ["# Region      : cellZone left", "# Cells       : 50"]);
    assert!(head[2].starts_with("# Volume      : 0.05"), "{}", head[2]);
    let words: Vec<&str> = head[3].split_whitespace().collect();
    assert_eq!(words, ["#", "Time", "volAverage(p)", "volAverage(U)"]);
    assert_eq!(lines(root, "set/0/volFieldValue.dat")[0], "# Region      : cellSet left");
    let of = |name: &str, file: &str| last(root, &format!("{name}/0/{file}.dat"));
    let (mean, sum) = (of("zone", "volFieldValue"), of("set", "volFieldValue"));
    let all = of("all", "volFieldValue");
    for k in 1..5 {
        assert!((0.05 * mean[k] - sum[k]).abs() < 1e-14, "{mean:?} {sum:?}");
    }
    assert!(sum[1] != all[1] && sum[2] != all[2]);
    let head = lines(root, "mid/0/surfaceFieldValue.dat");
    let expected = ["# Region type : faceZone mid", "# Faces       : 10"];
    assert_eq!(head[..2], expected);
    let area: f64 = head[2].strip_prefix("# Area        : ").unwrap().parse().unwrap();
    assert!((area - 0.1).abs() < 1e-15, "{area}");
    assert_eq!(head[3..5], ["# Scale factor: 1", "# Time        \tsum(phi)"]);
    // What passes the whole section is nothing; what passes its lower part comes back above.
    let part = of("part", "surfaceFieldValue")[1];
    assert!(part < -1e-4, "the lid drives to the right: {part}");
    let (mid, back) = (of("mid", "surfaceFieldValue")[1], of("back", "surfaceFieldValue")[1]);
    assert!(mid.abs() < 1e-4 * part.abs() && mid + back == 0.0, "{mid} {back}");
    // A zone of a patch's faces is the patch.
    assert_eq!(of("lid", "surfaceFieldValue"), of("patch", "surfaceFieldValue"));
    assert_eq!(lines(root, "lid/0/surfaceFieldValue.dat")[1], "# Faces       : 10");
}

#[test]
fn three_ranks_have_the_zones_of_one() {
    let (one, three) = (with(REGIONS), with(REGIONS));
    run(one.path(), &until(0.1));
    run(three.path(), &Options { ranks: 3, ..until(0.1) });
    let files = ["zone/0/volFieldValue", "part/0/surfaceFieldValue", "lid/0/surfaceFieldValue"];
    for file in files {
        let [a, b] = [&one, &three].map(|d| last(d.path(), &format!("{file}.dat")));
        let head = |d: &tempfile::TempDir| lines(d.path(), &format!("{file}.dat"))[..2].to_vec();
        assert_eq!(head(&one), head(&three));
        let apart = a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(a.len() > 1 && apart < 1e-5, "{file} {a:?} {b:?}");
    }
}

#[test]
fn zones_come_from_the_mesh_too() {
    let dir = with(
        "mid { type surfaceFieldValue; regionType faceZone; name given; operation sum; fields (phi); }",
    );
    let faces = "FoamFile { version 2.0; format ascii; class regIOobject; object faceZones; }
        1 ( given { type faceZone; faceLabels List<label> 2 (0 2); flipMap List<bool> 2{1}; } )";
    put(dir.path(), "constant/polyMesh/faceZones", faces);
    run(dir.path(), &until(0.02));
    assert_eq!(lines(dir.path(), "mid/0/surfaceFieldValue.dat")[1], "# Faces       : 2");
    put(dir.path(), "constant/polyMesh/faceZones", &faces.replace("2 (0 2)", "2 (0 99999)"));
    let said = load_errors(dir.path());
    assert!(said.contains("there is no face 99999"), "{said}");
}

#[test]
fn zones_that_are_not_there_are_named() {
    let wrong = |entry: &str| load_errors(with(entry).path());
    let zone = "type volFieldValue; operation volAverage; fields (p); regionType cellZone;";
    let said = wrong(&format!("a {{ {zone} name lefd; }}"));
    assert!(
        said.contains("no cell zone `lefd`") && said.contains("did you mean `left`?"),
        "{said}"
    );
    let faces = "type surfaceFieldValue; operation sum; regionType faceZone;";
    let said = wrong(&format!("a {{ {faces} name mit; fields (phi); }}"));
    assert!(said.contains("no face zone `mit`") && said.contains("did you mean `mid`?"), "{said}");
    // As OpenFOAM has it: fields of cells have no values inside.
    let said = wrong(&format!("a {{ {faces} name mid; fields (p); }}"));
    assert!(said.contains("`p` has no values on the faces between cells"), "{said}");
    let said = wrong(&format!("a {{ {faces} name odd; fields (phi); }}"));
    assert!(said.contains("the source of faces `normalToFace` is not done here"), "{said}");
}

#[test]
fn points_of_lattices_circles_cells_and_patches() {
    // The square of OpenFOAM's cavity, ten times as large.
    let sets = "s { type sets; setFormat raw; fields (p); interpolationScheme cell; sets (
        arr { type array; axis xyz; origin (0.25 0.25 0.02); coordinateRotation { type axes; e1 (0 1 0);
              e2 (-1 0 0); } pointsDensity (3 2 2); spanBox (0.5 0.5 0.06); }
        cc { type cellCentre; axis distance; bounds (0 0 0) (0.2 0.2 0.1); }
        circ { type circle; axis distance; origin (0.5 0.5 0.05); circleAxis (0 0 1);
               startPoint (0.8 0.5 0.05); dTheta 30; }
        pc { type patchCloud; axis xyz; patches (yMax); maxDistance 0.02;
             points ((0.2 1 0.05) (0.51 0.995 0.05) (0.7 0.9 0.05)); }
        ps { type patchSeed; axis xyz; patches (yMax); maxPoints 5; } ); }";
    let dir = with(sets);
    run(dir.path(), &until(0.1));
    let table = |name: &str| {
        Table::parse(&read(dir.path(), &format!("postProcessing/s/0.1/{name}_p.xy"))).columns
    };
    let near = |found: &[f64], wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len());
        let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
        assert!(found.iter().zip(wanted).all(apart), "{found:?} {wanted:?}");
    };
    // The first direction of the lattice is y, the second -x.
    let arr = table("arr");
    let x = 0.25 - 0.5 / 3.0;
    // The other half of its points lies beside the mesh.
    near(&arr[0], &[x; 6]);
    near(&arr[1][..3], &[0.375, 0.5, 0.625]);
    near(&arr[2], &[0.04, 0.04, 0.04, 0.06, 0.06, 0.06]);
    // The number of the cell is the distance.
    near(&table("cc")[0], &[0.0, 1.0, 10.0, 11.0]);
    let circ = table("circ");
    let step = 0.3 * std::f64::consts::PI / 6.0;
    near(&circ[0], &(0..12).map(|i| f64::from(i) * step).collect::<Vec<_>>());
    // Points beside the patch are moved onto it, those far away left out.
    let pc = table("pc");
    near(&pc[0], &[0.2, 0.51]);
    near(&pc[1], &[1.0, 1.0]);
    let ps = table("ps");
    near(&ps[0], &[0.15, 0.35, 0.55, 0.75, 0.95]);
    near(&ps[1], &[0.995; 5]);
}

#[test]
fn surfaces_at_a_distance() {
    let surfaces = "s { type surfaces; surfaceFormat raw; fields (p); surfaces (
        round { type distanceSurface; distance 0.05; signed true; surfaceType searchableSphere;
                surfaceName a; centre (0.5 0.5 0.05); radius 0.25; interpolate true; regularise false; }
        flat { type distanceSurface; distance 0.1; signed true; surfaceType searchablePlane; interpolate true;
               planeType pointAndNormal; pointAndNormalDict { point (0.43 0 0); normal (2 0 0); } }
        both { type distanceSurface; distance 0.1; signed false; surfaceType plane; interpolate true;
               planeType pointAndNormal; pointAndNormalDict { point (0.43 0 0); normal (2 0 0); } } ); }
        a { type surfaceFieldValue; regionType sampledSurface; name round; operation areaIntegrate; fields (one);
            sampledSurfaceDict { type distanceSurface; distance 0.05; signed true; surfaceType searchableSphere;
                centre (0.5 0.5 0.05); radius 0.25; } }";
    let dir = with(&format!("one {{ type mag; field U; result one; }} {surfaces}"));
    run(dir.path(), &until(0.05));
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = read(dir.path(), &format!("postProcessing/s/0.05/p_{name}.raw"));
        let parse = |l: &str| l.split(' ').map(|w| w.parse().unwrap()).collect();
        text.lines().filter(|l| !l.starts_with('#')).map(parse).collect()
    };
    let round = rows("round");
    assert!(round.len() > 60, "{}", round.len());
    for r in &round {
        let far = ((r[0] - 0.5).powi(2) + (r[1] - 0.5).powi(2) + (r[2] - 0.05).powi(2)).sqrt();
        // Linear along edges of a cell's length a: up to a^2/(8 r) off.
        assert!((far - 0.3).abs() < 0.01 / (8.0 * 0.3) + 1e-9, "{r:?} {far}");
    }
    assert!(rows("flat").iter().all(|r| (r[0] - 0.53).abs() < 1e-12));
    let [mut left, mut right] = [0, 0];
    for r in rows("both") {
        left += usize::from((r[0] - 0.33).abs() < 1e-12);
        right += usize::from((r[0] - 0.53).abs() < 1e-12);
    }
    assert_eq!(left + right, rows("both").len());
    assert!(left > 10 && right > 10);
    // The band of a sphere of 0.3 m that is 0.1 m high, less what facets cut off.
    let area: f64 = {
        let head = lines(dir.path(), "a/0/surfaceFieldValue.dat");
        head[2].split(": ").nth(1).unwrap().parse().unwrap()
    };
    let exact = 2.0 * std::f64::consts::PI * 0.3 * 0.1;
    assert!((area / exact - 1.0).abs() < 0.03, "{area} {exact}");
}

#[test]
fn fields_are_made_when_execute_says() {
    let dir = with(
        "seldom { type mag; field U; result seldom; executeControl timeStep; executeInterval 4; }
         now { type mag; field U; result now; }
         often { type fieldAverage; fields ( U { mean on; prime2Mean off; base iteration; } ); }
         rare { type fieldAverage; executeControl timeStep; executeInterval 5; fields ( p { mean on;
                prime2Mean off; base iteration; } ); }
         never { type mag; field p; result never; executeControl timeStep; executeInterval 50; }",
    );
    run(dir.path(), &until(0.1));
    let root = dir.path();
    // Steps 4 and 8 of 5 and 10.
    for (written, made) in [("0.05", "0.04"), ("0.1", "0.08")] {
        let whole = with("now { type mag; field U; result now; }");
        run(whole.path(), &until(made.parse().unwrap()));
        let cells = |root: &Path, file: String| {
            let text = read(root, &file);
            let inner = text.split("internalField").nth(1).unwrap();
            inner.split("boundaryField").next().unwrap().to_owned()
        };
        let (found, then) =
            (cells(root, format!("{written}/seldom")), cells(whole.path(), format!("{made}/now")));
        assert_eq!(found, then, "{written}");
        assert_ne!(found, cells(root, format!("{written}/now")));
    }
    assert!(!root.join("0.1/never").exists(), "it has not been made yet");
    // Two of ten steps.
    let memory = read(root, "0.1/uniform/functionObjects/functionObjectProperties");
    let of = |name: &str| memory.split(name).nth(1).unwrap().split('}').next().unwrap().to_owned();
    assert!(
        of("rare").contains("totalIter       2") && of("often").contains("totalIter       10"),
        "{memory}"
    );
}

#[test]
fn one_mistake_of_a_set_is_told_once() {
    let wrong = |sets: &str| {
        load_errors(with(&format!("s {{ type sets; fields (p); sets ( {sets} ); }}")).path())
    };
    let square = "type array; axis xyz; origin (0 0 0); coordinateRotation { type axes; e1 (1 0 0); e2 (0 1 0); }";
    let said =
        wrong(&format!("a {{ {square} spanBox (1 1 0.1); pointsDensity (1000 1000 1000); }}"));
    assert!(said.contains("together up to 10 million"), "{said}");
    let said =
        wrong("a { type patchCloud; axis xyz; patches (); points ((0 0 0)); maxDistance 1; }");
    assert!(said.contains("no patch is named"), "{said}");
    let crooked = square.replace("e2 (0 1 0)", "e2 (2 0 0)");
    let said = wrong(&format!("a {{ {crooked} spanBox (1 1 0.1); pointsDensity (2 2 2); }}"));
    assert!(said.contains("they span no plane"), "{said}");
    let line = "a { type uniform; axis x; start (0 0.5 0.05); end (1 0.5 0.05); nPoints 3; }";
    let said = wrong(&format!("{line} {line}"));
    assert!(said.contains("two sets are called `a`"), "{said}");
    let said = wrong(
        "a { type circle; axis xyz; origin (0.5 0.5 0); startPoint (0.8 0.5 0); circleAxis (0 0 0); dTheta 30; }",
    );
    assert!(said.contains("`circleAxis` has no direction"), "{said}");
    for said in [said, wrong(&format!("a {{ {square} spanBox (1 1 0.1); }}"))] {
        assert_eq!(said.matches("error:").count(), 1, "{said}");
    }
}

/// What looks at a field before its own time has it made, and not zeros.
#[test]
fn a_field_is_made_for_who_looks_at_it() {
    let dir = with(
        "speed { type mag; field U; executeControl timeStep; executeInterval 7; }
         mean { type volFieldValue; operation volAverage; fields (mag(U)); writeControl timeStep; writeInterval 1; }",
    );
    run(dir.path(), &until(0.03));
    let text = read(dir.path(), "postProcessing/mean/0/volFieldValue.dat");
    let means: Vec<f64> = text
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_whitespace().last().unwrap().parse().unwrap())
        .collect();
    assert!(means.len() == 3 && means[0] > 0.0, "{means:?}");
    assert!(means.iter().all(|m| *m == means[0]), "made once: {means:?}");
}
