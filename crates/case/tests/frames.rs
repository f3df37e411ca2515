//! Frames that turn (`MRFProperties`): on one rank and on three, over a restart, and what is refused.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::*;
use granflow_mesh::shapes;

const U: &str = "dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0); boundaryField {
    inner { type noSlip; } outer { type noSlip; }
    start { type cyclic; } end { type cyclic; } bottom { type slip; } top { type slip; } }";
const P: &str = "dimensions [0 2 -2 0 0 0 0]; internalField uniform 0; boundaryField {
    start { type cyclic; } end { type cyclic; } \".*\" { type zeroGradient; } }";
const FRAME: &str = "rotor { cellZone rotor; active yes; nonRotatingPatches (bottom top);
    origin (0 0 0); axis (0 0 1); omega table ((0 1) (1 3)); }";
const ZONES: &str = "actions ( { name rotor; type cellSet; action new; source cylinderToCell;
    p1 (0 0 -1); p2 (0 0 2); radius 0.75; } );";

/// A quarter of a ring whose inner wall turns with the zone around it.
fn ring(scheme: &str) -> tempfile::TempDir {
    let poly = shapes::annular_sector(0.5, 1.0, [8, 12, 1], 4);
    let control = CONTROL.replace("endTime 0.1", "endTime 0.2");
    let files = [
        ("system/controlDict", control.as_str()),
        ("system/fvSchemes", &format!("ddtSchemes {{ default {scheme}; }}")),
        (
            "system/fvSolution",
            "solvers { \"(U|p)\" { solver PBiCGStab; preconditioner DILU; tolerance 1e-13; } }",
        ),
        ("system/topoSetDict", ZONES),
        ("constant/transportProperties", "nu [0 2 -1 0 0 0 0] 0.01;\n"),
        ("constant/MRFProperties", FRAME),
        ("0/U", U),
        ("0/p", P),
    ];
    case(&files, Some(&poly))
}

#[test]
fn three_ranks_turn_as_one() {
    let (one, three) = (ring("Euler"), ring("Euler"));
    run(one.path(), &until(0.1));
    run(three.path(), &granflow_case::Options { ranks: 3, ..until(0.1) });
    for file in ["0.1/U", "0.1/p", "0.1/phi"] {
        let off = apart(one.path(), three.path(), file);
        assert!(off < 1e-8, "{file}: {off:e}");
    }
    // The zone moves what is in it.
    let still = ring("Euler");
    put(still.path(), "constant/MRFProperties", &FRAME.replace("yes", "no"));
    run(still.path(), &until(0.1));
    assert!(read(still.path(), "0.1/U").contains("internalField   uniform (0 0 0);"));
}

#[test]
fn a_restart_goes_on_to_the_last_bit() {
    for scheme in ["Euler", "backward", "CrankNicolson 0.9"] {
        let (whole, parts) = (ring(scheme), ring(scheme));
        run(whole.path(), &until(0.2));
        run(parts.path(), &until(0.1));
        run(parts.path(), &until(0.2));
        assert_same(whole.path(), parts.path(), "0.2");
    }
}

