//! How the equation of the fluidity is solved: Newton's method in ln g at the strain rate of the flow, from the
//! branch that leads to the true root.

use super::Ngf;
use super::law::{Form, Law, Local};
use crate::rheology::{FlowView, Granular, RheologyError, RheologyInfo};
use granflow_fv::Equation;
use granflow_linsolve::{Csr, SolveError};
use granflow_par::Exec;

/// The fluidity at which mu reaches mu_2 somewhere in the cell.
fn least_fluidity(rate: f64, spread: f64, mu_2: f64) -> f64 {
    rate * (1.0 + spread) / mu_2 * (1.0 + 1e-12)
}

/// Most Newton iterations of one update, and of one that follows from the last.
const MOST_NEWTON: usize = 200;
const FEW: usize = 12;
/// First step of pseudo-time from the local law and from the last update, in units of each equation's own.
const FAR: f64 = 1.0;
const NEAR: f64 = 1e3;

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
                *t = self.law.cell_mean(g[c], g_old, rate, spread, local, v.dt);
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

    /// The fluidity at the strain rate of the flow.
    pub(super) fn newton(&mut self, v: &FlowView<'_>) -> Result<RheologyInfo, RheologyError> {
        let mut info = RheologyInfo::default();
        self.followed = false;
        if self.follows {
            self.allow_rate(v);
            self.iterate(v, (NEAR, FEW), &mut info)?;
            if info.residual <= self.numerics.residual {
                self.followed = true;
                return Ok(info);
            }
        }
        self.start_from_local_law(v, &mut info)?;
        self.iterate(v, (FAR, MOST_NEWTON), &mut info)?;
        // Beside another fluid single cells come in and out of contact between two updates; in the primitive form
        // a fluidity that dies away is far from that of the pass before.
        let may = v.share.is_none() && self.law.form == Form::Steady;
        self.follows = may && info.residual <= self.numerics.residual;
        Ok(info)
    }

    /// Below it mu would reach mu_2.
    fn allow_rate(&mut self, v: &FlowView<'_>) {
        let (rate, spread, mu_2) = (&self.rate, &self.spread, self.law.grains.mu_2);
        v.exec.for_each(&mut self.g.cells.data[..v.mesh.n_cells], |first, g| {
            for (i, g) in g.iter_mut().enumerate() {
                *g = g.max(least_fluidity(rate[first + i], spread[first + i], mu_2));
            }
        });
        v.mesh.halo.update(v.exec, &mut self.g.cells.data);
    }

    /// Newton in ln g at frozen strain rate, damped by a pseudo-time step that grows as the residual falls
    /// (C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508).
    /// Rows are divided by the size of their terms and columns by g, so that every decade counts alike.
    /// Begins with a step of `tau` and takes `most` at most.
    fn iterate(
        &mut self,
        v: &FlowView<'_>,
        (mut tau, most): (f64, usize),
        info: &mut RheologyInfo,
    ) -> Result<(), RheologyError> {
        let n = v.mesh.n_cells;
        let mut terms = std::mem::take(&mut self.terms);
        let mut trial_terms = std::mem::take(&mut self.trial_terms);
        let mut residual = self.balance().of(v, &self.g.cells.data, &mut terms);
        let mu_2 = self.law.grains.mu_2;
        for _ in 0..most {
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
            let spread = &self.spread;
            v.exec.for_each(&mut self.trial[..n], |first, out| {
                for (i, trial) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let moved = g[c] * step[c].clamp(-2.0, 2.0).exp();
                    *trial = moved.max(least_fluidity(rate[c], spread[c], mu_2));
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
}
