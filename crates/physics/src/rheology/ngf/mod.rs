//! Nonlocal granular fluidity (NGF): stress and strain rate are tied by a fluidity g that
//! spreads over a few grains,
//!
//! paper eq. 1:  rate = g mu,            eta = P/g
//! paper eq. 3:  g = g_loc + xi^2 lap g
//! paper eq. 4:  g_loc = sqrt(P/(rho_s d^2)) I0 (mu - mu_s)/(mu (mu_2 - mu)),  mu > mu_s, else 0
//! paper eq. 5:  xi = A d sqrt((mu_2 - mu)/(dmu |mu - mu_s|))
//!
//! (eq. 4 with the dimensions put right). At mu = mu_s xi is infinite and g_loc zero, so the
//! equation is solved divided by xi^2, `lap g - q g + q g_loc = 0` with
//! `q = dmu |mu - mu_s|/(A^2 d^2 (mu_2 - mu))`: both coefficients are regular there.
//!
//! The primitive form (D. L. Henann, K. Kamrin, Phys. Rev. Lett. 113 (2014) 178001), whose roots
//! the steady form linearises:
//!
//! `t0 Dg/Dt = A^2 d^2 lap g - dmu (mu_s - mu)/(mu_2 - mu) g - b sqrt(rho_s d^2/P) mu g^2`, b = dmu/I0.

mod law;
mod rates;
mod spread;

pub use law::{Form, Law};

use self::law::Local;
use self::spread::InnerFit;
use super::beyond::beyond;
use super::{
    Entry, Floors, FlowView, FluidContext, Granular, Rheology, RheologyError, RheologyInfo, Share,
};
use granflow_base::Dims;
use granflow_dict::Reader;
use granflow_fv::conditions::ZeroGradient;
use granflow_fv::{
    CellField, Condition, Equation, FaceField, Surroundings, Terms, Unknown, div, laplacian,
};
use granflow_linsolve::{Csr, LinearSolver, SolveError, Tolerance};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// How the fluidity equation is solved.
pub struct NgfNumerics {
    /// Solver of the linearised equation.
    pub solver: Box<dyn LinearSolver<f64>>,
    /// Its tolerance.
    pub tolerance: Tolerance,
    /// Newton iterations stop at this residual: greatest imbalance of a cell over its terms.
    pub residual: f64,
}

/// The nonlocal granular fluidity.
pub struct Ngf {
    /// The parameters.
    pub law: Law,
    /// Fluidity, 1/s.
    pub g: Unknown<f64>,
    g_old: Vec<f64>,
    /// Whether `g` holds a fluidity (from a file or an update) or only zeros.
    known: bool,
    /// Whether `g_old` holds one although `g` does not: the step iterates from a guess, and history
    /// is what it was.
    remembers: bool,
    numerics: NgfNumerics,
    eqn: Equation<f64>,
    /// Share of the faces through which the fluidity spreads: 1 but beside another fluid.
    spreads: FaceField<f64>,
    carried: FaceField<f64>,
    upwind: FaceField<f64>,
    /// The linear part, `-lap g + t0/(A d)^2 div(phi g)`: values and right-hand side.
    linear: Vec<f64>,
    linear_b: Vec<f64>,
    local: Vec<f64>,
    rate: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
    terms: Vec<Local>,
    trial_terms: Vec<Local>,
    /// Least-squares gradients from inner neighbours, and the spread of mu within each cell.
    fit: InnerFit,
    mu: Vec<f64>,
    spread: Vec<f64>,
    /// Stress ratios that are held; empty where none is.
    held: Vec<f64>,
    /// Share of the cells and ghosts that grains in contact have.
    touching: Vec<f64>,
}

pub(super) const ENTRY: Entry = Entry {
    name: "NGF",
    summary: "dense granular flow, nonlocal: the granular fluidity spreads over a few grains",
    formula: "g = gLoc + xi^2 lap g, eta = P/g (form steady) or Henann & Kamrin's transient form \
              (form primitive)",
    reference: "K. Kamrin, G. Koval, Phys. Rev. Lett. 108 (2012) 178301; D. L. Henann, K. Kamrin, \
                Phys. Rev. Lett. 113 (2014) 178001",
    read: |r, context| Box::new(Ngf::read(r, context)),
};

