//! How fine the mesh is against what is to be resolved.

use super::outlook::Outlook;
use super::page::Page;
use super::regime;
use crate::text::number;
use granflow_base::Vec3;
use granflow_case::Case;

pub(super) fn say(case: &Case, outlook: &Outlook, page: &mut Page) {
    page.open("Resolution");
    let [finest, coarsest] = outlook.spacing;
    let text = if coarsest - finest <= 1e-6 * coarsest {
        format!("{} m everywhere", number(coarsest))
    } else {
        format!("{} to {} m", number(finest), number(coarsest))
    };
    page.say("cell spacing", text);
    let Some(grains) = &case.config.transport.grains else {
        for d in &outlook.drives {
            let across = d.reach / d.width;
            let text = format!("{} from patch {} across the mesh", number(across), d.patch);
            page.say("cells", text);
            if across < 10.0 {
                page.warn(format!(
                    "a boundary layer at {} has few cells: refine towards it",
                    d.patch
                ));
            }
        }
        return;
    };
    let [lo, hi] = extent(case);
    let widest = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
    if grains.d > 0.2 * widest {
        page.warn(format!(
            "a grain of {} m in a mesh of {} m: is d in metres, and so is the mesh (`scale`)?",
            number(grains.d),
            number(widest)
        ));
    }
    let each = |h: f64| number(grains.d / h);
    let among =
        |[a, b]: [f64; 2]| format!("{} at the finest, {} at the coarsest", each(a), each(b));
    page.say("cells a grain", among(outlook.spacing));
    for (cells, place) in
        [(outlook.in_grains, "among grains"), (outlook.at_surface, "across their surface")]
    {
        if let Some(ends) = cells {
            page.say("", format!("{} {place}", among(ends)));
        }
    }
    for d in &outlook.drives {
        let cells = grains.d / d.width;
        page.say("", format!("{} at patch {}", number(cells), d.patch));
        if cells < 2.0 {
            page.warn(format!(
                "the shear at {} decays over a few grains: 2 cells a grain resolve it to about a \
                 percent, 4 to 4e-4",
                d.patch
            ));
        }
    }
    cooperativity(case, outlook, page);
}

/// Smallest and largest coordinates of the mesh, m.
fn extent(case: &Case) -> [Vec3; 2] {
    let ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    case.poly.points.iter().fold(ends, |[lo, hi], x| {
        [0, 1]
            .map(|end| [0, 1, 2].map(|k| if end == 0 { lo[k].min(x[k]) } else { hi[k].max(x[k]) }))
    })
}

/// xi at stress ratios that are to be expected, against the cells.
fn cooperativity(case: &Case, outlook: &Outlook, page: &mut Page) {
    let transport = &case.config.transport;
    let (Some(g), Some(at_rest)) = (&transport.grains, transport.cooperativity) else { return };
    // xi = A d sqrt((mu2 - mu)/((mu2 - mus) |mu - mus|)); what is known is that at mu = 0.
    let range = g.mu_2 - g.mu_s;
    let length = at_rest / (g.mu_2 / (range * g.mu_s)).sqrt();
    let xi = |mu: f64| length * ((g.mu_2 - mu) / (range * (mu - g.mu_s).abs())).sqrt();
    let mut ratios = vec![("mu = 0".to_owned(), at_rest)];
    for share in [0.9, 1.1] {
        let mu = share * g.mu_s;
        if mu < g.mu_2 {
            ratios.push((format!("mu = {} ({share} mus)", number(mu)), xi(mu)));
        }
    }
    if let Some([_, most]) = regime::inertial(case, outlook).filter(|i| i[1] > 0.0) {
        let mu = g.mu_s + range / (g.i0 / most + 1.0);
        ratios.push((format!("I = {}, mu = {}", number(most), number(mu)), xi(mu)));
    }
    let coarsest = outlook.in_grains.unwrap_or(outlook.spacing)[1];
    let mut rows = vec![["xi at", "grains", "cells at the coarsest"].map(str::to_owned).to_vec()];
    for (what, xi) in &ratios {
        rows.push(vec![what.clone(), number(xi / g.d), number(xi / coarsest)]);
    }
    page.table(&rows);
    let least = ratios.iter().map(|r| r.1).fold(f64::INFINITY, f64::min) / coarsest;
    page.say(
        "xi",
        match least < 2.0 {
            true => "not resolved everywhere: less than 2 cells",
            false => "resolved: 2 cells or more",
        },
    );
}
