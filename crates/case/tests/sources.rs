//! Sources of a case: `fvOptions` with zones of `topoSetDict`, on one rank and on three, over a restart.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::*;

/// A force without times in a zone that is named as its set is, a porous body over the other half, and a
/// force whose time has not come.
const SOURCES: &str = "
    push { type vectorSemiImplicitSource; selectionMode cellZone; cellZone left; volumeMode specific;
           injectionRateSuSp { U ((0 30 0) -0.5); } }
    hold { type explicitPorositySource; explicitPorositySourceCoeffs { selectionMode cellZone;
           cellZone right; type DarcyForchheimer; d (20000 20000 20000); f (1 1 1);
           coordinateSystem { origin (0 0 0); e1 (1 0 0); e2 (0 1 0); } } }
    never { type vectorSemiImplicitSource; selectionMode all; volumeMode specific; timeStart 100;
            duration 1; injectionRateSuSp { U ((100 0 0) 0); } }";
const ZONES: &str = "actions (
    { name left; type cellSet; action new; source boxToCell; box (-1 -1 -1) (0.5 2 1); }
    { name left; type cellZoneSet; action new; source setToCellZone; set left; }
    { name right; type cellSet; action new; source cellToCell; set left; }
    { name right; type cellSet; action invert; } );";

fn case_with(sources: &str) -> tempfile::TempDir {
    let dir = cavity_case(8);
    put(dir.path(), "constant/fvOptions", sources);
    put(dir.path(), "system/topoSetDict", ZONES);
    let solvers =
        "solvers { \"(U|p)\" { solver PBiCGStab; preconditioner DILU; tolerance 1e-13; } }";
    put(dir.path(), "system/fvSolution", solvers);
    dir
}

#[test]
fn every_source_acts_in_its_zone_and_its_time() {
    let whole = case_with(SOURCES);
    run(whole.path(), &until(0.05));
    let without = |name: &str| {
        let dir =
            case_with(&SOURCES.replace(&format!("{name} {{"), &format!("{name} {{ active no;")));
        run(dir.path(), &until(0.05));
        apart(whole.path(), dir.path(), "0.05/U")
    };
    assert!(without("push") > 5e-3, "{}", without("push"));
    assert!(without("hold") > 5e-3, "{}", without("hold"));
    assert!(without("never") == 0.0);
}

#[test]
fn three_ranks_have_the_sources_of_one() {
    let (one, three) = (case_with(SOURCES), case_with(SOURCES));
    run(one.path(), &until(0.05));
    run(three.path(), &granflow_case::Options { ranks: 3, ..until(0.05) });
    for file in ["0.05/U", "0.05/p"] {
        let off = apart(one.path(), three.path(), file);
        assert!(off < 1e-8, "{file}: {off:e}");
    }
}

#[test]
fn zones_and_sources_that_cannot_be_are_refused() {
    let said = |from: &str, to: &str| {
        assert!(SOURCES.contains(from) || ZONES.contains(from), "{from}");
        let dir = case_with(&SOURCES.replace(from, to));
        put(dir.path(), "system/topoSetDict", &ZONES.replace(from, to));
        load_errors(dir.path())
    };
    assert!(said("cellZone left", "cellZone lefd").contains("did you mean `left`?"));
    assert!(said("(0.5 2 1)", "(-0.5 2 1)").contains("the zone `left` has no cells"));
    assert!(said("boxToCell", "boxToCel").contains("did you mean `boxToCell`?"));
    assert!(said("cellZone right;", "cellZone right; timeStart 1;").contains("acts all the time"));
    let more = said("source boxToCell;", "source boxToCell; sources boxToCell;");
    assert!(more.contains("unknown entry `sources`") && more.contains("topoSetDict"), "{more}");
    assert!(said("action invert;", "action invert; sett left;").contains("unknown entry `sett`"));
    assert!(said("U ((0 30 0) -0.5);", "").contains("no force is given"));
    assert!(said("-0.5", "0.5").contains("grows with the velocity"));
}

/// A restart whose gradient is lost says that it starts anew.
#[test]
fn a_lost_gradient_is_told() {
    let dir = couette("");
    put(dir.path(), "system/controlDict", "endTime 0.1; deltaT 0.05;");
    let hold = "hold { type meanVelocityForce; selectionMode all; fields (U); Ubar (1 0 0); }";
    put(dir.path(), "constant/fvOptions", hold);
    run(dir.path(), &until(0.1));
    let told = || {
        let (sink, notices) = (granflow_dict::Sink::new(), granflow_case::Notices::new());
        let from = Some(granflow_case::From::Latest);
        let options = granflow_case::Options { from, ..until(0.2) };
        granflow_case::Case::load(dir.path(), &options, &sink, &notices).unwrap();
        notices.take().join("\n")
    };
    assert!(!told().contains("holdProperties"), "{}", told());
    std::fs::remove_file(dir.path().join("0.1/uniform/holdProperties")).unwrap();
    assert!(told().contains("0.1/uniform/holdProperties is not there"), "{}", told());
}

#[test]
fn a_topo_set_that_nobody_asks_for_is_not_read() {
    let dir = cavity_case(4);
    put(
        dir.path(),
        "system/topoSetDict",
        "actions ( { name a; type cellSet; action new; source b; } );",
    );
    run(dir.path(), &until(0.01));
}
