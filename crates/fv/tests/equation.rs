//! Equations as data: what they say when they are wrong, how they print, and that the matrix is
//! the sum over faces that it stands for, slip walls and doubled faces included.

#![allow(
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::type_complexity,
    reason = "tests print what they measured, loops name their faces"
)]

mod common;

use common::*;
use granflow_base::{Dims, Value, Vec3, dot, norm, scale, sub};
use granflow_fv::conditions::{FixedValue, OfPatchType, Slip, ZeroGradient};
use granflow_fv::{
    CellField, Condition, Ddt, Differentiable, Equation, FaceField, Terms, Unknown, ddt, div,
    div_explicit, laplacian, operators, source, sp,
};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;

struct Parts {
    rho: CellField<f64>,
    flux: FaceField<f64>,
    weights: FaceField<f64>,
    eta: FaceField<f64>,
    nu: FaceField<f64>,
    stress: FaceField<Vec3>,
    force: CellField<Vec3>,
    drag: CellField<f64>,
    old: Vec<Vec3>,
}

/// Fields without pattern, reproducible.
fn parts(m: &Mesh) -> Parts {
    let noise = |i: usize, k: f64| ((i as f64 + 1.0) * k).sin();
    let face = |name: &str, dims, k: f64, mean: f64| {
        let mut x = FaceField::new(m, name, dims, 0.0);
        (0..m.n_faces()).for_each(|f| x.data[f] = mean + noise(f, k));
        x
    };
    let mut flux = face("rhoPhi", Dims::MASS_FLUX, 0.77, 0.0);
    // Nothing flows through boundary faces: slip walls are among them.
    flux.data[m.n_inner..].fill(0.0);
    let mut weights = face("w", Dims::NONE, 1.3, 0.5);
    weights.data.iter_mut().for_each(|w| *w = w.clamp(0.0, 1.0));
    let mut stress = FaceField::new(m, "explicitStress", Dims::FORCE, [0.0; 3]);
    (0..m.n_faces()).for_each(|f| stress.data[f] = [noise(f, 0.3), noise(f, 0.5), noise(f, 0.9)]);
    let mut force = CellField::new(m, "rhoG", Dims::DENSITY.mul(Dims::ACCELERATION), [0.0; 3]);
    (0..m.n_cells).for_each(|c| force.data[c] = [noise(c, 0.2), 1.0, noise(c, 0.4)]);
    Parts {
        rho: CellField::new(m, "rho", Dims::DENSITY, 1.5),
        flux,
        weights,
        eta: face("eta", Dims::VISCOSITY, 0.21, 2.0),
        nu: face("nu", Dims::KINEMATIC_VISCOSITY, 0.21, 2.0),
        stress,
        force,
        drag: CellField::new(m, "drag", Dims::DENSITY.div(Dims::TIME), 0.3),
        old: (0..m.n_all()).map(|c| [noise(c, 0.6), noise(c, 0.7), noise(c, 0.8)]).collect(),
    }
}

impl Parts {
    fn ddt(&self) -> Ddt<'_, Vec3> {
        Ddt {
            rho: &self.rho,
            rho_old: &self.rho,
            old: &self.old,
            older: &self.old,
            dt: 0.1,
            c: [1.5, 2.0, 0.5],
        }
    }
    fn momentum(&self) -> Terms<'_, Vec3> {
        ddt(self.ddt()) + div(&self.flux, &self.weights) + sp(&self.drag)
            - laplacian(&self.eta)
            - div_explicit(&self.stress)
            - source(&self.force)
    }
}

/// A velocity without pattern.
fn velocity(
    exec: &Exec,
    m: &Mesh,
    condition: impl Fn(&str) -> Box<dyn Condition<Vec3>>,
) -> Unknown<Vec3> {
    let conditions: Vec<Box<dyn Condition<Vec3>>> =
        m.patches.iter().map(|p| of_kind(&p.kind).unwrap_or_else(|| condition(&p.name))).collect();
    let mut u = Unknown::new(m, "U", Dims::VELOCITY, [0.0; 3], conditions);
    for c in 0..m.n_cells {
        let x = c as f64;
        u.cells.data[c] = [(1.1 * x).sin(), (0.4 * x + 1.0).cos(), (0.9 * x).sin()];
    }
    update(exec, m, &mut u);
    u
}

