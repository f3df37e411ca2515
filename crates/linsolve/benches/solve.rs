//! Matrix-vector product and multigrid solves of the project's three matrices:
//! `cargo bench -p granflow-linsolve`; divide by the number of rows for ns per unknown.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/problems/mod.rs"]
mod problems;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use granflow_linsolve::{Tolerance, gamg};
use granflow_par::{Exec, Solo};
use problems::*;

fn solves(c: &mut Criterion) {
    let tol = Tolerance { abs: 1e-8, rel: 0.0, max_iter: 200 };
    for threads in [1, 2] {
        let exec = Exec::new(threads, Box::new(Solo));
        for side in [46, 100] {
            let g = Grid::cube(side);
            let n = g.cells();
            let b = rhs(n);
            for (name, mut a) in [("a", laplacian(g)), ("b", interface(g)), ("c", viscous(g))] {
                let mut group = c.benchmark_group(format!("{name}/{n}/{threads} threads"));
                group.throughput(Throughput::Elements(n as u64)).sample_size(10);
                let (mut x, mut y) = (b.clone(), vec![0.0; n]);
                group.bench_function(BenchmarkId::from_parameter("matvec"), |bench| {
                    bench.iter(|| a.apply(&exec, &mut x, &mut y));
                });
                let mut s = gamg::<f64>();
                s.refresh(&exec, &a).unwrap();
                group.bench_function(BenchmarkId::from_parameter("refresh and solve"), |bench| {
                    bench.iter(|| {
                        a.val[0] *= 1.0 + 1e-15;
                        s.refresh(&exec, &a).unwrap();
                        x.fill(0.0);
                        s.solve(&exec, &a, &b, &mut x, &tol).unwrap()
                    });
                });
                group.finish();
            }
        }
    }
}

criterion_group!(benches, solves);
criterion_main!(benches);
