//! What limits the time step.

use super::outlook::Outlook;
use super::page::Page;
use crate::text::{number, rounded};
use granflow_case::Case;
use granflow_flow::TimeScheme;
use std::f64::consts::PI;

pub(super) fn say(case: &Case, outlook: &Outlook, page: &mut Page) {
    page.open("Time step");
    let control = &case.config.control;
    let (from, to) = (case.start.time, case.end);
    page.say("time", format!("{} to {} s", rounded(from, 6), rounded(to, 6)));
    let steady = case.config.schemes.ddt == TimeScheme::Steady;
    if steady {
        page.say("steps", "each finds the steady state of the conditions at its end");
        return;
    }
    let rate = outlook.rate();
    if rate > 0.0 {
        let speeds = match (outlook.fall, rate > outlook.courant) {
            (Some(_), true) => "after a free fall",
            _ if outlook.held.is_some() && outlook.drives.is_empty() => {
                "at the mean velocity that is held"
            }
            _ => "at the speeds of patches and start fields",
        };
        let courant = rate * control.dt;
        page.say(
            "deltaT",
            format!(
                "{} s is a Courant number of about {} {speeds}; a Courant number of 1 needs {} s",
                number(control.dt),
                number(courant),
                number(1.0 / rate)
            ),
        );
        // Cells with steps of their own do not have this one.
        let local = matches!(case.config.schemes.ddt, granflow_flow::TimeScheme::Local(_));
        let explicit = case.config.transport.second.is_some()
            || (case.config.transport.grains.is_none() && case.config.solution.outer == 1);
        if explicit && !local && control.adjust.is_none() && courant > 1.001 {
            page.warn(
                "that is more than 1: PISO and the interface become inaccurate or unstable; shorten \
                 deltaT, or write `adjustTimeStep yes; maxCo 0.5;`",
            );
        }
    } else {
        let text = format!("{} s; no speed is known beforehand to judge it by", number(control.dt));
        page.say("deltaT", text);
    }
    if let Some(a) = &control.adjust {
        let mut text = format!("to a Courant number of {}", number(a.max_co));
        if case.config.transport.second.is_some() {
            text += &format!(", {} at the interface", number(a.max_alpha_co));
        }
        if a.max_dt.is_finite() {
            text += &format!(", to {} s at most", number(a.max_dt));
        }
        page.say("adjusted", text);
        if a.max_co.min(a.max_alpha_co) > 1.0 && case.config.transport.second.is_some() {
            page.warn(
                "the interface skips cells at a Courant number above 1: write maxAlphaCo 0.5",
            );
        }
    }
    if let Some(limit) = capillary(case, outlook) {
        let text = format!("waves of surface tension on the cells need {} s", number(limit));
        page.say("capillary limit", format!("{text} (Brackbill et al. 1992)"));
        let longest = control.adjust.map_or(control.dt, |a| a.max_dt.min(step(case, outlook)));
        if longest > limit {
            page.warn(format!(
                "steps of up to {} s are longer: currents along the interface may grow; set {} to \
                 that or less",
                number(longest),
                if control.adjust.is_some() { "maxDeltaT" } else { "deltaT" }
            ));
        }
    }
}

/// Step beyond which capillary waves of the length of two cells are unstable where surface tension
/// is explicit, s.
fn capillary(case: &Case, outlook: &Outlook) -> Option<f64> {
    let second = case.config.transport.second.as_ref().filter(|s| s.sigma > 0.0)?;
    let mean = 0.5 * (case.config.transport.rho + second.transport.rho);
    Some((mean * outlook.spacing[0].powi(3) / (2.0 * PI * second.sigma)).sqrt())
}

/// The step that a run is likely to take, s.
pub(super) fn step(case: &Case, outlook: &Outlook) -> f64 {
    let control = &case.config.control;
    let Some(a) = &control.adjust else { return control.dt };
    match outlook.rate() {
        0.0 => control.dt,
        rate => (a.max_co.min(a.max_alpha_co) / rate).min(a.max_dt),
    }
}
