//! Newton's method for laws whose viscosity depends on the strain rate and the pressure of the
//! place alone: the viscosity is no unknown of its own, its change follows that of velocity and
//! pressure inside the operator of the coupled solve.
//!
//! With `eta(rate, P)` on a face, `d eta = eta (m d rate/rate + q dP)`: m is zero for a Newtonian
//! fluid and -1 where a material yields without hardening. The viscosity as the flow has it, held
//! for a pass (Kachanov's method, L. M. Kachanov, Foundations of the Theory of Plasticity (1971)),
//! leaves `-m` of an error; the steps of Newton's method are taken where they bring the imbalance
//! of forces down, halved until they do (J. E. Dennis, R. B. Schnabel, Numerical Methods for
//! Unconstrained Optimization (1983), section 6.3), and one of Kachanov's where no part of them
//! does.

use crate::two_phase::sparse;
use crate::{Flow, StepError};
use granflow_base::{Tensor, Value, Vec3, apply, dot, double_dot, symm};
use granflow_fv::{FaceField, Reconstruction, Unknown, operators};
use granflow_linsolve::Solved;
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::{LawValues, Points, magnitude};

/// A step must bring the imbalance down by this part of what a linear problem would give.
const ENOUGH: f64 = 1e-4;
/// Halvings of a step before the viscosity is held for a pass.
const HALVINGS: usize = 6;
/// Share of the neighbouring cells' mean in the strain rate of a face. Without it the law on the
/// faces does not converge where all of a material is at yield (mu(I) from rest with short steps,
/// Bingham on several cells along the flow): neighbouring faces that yield by turns are then as good
/// a solution as any. With 0.1, 0.25 and 1 it does (book, "The nonlinear iteration"); the error
/// beside a yield surface grows with it.
const SHARED: f64 = 0.1;

/// Least share of a material's stiffness that Newton's method gives it along its flow. A material that
/// yields without hardening has none there; where all of a body yields, only inertia resists, and the
/// linear problem is not solved. With a share that the law does not have the error of a pass does not
/// vanish, but falls to a share of itself. This is where grains beside another fluid begin; elsewhere there is none.
const LEAST_STIFFNESS: f64 = 0.05;
/// Share of its residual that a linear problem keeps from which on the stiffness doubles.
const STALLED: f64 = 0.5;

/// Scratch of the method.
pub(crate) struct Newton {
    /// Whether the present pass lets the viscosity follow.
    pub(crate) active: bool,
    /// Whether the last step of Newton's method was refused.
    pub(crate) refused: bool,
    /// Least share of stiffness along the flow, [`LEAST_STIFFNESS`] or more, or 0.
    stiffness: f64,
    /// Twice the strain rate tensor of the cells and the shares of their faces in it.
    twice_strain: Vec<Tensor>,
    shares: Vec<[f64; 3]>,
    /// Strain rate of the cells, 1/s, with ghosts.
    cell_rate: Vec<f64>,
    /// Changes of `twice_strain` and `cell_rate` with a direction.
    change: Vec<Tensor>,
    d_rate: Vec<f64>,
    /// Strain rate, pressure between grains (Pa), viscosity (Pa s) and its logarithm's slopes
    /// `d ln(eta)/d ln(rate)` and `d ln(eta)/dP` on the faces.
    rate: Vec<f64>,
    pressure: Vec<f64>,
    pub(crate) eta: Vec<f64>,
    slopes: Vec<[f64; 2]>,
    /// `d eta/d ln eta_1` of the viscosity on faces, Pa s: that viscosity itself but where fluids mix.
    pub(crate) response: Vec<f64>,
    /// `grad U + grad U^T` on the faces, 1/s, and its magnitude.
    face_strain: Vec<Tensor>,
    own_rate: Vec<f64>,
    /// Where the pass began.
    u: Vec<Vec3>,
    p: Vec<f64>,
}

impl Newton {
    pub(crate) fn new(m: &Mesh, local: bool) -> Self {
        // Only laws that can use it pay for it.
        let (cells, all, faces) =
            if local { (m.n_cells, m.n_all(), m.n_faces()) } else { (0, 0, 0) };
        Newton {
            active: false,
            refused: false,
            stiffness: 0.0,
            twice_strain: vec![[0.0; 9]; cells],
            shares: vec![[0.0; 3]; cells],
            cell_rate: vec![0.0; all],
            change: vec![[0.0; 9]; cells],
            d_rate: vec![0.0; all],
            rate: vec![0.0; faces],
            pressure: vec![0.0; faces],
            eta: vec![0.0; faces],
            slopes: vec![[0.0; 2]; faces],
            response: vec![0.0; faces],
            face_strain: vec![[0.0; 9]; faces],
            own_rate: vec![0.0; faces],
            u: vec![[0.0; 3]; all],
            p: vec![0.0; all],
        }
    }
    /// To be called as a step begins.
    pub(crate) fn begin_step(&mut self, beside_fluid: bool) {
        (self.active, self.refused) = (false, false);
        self.stiffness = if beside_fluid { LEAST_STIFFNESS } else { 0.0 };
    }
}

