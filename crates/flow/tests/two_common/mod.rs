//! Flows of two fluids built by hand.
#![allow(dead_code, unreachable_pub)]

use granflow_base::{Dims, Vec3, norm};
use granflow_flow::vof::{AlgebraicParams, Corners, GeometricParams, Params, Shape, Vof, fill};
use granflow_flow::*;
use granflow_fv::conditions::{
    FixedValue, InletOutlet, OfPatchType, PrghPressure, Slip, ZeroGradient,
};
use granflow_fv::{Condition, Convection, FaceField, Gradient, Unknown};
use granflow_linsolve::{LinearSolver, SolverSpec, Tolerance, build};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use granflow_physics::rheology::{Local, Newtonian, Rheology};
use std::sync::Arc;

pub fn solver<T: granflow_base::Value>(name: &str, precond: &str) -> Box<dyn LinearSolver<T>> {
    let spec =
        SolverSpec { solver: name.into(), preconditioner: Some(precond.into()), smoother: None };
    build(&spec).expect("a known solver")
}

pub fn numerics(correctors: usize) -> Numerics {
    let tolerance = Tolerance { abs: 1e-12, rel: 0.0, max_iter: 2000 };
    Numerics {
        ddt: TimeScheme::Euler,
        convection: Convection::LinearUpwind,
        gradient: Gradient::GaussLinear,
        gradient_p: Gradient::GaussLinear,
        compatible: false,
        limiter: None,
        non_orthogonal: 1.0,
        sn_grad: None,
        outer: 1,
        correctors,
        non_orthogonal_correctors: 0,
        predictor: false,
        control: ResidualControl::default(),
        u: Solve { solver: solver("PBiCGStab", "DILU"), tolerance, last: tolerance },
        p: Solve { solver: solver("PCG", "DIC"), tolerance, last: tolerance },
        compression: solver("PCG", "DIC"),
        reference: Some((0, 0.0)),
        reference_value: 0.0,
    }
}

/// A rheology on a mesh.
pub type Model = fn(&Exec, &Mesh) -> Box<dyn Rheology>;

/// What a flow of two fluids is made of; `shape` is filled with fluid 1.
pub struct Two<'a> {
    pub poly: &'a PolyMesh,
    pub gravity: Vec3,
    /// The part of it along cyclic directions.
    pub driving: Vec3,
    pub rho: [f64; 2],
    pub eta: [f64; 2],
    pub sigma: f64,
    pub geometric: bool,
    pub shape: Shape,
    pub numerics: Numerics,
    pub threads: usize,
    /// Patches at no pressure.
    pub open: &'a [&'a str],
    /// Volume fraction of what enters there.
    pub enters: f64,
    /// Of fluid 1 in place of `eta[0]`: grains, for example.
    pub rheology: Option<Model>,
    pub mixing: Mixing,
    pub pores: Pores,
    pub stiffest: Stiffest,
}

pub fn water_and_air(poly: &PolyMesh, shape: Shape) -> Two<'_> {
    Two {
        poly,
        gravity: [0.0, -9.81, 0.0],
        driving: [0.0; 3],
        rho: [1000.0, 1.0],
        eta: [1e-3, 1.48e-5],
        sigma: 0.0,
        geometric: false,
        shape,
        numerics: numerics(3),
        threads: 1,
        open: &[],
        enters: 0.0,
        rheology: None,
        mixing: Mixing::default(),
        pores: Pores::default(),
        stiffest: Stiffest::DEFAULT,
    }
}

pub fn wall() -> Box<dyn Condition<Vec3>> {
    Box::new(FixedValue::uniform([0.0; 3]))
}
pub fn slip() -> Box<dyn Condition<Vec3>> {
    Box::new(Slip)
}

