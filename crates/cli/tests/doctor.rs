//! `granflow check` as a doctor: the whole report of a sound case, and what it finds in cases that
//! read well and make no sense.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod common;

use common::{Case, cavity, collapse, dam, of_catalogue, text};

/// Runs the command on a case that must stay as it is; its exit code and both streams.
fn check(case: &Case) -> (Option<i32>, String, String) {
    let before = case.tree();
    let out = case.run(&["check"]);
    assert!(case.tree() == before, "`check` changed something");
    (out.status.code(), text(&out.stdout), text(&out.stderr))
}

/// What is said of the case on standard error, with the exit code that it must have.
fn findings(case: &Case, code: i32) -> String {
    let (found, out, err) = check(case);
    assert_eq!(found, Some(code), "{}\n{out}\n{err}", case.edits);
    err
}

#[test]
fn the_report_of_a_sound_case() {
    let (code, out, err) = check(&of_catalogue("annular_shear_cell"));
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    // The mesh has tests of its own.
    let behind_mesh = out.split_once("mesh ok\n").unwrap().1;
    insta::assert_snapshot!("doctor_annular_shear_cell", behind_mesh);
}

#[test]
fn the_report_of_two_phases() {
    let (code, out, err) = check(&dam());
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    insta::assert_snapshot!("doctor_dam", out.split_once("mesh ok\n").unwrap().1);
    let (_, out, _) = check(&collapse());
    // Free fall over 0.2 m, five grains of 2 mm.
    assert!(out.contains("inertial number    I about "), "{out}");
    assert!(out.contains("across their surface"), "{out}");
}

#[test]
fn no_case_of_the_catalogue_is_complained_about() {
    // One is on purpose coarser than it should be.
    for name in ["cavity", "heap_dry", "heap_flow", "silo", "rising_bubble", "vertical_chute"] {
        let (code, out, err) = check(&of_catalogue(name));
        assert_eq!((code, err.as_str()), (Some(0), ""), "{name}: {out}");
        assert!(!out.contains("\nwarning "), "{name}: {out}");
    }
}

#[test]
fn sources_are_told_with_their_zones() {
    let (code, out, _) = check(&of_catalogue("channel"));
    assert_eq!(code, Some(0));
    let held = "what holds a mean velocity of (1 0 0) m/s, in all cells";
    assert!(out.contains(held), "{out}");
    let case = cavity()
        .write("system/topoSetDict", "actions ( { name left; type cellSet; action new; source boxToCell; box (-1 -1 -1) (0.05 9 1); } );")
        .write("constant/fvOptions", "fan { type vectorSemiImplicitSource; selectionMode cellSet; cellSet left; volumeMode specific; injectionRateSuSp { U ((3 0 0) 0); } }");
    let (code, out, err) = check(&case);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("a force of (3 0 0) N/m3, in 8 of 16 cells"), "{out}");
}

#[test]
fn sources_of_one_kind_that_share_cells_are_told() {
    let fan = |name: &str, zone: &str| {
        format!(
            "{name} {{ type vectorSemiImplicitSource; {zone} volumeMode specific; injectionRateSuSp {{ U ((3 0 0) 0); }} }}"
        )
    };
    let of = |first: &str, second: &str| {
        let case = cavity()
            .write("system/topoSetDict", "actions ( { name left; type cellSet; action new; source boxToCell; box (-1 -1 -1) (0.05 9 1); } { name right; type cellSet; action new; source cellToCell; set left; } { name right; type cellSet; action invert; } );")
            .write("constant/fvOptions", &(fan("a", first) + &fan("b", second)));
        check(&case).1
    };
    let [all, left, right] = [
        "selectionMode all;",
        "selectionMode cellSet; cellSet left;",
        "selectionMode cellSet; cellSet right;",
    ];
    let told = "`a` and `b` are both a vectorSemiImplicitSource and share cells";
    assert!(of(all, left).contains(told), "{}", of(all, left));
    assert!(of(left, left).contains(told));
    assert!(!of(left, right).contains("share cells"));
}

