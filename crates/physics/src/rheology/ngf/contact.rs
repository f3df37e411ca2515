//! Which grains beside another fluid are in contact, in the steady form.

use super::{Form, Ngf};
use crate::rheology::{FlowView, Share};

/// Losses of contact in a step from which on a cell regains it only with [`PRESSES`]. With 1, 2 and 3 of them 22, 23 and 31 of 300 steps
/// of falling blocks do not converge (`flow/tests/grains_in_fluid.rs`); more leave more to what really presses.
const CHATTERS: u8 = 3;
/// Pressure that does so, over the weight of a grain on earth on its area. With 0.1 twice as many steps of such a block in the most
/// viscous fluid do not converge, with 1 as many.
const PRESSES: f64 = 0.3;

/// The contact of a step.
#[derive(Default)]
pub(super) struct Contact {
    /// Share of the cells and ghosts that grains in contact have.
    touching: Vec<f64>,
    /// How often the grains there have lost it.
    losses: Vec<u8>,
}

impl Contact {
    pub(super) fn new(cells: usize) -> Self {
        Contact { touching: vec![0.0; cells], losses: vec![0; cells] }
    }
    /// To be called as a step begins.
    pub(super) fn begin_step(&mut self) {
        self.losses.fill(0);
        self.touching.fill(0.0);
    }
}

impl Ngf {
    /// In the steady form, beside another fluid, grains under no pressure are out of contact: they carry no stress, have no
    /// fluidity, and what is in contact ends at them. (Their stress ratio is what a floor on the pressure makes of it,
    /// and where it comes to lie above mu_s beside faster grains, the equation at a given rate has no
    /// solution near by. The primitive form remembers, and has one.) The view that is returned has the share of the others.
    ///
    /// Contact changes what is beside it by more than a little: the fluidity spreads into a cell or does not. Where a cell
    /// under next to no pressure has it in every other pass, passes repeat themselves for ever; within a step it is then
    /// lost for good, unless what presses is about a third of a grain's weight. The endless step of a steady state takes many
    /// passes, and the first of them say nothing of the last: there it is not.
    pub(super) fn part<'a>(&self, v: &FlowView<'a>, contact: &'a mut Contact) -> FlowView<'a> {
        let Some(share) = v.share.filter(|_| self.law.form == Form::Steady) else { return *v };
        let grains = self.law.grains;
        let (pressure, loose) = (v.pressure, grains.loose());
        let presses = PRESSES * grains.rho_s * 9.81 * grains.d;
        let chatters = if v.dt < FlowView::FOREVER { CHATTERS } else { u8::MAX };
        let Contact { touching, losses } = contact;
        v.exec.for_each2(touching, losses, |first, touching, losses| {
            for (i, (touches, losses)) in touching.iter_mut().zip(losses).enumerate() {
                let c = first + i;
                let least = if *touches == 0.0 && *losses >= chatters { presses } else { loose };
                let now = if pressure[c] > least { share.now[c] } else { 0.0 };
                if *touches > 0.0 && now == 0.0 {
                    *losses = (*losses + 1).min(CHATTERS);
                }
                *touches = now;
            }
        });
        FlowView { share: Some(Share { now: touching, ..share }), ..*v }
    }
}
