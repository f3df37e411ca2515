//! Data that curves and figures ask for and that are not there: said once a folder, not once a curve or time.

use granflow_dict::{Diag, Sink, Span};

/// What is missing, in the order it was asked for.
#[derive(Default)]
pub(super) struct Gaps(Vec<Gap>);

struct Gap {
    /// Empty: the case itself, asked for by figures of fields.
    folder: String,
    /// Names of the times; none when nothing at all is there.
    times: Vec<String>,
    /// How many curves or figures are left out.
    left_out: usize,
    /// Where the first of them is asked for.
    at: Span,
}

impl Gaps {
    /// A curve lacks `times` of `folder`, or all of it.
    pub(super) fn note(&mut self, folder: &str, times: &[String], at: &Span) {
        let same = |g: &&mut Gap| g.folder == folder && g.times.is_empty() == times.is_empty();
        match self.0.iter_mut().find(same) {
            Some(g) => {
                g.left_out += times.len().max(1);
                let new = times.iter().filter(|t| !g.times.contains(t)).cloned();
                let new: Vec<String> = new.collect();
                g.times.extend(new);
            }
            None => self.0.push(Gap {
                folder: folder.to_owned(),
                times: times.to_vec(),
                left_out: times.len().max(1),
                at: at.clone(),
            }),
        }
    }

    /// A figure lacks `times` of the case, or the case has none.
    pub(super) fn note_fields(&mut self, times: &[String], at: &Span) {
        self.note("", times, at);
    }

    /// One warning for each folder.
    pub(super) fn warn(self, sink: &Sink) {
        for g in self.0 {
            let times = g.times.join(", ");
            let message = match (&g.folder[..], g.times.len()) {
                ("", 0) => "the case has no time directories".to_owned(),
                ("", 1) => format!("the case has no time {times}"),
                ("", _) => format!("the case has no times {times}"),
                (folder, 0) => format!("there are no data in {folder}"),
                (folder, 1) => format!("no data for the time {times} in {folder}"),
                (folder, _) => format!("no data for the times {times} in {folder}"),
            };
            let what = if g.folder.is_empty() { "figure" } else { "curve" };
            let label = match g.left_out {
                1 => format!("the {what} is left out"),
                n => format!("{n} {what}s are left out"),
            };
            sink.push(Diag::warning(&g.at, message).label(label));
        }
    }
}
