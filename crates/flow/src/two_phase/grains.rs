//! Grains beside another fluid: where they are, the pressure between them, and the viscosity of what is
//! mixed.
//!
//! The rheology of the grains sees the grains alone: their share of the cells, and the pressure that they
//! bear, `P = p_rgh + rho G.x - p_pore` ([`super::pore`]). What it says is `eta_1`; momentum has the
//! mixture's viscosity ([`super::mixing`]).

use super::TwoPhase;
use super::mixing::{Mixing, parallel, series};
use super::pore::{PorePressure, Pores};
use crate::{Flow, StepError};
use granflow_base::{Dims, Value, Vec3, dot, norm};
use granflow_fv::{CellField, FaceField, Gradient, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::{FlowView, Share};

/// Relative difference of viscosities that is rounding.
const LENT: f64 = 1e-9;

/// Whether a cell has too little of the grains to count.
#[inline]
pub(crate) fn sparse(share: f64) -> bool {
    share < Share::NONE
}

/// The greatest viscosity of grains that momentum feels, the greater of two. Above it the rounding of a velocity alone
/// makes forces that count. The law of the grains does not know of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffest {
    /// Over that of the fluid around them.
    pub beside: f64,
    /// Over `rho_1 sqrt(g h) h`: at 3e6 that of a material which its own weight shears at a millionth of the
    /// rate of a free fall through a cell of size h.
    pub own: f64,
}

impl Stiffest {
    /// What no flow can tell from more.
    pub const DEFAULT: Stiffest = Stiffest { beside: 1e12, own: 3e6 };
}

pub(crate) struct Grains {
    mixing: Mixing,
    /// Share of the cells and ghosts, 0 to 1, now and at the beginning of the step.
    pub(crate) share: Vec<f64>,
    pub(crate) share_old: Vec<f64>,
    /// Viscosity of the mixture in cells and ghosts, Pa s.
    pub(crate) eta: Vec<f64>,
    /// Viscosity of fluid 2.
    pub(crate) eta_2: CellField<f64>,
    /// `d ln eta / d ln eta_1` of the mixture on faces.
    pub(crate) response: Vec<f64>,
    /// [`Stiffest::beside`].
    beside: f64,
    /// Viscosity that momentum feels whatever the fluid around the grains, Pa s; cells and ghosts.
    least_stiffest: Vec<f64>,
    /// Gradient of the share, cells and ghosts, where the mixing asks for it.
    gradient: Vec<Vec3>,
    pub(crate) pore: PorePressure,
}

impl Grains {
    /// `weight` is `rho_1 sqrt(g)`.
    pub(crate) fn new(
        mesh: &Mesh,
        mixing: Mixing,
        (weight, stiffest): (f64, Stiffest),
        pore: PorePressure,
    ) -> Grains {
        let directed = mixing == Mixing::FaceDirection;
        Grains {
            mixing,
            share: vec![0.0; mesh.n_all()],
            share_old: vec![0.0; mesh.n_all()],
            eta: vec![0.0; mesh.n_all()],
            eta_2: CellField::new(mesh, "eta2", Dims::VISCOSITY, 0.0),
            response: vec![1.0; mesh.n_faces()],
            beside: stiffest.beside,
            least_stiffest: mesh.volume.iter().map(|v| stiffest.own * weight * v.sqrt()).collect(),
            gradient: if directed { vec![[0.0; 3]; mesh.n_all()] } else { Vec::new() },
            pore,
        }
    }

    /// The strain rate of the grains for the stress of a cell: the mixture's, but where both fluids bear
    /// the same stress.
    #[inline]
    pub(crate) fn rate(&self, c: usize, stress: f64, eta_1: f64) -> f64 {
        stress / self.viscosity_of_rate(c, eta_1)
    }

    /// The viscosity that [`Self::rate`] divides by.
    #[inline]
    pub(crate) fn viscosity_of_rate(&self, c: usize, eta_1: f64) -> f64 {
        match self.mixing {
            Mixing::Harmonic if !sparse(self.share[c]) => eta_1,
            _ => self.eta[c],
        }
    }

    /// Whether the viscosity of the face between two cells is of the same material as that of their rates:
    /// where both fluids bear the same stress, the face has the mixture's and the cell the grains'.
    #[inline]
    pub(crate) fn compares(&self, c: usize, n: usize) -> bool {
        self.mixing != Mixing::Harmonic || self.share[c] >= 1.0 && self.share[n] >= 1.0
    }

