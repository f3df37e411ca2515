//! From a state to a [`Flow`]: the one path that starting, restarting and going on after a write
//! all take, so that they cannot differ by a bit.

use crate::Case;
use crate::boundary::conditions;
use crate::collect::{own_cells, own_fluxes, tidy};
use crate::config::GradientKind;
use granflow_base::{Dims, Vec3};
use granflow_flow::vof::Vof;
use granflow_flow::{Flow, Fluid, Numerics, Solve, Source, State, TwoPhase, TwoPhaseParts, Zone};
use granflow_fv::{FaceField, Gradient, LeastSquares, Surroundings, Unknown, operators};
use granflow_linsolve::{LinearSolver, build as solver, gamg};
use granflow_mesh::Mesh;
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
    /// Pressure gradients that hold mean velocities, as in the files; those of the case if none.
    pub(crate) gradients: Option<Vec<f64>>,
    pub(crate) fluidity: Option<Vec<f64>>,
    pub(crate) alpha: Option<Vec<f64>>,
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
            gradients: None,
            phi_old: s.phi_old.as_ref().map(|phi| own_fluxes(mesh, phi)),
            fluidity: s.has_fluidity.then(|| own_cells(mesh, &s.fluidity.cells)),
            alpha: s.alpha.as_ref().map(|a| own_cells(mesh, &a.cells)),
        }
    }

    /// What the files of `flow` would hold.
    pub(crate) fn of_flow(case: &Case, flow: &Flow) -> Start {
        let (s, n) = (&flow.state, flow.mesh.n_cells);
        let k = case.pressure_factor();
        let backward = flow.numerics.ddt.remembers_two();
        let fluxes = |phi: &[f64]| phi.iter().map(|phi| tidy(*phi)).collect::<Vec<_>>();
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
            gradients: Some(case.gradients_of(&flow.mean_gradients())),
            fluidity: flow
                .fluid
                .rheology
                .field()
                .map(|g| g.data[..n].iter().map(|g| tidy(*g)).collect()),
            alpha: s.alpha.as_ref().map(|a| tidied_scalars(&a.cells.data[..n])),
        }
    }
}

fn tidied_scalars(v: &[f64]) -> Vec<f64> {
    v.iter().map(|x| tidy(*x)).collect()
}

