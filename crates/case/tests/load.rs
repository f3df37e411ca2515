//! What cases mean, and how wrong ones are refused.
#![allow(clippy::unwrap_used)]

mod common;
use common::*;
use granflow_case::config::WriteControl;
use granflow_case::{Case, Notices, Options, fields};
use granflow_dict::Sink;
use granflow_mesh::{PatchKind, shapes};

fn load(root: &std::path::Path) -> (Case, Vec<String>) {
    let (sink, notices) = (Sink::new(), Notices::new());
    match Case::load(root, &Options::default(), &sink, &notices) {
        Ok(case) => (case, notices.take()),
        Err(e) => panic!("{e}\n{}", sink.take()),
    }
}

#[test]
fn dictionaries_of_openfoam_are_understood() {
    let dir = cavity_case(4);
    put(
        dir.path(),
        "system/fvSchemes",
        "ddtSchemes { default Euler; } gradSchemes { default cellLimited Gauss linear 1; }
         divSchemes { default none; div(phi,U) Gauss limitedLinear 0.5; }
         laplacianSchemes { default Gauss linear limited corrected 0.33; }
         interpolationSchemes { default linear; } snGradSchemes { default orthogonal; }",
    );
    put(
        dir.path(),
        "system/fvSolution",
        "solvers { p { solver PCG; preconditioner FDIC; tolerance 1e-06; relTol 0.05; }
           pFinal { $p; relTol 0; } \"(U|k)\" { solver smoothSolver; smoother GaussSeidel;
           tolerance 1e-05; relTol 0; } }
         PISO { nCorrectors 3; nNonOrthogonalCorrectors 1; pRefCell 0; pRefValue 2; }
         relaxationFactors { equations { U 0.7; } }",
    );
    let (case, notices) = load(dir.path());
    let s = &case.config.solution;
    assert_eq!((s.outer, s.correctors, s.non_orthogonal_correctors), (1, 3, 1));
    assert_eq!((s.p.tolerance.rel, s.p.last.rel, s.p.last.abs), (0.05, 0.0, 1e-6));
    assert_eq!(s.u.spec.solver, "smoothSolver");
    assert_eq!(case.config.schemes.non_orthogonal, 0.33);
    assert_eq!(case.config.control.write, WriteControl::Steps(5));
    assert_eq!(case.reference, Some((0, 2.0)));
    let said = notices.join("\n");
    for fact in [
        "the gradient that convection extrapolates with is limited",
        "`FDIC` for `p` is served by a cycle of `GAMG`",
        "relaxationFactors",
        "limitedLinearV",
    ] {
        assert!(said.contains(fact), "{fact}: {said}");
    }
}

#[test]
fn outer_iterations_of_piso_are_ignored_aloud() {
    let dir = cavity_case(4);
    put(dir.path(), "system/fvSolution", "PISO { nCorrectors 2; nOuterCorrectors 20; }");
    let (sink, notices) = (Sink::new(), Notices::new());
    let case = Case::load(dir.path(), &Options::default(), &sink, &notices).unwrap();
    assert_eq!((case.config.solution.outer, case.config.solution.correctors), (1, 2));
    let said = sink.take().render(false);
    assert!(said.starts_with("warning: `nOuterCorrectors` is ignored: PISO has none"), "{said}");
    assert!(said.contains("help: name the dictionary PIMPLE"), "{said}");
}

