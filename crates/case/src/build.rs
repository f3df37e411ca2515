//! From a state to a [`Flow`]: the one path that starting, restarting and going on after a write
//! all take, so that they cannot differ by a bit.

use crate::Case;
use crate::boundary::conditions;
use crate::collect::{own_cells, own_fluxes, tidy};
use crate::config::GradientKind;
use granflow_base::{Dims, Vec3};
use granflow_flow::{Flow, Fluid, Numerics, Solve, State};
use granflow_fv::{FaceField, Gradient, LeastSquares, Surroundings, Unknown, operators};
use granflow_linsolve::{LinearSolver, build as solver, gamg};
use granflow_mesh::{Mesh, PatchKind};
use granflow_par::Exec;
use granflow_physics::rheology::{FluidContext, NgfNumerics};
use std::sync::Arc;

/// A state on one rank's mesh, own cells, the pressure in the units of the files.
pub(crate) struct Start {
    pub(crate) time: f64,
    pub(crate) step: usize,
    pub(crate) dt_old: f64,
    pub(crate) u: Vec<Vec3>,
    pub(crate) u_old: Option<Vec<Vec3>>,
    pub(crate) p: Vec<f64>,
    pub(crate) phi: Option<Vec<f64>>,
    pub(crate) phi_old: Option<Vec<f64>>,
    pub(crate) fluidity: Option<Vec<f64>>,
}

impl Start {
    /// The part of the case's start that lives on `mesh`.
    pub(crate) fn of_case(case: &Case, mesh: &Mesh) -> Start {
        let s = &case.start;
        Start {
            time: s.time,
            step: s.step,
            dt_old: s.dt_old,
            u: own_cells(mesh, &s.u.cells),
            u_old: s.u_old.as_ref().map(|u| own_cells(mesh, u)),
            p: own_cells(mesh, &s.p.cells),
            phi: s.phi.as_ref().map(|phi| own_fluxes(mesh, phi)),
            phi_old: s.phi_old.as_ref().map(|phi| own_fluxes(mesh, phi)),
            fluidity: s.has_fluidity.then(|| own_cells(mesh, &s.fluidity.cells)),
        }
    }

    /// What the files of `flow` would hold.
    pub(crate) fn of_flow(case: &Case, flow: &Flow) -> Start {
        let (s, n) = (&flow.state, flow.mesh.n_cells);
        let k = case.pressure_factor();
        let backward = flow.numerics.ddt == granflow_flow::TimeScheme::Backward;
        let fluxes = |phi: &[f64]| {
            let mut phi: Vec<f64> = phi.iter().map(|phi| tidy(*phi)).collect();
            for patch in flow.mesh.patches.iter().filter(|p| p.kind == PatchKind::Empty) {
                // Files hold nothing for empty patches.
                phi[patch.faces.clone()].fill(0.0);
            }
            phi
        };
        let tidied = |v: &[Vec3]| v[..n].iter().map(|v| tidy(*v)).collect::<Vec<_>>();
        Start {
            time: s.time,
            step: s.step,
            dt_old: s.dt_old,
            u: tidied(&s.u.cells.data),
            u_old: backward.then(|| tidied(&s.u_old)),
            p: s.p.cells.data[..n].iter().map(|p| tidy(p / k)).collect(),
            phi: Some(fluxes(&s.phi.data)),
            phi_old: backward.then(|| fluxes(&s.phi_old)),
            fluidity: flow
                .fluid
                .rheology
                .field()
                .map(|g| g.data[..n].iter().map(|g| tidy(*g)).collect()),
        }
    }
}

/// A solver that the configuration has checked.
fn checked<T: granflow_base::Value>(
    spec: &granflow_linsolve::SolverSpec,
) -> Box<dyn LinearSolver<T>> {
    solver(spec).unwrap_or_else(|_| gamg())
}

/// Puts the flow of one rank together.
pub(crate) fn flow(case: &Case, exec: Exec, mesh: Arc<Mesh>, start: Start) -> Flow {
    let (config, k) = (&case.config, case.pressure_factor());
    let rho = config.transport.rho;
    let n = mesh.n_cells;
    let entries = &case.start;
    let u_conditions =
        conditions::<Vec3>(&entries.u.boundary, &mesh, &case.poly, Dims::VELOCITY, 1.0);
    let mut u = Unknown::new(&mesh, "U", Dims::VELOCITY, [0.0; 3], u_conditions);
    u.cells.data[..n].copy_from_slice(&start.u);
    let p_conditions = conditions::<f64>(&entries.p.boundary, &mesh, &case.poly, Dims::PRESSURE, k);
    let mut p = Unknown::new(&mesh, config.pressure(), Dims::PRESSURE, 0.0, p_conditions);
    p.cells.data[..n].iter_mut().zip(&start.p).for_each(|(p, v)| *p = k * v);
    let mut phi = FaceField::new(&mesh, "phi", Dims::VOLUME_FLUX, 0.0);
    match start.phi {
        Some(values) => phi.data.copy_from_slice(&values),
        None => {
            let around = Surroundings { time: start.time, ..Surroundings::default() };
            u.update(&exec, &mesh, &around, None);
            let cells = u.cells.data.clone();
            operators::flux(&exec, &mesh, &u, &cells, &mut phi);
        }
    }
    let phi_old = start.phi_old.unwrap_or_else(|| phi.data.clone());
    let mut u_old = vec![[0.0; 3]; mesh.n_all()];
    u_old[..n].copy_from_slice(start.u_old.as_deref().unwrap_or(&start.u));
    mesh.halo.update(&exec, &mut u_old);

    let sol = &config.solution;
    let g_conditions =
        conditions::<f64>(&entries.fluidity.boundary, &mesh, &case.poly, Dims::RATE, 1.0);
    let mut rheology = config.transport.rheology(FluidContext {
        density: rho,
        exec: &exec,
        mesh: &mesh,
        fluidity_conditions: g_conditions,
        numerics: NgfNumerics {
            solver: checked(&sol.fluidity.spec),
            tolerance: sol.fluidity.tolerance,
            residual: sol.newton,
        },
    });
    if let (Some(field), Some(values)) = (rheology.field_mut(), &start.fluidity) {
        field.data[..n].copy_from_slice(values);
    }
    let gradient = match config.schemes.gradient {
        GradientKind::GaussLinear => Gradient::GaussLinear,
        GradientKind::LeastSquares => Gradient::LeastSquares(LeastSquares::new(&mesh)),
    };
    let reference = case.reference.and_then(|(cell, value)| {
        let here = mesh.global_cell.iter().position(|&c| c as usize == cell)?;
        Some((here, value))
    });
    let numerics = Numerics {
        ddt: config.schemes.ddt,
        convection: config.schemes.convection,
        gradient,
        non_orthogonal: config.schemes.non_orthogonal,
        outer: sol.outer,
        correctors: sol.correctors,
        non_orthogonal_correctors: sol.non_orthogonal_correctors,
        predictor: sol.predictor,
        control: sol.control,
        u: Solve { solver: checked(&sol.u.spec), tolerance: sol.u.tolerance, last: sol.u.last },
        p: Solve { solver: checked(&sol.p.spec), tolerance: sol.p.tolerance, last: sol.p.last },
        compression: checked(&sol.p.spec),
        reference,
        reference_value: case.reference.map_or(0.0, |r| r.1),
    };
    let (time, step, dt_old) = (start.time, start.step, start.dt_old);
    let state = State { time, step, u, u_old, dt_old, p, phi, phi_old };
    Flow::new(exec, mesh, state, Fluid { rho, rheology }, case.gravity, numerics)
}
