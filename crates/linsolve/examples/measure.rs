//! tmp
#[path = "../tests/problems/mod.rs"]
mod problems;
use granflow_linsolve::*;
use granflow_par::*;
use problems::*;
use std::time::Instant;
fn main() {
    let arg: Vec<String> = std::env::args().collect();
    let threads: usize = arg[1].parse().unwrap();
    let names: Vec<&str> = arg[3].split(',').collect();
    let exec = Exec::new(threads, Box::new(Solo));
    for m in arg[2].split(',') {
        let m: usize = m.parse().unwrap();
        let g = Grid::cube(m);
        let n = g.cells();
        for &name in &names {
            let sing = Grid { fixed: false, ..g };
            let a = match name {
                "a" => laplacian(g),
                "b" => interface(g),
                "c" => viscous(g),
                "t" => thin(g),
                "sb" => interface(sing),
                "sc" => viscous(sing),
                "w" => matrix(g, |_| 1.0, [1.0; 3], 3.0),
                _ => laplacian(sing),
            };
            let b = if name.starts_with('s') { balanced(n) } else { rhs(n) };
            let ns = |t: Instant| t.elapsed().as_nanos() as f64 / n as f64;
            let mut x = vec![0.0; n];
            let mut y = vec![0.0; n];
            a.apply(&exec, &mut x, &mut y);
            let t = Instant::now();
            for _ in 0..5 { a.apply(&exec, &mut x, &mut y); }
            let mv = ns(t) / 5.0;
            for solver in arg[4].split(',') {
                let mut s = if solver == "GAMG" { gamg::<f64>() } else {
                    let p: Vec<&str> = solver.split('+').collect();
                    build::<f64>(&SolverSpec { solver: p[0].into(), preconditioner: p.get(1).map(|s| s.to_string()), smoother: p.get(1).map(|s| s.to_string()).filter(|_| p[0] == "smoothSolver") }).unwrap()
                };
                let t = Instant::now();
                s.refresh(&exec, &a).unwrap();
                let setup = ns(t);
                let tol = Tolerance { abs: 1e-8, rel: 0.0, max_iter: 500 };
                x.fill(0.0);
                let first = s.solve(&exec, &a, &b, &mut x, &tol);
                let t = Instant::now();
                s.refresh(&exec, &a).unwrap();
                let refresh = ns(t);
                x.fill(0.0);
                let t = Instant::now();
                let r = s.solve(&exec, &a, &b, &mut x, &tol);
                println!("{name} {m}^3 {solver} thr {threads}: matvec {mv:.1} setup {setup:.0} refresh {refresh:.0} solve {:.0} ns/row, {r:?}", ns(t));
                let _ = first;
            }
        }
    }
}
