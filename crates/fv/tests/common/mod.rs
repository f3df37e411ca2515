//! Meshes, fields and small solves for the tests of this crate.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::print_stdout,
    reason = "shared by several test programs"
)]
pub mod manufactured;

use granflow_base::{Dims, Value, Vec3, dot};
use granflow_fv::conditions::{FixedGradient, FixedValue, OfPatchType};
use granflow_fv::{Condition, Differentiable, Equation, FaceField, Surroundings, Terms, Unknown};
use granflow_linsolve::{SolverSpec, Tolerance, build};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;

pub fn mesh(poly: &PolyMesh) -> Mesh {
    Mesh::new(poly).expect("a sound mesh")
}

/// A unit box whose cells lean over: non-orthogonal, not skewed.
pub fn leaning(n: [usize; 3]) -> PolyMesh {
    shapes::mapped_box(n, [0.0; 3], [1.0; 3], shapes::all(PatchKind::Patch), |[x, y, z]| {
        [x + 0.4 * y, y, z + 0.2 * x]
    })
}

/// Meshes of the unit box by name, `n` cells along each side.
pub fn boxes(n: usize) -> Vec<(&'static str, PolyMesh)> {
    let hexes = shapes::unit_box([n; 3]);
    let prisms = shapes::prism_box([n; 3], [0.0; 3], [1.0; 3], shapes::all(PatchKind::Patch));
    vec![
        ("displaced", shapes::displaced(&hexes, 0.2, 7)),
        ("leaning", leaning([n; 3])),
        ("prisms", prisms),
        ("hexahedra", hexes),
    ]
}

pub fn of_kind<T: Value>(kind: &PatchKind) -> Option<Box<dyn Condition<T>>> {
    let symmetric = matches!(kind, PatchKind::Symmetry | PatchKind::SymmetryPlane);
    let kind = match kind {
        PatchKind::Wedge => "wedge",
        PatchKind::Cyclic { .. } => "cyclic",
        PatchKind::Empty => "empty",
        PatchKind::Symmetry => "symmetry",
        PatchKind::SymmetryPlane => "symmetryPlane",
        _ => return None,
    };
    Some(Box::new(OfPatchType { kind, symmetric }))
}

/// A field with the exact values in the cells and conditions patch by patch.
pub fn unknown<T: Differentiable>(
    exec: &Exec,
    m: &Mesh,
    exact: impl Fn(Vec3) -> T,
    condition: impl Fn(&Mesh, usize) -> Box<dyn Condition<T>>,
) -> Unknown<T> {
    let conditions = (0..m.patches.len())
        .map(|p| of_kind(&m.patches[p].kind).unwrap_or_else(|| condition(m, p)))
        .collect();
    let mut phi = Unknown::new(m, "phi", Dims::NONE, T::ZERO, conditions);
    for c in 0..m.n_cells {
        phi.cells.data[c] = exact(m.cell_centre[c]);
    }
    update(exec, m, &mut phi);
    phi
}

pub fn update<T: Differentiable>(exec: &Exec, m: &Mesh, phi: &mut Unknown<T>) {
    phi.update(exec, m, &Surroundings::default(), None);
}

/// The exact value at every face of a patch.
pub fn dirichlet<T: Value>(
    exact: impl Fn(Vec3) -> T,
) -> impl Fn(&Mesh, usize) -> Box<dyn Condition<T>> {
    move |m, p| {
        let values = m.patches[p].faces.clone().map(|f| exact(m.face_centre[f])).collect();
        Box::new(FixedValue::per_face(values))
    }
}

/// The exact outward gradient at every face of a patch.
pub fn neumann(
    gradient: impl Fn(Vec3) -> Vec3,
) -> impl Fn(&Mesh, usize) -> Box<dyn Condition<f64>> {
    move |m, p| {
        let faces = m.patches[p].faces.clone();
        let along = |f| granflow_base::dot(gradient(m.face_centre[f]), m.normal(f));
        Box::new(FixedGradient::new(faces.map(along).collect()))
    }
}

pub fn ones(m: &Mesh) -> FaceField<f64> {
    FaceField::new(m, "one", Dims::NONE, 1.0)
}

/// Solves `terms(phi) = 0` once.
pub fn solve<T: Differentiable>(
    exec: &Exec,
    m: &Mesh,
    eqn: &mut Equation<T>,
    phi: &mut Unknown<T>,
    terms: &Terms<'_, T>,
) {
    eqn.assemble(exec, m, phi, terms).expect("consistent dimensions");
    let spec = SolverSpec {
        solver: "PBiCGStab".into(),
        preconditioner: Some("DILU".into()),
        smoother: None,
    };
    let mut solver = build::<T>(&spec).expect("a known solver");
    let tolerance = Tolerance { abs: 1e-11, rel: 0.0, max_iter: 2000 };
    solver.solve(exec, &eqn.a, &eqn.b, &mut phi.cells.data, &tolerance).expect("a solution");
    update(exec, m, phi);
}

/// Root mean square of `f(c)` over the volume.
pub fn rms(m: &Mesh, f: impl Fn(usize) -> f64) -> f64 {
    let volume: f64 = m.volume[..m.n_cells].iter().sum();
    ((0..m.n_cells).map(|c| m.volume[c] * f(c).powi(2)).sum::<f64>() / volume).sqrt()
}

/// Greatest of `f(c)` over the cells that `take` takes.
pub fn greatest(m: &Mesh, take: impl Fn(usize) -> bool, f: impl Fn(usize) -> f64) -> f64 {
    (0..m.n_cells).filter(|c| take(*c)).map(f).fold(0.0, f64::max)
}

/// Whether a cell has no boundary face.
pub fn inside(m: &Mesh, c: usize) -> bool {
    m.faces_of(c).all(|(f, _)| f < m.n_inner)
}

/// Observed orders under twofold refinement.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// The flux of the uniform velocity `u`.
pub fn uniform_flux(m: &Mesh, u: Vec3) -> FaceField<f64> {
    let mut flux = FaceField::new(m, "phi", Dims::VOLUME_FLUX, 0.0);
    (0..m.n_faces()).for_each(|f| flux.data[f] = dot(u, m.area[f]));
    flux
}
