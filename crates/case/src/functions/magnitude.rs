//! The size of a field, and its square.

use super::derived_field::{DerivedField, fill, result};
use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Components, Entry, Info, Plan, Rank, Reading, Values, View};
use granflow_dict::Reader;

pub(super) const ENTRY: Entry = Entry {
    name: "mag",
    summary: "the field `mag(<field>)`: the square root of the sum of the squares of all components",
    formula: "|phi| = sqrt(sum phi_i^2)",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| make(r, reading, "mag"),
    schedule: Schedule::always(Every::Writes(1)),
};

pub(super) const ENTRY_SQUARE: Entry = Entry {
    name: "magSqr",
    summary: "the field `magSqr(<field>)`: the sum of the squares of all components",
    formula: "|phi|^2 = sum phi_i^2",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| make(r, reading, "magSqr"),
    schedule: Schedule::always(Every::Writes(1)),
};

fn make(r: &Reader<'_>, reading: &Reading<'_>, kind: &str) -> Box<dyn Plan> {
    let of = Wanted::one(r, "field", reading);
    let square = kind == "magSqr";
    let name = result(r, &format!("{kind}({})", of.list[0].name));
    let unit = of.list[0].unit;
    Box::new(DerivedField {
        makes: vec![Info {
            name,
            rank: Rank::Scalar,
            unit: if square { unit.times(unit) } else { unit },
            on_faces: true,
        }],
        of,
        derived: false,
        compute: if square { square_of } else { size_of },
    })
}

/// The sum of the squares of the components of a value, those beside the diagonal of a symmetric
/// tensor twice.
pub(super) fn square(v: &Components, rank: Rank) -> f64 {
    let sum: f64 = v[..rank.n()].iter().map(|x| x * x).sum();
    match rank {
        Rank::SymmTensor => sum + v[1] * v[1] + v[2] * v[2] + v[4] * v[4],
        _ => sum,
    }
}

fn square_of(of: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let q = of.list[0].quantity;
    let of = |v: Components| components(&[square(&v, q.rank())]);
    fill(view, &mut out[0], |c| of(view.cell(q, c)), |f| of(view.on_boundary(q, f)));
}

fn size_of(of: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let q = of.list[0].quantity;
    let of = |v: Components| components(&[square(&v, q.rank()).sqrt()]);
    fill(view, &mut out[0], |c| of(view.cell(q, c)), |f| of(view.on_boundary(q, f)));
}
