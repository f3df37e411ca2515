//! Flows built by hand: meshes, materials and numerics for the tests of this crate.
#![allow(dead_code, unreachable_pub)]

use granflow_base::{Dims, Vec3};
use granflow_flow::*;
use granflow_fv::conditions::{FixedValue, OfPatchType, PrghPressure, Slip, ZeroGradient};
use granflow_fv::{Condition, Convection, FaceField, Gradient, Unknown};
use granflow_linsolve::{LinearSolver, SolverSpec, Tolerance, build};
use granflow_mesh::{Mesh, PatchKind, PolyMesh};
use granflow_par::Exec;
use granflow_physics::rheology::{Floors, Form, Granular, Law, Local, Ngf, NgfNumerics, Rheology};
use std::sync::Arc;

pub const BEADS: Granular = Granular {
    mu_s: 0.3819,
    mu_2: 0.6435,
    i0: 0.279,
    d: 0.75e-3,
    rho_s: 2450.0,
    floors: Floors::DEFAULT,
};
pub const A: f64 = 0.48;
pub const RHO_B: f64 = 0.62 * 2450.0;

pub fn solver<T: granflow_base::Value>(name: &str, precond: &str) -> Box<dyn LinearSolver<T>> {
    let spec =
        SolverSpec { solver: name.into(), preconditioner: Some(precond.into()), smoother: None };
    build(&spec).expect("a known solver")
}

pub fn tight() -> Tolerance {
    Tolerance { abs: 1e-14, rel: 1e-13, max_iter: 1000 }
}

/// A system's solver by name, solved tightly.
pub fn solve<T: granflow_base::Value>(name: &str, precond: &str) -> Solve<T> {
    Solve { solver: solver(name, precond), tolerance: tight(), last: tight() }
}

/// The same, each solve only so far as outer iterations make use of.
pub fn solve_loosely<T: granflow_base::Value>(name: &str, precond: &str, rel: f64) -> Solve<T> {
    let loose = Tolerance { abs: 1e-15, rel, max_iter: 300 };
    Solve { solver: solver(name, precond), tolerance: loose, last: loose }
}

pub fn numerics(outer: usize, correctors: usize) -> Numerics {
    Numerics {
        ddt: TimeScheme::Euler,
        convection: Convection::Upwind,
        gradient: Gradient::GaussLinear,
        gradient_p: Gradient::GaussLinear,
        compatible: false,
        limiter: None,
        non_orthogonal: 1.0,
        sn_grad: None,
        outer,
        correctors,
        non_orthogonal_correctors: 0,
        predictor: true,
        control: ResidualControl::default(),
        u: Solve { solver: solver("PBiCGStab", "DILU"), tolerance: tight(), last: tight() },
        p: Solve { solver: solver("PCG", "DIC"), tolerance: tight(), last: tight() },
        compression: solver("PCG", "DIC"),
        reference: Some((0, 0.0)),
        reference_value: 0.0,
    }
}

pub fn ngf(exec: &Exec, mesh: &Mesh, grains: Granular, form: Form) -> Box<dyn Rheology> {
    let numerics = NgfNumerics {
        solver: solver("PBiCGStab", "DILU"),
        tolerance: Tolerance { abs: 1e-12, rel: 1e-10, max_iter: 500 },
        residual: 1e-10,
    };
    Box::new(Ngf::new(Law { grains, a: A, form }, exec, mesh, Vec::new(), numerics))
}

/// The condition that the patch kind dictates, else `given`.
pub fn on_patch<T: granflow_base::Value>(
    kind: &PatchKind,
    given: Box<dyn Condition<T>>,
) -> Box<dyn Condition<T>> {
    match kind {
        PatchKind::Wedge => Box::new(OfPatchType { kind: "wedge", symmetric: false }),
        PatchKind::Cyclic { .. } => Box::new(OfPatchType { kind: "cyclic", symmetric: false }),
        PatchKind::Empty => Box::new(OfPatchType { kind: "empty", symmetric: false }),
        _ => given,
    }
}

pub struct Setup {
    pub exec: Exec,
    pub mesh: Arc<Mesh>,
    pub gravity: Gravity,
    pub rho: f64,
    pub u0: Vec<Vec3>,
    pub p0: f64,
    pub numerics: Numerics,
}

