//! Names, heads and columns of what functions write, against what OpenFOAM 1912 (Debian's 1912.200626) wrote
//! for the same dictionaries; values against plane Couette flow, U = y/h (1 0 0).
#![allow(clippy::unwrap_used)]

mod common;
use common::*;
use granflow_case::figures::table::Table;

/// The comment lines of a table, without blanks at their ends.
fn head(root: &std::path::Path, file: &str) -> Vec<String> {
    let text = read(root, &format!("postProcessing/{file}"));
    text.lines().filter(|l| l.starts_with('#')).map(|l| l.trim_end().to_owned()).collect()
}

/// The numbers of the last line.
fn last(root: &std::path::Path, file: &str) -> Vec<f64> {
    let text = read(root, &format!("postProcessing/{file}"));
    let row = text.lines().last().unwrap();
    row.split(['\t', ' ', '(', ')']).filter_map(|w| w.parse().ok()).collect()
}

fn near(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{found:?} {wanted:?}");
    let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
    assert!(found.iter().zip(wanted).all(apart), "{found:?} {wanted:?}");
}

#[test]
fn values_over_cells() {
    let dir = couette(
        "c { type writeCellCentres; } vol { type volFieldValue; operation volAverage; fields (p U); }
         all { type volFieldValue; operation volIntegrate; fields (U); scaleFactor 2; }
         cov { type volFieldValue; operation CoV; fields (U); writeFields no; regionType all; }
         most { type volFieldValue; operation max; fields (U); }
         heavy { type volFieldValue; operation weightedVolAverage; weightField Cy; fields (U); }",
    );
    run(dir.path(), &until(3000.0));
    let root = dir.path();
    let volume = 0.3 * H * 0.1;
    near(&last(root, "vol/0/volFieldValue.dat"), &[3000.0, 0.0, 0.5, 0.0, 0.0]);
    near(&last(root, "all/0/volFieldValue.dat"), &[3000.0, volume, 0.0, 0.0]);
    near(&last(root, "most/0/volFieldValue.dat"), &[3000.0, 15.0 / 16.0, 0.0, 0.0]);
    // Of the middles of eight rows.
    let middles: Vec<f64> = (0..8).map(|i| (f64::from(i) + 0.5) / 8.0).collect();
    let square = middles.iter().map(|m| m * m).sum::<f64>() / 8.0;
    let cov = (square - 0.25).sqrt() / 0.5;
    // Of what is zero on the mean a share means nothing.
    near(&last(root, "cov/0/volFieldValue.dat")[..2], &[3000.0, cov]);
    near(&last(root, "heavy/0/volFieldValue.dat"), &[3000.0, square / 0.5, 0.0, 0.0]);
    let lines = head(root, "heavy/0/volFieldValue.dat");
    assert_eq!(lines[0], "# Region      : all region0");
    assert_eq!(lines[1], "# Cells       : 24");
    assert!(lines[2].starts_with("# Volume      : 0.00"), "{lines:?}");
    assert_eq!(lines[3], "# Weight field: Cy");
    assert_eq!(lines[4], "# Time        \tweightedVolAverage(U)");
}

#[test]
fn values_over_patches_and_cuts() {
    let plane = "sampledSurfaceDict { type cuttingPlane; planeType pointAndNormal;
        pointAndNormalDict { point (0.15 0 0); normal (1 0 0); } interpolate true; }";
    let dir = couette(&format!(
        "through {{ type surfaceFieldValue; regionType sampledSurface; name cut; {plane}
            operation areaNormalIntegrate; fields (U); writeFields no; }}
         lid {{ type surfaceFieldValue; regionType patch; name yMax; operation weightedAreaAverage;
            weightField p; fields (U); }}
         even {{ type surfaceFieldValue; regionType patch; name yMax; operation CoV; fields (U); }}"
    ));
    run(dir.path(), &until(3000.0));
    let root = dir.path();
    near(&last(root, "through/0/surfaceFieldValue.dat"), &[3000.0, 0.5 * H * 0.1]);
    near(&last(root, "even/0/surfaceFieldValue.dat"), &[3000.0, 0.0, 0.0, 0.0]);
    let lines = head(root, "lid/0/surfaceFieldValue.dat");
    assert_eq!(lines[0], "# Region type : patch yMax");
    assert_eq!(lines[1], "# Faces       : 3");
    assert!(lines[2].starts_with("# Area        : 0.03"), "{lines:?}");
    assert_eq!(lines[3..5], ["# Scale factor: 1", "# Weight field: p"]);
    assert_eq!(lines[5], "# Time        \tweightedAreaAverage(U)");
    let lines = head(root, "through/0/surfaceFieldValue.dat");
    assert_eq!(lines[0], "# Region type : sampledSurface cut");
    assert_eq!(lines[1], "# Faces       : 8");
}