#[test]
fn all_mistakes_are_reported_at_once() {
    let dir = cavity_case(4);
    put(dir.path(), "system/controlDict", "application pimpelFoam; endTime 1; deltaT -1;");
    put(
        dir.path(),
        "system/fvSchemes",
        "ddtSchemes { default SLTS; }
        divSchemes { div(phi,U) Gauss limitedLiner 1; }",
    );
    put(dir.path(), "system/fvSolution", "solvers { p { solver GAMGG; } } PISO { nCorectors 2; }");
    put(
        dir.path(),
        "constant/transportProperties",
        "transportModel NGF; rho 1500; mus 0.3; mu3 1;",
    );
    put(dir.path(), "constant/turbulenceProperties", "simulationType RAS;");
    put(dir.path(), "0/U", &CAVITY_U.replace("noSlip", "noSplip").replace("[0 1 -1", "[0 1 -2"));
    put(dir.path(), "0/p", &CAVITY_P.replace("uniform 0", "nonuniform List<scalar> 3 (1 2 3)"));
    let all = load_errors(dir.path());
    for part in [
        "pimpleFoam",
        "`deltaT` must be positive",
        "time scheme `SLTS` is not supported",
        "did you mean `limitedLinear`?",
        "did you mean `GAMG`?",
        "unused entry `nCorectors`",
        "missing entry `mu2`",
        "unknown entry `mu3`",
        "turbulence models are not supported",
        "did you mean `noSlip`?",
        "wrong dimensions: expected [0 1 -1 0 0 0 0], found [0 1 -2 0 0 0 0]",
        "has 3 values for 16 elements",
    ] {
        assert!(all.contains(part), "{part}\n------\n{all}");
    }
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let refusal = |file: &str, text: &str| {
        let dir = cavity_case(2);
        put(dir.path(), file, text);
        load_errors(dir.path())
    };
    let two = refusal("constant/transportProperties", "phases (water air); water { nu 1; }");
    assert!(two.contains("two phases are needed") || two.contains("missing"), "{two}");
    let moving = refusal("constant/dynamicMeshDict", "dynamicFvMesh dynamicMotionSolverFvMesh;");
    assert!(moving.contains("moving meshes are not supported"), "{moving}");
    let source = refusal("constant/fvOptions", "disk { type actuationDiskSource; }");
    assert!(source.contains("the source `actuationDiskSource` is not done here"), "{source}");
    let function = refusal(
        "system/controlDict",
        "endTime 1; deltaT 1; functions { f { type forcs; patches (yMax); }
         g { type forces; patches (yMaxx); } h { type probes; fields (U fluidity); probeLocations ((0 0 0)); } }",
    );
    assert!(function.contains("unknown function `forcs`"), "{function}");
    assert!(function.contains("did you mean `yMax`?"), "{function}");
    assert!(function.contains("the case has no field `fluidity`"), "{function}");
    let rho = refusal(
        "constant/transportProperties",
        "transportModel muI; mus 0.3; mu2 0.6; I0 0.3; d 1e-3; rhos 2500;",
    );
    assert!(rho.contains("missing entry `rho`"), "{rho}");
    let p = refusal("constant/g", "dimensions [0 1 -2 0 0 0 0]; value (0 -9.81 0);");
    assert!(p.contains("rename `p`"), "{p}");
}

#[test]
fn missing_files_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let all = load_errors(dir.path());
    assert!(all.contains("the case has no mesh"), "{all}");
    assert!(all.contains("controlDict") && all.contains("transportProperties"), "{all}");
    let dir = cavity_case(2);
    std::fs::rename(dir.path().join("0"), dir.path().join("0.orig")).unwrap();
    assert!(load_errors(dir.path()).contains("granflow init"));
}

#[test]
fn kinematic_pressure_is_multiplied_by_the_density() {
    let dir = cavity_case(4);
    put(dir.path(), "constant/transportProperties", "transportModel Newtonian; nu 0.01; rho 4;");
    put(
        dir.path(),
        "0/p",
        &CAVITY_P
            .replace(
                "\".*\" { type zeroGradient; }",
                "\".*\" { type zeroGradient; } xMin { type fixedValue; value uniform 3; }",
            )
            .replace("internalField uniform 0", "internalField uniform 3"),
    );
    let run =
        granflow_case::Run::load(dir.path(), &Options::default(), &Sink::new(), &Notices::new())
            .unwrap();
    let flow = run.flow();
    assert!(flow.state.p.cells.data.iter().all(|p| *p == 12.0));
    let face = flow.mesh.patches[0].faces.start;
    assert_eq!(flow.state.p.boundary_value(&flow.mesh, face), 12.0);
    assert_eq!(flow.fluid.rho, 4.0);
    let mut run = run;
    run.advance().unwrap();
    run.write_now().unwrap();
    let p = read(dir.path(), "0.01/p");
    assert!(p.contains("[0 2 -2 0 0 0 0]") && p.contains("uniform 3;"), "{p}");
}

