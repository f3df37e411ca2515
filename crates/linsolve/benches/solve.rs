//! Multigrid on the project's matrices, ns per unknown: `cargo bench -p granflow-linsolve`, with
//! words to choose problems by their names (`cargo bench -p granflow-linsolve -- constant`).
//!
//! With one thread the processor time of the thread is counted where the system tells it, so that
//! other work on the machine disturbs less; with more the wall clock. Fastest of a few runs.
#![expect(clippy::print_stdout, reason = "its output is its product")]
#![expect(clippy::unwrap_used, reason = "a problem that is not solved is not worth timing")]

#[path = "../tests/problems/mod.rs"]
mod problems;

use std::time::{Duration, Instant};

use granflow_linsolve::{Csr, Tolerance, gamg};
use granflow_par::{Exec, Solo};
use problems::*;

type Maker = fn(Grid) -> Csr;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with('-')).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|w| name.contains(w.as_str()));
    println!(
        "{:18} {:>8} {:>7} {:>7} {:>7} {:>7} {:>10} {:>7} {:>7} {:>7}",
        "",
        "rows",
        "threads",
        "matvec",
        "set-up",
        "refresh",
        "iterations",
        "solve",
        "fresh",
        "kept"
    );
    for threads in [1, 2] {
        let exec = Exec::new(threads, Box::new(Solo));
        for side in [46, 100] {
            let g = Grid::cube(side);
            let makers: [(&str, Maker); 4] = [
                ("constant", laplacian),
                ("interface", interface),
                ("viscous", viscous),
                ("thin", thin),
            ];
            for (name, make) in makers.into_iter().filter(|(name, _)| wanted(name)) {
                measure(&exec, name, &make(g));
            }
        }
    }
}

/// Time spent by this thread, or by everybody when there are several.
fn now(exec: &Exec, begun: Instant) -> Duration {
    let cpu = || {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
    };
    let wall = begun.elapsed();
    if exec.threads() > 1 { wall } else { cpu().unwrap_or(wall) }
}

/// Fastest of some calls, ns per row.
fn fastest(exec: &Exec, rows: usize, calls: usize, mut call: impl FnMut()) -> f64 {
    let begun = Instant::now();
    let once = |call: &mut dyn FnMut()| {
        let before = now(exec, begun);
        call();
        (now(exec, begun) - before).as_nanos() as f64 / rows as f64
    };
    (0..calls).map(|_| once(&mut call)).fold(f64::INFINITY, f64::min)
}

fn measure(exec: &Exec, name: &str, a: &Csr) {
    let n = a.rows();
    let b = rhs(n);
    let (mut x, mut y) = (vec![0.0; a.cols()], vec![0.0; n]);
    let tolerance = Tolerance { abs: 1e-8, rel: 0.0, max_iter: 200 };
    let calls = if n < 200_000 { 9 } else { 4 };
    // Long enough for the clock of the scheduler.
    let many = 20_000_000 / n;
    let matvec = fastest(exec, n * many, 2, || {
        (0..many).for_each(|_| a.apply(exec, &mut x, &mut y));
    });
    let mut solver = gamg::<f64>();
    let setup = fastest(exec, n, calls, || {
        solver = gamg::<f64>();
        solver.refresh(exec, a).unwrap();
    });
    let refresh = fastest(exec, n, calls, || solver.refresh(exec, a).unwrap());
    let mut iterations = 0;
    let solve = fastest(exec, n, calls, || {
        x.fill(0.0);
        iterations = solver.solve(exec, a, &b, &mut x, &tolerance).unwrap().iterations;
    });
    println!(
        "{name:18} {n:8} {:7} {matvec:7.1} {setup:7.0} {refresh:7.0} {iterations:10} {solve:7.0} \
         {:7.0} {:7.0}",
        exec.threads(),
        setup + solve,
        refresh + solve
    );
}