#[test]
fn forces_and_their_coefficients() {
    let dir = couette(
        "f { type forces; patches (yMax); rho rhoInf; rhoInf 50; CofR (0.15 0 0.05); pRef 3; }
         c { type forceCoeffs; patches (\"y.*ax\"); rho rhoInf; rhoInf 50; CofR (0.15 0 0.05);
             liftDir (0 1 0); dragDir (1 0 0); pitchAxis (0 0 1); magUInf 2; lRef 0.1; Aref 0.3; }",
    );
    run(dir.path(), &until(3000.0));
    let root = dir.path();
    assert_eq!(
        head(root, "f/0/force.dat"),
        [
            "# Force",
            "# CofR        : (0.15 0 0.05)",
            "#",
            "# Time        \t(total_x total_y total_z)\t(pressure_x pressure_y pressure_z)\t(viscous_x \
             viscous_y viscous_z)"
        ]
    );
    assert_eq!(head(root, "f/0/moment.dat")[0], "# Moment");
    // The lid pushes with -5 Pa along x; the pressure outside is 3 Pa whatever the density.
    let area = 0.3 * 0.1;
    near(
        &last(root, "f/0/force.dat"),
        &[3000.0, -5.0 * area, -3.0 * area, 0.0, 0.0, -3.0 * area, 0.0, -5.0 * area, 0.0, 0.0],
    );
    let lines = head(root, "c/0/coefficient.dat");
    let axes = [
        "# Force coefficients",
        "# dragDir     : (1 0 0)",
        "# sideDir     : (0 0 -1)",
        "# liftDir     : (0 1 0)",
        "# rollAxis    : (1 0 0)",
        "# pitchAxis   : (0 0 -1)",
        "# yawAxis     : (0 1 0)",
        "# magUInf     : 2",
        "# lRef        : 0.1",
        "# Aref        : 0.3",
        "# CofR        : (0.15 0 0.05)",
        "#",
    ];
    assert_eq!(lines[..12], axes);
    let columns: Vec<&str> = lines[12].split('\t').map(str::trim).collect();
    assert_eq!(
        columns,
        [
            "# Time", "Cd", "Cs", "Cl", "CmRoll", "CmPitch", "CmYaw", "Cd(f)", "Cd(r)", "Cs(f)",
            "Cs(r)", "Cl(f)", "Cl(r)"
        ]
    );
    let push = 0.5 * 50.0 * 4.0 * 0.3;
    let drag = -5.0 * area / push;
    // About z, against the axis of pitch: r x F = -h F_x.
    let pitch = -(5.0 * area * H) / (push * 0.1);
    near(
        &last(root, "c/0/coefficient.dat"),
        &[3000.0, drag, 0.0, 0.0, 0.0, pitch, 0.0, 0.5 * drag, 0.5 * drag, 0.0, 0.0, pitch, -pitch],
    );
}

/// Where the pressure is kinematic and the case gives no density, `rhoInf` is the density of forces.
#[test]
fn forces_of_a_kinematic_case_have_the_density_that_is_asked_for() {
    let forces = |rho: f64| {
        let dir = cavity_case(4);
        let function = format!("f {{ type forces; patches (yMax); rho rhoInf; rhoInf {rho}; }}");
        let control = read(dir.path(), "system/controlDict");
        put(dir.path(), "system/controlDict", &format!("{control} functions {{ {function} }}"));
        run(dir.path(), &until(0.02));
        last(dir.path(), "f/0/force.dat")
    };
    let (one, heavy) = (forces(1.0), forces(1000.0));
    assert!(one[1] < -1e-3, "{one:?}");
    for (a, b) in one.iter().zip(&heavy).skip(1) {
        assert!((1000.0 * a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
    }
}

#[test]
fn probes_extremes_and_solvers() {
    let dir = cavity_case(4);
    let functions = "p { type probes; fields (p U); probeLocations ((0.5 0.5 0.05) (9 9 9)); }
        m { type fieldMinMax; fields (p U); }
        n { type fieldMinMax; fields (p U); mode component; location no; }
        s { type solverInfo; fields (p U); }";
    let control = read(dir.path(), "system/controlDict");
    put(dir.path(), "system/controlDict", &format!("{control} functions {{ {functions} }}"));
    run(dir.path(), &until(0.02));
    let root = dir.path();
    assert_eq!(
        head(root, "p/0/p"),
        [
            "# Probe 0 (0.5 0.5 0.05)",
            "# Probe 1 (9 9 9)  # Not Found",
            "#       Probe             0             1",
            "#        Time"
        ]
    );
    let rows = read(root, "postProcessing/p/0/U");
    assert!(rows.lines().last().unwrap().ends_with(" (-1e300 -1e300 -1e300)"), "{rows}");
    let words = |file: &str| -> Vec<String> {
        head(root, file).last().unwrap().split('\t').map(|w| w.trim().to_owned()).collect()
    };
    assert_eq!(head(root, "m/0/fieldMinMax.dat")[0], "# Field minima and maxima");
    let places = ["# Time", "field", "min", "location(min)", "max", "location(max)"];
    assert_eq!(words("m/0/fieldMinMax.dat"), places);
    assert_eq!(words("n/0/fieldMinMax.dat"), ["# Time", "min(U)", "max(U)", "min(p)", "max(p)"]);
    assert_eq!(head(root, "s/0/solverInfo.dat")[0], "# Solver information");
    assert_eq!(
        words("s/0/solverInfo.dat"),
        [
            "# Time",
            "U_solver",
            "Ux_initial",
            "Ux_final",
            "Ux_iters",
            "Uy_initial",
            "Uy_final",
            "Uy_iters",
            "U_converged",
            "p_solver",
            "p_initial",
            "p_final",
            "p_iters",
            "p_converged"
        ]
    );
}

#[test]
fn sets_have_a_file_a_rank_in_every_format() {
    let line =
        "sets ( l { type uniform; axis y; start (0.15 0 0.05); end (0.15 0.2 0.05); nPoints 5; }
        c { type cloud; axis xyz; points ((0.1 0.05 0.05) (0.2 0.15 0.05)); }
        b { type polyLine; axis distance; points ((0.1 0.05 0.05) (0.2 0.15 0.05)); } );";
    let set = |name: &str, format: &str| {
        format!("{name} {{ type sets; setFormat {format}; fields (p \"mag(U)\" U); {line} }}")
    };
    let formats = [
        ("raw", "raw"),
        ("csv", "csv"),
        ("vtk", "vtk"),
        ("gnu", "gnuplot"),
        ("agr", "xmgr"),
        ("dat", "jplot"),
    ];
    let all = formats.map(|(name, format)| set(name, format));
    let dir = couette(&format!("m {{ type mag; field U; }} {}", all.join("\n")));
    run(dir.path(), &until(3000.0));
    let root = dir.path();
    let text = |f: &str| read(root, &format!("postProcessing/{f}"));
    let csv = text("csv/3000/l_U.csv");
    assert!(csv.starts_with("y,U_0,U_1,U_2\n0,"), "{csv}");
    let table = Table::parse(&csv);
    let of = |name: &str| &table.columns[table.column(name).unwrap()];
    assert!(of("y").iter().zip(of("U_x")).all(|(y, u)| (u - y / H).abs() < 1e-9), "{csv}");
    assert!(text("csv/3000/c_mag(U)_p.csv").starts_with("x,y,z,mag(U),p\n0.1,0.05,0.05,"));
    // Beside OpenFOAM's files one with all fields.
    assert!(text("csv/3000/l_p_mag(U)_U.csv").starts_with("y,p,mag(U),U_x,U_y,U_z\n"));
    let raw = Table::parse(&text("raw/3000/l_mag(U)_p.xy"));
    assert_eq!((raw.columns.len(), raw.columns[0].len()), (3, 5));
    // Of a polyLine the distance is the number of the point, as OpenFOAM writes it.
    assert_eq!(Table::parse(&text("raw/3000/b_U.xy")).columns[0], [0.0, 1.0]);
    let vtk = text("vtk/3000/l_U.vtk");
    let lines: Vec<&str> = vtk.lines().collect();
    let start = ["# vtk DataFile Version 2.0", "l", "ASCII", "DATASET POLYDATA", "POINTS 5 double"];
    assert_eq!(lines[..5], start);
    assert!(vtk.contains("POINT_DATA 5\nFIELD attributes 1\nU 3 5 double\n"), "{vtk}");
    let gnu = text("gnu/3000/l_U.gplt");
    let start =
        "set term postscript color\nset output \"l.ps\"\nplot \"-\" title \"U\" with lines\n0\t";
    assert!(gnu.starts_with(start) && gnu.ends_with("\ne\n"), "{gnu}");
    // Of several fields each has an axis of its own, and each format its heads.
    let both = text("gnu/3000/l_mag(U)_p.gplt");
    let start = "set term postscript color\nset output \"l.ps\"\nset ylabel \"mag(U)\"\nset y2label \"p\"\n\
                 set ytics nomirror\nset y2tics\nplot \"-\" title \"mag(U)\" with lines axes x1y1, \"-\" title \
                 \"p\" with lines axes x1y2\n0\t";
    assert!(both.starts_with(start), "{both}");
    let agr = text("agr/3000/c_mag(U)_p.agr");
    let start = "@g0 on\n@with g0\n@    title \"c\"\n@    xaxis label \"xyz\"\n@    s0 legend \"mag(U)\"\n\
                 @target G0.S0\n0.1\t0.05\t0.05\t";
    assert!(agr.starts_with(start) && agr.ends_with("\n&\n"), "{agr}");
    assert!(agr.contains("\n&\n@    s1 legend \"p\"\n@target G0.S1\n"), "{agr}");
    let dat = text("dat/3000/l_mag(U)_p.dat");
    let start = "# JPlot file\n# column 1: l\n# column 2: mag(U)\n# column 3: p\n0\t";
    assert!(dat.starts_with(start), "{dat}");
    assert_eq!(dat.lines().count(), 4 + 5);
}

#[test]
fn surfaces_are_where_they_were_asked_for() {
    let surfaces = "surfaces (
        p1 { type cuttingPlane; planeType pointAndNormal; interpolate true;
             pointAndNormalDict { point (0.15 0 0); normal (1 0 0); } }
        p2 { type plane; pointAndNormalDict { basePoint (0.15 0 0); normalVector (1 0 0); } }
        w { type patch; patches (yMax); }
        i { type isoSurface; isoField Cy; isoValue 0.07; interpolate true; } );";
    let dir = couette(&format!(
        "c {{ type writeCellCentres; }}
         raw {{ type surfaces; surfaceFormat raw; fields (p U); {surfaces} }}
         vtp {{ type surfaces; surfaceFormat vtk; fields (p U); {surfaces} }}"
    ));
    run(dir.path(), &until(3000.0));
    let text = |f: &str| read(dir.path(), &format!("postProcessing/raw/3000/{f}"));
    let rows = |f: &str| -> Vec<Vec<f64>> {
        let parse = |l: &str| l.split(' ').map(|w| w.parse().unwrap()).collect();
        text(f).lines().filter(|l| !l.starts_with('#')).map(parse).collect()
    };
    assert!(text("U_p1.raw").starts_with("# U  POINT_DATA 18\n# x  y  z  U_x  U_y  U_z\n"));
    assert!(text("p_w.raw").starts_with("# p  FACE_DATA 3\n# x  y  z  p\n"));
    let faces = rows("U_p2.raw");
    assert_eq!(faces.len(), 8);
    for row in &faces {
        assert!((row[0] - 0.15).abs() < 1e-12 && (row[3] - row[1] / H).abs() < 1e-9, "{row:?}");
    }
    assert!(rows("U_w.raw").iter().all(|r| r[1] == H && r[3] == 1.0));
    let level = rows("U_i.raw");
    // A level of 24 cells above 0.3 x 0.1 m.
    assert!(level.len() >= 8);
    for row in &level {
        assert!((row[1] - 0.07).abs() < 1e-9 && (row[3] - 0.07 / H).abs() < 1e-9, "{row:?}");
    }
    let vtp = std::fs::read(dir.path().join("postProcessing/vtp/3000/p1.vtp")).unwrap();
    let xml = String::from_utf8_lossy(&vtp);
    let piece = "NumberOfPoints=\"18\" NumberOfVerts=\"0\" NumberOfLines=\"0\" \
                 NumberOfStrips=\"0\" NumberOfPolys=\"8\"";
    assert!(xml.contains("type=\"PolyData\"") && xml.contains(piece), "{xml}");
    assert!(xml.contains("<PointData>\n<DataArray type=\"Float64\" Name=\"p\""), "{xml}");
}

#[test]
fn stream_lines_follow_the_flow() {
    let seeds = "seedSampleSet { type uniform; axis y; start (0.15 0.03 0.05);
        end (0.15 0.17 0.05); nPoints 4; }";
    let dir = couette(&format!(
        "s {{ type streamLine; setFormat vtk; trackForward true; fields (p U); lifeTime 1000;
            nSubCycle 5; cloud particleTracks; {seeds} }}
         b {{ type streamLine; direction bidirectional; fields (U); setFormat vtp; {seeds} }}"
    ));
    run(dir.path(), &until(3000.0));
    let text = read(dir.path(), "postProcessing/sets/s/3000/track0_U.vtk");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[1], "track0");
    let n: usize = lines[4].split(' ').nth(1).unwrap().parse().unwrap();
    let points: Vec<Vec<f64>> = lines[5..5 + n]
        .iter()
        .map(|l| l.split(' ').map(|w| w.parse().unwrap()).collect())
        .collect();
    assert_eq!(lines[5 + n].split(' ').take(2).collect::<Vec<_>>(), ["LINES", "4"]);
    for (k, row) in lines[6 + n..10 + n].iter().enumerate() {
        let ids: Vec<usize> = row.split(' ').skip(1).map(|w| w.parse().unwrap()).collect();
        let height = 0.03 + 0.14 * k as f64 / 3.0;
        assert!(ids.iter().all(|i| (points[*i][1] - height).abs() < 1e-9), "line {k}");
        let ends = [points[ids[0]][0], points[ids[ids.len() - 1]][0]];
        // To the end of the mesh.
        assert!(ends[0] == 0.15 && (ends[1] - 0.3).abs() < 1e-3, "line {k}: {ends:?}");
    }
    assert!(dir.path().join("postProcessing/sets/b/3000/track0.vtp").is_file());
}