    /// Grains out of contact move with the fluid between them: `eta_1` of the cells is no less than its. Nor more: a
    /// viscosity that is lent to them makes pressure, and pressure is contact.
    pub(crate) fn lend_viscosity(&self, exec: &Exec, eta_1: &mut [f64]) {
        let eta_2 = &self.eta_2.data;
        exec.for_each(eta_1, |first, eta| {
            eta.iter_mut().enumerate().for_each(|(i, eta)| *eta = eta.max(eta_2[first + i]));
        });
    }

    /// Whether a viscosity of the grains of cell `c` is one that was lent to them, to the rounding of its logarithm.
    #[inline]
    pub(crate) fn is_lent(&self, c: usize, eta_1: f64) -> bool {
        eta_1 <= self.eta_2.data[c] * (1.0 + LENT)
    }

    /// Change of ln(viscosity) of the mixture in cell `c` when that of the grains goes from `old` to `new`.
    pub(crate) fn change(&self, c: usize, old: f64, new: f64) -> f64 {
        let of =
            |eta_1| self.mixing.in_cell(self.share[c], self.felt(c, eta_1), self.eta_2.data[c]);
        (of(new) / of(old)).ln().abs()
    }

    /// The viscosity of the grains in cell `c` that momentum feels, Pa s.
    #[inline]
    fn felt(&self, c: usize, eta_1: f64) -> f64 {
        eta_1.min((self.beside * self.eta_2.data[c]).max(self.least_stiffest[c]))
    }

    /// The grains are where `alpha` says; its conditions are up to date.
    fn settle_at(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
    ) -> Result<(), StepError> {
        let a = &alpha.cells.data;
        exec.for_each(&mut self.share, |first, out| {
            for (i, share) in out.iter_mut().enumerate() {
                let a = a[first + i];
                *share = if sparse(a) { 0.0 } else { a.min(1.0) };
            }
        });
        if !self.gradient.is_empty() {
            Gradient::GaussLinear.of(exec, mesh, alpha, &mut self.gradient);
        }
        self.pore.enclose(exec, mesh, &self.share)
    }

    /// From the viscosity of the grains in cells and on faces to that of the mixture; that of the grains
    /// on faces is overwritten.
    pub(crate) fn mix(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        eta_1: &[f64],
        eta_f: &mut FaceField<f64>,
    ) {
        let Grains { mixing, share, eta, eta_2, response, gradient, least_stiffest, .. } = self;
        let (mixing, share, eta_2) = (*mixing, &share[..], &eta_2.data[..]);
        let (beside, least_stiffest) = (self.beside, &least_stiffest[..]);
        exec.for_each(eta, |first, out| {
            for (i, eta) in out.iter_mut().enumerate() {
                let c = first + i;
                let felt = eta_1[c].min((beside * eta_2[c]).max(least_stiffest[c]));
                *eta = mixing.in_cell(share[c], felt, eta_2[c]);
            }
        });
        let gradient = &gradient[..];
        exec.for_each2(&mut eta_f.data, response, |first, out, response| {
            for i in 0..out.len() {
                let f = first + i;
                let o = mesh.owner[f] as usize;
                let n = mesh.neighbour.get(f).map_or(o, |&n| n as usize);
                let w = if n == o { 1.0 } else { mesh.weight[f] };
                let lerp = |x: &[f64]| w * x[o] + (1.0 - w) * x[n];
                let (a, two) = (lerp(share), lerp(eta_2));
                let most = (beside * two).max(least_stiffest[o].min(least_stiffest[n]));
                let (stiff, one) = (out[i] > most, out[i].min(most));
                if share[o] >= 1.0 && share[n] >= 1.0 {
                    (out[i], response[i]) = (one, f64::from(u8::from(!stiff)));
                    continue;
                }
                if a <= 0.0 {
                    (out[i], response[i]) = (two, 0.0);
                    continue;
                }
                let (mixed, of_one) = match mixing {
                    Mixing::Arithmetic => {
                        let mixed = parallel(a, one, two);
                        (mixed, a * one / mixed)
                    }
                    Mixing::Harmonic => {
                        // The paper's way: cells are mixed, faces have their linear mean.
                        let half = |c: usize, w: f64| {
                            let s = w * series(share[c], one, eta_2[c]);
                            [s, s * share[c] * series(share[c], one, eta_2[c]) / one]
                        };
                        let ([a, da], [b, db]) = (half(o, w), half(n, 1.0 - w));
                        (a + b, (da + db) / (a + b))
                    }
                    Mixing::FaceDirection => {
                        let g = gradient[o].scaled(w).axpy(1.0 - w, gradient[n]);
                        let across = dot(g, mesh.normal(f)).powi(2) / dot(g, g).max(1e-300);
                        // Of the way between the cells.
                        let way = (2.0 * a - 0.5).clamp(0.0, 1.0);
                        let (s, p) = (series(way, one, two), parallel(a, one, two));
                        let mixed = across * s + (1.0 - across) * p;
                        let carried = across * way * s * s / one + (1.0 - across) * a * one;
                        (mixed, (carried / mixed).min(1.0))
                    }
                };
                (out[i], response[i]) = (mixed, if stiff { 0.0 } else { of_one });
            }
        });
    }
}

