//! What the time schemes remember from step to step, and steps of their own for every cell.

use crate::two_phase::Carried;
use crate::{Flow, LocalSteps, TimeScheme};
use granflow_base::Value;
use granflow_fv::CellField;

/// Most passes over the mesh that even out local steps. Each lets a step differ by the allowed
/// growth one cell further; beyond them steps differ by many powers of it already.
const SMOOTHING: usize = 200;

impl Flow {
    /// Keeps what the next step's time derivative needs of this one, of length `dt`.
    ///
    /// The Crank-Nicolson scheme with OpenFOAM's `psi` is
    /// `((1 + psi) (U - U0)/dt - psi R0) = F`, with `R = (1 + psi) (U - U0)/dt - psi R0` handed
    /// on. With `U00 = U0 - dt R0` it has the form of differences over two steps, and what is handed
    /// on is `U - dt R`. With two fluids it is momentum that is handed on, as a velocity times the density,
    /// and what convection moved is no part of it ([`crate::two_phase`]).
    pub(crate) fn remember_old(&mut self, dt: f64) {
        let c = self.ddt_coefficients(dt);
        let grains = self.has_grains_in_fluid();
        let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
        if !matches!(numerics.ddt, TimeScheme::CrankNicolson(_)) {
            state.u_old.copy_from_slice(&w.u_start);
            state.phi_old.copy_from_slice(&w.phi_start);
            return;
        }
        let [c0, c1, c2] = c;
        let (u, start) = (&state.u.cells.data, &w.u_start);
        let carried = Carried { flux: &w.rho_phi.data, weights: &w.weights.data, correction: None };
        let convected = two_phase.as_ref().map(|t| &t.work.convected);
        let convected = convected.filter(|convected| !grains && convected.is_known());
        let densities = two_phase.as_ref().map(|t| (&w.rho.data, &t.work.rho_old.data));
        exec.for_each(&mut state.u_old[..mesh.n_cells], |first, old| {
            for (i, old) in old.iter_mut().enumerate() {
                let c = first + i;
                let ratio = densities.map_or(1.0, |(now, then)| then[c] / now[c]);
                let mut rate = u[c].scaled(c0).axpy(-c1 * ratio, start[c]).axpy(c2 * ratio, *old);
                if let (Some(convected), Some((rho, _))) = (convected, densities) {
                    let leaves = convected.leaves(mesh, &state.u, &carried, c);
                    rate = rate.axpy(dt / (rho[c] * mesh.volume[c]), leaves);
                }
                *old = u[c].minus(rate);
            }
        });
        mesh.halo.update(exec, &mut state.u_old);
        let (phi, start) = (&state.phi.data, &w.phi_start);
        exec.for_each(&mut state.phi_old, |first, old| {
            for (i, old) in old.iter_mut().enumerate() {
                let f = first + i;
                *old = phi[f] - (c0 * phi[f] - c1 * start[f] + c2 * *old);
            }
        });
    }

    /// Where cells have steps of their own: the density that stands for them in a step of `dt`, from
    /// the flux as it stands.
    pub(crate) fn set_local_steps(&mut self, dt: f64) {
        let TimeScheme::Local(LocalSteps { courant, longest, growth }) = self.numerics.ddt else {
            return;
        };
        let Flow { exec, mesh, state, work: w, .. } = self;
        let n = mesh.n_cells;
        let phi = &state.phi.data;
        let (local, next) = w.local.get_or_insert_with(|| {
            let mut scratch = w.rho.data.clone();
            scratch.fill(0.0);
            (w.rho.clone(), scratch)
        });
        // One over the step, and then no cell may be much faster than its neighbours.
        let rates = &mut local.data;
        exec.for_each(&mut rates[..n], |first, out| {
            for (i, rate) in out.iter_mut().enumerate() {
                let c = first + i;
                let through: f64 = mesh.faces_of(c).map(|(f, _)| phi[f].abs()).sum();
                *rate = (0.5 * through / (courant * mesh.volume[c])).max(1.0 / longest);
            }
        });
        for _ in 0..SMOOTHING {
            mesh.halo.update(exec, rates);
            let all = &*rates;
            exec.for_each(&mut next[..n], |first, out| {
                for (i, rate) in out.iter_mut().enumerate() {
                    let c = first + i;
                    let mut most = all[c];
                    for (f, s) in mesh.faces_of(c).filter(|(f, _)| *f < mesh.n_inner) {
                        let of = if s > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] };
                        most = most.max(all[of as usize] / (1.0 + growth));
                    }
                    *rate = most;
                }
            });
            let (old, new) = (&rates[..n], &next[..n]);
            let changed = exec.max(n, |r| r.map(|c| new[c] - old[c]).fold(0.0, f64::max));
            rates[..n].copy_from_slice(&next[..n]);
            if changed == 0.0 {
                break;
            }
        }
        mesh.halo.update(exec, rates);
        let rho = &w.rho.data;
        exec.for_each(rates, |first, out| {
            out.iter_mut().enumerate().for_each(|(i, rate)| *rate *= rho[first + i] * dt);
        });
    }
}

/// A density and scratch of its size; see `Work::local`.
pub(crate) type Local = Option<(CellField<f64>, Vec<f64>)>;

/// The density that inertia has: the fluid's, `rho`, but for cells with steps of their own.
pub(crate) fn inertia<'a>(rho: &'a CellField<f64>, local: &'a Local) -> &'a CellField<f64> {
    local.as_ref().map_or(rho, |(rho, _)| rho)
}
