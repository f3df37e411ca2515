//! Momentum interpolation: the flux through a face from the momentum of its two cells.
//!
//! The flux is that of the interpolated velocity, with the compact pressure gradient over the face
//! in place of the interpolated one (C. M. Rhie, W. L. Chow, AIAA J. 21 (1983) 1525), and the old
//! flux in place of the interpolated old velocity. The mobility of a face keeps inertia apart from
//! the rest, so that a steady flux knows nothing of the time step (A. Cubero, N. Fueyo, Numer.
//! Heat Transfer B 52 (2007) 507). Open boundaries are faces like others: `u_f` is there what the
//! condition makes of the cell's velocity.

use crate::time::inertia;
use crate::work::Work;
use crate::{Flow, Numerics, State, TimeScheme, TwoPhase};
use granflow_base::{Tensor, Value, Vec3, dot};
use granflow_fv::{Convection, FaceField, Unknown, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// The mobility of all cells together exceeds that of one by at most this factor: beyond it the
/// time step is infinite as far as the mesh can tell.
const MOST_MOBILE: f64 = 1e6;
/// The mobility of all cells together also answers to what flows through a cell, by this share of
/// the flux: what is washed away has no time to gather speed. Without it a steady flow's mobility
/// is that of a single cell near walls and without bounds elsewhere, and the pressure it
/// preconditions useless. Between 0.03 and 1 the share matters little.
const WASHED_AWAY: f64 = 0.1;
/// A short time over the step, for rates of change at boundaries.
const SHORT: f64 = 1e-3;

/// What a flux is interpolated from.
pub(crate) struct Interpolated<'a> {
    /// The velocity's conditions.
    pub(crate) u: &'a Unknown<Vec3>,
    /// Velocity in cells and ghosts, m/s.
    pub(crate) cells: &'a [Vec3],
    /// Its gradient where faces are skewed, 1/s.
    pub(crate) skewed: Option<&'a [Tensor]>,
    /// The pressure's gradient in cells and ghosts, Pa/m, and
    pub(crate) grad_p: &'a [Vec3],
    /// its normal derivative on faces.
    pub(crate) dp_dn: &'a [f64],
    /// Velocity per pressure gradient on faces.
    pub(crate) mobility: &'a [f64],
    /// Weights of the owners' velocities on inner faces, where they are not those of distance.
    pub(crate) weights: &'a [f64],
}

/// `phi = S . u_f + r_f (S . (grad p)_f - |S| dp/dn)`.
pub(crate) fn interpolated_flux(
    exec: &Exec,
    mesh: &Mesh,
    of: &Interpolated<'_>,
    phi: &mut FaceField<f64>,
) {
    let Interpolated { u, cells, skewed, grad_p, dp_dn, mobility, weights } = of;
    plain_flux(exec, mesh, (u, cells), weights, phi);
    if let Some(gradient) = skewed {
        operators::add_skew_flux(exec, mesh, 1.0, gradient, phi);
    }
    exec.for_each(&mut phi.data, |first, out| {
        for (i, phi) in out.iter_mut().enumerate() {
            let f = first + i;
            let o = mesh.owner[f] as usize;
            let wide = match mesh.neighbour.get(f) {
                Some(&n) => {
                    let w = mesh.weight[f];
                    let between = grad_p[o].scaled(w).axpy(1.0 - w, grad_p[n as usize]);
                    dot(between, mesh.area[f])
                }
                None => {
                    // Where the cell's velocity leaves through the boundary, its own pressure
                    // gradient is in it already.
                    let open = open_share(u, f - mesh.n_inner);
                    if open > 0.0 { open * dot(grad_p[o], mesh.area[f]) } else { 0.0 }
                }
            };
            *phi += mobility[f] * (wide - mesh.mag_area[f] * dp_dn[f]);
        }
    });
}

/// `S . u_f`, by distance or by `weights`.
fn plain_flux(
    exec: &Exec,
    mesh: &Mesh,
    (u, cells): (&Unknown<Vec3>, &[Vec3]),
    weights: &[f64],
    phi: &mut FaceField<f64>,
) {
    operators::flux(exec, mesh, u, cells, phi);
    if weights.is_empty() {
        return;
    }
    exec.for_each(&mut phi.data[..mesh.n_inner], |first, out| {
        for (i, phi) in out.iter_mut().enumerate() {
            let f = first + i;
            let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
            let w = weights[f] - mesh.weight[f];
            if w != 0.0 {
                *phi += w * (dot(cells[o], mesh.area[f]) - dot(cells[n], mesh.area[f]));
            }
        }
    });
}

