//! How long a run may take and how much it may write.

use super::outlook::Outlook;
use super::page::Page;
use super::time_step::step;
use crate::text::{bytes, count, duration, rounded};
use granflow_case::Case;
use granflow_case::config::WriteControl;
use granflow_case::store::Compression;
use granflow_dict::Format;
use granflow_flow::TimeScheme;

/// Time of a cell in a step, s, around what single runs of the catalogue took on one thread.
/// `cavity` takes 1.4e-6.
const PISO: [f64; 2] = [1e-6, 5e-6];
/// `bingham_poiseuille` takes 1e-4.
const COUPLED: [f64; 2] = [2e-5, 2e-4];
/// `dam_break` and `rising_bubble` take 3e-6.
const TWO_FLUIDS: [f64; 2] = [2e-6, 1e-5];
/// `annular_shear_cell`, `linear_shear_gravity` and `heap_dry` take 4e-4 to 8e-4.
const GRAINS: [f64; 2] = [1e-4, 1e-3];
/// `column_collapse` takes 1.4e-4.
const GRAINS_IN_FLUID: [f64; 2] = [5e-5, 5e-4];

pub(super) fn say(case: &Case, outlook: &Outlook, page: &mut Page) {
    page.open("Cost");
    let dt = step(case, outlook);
    let span = (case.end - case.start.time).max(0.0);
    let steps = (span / dt).ceil();
    let adjusted = case.config.control.adjust.is_some();
    let of = if adjusted { " or so, of the length that the Courant number allows" } else { "" };
    page.say("steps", format!("{}{of}", rounded(steps, if adjusted { 2 } else { 6 })));
    let [low, high] = seconds(case, steps);
    page.say(
        "time",
        format!(
            "{} on one thread ({} cells, from the catalogue's times a cell and step)",
            match high < 0.1 {
                true => "less than 0.1 s".to_owned(),
                false => format!("about {} to {}", duration(low), duration(high)),
            },
            case.mesh.n_cells
        ),
    );
    let (writes, each) = disk(case, steps);
    let total = bytes(writes * each);
    page.say(
        "disk",
        format!("about {total}: {} of {}", count(writes as usize, "time"), bytes(each)),
    );
}

/// Least and greatest time of all steps, s.
fn seconds(case: &Case, steps: f64) -> [f64; 2] {
    let transport = &case.config.transport;
    let steady = case.config.schemes.ddt == TimeScheme::Steady;
    let outer = case.config.solution.outer as f64;
    let [low, high] = match (transport.second.is_some(), transport.grains.is_some()) {
        (_, true) if steady => GRAINS,
        _ if steady => COUPLED,
        (true, true) => GRAINS_IN_FLUID,
        (true, false) => TWO_FLUIDS,
        (false, true) => GRAINS,
        (false, false) if outer > 1.0 => COUPLED,
        (false, false) => PISO,
    };
    [low, high].map(|each| each * steps * case.mesh.n_cells as f64)
}

/// Number of time directories and the size of one, bytes.
fn disk(case: &Case, steps: f64) -> (f64, f64) {
    let control = &case.config.control;
    let span = (case.end - case.start.time).max(0.0);
    let writes = match control.write {
        WriteControl::Steps(n) => (steps / n as f64).ceil(),
        WriteControl::Time(every) | WriteControl::Adjustable(every) => (span / every).ceil(),
        WriteControl::Never => 1.0,
    };
    let kept = if control.purge > 0 { writes.min(control.purge as f64) } else { writes };
    // U, p, strain rate, viscosity; of grains fluidity, I and mu as well; phi on faces.
    let fields = if case.config.transport.grains.is_some() { 9.0 } else { 6.0 };
    let numbers = fields * case.mesh.n_cells as f64 + case.mesh.n_faces() as f64;
    let size = match (control.format, control.compression) {
        (Format::Ascii, Compression::Plain) => 20.0,
        (Format::Ascii, Compression::Gzip) => 9.0,
        (Format::Binary, Compression::Plain) => 8.0,
        (Format::Binary, Compression::Gzip) => 7.5,
    };
    (kept.max(1.0), numbers * size + 8e3)
}
