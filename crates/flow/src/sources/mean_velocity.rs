//! The pressure gradient that keeps the mean velocity at a given value (`meanVelocityForce`): channels
//! with cyclic ends.

use super::{Source, Zone};
use crate::{Flow, Residuals};
use granflow_base::{Value, Vec3, dot};
use granflow_fv::operators;
use granflow_mesh::PatchKind;

/// How near the mean is to what it is held at, of that.
const HELD: f64 = 1e-10;
/// How far from balance forces may be for a secant, over what the mean lacks.
const NEAR: f64 = 0.03;

/// A force along a direction, as large as the mean velocity asks for.
#[derive(Clone, Debug)]
pub struct MeanVelocity {
    /// The name of the entry, under which the gradient is kept.
    pub name: String,
    /// Where.
    pub zone: Zone,
    /// Unit vector.
    pub direction: Vec3,
    /// Mean velocity along it, m/s.
    pub mean: f64,
    /// Share of the correction that a single pass takes.
    pub relaxation: f64,
    /// The force per volume, N/m3: part of a restart.
    pub gradient: f64,
    /// The gradient before and the mean that came out with it.
    pub last: Option<[f64; 2]>,
    /// Change of the mean for one of the gradient, m4/(N s).
    pub response: Option<f64>,
    /// The gradient when the step began.
    pub start: f64,
}

impl MeanVelocity {
    pub(super) fn add(&self, n: usize, body: &mut [Vec3]) {
        self.zone.each(n, |c| body[c] = body[c].axpy(self.gradient, self.direction));
    }
}

impl Flow {
    /// Mean of `of` over the zone of source `k`, by volume, on all ranks.
    fn mean_over(&self, zone: &Zone, of: impl Fn(usize) -> f64) -> f64 {
        let volume = &self.mesh.volume;
        let mut sums = [0.0; 2];
        zone.each(self.mesh.n_cells, |c| {
            sums[0] += volume[c] * of(c);
            sums[1] += volume[c];
        });
        self.exec.comm().sum(&mut sums);
        if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 }
    }

    /// At the end of a single pass: moves the velocity to the mean that is asked for, by the mobility of all
    /// cells together. That of each cell alone, where viscosity rules, is so much less than what the flow
    /// answers with that the gradient grows from step to step.
    pub(crate) fn move_to_mean_velocity(&mut self) {
        for k in 0..self.sources.len() {
            let Some((lacks, _)) = self.lack_of_mean(k) else { continue };
            let Source::MeanVelocity(m) = &self.sources[k] else { continue };
            let response = self.mean_over(&m.zone, |c| self.work.r_at.data[c]);
            let Flow { mesh, state, work: w, sources, .. } = self;
            let (r_at, u) = (&w.r_at.data, &mut state.u.cells.data);
            if let Source::MeanVelocity(m) = &mut sources[k] {
                let (change, direction) = (m.relaxation * lacks / response, m.direction);
                m.zone.each(mesh.n_cells, |c| u[c] = u[c].axpy(r_at[c] * change, direction));
                m.gradient += change;
            }
            self.update_conditions();
        }
    }

    /// Between outer passes, with the flow of the present gradient near enough (`residuals`): the gradient
    /// follows the secant of mean against gradient. The first time it takes the response that inertia has, or
    /// where there is none that of a slit as wide as volume over wall makes it, `(2 V/A)^2/(12 eta)`. Says
    /// whether anything changed.
    pub(crate) fn answer_mean_velocity(&mut self, dt: f64, residuals: &Residuals) -> bool {
        let mut changed = false;
        for k in 0..self.sources.len() {
            let Some((lacks, mean)) = self.lack_of_mean(k) else { continue };
            let Source::MeanVelocity(m) = &self.sources[k] else { continue };
            let near = NEAR * (lacks / m.mean).abs().min(1.0);
            let control = &self.numerics.control;
            if residuals.u > near.max(control.u)
                || residuals.viscosity > near.max(control.viscosity)
            {
                continue;
            }
            let secant = m.last.map(|[gradient, before]| (mean - before) / (m.gradient - gradient));
            let response = secant
                .filter(|r| r.is_finite() && *r > 0.0)
                .or(m.response)
                .unwrap_or_else(|| self.first_response(&m.zone, dt));
            if let Source::MeanVelocity(m) = &mut self.sources[k] {
                m.last = Some([m.gradient, mean]);
                m.response = Some(response);
                m.gradient += lacks / response;
                changed = true;
            }
        }
        changed
    }

    /// What the mean velocity of source `k` lacks, and the mean, m/s; none where it is held, and of
    /// other sources.
    fn lack_of_mean(&self, k: usize) -> Option<(f64, f64)> {
        let Source::MeanVelocity(m) = &self.sources[k] else { return None };
        let u = &self.state.u.cells.data;
        let mean = self.mean_over(&m.zone, |c| dot(u[c], m.direction));
        let lacks = m.mean - mean;
        (lacks.abs() > HELD * m.mean).then_some((lacks, mean))
    }

    /// Where nothing moves yet and outer passes will look for the gradient: all of the zone has the mean
    /// velocity, so that a viscosity that follows the flow is that of a flow.
    pub(crate) fn start_at_mean_velocity(&mut self) {
        if !self.is_coupled() {
            return;
        }
        for k in 0..self.sources.len() {
            let Some((_, mean)) = self.lack_of_mean(k) else { continue };
            let Flow { exec, mesh, state, sources, .. } = self;
            let Source::MeanVelocity(m) = &sources[k] else { continue };
            if m.gradient != 0.0 || mean != 0.0 {
                continue;
            }
            let (u, plug) = (&mut state.u.cells.data, m.direction.scaled(m.mean));
            m.zone.each(mesh.n_cells, |c| u[c] = plug);
            mesh.halo.update(exec, u);
            operators::flux(exec, mesh, &state.u, &state.u.cells.data, &mut state.phi);
            self.update_conditions();
        }
    }

    /// A gradient to begin with, at the viscosity as it stands, where there is none yet.
    pub(crate) fn guess_mean_gradient(&mut self, dt: f64) {
        for k in 0..self.sources.len() {
            let Source::MeanVelocity(m) = &self.sources[k] else { continue };
            if m.gradient == 0.0 {
                let guess = m.mean / self.first_response(&m.zone, dt);
                if let Source::MeanVelocity(m) = &mut self.sources[k] {
                    m.gradient = guess;
                }
            }
        }
    }

    fn first_response(&self, zone: &Zone, dt: f64) -> f64 {
        let (w, mesh) = (&self.work, &self.mesh);
        let inertia = self.mean_over(zone, |c| w.rho.data[c]) / dt;
        let walls =
            mesh.patches.iter().filter(|p| matches!(p.kind, PatchKind::Wall | PatchKind::Patch));
        let area: f64 = walls.flat_map(|p| p.faces.clone()).map(|f| mesh.mag_area[f]).sum();
        let volume: f64 = mesh.volume[..mesh.n_cells].iter().sum();
        let mut sums = [area, volume];
        self.exec.comm().sum(&mut sums);
        // What yields decides, and not the plug.
        let eta = 1.0 / self.mean_over(zone, |c| 1.0 / w.eta.data[c]);
        let width = 2.0 * sums[1] / sums[0].max(f64::MIN_POSITIVE);
        1.0 / (inertia + 12.0 * eta / (width * width))
    }
}
