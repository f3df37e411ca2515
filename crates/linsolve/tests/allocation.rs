//! Repeated solves of one size allocate nothing.

#![allow(clippy::unwrap_used)]

mod problems;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use granflow_base::{Value, Vec3};
use granflow_linsolve::{Csr, SolverSpec, Tolerance, build};
use granflow_par::{Exec, Solo};
use problems::*;

struct Counting;
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
// SAFETY: forwards to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, l: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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

fn second_solve<T: Value>(exec: &Exec, a: &Csr, b: &[T], words: (&str, &str, &str)) -> usize {
    let spec = SolverSpec {
        solver: words.0.into(),
        preconditioner: Some(words.1.into()),
        smoother: Some(words.2.into()),
    };
    let mut s = build::<T>(&spec).unwrap();
    let tol = Tolerance { abs: 1e-6, rel: 0.0, max_iter: 50 };
    let mut x = vec![T::ZERO; a.cols()];
    let mut counted = 0;
    for _ in 0..2 {
        x.fill(T::ZERO);
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        s.refresh(exec, a).unwrap();
        let done = s.solve(exec, a, b, &mut x, &tol);
        counted = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert!(done.is_ok(), "{words:?} {done:?}");
    }
    counted
}

/// One test, so that no other thread allocates meanwhile.
#[test]
fn a_second_refresh_and_solve_allocate_nothing() {
    let g = Grid { n: [24, 22, 20], fixed: true, periodic: true };
    let mut a = matrix(g, |_| 1.0, [1.0; 3], 0.5);
    let pressure = interface(g);
    (0..a.rows()).for_each(|i| a.val[a.diag[i] as usize] += 5.0);
    let b = rhs(a.rows());
    let v: Vec<Vec3> = b.iter().map(|&b| [b, -b, 2.0 * b]).collect();
    for threads in [1, 2] {
        let exec = Exec::new(threads, Box::new(Solo));
        for words in [
            ("GAMG", "none", "DIC"),
            ("PBiCGStab", "DILU", "DIC"),
            ("smoothSolver", "none", "symGaussSeidel"),
            ("smoothSolver", "none", "DILU"),
            ("diagonal", "none", "DIC"),
        ] {
            assert_eq!(second_solve(&exec, &a, &b, words), 0, "{words:?} {threads}");
            assert_eq!(second_solve(&exec, &a, &v, words), 0, "vectors {words:?} {threads}");
        }
        for words in [("GAMG", "none", "DIC"), ("PCG", "GAMG", "DIC")] {
            assert_eq!(second_solve(&exec, &pressure, &b, words), 0, "{words:?} {threads}");
        }
    }
    rebuilds_allocate_nothing();
}

/// Values that jump between two matrices, so that each needs aggregates of its own.
fn rebuilds_allocate_nothing() {
    let exec = Exec::serial();
    let g = Grid { n: [24, 22, 20], fixed: true, periodic: false };
    let (mut a, b) = (laplacian(g), rhs(g.cells()));
    let values =
        [matrix(g, |_| 1.0, [1.0, 1.0, 1e4], 0.0), matrix(g, |_| 1.0, [1e4, 1.0, 1.0], 0.0)];
    let spec = SolverSpec { solver: "GAMG".into(), ..SolverSpec::default() };
    let mut s = build::<f64>(&spec).unwrap();
    let tol = Tolerance { abs: 1e-8, rel: 0.0, max_iter: 400 };
    let mut x = vec![0.0; a.cols()];
    for round in 0..4 {
        for (k, new) in values.iter().enumerate() {
            a.val.clone_from(&new.val);
            let before = ALLOCATIONS.load(Ordering::Relaxed);
            let iterations = [0, 1].map(|_| {
                s.refresh(&exec, &a).unwrap();
                x.fill(0.0);
                s.solve(&exec, &a, &b, &mut x, &tol).unwrap().iterations
            });
            let counted = ALLOCATIONS.load(Ordering::Relaxed) - before;
            // Slow with the aggregates of the other matrix, fast after a rebuild.
            let rebuilt = iterations[0] > 60 && iterations[1] < 30;
            assert!(rebuilt || (round, k) == (0, 0), "{round} {k} {iterations:?}");
            assert!(counted == 0 || round < 1, "{round} {k}: {counted} allocations");
        }
    }
}