impl Setup {
    pub fn new(poly: &PolyMesh, numerics: Numerics) -> Self {
        Setup::on(Exec::serial(), Mesh::new(poly).expect("a sound mesh"), numerics)
    }
    /// On a mesh that may be one rank's part, by the team `exec`.
    pub fn on(exec: Exec, mesh: Mesh, numerics: Numerics) -> Self {
        let mesh = Arc::new(mesh);
        Setup {
            exec,
            u0: vec![[0.0; 3]; mesh.n_cells],
            mesh,
            gravity: Gravity::default(),
            rho: RHO_B,
            p0: 0.0,
            numerics,
        }
    }
    /// `u` and `p` give the condition of each patch by name.
    pub fn flow(
        self,
        rheology: Box<dyn Rheology>,
        u: impl Fn(&str) -> Box<dyn Condition<Vec3>>,
        p: impl Fn(&str) -> Box<dyn Condition<f64>>,
    ) -> Flow {
        let m = self.mesh.clone();
        let u_conditions = m.patches.iter().map(|q| on_patch(&q.kind, u(&q.name))).collect();
        let p_conditions = m.patches.iter().map(|q| on_patch(&q.kind, p(&q.name))).collect();
        let mut u = Unknown::new(&m, "U", Dims::VELOCITY, [0.0; 3], u_conditions);
        u.cells.data[..m.n_cells].copy_from_slice(&self.u0);
        let p = Unknown::new(&m, "p", Dims::PRESSURE, self.p0, p_conditions);
        let state = State {
            time: 0.0,
            step: 0,
            u_old: u.cells.data.clone(),
            u,
            dt_old: 0.0,
            p,
            phi: FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0),
            phi_old: vec![0.0; m.n_faces()],
            alpha: None,
        };
        let fluid = Fluid { rho: self.rho, rheology };
        Flow::new(self.exec, m, state, fluid, self.gravity, self.numerics)
    }
}

pub fn fixed<T: granflow_base::Value>(v: T) -> Box<dyn Condition<T>> {
    Box::new(FixedValue::uniform(v))
}
pub fn free<T: granflow_base::Value>() -> Box<dyn Condition<T>> {
    Box::new(ZeroGradient)
}
pub fn slip() -> Box<dyn Condition<Vec3>> {
    Box::new(Slip)
}
pub fn pressure(p: f64) -> Box<dyn Condition<f64>> {
    Box::new(PrghPressure::new(vec![p]))
}
pub fn local<L: granflow_physics::LocalLaw + 'static>(law: L) -> Box<dyn Rheology> {
    Box::new(Local(Box::new(law)))
}

/// A wall that turns about the z axis with its face points at speed `v` at radius `r`.
pub fn turning(v: f64, r: f64) -> Box<dyn Condition<Vec3>> {
    let omega = granflow_fv::TimeFunction::constant(v / r);
    let axis = [0.0, 0.0, 1.0];
    Box::new(granflow_fv::conditions::RotatingWall { origin: [0.0; 3], axis, omega })
}

/// Greatest of `f(c)` over the cells.
pub fn greatest(mesh: &Mesh, f: impl Fn(usize) -> f64) -> f64 {
    (0..mesh.n_cells).map(f).fold(0.0, f64::max)
}

/// Root mean square of `f(c)` over the volume.
pub fn rms(mesh: &Mesh, f: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for c in 0..mesh.n_cells {
        sum += mesh.volume[c] * f(c).powi(2);
        all += mesh.volume[c];
    }
    (sum / all).sqrt()
}

/// Numbers with two digits, for messages.
pub fn short(x: &[f64]) -> String {
    x.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(" ")
}

/// Observed order of successive errors when the mesh is refined twofold each time.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// Columns of a reference file of `cases/`, rows of numbers, `#` comments and header skipped.
pub fn reference(path: &str) -> Vec<Vec<f64>> {
    let full = format!("{}/../../cases/{path}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&full).unwrap_or_else(|e| panic!("{full}: {e}"));
    let row = |l: &str| l.split(',').map(|x| x.parse().ok()).collect::<Option<Vec<f64>>>();
    text.lines().filter_map(row).collect()
}

/// Cubic interpolation of `(x, y)` rows at `at` (local Lagrange).
pub fn interpolate(rows: &[Vec<f64>], x: usize, y: usize, at: f64) -> f64 {
    let k = rows.partition_point(|r| r[x] < at).clamp(2, rows.len() - 2);
    let p = &rows[k - 2..k + 2];
    (0..4)
        .map(|i| {
            let others = (0..4).filter(|&j| j != i);
            p[i][y] * others.map(|j| (at - p[j][x]) / (p[i][x] - p[j][x])).product::<f64>()
        })
        .sum()
}

/// U. Ghia, K. N. Ghia, C. T. Shin, J. Comput. Phys. 48 (1982) 387, table I: y, and U_x on the vertical
/// centre line at Re 100, 400 and 1000.
pub const GHIA: [[f64; 4]; 15] = [
    [0.9766, 0.84123, 0.75837, 0.65928],
    [0.9688, 0.78871, 0.68439, 0.57492],
    [0.9609, 0.73722, 0.61756, 0.51117],
    [0.9531, 0.68717, 0.55892, 0.46604],
    [0.8516, 0.23151, 0.29093, 0.33304],
    [0.7344, 0.00332, 0.16256, 0.18719],
    [0.6172, -0.13641, 0.02135, 0.05702],
    [0.5000, -0.20581, -0.11477, -0.06080],
    [0.4531, -0.21090, -0.17119, -0.10648],
    [0.2813, -0.15662, -0.32726, -0.27805],
    [0.1719, -0.10150, -0.24299, -0.38289],
    [0.1016, -0.06434, -0.14612, -0.29730],
    [0.0703, -0.04775, -0.10338, -0.22220],
    [0.0625, -0.04192, -0.09266, -0.20196],
    [0.0547, -0.03717, -0.08186, -0.18109],
];