impl Flow {
    /// Whether the viscosity follows the flow inside the coupled solve.
    pub(crate) fn has_newton(&self) -> bool {
        self.fluid.rheology.is_local() && !self.fluid.rheology.is_constant() && self.is_coupled()
    }

    /// Strain rate of the cells from the velocity alone, into `work.strain_rate`. The cell
    /// gradients must be up to date.
    pub(crate) fn local_strain_rate(&mut self) {
        let n = self.mesh.n_cells;
        let least = self.least_rate();
        let Flow { exec, mesh, state, work: w, .. } = self;
        let Newton { twice_strain, shares, .. } = &mut w.newton;
        w.reconstruction.twice_strain(exec, mesh, &state.u, &w.grad_u, shares, twice_strain);
        let twice_strain = &*twice_strain;
        exec.for_each(&mut w.strain_rate[..n], |first, out| {
            for (i, rate) in out.iter_mut().enumerate() {
                *rate = magnitude(&twice_strain[first + i]).max(least(mesh.cell_size(first + i)));
            }
        });
    }

    /// Least strain rate over a given length.
    fn least_rate(&self) -> impl Fn(f64) -> f64 + Sync + use<> {
        let (share, fall) = (self.work.slowest, self.free_fall());
        move |size| if share > 0.0 { share * fall.rate(size) } else { 0.0 }
    }

    /// The law on the faces: at the strain rate of their own differences but for what they share
    /// with their neighbours ([`SHARED`]), and the pressure that their cells have in the mean. The
    /// cell gradients of velocity and `work.strain_rate` must be up to date.
    pub(crate) fn evaluate_law_on_faces(&mut self) {
        let least = self.least_rate();
        let Flow { exec, mesh, state, work: w, fluid, gravity, two_phase, .. } = self;
        let grains = two_phase.as_ref().and_then(|t| t.work.grains.as_ref());
        let pressure_of_cells = &w.pressure;
        let (u, p, gradient) = (&state.u, &state.p, &w.grad_u);
        let Newton { cell_rate, rate, pressure, eta, slopes, face_strain, own_rate, .. } =
            &mut w.newton;
        exec.for_each2(face_strain, own_rate, |first, strain, rate| {
            for i in 0..rate.len() {
                strain[i] = strain_on_face(mesh, u, gradient, first + i);
                rate[i] = magnitude(&strain[i]);
            }
        });
        let own_rate = &*own_rate;
        cell_rate[..mesh.n_cells].copy_from_slice(&w.strain_rate[..mesh.n_cells]);
        mesh.halo.update(exec, cell_rate);
        let density = &w.rho.data;
        let cell_rate = &*cell_rate;
        exec.for_each2(rate, pressure, |first, rate, pressure| {
            for i in 0..rate.len() {
                let f = first + i;
                rate[i] = match mesh.neighbour.get(f) {
                    Some(_) => SHARED * between(mesh, cell_rate, f) + (1.0 - SHARED) * own_rate[f],
                    None => own_rate[f],
                }
                .max(least(if f < mesh.n_inner { 1.0 } else { 2.0 } / mesh.inv_dist[f]));
                let (here, x) = (mesh.owner[f] as usize, mesh.face_centre[f]);
                let weight = density[here] * dot(gravity.hydrostatic, x);
                pressure[i] = match (mesh.neighbour.get(f), grains) {
                    (Some(_), None) => between(mesh, &p.cells.data, f) + weight,
                    (Some(_), Some(_)) => between(mesh, pressure_of_cells, f),
                    (None, None) => p.boundary_value(mesh, f) + weight,
                    (None, Some(grains)) => {
                        p.boundary_value(mesh, f) + weight - grains.pore.at(here, x)
                    }
                };
            }
        });
        let points = Points { strain_rate: rate, pressure, density: fluid.rho };
        fluid.rheology.at_points(exec, &points, LawValues { viscosity: eta, slopes });
    }

    /// One pass: velocity, pressure and flux change by a step of Newton's method, or by one with
    /// the viscosity held where no part of the last step of Newton's method was any good. On entry
    /// momentum is assembled with the viscosity of the flow as it stands.
    pub(crate) fn newton_pass(&mut self, dt: f64, wanted: f64) -> Result<[Solved; 2], StepError> {
        self.work.newton.active = !self.work.newton.refused;
        self.work.newton.refused = false;
        if !self.work.newton.active {
            return self.solve_coupled(dt, wanted);
        }
        let Flow { state, work: w, .. } = self;
        w.newton.u.copy_from_slice(&state.u.cells.data);
        w.newton.p.copy_from_slice(&state.p.cells.data);
        let solved = self.solve_coupled(dt, wanted)?;
        let (start, mut share) = (solved[0].first, 1.0);
        let stiffness = &mut self.work.newton.stiffness;
        if solved[0].last > STALLED * start {
            // Elsewhere there is none to double: `bagnold` would not converge from rest.
            *stiffness = (2.0 * *stiffness).min(1.0);
        }
        for _ in 0..=HALVINGS {
            if self.imbalance_of_state(dt)? <= (1.0 - ENOUGH * share) * start {
                return Ok(solved);
            }
            share *= 0.5;
            self.back_towards_start(0.5, dt);
        }
        let Flow { state, work: w, .. } = self;
        state.u.cells.data.copy_from_slice(&w.newton.u);
        state.p.cells.data.copy_from_slice(&w.newton.p);
        self.update_conditions();
        self.interpolate_flux_of_state(dt);
        self.work.newton.refused = true;
        Ok(solved)
    }

