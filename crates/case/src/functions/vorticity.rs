//! The curl of the velocity.

use super::derived_field::DerivedField;
use super::field::components;
use super::gradient::RATE;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Rank, Values, View};

pub(super) const ENTRY: Entry = Entry {
    name: "vorticity",
    summary: "the field `vorticity`: the curl of the velocity, 1/s",
    formula: "omega = curl U",
    reference: "G. K. Batchelor, An Introduction to Fluid Dynamics, ch. 2",
    read: |r, _| DerivedField::of_velocity_gradient(r, "vorticity", (Rank::Vector, RATE), compute),
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    for (c, g) in view.derived.gradient_u.iter().enumerate().take(view.mesh.n_cells) {
        // g[3 i + j] = d_i U_j.
        out[0].set_cell(c, &components(&[g[5] - g[7], g[6] - g[2], g[1] - g[3]]));
    }
}