/// What the state at 0.1 was written with, and what it goes on with: fluxes are those of the velocity then.
#[test]
fn other_frames_than_those_of_the_state_have_its_fluxes_made_anew() {
    let faster = FRAME.replace("(1 3)", "(1 6)");
    let smaller = ("system/topoSetDict", ZONES.replace("0.75", "0.6"));
    let mrf = |text: &str| ("constant/MRFProperties", text.to_owned());
    let gone = mrf(&FRAME.replace("yes", "no"));
    for (before, after) in [
        (mrf(FRAME), mrf(&faster)),
        (mrf(FRAME), gone.clone()),
        (gone, mrf(FRAME)),
        (mrf(FRAME), smaller),
        (mrf(FRAME), mrf(&FRAME.replace("(bottom top)", "(bottom top outer)"))),
    ] {
        let dir = ring("Euler");
        put(dir.path(), before.0, &before.1);
        run(dir.path(), &until(0.1));
        put(dir.path(), after.0, &after.1);
        let known = |wanted: bool| {
            let (sink, notices) = (granflow_dict::Sink::new(), granflow_case::Notices::new());
            let options = granflow_case::Options::default();
            let case = granflow_case::Case::load(dir.path(), &options, &sink, &notices).unwrap();
            let said = notices.take().join(" ");
            assert_eq!(said.contains("fluxes are made anew from the velocity"), !wanted, "{said}");
            assert_eq!(case.start.phi.is_some(), wanted);
        };
        known(false);
        // The flux is not one of the frame before.
        run(dir.path(), &until(0.11));
        let anew = ring("Euler");
        put(anew.path(), before.0, &before.1);
        run(anew.path(), &until(0.1));
        put(anew.path(), after.0, &after.1);
        std::fs::remove_file(anew.path().join("0.1/phi")).unwrap();
        run(anew.path(), &until(0.11));
        for file in ["0.11/U", "0.11/phi"] {
            let off = apart(dir.path(), anew.path(), file);
            assert!(off < 1e-9, "{file}: {off:e}");
        }
        known(true);
    }
}

#[test]
fn a_frame_without_its_dictionary_is_refused() {
    let dir = ring("Euler");
    let bare = FRAME.trim_start_matches("rotor {").trim_end_matches('}');
    put(dir.path(), "constant/MRFProperties", bare);
    let said = load_errors(dir.path());
    assert!(said.contains("`cellZone` stands outside of the dictionary of a zone"), "{said}");
    assert!(said.contains("rotor { cellZone rotor;"), "{said}");
    assert_eq!(said.matches("error:").count(), 1, "{said}");
    // What a macro stands for is no entry of a frame.
    let by_macro =
        format!("omega constant 2; {}", FRAME.replace("omega table ((0 1) (1 3))", "omega $omega"));
    put(dir.path(), "constant/MRFProperties", &by_macro);
    run(dir.path(), &until(0.01));
}

#[test]
fn an_unknown_entry_is_told_once() {
    let dir = ring("Euler");
    put(
        dir.path(),
        "constant/MRFProperties",
        &FRAME.replace("active yes;", "active yes; speed 3;"),
    );
    let said = load_errors(dir.path());
    assert_eq!(said.matches("`speed`").count(), 1, "{said}");
}

#[test]
fn frames_that_cannot_be_are_refused() {
    let said = |from: &str, to: &str| {
        let dir = ring("Euler");
        assert!(FRAME.contains(from), "{from}");
        put(dir.path(), "constant/MRFProperties", &FRAME.replace(from, to));
        load_errors(dir.path())
    };
    assert!(said("cellZone rotor", "cellZone roter").contains("did you mean `rotor`?"));
    assert!(said("(bottom top)", "(botom top)").contains("did you mean `bottom`?"));
    let open = said("(bottom top)", "(top)");
    assert!(open.contains("the patch `bottom` lies in the zone and is no wall"), "{open}");
    let empty = ring("Euler");
    put(empty.path(), "system/topoSetDict", &ZONES.replace("radius 0.75", "radius 0.1"));
    let empty = load_errors(empty.path());
    assert!(empty.contains("the zone `rotor` has no cells"), "{empty}");
    assert!(said("axis (0 0 1)", "axis (0 0 0)").contains("no direction"));
    assert!(said("origin", "orign").contains("`origin`"));
    assert!(said("active yes;", "active yes; speed 3;").contains("unknown entry `speed`"));
}

#[test]
fn a_zone_that_is_not_round_is_told() {
    let dir = ring("Euler");
    put(
        dir.path(),
        "system/topoSetDict",
        "actions ( { name rotor; type cellSet; action new; source boxToCell;
            box (0 0 -1) (0.6 0.6 2); } );",
    );
    let (sink, notices) = (granflow_dict::Sink::new(), granflow_case::Notices::new());
    let options = granflow_case::Options::default();
    granflow_case::Case::load(dir.path(), &options, &sink, &notices).unwrap();
    let said = sink.take().to_string();
    assert!(said.contains("is not round about its axis"), "{said}");
}