/// What the balance of the equation reads besides the fluidity itself.
struct Balance<'a> {
    law: Law,
    a: &'a Csr,
    linear: &'a [f64],
    linear_b: &'a [f64],
    g_old: &'a [f64],
    rate: &'a [f64],
    local: &'a [f64],
    spread: &'a [f64],
    /// Stress ratios that are held in place of the strain rate, where they are numbers; may be empty.
    held: &'a [f64],
}

impl Balance<'_> {
    /// Fills `terms` for the fluidity `g` (ghosts fresh) and returns the greatest imbalance.
    fn of(&self, v: &FlowView<'_>, g: &[f64], terms: &mut [Local]) -> f64 {
        let (a, volume) = (self.a, &v.mesh.volume);
        v.exec.for_each(terms, |first, out| {
            for (i, t) in out.iter_mut().enumerate() {
                let c = first + i;
                if !v.has(c) {
                    *t = Local::NOTHING;
                    continue;
                }
                // What enters or leaves with the surface of the grains counts as carried.
                let g_old = v.share.map_or(1.0, |s| s.old[c] / s.now[c]) * self.g_old[c];
                let g_old = g_old.max(self.law.grains.floors.fluidity);
                let [rate, spread, local] = [self.rate[c], self.spread[c], self.local[c]];
                let held = self.held.get(c).filter(|mu| mu.is_finite());
                let rate = held.map_or(rate, |mu| mu * g[c]);
                *t = self.law.cell_mean(g[c], g_old, rate, spread, local, v.dt);
                if held.is_some() {
                    // The rate follows g.
                    t.slope += t.of_rate / g[c];
                }
                if v.share.is_some() {
                    *t = t.scaled(v.share(c));
                }
                // A g - b of the linear part, and the size of its terms.
                let (mut sum, mut size) = (-self.linear_b[c], self.linear_b[c].abs());
                for k in a.ptr[c] as usize..a.ptr[c + 1] as usize {
                    let part = self.linear[k] * g[a.col[k] as usize];
                    sum += part;
                    size += part.abs();
                }
                t.size += size / volume[c];
                t.k += sum / volume[c];
                t.imbalance = -t.k / t.size;
            }
        });
        let terms = &*terms;
        v.exec.max(terms.len(), |r| r.map(|c| terms[c].imbalance.abs()).fold(0.0, f64::max))
    }
}

impl Ngf {
    /// Reads the coefficients and allocates the equation.
    pub fn read(r: &Reader<'_>, context: FluidContext<'_>) -> Self {
        let grains = Granular::read(r);
        let a = r.positive("A", Dims::NONE);
        let primitive = r.opt_one_of("form", &[("steady", false), ("primitive", true)], false);
        let form = if primitive {
            Form::Primitive { t0: r.positive("t0", Dims::TIME) }
        } else {
            // A case may keep its t0 while it tries the steady form.
            r.ignore("t0");
            Form::Steady
        };
        Ngf::new(
            Law { grains, a, form },
            context.exec,
            context.mesh,
            context.fluidity_conditions,
            context.numerics,
        )
    }

