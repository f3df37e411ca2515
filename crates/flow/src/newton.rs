//! Newton's method for laws whose viscosity depends on the strain rate and the pressure of the
//! place alone: the viscosity is no unknown of its own, its change follows that of velocity and
//! pressure inside the operator of the coupled solve.
//!
//! With `eta(rate, P)` in a cell, `d eta = eta (m d rate/rate + q dP)`: m is zero for a Newtonian
//! fluid and -1 where a material yields without hardening. The viscosity as the flow has it, held
//! for a pass (Kachanov's method, L. M. Kachanov, Foundations of the Theory of Plasticity (1971)),
//! leaves `-m` of an error; the steps of Newton's method are taken where they bring the imbalance
//! of forces down, halved until they do (J. E. Dennis, R. B. Schnabel, Numerical Methods for
//! Unconstrained Optimization (1983), section 6.3), and one of Kachanov's where no part of them
//! does.

use crate::{Flow, StepError};
use granflow_base::{Dims, Tensor, Value, Vec3, double_dot};
use granflow_fv::{CellField, FaceField, Reconstruction, Unknown, operators};
use granflow_linsolve::Solved;
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// A step must bring the imbalance down by this part of what a linear problem would give.
const ENOUGH: f64 = 1e-4;
/// Halvings of a step before the viscosity is held for a pass.
const HALVINGS: usize = 6;

/// Scratch of the method.
pub(crate) struct Newton {
    /// Whether the present pass lets the viscosity follow.
    pub(crate) active: bool,
    /// Whether the last step of Newton's method was refused.
    refused: bool,
    /// `d ln(eta)/d ln(rate)` and `d ln(eta)/dP` in the cells.
    pub(crate) rate_slope: Vec<f64>,
    pub(crate) pressure_slope: Vec<f64>,
    /// Twice the strain rate tensor of the state and of a direction, and the shares behind both.
    twice_strain: Vec<Tensor>,
    change: Vec<Tensor>,
    shares: Vec<[f64; 3]>,
    /// Viscous force on faces per unit of viscosity.
    per_viscosity: FaceField<Vec3>,
    d_ln_eta: CellField<f64>,
    /// Where the pass began.
    u: Vec<Vec3>,
    p: Vec<f64>,
}

impl Newton {
    pub(crate) fn new(m: &Mesh, local: bool) -> Self {
        // Only laws that can use it pay for it.
        let (cells, all) = if local { (m.n_cells, m.n_all()) } else { (0, 0) };
        Newton {
            active: false,
            refused: false,
            rate_slope: vec![0.0; cells],
            pressure_slope: vec![0.0; cells],
            twice_strain: vec![[0.0; 9]; cells],
            change: vec![[0.0; 9]; cells],
            shares: vec![[0.0; 3]; cells],
            per_viscosity: FaceField::new(m, "viscous force", Dims::NONE, [0.0; 3]),
            d_ln_eta: CellField::new(m, "ln(eta)'", Dims::NONE, 0.0),
            u: vec![[0.0; 3]; all],
            p: vec![0.0; all],
        }
    }
    /// To be called as a step begins.
    pub(crate) fn begin_step(&mut self) {
        (self.active, self.refused) = (false, false);
    }
}

impl Flow {
    /// Whether the viscosity follows the flow inside the coupled solve.
    pub(crate) fn has_newton(&self) -> bool {
        self.fluid.rheology.is_local() && !self.fluid.rheology.is_constant()
    }

