//! The pressure gradient that keeps the mean velocity at a given value (`meanVelocityForce`): channels
//! with cyclic ends.

use super::{Entry, Given, Seen, Source, Zone, three};
use crate::{Flow, Residuals};
use granflow_base::{Dims, Value, Vec3, dot, norm, unit};
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
    /// Share of the correction that a pass takes.
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

impl Source for MeanVelocity {
    fn name(&self) -> &str {
        &self.name
    }
    fn kind(&self) -> &'static str {
        ENTRY.names[0]
    }
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn says(&self, number: &dyn Fn(f64) -> String) -> String {
        let mean = three(self.direction.scaled(self.mean), number);
        format!("what holds a mean velocity of {mean} m/s")
    }
    fn add(&self, _: &Seen<'_>, n: usize, body: &mut [Vec3], _: &mut [f64]) {
        self.zone.each(n, |c| body[c] = body[c].axpy(self.gradient, self.direction));
    }
    fn held(&self) -> Option<&MeanVelocity> {
        Some(self)
    }
    fn held_mut(&mut self) -> Option<&mut MeanVelocity> {
        Some(self)
    }
    fn boxed(&self) -> Box<dyn Source> {
        Box::new(self.clone())
    }
}

pub(super) const ENTRY: Entry = Entry {
    names: &["meanVelocityForce"],
    summary: "the uniform force that keeps the mean velocity over a zone at Ubar",
    formula: "f = g Ubar/|Ubar|, g such that sum U V . Ubar/|Ubar| = |Ubar| sum V",
    reference: "OpenFOAM user guide, fvOptions",
    read,
};

fn read(of: &Given<'_, '_>) -> Vec<Box<dyn Source>> {
    let r = of.r;
    of.always();
    for key in ["fields", "fieldNames"] {
        r.ignore(key);
    }
    let mean = r.vector("Ubar", Dims::VELOCITY);
    if norm(mean) == 0.0 || !norm(mean).is_finite() {
        let message = "the mean velocity has no direction";
        r.error_at_key("Ubar", message, "zero, or beyond numbers", Some("leave the source out"));
    }
    if (0..3).any(|k| mean[k] != 0.0 && !of.mesh.solved_dirs[k]) {
        let message = "the mean velocity points where the mesh has no cells side by side";
        r.error_at_key("Ubar", message, "out of the plane", None);
    }
    if of.two {
        let message = "a held mean velocity is for one fluid";
        let help = Some("give the force: `vectorSemiImplicitSource`");
        of.outer.error_at_key("type", message, "two phases", help);
    }
    let relaxation = r.opt_in_range("relaxation", Dims::NONE, 1e-3..=1.0, 1.0);
    vec![Box::new(MeanVelocity {
        name: of.name.to_owned(),
        zone: of.zone.clone(),
        direction: unit(mean),
        mean: norm(mean),
        relaxation,
        gradient: 0.0,
        start: 0.0,
        last: None,
        response: None,
    })]
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
            let Some(m) = self.sources[k].held() else { continue };
            let response = self.mean_over(&m.zone, |c| self.work.r_at.data[c]);
            let Flow { mesh, state, work: w, sources, .. } = self;
            let (r_at, u) = (&w.r_at.data, &mut state.u.cells.data);
            if let Some(m) = sources[k].held_mut() {
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
            let Some(m) = self.sources[k].held() else { continue };
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
            if let Some(m) = self.sources[k].held_mut() {
                m.last = Some([m.gradient, mean]);
                m.response = Some(response);
                m.gradient += m.relaxation * lacks / response;
                changed = true;
            }
        }
        changed
    }

    /// What the mean velocity of source `k` lacks, and the mean, m/s; none where it is held, and of
    /// other sources.
    fn lack_of_mean(&self, k: usize) -> Option<(f64, f64)> {
        let m = self.sources[k].held()?;
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
            let Some(m) = sources[k].held() else { continue };
            if m.gradient != 0.0 || mean != 0.0 {
                continue;
            }
            let (u, plug) = (&mut state.u.cells.data, m.direction.scaled(m.mean));
            m.zone.each(mesh.n_cells, |c| u[c] = plug);
            mesh.halo.update(exec, u);
            operators::flux(exec, mesh, &state.u, &state.u.cells.data, &mut state.phi);
            self.take_frames_from(|flow| &mut flow.state.phi);
            self.update_conditions();
        }
    }

    /// A gradient to begin with, at the viscosity as it stands, where there is none yet.
    pub(crate) fn guess_mean_gradient(&mut self, dt: f64) {
        for k in 0..self.sources.len() {
            let Some(m) = self.sources[k].held() else { continue };
            if m.gradient == 0.0 {
                let guess = m.mean / self.first_response(&m.zone, dt);
                if let Some(m) = self.sources[k].held_mut() {
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
