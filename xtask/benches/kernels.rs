//! ns per cell of the kernels that a time step is made of, one JSON object a line; `cargo xtask
//! bench kernels` runs this and prints a table.

#![expect(clippy::print_stdout, reason = "its output is its product")]

use granflow_base::{Dims, Vec3};
use granflow_fv::conditions::{FixedValue, ZeroGradient};
use granflow_fv::{
    CellField, Condition, Convection, Ddt, Differentiable, Equation, FaceField, Gradient,
    LeastSquares, LimiterKind, Reconstruction, Surroundings, Unknown, ddt, div, div_explicit,
    laplacian, operators, source,
};
use granflow_linsolve::{Tolerance, gamg};
use granflow_mesh::{Mesh, shapes};
use granflow_par::{Exec, Solo};
use std::error::Error;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for n in [32, 100] {
        let mesh = Mesh::new(&shapes::unit_box([n; 3]))?;
        measure(&Exec::serial(), &mesh)?;
        if cores > 1 {
            measure(&Exec::new(cores, Box::new(Solo)), &mesh)?;
        }
    }
    Ok(())
}

/// Median time of one call, over batches long enough for the clock.
fn report(exec: &Exec, mesh: &Mesh, kernel: &str, mut call: impl FnMut()) {
    call();
    let begun = Instant::now();
    call();
    let once = begun.elapsed().max(Duration::from_nanos(100));
    let calls =
        (Duration::from_millis(40).as_secs_f64() / once.as_secs_f64()).ceil().max(1.0) as usize;
    let mut batches: Vec<f64> = (0..7)
        .map(|_| {
            let begun = Instant::now();
            (0..calls).for_each(|_| call());
            begun.elapsed().as_nanos() as f64 / calls as f64
        })
        .collect();
    batches.sort_by(f64::total_cmp);
    let (cells, threads, ns) = (mesh.n_cells, exec.threads(), batches[3] / mesh.n_cells as f64);
    println!(
        "{{\"kernel\":\"{kernel}\",\"cells\":{cells},\"threads\":{threads},\"ns_per_cell\":{ns:.3}}}"
    );
}

/// A field with its first patch fixed and the others free.
fn unknown<T: Differentiable>(
    exec: &Exec,
    mesh: &Mesh,
    dims: Dims,
    at: impl Fn(Vec3) -> T,
) -> Unknown<T> {
    let condition = |patch: usize| -> Box<dyn Condition<T>> {
        if patch == 0 { Box::new(FixedValue::uniform(T::ZERO)) } else { Box::new(ZeroGradient) }
    };
    let conditions = (0..mesh.patches.len()).map(condition).collect();
    let mut phi = Unknown::new(mesh, "phi", dims, T::ZERO, conditions);
    for (v, x) in phi.cells.data.iter_mut().zip(&mesh.cell_centre) {
        *v = at(*x);
    }
    phi.update(exec, mesh, &Surroundings::default(), None);
    phi
}

