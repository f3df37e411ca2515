//! Sums of powers of the time.

use super::{Form, Settings, value};
use granflow_base::Value;
use std::sync::Arc;

/// `sum of coefficient * time^exponent`, component by component.
struct Polynomial<T> {
    terms: Vec<(T, T)>,
}

impl<T: Value> Form<T> for Polynomial<T> {
    fn at(&self, time: f64) -> T {
        let mut out = T::ZERO;
        for (coefficient, exponent) in &self.terms {
            for c in 0..T::N {
                let term = coefficient.comp(c) * time.powf(exponent.comp(c));
                out.set_comp(c, out.comp(c) + term);
            }
        }
        out
    }
}

/// `polynomial ((coefficient exponent) ...)`, or `coeffs ( ... )` in a dictionary.
pub(super) fn read<T: Value>(s: &mut Settings<'_, '_>) -> Option<Arc<dyn Form<T>>> {
    let mut rows = s.list("coeffs", "the terms")?;
    let mut terms = Vec::new();
    while !rows.is_empty() {
        let mut row = rows.list("a term `(coefficient exponent)`")?;
        terms.push((value(&mut row), value(&mut row)));
        row.finish();
    }
    if terms.is_empty() {
        let help = Some("write `polynomial ((1 0) (2 1))` for 1 + 2 t");
        s.r.error_at_key(s.key, format!("polynomial `{}` has no terms", s.key), "empty", help);
    }
    Some(Arc::new(Polynomial { terms }))
}
