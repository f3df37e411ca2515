//! One rank's part of a run. Every rank does the same things in the same order: rank 0 says what
//! is next, and what needs the disk happens there alone.

mod order;

pub(crate) use order::Order;

use crate::build::{self, Start};
use crate::collect::Collector;
use crate::functions::whole::Whole as ToWhole;
use crate::functions::{Derivations, Function, View, Whole, Written};
use crate::section::Grid;
use crate::tensile::{self, Tensile};
use crate::{Case, Options};
use granflow_base::{Vec3, dot};
use granflow_flow::{Flow, Report, StepError, Watch};
use granflow_mesh::Mesh;
use granflow_par::{Comm, Exec, InProcess};
use std::cell::OnceCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::JoinHandle;

/// What rank 0 gets back.
pub(crate) enum Answer {
    Done,
    Stepped(Box<Report>),
    Sampled(Vec<Written>),
    Collected(Box<Sheets>),
    Field(Whole),
    Number(f64),
}

/// Fields of the whole mesh in the user's numbering, SI units.
#[derive(Default)]
pub(crate) struct Sheets {
    pub(crate) u: Vec<Vec3>,
    pub(crate) u_faces: Vec<Vec3>,
    pub(crate) u_old: Option<Vec<Vec3>>,
    pub(crate) p: Vec<f64>,
    pub(crate) p_faces: Vec<f64>,
    pub(crate) phi: Vec<f64>,
    pub(crate) phi_old: Option<Vec<f64>>,
    /// Pressure gradients that hold mean velocities, as in the files.
    pub(crate) gradients: Vec<f64>,
    pub(crate) fluidity: Option<Vec<f64>>,
    pub(crate) alpha: Option<Vec<f64>>,
    /// Of alpha, zero where there is none.
    pub(crate) alpha_faces: Vec<f64>,
    /// Between grains, where there are any, Pa.
    pub(crate) pressure: Option<Vec<f64>>,
    /// Of everything, its weight included, Pa.
    pub(crate) total: Option<Vec<f64>>,
    pub(crate) strain_rate: Option<Vec<f64>>,
    pub(crate) viscosity: Option<Vec<f64>>,
}

/// One rank.
pub(crate) struct Worker {
    pub(crate) case: Arc<Case>,
    /// `None` only while it is being renewed.
    flow: Option<Flow>,
    collector: Collector,
    functions: Vec<Box<dyn Function>>,
    /// The step after which each function made its fields last.
    made_at: Vec<Option<usize>>,
    /// The whole mesh as cuts need it, on rank 0.
    grid: OnceCell<Grid>,
    derived: Derivations,
    report: Report,
    /// Time and step number before the last step.
    before: (f64, usize),
    /// Where grains are pulled apart, when the run first comes to such a state.
    pub(crate) tensile: Option<Tensile>,
    /// Whether nobody looks for that (any more).
    tensile_known: bool,
    /// Asks the flow to give up the step it is at.
    stop: Arc<AtomicBool>,
    /// Hears of the flow's passes.
    watch: Option<Watch>,
    /// Name of the present time in tables.
    pub(crate) time_name: String,
}

impl Worker {
    pub(crate) fn new(
        case: Arc<Case>,
        exec: Exec,
        mesh: Arc<Mesh>,
        stop: Arc<AtomicBool>,
    ) -> Worker {
        let collector = Collector::new(&exec, &mesh, case.poly.n_cells(), case.poly.n_faces());
        let plans = case.config.functions.iter().zip(&case.remembered);
        let functions: Vec<_> =
            plans.map(|(f, earlier)| f.plan.build(&mesh, &exec, earlier.as_ref())).collect();
        let start = Start::of_case(&case, &mesh);
        let mut flow = build::flow(&case, exec, mesh, start);
        flow.stop = Some(stop.clone());
        Worker {
            flow: Some(flow),
            collector,
            made_at: vec![None; functions.len()],
            functions,
            grid: OnceCell::new(),
            derived: Derivations::default(),
            report: Report::default(),
            before: (0.0, 0),
            tensile: None,
            tensile_known: case.config.transport.grains.is_none(),
            stop,
            watch: None,
            time_name: String::new(),
            case,
        }
    }

    /// With somebody who hears of the passes.
    fn watched(mut self, watch: &Option<Watch>) -> Worker {
        self.watch = watch.clone();
        self.flow_mut().watch = watch.clone();
        self
    }

    /// The flow.
    pub(crate) fn flow(&self) -> &Flow {
        self.flow.as_ref().expect("only `renew` takes the flow, and puts it back")
    }
    fn flow_mut(&mut self) -> &mut Flow {
        self.flow.as_mut().expect("only `renew` takes the flow, and puts it back")
    }

