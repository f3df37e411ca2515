//! The gradient of a scalar or of a vector, by Gauss's theorem with linear interpolation.

use super::derived_field::{DerivedField, result};
use super::field::components;
use super::quantity::{Quantity, Wanted};
use super::schedule::{Every, Schedule};
use super::{Components, Entry, Info, Rank, Unit, Values, View};
use granflow_base::Dims;

pub(super) const ENTRY: Entry = Entry {
    name: "grad",
    summary: "the field `grad(<field>)` of a scalar or a vector, `d_i u_j` by rows",
    formula: "(grad phi)_ij = d phi_j/d x_i, by the scheme of gradSchemes",
    reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 8",
    read: |r, reading| {
        let of = Wanted::one(r, "field", reading);
        let one = &of.list[0];
        let rank = match one.quantity.rank() {
            Rank::Scalar => Rank::Vector,
            Rank::Vector => Rank::Tensor,
            Rank::SymmTensor | Rank::Tensor => {
                let message = format!("`{}` is a tensor: its gradient has no file", one.name);
                r.error_at_key("field", message, "a scalar or a vector is needed", None);
                Rank::Tensor
            }
        };
        Box::new(DerivedField {
            makes: vec![Info {
                name: result(r, &format!("grad({})", one.name)),
                rank,
                unit: one.unit.per_length(),
                on_faces: false,
            }],
            derived: one.quantity == Quantity::U,
            of,
            compute,
        })
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(of: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let q = of.list[0].quantity;
    for c in 0..view.mesh.n_cells {
        // That of the velocity is the case's own, `gradSchemes` and all.
        let g = if q == Quantity::U { view.derived.gradient_u[c] } else { gauss(view, q, c) };
        out[0].set_cell(c, &g);
    }
}

/// Gauss's theorem in cell `c`: a vector of a scalar, a tensor of a vector.
fn gauss(view: &View<'_>, q: Quantity, c: usize) -> Components {
    let (mesh, n) = (view.mesh, q.n());
    let mut sum = [0.0; 9];
    for (f, s) in mesh.faces_of(c) {
        let v = view.on_face(q, f);
        for i in 0..3 {
            (0..n).for_each(|j| sum[n * i + j] += s * mesh.area[f][i] * v[j]);
        }
    }
    components(&sum[..3 * n]).map(|x| x / mesh.volume[c])
}

/// Dimensions of a rate, for what is made of the velocity gradient.
pub(super) const RATE: Unit = Unit::of(Dims::RATE);