#[test]
fn packaged_functions_are_included() {
    let dir = couette(
        "#includeFunc mag(U)
         #includeFunc residuals // of p and U
         #includeFunc patchAverage(name=yMax, U)
         #includeFunc graph",
    );
    put(
        dir.path(),
        "system/graph",
        "start (0.15 0 0.05); end (0.15 0.2 0.05); fields (U);
         #includeEtc \"caseDicts/postProcessing/graphs/sampleDict.cfg\"
         setConfig { axis y; }
         #includeEtc \"caseDicts/postProcessing/graphs/graph.cfg\"",
    );
    run(dir.path(), &until(3000.0));
    assert!(dir.path().join("3000/mag(U)").is_file());
    assert!(dir.path().join("postProcessing/residuals/0/solverInfo.dat").is_file());
    let average = last(dir.path(), "patchAverage(name=yMax,U)/0/surfaceFieldValue.dat");
    near(&average, &[3000.0, 1.0, 0.0, 0.0]);
    let line = Table::parse(&read(dir.path(), "postProcessing/graph/3000/line_U.xy"));
    assert_eq!(line.columns[0].len(), 100);
    assert_eq!(line.names[0], "y");
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let dir = couette(
        "a { type yPlus; } b { type surfaces; fields (U); surfaces ( s { type distanceSurface;
         surfaceType triSurfaceMesh; } ); }
         c { type volFieldValue; operation volAverage; regionType cellZone; name z; fields (U); }
         d { type fieldAverage; fields ( U { window 3; } ); } e { type probes; fields (vorticity);
         probeLocations ((0 0 0)); } f { type vorticity; } g { type forces; patches (yMax);
         porosity yes; } #includeFunc streamlinez
         h { type sets; fields (U); sets ( l { type patchEdge; } ); } i { type volFieldValue;
         operation volAverge; fields (U); } j { type mag; field U; result p; }
         k { type magSqr; field U; } l { type magSqr; field U; }",
    );
    let said = load_errors(dir.path());
    for text in [
        "the function `yPlus` is not supported",
        "there is no turbulence model",
        "`triSurfaceMesh`: surfaces of triangles are not read",
        "no cell zone `z`",
        "`window` is not supported",
        "unknown field `vorticity`",
        "what functions before this one make",
        "nothing is porous here",
        "there is no function `streamlinez` to include",
        "sets of type `patchEdge` are not supported: it needs a surface of triangles",
        "`volAverge`",
        "the field `p` cannot be made under this name",
        "the field `magSqr(U)` cannot be made under this name",
    ] {
        assert!(said.contains(text), "{text}\n{said}");
    }
}
