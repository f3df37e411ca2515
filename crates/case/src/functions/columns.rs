//! Text of tables.

use super::Quantity;
use granflow_base::Vec3;
use granflow_dict::number;

/// `1` or `(1 2 3)`.
pub(super) fn value(q: Quantity, v: Vec3) -> String {
    if q.n() == 3 { vector(v) } else { number(v[0]) }
}

/// `(1 2 3)`.
pub(super) fn vector(v: Vec3) -> String {
    format!("({})", v.map(number).join(" "))
}
