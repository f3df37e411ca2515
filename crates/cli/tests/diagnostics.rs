//! What a person reads about each mistake: file, line, column, what was expected, the nearest
//! choice. Every bad case ends with exit code 2 and is left as it was, byte for byte (but for the file
//! that shows the bad cells of a mesh).

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{Case, cavity, collapse, dam, flume, granflow, ring, text};

/// Runs the bad case and returns what was said about it.
fn diagnose(case: &Case) -> String {
    let before = case.tree();
    let run = case.run(&["run"]);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{}\n{said}\n{}", case.edits, text(&run.stdout));
    assert!(case.tree() == before, "`run` changed a bad case");
    let check = case.run(&["check"]);
    assert_eq!(check.status.code(), Some(2), "{}\n{}", case.edits, text(&check.stderr));
    let mut after = case.tree();
    // The cells of a poor mesh have a file of their own; all else stays.
    after.retain(|path, _| !path.components().any(|c| c.as_os_str() == "postProcessing"));
    assert!(after == before, "`check` changed a bad case");
    format!("{}\n{said}", case.edits)
}

macro_rules! bad {
    ($($(#[$attribute:meta])* $name:ident: $case:expr;)*) => {
        $(
            $(#[$attribute])*
            #[test]
            fn $name() {
                let mut settings = insta::Settings::clone_current();
                settings.set_prepend_module_to_snapshot(false);
                settings.set_omit_expression(true);
                settings.bind(|| insta::assert_snapshot!(stringify!($name), diagnose(&$case)));
            }
        )*
    };
}

const CONTROL: &str = "system/controlDict";
const SCHEMES: &str = "system/fvSchemes";
const SOLUTION: &str = "system/fvSolution";
const BLOCKS: &str = "system/blockMeshDict";
const PLOT: &str = "system/plotDict";
const TRANSPORT: &str = "constant/transportProperties";

// ---- syntax
bad! {
    missing_semicolon: cavity().edit(CONTROL, "endTime         0.1;", "endTime         0.1");
    unclosed_brace: cavity().edit(SOLUTION, "        relTol          0.01;\n    }", "        relTol          0.01;");
    surplus_brace: cavity().edit(SCHEMES, "snGradSchemes { default corrected; }", "snGradSchemes { default corrected; } }");
    unclosed_list: cavity().edit("0/U", "uniform (1 0 0);", "uniform (1 0 0;");
    unclosed_comment: cavity().edit(CONTROL, "startFrom ", "/* startFrom ");
    unclosed_string: cavity().edit(CONTROL, "application     icoFoam;", "application     \"icoFoam;");
    macro_undefined: cavity().edit(CONTROL, "endTime         0.1;", "endTime         $lastTime;");
    include_missing: cavity().edit(CONTROL, "application ", "#include \"settings\"\napplication ");
    code_stream: cavity().edit(CONTROL, "endTime         0.1;", "endTime #codeStream { code #{ os << 1; #}; };");
    empty_file: cavity().write(CONTROL, "");
    include_etc_of_another_file: cavity().edit("0/U", "boundaryField\n{", "boundaryField\n{\n    #includeEtc \"caseDicts/general/bc\"")
        .edit("0/U", "    sides\n    {\n        type        empty;\n    }\n", "")
        .edit("0/U", "    walls\n    {\n        type        noSlip;\n    }\n", "");
    number_out_of_range: cavity().edit(CONTROL, "endTime         0.1;", "endTime         1e400;");
}

// ---- controlDict
bad! {
    misspelt_keyword: cavity().edit(CONTROL, "endTime         0.1;", "endTimme        0.1;");
    wrong_type: cavity().edit(CONTROL, "deltaT          0.005;", "deltaT          small;");
    delta_t_zero: cavity().edit(CONTROL, "deltaT          0.005;", "deltaT          0;");
    end_before_start: cavity().edit(CONTROL, "endTime         0.1;", "endTime         -1;");
    unknown_application: cavity().edit(CONTROL, "icoFoam", "icoFaom");
    fractional_write_interval: cavity().edit(CONTROL, "writeInterval   10;", "writeInterval   0.5;");
    unknown_write_control: cavity().edit(CONTROL, "timeStep", "timestep");
    unknown_function: ring().edit(CONTROL, "type    forces;", "type    force;");
    function_on_no_patch: ring().edit(CONTROL, "patches (inner);", "patches (iner);");
    function_on_an_empty_patch: cavity().edit(CONTROL, "startTime       0;", "startTime 0; functions { most { type surfaceFieldValue; regionType patch; name sides; operation max; fields (p); } }");
    function_on_no_field: ring().edit(CONTROL, "fields  (U fluidity);", "fields  (U fluidty);");
    no_such_start: cavity().edit(CONTROL, "startTime       0;", "startTime       3;");
    no_such_start_of_a_mapped_case: cavity()
        .edit(CONTROL, "startTime       0;", "startTime       0.05;")
        .write("system/mapFieldsDict", "patchMap ();");
    empty_value: cavity().edit(CONTROL, "endTime         0.1;", "endTime         ;");
    no_delta_t: cavity().edit(CONTROL, "deltaT          0.005;", "");
    condition_without_type: cavity().edit("0/U", "        type        noSlip;\n", "");
    many_mistakes: cavity()
        .edit(CONTROL, "deltaT          0.005;", "deltaT          -1;")
        .edit(SCHEMES, "ddtSchemes { default Euler; }", "ddtSchemes { default Eular; }")
        .edit("0/p", "[0 2 -2 0 0 0 0]", "[0 2 -1 0 0 0 0]")
        .edit("0/U", "noSlip", "noslip");
}

// ---- fvSchemes, fvSolution
bad! {
    unknown_time_scheme: cavity().edit(SCHEMES, "Euler", "Eulr");
    steady_scheme_of_two_phases: dam().edit(SCHEMES, "Euler", "steadyState");
    compatible_with_a_second_law: dam().edit(SCHEMES, "compatible      no", "compatible yes").edit(TRANSPORT, "Newtonian;\n    nu              1.48e-05", "powerLaw;\n    powerLawCoeffs { k 1e-5; n 0.5; nuMin 1e-6; nuMax 1e-4; }\n    nu              1.48e-05");
    compatible_with_crank_nicolson: dam().edit(SCHEMES, "default Euler", "default CrankNicolson 0.9").edit(SCHEMES, "compatible      no", "compatible yes");
    compatible_with_outer_passes_of_two_phases: dam().edit(SCHEMES, "compatible      no", "compatible yes").edit(SOLUTION, "nCorrectors", "nOuterCorrectors 2; nCorrectors");
    compatible_with_backward: cavity().edit(SCHEMES, "ddtSchemes { default Euler; }", "compatible yes;\nddtSchemes { default backward; }");
    compatible_with_outer_passes: cavity().edit(SCHEMES, "ddtSchemes", "compatible yes;\nddtSchemes").edit(SOLUTION, "PISO", "PIMPLE").edit(SOLUTION, "nCorrectors     2;", "nCorrectors     2;\n    nOuterCorrectors 5;");
    compatible_is_a_switch: cavity().edit(SCHEMES, "ddtSchemes", "compatible foam;\nddtSchemes");
    unknown_convection_scheme: cavity().edit(SCHEMES, "div(phi,U)      Gauss linear;", "div(phi,U) Gauss vanLear;");
    convection_without_gauss: cavity().edit(SCHEMES, "div(phi,U)      Gauss linear;", "div(phi,U) linear;");
    no_convection_scheme: cavity().edit(SCHEMES, "div(phi,U) ", "div(phi,u) ");
    unknown_gradient_scheme: cavity().edit(SCHEMES, "gradSchemes { default Gauss linear; }", "gradSchemes { default Gaus linear; }");
    unknown_solver: cavity().edit(SOLUTION, "PCG", "PGC");
    unknown_preconditioner: cavity().edit(SOLUTION, "DIC", "DOC");
    unknown_smoother: cavity().edit(SOLUTION, "symGaussSeidel", "symGausSeidel");
    negative_tolerance: cavity().edit(SOLUTION, "relTol          0.01;", "relTol          -0.01;");
    no_correctors: cavity().edit(SOLUTION, "nCorrectors     2;", "nCorrectors     0;");
    reference_cell_outside: cavity().edit(SOLUTION, "pRefCell        0;", "pRefCell        16;");
    compression_misspelt: dam().edit(SCHEMES, "div(phirb,alpha) Gauss linear;", "div(phirb,alpha) Gauss linaer;");
    gradient_by_a_misspelt_interpolation: cavity().edit(SCHEMES, "gradSchemes { default Gauss linear; }", "gradSchemes { default Gauss linaer; }");
    gradient_limiter_without_its_number: cavity().edit(SCHEMES, "gradSchemes { default Gauss linear; }", "gradSchemes { default Gauss linear; grad(U) cellLimited Gauss linear; }");
    limited_without_its_number: cavity().edit(SCHEMES, "snGradSchemes { default corrected; }", "snGradSchemes { default limited; }");
    limited_laplacian_without_its_number: cavity().edit(SCHEMES, "Gauss linear corrected", "Gauss linear limited corrected");
    grains_without_pressure_level: ring().edit(SOLUTION, "    pRefCell    0;\n    pRefValue   75;\n", "");
}

// ---- fields
bad! {
    missing_field: cavity().remove("0/U");
    wrong_dimensions: cavity().edit("0/U", "[0 1 -1 0 0 0 0]", "[0 1 -2 0 0 0 0]");
    height_of_one_phase: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type variableHeightFlowRateInletVelocity; flowRate 0.01; alpha alpha.water;");
    wrong_class: cavity().edit("0/U", "volVectorField", "volScalarField");
    condition_with_code: cavity().edit("0/U", "type        noSlip;", "type codedFixedValue; name f; code #{ x #};");
    condition_of_turbulence: cavity().edit("0/U", "noSlip", "nutUSpaldingWallFunction");
    condition_of_a_moving_mesh: cavity().edit("0/U", "noSlip", "waveMaker");
    formula_of_a_field: cavity().edit("0/U", "noSlip;", "exprFixedValue; valueExpr \"vector(mag(U), 0, 0)\";");
    mapped_without_points: cavity().edit("0/U", "noSlip;", "timeVaryingMappedFixedValue;");
    unknown_condition: cavity().edit("0/U", "noSlip", "noSlipp");
    scalar_condition_on_vector: cavity().edit("0/U", "noSlip", "fixedFluxPressure");
    missing_condition: cavity().edit("0/p", "    lid\n    {\n        type        zeroGradient;\n    }\n", "");
    extra_patch: cavity().edit("0/p", "    lid\n", "    outlet { type zeroGradient; }\n    lidd\n");
    wrong_vector_size: cavity().edit("0/U", "uniform (1 0 0)", "uniform (1 0)");
    missing_value: cavity().edit("0/U", "        value       uniform (1 0 0);\n", "");
    empty_patch_as_wall: cavity().edit("0/U", "type        empty;", "type        noSlip;");
    wedge_patch_as_wall: ring().edit("0.orig/U", "minus   { type wedge; }", "minus   { type noSlip; }");
    field_too_short: cavity().edit("0/p", "uniform 0;", "nonuniform List<scalar> 3 (0 0 0);");
    list_shorter_than_it_says: cavity().edit("0/p", "uniform 0;", "nonuniform List<scalar> 16 (0 0 0);");
    field_not_finite: cavity().edit("0/p", "uniform 0;", "uniform nan;");
    bad_time_table: ring().edit("0.orig/U", "omega   0.2;", "omega   table ((0 0) (1 0.2) (0.5 0.3));");
    time_function_unknown: ring().edit("0.orig/U", "omega   0.2;", "omega sinus; frequency 1;");
    time_function_coded: ring().edit("0.orig/U", "omega   0.2;", "omega coded;");
    time_table_too_short: ring().edit("0.orig/U", "omega   0.2;", "omega table ((0 0) (0.1 0.2)); outOfBounds error;");
    time_file_missing: ring().edit("0.orig/U", "omega   0.2;", "omega { type tableFile; file \"<case>/constant/omega.dat\"; }");
    empty_time_table: ring().edit("0.orig/U", "omega   0.2;", "omega   table ();");
    macro_undefined_in_vector: cavity().edit("0/U", "uniform (1 0 0);", "uniform ($lidSpeed 0 0);");
    macro_undefined_as_type: cavity().edit("0/U", "type        noSlip;", "type        $wallType;");
    set_fields: dam().edit("system/setFieldsDict", "boxToCell", "boxTocell");
    set_fields_without_a_box: dam().edit("system/setFieldsDict", "box (0 0 -1) (0.146 0.292 1);", "");
    missing_alpha: dam().rename("0.orig/alpha.water", "0.orig/alpha.wather");
    contact_angle_out_of_range: dam().edit("0.orig/alpha.water", "walls       { type zeroGradient; }", "walls { type constantAlphaContactAngle; theta0 190; limit gradiant; }");
    time_table_of_words: ring().edit("0.orig/U", "omega   0.2;", "omega   table ((0 fast) (1));");
    friction_without_a_wall: cavity().edit("0/U", "noSlip;", "coulombFriction; mu -0.3; wallvelocity (0 0 0);");
    axis_without_direction: ring().edit("0.orig/U", "axis    (0 0 1);", "axis    (0 0 0);");
    p_with_gravity: cavity().write("constant/g", "dimensions [0 1 -2 0 0 0 0]; value (0 -9.81 0);");
    gravity_across_the_wedge: ring()
        .rename("0.orig/p", "0.orig/p_rgh")
        .write("constant/g", "dimensions [0 1 -2 0 0 0 0]; value (9.81 0 0);");
    gravity_dimensions: cavity().write("constant/g", "dimensions [0 1 -1 0 0 0 0]; value (0 0 0);");
    no_time_directory: cavity().rename("0", "zero");
    outlet_mean_of_one_phase: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type outletPhaseMeanVelocity; alpha alpha.water; Umean 1;");
    outlet_mean_of_another_phase: dam().edit("0.orig/U", "type pressureInletOutletVelocity; value uniform (0 0 0);", "type outletPhaseMeanVelocity; alpha alpha.oil; Umean 1;");
    share_beyond_one: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type exprMixed; valueExpr \"vector(1, 0, 0)\"; fractionExpr \"1.5\";");
    share_beyond_one_somewhere: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type exprMixed; valueExpr \"vector(1, 0, 0)\"; fractionExpr \"20*pos().x()\";");
    formula_infinite: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type exprFixedValue; valueExpr \"vector(1/0, 0, 0)\";");
    formula_infinite_at_the_start: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type exprFixedValue; valueExpr \"vector(1/time(), 0, 0)\";");
    formula_vector_of_two: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type exprFixedValue; valueExpr \"vector(1, 0)\";");
    profile_without_direction: cavity().edit("0/U", "type        fixedValue;\n        value       uniform (1 0 0);", "type fixedProfile; profile constant (1 0 0); direction (0 0 0); origin 0;");
}

