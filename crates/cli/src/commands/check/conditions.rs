//! Which condition each patch has for each field, and what fixes the level of the pressure.

use super::outlook::Outlook;
use super::page::Page;
use crate::text::number;
use granflow_case::Case;
use granflow_case::config::ReferenceCell;
use granflow_dict::Dict;

pub(super) fn say(case: &Case, outlook: &Outlook, folder: &str, page: &mut Page) {
    page.open(&format!("Conditions ({folder})"));
    let start = &case.start;
    let mut fields: Vec<(&str, &[Dict])> =
        vec![("U", &start.u.boundary), (&start.p.name, &start.p.boundary)];
    if let Some(alpha) = &start.alpha {
        fields.push((&alpha.name, &alpha.boundary));
    }
    if case.config.transport.has_fluidity {
        fields.push(("fluidity", &start.fluidity.boundary));
    }
    let mut heading: Vec<String> = ["patch", "type", "faces"].map(str::to_owned).into();
    heading.extend(fields.iter().map(|f| f.0.to_owned()));
    let mut rows = vec![heading];
    for (i, patch) in case.poly.patches.iter().enumerate() {
        let mut row = vec![patch.name.clone(), patch.kind.word().to_owned(), patch.len.to_string()];
        row.extend(fields.iter().map(|f| f.1[i].word("type").unwrap_or("").to_owned()));
        rows.push(row);
    }
    page.table(&rows);
    for d in &outlook.drives {
        let [least, most] = d.speed.map(number);
        let speed = if least == most { most } else { format!("{least} to {most}") };
        page.say("speed", format!("{speed} m/s at patch {}", d.patch));
    }
    page.say("pressure level", level(case));
}

fn level(case: &Case) -> String {
    let given = case.config.solution.reference.as_ref();
    match (case.reference, given) {
        (None, None) => "fixed by the conditions of patches".to_owned(),
        (None, Some(_)) => {
            "fixed by the conditions of patches: pRefCell and pRefValue are not needed".to_owned()
        }
        (Some(_), Some(given)) => {
            let at = match given.cell {
                ReferenceCell::Cell(c) => format!("cell {c}"),
                ReferenceCell::Point(x) => {
                    let [x, y, z] = x.map(number);
                    format!("the cell at ({x} {y} {z}) m")
                }
            };
            format!("{} in {at} (pRefValue)", number(given.value))
        }
        (Some((cell, _)), None) => format!(
            "0 in cell {cell}, since no patch fixes it and fvSolution has no pRefCell and pRefValue"
        ),
    }
}