#[test]
fn mean_velocities_held_in_the_same_cells_are_rivals() {
    let with = |ubar: &str| {
        let other = format!(
            "momentumSource {{ type meanVelocityForce; selectionMode all; Ubar (1 0 0); }}
             other {{ type meanVelocityForce; selectionMode all; Ubar {ubar}; }}"
        );
        check(&of_catalogue("channel").write("constant/fvOptions", &other))
    };
    let (code, out, err) = with("(2 0 0)");
    assert_eq!(code, Some(0), "{err}");
    let told = "`momentumSource` and `other` hold a mean velocity in the same cells";
    assert!(err.contains(told) && !out.contains("add up"), "{out}{err}");
    assert!(!with("(0 1 0)").2.contains("hold a mean velocity"));
}

#[test]
fn walls_that_a_frame_moves_count() {
    let of = |still: &str| {
        let zone = "actions ( { name all; type cellSet; action new; source boxToCell; box (-9 -9 -9) (9 9 9); } );";
        let frame = format!(
            "rotor {{ cellZone all; origin (0 0 0); axis (0 0 1e-200); omega 400; nonRotatingPatches ({still}); }}"
        );
        let case =
            cavity().write("system/topoSetDict", zone).write("constant/MRFProperties", &frame);
        let (code, out, err) = check(&case);
        assert_eq!(code, Some(0), "{err}");
        out
    };
    let turning = of("");
    assert!(turning.contains("m/s at patch walls"), "{turning}");
    assert!(turning.contains("that is more than 1: PISO"), "{turning}");
    let still = of("lid walls");
    assert!(!still.contains("m/s at patch walls"), "{still}");
    // The fluid at rest goes through the cells of the frame.
    assert!(still.contains("that is more than 1: PISO"), "{still}");
}

#[test]
fn two_fluids_without_damping_in_time_are_told() {
    let of =
        |scheme: &str| dam().edit("system/fvSchemes", "Euler", &format!("CrankNicolson {scheme}"));
    let (code, _, err) = check(&of("1"));
    assert_eq!(code, Some(0), "{err}");
    insta::assert_snapshot!("doctor_crank_nicolson", err);
    let case = of("");
    assert!(case.run(&["init", "-q"]).status.success());
    let run = case.run(&["run", "--until", "0.001"]);
    assert!(text(&run.stderr).contains("`CrankNicolson 0.9` is nearly as exact"));
    assert_eq!(check(&of("0.9")).2, "");
}