    /// The model on a mesh; `conditions` of the fluidity one per patch (none: zero gradient, the
    /// paper's choice).
    pub fn new(
        law: Law,
        exec: &Exec,
        mesh: &Mesh,
        mut conditions: Vec<Box<dyn Condition<f64>>>,
        numerics: NgfNumerics,
    ) -> Self {
        while conditions.len() < mesh.patches.len() {
            conditions.push(Box::new(ZeroGradient));
        }
        let (n, all) = (mesh.n_cells, mesh.n_cells + mesh.n_ghosts);
        let eqn = Equation::new(exec, mesh);
        Ngf {
            law,
            g: Unknown::new(mesh, "fluidity", Dims::RATE, 0.0, conditions),
            g_old: vec![0.0; all],
            known: false,
            remembers: false,
            numerics,
            linear: vec![0.0; eqn.a.val.len()],
            eqn,
            spreads: FaceField::new(mesh, "share", Dims::NONE, 1.0),
            carried: FaceField::new(mesh, "t0 phi", Dims::LENGTH, 0.0),
            upwind: FaceField::new(mesh, "upwind", Dims::NONE, 1.0),
            linear_b: vec![0.0; n],
            local: vec![0.0; n],
            rate: vec![0.0; n],
            trial: vec![0.0; all],
            step: vec![0.0; all],
            terms: vec![Local::default(); n],
            trial_terms: vec![Local::default(); n],
            fit: InnerFit::new(mesh),
            mu: vec![0.0; all],
            spread: vec![0.0; n],
            held: Vec::with_capacity(n),
            touching: vec![0.0; all],
        }
    }

    /// The branch that leads to the true root: the local law's fluidity, rate/mu(I), smoothed by
    /// one solve with the sink of material at rest. (From above, Newton would end on the spurious
    /// root mu = mu_s, which the steady form has at any strain rate.)
    fn start_from_local_law(
        &mut self,
        v: &FlowView<'_>,
        info: &mut RheologyInfo,
    ) -> Result<(), RheologyError> {
        let Granular { mu_s, mu_2, d, .. } = self.law.grains;
        let q = (mu_2 - mu_s) * mu_s / mu_2 / (self.law.a * d).powi(2);
        let n = v.mesh.n_cells;
        let (ptr, diag, linear) = (&self.eqn.a.ptr, &self.eqn.a.diag, &self.linear);
        let (rate, local, grains) = (&self.rate, &self.local, self.law.grains);
        let volume = &v.mesh.volume;
        let law = |c: usize| rate[c] / grains.mu(rate[c] / local[c]);
        // Unknown: the ratio to the local law, so that far decades are as exact as near ones.
        v.exec.for_each(&mut self.trial[..n], |first, out| {
            out.iter_mut().enumerate().for_each(|(i, g)| *g = law(first + i));
        });
        v.mesh.halo.update(v.exec, &mut self.trial);
        let (trial, col) = (&self.trial, &self.eqn.a.col);
        let linear_b = &self.linear_b;
        v.exec.for_each_row(ptr, &mut self.eqn.a.val, &mut self.eqn.b, |first, val, b| {
            let base = ptr[first] as usize;
            for (i, b) in b.iter_mut().enumerate() {
                let c = first + i;
                let unit = 1.0 / (volume[c] * trial[c]);
                let q = if v.has(c) { q * v.share(c) } else { q };
                for k in ptr[c] as usize..ptr[c + 1] as usize {
                    let sink = if k == diag[c] as usize { q * volume[c] } else { 0.0 };
                    val[k - base] = (linear[k] + sink) * trial[col[k] as usize] * unit;
                }
                *b = q + linear_b[c] * unit;
            }
        });
        self.step[..n].fill(1.0);
        self.solve(v.exec, info)?;
        let (step, trial) = (&self.step, &self.trial);
        let (rate, spread) = (&self.rate, &self.spread);
        v.exec.for_each(&mut self.g.cells.data[..n], |first, g| {
            for (i, g) in g.iter_mut().enumerate() {
                let c = first + i;
                let least = least_fluidity(rate[c], spread[c], mu_2);
                *g = (step[c] * trial[c]).max(least);
            }
        });
        v.mesh.halo.update(v.exec, &mut self.g.cells.data);
        Ok(())
    }

