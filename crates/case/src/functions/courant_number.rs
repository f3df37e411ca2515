//! The Courant number of the last step in every cell.

use super::derived_field::{DerivedField, result};
use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Info, Rank, Unit, Values, View};
use granflow_base::Dims;

pub(super) const ENTRY: Entry = Entry {
    name: "CourantNo",
    summary: "the field `Co`: half the flux through a cell's faces times the step over its volume",
    formula: "Co = dt sum |phi|/(2 V)",
    reference: "R. Courant, K. Friedrichs, H. Lewy, Math. Ann. 100 (1928) 32",
    read: |r, _| {
        r.ignore("phi");
        Box::new(DerivedField {
            makes: vec![Info {
                name: result(r, "Co"),
                rank: Rank::Scalar,
                unit: Unit::of(Dims::NONE),
                on_faces: false,
            }],
            of: Wanted::velocity(r),
            derived: false,
            compute,
        })
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let mesh = view.mesh;
    for c in 0..mesh.n_cells {
        let through: f64 = mesh.faces_of(c).map(|(f, _)| view.phi[f].abs()).sum();
        out[0].set_cell(c, &components(&[0.5 * view.dt * through / mesh.volume[c]]));
    }
}
