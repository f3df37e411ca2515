//! `where { alpha.grains (0.5 1); }`: what a figure is confined to.

use super::field::{Scene, check};
use super::shades::range;
use crate::CaseError;
use crate::section::{self, Piece};
use granflow_dict::Reader;

/// Most fields of one `where`.
pub(super) const MOST: usize = 4;

/// Ranges of fields; everything when there are none.
pub(super) struct Limits<'a> {
    /// Where they stand, if anywhere.
    reader: Option<Reader<'a>>,
    ranges: Vec<(&'a str, (f64, f64))>,
}

impl<'a> Limits<'a> {
    pub(super) fn read(r: &Reader<'a>) -> Limits<'a> {
        let reader = r.opt_sub("where");
        let mut ranges = Vec::new();
        if let Some(sub) = &reader {
            for key in sub.keys() {
                check(sub, key, key);
                ranges.extend(range(sub, key).map(|ends| (key, ends)));
            }
        }
        if ranges.len() > MOST {
            r.error_at_key("where", format!("at most {MOST} fields"), "too many", None);
            ranges.truncate(MOST);
        }
        Limits { reader, ranges }
    }

    pub(super) fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Values at the points of the mesh of a field that is shown within the ranges only: where a
    /// point has samples within, those beyond (of another phase) do not count. `None` after a
    /// mistake, which is reported at `key`.
    pub(super) fn at_points(
        &self,
        scene: &Scene<'_>,
        r: &Reader<'_>,
        key: &str,
        text: &str,
    ) -> Result<Option<Vec<f64>>, CaseError> {
        let Some(mut samples) = scene.samples(r, key, text)? else { return Ok(None) };
        for (field, (lo, hi)) in &self.ranges {
            let Some(reader) = &self.reader else { break };
            let Some(by) = scene.samples(reader, field, field)? else { return Ok(None) };
            let within = by.values.iter().map(|v| (*lo..=*hi).contains(v));
            samples.known.iter_mut().zip(within).for_each(|(known, within)| *known &= within);
        }
        Ok(Some(scene.grid.at_points(&samples)))
    }

    /// Values of their fields at the points of the mesh, for the slots from `first` on.
    pub(super) fn slots(
        &self,
        scene: &Scene<'_>,
        first: usize,
    ) -> Result<Vec<(usize, Vec<f64>)>, CaseError> {
        let mut out = Vec::new();
        for (k, (field, _)) in self.ranges.iter().enumerate() {
            let Some(reader) = &self.reader else { break };
            out.extend(scene.at_points(reader, field, field)?.map(|v| (first + k, v)));
        }
        Ok(out)
    }

    /// What of triangles lies within all ranges, or within all but one.
    pub(super) fn confine(
        &self,
        mut pieces: Vec<Piece>,
        first: usize,
        but: Option<usize>,
    ) -> Vec<Piece> {
        for (k, (_, (lo, hi))) in self.ranges.iter().enumerate() {
            if Some(k) != but {
                let slack = 1e-9 * (hi - lo);
                pieces = section::clip(pieces, first + k, lo - slack, 1.0);
                pieces = section::clip(pieces, first + k, hi + slack, -1.0);
            }
        }
        pieces
    }

    /// The surfaces that bound the ranges: number of the range, its field and the level.
    pub(super) fn ends(&self) -> impl Iterator<Item = (usize, &'a str, f64)> {
        let both = |(k, (field, (lo, hi))): (usize, &(&'a str, (f64, f64)))| {
            [(k, *field, *lo), (k, *field, *hi)]
        };
        self.ranges.iter().enumerate().flat_map(both)
    }

    /// A warning when nothing is left.
    pub(super) fn warn_if_empty(&self, pieces: &[Piece], r: &Reader<'_>, time: &str) {
        let Some(sub) = self.reader.as_ref().filter(|_| pieces.is_empty()) else { return };
        let at = sub.keys().first().map_or_else(|| r.key_span("where"), |k| sub.key_span(k));
        let message = format!("nothing lies within `where` at the time {time}");
        r.warn_at(&at, message, "leaves nothing", None);
    }
}
