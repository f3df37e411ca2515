//! Density of the mixture, linear in the volume fraction, its viscosity ([`super::mixing`]), and its mass flux.

use super::mixing::{Mixing, by_direction};
use crate::viscosity::strain_rate_of;
use crate::{Flow, StepError};
use granflow_base::{Value, Vec3, dot};
use granflow_fv::{FaceField, Gradient, Unknown, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::FlowView;

impl Flow {
    /// Density from the volume fraction as it stands, cells and ghosts, into `work.rho`, and what
    /// acts on the bulk along cyclic directions.
    pub(crate) fn mix_density(&mut self) {
        let Flow { exec, state, work: w, fluid, two_phase, gravity, .. } = self;
        let (Some(two), Some(alpha)) = (two_phase, &state.alpha) else { return };
        let (rho_1, rho_2) = (fluid.rho, two.rho_2);
        let a = &alpha.cells.data;
        exec.for_each(&mut w.rho.data, |first, out| {
            for (i, rho) in out.iter_mut().enumerate() {
                let a = a[first + i].clamp(0.0, 1.0);
                *rho = a * rho_1 + (1.0 - a) * rho_2;
            }
        });
        if gravity.driving != [0.0; 3] {
            let (rho, g) = (&w.rho.data, gravity.driving);
            exec.for_each(&mut w.body.data, |first, out| {
                for (i, force) in out.iter_mut().enumerate() {
                    *force = g.map(|g| g * rho[first + i]);
                }
            });
        }
    }

    /// Mass flux through faces that carried momentum in the last step, kg/s; `None` with one fluid.
    pub fn mass_flux(&self) -> Option<&[f64]> {
        self.two_phase.as_ref().map(|_| &self.work.rho_phi.data[..])
    }

    /// `rho phi = (rho_1 - rho_2) alphaPhi + rho_2 phi`: the density moves as the fraction does.
    pub(crate) fn mix_mass_flux(&mut self) {
        let Flow { exec, work: w, fluid, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let (alpha_phi, phi) = (&two.vof.alpha_phi().data, &two.work.carrier.data);
        let (difference, rho_2) = (fluid.rho - two.rho_2, two.rho_2);
        exec.for_each(&mut w.rho_phi.data, |first, out| {
            for (i, m) in out.iter_mut().enumerate() {
                *m = difference * alpha_phi[first + i] + rho_2 * phi[first + i];
            }
        });
    }

    /// Viscosity of each fluid at the strain rate as it stands, mixed in the cells and linear
    /// between them, or mixed on faces where their direction counts.
    pub(crate) fn mix_viscosity_of_fluids(&mut self, dt: f64) -> Result<(), StepError> {
        self.total_pressure()?;
        let time = self.state.time;
        let Flow { exec, mesh, state, work: w, fluid, two_phase, numerics, .. } = self;
        let (Some(two), Some(alpha)) = (two_phase, &state.alpha) else { return Ok(()) };
        let n = mesh.n_cells;
        if !(fluid.rheology.is_constant() && two.rheology_2.is_constant()) {
            numerics.gradient.of(exec, mesh, &state.u, &mut w.grad_u);
            strain_rate_of(exec, &w.grad_u, &mut w.strain_rate[..n]);
        }
        let view = FlowView {
            exec,
            mesh,
            time,
            dt,
            strain_rate: &w.strain_rate,
            stress: None,
            pressure: &w.pressure,
            density: &w.rho.data,
            flux: &state.phi,
            share: None,
        };
        let failed = |source| StepError::Rheology { time, source };
        fluid.rheology.update(&view, &mut w.eta).map_err(failed)?;
        two.rheology_2.update(&view, &mut w.eta_new).map_err(failed)?;
        let directed = two.mixing == Mixing::FaceDirection;
        if directed {
            mesh.halo.update(exec, &mut w.eta.data);
            mesh.halo.update(exec, &mut w.eta_new.data);
            Gradient::GaussLinear.of(exec, mesh, alpha, &mut w.grad_p);
            let each = [&w.eta.data, &w.eta_new.data].map(|eta| &eta[..]);
            mix_faces(exec, mesh, alpha, &w.grad_p, each, &mut w.eta_f);
        }
        let (a, eta_2, mixing) = (&alpha.cells.data, &w.eta_new.data, two.mixing);
        exec.for_each(&mut w.eta.data[..n], |first, eta| {
            for (i, eta) in eta.iter_mut().enumerate() {
                *eta = mixing.in_cell(a[first + i], *eta, eta_2[first + i]);
            }
        });
        mesh.halo.update(exec, &mut w.eta.data);
        if !directed {
            operators::to_faces(exec, mesh, &w.eta.data, &mut w.eta_f);
        }
        Ok(())
    }
}

/// Viscosity on faces by their direction to the interface, of those of either fluid in cells and ghosts.
fn mix_faces(
    exec: &Exec,
    mesh: &Mesh,
    alpha: &Unknown<f64>,
    gradient: &[Vec3],
    [one, two]: [&[f64]; 2],
    eta_f: &mut FaceField<f64>,
) {
    exec.for_each(&mut eta_f.data, |first, out| {
        for (i, eta) in out.iter_mut().enumerate() {
            let f = first + i;
            let o = mesh.owner[f] as usize;
            let n = mesh.neighbour.get(f).map_or(o, |&n| n as usize);
            let w = if n == o { 1.0 } else { mesh.weight[f] };
            let lerp = |x: &[f64]| w * x[o] + (1.0 - w) * x[n];
            let a = lerp(&alpha.cells.data).clamp(0.0, 1.0);
            let g = gradient[o].scaled(w).axpy(1.0 - w, gradient[n]);
            let across = dot(g, mesh.normal(f)).powi(2) / dot(g, g).max(f64::MIN_POSITIVE);
            let [s, p] = by_direction(a, lerp(one), lerp(two));
            *eta = across * s + (1.0 - across) * p;
        }
    });
}
