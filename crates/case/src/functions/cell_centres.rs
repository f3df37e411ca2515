//! Where cells are.

use super::derived_field::{DerivedField, fill};
use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Info, Rank, Unit, Values, View};
use granflow_base::Dims;
use granflow_dict::Span;

pub(super) const ENTRY: Entry = Entry {
    name: "writeCellCentres",
    summary: "the fields `C`, `Cx`, `Cy`, `Cz`: centres of cells and boundary faces, m",
    formula: "C = x_P, the centroid",
    reference: "OpenFOAM user guide, function objects",
    read: |_, _| {
        let info = |name: &str, rank| Info {
            name: name.into(),
            rank,
            unit: Unit::of(Dims::LENGTH),
            on_faces: true,
        };
        Box::new(DerivedField {
            makes: vec![
                info("C", Rank::Vector),
                info("Cx", Rank::Scalar),
                info("Cy", Rank::Scalar),
                info("Cz", Rank::Scalar),
            ],
            of: Wanted { list: Vec::new(), span: Span::none() },
            derived: false,
            compute,
        })
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let (cells, faces) = (&view.mesh.cell_centre, &view.mesh.face_centre);
    fill(view, &mut out[0], |c| components(&cells[c]), |f| components(&faces[f]));
    for k in 0..3 {
        let (cell, face) = (|c: usize| cells[c][k], |f: usize| faces[f][k]);
        fill(view, &mut out[1 + k], |c| components(&[cell(c)]), |f| components(&[face(f)]));
    }
}
