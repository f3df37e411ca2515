//! How large cells are.

use super::derived_field::DerivedField;
use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Info, Rank, Unit, Values, View};
use granflow_base::Dims;
use granflow_dict::Span;

pub(super) const ENTRY: Entry = Entry {
    name: "writeCellVolumes",
    summary: "the field `V`: volumes of cells, m3",
    formula: "V",
    reference: "OpenFOAM user guide, function objects",
    read: |_, _| {
        Box::new(DerivedField {
            makes: vec![Info {
                name: "V".into(),
                rank: Rank::Scalar,
                unit: Unit::of(Dims::VOLUME),
                on_faces: false,
            }],
            of: Wanted { list: Vec::new(), span: Span::none() },
            derived: false,
            compute,
        })
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let volume = &view.mesh.volume;
    (0..view.mesh.n_cells).for_each(|c| out[0].set_cell(c, &components(&[volume[c]])));
}