impl Flow {
    /// Where grains end, the face moves with the mass of its cells, and not half with a fluid that weighs
    /// nothing: else what sloshes in the fluid moves the surface of the grains.
    pub(crate) fn weigh_surfaces(&mut self) {
        let Flow { exec, mesh, work: w, two_phase, .. } = self;
        let Some(share) = two_phase.as_ref().and_then(|t| t.share()) else { return };
        w.flux_weights.resize(mesh.n_inner, 0.0);
        let rho = &w.rho.data;
        exec.for_each(&mut w.flux_weights, |first, out| {
            for (i, weight) in out.iter_mut().enumerate() {
                let f = first + i;
                let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                let jump = (share[o] - share[n]).abs();
                let mass = rho[o] / (rho[o] + rho[n]);
                *weight = mesh.weight[f] + jump * (mass - mesh.weight[f]);
            }
        });
    }

    /// Mobilities of the momentum equation in cells and on faces.
    pub(crate) fn update_mobility(&mut self, dt: f64) {
        let c0 = self.ddt_coefficients(dt)[0];
        let two_fluids = self.two_phase.is_some();
        // A single pass takes the row as it is: its correction of the pressure has no second try.
        let share = if self.is_coupled() { WASHED_AWAY } else { 0.0 };
        let central = self.defers_convection() && self.numerics.convection == Convection::Linear;
        let Flow { exec, mesh, work: w, .. } = self;
        let (eqn, volume, flux) = (&w.u_eqn, &mesh.volume, &w.rho_phi.data);
        let n = mesh.n_cells;
        exec.for_each2(&mut w.r_a.data[..n], &mut w.r_at.data[..n], |first, one, all| {
            for i in 0..one.len() {
                let c = first + i;
                let mut a = eqn.a.val[eqn.a.diag[c] as usize];
                let mut through = 0.0;
                for (f, s) in mesh.faces_of(c) {
                    through += 0.5 * flux[f].abs();
                    if central && f < mesh.n_inner {
                        // The flux does not ask how convection is solved.
                        let here = if s > 0.0 { mesh.weight[f] } else { 1.0 - mesh.weight[f] };
                        a += s * flux[f] * here - f64::max(s * flux[f], 0.0);
                    }
                }
                // Not dominant in a cell that more enters than leaves: its size counts.
                let a = a.abs();
                one[i] = volume[c] / a;
                let row = eqn.row_sum[c].max(0.0) + share * through;
                all[i] = volume[c] / row.max(a / MOST_MOBILE).min(a);
            }
        });
        mesh.halo.update(exec, &mut w.r_a.data);
        mesh.halo.update(exec, &mut w.r_at.data);
        if two_fluids {
            // As forces over density, which are smooth beside an interface.
            let r_at = &w.r_at.data;
            exec.for_each(&mut w.r_at_f.data, |first, out| {
                for (i, r) in out.iter_mut().enumerate() {
                    let f = first + i;
                    let o = r_at[mesh.owner[f] as usize];
                    *r = match mesh.neighbour.get(f) {
                        Some(&n) => {
                            let w = mesh.weight[f];
                            1.0 / (w / o + (1.0 - w) / r_at[n as usize])
                        }
                        None => o,
                    };
                }
            });
        } else {
            operators::to_faces(exec, mesh, &w.r_at.data, &mut w.r_at_f);
        }
        let (r_a, rho) = (&w.r_a.data, &inertia(&w.rho, &w.local).data);
        exec.for_each(&mut w.r_a_f.data, |first, out| {
            let inertia = |c: u32| rho[c as usize] * c0 / dt;
            let steady = |c: u32| {
                let one = r_a[c as usize];
                one / (1.0 - inertia(c) * one).max(1.0 / MOST_MOBILE)
            };
            for (i, r) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = mesh.owner[f];
                let (rest, inertia) = match mesh.neighbour.get(f) {
                    Some(&n) => {
                        let w = mesh.weight[f];
                        // Beside a fluid that hardly resists, what resists decides.
                        let rest = match two_fluids {
                            true => 1.0 / (w / steady(o) + (1.0 - w) / steady(n)),
                            false => w * steady(o) + (1.0 - w) * steady(n),
                        };
                        (rest, inertia(o) + (1.0 - w) * (inertia(n) - inertia(o)))
                    }
                    None => (steady(o), inertia(o)),
                };
                *r = rest / (1.0 + inertia * rest);
            }
        });
        if self.numerics.compatible {
            self.mobility_of_one_cell();
        }
    }

    /// The flux of velocity and pressure as they stand, into the state.
    pub(crate) fn interpolate_flux_of_state(&mut self, dt: f64) {
        {
            let Flow { exec, mesh, state, numerics, work: w, two_phase, .. } = self;
            let two = two_phase.as_deref_mut();
            w.slopes_of_pressure(exec, mesh, numerics, two, Slopes::Of(&state.p));
            let skewed = mesh.is_skewed();
            if skewed {
                numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
            }
            let of = Interpolated {
                u: &state.u,
                cells: &state.u.cells.data,
                skewed: skewed.then_some(&w.grad_u[..]),
                grad_p: &w.grad_p,
                dp_dn: &w.dp_dn,
                mobility: &w.r_a_f.data,
                weights: &w.flux_weights,
            };
            interpolated_flux(exec, mesh, &of, &mut state.phi);
        }
        self.take_frames_from(|flow| &mut flow.state.phi);
        self.add_memory(dt, |flow| &mut flow.state.phi);
    }

    /// The flux (into `phi_star`) of the velocity that momentum gives each cell from its
    /// neighbours with the present pressure gradient (into `hby_a`).
    pub(crate) fn interpolate_flux_of_momentum(&mut self, dt: f64) {
        {
            let Flow { exec, mesh, state, numerics, work: w, .. } = self;
            let n = mesh.n_cells;
            w.u_eqn.jacobi(exec, &state.u.cells.data, &mut w.hby_a[..n]);
            w.slopes_of_pressure(exec, mesh, numerics, None, Slopes::Of(&state.p));
            // Of the velocity as it stands: hby_a has no conditions of its own.
            let skewed = mesh.is_skewed();
            if skewed {
                numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
            }
            let (r_a, grad_p) = (&w.r_a.data, &w.grad_p);
            exec.for_each(&mut w.hby_a[..n], |first, u| {
                for (i, u) in u.iter_mut().enumerate() {
                    let c = first + i;
                    *u = u.axpy(-r_a[c], grad_p[c]);
                }
            });
            mesh.halo.update(exec, &mut w.hby_a);
            if !numerics.compatible {
                let of = Interpolated {
                    u: &state.u,
                    cells: &w.hby_a,
                    skewed: skewed.then_some(&w.grad_u[..]),
                    grad_p: &w.grad_p,
                    dp_dn: &w.dp_dn,
                    mobility: &w.r_a_f.data,
                    weights: &w.flux_weights,
                };
                interpolated_flux(exec, mesh, &of, &mut w.phi_star);
            }
        }
        if self.numerics.compatible {
            self.flux_of_one_cell();
        }
        self.take_frames_from(|flow| &mut flow.work.phi_star);
        self.add_memory(dt, |flow| &mut flow.work.phi_star);
    }

    /// What the old fluxes are ahead of the flux of the old velocities, weighted as the time scheme
    /// does, into `work.ahead`. Called at the old time, with the state as a restart has it.
    pub(crate) fn remember_flux(&mut self, dt: f64) {
        let mut c = self.ddt_coefficients(dt);
        if self.two_phase.is_some() {
            // The older velocity stands for an older momentum.
            c = [c[0], c[0], 0.0];
        }
        self.update_conditions();
        self.work.ahead.data.fill(0.0);
        for (k, older) in [(c[1], false), (-c[2], true)] {
            if k == 0.0 {
                continue;
            }
            let swap = |state: &mut State| {
                std::mem::swap(&mut state.u.cells.data, &mut state.u_old);
                std::mem::swap(&mut state.phi.data, &mut state.phi_old);
            };
            let skewed = self.mesh.is_skewed();
            if older {
                if skewed {
                    self.go_back_at_boundaries();
                }
                swap(&mut self.state);
            }
            {
                let Flow { exec, mesh, state, numerics, work: w, .. } = self;
                let Work { phi_star: plain, grad_u, flux_weights, .. } = w;
                plain_flux(exec, mesh, (&state.u, &state.u.cells.data), flux_weights, plain);
                if skewed {
                    numerics.gradient.of(exec, mesh, &state.u, grad_u);
                    operators::add_skew_flux(exec, mesh, 1.0, grad_u, plain);
                }
            }
            // Nor did frames turn then as they do now.
            let then = self.state.time - if older { self.state.dt_old } else { 0.0 };
            let mut plain = std::mem::take(&mut self.work.phi_star.data);
            self.take_frames(then, &mut plain);
            let phi = &self.state.phi.data;
            self.exec.for_each(&mut self.work.ahead.data, |first, out| {
                for (i, ahead) in out.iter_mut().enumerate() {
                    let f = first + i;
                    *ahead += k * (phi[f] - plain[f]);
                }
            });
            self.work.phi_star.data = plain;
            if older {
                swap(&mut self.state);
                if skewed {
                    self.update_conditions();
                }
            }
        }
        let Flow { exec, mesh, state, work: w, .. } = self;
        let ahead = &mut w.ahead;
        // A boundary has a flux of its own where its velocity or its pressure leaves it one.
        let (u, p) = (&state.u, &state.p);
        exec.for_each(&mut ahead.data[mesh.n_inner..], |first, out| {
            for (i, ahead) in out.iter_mut().enumerate() {
                let b = first + i;
                *ahead *= open_share(u, b).max(1.0 - p.closure.slope[b]);
            }
        });
        if self.numerics.compatible {
            self.limit_memory();
        }
    }

    /// The velocity at boundaries that belongs to the older velocity of the time scheme: gradients of the one need
    /// the other. That of the present time would leave an error that does not fade with the step, since the
    /// memory of fluxes is divided by it.
    ///
    /// What the Crank-Nicolson scheme has in place of the older velocity is the old one less its rate of change times
    /// the step: at boundaries that rate is a difference over a short time.
    fn go_back_at_boundaries(&mut self) {
        let (time, dt) = (self.state.time, self.state.dt_old);
        let short = match self.numerics.ddt {
            TimeScheme::CrankNicolson(_) => SHORT,
            _ => 1.0,
        };
        self.work.boundary_now.copy_from_slice(&self.state.u.closure.offset);
        self.state.time = time - short * dt;
        self.update_conditions();
        self.state.time = time;
        let now = &self.work.boundary_now;
        for (then, now) in self.state.u.closure.offset.iter_mut().zip(now) {
            *then = now.axpy(1.0 / short, then.minus(*now));
        }
    }

    /// Adds to the flux what the old ones were ahead of the old velocities, as far as inertia holds
    /// it: from then on the steady flux is that of a mobility without inertia.
    fn add_memory(&mut self, dt: f64, of: impl Fn(&mut Flow) -> &mut FaceField<f64>) {
        let mut phi = std::mem::take(&mut of(self).data);
        let mesh = &self.mesh;
        let rho = self
            .two_phase
            .as_ref()
            .map_or(&inertia(&self.work.rho, &self.work.local).data, |t| &t.work.rho_old.data);
        let (r_a_f, ahead) = (&self.work.r_a_f.data, &self.work.ahead.data);
        self.exec.for_each(&mut phi, |first, out| {
            for (i, phi) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = rho[mesh.owner[f] as usize];
                let rho = match mesh.neighbour.get(f) {
                    Some(&n) => o + (1.0 - mesh.weight[f]) * (rho[n as usize] - o),
                    None => o,
                };
                *phi += r_a_f[f] * (rho / dt) * ahead[f];
            }
        });
        of(self).data = phi;
    }
}

