//! Fields that functions make, on plane Couette flow, where all of them are known: U = y/h (1 0 0).
#![allow(clippy::unwrap_used)]

mod common;
use common::*;
use granflow_base::Dims;
use granflow_case::Options;
use std::path::Path;

/// The numbers of `internalField`, `n` a cell, of a field with the dimensions and the class that it must
/// have.
fn cells(root: &Path, time: &str, name: &str, dims: Dims, class: &str, n: usize) -> Vec<Vec<f64>> {
    let text = read(root, &format!("{time}/{name}"));
    assert!(text.contains(&format!("class           {class};")), "{name}: {text}");
    assert!(text.contains(&format!("dimensions      {dims};")), "{name}, {dims}: {text}");
    let inside = text.split("internalField").nth(1).unwrap().split("boundaryField").next().unwrap();
    let numbers = |t: &str| -> Vec<f64> {
        let bare = t.replace(['(', ')', ';'], " ");
        bare.split_whitespace().filter_map(|w| w.parse().ok()).collect()
    };
    let Some(uniform) = inside.trim().strip_prefix("uniform") else {
        let all = numbers(inside.split_once('\n').unwrap().1);
        // The first one is how many there are.
        assert_eq!(all.len() - 1, all[0] as usize * n, "{name}");
        return all[1..].chunks(n).map(<[f64]>::to_vec).collect();
    };
    vec![numbers(uniform); 24]
}

fn vectors(root: &Path, time: &str, name: &str, dims: Dims) -> Vec<Vec<f64>> {
    cells(root, time, name, dims, "volVectorField", 3)
}

fn scalars(root: &Path, time: &str, name: &str, dims: Dims) -> Vec<f64> {
    cells(root, time, name, dims, "volScalarField", 1).into_iter().flatten().collect()
}

fn near(found: &[f64], wanted: impl Fn(usize) -> f64, what: &str) {
    for (c, x) in found.iter().enumerate() {
        assert!((x - wanted(c)).abs() < 1e-8, "{what}, cell {c}: {x}, not {}", wanted(c));
    }
}

