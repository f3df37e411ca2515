//! Which shear rates and inertial numbers are to be expected.

use super::outlook::{Drive, Outlook};
use super::page::Page;
use crate::text::number;
use granflow_base::norm;
use granflow_case::Case;

/// Width in grains of the layer that shears when it localises at a wall.
const LAYER: f64 = 5.0;

pub(super) fn say(case: &Case, outlook: &Outlook, page: &mut Page) {
    page.open("What to expect");
    let Some(g) = &case.config.transport.grains else {
        fluid(outlook, page);
        reynolds(case, outlook, page);
        return;
    };
    if let Some([least, _, most]) = outlook.pressure {
        if least <= 0.0 {
            page.warn(
                "the pressure at the start is not positive everywhere: grains fall apart there",
            );
        }
        let how = match case.config.transport.second.is_some() {
            true => "from the weight of grains",
            false => "at the start",
        };
        page.say("pressure", format!("{} Pa {how}", range(least, most)));
    }
    slope(case, page);
    let Some([low, high]) = rates(case, outlook) else {
        page.say("shear rate", "not known: no patch moves, and nothing falls");
        return;
    };
    page.say("shear rate", format!("about {} 1/s", range(low, high)));
    grains(case, outlook, high, page);
    let Some([a, b]) = inertial(case, outlook).filter(|i| i[1] > 0.0) else { return };
    let regime = match b {
        b if b < 1e-3 => "quasi-static: the nonlocal part decides",
        b if b < 0.3 => "dense flow",
        _ => "fast: beyond what mu(I) was measured for (I up to about 0.3)",
    };
    let how = match (outlook.drives.is_empty(), outlook.fall) {
        (false, _) => "at the driven patches",
        (true, Some(_)) => "were they to fall freely",
        (true, None) => "down such a slope",
    };
    page.say("inertial number", format!("I about {} {how} ({regime})", range(a, b)));
    let mu = |i: f64| g.mu_s + (g.mu_2 - g.mu_s) / (g.i0 / i + 1.0);
    page.say("friction", format!("mu of {} by mu(I)", range(mu(a), mu(b))));
}

/// `a to b`, or the one value that both are.
fn range(a: f64, b: f64) -> String {
    if b - a <= 1e-9 * b { number(b) } else { format!("{} to {}", number(a), number(b)) }
}

fn fluid(outlook: &Outlook, page: &mut Page) {
    if let Some(fall) = outlook.fall {
        page.say(
            "speed",
            format!("up to {} m/s, after a fall of {} m", number(fall), number(outlook.height)),
        );
    }
    for d in &outlook.drives {
        let [least, most] = [d.speed[0] / d.reach, d.speed[1] / d.width];
        let text = format!(
            "{} 1/s across the mesh to {} 1/s in the first cells at patch {}",
            number(least),
            number(most),
            d.patch
        );
        page.say("shear rate", text);
    }
    if let Some([speed, _]) = outlook.held {
        page.say("speed", format!("{} m/s on the mean, which a source holds", number(speed)));
    }
    if outlook.drives.is_empty() && outlook.fall.is_none() && outlook.held.is_none() {
        page.say("speed", "not known: no patch moves, and nothing falls");
    }
}

/// Speed times length over the kinematic viscosity, of what is fastest.
fn reynolds(case: &Case, outlook: &Outlook, page: &mut Page) {
    let named = |d: &Drive| (d.speed[1], d.length, format!("patch {}", d.patch));
    let held = outlook.held.map(|[speed, width]| (speed, width, "the walls".to_owned()));
    let fall =
        outlook.fall.map(|speed| (speed, outlook.height, "the height of the fall".to_owned()));
    let all = outlook.drives.iter().map(named).chain(held).chain(fall);
    let Some((speed, length, of)) = all.max_by(|a, b| (a.0 * a.1).total_cmp(&(b.0 * b.1))) else {
        return;
    };
    let first = &case.config.transport;
    let second = first.second.as_ref();
    let fluids = match second {
        None => vec![("", first)],
        Some(second) => {
            vec![(second.names[0].as_str(), first), (second.names[1].as_str(), &second.transport)]
        }
    };
    for (name, fluid) in fluids {
        let Some(eta) = fluid.viscosity_at(&case.mesh, speed / length) else { continue };
        let number_of = fluid.rho * speed * length / eta;
        let among = if name.is_empty() { String::new() } else { format!(" of {name}") };
        let at = match fluid.is_constant {
            true => String::new(),
            false => format!(" with the viscosity at {} 1/s", number(speed / length)),
        };
        let text = format!(
            "about {}{among}: {} m/s over {} m ({of}){at}",
            number(number_of),
            number(speed),
            number(length)
        );
        page.say("Reynolds number", text);
    }
}

