//! The divergence of a vector, or of the flux through faces.

use super::derived_field::{DerivedField, result};
use super::field::components;
use super::gradient::RATE;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Info, Rank, Values, View};
use granflow_base::dot;
use granflow_dict::Span;

pub(super) const ENTRY: Entry = Entry {
    name: "div",
    summary: "the field `div(<field>)` of a vector, or `div(phi)` of the volume flux",
    formula: "div U = sum U_f . S/V; div phi = sum phi/V of the volume flux",
    reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 8",
    read: |r, reading| {
        let info = |name: &str, unit| Info {
            name: result(r, &format!("div({name})")),
            rank: Rank::Scalar,
            unit,
            on_faces: false,
        };
        if r.maybe_string("field") == Some("phi") {
            return Box::new(DerivedField {
                makes: vec![info("phi", RATE)],
                of: Wanted { list: Vec::new(), span: Span::none() },
                derived: false,
                compute: of_flux,
            });
        }
        let of = Wanted::one(r, "field", reading);
        let one = &of.list[0];
        if one.quantity.rank() != Rank::Vector {
            let message = format!("`{}` is no vector", one.name);
            r.error_at_key("field", message, "a vector or `phi` is needed", None);
        }
        let makes = vec![info(&one.name, one.unit.per_length())];
        Box::new(DerivedField { makes, of, derived: false, compute: of_vector })
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn of_flux(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let mesh = view.mesh;
    for c in 0..mesh.n_cells {
        let sum: f64 = mesh.faces_of(c).map(|(f, s)| s * view.phi[f]).sum();
        out[0].set_cell(c, &components(&[sum / mesh.volume[c]]));
    }
}

fn of_vector(of: &Wanted, view: &View<'_>, out: &mut [Values]) {
    let (mesh, q) = (view.mesh, of.list[0].quantity);
    let through = |f: usize| {
        let v = view.on_face(q, f);
        dot(mesh.area[f], [v[0], v[1], v[2]])
    };
    for c in 0..mesh.n_cells {
        let sum: f64 = mesh.faces_of(c).map(|(f, s)| s * through(f)).sum();
        out[0].set_cell(c, &components(&[sum / mesh.volume[c]]));
    }
}
