//! Two fluids: no allocation after the second step.

#[path = "common/counting.rs"]
mod counting;
mod two_common;

use counting::ALLOCATIONS;
use granflow_flow::vof::Shape;
use two_common::*;

#[test]
fn no_allocation_after_the_second_step() {
    let mut poly = tank([16, 12], [0.0; 2], [0.4, 0.3]);
    // Aslant, so that levels are looked for.
    poly.points.iter_mut().for_each(|p| p[1] += 0.2 * p[0]);
    for geometric in [false, true] {
        let mut two = water_and_air(&poly, Shape::cuboid([-1.0; 3], [0.15, 0.2, 1.0]));
        (two.geometric, two.sigma, two.numerics.predictor) = (geometric, 0.07, true);
        let mut flow = two.flow(|_| wall());
        for _ in 0..2 {
            flow.step(1e-3).expect("a step");
        }
        let before = ALLOCATIONS.get();
        for _ in 0..20 {
            flow.step(1e-3).expect("a step");
        }
        assert_eq!(ALLOCATIONS.get() - before, 0, "geometric {geometric}");
    }
}