/// What grains are to the flow: how many of them lie across it, and what the fluid between them does.
fn grains(case: &Case, outlook: &Outlook, rate: f64, page: &mut Page) {
    let Some(g) = &case.config.transport.grains else { return };
    if let Some(d) = outlook.drives.iter().min_by(|a, b| a.reach.total_cmp(&b.reach)) {
        let across =
            format!("{} between patch {} and what is opposite", number(d.reach / g.d), d.patch);
        page.say("grains across", across);
    }
    let Some(second) = &case.config.transport.second else { return };
    let Some(eta) = second.transport.viscosity_at(&case.mesh, rate) else { return };
    // I^2/J (M. Trulsson, B. Andreotti, P. Claudin, Phys. Rev. Lett. 109 (2012) 118305).
    let stokes = g.rho_s * g.d * g.d * rate / eta;
    let mut text = format!("rhos d^2 rate/eta about {}", number(stokes));
    if let Some([_, mean, _]) = outlook.pressure.filter(|p| p[1] > 0.0) {
        text += &format!(", viscous number eta rate/P about {}", number(eta * rate / mean));
    }
    text += match stokes {
        s if s < 1.0 => " (viscous: the fluid between grains decides, and mu(I) does not know it)",
        s if s < 10.0 => " (fluid and grains both count)",
        _ => " (inertia of grains decides)",
    };
    page.say("Stokes number", text);
}

/// Grains that gravity drives along cyclic patches: their stress ratio is known.
fn slope(case: &Case, page: &mut Page) {
    let (Some(g), Some(mu)) = (&case.config.transport.grains, incline(case)) else { return };
    let text = format!("{} along the cyclic patches, from the direction of gravity", number(mu));
    page.say("stress ratio", text);
    if mu >= g.mu_2 {
        page.warn(format!(
            "that is beyond mu2 = {}: grains gain speed for ever on such a slope",
            number(g.mu_2)
        ));
    }
}

/// Driving over normal component of gravity, where grains alone run down a slope.
fn incline(case: &Case) -> Option<f64> {
    let (driving, normal) = (norm(case.gravity.driving), norm(case.gravity.hydrostatic));
    (driving > 0.0 && normal > 0.0).then(|| driving / normal)
}

/// Least and greatest shear rate, 1/s.
pub(super) fn rates(case: &Case, outlook: &Outlook) -> Option<[f64; 2]> {
    let g = case.config.transport.grains.as_ref()?;
    let mut ends: Vec<[f64; 2]> = outlook
        .drives
        .iter()
        .map(|d| [d.speed[0] / d.reach, d.speed[1] / (LAYER * g.d).min(d.reach)])
        .collect();
    if let Some(fall) = outlook.fall {
        // Over the height, and over a layer of grains.
        ends.push([fall / outlook.height, fall / (LAYER * g.d).min(outlook.height)]);
    }
    if let (true, Some(mu), Some([_, mean, _])) = (ends.is_empty(), incline(case), outlook.pressure)
        && mu > g.mu_s
        && mu < g.mu_2
        && mean > 0.0
    {
        let i = g.i0 * (mu - g.mu_s) / (g.mu_2 - mu);
        let rate = i * (mean / g.rho_s).sqrt() / g.d;
        ends.push([rate, rate]);
    }
    let all = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    ends.into_iter().reduce(all)
}

/// Least and greatest inertial number at the mean pressure.
pub(super) fn inertial(case: &Case, outlook: &Outlook) -> Option<[f64; 2]> {
    let g = case.config.transport.grains.as_ref()?;
    let [_, mean, _] = outlook.pressure.filter(|p| p[1] > 0.0)?;
    Some(rates(case, outlook)?.map(|rate| g.inertial_number(rate, mean)))
}
