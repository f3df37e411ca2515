//! Cases that compute: from dictionaries to time directories and back.
#![allow(clippy::unwrap_used)]

mod common;
use common::*;

#[test]
fn a_cavity_runs_and_writes() {
    let dir = cavity_case(8);
    let run = run(dir.path(), &until(0.1));
    assert!((run.time() - 0.1).abs() < 1e-12);
    let u = read(dir.path(), "0.1/U");
    assert!(u.contains("nonuniform List<vector>"), "{u}");
    assert!(u.contains("noSlip"), "{u}");
    for f in ["0.05/U", "0.1/p", "0.1/phi", "0.1/strainRate", "0.1/viscosity", "0.1/uniform/time"] {
        assert!(dir.path().join(f).exists(), "{f}");
    }
}

#[test]
fn restart_is_exact_to_the_last_bit() {
    let whole = cavity_case(8);
    run(whole.path(), &until(0.1));
    let halves = copy(whole.path());
    run(halves.path(), &until(0.05));
    run(halves.path(), &until(0.1));
    assert_same(whole.path(), halves.path(), "0.1");
}