// ---- figures, before anything is computed
bad! {
    plot_unknown_entry: cavity().write(PLOT, "figures { u { xlabel x; curves ({ file \"postProcessing/a.xy\"; x x; y y; }); } }");
    plot_bad_expression: cavity().write(PLOT, "figures { u { curves ({ file \"postProcessing/a.xy\"; x \"(x\"; y \"tan(y)\"; time lastest; }); } }");
    plot_unknown_type: cavity().write(PLOT, "figures { u { type slise; field U_x; } }");
    plot_slice: cavity().write(PLOT, "figures { u {\n    type slice; field \"tan(p)\"; time never;\n    plane { point (0 0); normal (0 0 0); }\n    where { p (1 0); T 5; } lines { p; } contours many; shading flat;\n    map rainbow; range (1 1); scale -1; arrows { spacing 0; color red; }\n} }");
    plot_slice_without_plane: cavity().write(PLOT, "figures { u { type slice; where { p (0 1); T (0 1); U_x (0 1); } lines { p 0.5; U_y 0; } } }");
    plot_volume: cavity().write(PLOT, "figures { u {\n    type volume; stretch (1 0 1); hide (lid;\n    view { azimuth east; elevation 100; up w; }\n    phases ( { colour mauve; opacity 0; } { where { p (0 1); } lable a; } );\n} }");
    plot_volume_without_colour: cavity().write(PLOT, "figures { u { type volume; phases ( { colour red; } { opacity 0.5; } ); time 0.1; titel a; } }");
    plot_without_file: cavity().write(PLOT, "figures { u { curves ({ x x; y y; }); } }");
}

