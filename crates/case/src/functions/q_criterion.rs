//! The second invariant of the velocity gradient: positive where a vortex turns faster than the flow
//! is strained.

use super::derived_field::DerivedField;
use super::field::{components, double_dot_transposed};
use super::gradient::RATE;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Rank, Values, View};

pub(super) const ENTRY: Entry = Entry {
    name: "Q",
    summary: "the field `Q`: second invariant of the velocity gradient, 1/s2",
    formula: "Q = ((tr G)^2 - tr(G . G))/2, G = grad U",
    reference: "J. C. R. Hunt, A. A. Wray, P. Moin, CTR-S88 (1988) 193",
    read: |r, _| {
        DerivedField::of_velocity_gradient(r, "Q", (Rank::Scalar, RATE.times(RATE)), compute)
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    for (c, g) in view.derived.gradient_u.iter().enumerate().take(view.mesh.n_cells) {
        let trace = g[0] + g[4] + g[8];
        out[0].set_cell(c, &components(&[0.5 * (trace * trace - double_dot_transposed(g))]));
    }
}