    fn balance(&self) -> Balance<'_> {
        Balance {
            law: self.law,
            a: &self.eqn.a,
            linear: &self.linear,
            linear_b: &self.linear_b,
            g_old: &self.g_old,
            rate: &self.rate,
            local: &self.local,
            spread: &self.spread,
            held: &self.held,
        }
    }

    /// Solves for `step`; adds what it took to `info`.
    fn solve(&mut self, exec: &Exec, info: &mut RheologyInfo) -> Result<(), RheologyError> {
        let failed = |source| RheologyError::Solve { field: "fluidity", source };
        let solver = &mut self.numerics.solver;
        solver.refresh(exec, &self.eqn.a).map_err(failed)?;
        let tolerance = &self.numerics.tolerance;
        let result = solver.solve(exec, &self.eqn.a, &self.eqn.b, &mut self.step, tolerance);
        info.solves += 1;
        info.iterations += match result {
            Ok(done) | Err(SolveError::Spent(done)) => done.iterations,
            // Some way is better than none: Newton's residual judges.
            Err(SolveError::NotConverged(done)) => {
                info.unconverged += 1;
                done.iterations
            }
            Err(e) => return Err(failed(e)),
        };
        Ok(())
    }

    /// The fluidity at the strain rate of the flow, and at its stress where the rate has no solution.
    fn newton(&mut self, v: &FlowView<'_>) -> Result<RheologyInfo, RheologyError> {
        let mut info = RheologyInfo::default();
        self.held.clear();
        self.start_from_local_law(v, &mut info)?;
        self.iterate(v, &mut info)?;
        if info.residual > UNSOLVED && self.hold_stress(v) {
            self.iterate(v, &mut info)?;
        }
        Ok(info)
    }

    /// At a given strain rate the equation may have no solution near by, where grains above yield are fed
    /// from beside (`g > 2 g_loc`): the sink then falls as g grows. At a given stress it has one. Holds
    /// the stress ratio of such cells; false where no stress is known, and where there is no
    /// other fluid and so no reason to give up the rate.
    fn hold_stress(&mut self, v: &FlowView<'_>) -> bool {
        if v.stress.is_none() || v.share.is_none() {
            return false;
        }
        let Granular { mu_2, floors: Floors { still, .. }, .. } = self.law.grains;
        let most = mu_2 - LEAST_LEFT * self.law.grains.delta_mu();
        let (terms, mu, spread) = (&self.terms, &self.mu, &self.spread);
        self.held.resize(v.mesh.n_cells, f64::NAN);
        v.exec.for_each(&mut self.held, |first, held| {
            for (i, held) in held.iter_mut().enumerate() {
                let c = first + i;
                let fed = terms[c].of_rate > 0.0 || terms[c].imbalance.abs() > UNSOLVED;
                *held = match fed {
                    true => mu[c].min(most / (1.0 + spread[c])).max(still),
                    false => f64::NAN,
                };
            }
        });
        true
    }

    /// Newton in ln g at frozen strain rate, or stress where `held` says so, damped by a pseudo-time step
    /// that grows as the residual falls (C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508).
    /// Rows are divided by the size of their terms and columns by g, so that every decade counts alike.
    fn iterate(&mut self, v: &FlowView<'_>, info: &mut RheologyInfo) -> Result<(), RheologyError> {
        let n = v.mesh.n_cells;
        let mut terms = std::mem::take(&mut self.terms);
        let mut trial_terms = std::mem::take(&mut self.trial_terms);
        let mut residual = self.balance().of(v, &self.g.cells.data, &mut terms);
        let mut tau = 1.0;
        let mu_2 = self.law.grains.mu_2;
        for _ in 0..MOST_NEWTON {
            if residual <= self.numerics.residual || tau < 1e-12 {
                break;
            }
            let g = &self.g.cells.data;
            let Equation { a, b, .. } = &mut self.eqn;
            let (ptr, diag, col, linear) = (&a.ptr, &a.diag, &a.col, &self.linear);
            let (volume, t) = (&v.mesh.volume, &terms);
            v.exec.for_each_row(ptr, &mut a.val, b, |first, val, b| {
                let base = ptr[first] as usize;
                for (i, b) in b.iter_mut().enumerate() {
                    let c = first + i;
                    let unit = 1.0 / (volume[c] * t[c].size);
                    for k in ptr[c] as usize..ptr[c + 1] as usize {
                        val[k - base] = linear[k] * g[col[k] as usize] * unit;
                    }
                    val[diag[c] as usize - base] += t[c].slope * g[c] / t[c].size + 1.0 / tau;
                    *b = t[c].imbalance;
                }
            });
            self.step.fill(0.0);
            self.solve(v.exec, info)?;
            let (step, rate, g) = (&self.step, &self.rate, &self.g.cells.data);
            let (spread, held) = (&self.spread, &self.held);
            v.exec.for_each(&mut self.trial[..n], |first, out| {
                for (i, trial) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let moved = g[c] * step[c].clamp(-2.0, 2.0).exp();
                    *trial = match held.get(c).is_some_and(|mu| mu.is_finite()) {
                        true => moved,
                        false => moved.max(least_fluidity(rate[c], spread[c], mu_2)),
                    };
                }
            });
            v.mesh.halo.update(v.exec, &mut self.trial);
            let next = self.balance().of(v, &self.trial, &mut trial_terms);
            if next < 2.0 * residual + 1e-3 {
                tau = (tau * 2.0 * (residual / next.max(1e-300)).max(0.5)).min(1e6);
                std::mem::swap(&mut self.g.cells.data, &mut self.trial);
                std::mem::swap(&mut terms, &mut trial_terms);
                residual = next;
            } else {
                tau *= 0.1;
            }
        }
        (self.terms, self.trial_terms) = (terms, trial_terms);
        info.residual = residual;
        Ok(())
    }

    /// The spread of mu within each cell, where the stress is known.
    fn measure_spread(&mut self, v: &FlowView<'_>) {
        let Some(stress) = v.stress else {
            let (rate, local, grains) = (&self.rate, &self.local, self.law.grains);
            v.exec.for_each(&mut self.mu[..v.mesh.n_cells], |first, mu| {
                for (i, mu) in mu.iter_mut().enumerate() {
                    *mu = grains.mu(rate[first + i] / local[first + i]);
                }
            });
            return self.spread.fill(0.0);
        };
        let (pressure, loose) = (v.pressure, self.law.grains.loose());
        v.exec.for_each(&mut self.mu[..v.mesh.n_cells], |first, mu| {
            for (i, mu) in mu.iter_mut().enumerate() {
                *mu = stress[first + i] / pressure[first + i].max(loose);
            }
        });
        v.mesh.halo.update(v.exec, &mut self.mu);
        self.fit.spread(v, &self.mu, &mut self.spread);
    }

    /// The linear part of the equation with the conditions of g, and the local rates.
    fn prepare(&mut self, v: &FlowView<'_>) -> Result<(), RheologyError> {
        let n = v.mesh.n_cells;
        self.local_rates(v);
        self.measure_spread(v);
        self.enclose(v);
        let (law, mu, local) = (self.law, &self.mu, &self.local);
        v.exec.for_each(&mut self.trial[..n], |first, g| {
            let each = g.iter_mut().enumerate();
            each.for_each(|(i, g)| *g = law.g_loc(mu[first + i], local[first + i]));
        });
        let around = Surroundings {
            time: v.time,
            local_fluidity: &self.trial[..n],
            ..Surroundings::default()
        };
        self.g.update(v.exec, v.mesh, &around, Some(v.flux));
        let lhs: Terms<'_, f64> = match self.law.form {
            Form::Steady => -laplacian(&self.spreads),
            Form::Primitive { t0 } => {
                let k = t0 / (self.law.a * self.law.grains.d).powi(2);
                let (flux, spreads) = (&v.flux.data, &self.spreads.data);
                v.exec.for_each2(
                    &mut self.carried.data,
                    &mut self.upwind.data,
                    |first, carried, weight| {
                        for i in 0..carried.len() {
                            let inside = spreads[first + i] > 0.0;
                            carried[i] = if inside { k * flux[first + i] } else { 0.0 };
                            weight[i] = if flux[first + i] >= 0.0 { 1.0 } else { 0.0 };
                        }
                    },
                );
                -laplacian(&self.spreads) + div(&self.carried, &self.upwind)
            }
        };
        self.eqn.assemble(v.exec, v.mesh, &self.g, &lhs)?;
        self.linear.copy_from_slice(&self.eqn.a.val);
        self.linear_b.copy_from_slice(&self.eqn.b);
        Ok(())
    }

    /// The fluidity lives in the grains: no flux of it through their surface. A face counts by
    /// the harmonic mean of its cells' shares, which vanishes with either, so that the equation of a
    /// cell that grains fill in part is that of the part (the diffuse domain of X. Li, J. Lowengrub,
    /// A. Raetz, A. Voigt, Commun. Math. Sci. 7 (2009) 81).
    fn enclose(&mut self, v: &FlowView<'_>) {
        let Some(share) = v.share else { return };
        v.exec.for_each(&mut self.spreads.data, |first, out| {
            for (i, spreads) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = share.now[v.mesh.owner[f] as usize];
                let n = v.mesh.neighbour.get(f).map_or(o, |&n| share.now[n as usize]);
                *spreads = if o.min(n) < Share::NONE { 0.0 } else { 2.0 * o * n / (o + n) };
            }
        });
    }

    /// Cells that grains have reached since the last step have the mean fluidity of the grains beside
    /// them.
    fn reach_new_cells(&mut self, v: &FlowView<'_>) {
        if v.share.is_none() {
            return;
        }
        v.mesh.halo.update(v.exec, &mut self.g.cells.data);
        let (g, mesh) = (&self.g.cells.data, v.mesh);
        v.exec.for_each(&mut self.trial[..mesh.n_cells], |first, out| {
            for (i, new) in out.iter_mut().enumerate() {
                let c = first + i;
                *new = g[c];
                let reached = v.has(c) && v.share.is_some_and(|s| s.old[c] < Share::NONE);
                if !reached || g[c] > 0.0 {
                    continue;
                }
                let (mut sum, mut of) = (0.0, 0.0);
                for (f, _) in mesh.faces_of(c) {
                    let Some(&n) = mesh.neighbour.get(f) else { continue };
                    let other = if n as usize == c { mesh.owner[f] } else { n } as usize;
                    if g[other] > 0.0 {
                        sum += g[other];
                        of += 1.0;
                    }
                }
                *new = if of > 0.0 { sum / of } else { 0.0 };
            }
        });
        self.g.cells.data[..mesh.n_cells].copy_from_slice(&self.trial[..mesh.n_cells]);
        v.mesh.halo.update(v.exec, &mut self.g.cells.data);
    }

    /// Where there are no grains there is no fluidity.
    fn leave_the_rest(&mut self, v: &FlowView<'_>) {
        if v.share.is_none() {
            return;
        }
        v.exec.for_each(&mut self.g.cells.data, |first, g| {
            for (i, g) in g.iter_mut().enumerate() {
                if !v.has(first + i) {
                    *g = 0.0;
                }
            }
        });
    }

    /// In the steady form, beside another fluid, grains under no pressure are out of contact: they carry no stress, have no
    /// fluidity, and what is in contact ends at them. (Their stress ratio is what a floor on the pressure makes of it,
    /// and where it comes to lie above mu_s beside faster grains, the equation at a given rate has no
    /// solution near by. The primitive form remembers, and has one.) `touching` is filled with the share of
    /// the others.
    fn part<'a>(&self, v: &FlowView<'a>, touching: &'a mut [f64]) -> FlowView<'a> {
        let Some(share) = v.share.filter(|_| self.law.form == Form::Steady) else { return *v };
        let (pressure, loose) = (v.pressure, self.law.grains.loose());
        v.exec.for_each(touching, |first, out| {
            for (i, share_of) in out.iter_mut().enumerate() {
                let c = first + i;
                *share_of = if pressure[c] > loose { share.now[c] } else { 0.0 };
            }
        });
        FlowView { share: Some(Share { now: touching, ..share }), ..*v }
    }

    /// Viscosity, paper eq. 1: `eta = P/g`; none where there are no grains in contact.
    fn viscosity(&self, v: &FlowView<'_>, eta: &mut CellField<f64>) {
        let (g, loose, pressure) = (&self.g.cells.data, self.law.grains.loose(), v.pressure);
        let least = self.law.grains.floors.fluidity * f64::EPSILON;
        v.exec.for_each(&mut eta.data[..v.mesh.n_cells], |first, out| {
            for (i, eta) in out.iter_mut().enumerate() {
                let c = first + i;
                let there = v.has(c) && (v.share.is_none() || g[c] > 0.0);
                *eta = if there { pressure[c].max(loose) / g[c].max(least) } else { 0.0 };
            }
        });
    }
}