// ---- materials and physics
bad! {
    negative_viscosity: cavity().edit(TRANSPORT, "nu              0.01;", "nu              -0.01;");
    viscosity_dimensions: cavity().edit(TRANSPORT, "nu              0.01;", "nu [1 -1 -1 0 0 0 0] 0.01;");
    missing_viscosity: cavity().edit(TRANSPORT, "nu              0.01;", "");
    unknown_rheology: cavity().edit(TRANSPORT, "Newtonian", "Newtonain");
    mu2_below_mus: ring().edit(TRANSPORT, "mu2  0.6435;", "mu2  0.3;");
    misspelt_coefficient: ring().edit(TRANSPORT, "rhos 2450;", "rhoS 2450;");
    unknown_coefficient: ring().edit(TRANSPORT, "rhos 2450;", "rhos 2450; relaxation 0.2;");
    missing_density: ring().edit(TRANSPORT, "rho            1519;\n", "");
    primitive_without_t0: ring().edit(TRANSPORT, "form steady;", "form primitive;");
    unknown_form: ring().edit(TRANSPORT, "form steady;", "form stationary;");
    missing_transport: cavity().remove(TRANSPORT);
    two_phases: cavity().edit(TRANSPORT, "transportModel ", "phases (water air);\ntransportModel ");
    other_heights: dam().write("constant/hRef", "dimensions [0 1 0 0 0 0 0]; value 0.1;");
    one_phase_of_two: dam().edit(TRANSPORT, "phases (water air);", "phases (water);");
    phase_misspelt_in_the_list: dam().edit(TRANSPORT, "phases (water air);", "phases (water aire);");
    phase_without_dictionary: dam().edit(TRANSPORT, "phases (water air);", "phases (water methane);");
    grains_after_their_fluid: collapse().edit(TRANSPORT, "(grains air)", "(air grains)");
    air_without_viscosity: collapse().edit(TRANSPORT, "nu             1.5e-5;", "nu             0;");
    phase_without_density: dam().edit(TRANSPORT, "    rho             1000;\n", "");
    backward_with_two_phases: dam().edit(SCHEMES, "default Euler", "default backward");
    unknown_reconstruction: dam().edit(SOLUTION, "nAlphaCorr      2;", "reconstructionScheme plicRdf; nAlphaCorr 0;");
    set_flow_that_is_solved: dam().edit(CONTROL, "type            phase;", "type setFlow; mode vortex2d;");
    turbulence: cavity().write("constant/turbulenceProperties", "simulationType RAS; RAS { RASModel kEpsilon; }");
    viscoelastic: cavity().write("constant/turbulenceProperties", "simulationType laminar; laminar { laminarModel Maxwell; MaxwellCoeffs { nuM 1; } }");
    moving_mesh: cavity().write("constant/dynamicMeshDict", "dynamicFvMesh dynamicMotionSolverFvMesh;");
    topo_set_action_without_a_name: cavity()
        .write("system/topoSetDict", "actions ( { type cellSet; action new; source boxToCell; box (-1 -1 -1) (1 1 1); } );")
        .write("constant/fvOptions", "push { type vectorSemiImplicitSource; selectionMode cellSet; cellSet left; volumeMode specific; injectionRateSuSp { U ((3 0 0) 0); } }");
    frame_without_its_dictionary: cavity().write("constant/MRFProperties", "cellZone rotor; active yes; origin (0 0 0); axis (0 0 1); omega 3;");
    unknown_entry_of_a_source: cavity().write("constant/fvOptions", "push { type vectorSemiImplicitSource; selectionMode all; volumeMode specific; speed 3; injectionRateSuSp { U ((3 0 0) 0); } }");
    source_terms: cavity().write("constant/fvOptions", "heat { type scalarSemiImplicitSource; active yes; }");
}

