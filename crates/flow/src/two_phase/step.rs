//! One time step of two fluids: interface, mixture, momentum, pressure.

use crate::vof::Drive;
use crate::{Flow, Report, State, StepError, TimeScheme};
use granflow_base::{dot, norm};
use granflow_fv::Surroundings;
use std::sync::Arc;

/// Strain rate that grains are taken to have when a run starts, over that of a free fall through a cell:
/// from too soft a material the iteration finds what stands still, from a rigid one not what gives way.
const FIRST_RATE: f64 = 0.1;

impl Flow {
    /// Makes this a flow of two fluids; the state has their volume fraction.
    #[must_use]
    pub fn with_second_fluid(mut self, two: crate::TwoPhase) -> Flow {
        self.two_phase = Some(Box::new(two));
        self.prepare_grains();
        self.refresh_mixture();
        // An equation that is not written wrongly does not fail.
        let placed = self.place_grains();
        debug_assert!(placed.is_ok());
        self.prescribe(self.state.time);
        self.update_conditions();
        self
    }

    /// Density and conditions that follow from the volume fraction in the state.
    pub(crate) fn refresh_mixture(&mut self) {
        let Flow { exec, mesh, state, two_phase, numerics, .. } = self;
        let State { alpha, time, .. } = state;
        let (Some(two), Some(alpha)) = (two_phase, alpha) else { return };
        let around = Surroundings { time: *time, ..Surroundings::default() };
        two.work.tension.meet_walls(exec, mesh, alpha, (&around, numerics.compatible));
        self.mix_density();
    }

    /// What [`Flow::step`] does with two fluids, with errors as they come.
    pub(crate) fn advance_two_phases(&mut self, clock: f64) -> Result<Report, StepError> {
        let starts = self.state.step == 0;
        self.begin_step(clock);
        self.refuse_faults()?;
        let dt = self.inertial_step(clock);
        if starts {
            self.project_first_flux()?;
        }
        self.refresh_mixture();
        if let (Some(two), Some(alpha)) = (&mut self.two_phase, &self.state.alpha) {
            two.work.alpha_start.copy_from_slice(&alpha.cells.data);
            two.work.rho_old.data.copy_from_slice(&self.work.rho.data);
        }
        if self.has_grains_in_fluid() {
            return self.advance_grains_in_fluid((clock, dt), starts);
        }
        // In the middle of the step, for second order.
        self.prescribe(self.state.time - 0.5 * dt);
        let mut report = Report { time: self.state.time, dt, ..Report::default() };
        let outer = self.numerics.outer.max(1);
        for k in 0..outer {
            self.give_up_if_asked()?;
            self.move_interface(dt, k > 0)?;
            report.outer = k + 1;
            if self.two_phase.as_ref().is_some_and(|t| t.frozen) {
                break;
            }
            self.mix_mass_flux();
            self.mix_viscosity_of_fluids(dt)?;
            self.update_face_forces();
            self.update_conditions();
            let last = k + 1 == outer;
            self.assemble_two_phase_momentum(dt, k > 0)?;
            if self.numerics.predictor {
                self.push_two_phase_momentum();
                let solved = self.predict_velocity(last)?;
                crate::step::note(&mut report.u, &mut report.iterations[0], solved);
            }
            self.update_two_phase_mobility();
            for i in 0..self.numerics.correctors {
                let final_one = last && i + 1 == self.numerics.correctors;
                let settle = starts && k == 0 && i == 0;
                let solved = self.correct_two_phase(dt, final_one, settle)?;
                crate::step::note(&mut report.p, &mut report.iterations[1], solved);
            }
        }
        self.move_to_mean_velocity();
        self.prescribe(self.state.time);
        report.converged = true;
        report.residuals.u = report.u.map_or(0.0, |(first, _)| first.first);
        report.residuals.p = self.continuity_residual();
        report.vof = self.two_phase.as_ref().map(|t| t.work.vof);
        self.end_step(dt, &mut report)?;
        Ok(report)
    }

    /// Grains beside another fluid: the interface moves once, then momentum, continuity, viscosity and
    /// the friction of walls are solved together as they are without it. Between creep and the other
    /// fluid viscosities differ by ten decades, and stress follows pressure: corrections of the pressure
    /// alone (PISO) grow.
    fn advance_grains_in_fluid(
        &mut self,
        (clock, dt): (f64, f64),
        starts: bool,
    ) -> Result<Report, StepError> {
        let mut report = Report { time: self.state.time, dt: clock, ..Report::default() };
        if let Some(grains) = self.two_phase.as_mut().and_then(|t| t.work.grains.as_mut()) {
            grains.share_old.copy_from_slice(&grains.share);
        }
        self.give_up_if_asked()?;
        self.move_interface(dt, false)?;
        report.vof = self.two_phase.as_ref().map(|t| t.work.vof);
        if self.two_phase.as_ref().is_some_and(|t| t.frozen) {
            self.end_step(dt, &mut report)?;
            return Ok(report);
        }
        self.place_grains()?;
        if !self.fluid.rheology.is_local() {
            self.keep_pressure();
        }
        self.mix_mass_flux();
        self.update_face_forces();
        self.update_conditions();
        if starts && self.fastest() == 0.0 {
            self.guess_pressure(clock)?;
            self.work.slowest = FIRST_RATE;
        }
        self.recall_viscosity(dt)?;
        self.iterate(dt, &mut report)?;
        self.end_coupled_step(clock, &mut report)?;
        Ok(report)
    }