/// A case of `interFoam` has its forms, unless it says otherwise; where something else does, it is told.
#[test]
fn whose_forms_a_case_of_two_fluids_has_is_told() {
    let said = |case: Case| -> String {
        let (code, out, err) = check(&case);
        assert_eq!(code, Some(0), "{err}");
        out.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let (theirs, not) = ("with OpenFOAM's forms", "not the forms of interFoam but our own");
    let plain = || dam().edit("system/fvSchemes", "compatible      no", "//");
    let has = said(plain());
    assert!(has.contains(theirs) && !has.contains(not), "{has}");
    let other = said(plain().edit("system/fvSchemes", "Euler", "CrankNicolson 0.9"));
    assert!(!other.contains(theirs) && other.contains(not), "{other}");
    let asked = said(dam());
    assert!(!asked.contains(theirs) && !asked.contains(not), "{asked}");
}

#[test]
fn a_share_of_a_velocity_is_not_given() {
    let lid = "type        fixedValue;\n        value       uniform (1 0 0);";
    let of = |condition: &str| check(&cavity().edit("0/U", lid, condition));
    let mixed = |share: &str| {
        format!(
            "type mixed; refValue uniform (1 -0.5 0); refGradient uniform (0 0 0); valueFraction uniform {share};"
        )
    };
    let formula = |share: &str| {
        format!("type exprMixed; valueExpr \"vector(1, -0.5, 0)\"; fractionExpr \"{share}\";")
    };
    for whole in [mixed("1"), formula("2/2")] {
        let (code, _, err) = of(&whole);
        assert_eq!(code, Some(2), "{whole}: {err}");
        assert!(err.contains("the velocity is given on every patch"), "{err}");
    }
    for part in [mixed("0.5"), formula("0.5"), formula("time() < 0.05 ? 1 : 0")] {
        let (code, _, err) = of(&part);
        assert_eq!((code, err.as_str()), (Some(0), ""), "{part}");
    }
    for none in [mixed("0"), formula("0")] {
        let (code, _, err) = of(&none);
        assert_eq!(code, Some(0), "{none}: {err}");
        assert!(err.contains("neither the velocity nor the pressure is given"), "{none}: {err}");
    }
}

#[test]
fn more_in_than_out_cannot_be() {
    let case = cavity().edit("0/U", "uniform (1 0 0);", "uniform (1 -0.5 0);");
    insta::assert_snapshot!("doctor_net_inflow", findings(&case, 2));
    let run = case.run(&["run"]);
    assert_eq!(run.status.code(), Some(2), "nor can it be run");
}

#[test]
fn velocity_and_pressure_both_or_neither() {
    let wall = "    walls\n    {\n        type        noSlip;\n    }\n";
    let open = "    walls\n    {\n        type        zeroGradient;\n    }\n";
    let case = cavity()
        .edit("0/U", wall, open)
        .edit("0/U", "uniform (1 0 0);", "uniform (1 -0.5 0);")
        .edit(
            "0/p",
            "    lid\n    {\n        type        zeroGradient;\n",
            "    lid\n    {\n        type fixedValue; value uniform 0;\n",
        );
    insta::assert_snapshot!("doctor_both_and_neither", findings(&case, 0));
}

#[test]
fn files_with_nearly_the_right_name() {
    let case = cavity().rename("system/fvSolution", "system/fvsolution").write("0/T", "");
    let (code, out, err) = check(&case);
    assert_eq!(code, Some(0), "{out}\n{err}");
    assert!(err.contains("warning: nothing reads this file"), "{err}");
    assert!(err.contains("did you mean `fvSolution`, which the case does not have?"), "{err}");
    assert!(out.contains("not read           system/fvsolution, 0/T"), "{out}");
    assert!(out.contains("fvSolution         the case has none: defaults"), "{out}");
    let included = cavity()
        .edit("system/controlDict", "application ", "#include \"more\"\napplication ")
        .write("system/more", "purgeWrite 0;\n");
    let (_, out, err) = check(&included);
    assert!(err.is_empty() && !out.contains("not read"), "{out}\n{err}");
    let case = cavity().rename("system/fvSolution", "system/fvsolution").write("0/T", "");
    let (_, out, _) = check(&case);
    // The other one is of the few cells.
    assert!(out.contains("\n2 warnings\n"), "{out}");
    let case = cavity().edit("system/fvSchemes", "div(phi,U)", "default Gauss upwind; div(phi,u)");
    let err = findings(&case, 0);
    assert!(err.contains("`div(phi,u)` is not the convection of U: the default is used"), "{err}");
}

#[test]
fn what_is_there_under_another_name_is_named() {
    let case = dam().rename("0.orig/alpha.water", "0.orig/alpha.watr");
    let err = findings(&case, 2);
    assert!(err.contains("error: the field `alpha.water` is missing"), "{err}");
    assert!(err.contains("0.orig/alpha.watr\n = help: did you mean `alpha.water`"), "{err}");
    let err = findings(&dam().remove("constant/g"), 0);
    assert!(err.contains("warning: two phases without gravity: this file is missing"), "{err}");
    let case = cavity().edit("system/blockMeshDict", "type empty;", "type patch;");
    let err = findings(&case, 2);
    assert!(
        err.contains("`empty` is the condition of patches of that type: `sides` is a patch"),
        "{err}"
    );
    let case =
        of_catalogue("heap_dry").edit("constant/transportProperties", "d    0.5e-3;", "d 0.5;");
    let (_, out, _) = check(&case);
    assert!(out.contains("warning            a grain of 0.5 m in a mesh of "), "{out}");
}

#[test]
fn steps_that_are_too_long() {
    let case = cavity().edit("system/controlDict", "deltaT          0.005;", "deltaT 5;");
    let (code, out, _) = check(&case);
    assert_eq!(code, Some(0));
    assert!(out.contains("warning            that is more than 1: PISO"), "{out}");
    // sqrt(501 * 0.0456^3/(2 pi 0.07)) = 0.33 s.
    let (_, out, _) = check(&dam());
    assert!(
        out.contains("capillary limit    waves of surface tension on the cells need 0.3"),
        "{out}"
    );
}

#[test]
fn the_interface_must_not_skip_cells() {
    let control = "system/controlDict";
    let case = dam().edit(control, "maxCo           0.5;", "maxCo           5;");
    let (_, out, _) = check(&case);
    assert!(!out.contains("\nwarning "), "{out}");
    let case = case.edit(control, "maxAlphaCo      0.5;", "maxAlphaCo      5;");
    let (_, out, _) = check(&case);
    assert!(out.contains("warning            the interface skips cells"), "{out}");
}