// ---- blockMeshDict
bad! {
    no_mesh: cavity().remove(BLOCKS);
    vertex_out_of_range: cavity().edit(BLOCKS, "hex (0 1 2 3 4 5 6 7)", "hex (0 1 2 3 4 5 6 8)");
    inverted_block: cavity().edit(BLOCKS, "hex (0 1 2 3 4 5 6 7)", "hex (4 5 6 7 0 1 2 3)");
    seven_vertices: cavity().edit(BLOCKS, "hex (0 1 2 3 4 5 6 7)", "hex (0 1 2 3 4 5 6)");
    unknown_block: cavity().edit(BLOCKS, "hex (0", "hexa (0");
    no_cells: cavity().edit(BLOCKS, "(4 4 1)", "(4 0 1)");
    bad_grading: cavity().edit(BLOCKS, "simpleGrading (1 1 1)", "simpleGrading (1 0 1)");
    face_not_on_boundary: cavity().edit(BLOCKS, "((3 7 6 2))", "((3 7 6 1))");
    face_of_unknown_vertex: cavity().edit(BLOCKS, "((3 7 6 2))", "((3 7 6 9))");
    face_in_two_patches: cavity().edit(BLOCKS, "((0 4 7 3) (2 6 5 1) (1 5 4 0))", "((0 4 7 3) (2 6 5 1) (1 5 4 0) (3 7 6 2))");
    unknown_patch_type: cavity().edit(BLOCKS, "    lid\n    {\n        type wall;", "    lid\n    {\n        type wal;");
    cyclic_without_neighbour: cavity().edit(BLOCKS, "    lid\n    {\n        type wall;", "    lid\n    {\n        type cyclic;");
    unknown_edge: cavity().edit(BLOCKS, "edges ();", "edges (arch 0 1 (0.5 -0.1 0));");
    merge_patch_pairs: cavity().edit(BLOCKS, "edges ();", "edges (); mergePatchPairs ((lid walls));");
    fat_wedge: ring().edit(BLOCKS, "(51 0.445070257328698 0)\n", "(51 0.6 0)\n");
}

