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

mod contact;
mod law;
mod rates;
mod solve;
mod spread;

pub use law::{Form, Law};

use self::contact::Contact;
use self::law::Local;
use self::spread::InnerFit;
use super::beyond::beyond;
use super::{
    Entry, FlowView, FluidContext, Granular, Rheology, RheologyError, RheologyInfo, Share,
};
use granflow_base::Dims;
use granflow_dict::Reader;
use granflow_fv::conditions::ZeroGradient;
use granflow_fv::{
    CellField, Condition, Equation, FaceField, Surroundings, Terms, Unknown, div, laplacian,
};
use granflow_linsolve::{LinearSolver, Tolerance};
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
    /// Whether `g` is the solution of an earlier update of this step, from which the next one follows.
    follows: bool,
    /// Whether the last update did so.
    followed: bool,
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
    contact: Contact,
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
            follows: false,
            followed: false,
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
            contact: Contact::new(all),
        }
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
        let mut contact = std::mem::take(&mut self.contact);
        let part = &self.part(v, &mut contact);
        let info = self.prepare(part).and_then(|()| self.newton(part));
        if first {
            self.g_old.copy_from_slice(&self.g.cells.data);
        }
        self.leave_the_rest(part);
        self.viscosity(part, eta);
        self.contact = contact;
        self.known = true;
        let mut info = info?;
        info.beyond = beyond(v, &self.law.grains);
        Ok(info)
    }
    fn begin_step(&mut self) {
        self.contact.begin_step();
        self.remembers = false;
        (self.follows, self.followed) = (false, false);
        self.g_old.copy_from_slice(&self.g.cells.data);
    }
    fn doubt(&mut self) -> bool {
        self.follows = false;
        std::mem::take(&mut self.followed)
    }
    fn rollback(&mut self) {
        self.g.cells.data.copy_from_slice(&self.g_old);
    }
    fn forget(&mut self) {
        self.remembers = self.known && self.law.form != Form::Steady;
        self.g.cells.data.fill(0.0);
        (self.known, self.follows) = (false, false);
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
            let mut contact = std::mem::take(&mut self.contact);
            let part = &self.part(v, &mut contact);
            self.viscosity(part, eta);
            self.contact = contact;
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
