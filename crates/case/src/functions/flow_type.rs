//! What kind of flow a place has: -1 rotation, 0 simple shear, 1 pure strain.

use super::derived_field::DerivedField;
use super::field::components;
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::{Entry, Rank, Unit, Values, View};
use granflow_base::{Dims, Tensor};

pub(super) const ENTRY: Entry = Entry {
    name: "flowType",
    summary: "the field `flowType`: -1 rotation, 0 simple shear, 1 pure strain",
    formula: "(|D| - |W|)/(|D| + |W|), D and W the symmetric and the antisymmetric part of \
              grad U",
    reference: "J. S. Lee et al., Rheol. Acta 46 (2007) 521",
    read: |r, _| {
        DerivedField::of_velocity_gradient(
            r,
            "flowType",
            (Rank::Scalar, Unit::of(Dims::NONE)),
            compute,
        )
    },
    schedule: Schedule::always(Every::Writes(1)),
};

fn compute(_: &Wanted, view: &View<'_>, out: &mut [Values]) {
    for (c, g) in view.derived.gradient_u.iter().enumerate().take(view.mesh.n_cells) {
        out[0].set_cell(c, &components(&[kind(g)]));
    }
}

/// `(|D| - |W|)/(|D| + |W|)` of the symmetric and the antisymmetric part.
fn kind(g: &Tensor) -> f64 {
    let (mut strain, mut spin) = (0.0, 0.0);
    for i in 0..3 {
        for j in 0..3 {
            let (a, b) = (g[3 * i + j], g[3 * j + i]);
            strain += 0.25 * (a + b) * (a + b);
            spin += 0.25 * (a - b) * (a - b);
        }
    }
    let (d, w) = (f64::sqrt(strain), f64::sqrt(spin));
    if d + w > 0.0 { (d - w) / (d + w) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::kind;

    #[test]
    fn rotation_shear_and_strain_are_told_apart() {
        let of = |a: f64, b: f64| kind(&[0.0, a, 0.0, b, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((of(1.0, -1.0) + 1.0).abs() < 1e-15);
        assert!(of(1.0, 0.0).abs() < 1e-15);
        assert!((of(1.0, 1.0) - 1.0).abs() < 1e-15);
        assert_eq!(of(0.0, 0.0), 0.0);
    }
}