    /// Strain rate of the cells from the velocity alone, into `work.strain_rate`. The cell
    /// gradients must be up to date.
    pub(crate) fn local_strain_rate(&mut self) {
        let n = self.mesh.n_cells;
        let Flow { exec, mesh, state, work: w, .. } = self;
        let Newton { twice_strain, shares, .. } = &mut w.newton;
        w.reconstruction.twice_strain(exec, mesh, &state.u, &w.grad_u, shares, twice_strain);
        let twice_strain = &*twice_strain;
        exec.for_each(&mut w.strain_rate[..n], |first, out| {
            for (i, rate) in out.iter_mut().enumerate() {
                *rate = granflow_physics::rheology::magnitude(&twice_strain[first + i]);
            }
        });
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
        self.force_per_viscosity();
        let Flow { state, work: w, .. } = self;
        w.newton.u.copy_from_slice(&state.u.cells.data);
        w.newton.p.copy_from_slice(&state.p.cells.data);
        let solved = self.solve_coupled(dt, wanted)?;
        let (start, mut share) = (solved[0].first, 1.0);
        for _ in 0..=HALVINGS {
            if self.imbalance_of_state(dt)? <= (1.0 - ENOUGH * share) * start {
                return Ok(solved);
            }
            share *= 0.5;
            self.back_towards_start(0.5, dt);
        }
        self.back_towards_start(0.0, dt);
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

    /// Viscous force on the faces for a viscosity of one.
    fn force_per_viscosity(&mut self) {
        let Flow { exec, mesh, state, work: w, numerics, .. } = self;
        numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
        let (u, gradient) = (&state.u, &w.grad_u);
        let leaning =
            (mesh.max_nonorth_deg > 0.1 && numerics.non_orthogonal > 0.0).then_some(&gradient[..]);
        exec.for_each(&mut w.newton.per_viscosity.data, |first, out| {
            for (i, force) in out.iter_mut().enumerate() {
                let f = first + i;
                let dudn = operators::normal_derivative(mesh, u, leaning, f);
                let both = dudn.plus(operators::transpose_derivative(mesh, gradient, f, dudn));
                *force = both.scaled(mesh.mag_area[f]);
            }
        });
    }
}

impl Newton {
    /// Adds to `stress`, the viscous force on faces for a change `du` of velocity and `dp` of
    /// pressure, what their change of viscosity makes of the present flow. `gradient` is that of
    /// `du`; `rate` in the cells and `eta` on the
    /// faces belong to the state.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn add_change_of_viscosity(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        reconstruction: &Reconstruction,
        (du, gradient): (&Unknown<Vec3>, &[Tensor]),
        dp: &[f64],
        (rate, eta): (&[f64], &FaceField<f64>),
        stress: &mut FaceField<Vec3>,
    ) {
        let Newton { change, shares, twice_strain, rate_slope, pressure_slope, d_ln_eta, .. } =
            self;
        reconstruction.change_of_strain(exec, mesh, du, gradient, shares, change);
        let change = &*change;
        exec.for_each(&mut d_ln_eta.data[..mesh.n_cells], |first, out| {
            for (i, d_ln_eta) in out.iter_mut().enumerate() {
                let c = first + i;
                // rate^2 = E:E/2, so that d ln(rate) = E:dE/(2 rate^2).
                let d_ln_rate = if rate_slope[c] == 0.0 {
                    0.0
                } else {
                    0.5 * double_dot(&twice_strain[c], &change[c]) / (rate[c] * rate[c])
                };
                *d_ln_eta = rate_slope[c] * d_ln_rate + pressure_slope[c] * dp[c];
            }
        });
        mesh.halo.update(exec, &mut d_ln_eta.data);
        let (d_ln_eta, force) = (&d_ln_eta.data, &self.per_viscosity.data);
        exec.for_each(&mut stress.data, |first, out| {
            for (i, t) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = mesh.owner[f] as usize;
                // Of the geometric mean between cells.
                let d_ln = match mesh.neighbour.get(f) {
                    Some(&n) => {
                        let (w, n) = (mesh.weight[f], n as usize);
                        w * d_ln_eta[o] + (1.0 - w) * d_ln_eta[n]
                    }
                    None => d_ln_eta[o],
                };
                *t = t.axpy(d_ln * eta.data[f], force[f]);
            }
        });
    }
}