#[test]
fn gravity_along_a_cyclic_direction_drives_the_flow() {
    use PatchKind::{Empty, Wall};
    let [x0, x1, ..] = shapes::periodic_kinds([true, false, false], Wall);
    let h = 0.02;
    let poly =
        shapes::box_mesh([2, 16, 1], [0.0; 3], [0.1, h, 0.1], [x0, x1, Wall, Wall, Empty, Empty]);
    let dir = case(
        &[
            ("system/controlDict", "endTime 400; deltaT 100;"),
            ("constant/transportProperties", "transportModel Newtonian; nu 1e-2; rho 1000;"),
            ("constant/g", "dimensions [0 1 -2 0 0 0 0]; value (2 -9 0);"),
            (
                "0/U",
                "dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0); boundaryField {
                 \"y.*\" { type noSlip; } \"x.*\" { type cyclic; } \"z.*\" { type empty; } }",
            ),
            (
                "0/p_rgh",
                "dimensions [1 -1 -2 0 0 0 0]; internalField uniform 0; boundaryField {
                 \"y.*\" { type fixedFluxPressure; } \"x.*\" { type cyclic; } \"z.*\" { type empty; } }",
            ),
        ],
        Some(&poly),
    );
    let (case, notices) = load(dir.path());
    assert_eq!(case.gravity.driving, [2.0, 0.0, 0.0]);
    assert_eq!(case.gravity.hydrostatic, [0.0, -9.0, 0.0]);
    assert!(notices.iter().any(|n| n.contains("body force")), "{notices:?}");
    let run = run(dir.path(), &until(400.0));
    let flow = run.flow();
    let most = flow.state.u.cells.data.iter().map(|u| u[0]).fold(0.0, f64::max);
    let exact = 2.0 * h * h / (8.0 * 1e-2);
    assert!((most / exact - 1.0).abs() < 0.01, "{most} {exact}");
    // p = p_rgh + rho g.x falls from the lower to the upper wall by rho g h.
    let dims = [granflow_base::Dims::PRESSURE];
    let none = granflow_fv::conditions::CaseContext::NONE;
    let p = fields::read_vol::<f64>(dir.path(), "400", "p", &dims, (&poly, none), &Sink::new());
    let p = p.unwrap().unwrap().cells;
    let (low, high) = p.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    assert!((high - low - 9000.0 * h * 15.0 / 16.0).abs() < 0.01, "{low} {high}");
}

#[test]
fn fields_survive_a_round_trip_through_a_shuffled_mesh() {
    let poly = shapes::shuffled(&cavity(6), 5);
    let dir = cavity_case(6);
    granflow_case::meshing::write(
        dir.path(),
        &poly,
        granflow_dict::Format::Ascii,
        granflow_case::store::Compression::Plain,
    )
    .unwrap();
    let values: Vec<String> = (0..36).map(|i| format!("({} 0.1 0)", f64::from(i) / 7.0)).collect();
    let list = format!("nonuniform List<vector> 36 ({})", values.join(" "));
    put(dir.path(), "0/U", &CAVITY_U.replace("uniform (0 0 0)", &list));
    let (case, _) = load(dir.path());
    assert_ne!(case.mesh.global_cell, (0..36).collect::<Vec<u32>>());
    let u = case.start.u.cells.clone();
    put(dir.path(), "system/controlDict", "endTime 1e-9; deltaT 1e-9; timePrecision 9;");
    let run = run(dir.path(), &until(1e-9));
    let options = Options::default();
    let again = Case::load(dir.path(), &options, &Sink::new(), &Notices::new()).unwrap();
    // One tiny step projects the field; its divergence-free part keeps each cell's own number.
    let flow = run.flow();
    for (c, &user) in flow.mesh.global_cell.iter().enumerate() {
        assert_eq!(flow.state.u.cells.data[c], again.start.u.cells[user as usize]);
    }
    assert_eq!(u[7], [1.0, 0.1, 0.0]);
    let phi = again.start.phi.unwrap();
    for (f, &e) in flow.mesh.poly_face.iter().enumerate() {
        let sign = if e & 1 == 1 { -1.0 } else { 1.0 };
        assert_eq!(flow.state.phi.data[f], sign * phi[(e >> 1) as usize]);
    }
}