    /// Begins with the pressure `p_rgh + rho G.x` of the step before where the density has changed: grains that the surface has
    /// left or reached would be pulled or pressed by what the level of reference makes of that, and their first viscosity be that
    /// of fluid. (Of the steps in which a column of NGF falls 31 used up 20 passes so, 131 without. Newton's method of local
    /// laws gains nothing by it.)
    fn keep_pressure(&mut self) {
        let Flow { exec, mesh, state, two_phase, work: w, gravity, .. } = self;
        let Some(two) = two_phase else { return };
        let (old, new, g) = (&two.work.rho_old.data, &w.rho.data, gravity.hydrostatic);
        exec.for_each(&mut state.p.cells.data[..mesh.n_cells], |first, p| {
            for (i, p) in p.iter_mut().enumerate() {
                let c = first + i;
                *p += (old[c] - new[c]) * dot(g, mesh.cell_centre[c]);
            }
        });
    }

    /// The greatest velocity of a cell, m/s.
    fn fastest(&self) -> f64 {
        let u = &self.state.u.cells.data;
        self.exec.max(self.mesh.n_cells, |r| r.map(|c| norm(u[c])).fold(0.0, f64::max))
    }

    /// Whether the interface stays where it is: a steady state is looked for.
    pub(crate) fn holds_interface(&self) -> bool {
        self.two_phase.is_some() && self.numerics.ddt == TimeScheme::Steady
    }

    /// The mass flux of the flow as it stands, where the interface does not move.
    pub(crate) fn carry_with_the_flow(&mut self) {
        let Flow { exec, mesh, state, two_phase, .. } = self;
        if let (Some(two), Some(alpha)) = (two_phase, &state.alpha) {
            two.work.carrier.data.copy_from_slice(&state.phi.data);
            two.vof.hold(exec, mesh, alpha, &state.phi.data);
        }
        self.mix_mass_flux();
    }

    /// Moves the volume fraction from where it was at the beginning of the step.
    fn move_interface(&mut self, dt: f64, again: bool) -> Result<(), StepError> {
        let holds = self.holds_interface();
        self.choose_carrier(dt, again);
        let Flow { exec, mesh, state, two_phase, .. } = self;
        let State { alpha, time, .. } = state;
        let (Some(two), Some(alpha)) = (two_phase, alpha) else { return Ok(()) };
        if holds {
            two.vof.hold(exec, mesh, alpha, &two.work.carrier.data);
            return Ok(());
        }
        if again {
            alpha.cells.data.copy_from_slice(&two.work.alpha_start);
        }
        let t = &mut two.work;
        let around = Surroundings {
            time: *time,
            contact_gradient: &t.tension.contact_gradient,
            ..Surroundings::default()
        };
        t.vof = two
            .vof
            .advance(exec, mesh, alpha, Drive { phi: &t.carrier, dt, around: &around })
            .map_err(|source| StepError::Interface { time: *time, source: Arc::new(source) })?;
        self.refresh_mixture();
        Ok(())
    }

    /// The flux that moves the interface in a step: the last one, or with the Crank-Nicolson scheme
    /// `(phi + psi phi0)/(1 + psi)`. Its first pass, in which the new flux is not known yet, puts
    /// `phi0 + psi/(1 + psi) dt R` with the rate R handed on from the step before in its place. Interface and
    /// velocity are then the two halves of a symplectic method at any psi, velocity Verlet's at 1 (L. Verlet,
    /// Phys. Rev. 159 (1967) 98): a wave neither grows nor fades by it. With the last flux it grows, as
    /// momentum takes the mean of the forces at both ends.
    fn choose_carrier(&mut self, dt: f64, again: bool) {
        let from_old = self.numerics.ddt;
        let grains = self.has_grains_in_fluid();
        let Flow { exec, state, work: w, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let given = two.prescribed.is_some();
        let (carrier, phi) = (&mut two.work.carrier.data, &state.phi.data);
        let TimeScheme::CrankNicolson(psi) = from_old else {
            return carrier.copy_from_slice(phi);
        };
        if grains || given || state.dt_old == 0.0 {
            return carrier.copy_from_slice(phi);
        }
        let share = psi / (1.0 + psi);
        let (share, old) = match again {
            true => (-share, &w.phi_start),
            false => (share * dt / state.dt_old, &state.phi_old),
        };
        exec.for_each(carrier, |first, out| {
            for (i, carrier) in out.iter_mut().enumerate() {
                let f = first + i;
                *carrier = phi[f] + share * (phi[f] - old[f]);
            }
        });
    }

    /// Density in the cells, kg/m3.
    pub fn density(&self) -> &[f64] {
        &self.work.rho.data
    }

    /// Greatest Courant number of a step of one second in cells at the interface, with fractions
    /// from 0.01 to 0.99; 0 with one fluid.
    pub fn interface_courant_rate(&self) -> f64 {
        let Some(alpha) = &self.state.alpha else { return 0.0 };
        let (mesh, phi, a) = (&self.mesh, &self.state.phi.data, &alpha.cells.data);
        let rate = |c: usize| {
            0.5 * mesh.faces_of(c).map(|(f, _)| phi[f].abs()).sum::<f64>() / mesh.volume[c]
        };
        let mixed = |c: &usize| (0.01..=0.99).contains(&a[*c]);
        self.exec.max(mesh.n_cells, |r| r.filter(mixed).map(rate).fold(0.0, f64::max))
    }
}
