//! Two fluids: no allocation after the second step.

mod two_common;

use granflow_flow::vof::Shape;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use two_common::*;

thread_local! {
    /// Allocations of this thread alone: tests run side by side.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;
// SAFETY: forwards to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, l: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's contract.
        unsafe { System.alloc(l) }
    }
    unsafe fn dealloc(&self, p: *mut u8, l: Layout) {
        // SAFETY: the caller's contract.
        unsafe { System.dealloc(p, l) }
    }
}
#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
        let before = ALLOCATIONS.with(Cell::get);
        for _ in 0..20 {
            flow.step(1e-3).expect("a step");
        }
        assert_eq!(ALLOCATIONS.with(Cell::get) - before, 0, "geometric {geometric}");
    }
}