    /// Imbalance of momentum and continuity, viscosity up to date, in the units of the pass.
    fn imbalance_of_state(&mut self, dt: f64) -> Result<f64, StepError> {
        self.evaluate_rheology(dt)?;
        self.try_viscosity();
        self.assemble_momentum(dt)?;
        self.momentum_residual();
        self.update_mobility(dt);
        self.interpolate_flux_of_state(dt);
        Ok(self.imbalance())
    }

    /// The state becomes `start + share (state - start)`.
    fn back_towards_start(&mut self, share: f64, dt: f64) {
        let Flow { exec, state, work: w, .. } = self;
        let (u, p) = (&w.newton.u, &w.newton.p);
        exec.for_each2(&mut state.u.cells.data, &mut state.p.cells.data, |first, us, ps| {
            for i in 0..us.len() {
                let (u, p) = (u[first + i], p[first + i]);
                us[i] = u.axpy(share, us[i].minus(u));
                ps[i] = p + share * (ps[i] - p);
            }
        });
        self.update_conditions();
        self.interpolate_flux_of_state(dt);
    }
}

impl Newton {
    /// Adds to `stress`, the viscous force on faces for a change `du` of velocity and `dp` of
    /// pressure, what their change of viscosity makes of the present flow. `gradient` is that of
    /// `du`. A face bears `eta S.E` with `E = grad U + grad U^T`.
    pub(crate) fn add_change_of_viscosity(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        reconstruction: &Reconstruction,
        (du, gradient): (&Unknown<Vec3>, &[Tensor]),
        (dp, share): (&Unknown<f64>, Option<&[f64]>),
        stress: &mut FaceField<Vec3>,
    ) {
        let Newton { twice_strain, shares, cell_rate, change, d_rate, .. } = self;
        reconstruction.change_of_strain(exec, mesh, du, gradient, shares, change);
        let change = &*change;
        exec.for_each(&mut d_rate[..mesh.n_cells], |first, out| {
            for (i, d_rate) in out.iter_mut().enumerate() {
                let c = first + i;
                // rate^2 = E:E/2.
                let rate = cell_rate[c];
                *d_rate = match rate > 0.0 {
                    true => 0.5 * double_dot(&twice_strain[c], &change[c]) / rate,
                    false => 0.0,
                };
            }
        });
        mesh.halo.update(exec, d_rate);
        let d_rate = &*d_rate;
        let (rate, slopes, response) = (&self.rate, &self.slopes, &self.response);
        // Without one the slope is the law's, whatever it is.
        let least = self.stiffness;
        let softest = if least > 0.0 { least - 1.0 } else { f64::NEG_INFINITY };
        exec.for_each(&mut stress.data, |first, out| {
            for (i, t) in out.iter_mut().enumerate() {
                let f = first + i;
                let [of_rate, of_pressure] = slopes[f];
                if of_rate == 0.0 && of_pressure == 0.0 {
                    continue;
                }
                let e = strain_on_face(mesh, du, gradient, f);
                let own = self.own_rate[f].max(f64::MIN_POSITIVE);
                let mut change = 0.5 * double_dot(&self.face_strain[f], &e) / own;
                let dp = match mesh.neighbour.get(f) {
                    Some(&n) => {
                        change = SHARED * between(mesh, d_rate, f) + (1.0 - SHARED) * change;
                        let bears = |c: u32| share.is_none_or(|s| !sparse(s[c as usize]));
                        let of = |c: u32| if bears(c) { dp.cells.data[c as usize] } else { 0.0 };
                        let w = mesh.weight[f];
                        w * of(mesh.owner[f]) + (1.0 - w) * of(n)
                    }
                    None => dp.boundary_value(mesh, f),
                };
                let mut d_ln_eta = of_pressure * dp;
                if of_rate != 0.0 {
                    let of_rate = if of_rate < softest { softest } else { of_rate };
                    d_ln_eta += of_rate * change / rate[f];
                }
                *t = t.axpy(d_ln_eta * response[f], apply(&self.face_strain[f], mesh.area[f]));
            }
        });
    }
}

/// Linear interpolation to inner face `f`.
#[inline]
fn between(mesh: &Mesh, x: &[f64], f: usize) -> f64 {
    let w = mesh.weight[f];
    w * x[mesh.owner[f] as usize] + (1.0 - w) * x[mesh.neighbour[f] as usize]
}

/// `grad U + grad U^T` on face `f`.
#[inline]
fn strain_on_face(mesh: &Mesh, u: &Unknown<Vec3>, gradient: &[Tensor], f: usize) -> Tensor {
    let g = operators::face_gradient(mesh, u, gradient, mesh.max_nonorth_deg > 0.1, f);
    symm(&g).scaled(2.0)
}