/// The fluidity at which mu reaches mu_2 somewhere in the cell.
fn least_fluidity(rate: f64, spread: f64, mu_2: f64) -> f64 {
    rate * (1.0 + spread) / mu_2 * (1.0 + 1e-12)
}

/// Imbalance of the equation over its terms from which on it is not solved.
const UNSOLVED: f64 = 1e-6;
/// Share of `mu_2 - mu_s` that is left of a stress ratio that is held.
const LEAST_LEFT: f64 = 0.02;
/// Most Newton iterations of one update.
const MOST_NEWTON: usize = 200;

impl Rheology for Ngf {
    fn update(
        &mut self,
        v: &FlowView<'_>,
        eta: &mut CellField<f64>,
    ) -> Result<RheologyInfo, RheologyError> {
        // Without a fluidity to start from there is none to remember: grains that are about to move
        // are in equilibrium with the first guess of their rate. (Remembering zero would hold
        // them rigid for as long as dt is less than t0.)
        let first = !self.known && !self.remembers;
        let v = &FlowView { dt: if first { f64::INFINITY } else { v.dt }, ..*v };
        let mut touching = std::mem::take(&mut self.touching);
        let part = &self.part(v, &mut touching);
        let info = self.prepare(part).and_then(|()| self.newton(part));
        if first {
            self.g_old.copy_from_slice(&self.g.cells.data);
        }
        self.leave_the_rest(part);
        self.viscosity(part, eta);
        self.touching = touching;
        self.known = true;
        let mut info = info?;
        info.beyond = beyond(v, &self.law.grains);
        Ok(info)
    }
    fn begin_step(&mut self) {
        self.remembers = false;
        self.g_old.copy_from_slice(&self.g.cells.data);
    }
    fn rollback(&mut self) {
        self.g.cells.data.copy_from_slice(&self.g_old);
    }
    fn forget(&mut self) {
        self.remembers = self.known && self.law.form != Form::Steady;
        self.g.cells.data.fill(0.0);
        self.known = false;
    }
    fn recall(&mut self, v: &FlowView<'_>, eta: &mut CellField<f64>) -> bool {
        let g = &self.g.cells.data;
        let unknown = |c: usize| v.has(c) && g[c] <= 0.0;
        // Cells that grains have just reached take it from where they came from; a rank may have none.
        let has = (0..v.mesh.n_cells).any(|c| g[c] > 0.0);
        let lacks = v.share.is_none() && (0..v.mesh.n_cells).any(unknown);
        let mut of_all = [has, lacks].map(|is| f64::from(u8::from(is)));
        v.exec.comm().max(&mut of_all);
        self.known |= of_all[0] > 0.0 && of_all[1] <= 0.0;
        if self.known {
            self.reach_new_cells(v);
            let mut touching = std::mem::take(&mut self.touching);
            let part = &self.part(v, &mut touching);
            self.viscosity(part, eta);
            self.touching = touching;
        }
        self.known
    }
    fn reads_pressure(&self) -> bool {
        true
    }
    fn field(&self) -> Option<&CellField<f64>> {
        Some(&self.g.cells)
    }
    fn field_mut(&mut self) -> Option<&mut CellField<f64>> {
        Some(&mut self.g.cells)
    }
    fn conditions(&self) -> &[Box<dyn Condition<f64>>] {
        &self.g.conditions
    }
    fn grains(&self) -> Option<Granular> {
        Some(self.law.grains)
    }
}