#[test]
fn wrong_dimensions_name_both_terms() {
    let exec = Exec::serial();
    let m = mesh(&shapes::unit_box([2; 3]));
    let p = parts(&m);
    let u = velocity(&exec, &m, |_| Box::new(ZeroGradient));
    let mut eqn = Equation::new(&exec, &m);
    // The kinematic viscosity in a dynamic equation: the classical slip of the pen.
    let wrong = ddt(p.ddt()) + div(&p.flux, &p.weights) - laplacian(&p.nu);
    let error = eqn.assemble(&exec, &m, &u, &wrong).expect_err("m2/s is not Pa s");
    let text = error.to_string();
    println!("{text}");
    for part in ["`U`", "ddt(rho)", "laplacian(nu)"] {
        assert!(text.contains(part), "`{part}` is missing from: {text}");
    }
    assert!(text.contains(&error.first_dims.to_string()));
    assert!(text.contains(&error.other_dims.to_string()));
    assert_eq!(error.first_dims, Dims::FORCE);
    assert_eq!(error.other_dims, Dims::FORCE.div(Dims::DENSITY));
    let weightless = CellField::new(&m, "g", Dims::ACCELERATION, [0.0; 3]);
    let wrong = ddt(p.ddt()) - source(&weightless);
    let error = eqn.assemble(&exec, &m, &u, &wrong).expect_err("not a force density");
    assert!(error.to_string().contains("g is"), "{error}");
    // And nothing is refused that is right.
    eqn.assemble(&exec, &m, &u, &p.momentum()).expect("momentum in newtons");
}

#[test]
fn an_equation_prints_as_it_is_written() {
    let m = mesh(&shapes::unit_box([1; 3]));
    let p = parts(&m);
    assert_eq!(
        p.momentum().to_string(),
        "ddt(rho) + div(rhoPhi) + sp(drag) - laplacian(eta) - div(explicitStress) - rhoG = 0"
    );
    let one: Terms<'_, Vec3> = -laplacian(&p.eta);
    assert_eq!(one.to_string(), "-laplacian(eta) = 0");
}

/// The equation's imbalance in every cell by a plain loop over faces.
fn by_hand<T: Differentiable>(
    m: &Mesh,
    p: &Parts,
    u: &Unknown<T>,
    old: &[T],
    stress: &FaceField<T>,
    force: &CellField<T>,
) -> Vec<T> {
    (0..m.n_cells)
        .map(|c| {
            let here = u.cells.data[c];
            let bdf = here.scaled(1.5).minus(old[c].scaled(2.0)).plus(old[c].scaled(0.5));
            let mut sum = bdf.scaled(1.5 * m.volume[c] / 0.1);
            sum = sum.axpy(0.3 * m.volume[c], here).axpy(-m.volume[c], force.data[c]);
            for (f, s) in m.faces_of(c) {
                let value = if f < m.n_inner {
                    let w = p.weights.data[f];
                    let n = u.cells.data[m.neighbour[f] as usize];
                    u.cells.data[m.owner[f] as usize].scaled(w).axpy(1.0 - w, n)
                } else {
                    u.boundary_value(m, f)
                };
                sum = sum.axpy(s * p.flux.data[f], value);
                let dn = operators::normal_derivative(m, u, None, f);
                sum = sum.axpy(-s * p.eta.data[f] * m.mag_area[f], dn);
                sum = sum.axpy(-s, stress.data[f]);
            }
            sum
        })
        .collect()
}

