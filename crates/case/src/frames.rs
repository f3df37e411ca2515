//! What turning frames a state was written with: `uniform/turningFrames` of a time directory.
//!
//! In a zone that turns `phi` is the flux relative to the frame. Of a state with other frames it is another
//! one: where they differ, fluxes are made anew from the velocity, as at the start of a run.

use crate::restart::WholeState;
use crate::{CaseError, Notices, files};
use granflow_base::{Dims, Vec3, norm, scale, sub};
use granflow_dict::{Dict, Format, Header, Reader, Sink, Writer};
use granflow_flow::sources::{RotatingFrame, Source, Zone};
use std::path::Path;

const FILE: &str = "uniform/turningFrames";
/// What rounding may make of the same frame, of its size.
const SAME: f64 = 1e-9;

/// The file and its text in the directory `dir` at `time`, where something turns.
pub(crate) fn sheet(
    sources: &[Box<dyn Source>],
    dir: &str,
    time: f64,
) -> Option<(&'static str, Vec<u8>)> {
    let mut frames = sources.iter().filter_map(|s| s.frame()).peekable();
    frames.peek()?;
    let header = Header::new("dictionary", "turningFrames").location(format!("{dir}/uniform"));
    let mut w = Writer::new(&header.format(Format::Ascii));
    for frame in frames {
        w.open(&frame.name);
        w.vector("origin", frame.origin);
        w.vector("omega", scale(frame.axis, frame.omega.at(time)));
        w.entry("nonRotatingPatches", format_args!("({})", frame.still.join(" ")));
        w.entry("cells", format_args!("\"{}\"", cells(frame)));
        w.close();
    }
    Some((FILE, w.finish()))
}

/// Where the state was written with other frames than `sources` has, it loses its fluxes, which is said.
///
/// # Errors
/// The file is there and cannot be read.
pub(crate) fn meet(
    root: &Path,
    start: &mut WholeState,
    sources: &[Box<dyn Source>],
    sink: &Sink,
    notices: &Notices,
) -> Result<(), CaseError> {
    if start.phi.is_none() {
        return Ok(());
    }
    let frames: Vec<&RotatingFrame> = sources.iter().filter_map(|s| s.frame()).collect();
    let file = format!("{}/{FILE}", start.dir);
    let why = match files::dict(root, &file, sink)? {
        None if frames.is_empty() => return Ok(()),
        None => format!("{file} is not there, which says what frames turned when phi was written"),
        Some(dict) if same(&dict, &frames, start.time) => return Ok(()),
        Some(_) => format!("constant/MRFProperties is not what phi was written with ({file})"),
    };
    (start.phi, start.phi_old, start.u_old, start.dt_old) = (None, None, None, 0.0);
    notices.say(format!("{why}: fluxes are made anew from the velocity"));
    Ok(())
}

fn same(dict: &Dict, frames: &[&RotatingFrame], time: f64) -> bool {
    // What cannot be understood is not the same.
    let sink = Sink::new();
    let all = Reader::new(dict, &sink);
    let written = all.subs();
    let near = |a: Vec3, b: Vec3| norm(sub(a, b)) <= SAME * norm(a).max(norm(b));
    let is = |frame: &&RotatingFrame, r: &Reader<'_>| {
        near(r.vector("origin", Dims::LENGTH), frame.origin)
            && near(r.vector("omega", Dims::RATE), scale(frame.axis, frame.omega.at(time)))
            && r.words("nonRotatingPatches") == frame.still
            && r.string("cells") == cells(frame)
    };
    written.len() == frames.len()
        && frames.iter().all(|frame| written.iter().any(|(_, r)| is(frame, r)))
}

/// How many cells a frame has, and a sum that other cells do not have (the FNV-1a hash of G. Fowler, L. C. Noll
/// and K.-P. Vo).
fn cells(frame: &RotatingFrame) -> String {
    let Zone::Cells(cells) = &frame.zone else { return "all".to_owned() };
    let bytes = cells.iter().flat_map(|c| c.to_le_bytes());
    let sum = bytes.fold(0xcbf2_9ce4_8422_2325u64, |sum, b| {
        (sum ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{} {sum:016x}", cells.len())
}