fn measure(exec: &Exec, mesh: &Mesh) -> Result<(), Box<dyn Error>> {
    let all = mesh.n_cells + mesh.n_ghosts;
    let wave = |x: Vec3| (5.0 * x[0]).sin() * (4.0 * x[1]).cos() + x[2];
    let p = unknown(exec, mesh, Dims::PRESSURE, wave);
    let u = unknown(exec, mesh, Dims::VELOCITY, |x| [wave(x), -x[1], x[0] * x[2]]);
    let rho = CellField::new(mesh, "rho", Dims::DENSITY, 1500.0);
    let eta = FaceField::new(mesh, "eta", Dims::VISCOSITY, 3.0);
    let mut rho_phi = FaceField::new(mesh, "rhoPhi", Dims::MASS_FLUX, 0.0);
    operators::flux(exec, mesh, &u, &u.cells.data, &mut rho_phi);
    let body =
        CellField::new(mesh, "rhoG", Dims::DENSITY.mul(Dims::ACCELERATION), [0.0, 0.0, -1.0]);
    let mut explicit = FaceField::new(mesh, "explicit", Dims::FORCE, [0.0; 3]);
    let mut weights = FaceField::new(mesh, "weights", Dims::NONE, 0.5);
    let mut correction = FaceField::new(mesh, "correction", Dims::FORCE, [0.0; 3]);
    let mut grad_p = vec![[0.0; 3]; all];
    let mut grad_u = vec![[0.0; 9]; all];
    let least_squares = Gradient::LeastSquares(LeastSquares::new(mesh));
    let van_leer = Convection::Limited(LimiterKind::parse("vanLeer", 1.0).ok_or("vanLeer")?);
    let reconstruction = Reconstruction::new(mesh);
    let mut stress = vec![[0.0; 9]; all];

    report(exec, mesh, "gradient of a scalar, Gauss linear", || {
        Gradient::GaussLinear.of(exec, mesh, &p, &mut grad_p);
    });
    report(exec, mesh, "gradient of a vector, Gauss linear", || {
        Gradient::GaussLinear.of(exec, mesh, &u, &mut grad_u);
    });
    report(exec, mesh, "gradient of a vector, least squares", || {
        least_squares.of(exec, mesh, &u, &mut grad_u);
    });
    report(exec, mesh, "convection weights, vanLeer", || {
        van_leer.weigh(exec, mesh, &u, &grad_u, &rho_phi.data, &mut weights, &mut correction);
    });
    report(exec, mesh, "transpose part of the viscous stress", || {
        operators::transpose_stress_flux(exec, mesh, &u, &grad_u, &eta, &mut explicit);
    });
    report(exec, mesh, "mean viscous stress of the cells", || {
        reconstruction.viscous_stress(exec, mesh, &u, &grad_u, &eta, &mut stress);
    });

    let mut momentum = Equation::<Vec3>::new(exec, mesh);
    let old = &u.cells.data;
    let inertia = Ddt { rho: &rho, rho_old: &rho, old, older: old, dt: 1e-3, c: [1.0, 1.0, 0.0] };
    let mut assembled = Ok(());
    report(exec, mesh, "assembly of momentum", || {
        let terms = ddt(inertia) + div(&rho_phi, &weights)
            - laplacian(&eta)
            - div_explicit(&explicit)
            - source(&body);
        assembled = momentum.assemble(exec, mesh, &u, &terms);
    });
    assembled?;
    let (mut x, mut y) = (u.cells.data.clone(), u.cells.data.clone());
    report(exec, mesh, "matrix times vector field", || momentum.a.apply(exec, &mut x, &mut y));

    let mut poisson = Equation::<f64>::new(exec, mesh);
    poisson.assemble(exec, mesh, &p, &-laplacian(&eta))?;
    let (mut x, mut y) = (p.cells.data.clone(), p.cells.data.clone());
    report(exec, mesh, "matrix times scalar field", || poisson.a.apply(exec, &mut x, &mut y));
    let mut solver = gamg::<f64>();
    let mut outcome = solver.refresh(exec, &poisson.a);
    outcome?;
    report(exec, mesh, "multigrid, refresh of the numbers", || {
        outcome = solver.refresh(exec, &poisson.a);
    });
    outcome?;
    // What a pressure correction asks for, and a full solve.
    for (what, abs) in [("multigrid, solve to 1e-2", 1e-2), ("multigrid, solve to 1e-8", 1e-8)] {
        let tolerance = Tolerance { abs, rel: 0.0, max_iter: 200 };
        let b: Vec<f64> = mesh.cell_centre[..mesh.n_cells]
            .iter()
            .map(|x| (9.0 * x[0] + 7.0 * x[1]).sin())
            .collect();
        let mut solved = Ok(());
        report(exec, mesh, what, || {
            x.fill(0.0);
            solved = solver.solve(exec, &poisson.a, &b, &mut x, &tolerance).map(drop);
        });
        solved?;
    }
    Ok(())
}
