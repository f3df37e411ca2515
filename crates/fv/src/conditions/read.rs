//! What readers of conditions have in common.

use super::PatchContext;
use granflow_base::Value;
use granflow_dict::{FieldValue, Reader};

/// `uniform v` or `nonuniform ..` as it stands.
pub(super) fn values<T: Value>(r: &Reader<'_>, key: &str, n: usize) -> Vec<T> {
    match r.field::<T>(key, n) {
        FieldValue::Uniform(v) => vec![v],
        FieldValue::NonUniform(v) if v.is_empty() => vec![T::ZERO],
        FieldValue::NonUniform(v) => v,
    }
}

/// The same in the units of the field (per metre, of a gradient).
pub(super) fn field_values<T: Value>(r: &Reader<'_>, key: &str, c: &PatchContext<'_>) -> Vec<T> {
    let given = values::<T>(r, key, c.n_faces);
    match c.factor {
        1.0 => given,
        k => given.into_iter().map(|v| v.scaled(k)).collect(),
    }
}

/// What OpenFOAM's own output carries along without meaning for the condition.
pub(super) fn leave_value(r: &Reader<'_>) {
    r.ignore("value");
}

/// Names of the fields of flux and density, which are what they are called here.
pub(super) fn leave_flux(r: &Reader<'_>) {
    r.ignore("phi");
    r.ignore("rho");
}