impl TwoPhase {
    /// Share of the grains in cells and ghosts, where there are any.
    pub(crate) fn share(&self) -> Option<&[f64]> {
        self.work.grains.as_ref().map(|g| &g.share[..])
    }
    /// The same with what it was when the step began.
    pub(crate) fn shares(&self) -> Option<Share<'_>> {
        let grains = self.work.grains.as_ref()?;
        Some(Share { now: &grains.share, old: &grains.share_old })
    }
    /// Viscosity of the mixture in cells and ghosts, where it is not that of fluid 1.
    pub(crate) fn viscosity(&self) -> Option<&[f64]> {
        self.work.grains.as_ref().map(|g| &g.eta[..])
    }
}

impl Flow {
    /// Whether fluid 1 is made of grains that another fluid surrounds.
    pub(crate) fn has_grains_in_fluid(&self) -> bool {
        self.grains().is_some()
    }

    pub(crate) fn grains(&self) -> Option<&Grains> {
        self.two_phase.as_ref()?.work.grains.as_ref()
    }

    /// Where fluid 1 is made of grains beside another fluid: their share of the cells, and the pressure
    /// between them as the last step left it, Pa.
    pub fn grains_in_fluid(&self) -> Option<(&[f64], &[f64])> {
        let n = self.mesh.n_cells;
        self.grains().map(|g| (&g.share[..n], &self.work.pressure[..n]))
    }

    /// Makes room for grains beside the other fluid, where there are any.
    pub(crate) fn prepare_grains(&mut self) {
        let Flow { exec, mesh, two_phase, fluid, gravity, .. } = self;
        let Some(two) = two_phase else { return };
        if two.pore_solver.is_none() || !fluid.rheology.reads_pressure() {
            return;
        }
        let weight = match two.pores {
            Pores::Dry => [0.0; 3],
            Pores::Saturated => gravity.hydrostatic.map(|g| g * two.rho_2),
        };
        let pore = PorePressure::new(exec, mesh, weight);
        let weight = fluid.rho * norm(gravity.hydrostatic).sqrt();
        two.work.grains = Some(Grains::new(mesh, two.mixing, (weight, two.stiffest), pore));
    }

    /// Shares of the grains from the volume fraction as it stands.
    pub(crate) fn place_grains(&mut self) -> Result<(), StepError> {
        let Flow { exec, mesh, two_phase, state, .. } = self;
        let (Some(two), Some(alpha)) = (two_phase, &state.alpha) else { return Ok(()) };
        let Some(grains) = &mut two.work.grains else { return Ok(()) };
        grains.settle_at(exec, mesh, alpha)?;
        self.weigh_surfaces();
        Ok(())
    }

    /// Takes the pressure of the pores from `work.pressure`.
    pub(crate) fn relieve_grains(&mut self) -> Result<(), StepError> {
        let Flow { exec, mesh, two_phase, work: w, state, .. } = self;
        let Some(TwoPhase { pore_solver: Some(solver), work, .. }) = two_phase.as_deref_mut()
        else {
            return Ok(());
        };
        let Some(Grains { pore, share, .. }) = &mut work.grains else { return Ok(()) };
        pore.update(exec, mesh, solver.as_mut(), (share, &w.pressure), state.time)?;
        let (pore, share) = (&*pore, &*share);
        exec.for_each(&mut w.pressure[..mesh.n_cells], |first, out| {
            for (i, p) in out.iter_mut().enumerate() {
                let c = first + i;
                *p = if sparse(share[c]) { 0.0 } else { *p - pore.at(c, mesh.cell_centre[c]) };
            }
        });
        Ok(())
    }

    /// Viscosity of the other fluid at the strain rate as it stands.
    pub(crate) fn evaluate_surrounding_fluid(&mut self, dt: f64) -> Result<(), StepError> {
        let Flow { exec, mesh, two_phase, work: w, state, .. } = self;
        let time = state.time;
        let Some(two) = two_phase else { return Ok(()) };
        let Some(grains) = &mut two.work.grains else { return Ok(()) };
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
        two.rheology_2
            .update(&view, &mut grains.eta_2)
            .map_err(|source| StepError::Rheology { time, source })?;
        mesh.halo.update(exec, &mut grains.eta_2.data);
        Ok(())
    }
}
