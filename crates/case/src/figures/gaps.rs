//! Data that curves ask for and that are not there: said once a folder, not once a curve or time.

use granflow_dict::{Diag, Sink, Span};

/// What is missing, in the order it was asked for.
#[derive(Default)]
pub(super) struct Gaps(Vec<Gap>);

struct Gap {
    folder: String,
    /// Names of the times; none when nothing at all is there.
    times: Vec<String>,
    curves: usize,
    /// Where the first of them is asked for.
    at: Span,
}

impl Gaps {
    /// A curve lacks `times` of `folder`, or all of it.
    pub(super) fn note(&mut self, folder: &str, times: &[String], at: &Span) {
        let same = |g: &&mut Gap| g.folder == folder && g.times.is_empty() == times.is_empty();
        match self.0.iter_mut().find(same) {
            Some(g) => {
                g.curves += times.len().max(1);
                let new = times.iter().filter(|t| !g.times.contains(t)).cloned();
                let new: Vec<String> = new.collect();
                g.times.extend(new);
            }
            None => self.0.push(Gap {
                folder: folder.to_owned(),
                times: times.to_vec(),
                curves: times.len().max(1),
                at: at.clone(),
            }),
        }
    }

    /// One warning for each folder.
    pub(super) fn warn(self, sink: &Sink) {
        for g in self.0 {
            let message = match &g.times[..] {
                [] => format!("there are no data in {}", g.folder),
                [t] => format!("no data for the time {t} in {}", g.folder),
                all => format!("no data for the times {} in {}", all.join(", "), g.folder),
            };
            let label = match g.curves {
                1 => "the curve is left out".to_owned(),
                n => format!("{n} curves are left out"),
            };
            sink.push(Diag::warning(&g.at, message).label(label));
        }
    }
}