const MESH: &str = "constant/polyMesh";

// ---- polyMesh
bad! {
    mesh_file_missing: cavity().meshed().remove("constant/polyMesh/owner");
    mesh_owner_out_of_range: last_owner("99");
    mesh_open_cell: last_owner("3");
    mesh_point_missing: cavity().meshed().edit(&format!("{MESH}/points"), "\n50\n(\n", "\n51\n(\n");
    mesh_patch_beyond_faces: cavity().meshed().edit(&format!("{MESH}/boundary"), "nFaces          32;", "nFaces          33;");
    mesh_not_a_number: cavity().meshed().edit(&format!("{MESH}/neighbour"), "(\n1\n", "(\none\n");
}

/// The last face belongs to another cell.
fn last_owner(cell: &str) -> Case {
    let mut case = cavity().meshed();
    let owner = case.read("constant/polyMesh/owner");
    let (head, tail) = owner.rsplit_once("\n15\n").unwrap();
    case.put("constant/polyMesh/owner", format!("{head}\n{cell}\n{tail}").as_bytes());
    case.edits = format!("constant/polyMesh/owner: the last face is given to cell {cell}\n");
    case
}

/// What the program says about its own arguments.
fn refused(args: &[&str]) -> String {
    let case = cavity();
    let before = case.tree();
    let out = granflow(args).current_dir(case.path()).output().unwrap();
    assert_eq!(out.status.code(), Some(2), "{args:?}");
    assert!(case.tree() == before);
    format!("granflow {}\n\n{}", args.join(" "), text(&out.stderr))
}