impl Two<'_> {
    pub fn flow(self, u: impl Fn(&str) -> Box<dyn Condition<Vec3>>) -> Flow {
        let m = Mesh::new(self.poly).expect("a sound mesh");
        // As cases have them.
        let m = Arc::new(if self.numerics.compatible { m.without_skewness() } else { m });
        let exec = Exec::new(self.threads, Box::new(granflow_par::Solo)).sharing_from(1);
        let dictated = |kind: &PatchKind| match kind {
            PatchKind::Cyclic { .. } => Some("cyclic"),
            PatchKind::Empty => Some("empty"),
            _ => None,
        };
        fn of<T: granflow_base::Value>(kind: &'static str) -> Box<dyn Condition<T>> {
            Box::new(OfPatchType { kind, symmetric: false })
        }
        let scalar =
            |at_open: &dyn Fn() -> Box<dyn Condition<f64>>| -> Vec<Box<dyn Condition<f64>>> {
                let one = |q: &granflow_mesh::Patch| match dictated(&q.kind) {
                    Some(kind) => of(kind),
                    None if self.open.contains(&&*q.name) => at_open(),
                    None => Box::new(ZeroGradient),
                };
                m.patches.iter().map(one).collect()
            };
        let vector = m.patches.iter().map(|q| dictated(&q.kind).map_or_else(|| u(&q.name), of));
        let u = Unknown::new(&m, "U", Dims::VELOCITY, [0.0; 3], vector.collect());
        let p = Unknown::new(
            &m,
            "p_rgh",
            Dims::PRESSURE,
            0.0,
            scalar(&|| Box::new(PrghPressure::new(vec![0.0]))),
        );
        let mut alpha = Unknown::new(
            &m,
            "alpha",
            Dims::NONE,
            0.0,
            scalar(&|| Box::new(InletOutlet::new(vec![self.enters]))),
        );
        let corners = Corners::new(self.poly, &m);
        fill(&exec, &m, &corners, &self.shape, &mut alpha.cells.data);
        m.halo.update(&exec, &mut alpha.cells.data);
        let params = if self.geometric {
            Params::Geometric(GeometricParams::default())
        } else {
            Params::Algebraic(AlgebraicParams {
                mules_corr: true,
                n_alpha_corr: 2,
                central_compression: self.numerics.compatible,
                ..AlgebraicParams::default()
            })
        };
        let vof = Vof::new(&exec, self.poly, &m, &params).expect("a method");
        let newton = |eta| -> Box<dyn Rheology> { Box::new(Local(Box::new(Newtonian { eta }))) };
        let parts = TwoPhaseParts {
            rho_2: self.rho[1],
            rheology_2: newton(self.eta[1]),
            sigma: self.sigma,
            frozen: false,
            reference_pressure: 0.0,
            vof,
            mixing: self.mixing,
            pores: self.pores,
            pore_solver: Some(solver("PCG", "DIC")),
        };
        let mut two = TwoPhase::new(&exec, self.poly, &m, &p, self.gravity, parts);
        two.stiffest = self.stiffest;
        let state = State {
            time: 0.0,
            step: 0,
            u_old: u.cells.data.clone(),
            u,
            dt_old: 0.0,
            p,
            phi: FaceField::new(&m, "phi", Dims::VOLUME_FLUX, 0.0),
            phi_old: vec![0.0; m.n_faces()],
            alpha: Some(alpha),
        };
        let rheology = match self.rheology {
            Some(of) => of(&exec, &m),
            None => newton(self.eta[0]),
        };
        let fluid = Fluid { rho: self.rho[0], rheology };
        let gravity = Gravity { hydrostatic: self.gravity, driving: self.driving };
        Flow::new(exec, m, state, fluid, gravity, self.numerics).with_second_fluid(two)
    }
}

pub fn alpha(flow: &Flow) -> &[f64] {
    let alpha = flow.state.alpha.as_ref().expect("two fluids");
    &alpha.cells.data[..flow.mesh.n_cells]
}
pub fn fastest(flow: &Flow) -> f64 {
    let n = flow.mesh.n_cells;
    flow.state.u.cells.data[..n].iter().map(|u| norm(*u)).fold(0.0, f64::max)
}
/// A plane mesh of walls.
pub fn tank(n: [usize; 2], lo: [f64; 2], hi: [f64; 2]) -> PolyMesh {
    shapes::plane_mesh(n, lo, hi, [const { PatchKind::Wall }; 4])
}
