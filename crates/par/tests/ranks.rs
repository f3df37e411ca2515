//! Sums, halos and allocation across threads and in-process ranks.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use granflow_base::{Vec3, rotation_about};
use granflow_par::{Exec, Halo, InProcess, Link, Solo};
use proptest::prelude::*;

struct Counting;
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
thread_local! { static WATCHED: std::cell::Cell<bool> = const { std::cell::Cell::new(false) }; }
// SAFETY: forwards to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, l: Layout) -> *mut u8 {
        if WATCHED.with(std::cell::Cell::get) {
            ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        }
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

fn on_ranks<R: Send>(n: usize, threads: usize, f: impl Fn(Exec) -> R + Sync) -> Vec<R> {
    std::thread::scope(|s| {
        let f = &f;
        let ranks = InProcess::world(n);
        let run = |c| s.spawn(move || f(Exec::new(threads, Box::new(c))));
        let ranks: Vec<_> = ranks.into_iter().map(run).collect();
        ranks.into_iter().map(|r| r.join().expect("rank")).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn sums_do_not_depend_on_threads(n in 0usize..40_000, seed in 0u64..1000) {
        let x: Vec<f64> = (0..n)
            .map(|i| ((i as f64 + seed as f64) * 12.9898).sin() * 10f64.powi((i % 30) as i32 - 15))
            .collect();
        let v: Vec<Vec3> = x.iter().map(|&x| [x, 2.0 * x, -x]).collect();
        let all = |threads| {
            let e = Exec::new(threads, Box::new(Solo));
            let s = e.sums(n, |r| [x[r.clone()].iter().sum(), x[r].iter().map(|x| x * x).sum()]);
            [s[0].to_bits(), s[1].to_bits(), e.dot(&x, &x).to_bits(), e.dot(&v, &v).to_bits()]
        };
        let one = all(1);
        prop_assert_eq!(one, all(2));
        prop_assert_eq!(one, all(3));
        let exact: f64 = x.iter().map(|x| x * x).sum();
        prop_assert!((f64::from_bits(one[2]) - exact).abs() <= 1e-12 * exact);
    }
}

#[test]
fn a_ring_of_ranks_sees_its_neighbours_and_settles_without_allocation() {
    let turn = rotation_about([0.0, 0.0, 1.0], 0.3);
    let sums = on_ranks(3, 2, |exec| {
        let (me, n) = (exec.rank(), 3000usize);
        // Two ghosts: the last cell of the rank before and the first of the rank after, turned.
        let before = (me + 2) % 3;
        let after = (me + 1) % 3;
        let halo = Halo::new(vec![
            Link { rank: before, send: vec![0], recv: n..n + 1, rotation: Some(turn) },
            Link { rank: after, send: vec![n as u32 - 1], recv: n + 1..n + 2, rotation: None },
        ]);
        let mut x: Vec<Vec3> = (0..n + 2).map(|i| [(me * n + i) as f64, 1.0, 0.0]).collect();
        let mut total = 0.0;
        for round in 0..20 {
            // The first rounds fill the buffers of all ranks.
            WATCHED.with(|w| w.set(round >= 10));
            halo.update(&exec, &mut x);
            total = exec.dot(&x, &x[..n]);
        }
        WATCHED.with(|w| w.set(false));
        let last = [(before * n + n - 1) as f64, 1.0, 0.0];
        let expect = granflow_base::apply(&turn, last);
        assert!(granflow_base::norm(granflow_base::sub(x[n], expect)) < 1e-9);
        assert_eq!(x[n + 1], [(after * n) as f64, 1.0, 0.0]);
        total
    });
    assert!(sums.iter().all(|s| s.to_bits() == sums[0].to_bits()));
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed), 0);
}