/// Every kind of patch and coupling.
fn zoo() -> Vec<(&'static str, PolyMesh)> {
    let periodic = |n, along| shapes::periodic_box(n, along);
    let sides = [PatchKind::Wall, PatchKind::Wall, PatchKind::Symmetry, PatchKind::Patch];
    vec![
        ("leaning", leaning([3, 4, 2])),
        ("displaced", shapes::displaced(&shapes::unit_box([3, 4, 5]), 0.2, 5)),
        ("prisms", shapes::prism_box([2; 3], [0.0; 3], [1.0; 3], shapes::all(PatchKind::Wall))),
        ("one cell thick", periodic([1, 4, 3], [true; 3])),
        ("two cells thick", periodic([2, 4, 3], [true, false, true])),
        ("one cell", periodic([1, 1, 1], [true; 3])),
        ("two cells", periodic([2, 1, 1], [true; 3])),
        ("plane", shapes::plane_mesh([4, 3], [0.0; 2], [1.0; 2], sides)),
        ("wedge", shapes::wedge_ring(0.0, 1.0, 1.0, 4, 3, 0.04)),
        ("ring", shapes::wedge_ring(0.5, 1.0, 1.0, 4, 3, 0.04)),
        ("sector", shapes::annular_sector(0.5, 1.0, [3, 2, 2], 6)),
        ("thin sector", shapes::annular_sector(0.5, 1.0, [3, 1, 2], 6)),
    ]
}

#[test]
fn the_matrix_is_the_sum_over_faces() {
    let exec = Exec::serial();
    for (name, poly) in zoo() {
        let m = mesh(&poly);
        let p = parts(&m);
        let conditions: [(&str, fn() -> Box<dyn Condition<Vec3>>); 3] = [
            ("slip", || Box::new(Slip)),
            ("fixed", || Box::new(FixedValue::uniform([1.0, 2.0, 3.0]))),
            ("free", || Box::new(ZeroGradient)),
        ];
        for (condition, make) in conditions {
            let mut u = velocity(&exec, &m, |_| make());
            let want = by_hand(&m, &p, &u, &p.old, &p.stress, &p.force);
            let mut eqn = Equation::new(&exec, &m);
            eqn.assemble(&exec, &m, &u, &p.momentum()).expect("consistent dimensions");
            let mut r = vec![[0.0; 3]; m.n_cells];
            eqn.a.residual(&exec, &eqn.b, &mut u.cells.data, &mut r);
            for c in 0..m.n_cells {
                let (got, want) = (scale(r[c], -1.0), want[c]);
                let off = norm(sub(got, want)) / norm(want).max(1e-3);
                assert!(off < 1e-9, "{name}, {condition}, cell {c}: {got:?}, not {want:?}");
            }
        }
    }
}

#[test]
fn jacobi_of_the_solution_is_the_solution() {
    let exec = Exec::serial();
    for (name, poly) in zoo() {
        let m = mesh(&poly);
        let p = parts(&m);
        let mut u = velocity(&exec, &m, |_| Box::new(Slip));
        let mut eqn = Equation::new(&exec, &m);
        eqn.assemble(&exec, &m, &u, &p.momentum()).expect("consistent dimensions");
        // The residual of a row over its diagonal is what one Jacobi sweep changes.
        let mut r = vec![[0.0; 3]; m.n_cells];
        eqn.a.residual(&exec, &eqn.b, &mut u.cells.data, &mut r);
        let mut next = vec![[0.0; 3]; m.n_cells];
        eqn.jacobi(&exec, &u.cells.data, &mut next);
        for c in 0..m.n_cells {
            let d = eqn.a.val[eqn.a.diag[c] as usize];
            let want = u.cells.data[c].axpy(1.0 / d, r[c]);
            let off = norm(sub(next[c], want)) / (1.0 + norm(want));
            assert!(off < 1e-10, "{name}, cell {c}: {:?}, not {want:?}", next[c]);
        }
    }
}