#[test]
fn arguments() {
    let all: Vec<String> = [
        &["run", "no_such_case"][..],
        &["run", "0/U"],
        &["run", "0"],
        &["run", "--from", "lastest"],
        &["run", "--from", "0.5"],
        &["run", "--until=-1"],
        &["run", "-j", "0"],
        &["runn"],
        &["init"],
        &["new", "cavityy"],
        &["new", "cavity", "system"],
        &["list", "rheology"],
        &["export", "nowhere"],
        &["validate", "cavty"],
    ]
    .map(refused)
    .into();
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.bind(|| insta::assert_snapshot!("arguments", all.join("\n----\n")));
}

#[test]
fn the_good_cases_are_good() {
    for case in [cavity(), ring(), cavity().meshed()] {
        let before = case.tree();
        let out = case.run(&["check"]);
        assert_eq!((out.status.code(), text(&out.stderr).as_str()), (Some(0), ""));
        assert!(case.tree() == before, "`check` changed something");
    }
}

#[test]
fn every_mistake_of_every_file_is_in_one_report() {
    let case = cavity()
        .edit(CONTROL, "deltaT          0.005;", "deltaT          -1;")
        .edit(SCHEMES, "ddtSchemes { default Euler; }", "ddtSchemes { default Eular; }")
        .edit(SOLUTION, "PCG", "PGC")
        .edit(TRANSPORT, "nu              0.01;", "nu              -0.01;")
        .edit("0/U", "noSlip", "noslip");
    let said = text(&case.run(&["run"]).stderr);
    for file in [CONTROL, SCHEMES, SOLUTION, TRANSPORT, "0/U"] {
        assert!(said.contains(&format!("--> {file}:")), "{file} is not in\n{said}");
    }
    assert!(said.ends_with("errors: nothing was changed\n"), "{said}");
}

// ---- waveProperties
const WAVES: &str = "constant/waveProperties";

fn still() -> Case {
    let mut case = flume();
    assert!(case.run(&["init", "-q"]).status.success());
    case.edits.clear();
    case
}

bad! {
    unknown_wave_model: still().edit(WAVES, "StokesI;", "StokesIV;");
    wave_without_height: still().edit(WAVES, "    waveHeight      0.04;\n", "");
    wave_without_model: still().edit(WAVES, "    waveModel       StokesI;\n", "");
    wave_of_another_patch: still().edit(WAVES, "outlet\n", "outflow\n");
    wave_of_another_phase: still().edit(WAVES, "inlet\n{\n    alpha           alpha.water;", "inlet\n{\n    alpha           alpha.oil;");
    wave_on_a_negative_depth: still().edit(WAVES, "rampTime        1.5;", "rampTime        1.5;\n    waterDepthRef   -0.4;");
    wave_higher_than_its_water: still().edit(WAVES, "0.04;", "0.44;");
    wave_too_long_for_stokes: still().edit(WAVES, "StokesI;", "StokesV;").edit(WAVES, "wavePeriod      1.5;", "wavePeriod      15;");
    wave_properties_missing: still().remove(WAVES);
}
