//! Text of tables.

use super::field::Components;
use super::{Rank, View};
use granflow_base::Vec3;
use granflow_dict::number;

/// Least width of a column, as OpenFOAM has it with six digits.
const WIDTH: usize = 14;

/// `1` or `(1 2 3)`.
pub(super) fn value(rank: Rank, v: &Components) -> String {
    match rank {
        Rank::Scalar => number(v[0]),
        _ => {
            format!("({})", v[..rank.n()].iter().map(|x| number(*x)).collect::<Vec<_>>().join(" "))
        }
    }
}

/// `(1 2 3)`.
pub(super) fn vector(v: Vec3) -> String {
    format!("({})", v.map(number).join(" "))
}

/// A comment line `# key         : value`.
pub(super) fn property(key: &str, value: &str) -> String {
    format!("# {key:<12}: {value}\n")
}

/// The comment line that names the columns behind the time.
pub(super) fn head(names: &[String]) -> String {
    let names = names.iter().map(|n| format!("\t{n:<WIDTH$}"));
    format!("# {:<12}{}", "Time", names.collect::<String>()).trim_end().to_owned()
}

/// The time and what follows it.
pub(super) fn row(view: &View<'_>, cells: &[String]) -> String {
    format!("{:<WIDTH$}\t{}", view.time_name, cells.join("\t"))
}
