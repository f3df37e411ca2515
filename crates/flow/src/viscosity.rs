//! The viscosity of an outer iteration: from the flow to the rheology and back.

use crate::two_phase::sparse;
use crate::{Flow, StepError};
use granflow_base::{Tensor, dot};
use granflow_fv::{FaceField, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::{FlowView, RheologyInfo, magnitude};

/// Smallest viscosity, Pa s: below any material's; it only keeps logarithms finite where grains
/// are out of contact.
const LEAST: f64 = 1e-12;
/// Strain rate, over the greatest, below which a cell counts as being at rest.
const AT_REST: f64 = 1e-9;
/// Speed over that of a free fall through a cell below which all cells count so.
const STANDING_STILL: f64 = 1e-9;
/// Relative error of a velocity difference over that of a velocity: rounding, times the contrast
/// of viscosity between neighbours that a stress is averaged over.
const ROUNDING: f64 = 1e-13;

impl Flow {
    /// Pressure between grains, P = p_rgh + rho G.x less what the fluid around them bears, Pa.
    pub(crate) fn total_pressure(&mut self) -> Result<(), StepError> {
        let Flow { exec, mesh, state, work: w, gravity, .. } = self;
        let (p, rho, g) = (&state.p.cells.data, &w.rho.data, gravity.hydrostatic);
        exec.for_each(&mut w.pressure[..mesh.n_cells], |first, out| {
            for (i, total) in out.iter_mut().enumerate() {
                let c = first + i;
                *total = p[c] + rho[c] * dot(g, mesh.cell_centre[c]);
            }
        });
        self.relieve_grains()?;
        self.mesh.halo.update(&self.exec, &mut self.work.pressure);
        Ok(())
    }

    /// The viscosity as the step begins: the rheology's own field if it has one, else the flow's
    /// present strain rate. A function of the state alone, so that a restart repeats it.
    pub(crate) fn recall_viscosity(&mut self, dt: f64) -> Result<(), StepError> {
        self.total_pressure()?;
        let time = self.state.time;
        let n = self.mesh.n_cells;
        // No viscosity yet: the strain rate comes from the velocity alone.
        if !self.fluid.rheology.is_constant() {
            let local = self.has_newton();
            let Flow { exec, mesh, work: w, state, numerics, .. } = self;
            numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
            if local {
                self.local_strain_rate();
            } else {
                strain_rate_of(exec, &w.grad_u, &mut w.strain_rate[..n]);
            }
        }
        self.evaluate_surrounding_fluid(dt)?;
        let Flow { exec, mesh, work: w, fluid, state, two_phase, .. } = self;
        let two = two_phase.as_deref();
        let view = FlowView {
            exec,
            mesh,
            time,
            dt,
            strain_rate: &w.strain_rate,
            stress: None,
            pressure: &w.pressure,
            density: &w.rho.data,
            flux: two.map_or(&state.phi, |t| t.vof.alpha_phi()),
            share: two.and_then(|t| t.shares()),
        };
        if !fluid.rheology.recall(&view, &mut w.eta) {
            fluid
                .rheology
                .update(&view, &mut w.eta)
                .map_err(|source| StepError::Rheology { time, source })?;
        }
        if let Some(grains) = two_phase.as_ref().and_then(|t| t.work.grains.as_ref()) {
            grains.lend_viscosity(exec, &mut w.eta.data[..n]);
        }
        if self.has_newton() {
            self.evaluate_law_on_faces();
        }
        self.spread_viscosity();
        if self.has_compatible_viscosity() {
            self.viscosity_between_cells();
        }
        Ok(())
    }

    /// What the rheology makes of the flow, into `eta_new`. The strain rate that a local law sees
    /// is that of the velocity; a model with a field of its own sees the mean stress of the cell
    /// over the viscosity it was computed with, which is what keeps steep profiles exact (see
    /// [`granflow_fv::Reconstruction::viscous_stress`]).
    pub(crate) fn evaluate_rheology(&mut self, dt: f64) -> Result<RheologyInfo, StepError> {
        self.total_pressure()?;
        let time = self.state.time;
        let n = self.mesh.n_cells;
        let Flow { exec, mesh, work: w, state, numerics, .. } = self;
        numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
        self.strain_rate_of_state();
        self.evaluate_surrounding_fluid(dt)?;
        let Flow { exec, mesh, work: w, fluid, state, two_phase, .. } = self;
        let two = two_phase.as_deref();
        // A model with a field of its own sees the stress as it is.
        if fluid.rheology.is_local() {
            let (rate, eta) = (&w.strain_rate, &w.eta.data);
            exec.for_each(&mut w.tau[..n], |first, tau| {
                tau.iter_mut().enumerate().for_each(|(i, t)| *t = eta[first + i] * rate[first + i]);
            });
        }
        // A local law carries what it says at this rate; `eta` may be of another trial.
        let nonlocal = !fluid.rheology.is_local();
        let view = FlowView {
            exec,
            mesh,
            time,
            dt,
            strain_rate: &w.strain_rate,
            stress: nonlocal.then_some(&w.tau[..]),
            pressure: &w.pressure,
            density: &w.rho.data,
            flux: two.map_or(&state.phi, |t| t.vof.alpha_phi()),
            share: two.and_then(|t| t.shares()),
        };
        let info = fluid
            .rheology
            .update(&view, &mut w.eta_new)
            .map_err(|source| StepError::Rheology { time, source })?;
        if self.has_newton() {
            self.evaluate_law_on_faces();
        }
        let Flow { exec, work: w, two_phase, .. } = self;
        if let Some(grains) = two_phase.as_ref().and_then(|t| t.work.grains.as_ref()) {
            grains.lend_viscosity(exec, &mut w.eta_new.data[..n]);
        }
        let eta_new = &w.eta_new.data;
        exec.for_each(&mut w.g_of_y, |first, y| {
            y.iter_mut().enumerate().for_each(|(i, y)| *y = eta_new[first + i].max(LEAST).ln());
        });
        Ok(info)
    }

    /// The strain rate that the rheology sees, into `work.strain_rate`. The cell gradients of
    /// velocity must be up to date.
    pub(crate) fn strain_rate_of_state(&mut self) {
        if self.has_newton() {
            return self.local_strain_rate();
        }
        let Flow { exec, mesh, work: w, state, two_phase, .. } = self;
        w.reconstruction.viscous_stress(exec, mesh, &state.u, &w.grad_u, &w.eta_f, &mut w.stress);
        let (stress, eta) = (&w.stress, &w.eta.data);
        let grains = two_phase.as_ref().and_then(|t| t.work.grains.as_ref());
        let n = mesh.n_cells;
        exec.for_each2(&mut w.strain_rate[..n], &mut w.tau[..n], |first, out, tau| {
            for (i, rate) in out.iter_mut().enumerate() {
                let c = first + i;
                let stress = magnitude(&stress[c]);
                *rate = match grains {
                    None => stress / eta[c],
                    Some(grains) => grains.rate(c, stress, eta[c]),
                };
                tau[i] = eta[c] * *rate;
            }
        });
        self.mean_viscosity_where_coarse();
    }

    /// Takes `eta_new` in cells and on faces, but leaves the logarithms where the pass began.
    pub(crate) fn try_viscosity(&mut self) {
        let n = self.mesh.n_cells;
        self.work.eta.data[..n].copy_from_slice(&self.work.eta_new.data[..n]);
        self.viscosity_to_faces();
    }

    /// Ghosts and faces of `eta`.
    fn viscosity_to_faces(&mut self) {
        let (newton, constant) = (self.has_newton(), self.fluid.rheology.is_constant());
        let Flow { exec, mesh, work: w, two_phase, .. } = self;
        mesh.halo.update(exec, &mut w.eta.data);
        let share = two_phase.as_ref().and_then(|t| t.share());
        if newton {
            w.eta_f.data.copy_from_slice(&w.newton.eta);
        } else {
            viscosity_on_faces(exec, mesh, (constant, share), &w.eta.data, &mut w.eta_f);
        }
        self.press_faces();
        let Flow { exec, mesh, work: w, two_phase, .. } = self;
        let grains = two_phase.as_mut().and_then(|t| t.work.grains.as_mut());
        if let Some(grains) = grains {
            grains.mix(exec, mesh, &w.eta.data, &mut w.eta_f);
            if newton {
                let (eta, response) = (&w.eta_f.data, &grains.response);
                exec.for_each(&mut w.newton.response, |first, out| {
                    let each = out.iter_mut().enumerate();
                    each.for_each(|(i, r)| *r = eta[first + i] * response[first + i]);
                });
            }
        } else if newton {
            w.newton.response.copy_from_slice(&w.newton.eta);
        }
        self.viscosity_meets_walls();
    }

    /// Ghosts, faces and logarithms of `eta`.
    pub(crate) fn spread_viscosity(&mut self) {
        self.viscosity_to_faces();
        let Flow { exec, work: w, .. } = self;
        let eta = &w.eta.data;
        exec.for_each(&mut w.y, |first, y| {
            y.iter_mut().enumerate().for_each(|(i, y)| *y = eta[first + i].max(LEAST).ln());
        });
    }

    /// The greatest change of ln(viscosity), that of the mixture, that taking `eta_new` would make, among the cells that
    /// move at all: a strain rate of a billionth of the greatest, or what the rounding of the
    /// velocity alone can make of it, is no movement.
    pub(crate) fn viscosity_residual(&self) -> f64 {
        let (y, g, rate) = (&self.work.y, &self.work.g_of_y, &self.work.strain_rate);
        let (mesh, u) = (&self.mesh, &self.state.u.cells.data);
        let n = y.len();
        if self.rests() {
            return 0.0;
        }
        let grains = self.grains();
        // Beside grains the stress of a fluid is theirs, and a strain rate made of it is none.
        let counts = |c: usize| grains.is_none_or(|grains| !sparse(grains.share[c]));
        let of = |c: usize| if counts(c) { rate[c] } else { 0.0 };
        let fastest = self.exec.max(n, |r| r.map(of).fold(0.0, f64::max));
        let change = |c: usize| {
            if !counts(c) || rate[c] < AT_REST * fastest {
                return 0.0;
            }
            let shortest = mesh.faces_of(c).map(|(f, _)| mesh.inv_dist[f]).fold(0.0, f64::max);
            let rounding = ROUNDING * granflow_base::norm(u[c]) * shortest / rate[c];
            let change = match grains {
                Some(grains) if grains.share[c] < 1.0 => grains.change(c, y[c].exp(), g[c].exp()),
                _ => (g[c] - y[c]).abs(),
            };
            let change = change - rounding;
            // What is no number is no small change.
            if change.is_nan() { f64::INFINITY } else { change.max(0.0) }
        };
        self.exec.max(n, |r| r.map(change).fold(0.0, f64::max))
    }

    /// Whether grains and the fluid around them stand still: of strain rates that are rounding a viscosity
    /// is no more than that.
    pub(crate) fn rests(&self) -> bool {
        let fall = self.free_fall();
        if fall.g == 0.0 {
            return false;
        }
        let (mesh, u) = (&self.mesh, &self.state.u.cells.data);
        let speed = |c: usize| granflow_base::norm(u[c]) / fall.speed(mesh.cell_size(c));
        self.exec.max(mesh.n_cells, |r| r.map(speed).fold(0.0, f64::max)) < STANDING_STILL
    }

    /// Takes `eta_new` as it is: at the end of a step the viscosity is the rheology's own.
    pub(crate) fn accept_viscosity(&mut self) {
        let n = self.mesh.n_cells;
        self.work.eta.data[..n].copy_from_slice(&self.work.eta_new.data[..n]);
        self.spread_viscosity();
    }

    /// Where grains have come into contact beside a fluid or out of it, the viscosity is taken as it is: the jump, of ten decades at
    /// times, has no history, and as what is too long is shortened as a whole, it would hold all others back.
    fn take_contact(&mut self) {
        let Flow { exec, work: w, two_phase, .. } = self;
        let Some(grains) = two_phase.as_ref().and_then(|t| t.work.grains.as_ref()) else { return };
        let new = &w.g_of_y;
        exec.for_each(&mut w.y, |first, y| {
            for (i, y) in y.iter_mut().enumerate() {
                let c = first + i;
                if grains.is_lent(c, y.exp()) != grains.is_lent(c, new[c].exp()) {
                    *y = new[c];
                }
            }
        });
    }

    /// Mixes `eta_new` with the history of the outer iterations (Anderson, in logarithms).
    pub(crate) fn mix_viscosity(&mut self) {
        self.take_contact();
        let w = &mut self.work;
        w.anderson.mix(&self.exec, &mut w.y, &w.g_of_y);
        let y = &w.y;
        let n = y.len();
        self.exec.for_each(&mut w.eta.data[..n], |first, eta| {
            eta.iter_mut().enumerate().for_each(|(i, e)| *e = y[first + i].exp());
        });
        self.viscosity_to_faces();
    }

    /// Where `eta = P/g` with a fluidity of its own, faces have the linear mean of P over the
    /// geometric mean of g: both exact where the weight of grains makes P and creep makes g. The
    /// geometric mean of eta alone lacks 13 % on the face below a free surface, where P is zero. Grains out of contact
    /// were lent the fluid's viscosity, which is no P/g: there the mean of the viscosities is linear.
    fn press_faces(&mut self) {
        let Flow { exec, mesh, work: w, fluid, two_phase, .. } = self;
        let nonlocal = !fluid.rheology.is_local();
        let Some(loose) = fluid.rheology.grains().filter(|_| nonlocal).map(|g| g.loose()) else {
            return;
        };
        let grains = two_phase.as_ref().and_then(|t| t.work.grains.as_ref());
        let share = grains.map(|g| &g.share[..]);
        let (pressure, of_cells) = (&w.pressure, &w.eta.data);
        let apart = |c: usize| grains.is_some_and(|g| g.is_lent(c, of_cells[c]));
        exec.for_each(&mut w.eta_f.data[..mesh.n_inner], |first, eta| {
            for (i, eta) in eta.iter_mut().enumerate() {
                let f = first + i;
                let [o, n] = [mesh.owner[f], mesh.neighbour[f]].map(|c| c as usize);
                let t = weight_beyond(share, [o, n], 1.0 - mesh.weight[f]);
                if apart(o) || apart(n) {
                    *eta = (1.0 - t) * of_cells[o] + t * of_cells[n];
                    continue;
                }
                let r = pressure[n].max(loose) / pressure[o].max(loose);
                if r != 1.0 && t > 0.0 && t < 1.0 {
                    *eta *= (1.0 - t + t * r) / r.powf(t);
                }
            }
        });
    }
}

/// `sqrt(2 D:D)` of velocity gradients, 1/s.
pub(crate) fn strain_rate_of(exec: &Exec, gradient: &[Tensor], out: &mut [f64]) {
    exec.for_each(out, |first, out| {
        for (i, rate) in out.iter_mut().enumerate() {
            *rate = (2.0 * granflow_base::double_dot_sym(&gradient[first + i])).sqrt();
        }
    });
}

/// Weight of the neighbour `cells[1]` in a mean of what only the material in the cells has, `weight` where
/// both are full of it: by how much each holds.
pub(crate) fn weight_beyond(share: Option<&[f64]>, cells: [usize; 2], weight: f64) -> f64 {
    let Some(share) = share else { return weight };
    let [o, n] = cells.map(|c| share[c]);
    match o == n {
        true if o == 0.0 => 0.0,
        true => weight,
        false => weight * n / ((1.0 - weight) * o + weight * n),
    }
}

/// Viscosity on faces: between cells the weighted geometric mean, exact where viscosity changes
/// exponentially, as it does in creeping zones; at the boundary the cell's.
fn viscosity_on_faces(
    exec: &Exec,
    mesh: &Mesh,
    (constant, share): (bool, Option<&[f64]>),
    eta: &[f64],
    out: &mut FaceField<f64>,
) {
    if constant {
        return operators::to_faces(exec, mesh, eta, out);
    }
    exec.for_each(&mut out.data, |first, out| {
        for (i, v) in out.iter_mut().enumerate() {
            let f = first + i;
            let here = mesh.owner[f] as usize;
            let o = eta[here];
            *v = match mesh.neighbour.get(f) {
                Some(&there) => {
                    let (there, w) = (there as usize, mesh.weight[f]);
                    // A ratio, so that equal neighbours give their value to the bit.
                    match weight_beyond(share, [here, there], 1.0 - w) {
                        0.0 => o,
                        1.0 => eta[there],
                        t => o * (eta[there] / o).powf(t),
                    }
                }
                None => o,
            };
        }
    });
}