/// The pressure that slopes are taken of.
pub(crate) enum Slopes<'a> {
    /// The state's, with what weight and surface tension ask of it where there are two fluids.
    Of(&'a Unknown<f64>),
    /// A change of it, `work.p_prime`.
    OfChange,
}

impl Work {
    /// Gradient of a pressure in cells and ghosts (`grad_p`) and its normal derivative on faces
    /// (`dp_dn`): what drives the flow. With two fluids both are what the faces' forces leave of each
    /// other.
    pub(crate) fn slopes_of_pressure(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        numerics: &Numerics,
        two: Option<&mut TwoPhase>,
        of: Slopes<'_>,
    ) {
        let Work { p_prime, grad_p, dp_dn, rho, .. } = self;
        let (p, whole) = match of {
            Slopes::Of(p) => (p, true),
            Slopes::OfChange => (&*p_prime, false),
        };
        if let Some(two) = two {
            return two.work.forces.slopes(
                exec,
                mesh,
                (p, &rho.data),
                (numerics.slanted(), whole),
                (grad_p, dp_dn),
            );
        }
        numerics.gradient_p.of(exec, mesh, p, grad_p);
        let leaning = mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0;
        let corrected = leaning.then_some(&grad_p[..]);
        exec.for_each(dp_dn, |first, out| {
            let each = out.iter_mut().enumerate();
            each.for_each(|(i, d)| {
                *d = operators::normal_derivative(mesh, p, corrected, first + i)
            });
        });
    }
}

/// How much of its cell's normal velocity goes through boundary face `b`.
pub(crate) fn open_share(u: &Unknown<Vec3>, b: usize) -> f64 {
    (u.closure.slope[b] - u.closure.normal[b]).max(0.0)
}
