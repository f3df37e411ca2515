//! `granflow list`: what can be written in a case, from the registries.

use super::schemes;
use crate::args::{List, Listing};
use crate::catalogue;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::wrap;
use granflow_physics::rheology;
use serde_json::{Map, Value, json};

/// One thing that can be written.
struct Item {
    name: String,
    /// What the name stands for where a list holds several kinds (solver, preconditioner).
    kind: Option<String>,
    summary: String,
    formula: String,
    /// Entries beside the name, each with its meaning and unit.
    keys: &'static [(&'static str, &'static str)],
    reference: String,
    mapped_onto: Option<String>,
}

impl Item {
    fn new(name: &str, summary: &str, formula: &str, reference: &str) -> Item {
        Item {
            name: name.into(),
            kind: None,
            summary: summary.into(),
            formula: formula.into(),
            keys: &[],
            reference: reference.into(),
            mapped_onto: None,
        }
    }
    fn json(&self) -> Map<String, Value> {
        let mut object = Map::new();
        let mut put = |key: &str, value: Option<&str>| {
            if let Some(v) = value {
                object.insert(key.to_owned(), v.into());
            }
        };
        put("name", Some(&self.name));
        put("kind", self.kind.as_deref());
        put("summary", Some(&self.summary));
        put("formula", Some(self.formula.as_str()).filter(|f| !f.is_empty()));
        put("mapped_onto", self.mapped_onto.as_deref());
        put("reference", Some(&self.reference));
        if !self.keys.is_empty() {
            let keys = self.keys.iter().map(|(key, meaning)| json!([key, meaning]));
            object.insert("keys".to_owned(), keys.collect());
        }
        object
    }
}

const EVERYTHING: [Listing; 8] = [
    Listing::Rheologies,
    Listing::Conditions,
    Listing::Waves,
    Listing::Schemes,
    Listing::Solvers,
    Listing::Functions,
    Listing::Sources,
    Listing::Cases,
];

/// Where the words go.
fn title(what: Listing) -> (&'static str, &'static str) {
    match what {
        Listing::Rheologies => ("rheologies", "transportModel in constant/transportProperties"),
        Listing::Conditions => ("conditions", "type of a patch in a field file"),
        Listing::Waves => ("waves", "waveModel of a patch in constant/waveProperties"),
        Listing::Schemes => ("schemes", "words of system/fvSchemes"),
        Listing::Solvers => ("solvers", "solver, preconditioner, smoother in system/fvSolution"),
        Listing::Functions => ("functions", "type of a function in system/controlDict"),
        Listing::Sources => ("sources", "type of a force in constant/fvOptions"),
        Listing::Cases => ("cases", "built in: granflow new NAME"),
    }
}

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &List) -> Result<(), Failure> {
    let which = args.what.map_or(EVERYTHING.to_vec(), |w| vec![w]);
    if args.json {
        let mut all = Vec::new();
        for what in &which {
            for item in items(*what) {
                let mut object = item.json();
                if args.what.is_none() {
                    object.insert("list".into(), title(*what).0.into());
                }
                all.push(Value::Object(object));
            }
        }
        session.out.print(&format!("{:#}", Value::Array(all)));
        return Ok(());
    }
    for (i, what) in which.iter().enumerate() {
        if i > 0 {
            session.out.print("");
        }
        let (name, place) = title(*what);
        session.out.print(&format!("{name} ({place})"));
        print(session, &items(*what));
    }
    Ok(())
}

fn print(session: &mut Session, items: &[Item]) {
    if items.is_empty() {
        session.out.print("  none");
    }
    let width = items.iter().map(|i| i.name.len()).max().unwrap_or(0);
    let mut kind = None;
    for item in items {
        if item.kind != kind {
            kind.clone_from(&item.kind);
            session.out.print(&format!(" {}", kind.as_deref().unwrap_or("")));
        }
        let room = 96_usize.saturating_sub(width + 4).max(30);
        let mut body = wrap(&item.summary, width + 4, room);
        for more in [&item.formula, &item.reference].into_iter().filter(|t| !t.is_empty()) {
            body += "\n";
            body += &wrap(more, width + 6, room - 2);
        }
        let first = body.get(width + 4..).unwrap_or("");
        session.out.print(&format!("  {:width$}  {first}", item.name));
    }
}

fn items(what: Listing) -> Vec<Item> {
    match what {
        Listing::Rheologies => rheology::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.formula, e.reference))
            .collect(),
        Listing::Conditions => granflow_fv::conditions::ALL
            .iter()
            .map(|e| Item { keys: e.keys, ..Item::new(e.name, e.summary, e.formula, e.reference) })
            .collect(),
        Listing::Waves => granflow_fv::waves::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.formula, e.reference))
            .collect(),
        Listing::Schemes => schemes::ALL
            .iter()
            .map(|e| Item {
                kind: Some(e.kind.into()),
                ..Item::new(e.name, e.summary, e.formula, e.reference)
            })
            .collect(),
        Listing::Sources => granflow_flow::sources::ALL
            .iter()
            .map(|e| Item::new(e.names[0], e.summary, e.formula, e.reference))
            .collect(),
        Listing::Solvers => granflow_linsolve::ALL
            .iter()
            .map(|e| Item {
                kind: Some(e.kind.to_string()),
                mapped_onto: e.mapped_onto.map(Into::into),
                ..Item::new(e.name, e.summary, e.formula, e.reference)
            })
            .collect(),
        Listing::Functions => granflow_case::functions::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.formula, e.reference))
            .collect(),
        Listing::Cases => catalogue::ALL
            .iter()
            .map(|c| Item::new(c.name, &c.summary(), "", &c.reference()))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_fv::LimiterKind;

    #[test]
    fn every_convection_scheme_is_listed_and_nothing_else() {
        let mut listed: Vec<&str> =
            schemes::ALL.iter().filter(|s| s.kind == "convection").map(|s| s.name).collect();
        let mut known = granflow_case::config::PLAIN.to_vec();
        known.extend(LimiterKind::NAMES);
        listed.sort_unstable();
        known.sort_unstable();
        assert_eq!(listed, known);
    }

    #[test]
    fn every_item_has_a_summary_and_a_reference_and_a_name_for_a_page() {
        for what in EVERYTHING {
            let items = items(what);
            assert!(!items.is_empty() || what == Listing::Cases, "{what:?}");
            for i in items {
                assert!(!i.summary.is_empty() && !i.reference.is_empty(), "{}", i.name);
                assert!(!i.formula.is_empty() || what == Listing::Cases, "{}", i.name);
                assert!(!i.name.contains(['/', '\\', ' ']), "{}", i.name);
                assert!(!i.summary.ends_with('.') && !i.reference.ends_with('.'), "{}", i.name);
            }
        }
    }
}
