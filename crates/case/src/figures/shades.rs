//! How values become colours, as the dictionary of a figure says.

use crate::plot::{ColourMap, Shades, literal};
use granflow_dict::Reader;

/// `map`, `range` and `barLabel`.
pub(super) struct ShadeSpec {
    map: ColourMap,
    range: Option<(f64, f64)>,
    label: String,
}

impl ShadeSpec {
    pub(super) fn read(r: &Reader<'_>) -> ShadeSpec {
        let maps = [("viridis", ColourMap::Viridis), ("coolwarm", ColourMap::CoolWarm)];
        ShadeSpec {
            map: r.opt_one_of("map", &maps, ColourMap::Viridis),
            range: range(r, "range"),
            label: r.opt_string("barLabel", "").to_owned(),
        }
    }

    /// With the ends of the values where no range is given; around zero for a diverging map.
    pub(super) fn over(&self, values: impl Iterator<Item = f64>, field: &str) -> Shades {
        let (lo, hi) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| (e.0.min(v), e.1.max(v)));
        let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, 1.0) };
        let (lo, hi) = match self.map {
            ColourMap::CoolWarm if lo < 0.0 && hi > 0.0 => {
                let most = hi.max(-lo);
                (-most, most)
            }
            _ if hi - lo <= 1e-12 * hi.abs().max(lo.abs()) => {
                let half = if lo == 0.0 { 1.0 } else { 0.1 * lo.abs() };
                (lo - half, hi + half)
            }
            _ => (lo, hi),
        };
        let label = match &self.label[..] {
            "" => literal(field).into_owned(),
            given => given.to_owned(),
        };
        Shades { map: self.map, range: self.range.unwrap_or((lo, hi)), label }
    }
}

/// Two growing numbers.
pub(super) fn range(r: &Reader<'_>, key: &str) -> Option<(f64, f64)> {
    let before = r.sink().n_errors();
    let v = r.maybe_scalars(key)?;
    match v[..] {
        [a, b] if a < b => Some((a, b)),
        // It is no list, which was reported.
        _ if r.sink().n_errors() > before => None,
        _ => {
            let help = Some("write `(0 16)`");
            r.error_at_key(key, "a range is two growing numbers", "not a range", help);
            None
        }
    }
}