#[test]
fn fields_of_couette_flow_are_those_of_the_books() {
    let dir = couette(
        "m { type mag; field U; } s { type magSqr; field U; } g { type grad; field U; }
         gm { type grad; field \"mag(U)\"; } d { type div; field U; } dp { type div; field phi; }
         v { type vorticity; } q { type Q; } f { type flowType; } co { type CourantNo; }
         c { type writeCellCentres; } w { type writeCellVolumes; } t { type wallShearStress; }",
    );
    run(dir.path(), &until(3000.0));
    let root = dir.path();
    let y: Vec<f64> = scalars(root, "3000", "Cy", Dims::LENGTH);
    assert_eq!(y.len(), 24);
    let u = |c: usize| y[c] / H;
    near(&scalars(root, "3000", "mag(U)", Dims::VELOCITY), u, "mag");
    let square = Dims::VELOCITY.mul(Dims::VELOCITY);
    near(&scalars(root, "3000", "magSqr(U)", square), |c| u(c) * u(c), "magSqr");
    near(&scalars(root, "3000", "div(U)", Dims::RATE), |_| 0.0, "div");
    near(&scalars(root, "3000", "div(phi)", Dims::RATE), |_| 0.0, "div phi");
    near(&scalars(root, "3000", "Q", Dims::RATE.mul(Dims::RATE)), |_| 0.0, "Q");
    near(&scalars(root, "3000", "flowType", Dims::NONE), |_| 0.0, "flowType");
    // Cells are 0.1 m long and a step takes 1000 s.
    let courant = scalars(root, "3000", "Co", Dims::NONE);
    near(&courant.iter().map(|co| co / 1e4).collect::<Vec<_>>(), u, "Co");
    near(&scalars(root, "3000", "V", Dims::VOLUME), |_| 0.1 * H / 8.0 * 0.1, "V");
    let vorticity = vectors(root, "3000", "vorticity", Dims::RATE);
    near(&vorticity.iter().map(|v| v[2]).collect::<Vec<_>>(), |_| -1.0 / H, "vorticity");
    let steep = vectors(root, "3000", "grad(mag(U))", Dims::RATE);
    near(&steep.iter().map(|v| v[1]).collect::<Vec<_>>(), |_| 1.0 / H, "grad of what mag made");
    // d_y U_x is the fourth component.
    let gradients = cells(root, "3000", "grad(U)", Dims::RATE, "volTensorField", 9);
    near(&gradients.iter().map(|g| g[3]).collect::<Vec<_>>(), |_| 1.0 / H, "grad");
    near(&gradients.iter().map(|g| g[1]).collect::<Vec<_>>(), |_| 0.0, "grad");
    // The lid drives the flow, the bottom holds it: eta/h = 5 Pa.
    let text = read(root, "postProcessing/t/0/wallShearStress.dat");
    let rows: Vec<Vec<&str>> =
        text.lines().map(|l| l.split('\t').map(str::trim).collect()).collect();
    assert_eq!(rows[1], ["# Time", "patch", "min", "max"], "as OpenFOAM 1912 has it");
    let stress = |row: &[&str]| -> f64 {
        row[2].trim_matches('(').split(' ').next().unwrap().parse().unwrap()
    };
    assert_eq!((rows[2][1], rows[3][1]), ("yMin", "yMax"));
    assert!(
        (stress(&rows[2]) + 5.0).abs() < 1e-8 && (stress(&rows[3]) - 5.0).abs() < 1e-8,
        "{text}"
    );
    let field = read(root, "3000/wallShearStress");
    assert!(field.contains("dimensions      [1 -1 -2 0 0 0 0]"), "{field}");
}

/// A cavity whose mean and variance over ten steps are taken, by time and by step.
fn averaged(n: usize) -> tempfile::TempDir {
    let dir = cavity_case(n);
    let control = "endTime 0.1; deltaT 0.01; writeControl timeStep; writeInterval 1; functions {
        means { type fieldAverage; fields ( U { mean on; prime2Mean on; base time; }
            p { prime2Mean yes; base iteration; } ); }
        size { type mag; field U; }
        late { type fieldAverage; timeStart 0.055; fields ( \"mag(U)\" { } ); } }";
    put(dir.path(), "system/controlDict", control);
    dir
}

#[test]
fn means_are_those_of_the_times_on_the_disk() {
    let dir = averaged(5);
    run(dir.path(), &until(0.1));
    let times: Vec<String> = (1..=10).map(|i| format!("{}", f64::from(i) / 100.0)).collect();
    let all: Vec<Vec<Vec<f64>>> =
        times.iter().map(|t| vectors(dir.path(), t, "U", Dims::VELOCITY)).collect();
    let mean = vectors(dir.path(), "0.1", "UMean", Dims::VELOCITY);
    for (c, m) in mean.iter().enumerate() {
        for k in 0..3 {
            let exact = all.iter().map(|u| u[c][k]).sum::<f64>() / 10.0;
            assert!((m[k] - exact).abs() < 1e-14, "cell {c}: {} {exact}", m[k]);
        }
    }
    let pressures: Vec<Vec<f64>> =
        times.iter().map(|t| scalars(dir.path(), t, "p", Dims::KINEMATIC_PRESSURE)).collect();
    let square = Dims::KINEMATIC_PRESSURE.mul(Dims::KINEMATIC_PRESSURE);
    let spread = scalars(dir.path(), "0.1", "pPrime2Mean", square);
    for (c, s) in spread.iter().enumerate() {
        let mean = pressures.iter().map(|p| p[c]).sum::<f64>() / 10.0;
        let exact = pressures.iter().map(|p| (p[c] - mean).powi(2)).sum::<f64>() / 10.0;
        assert!((s - exact).abs() < 1e-12, "cell {c}: {s} {exact}");
    }
    // Before its time a mean is not there.
    assert!(!dir.path().join("0.05/mag(U)Mean").exists());
    assert!(dir.path().join("0.06/mag(U)Mean").exists());
    let text = read(dir.path(), "0.1/uniform/functionObjects/functionObjectProperties");
    let steps = text.lines().filter(|l| l.contains("totalIter")).map(|l| l.trim().to_owned());
    let steps: Vec<String> = steps.collect();
    assert_eq!(steps.len(), 3, "{text}");
    assert!(steps[0].ends_with("10;") && steps[2].ends_with("5;"), "{text}");
    assert!(read(dir.path(), "0.1/UPrime2Mean").contains("volSymmTensorField"));
}

#[test]
fn a_restart_goes_on_with_the_means_to_the_bit() {
    for format in ["ascii", "binary"] {
        let dir = averaged(4);
        let control = read(dir.path(), "system/controlDict") + &format!("writeFormat {format};");
        put(dir.path(), "system/controlDict", &control);
        run(dir.path(), &until(0.1));
        let halves = copy(dir.path());
        run(halves.path(), &until(0.07));
        run(halves.path(), &until(0.1));
        assert_same(dir.path(), halves.path(), "0.1");
        let properties = "0.1/uniform/functionObjects/functionObjectProperties";
        assert_eq!(read(dir.path(), properties), read(halves.path(), properties));
        // The same with the fields gone: the means begin anew.
        std::fs::remove_file(halves.path().join("0.07/UMean")).unwrap();
        let from = Options { from: Some(granflow_case::From::Time(0.07)), ..until(0.1) };
        run(halves.path(), &from);
        let text = read(halves.path(), properties);
        assert!(text.contains("totalIter       3;"), "{text}");
    }
}

#[test]
fn ranks_make_the_same_fields_and_surfaces() {
    let (one, three) = (averaged(6), averaged(6));
    let more = "functions { t { type wallShearStress; }
        v { type volFieldValue; operation CoV; fields (U p); }
        cut { type surfaces; surfaceFormat raw; fields (p U); surfaces (
            plane { type cuttingPlane; planeType pointAndNormal; interpolate true;
                pointAndNormalDict { point (0.5 0.5 0.05); normal (1 0 0); } }
            lid { type patch; patches (yMax); } ); }
        flow { type streamLine; fields (p U); lifeTime 50; seedSampleSet { type uniform; axis x;
            start (0.2 0.5 0.05); end (0.8 0.5 0.05); nPoints 3; } } }";
    let solution =
        "solvers { \"(U|p)\" { solver PBiCGStab; preconditioner DILU; tolerance 1e-13; } }";
    for dir in [&one, &three] {
        let control = read(dir.path(), "system/controlDict") + more;
        put(dir.path(), "system/controlDict", &control);
        put(dir.path(), "system/fvSolution", solution);
    }
    run(one.path(), &until(0.05));
    run(three.path(), &Options { ranks: 3, ..until(0.05) });
    let files = [
        "0.05/UMean",
        "0.05/UPrime2Mean",
        "0.05/wallShearStress",
        "postProcessing/t/0/wallShearStress.dat",
        "postProcessing/cut/0.05/p_plane.raw",
        "postProcessing/cut/0.05/U_lid.raw",
        "postProcessing/sets/flow/0.05/track0_p.vtk",
    ];
    for f in files {
        let numbers = |root: &Path| -> Vec<f64> {
            let text = read(root, f).replace(['(', ')', ';'], " ");
            text.split_whitespace().filter_map(|w| w.parse().ok()).collect()
        };
        let (a, b) = (numbers(one.path()), numbers(three.path()));
        assert_eq!(a.len(), b.len(), "{f}");
        assert!(a.len() > 6, "{f}");
        let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let off = a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-8 * size, "{f}: {off:e} of {size:e}");
    }
}
