//! What flows, in which units.

use super::page::Page;
use crate::text::number;
use granflow_base::norm;
use granflow_case::Case;
use granflow_case::config::Transport;
use granflow_flow::{Source, Zone};

pub(super) fn say(case: &Case, page: &mut Page) {
    page.open("Phases and units");
    let transport = &case.config.transport;
    match &transport.second {
        None => page.say("model", of(transport)),
        Some(second) => {
            page.say(&second.names[0], of(transport));
            page.say(&second.names[1], of(&second.transport));
            page.say("surface tension", format!("{} N/m", number(second.sigma)));
        }
    }
    if let Some(g) = &transport.grains {
        let text = format!(
            "d {} m, density of a grain {} kg/m3, mu from {} at rest to {}, I0 {}",
            number(g.d),
            number(g.rho_s),
            number(g.mu_s),
            number(g.mu_2),
            number(g.i0)
        );
        page.say("grains", text);
        let filled = transport.rho / g.rho_s;
        // Equal ones are a case without units.
        if !(0.3..=1.0).contains(&filled) {
            page.warn(format!(
                "rho is that of grains and gaps together: {} of a grain's density, where packings \
                 have about 0.55 to 0.64",
                number(filled)
            ));
        }
    }
    let gravity = case.config.gravity.unwrap_or_default();
    let text = match norm(gravity) {
        0.0 => "none".to_owned(),
        _ => {
            let [x, y, z] = gravity.map(number);
            format!("({x} {y} {z}) m/s2")
        }
    };
    page.say("gravity", text);
    for source in &case.sources {
        page.say("source", of_source(source.as_ref(), case.mesh.n_cells));
    }
    for (k, one) in case.sources.iter().enumerate() {
        for other in &case.sources[..k] {
            // Held mean velocities do not, which every command says.
            if one.kind() == other.kind()
                && one.held().is_none()
                && one.name() != other.name()
                && one.zone().meets(other.zone())
            {
                page.warn(format!(
                    "`{}` and `{}` are both a {} and share cells: there they add up",
                    other.name(),
                    one.name(),
                    one.kind()
                ));
            }
        }
    }
    let unit = match (case.start.kinematic(), case.pressure_factor()) {
        (false, _) => "Pa".to_owned(),
        (true, rho) => format!("m2/s2 in its file, times rho = {} kg/m3 inside", number(rho)),
    };
    let name = case.config.pressure();
    let what = if name == "p_rgh" { "p_rgh, the pressure less the weight above" } else { "p" };
    page.say("pressure", format!("{what}, in {unit}"));
}

/// A force on the bulk and where it acts.
fn of_source(source: &dyn Source, all: usize) -> String {
    let what = source.says(&number);
    match source.zone() {
        Zone::All => format!("{what}, in all cells"),
        Zone::Cells(cells) => format!("{what}, in {} of {all} cells", cells.len()),
    }
}

fn of(t: &Transport) -> String {
    format!("{}, rho {} kg/m3", t.model, t.rho)
}