/// The sources of the case on the cells of one rank.
fn sources(case: &Case, mesh: &Mesh, gradients: Option<Vec<f64>>) -> Vec<Box<dyn Source>> {
    let mut sources = case.sources.clone();
    let mut here = std::collections::HashMap::new();
    if !sources.is_empty() {
        here = (0..mesh.n_cells).map(|c| (mesh.global_cell[c], c as u32)).collect();
    }
    let mut kept = gradients.into_iter().flatten();
    for source in &mut sources {
        if let Some(held) = source.held_mut()
            && let Some(g) = kept.next()
        {
            held.gradient = g * case.config.acceleration_to_force();
        }
        let zone = source.zone_mut();
        if let Zone::Cells(cells) = zone {
            let mut own: Vec<u32> = cells.iter().filter_map(|c| here.get(c).copied()).collect();
            own.sort_unstable();
            *cells = own;
        }
    }
    sources
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
    let compatible = config.schemes.compatible;
    let mesh = match compatible {
        true => Arc::new(mesh.without_skewness()),
        false => mesh,
    };
    let rho = config.transport.rho;
    let n = mesh.n_cells;
    let entries = &case.start;
    let u_conditions =
        conditions::<Vec3>(&entries.u.boundary, &mesh, case.patches(), ("U", Dims::VELOCITY), 1.0);
    let mut u = Unknown::new(&mesh, "U", Dims::VELOCITY, [0.0; 3], u_conditions);
    u.cells.data[..n].copy_from_slice(&start.u);
    let p_conditions = conditions::<f64>(
        &entries.p.boundary,
        &mesh,
        case.patches(),
        (config.pressure(), entries.p.dims),
        k,
    );
    let mut p = Unknown::new(&mesh, config.pressure(), Dims::PRESSURE, 0.0, p_conditions);
    p.cells.data[..n].iter_mut().zip(&start.p).for_each(|(p, v)| *p = k * v);
    let fresh = start.phi.is_none();
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
    let g_conditions = conditions::<f64>(
        &entries.fluidity.boundary,
        &mesh,
        case.patches(),
        ("fluidity", Dims::RATE),
        1.0,
    );
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
    let gradient = |kind: GradientKind| match kind {
        GradientKind::GaussLinear => Gradient::GaussLinear,
        GradientKind::LeastSquares if compatible => {
            Gradient::LeastSquares(LeastSquares::by_area(&mesh))
        }
        GradientKind::LeastSquares => Gradient::LeastSquares(LeastSquares::new(&mesh)),
    };
    let reference = case.reference.and_then(|(cell, value)| {
        let here = mesh.global_cell.iter().position(|&c| c as usize == cell)?;
        Some((here, value))
    });
    let numerics = Numerics {
        ddt: config.schemes.ddt,
        convection: config.schemes.convection,
        gradient: gradient(config.schemes.gradient),
        gradient_p: gradient(config.schemes.gradient_p),
        limiter: config.schemes.limiter,
        non_orthogonal: config.schemes.non_orthogonal,
        sn_grad: config.schemes.sn_grad,
        compatible,
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
    let (alpha, second) = second_phase(case, &exec, &mesh, &p, start.alpha);
    let state = State { time, step, u, u_old, dt_old, p, phi, phi_old, alpha };
    let sources = sources(case, &mesh, start.gradients);
    let mut flow = Flow::new(exec, mesh, state, Fluid { rho, rheology }, case.gravity, numerics);
    flow.sources = sources;
    flow.turn_frames(fresh);
    match second {
        Some(second) => flow.with_second_fluid(second),
        None => flow,
    }
}

/// The volume fraction and the second phase, where there are two.
fn second_phase(
    case: &Case,
    exec: &Exec,
    mesh: &Mesh,
    p: &Unknown<f64>,
    start: Option<Vec<f64>>,
) -> (Option<Unknown<f64>>, Option<TwoPhase>) {
    let config = &case.config;
    let (Some(second), Some(params)) = (&config.transport.second, &config.vof) else {
        return (None, None);
    };
    let (Some(field), Some(start)) = (&case.start.alpha, start) else { return (None, None) };
    let alpha_conditions =
        conditions::<f64>(&field.boundary, mesh, case.patches(), (&field.name, Dims::NONE), 1.0);
    let mut alpha = Unknown::new(mesh, &field.name, Dims::NONE, 0.0, alpha_conditions);
    alpha.cells.data[..mesh.n_cells].copy_from_slice(&start);
    mesh.halo.update(exec, &mut alpha.cells.data);
    let Ok(vof) = Vof::new(exec, &case.poly, mesh, params) else {
        // The mesh was checked when the case was loaded.
        return (None, None);
    };
    let other = &second.transport;
    let context = FluidContext {
        density: other.rho,
        exec,
        mesh,
        fluidity_conditions: Vec::new(),
        numerics: NgfNumerics {
            solver: checked(&config.solution.fluidity.spec),
            tolerance: config.solution.fluidity.tolerance,
            residual: config.solution.newton,
        },
    };
    let parts = TwoPhaseParts {
        rho_2: other.rho,
        rheology_2: other.rheology(context),
        sigma: second.sigma,
        frozen: config.solution.frozen,
        reference_pressure: case.reference.map_or(0.0, |r| r.1),
        vof,
        mixing: second.mixing,
        pores: second.pores,
        pore_solver: Some(checked(&config.solution.p.spec)),
    };
    let mut two = TwoPhase::new(exec, &case.poly, mesh, p, case.gravity.hydrostatic, parts);
    let given = config.functions.iter().find_map(|f| f.plan.prescribes());
    two.prescribed = given.map(|flow| flow.on(&case.poly, mesh));
    (Some(alpha), Some(two))
}