#[test]
fn slip_walls_hold_the_normal_part_only() {
    let exec = Exec::serial();
    // A leaning box: the walls' normals are no coordinate axes.
    let m = mesh(&leaning([1, 1, 1]));
    let eta = FaceField::new(&m, "eta", Dims::VISCOSITY, 1.0);
    let mut u = velocity(&exec, &m, |patch| match patch {
        "xMax" => Box::new(Slip),
        _ => Box::new(ZeroGradient),
    });
    let face = m.patches[m.patch("xMax").expect("xMax")].faces.start;
    let n = m.normal(face);
    assert!(n[0] < 0.99, "the wall leans");
    let mut eqn = Equation::new(&exec, &m);
    eqn.assemble(&exec, &m, &u, &-laplacian(&eta)).expect("one term");
    let strength = m.mag_area[face] * m.inv_dist[face];
    let along = granflow_base::unit(granflow_base::cross(n, [0.0, 0.3, 1.0]));
    for (value, want) in [(n, scale(n, strength)), (along, [0.0; 3])] {
        u.cells.data[0] = value;
        let mut out = vec![[0.0; 3]; m.n_cells];
        eqn.a.apply(&exec, &mut u.cells.data, &mut out);
        assert!(norm(sub(out[0], want)) < 1e-12 * strength, "{value:?}: {:?}", out[0]);
    }
    u.cells.data[0] = [0.3, 0.5, -0.2];
    assert!(dot(u.boundary_value(&m, face), n).abs() < 1e-15, "nothing flows through");
    // Symmetry planes do the same.
    let symmetric: Box<dyn Condition<Vec3>> =
        Box::new(OfPatchType { kind: "symmetry", symmetric: true });
    let mut conditions = vec![symmetric];
    conditions.extend((1..6).map(|_| Box::new(ZeroGradient) as Box<dyn Condition<Vec3>>));
    let mut u = Unknown::new(&m, "U", Dims::VELOCITY, [0.3, 0.5, -0.2], conditions);
    update(&exec, &m, &mut u);
    let face = m.patches[0].faces.start;
    assert!(dot(u.boundary_value(&m, face), m.normal(face)).abs() < 1e-15);
}

#[test]
fn two_faces_between_the_same_cells_share_an_entry() {
    let exec = Exec::serial();
    let one = |m: &Mesh| FaceField::new(m, "one", Dims::VISCOSITY, 1.0);
    // Two cells, periodic: each sees the other across two faces, one of them through a ghost.
    let m = mesh(&shapes::periodic_box([2, 1, 1], [true; 3]));
    let mut eqn = Equation::<f64>::new(&exec, &m);
    let phi = unknown(&exec, &m, |p| p[0], |_, _| Box::new(ZeroGradient));
    let scalar = |m: &Mesh| {
        let mut f = one(m);
        f.dims = Dims::NONE;
        f
    };
    eqn.assemble(&exec, &m, &phi, &-laplacian(&scalar(&m))).expect("one term");
    for row in 0..2 {
        let entries: Vec<u32> =
            eqn.a.col[eqn.a.ptr[row] as usize..eqn.a.ptr[row + 1] as usize].to_vec();
        let mut distinct = entries.clone();
        distinct.dedup();
        assert_eq!(entries, distinct, "columns are sorted and occur once");
    }
    // Faces of area 1 between centres 1/2 apart, twice: 4 (phi0 - phi1); y and z faces cancel.
    let (mut x, mut y) = (phi.cells.data.clone(), vec![0.0; 2]);
    eqn.a.apply(&exec, &mut x, &mut y);
    assert!((y[0] - 4.0 * (x[0] - x[1])).abs() < 1e-12 && (y[0] + y[1]).abs() < 1e-12, "{y:?}");
    // One cell, periodic: its own neighbour everywhere.
    let m = mesh(&shapes::periodic_box([1, 1, 1], [true; 3]));
    let phi = unknown(&exec, &m, |_| 3.0, |_, _| Box::new(ZeroGradient));
    let mut eqn = Equation::<f64>::new(&exec, &m);
    eqn.assemble(&exec, &m, &phi, &-laplacian(&scalar(&m))).expect("one term");
    let (mut x, mut y) = (phi.cells.data.clone(), vec![1.0; 1]);
    eqn.a.apply(&exec, &mut x, &mut y);
    assert_eq!(y, [0.0]);
    assert_eq!(eqn.row_sum, [0.0]);
}