    /// What function `i` would have a restart know.
    pub(crate) fn memory(&self, i: usize) -> Vec<(String, Vec<(&'static str, String)>)> {
        self.functions.get(i).map_or(Vec::new(), |f| f.memory())
    }
    /// Whether function `i` has made its fields at all.
    pub(crate) fn has_fields(&self, i: usize) -> bool {
        self.functions.get(i).is_some_and(|f| f.ready())
    }
    /// Whether function `i` needs [`Order::Derive`] first.
    pub(crate) fn needs_derived(&self, i: usize) -> bool {
        self.functions[i].needs_derived()
    }

    /// Rank 0: tells every rank and does its own part.
    pub(crate) fn order(&mut self, order: Order) -> Result<Answer, StepError> {
        let exec = &self.flow().exec;
        if exec.ranks() > 1 {
            exec.comm().broadcast(&mut order.code());
        }
        self.execute(order)
    }

    /// The other ranks: obey until the end.
    pub(crate) fn serve(mut self) {
        loop {
            let mut code = Vec::new();
            self.flow().exec.comm().broadcast(&mut code);
            let order = Order::from_code(&code);
            if order == Order::Stop {
                return;
            }
            // Rank 0 hears of failures by itself and decides what to do.
            let _ = self.execute(order);
        }
    }

    fn execute(&mut self, order: Order) -> Result<Answer, StepError> {
        match order {
            Order::Step(dt) => {
                let flow = self.flow_mut();
                let before = (flow.state.time, flow.state.step);
                let result = flow.step(dt);
                self.before = before;
                let report = self.agree(result)?;
                self.report = report;
                if !self.tensile_known {
                    self.tensile = tensile::find(self.flow());
                    self.tensile_known = self.tensile.is_some();
                }
                Ok(Answer::Stepped(Box::new(report)))
            }
            Order::Rollback => {
                let (time, step) = self.before;
                let flow = self.flow_mut();
                flow.rollback();
                (flow.state.time, flow.state.step) = (time, step);
                Ok(Answer::Done)
            }
            Order::Derive => {
                let Worker { flow, derived, .. } = self;
                if let Some(flow) = flow {
                    derived.update(flow)?;
                }
                Ok(Answer::Done)
            }
            Order::Make(i) => {
                self.make(i);
                Ok(Answer::Done)
            }
            Order::Sample(i) => Ok(Answer::Sampled(self.sample(i))),
            Order::Field(i, slot) => Ok(Answer::Field(self.field(i, slot))),
            Order::Written(i) => {
                if let Some(f) = self.functions.get_mut(i) {
                    f.written();
                }
                Ok(Answer::Done)
            }
            Order::Collect(derived) => Ok(Answer::Collected(Box::new(self.collect(derived)))),
            Order::Renew => {
                self.renew();
                Ok(Answer::Done)
            }
            Order::Courant => {
                let Some(adjust) = self.case.config.control.adjust else {
                    return Ok(Answer::Number(0.0));
                };
                let flow = self.flow();
                let at_interface = flow.interface_courant_rate() / adjust.max_alpha_co;
                Ok(Answer::Number((courant(flow) / adjust.max_co).max(at_interface)))
            }
            Order::Settled(dt) => {
                let end = self.case.end;
                let flow = self.flow_mut();
                Ok(Answer::Number(f64::from(u8::from(flow.conditions_stay(dt, end)))))
            }
            Order::Stop => Ok(Answer::Done),
        }
    }

    /// A step has failed when it has failed on any rank.
    fn agree(&self, result: Result<Report, StepError>) -> Result<Report, StepError> {
        let exec = &self.flow().exec;
        if exec.ranks() == 1 {
            return result;
        }
        let mut failed = [f64::from(u8::from(result.is_err()))];
        exec.comm().max(&mut failed);
        if failed[0] > 0.0
            && let Ok(report) = &result
        {
            return Err(StepError::NotFinite {
                field: "a field of another rank",
                cell: 0,
                place: [0.0; 3],
                time: report.time,
                cause: "see the report of that rank",
            });
        }
        result
    }

    /// Shows the flow to function `i`, with the functions before it.
    fn shown<T>(
        &mut self,
        i: usize,
        to: impl FnOnce(&mut dyn Function, &View<'_>) -> T,
    ) -> Option<T> {
        let Worker { case, flow, collector, functions, grid, derived, report, time_name, .. } =
            self;
        let flow = flow.as_ref()?;
        let (before, rest) = functions.split_at_mut_checked(i)?;
        let function = rest.first_mut()?;
        let view = View {
            exec: &flow.exec,
            mesh: &flow.mesh,
            u: &flow.state.u,
            p: &flow.state.p,
            fluidity: flow.fluid.rheology.field().map(|g| &g.data[..]),
            derived,
            grains: case.config.transport.grains,
            alpha: flow.state.alpha.as_ref(),
            phi: &flow.state.phi.data,
            mass_flux: flow.mass_flux(),
            density: flow.density(),
            gravity: flow.gravity.hydrostatic,
            pressure_factor: case.pressure_factor(),
            time: flow.state.time,
            time_name,
            dt: report.dt,
            report,
            made: before,
            whole: ToWhole { case, collector, grid },
        };
        Some(to(function.as_mut(), &view))
    }

    fn sample(&mut self, i: usize) -> Vec<Written> {
        self.shown(i, |f, view| f.sample(view)).unwrap_or_default()
    }

    /// Once a step, however many ask for it.
    fn make(&mut self, i: usize) {
        let step = Some(self.flow().state.step);
        if self.made_at.get(i) == Some(&step) {
            return;
        }
        self.shown(i, |f, view| f.execute(view));
        if let Some(at) = self.made_at.get_mut(i) {
            *at = step;
        }
    }

    /// A field of function `i` on the whole mesh, on rank 0.
    fn field(&self, i: usize, slot: usize) -> Whole {
        let Some(values) = self.functions.get(i).and_then(|f| f.fields().get(slot)) else {
            return Whole::default();
        };
        let (exec, mesh) = (&self.flow().exec, &self.flow().mesh);
        // Component by component, so that any rank of tensor passes.
        let n = values.n;
        let mut out = Whole::default();
        let mut put = |to: fn(&mut Whole) -> &mut Vec<f64>, k: usize, all: Option<Vec<f64>>| {
            let Some(all) = all else { return };
            to(&mut out).resize(n * all.len(), 0.0);
            all.into_iter().enumerate().for_each(|(c, x)| to(&mut out)[n * c + k] = x);
        };
        for k in 0..n {
            let own: Vec<f64> = (0..mesh.n_cells).map(|c| values.cells[n * c + k]).collect();
            put(|w| &mut w.cells, k, self.collector.cells(exec, &own, mesh.n_cells));
            if values.faces.is_empty() && mesh.n_faces() > mesh.n_inner {
                continue;
            }
            let mut faces = vec![0.0; mesh.n_faces()];
            for (i, x) in faces[mesh.n_inner..].iter_mut().enumerate() {
                *x = values.faces[n * i + k];
            }
            put(|w| &mut w.faces, k, self.collector.faces(exec, &faces, false));
        }
        out
    }

    fn collect(&mut self, derived: bool) -> Sheets {
        let flow = self.flow();
        let (exec, mesh, s, n) = (&flow.exec, &flow.mesh, &flow.state, flow.mesh.n_cells);
        let c = &self.collector;
        let whole = |v: &[f64]| c.cells(exec, v, n);
        let mut u_faces = vec![[0.0; 3]; mesh.n_faces()];
        let mut p_faces = vec![0.0; mesh.n_faces()];
        for f in mesh.n_inner..mesh.n_faces() {
            u_faces[f] = s.u.boundary_value(mesh, f);
            p_faces[f] = s.p.boundary_value(mesh, f);
        }
        let mut alpha_faces = vec![0.0; mesh.n_faces()];
        if let Some(alpha) = &s.alpha {
            let boundary = alpha_faces.iter_mut().enumerate().skip(mesh.n_inner);
            boundary.for_each(|(f, a)| *a = alpha.boundary_value(mesh, f));
        }
        let backward = flow.numerics.ddt.remembers_two();
        let d = &self.derived;
        let (rho, g) = (flow.density(), flow.gravity.hydrostatic);
        let of = |c: usize| s.p.cells.data[c] + rho[c] * dot(g, mesh.cell_centre[c]);
        let total: Vec<f64> = if derived { (0..n).map(of).collect() } else { Vec::new() };
        Sheets {
            u: c.cells(exec, &s.u.cells.data, n).unwrap_or_default(),
            u_faces: c.faces(exec, &u_faces, false).unwrap_or_default(),
            u_old: if backward { c.cells(exec, &s.u_old, n) } else { None },
            p: whole(&s.p.cells.data).unwrap_or_default(),
            p_faces: c.faces(exec, &p_faces, false).unwrap_or_default(),
            phi: c.faces(exec, &s.phi.data, true).unwrap_or_default(),
            phi_old: if backward { c.faces(exec, &s.phi_old, true) } else { None },
            gradients: self.case.gradients_of(&flow.mean_gradients()),
            fluidity: flow.fluid.rheology.field().and_then(|g| whole(&g.data)),
            alpha: s.alpha.as_ref().and_then(|a| whole(&a.cells.data)),
            alpha_faces: c.faces(exec, &alpha_faces, false).unwrap_or_default(),
            pressure: if derived { whole(&d.pressure) } else { None },
            total: if derived { whole(&total) } else { None },
            strain_rate: if derived { whole(&d.strain_rate) } else { None },
            viscosity: if derived { whole(&d.viscosity) } else { None },
        }
    }

    /// Builds the flow anew from what the files of its state hold, so that going on and
    /// restarting are one and the same: no solver, no condition remembers more than the files.
    fn renew(&mut self) {
        let start = Start::of_flow(&self.case, self.flow());
        if let Some(Flow { exec, mesh, .. }) = self.flow.take() {
            let mut flow = build::flow(&self.case, exec, mesh, start);
            flow.stop = Some(self.stop.clone());
            flow.watch = self.watch.clone();
            self.flow = Some(flow);
        }
    }
}

/// Greatest Courant number of a step of one second.
fn courant(flow: &Flow) -> f64 {
    let (mesh, phi) = (&flow.mesh, &flow.state.phi.data);
    let rate =
        |c: usize| 0.5 * mesh.faces_of(c).map(|(f, _)| phi[f].abs()).sum::<f64>() / mesh.volume[c];
    flow.exec.max(mesh.n_cells, |r| r.map(rate).fold(0.0, f64::max))
}

/// Rank 0 and the threads of the others.
pub(crate) struct Crew {
    pub(crate) worker: Worker,
    others: Vec<JoinHandle<()>>,
}

impl Crew {
    /// Starts the ranks. The other ranks live on threads of this process until the crew is
    /// dropped.
    pub(crate) fn new(
        case: Arc<Case>,
        options: &Options,
    ) -> Result<Crew, granflow_mesh::MeshError> {
        let stop = &options.stop;
        let ranks = options.ranks.clamp(1, case.mesh.n_cells.max(1));
        if ranks == 1 {
            let exec = exec(options, Box::new(granflow_par::Solo));
            let mesh = case.mesh.clone();
            return Ok(Crew {
                worker: Worker::new(case, exec, mesh, stop.clone()).watched(&options.watch),
                others: Vec::new(),
            });
        }
        let parts = decompose(&case, ranks)?;
        let mut others = Vec::with_capacity(ranks - 1);
        let mut first = None;
        for (comm, mesh) in InProcess::world(ranks).into_iter().zip(parts) {
            if first.is_none() {
                first = Some((comm, mesh));
                continue;
            }
            let (case, stop) = (case.clone(), stop.clone());
            let options = options.clone();
            others.push(std::thread::spawn(move || {
                let exec = exec(&options, Box::new(comm));
                Worker::new(case, exec, Arc::new(mesh), stop).serve();
            }));
        }
        let (comm, mesh) = first.expect("at least one rank");
        let exec = exec(options, Box::new(comm));
        let worker = Worker::new(case, exec, Arc::new(mesh), stop.clone());
        Ok(Crew { worker: worker.watched(&options.watch), others })
    }
}

/// The threads of a rank.
fn exec(options: &Options, comm: Box<dyn Comm>) -> Exec {
    let exec = Exec::new(options.threads, comm);
    match options.share {
        Some(least) => exec.sharing_from(least),
        None => exec,
    }
}

/// The parts of the whole mesh, with the user's numbers.
fn decompose(case: &Case, ranks: usize) -> Result<Vec<Mesh>, granflow_mesh::MeshError> {
    // By the user's cells, so that the cut does not depend on the renumbering.
    let by_user = granflow_mesh::partition(&case.poly, ranks);
    let part: Vec<u32> = case.mesh.global_cell.iter().map(|&c| by_user[c as usize]).collect();
    (0..ranks)
        .map(|rank| {
            let mut mesh = granflow_mesh::extract(&case.mesh, &part, rank)?;
            for c in &mut mesh.global_cell {
                *c = case.mesh.global_cell[*c as usize];
            }
            Ok(mesh)
        })
        .collect()
}

impl Drop for Crew {
    fn drop(&mut self) {
        if self.others.is_empty() || std::thread::panicking() {
            return;
        }
        let _ = self.worker.order(Order::Stop);
        for thread in self.others.drain(..) {
            // A rank that panicked has said so.
            let _ = thread.join();
        }
    }
}
