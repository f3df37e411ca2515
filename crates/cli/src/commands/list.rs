//! `granflow list`: what can be written in a case, from the registries.

use crate::args::{List, Listing};
use crate::catalogue;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::wrap;
use granflow_physics::rheology;
use serde_json::{Map, Value};

/// One thing that can be written.
struct Item {
    name: String,
    /// What the name stands for where a list holds several kinds (solver, preconditioner).
    kind: Option<String>,
    summary: String,
    formula: Option<String>,
    reference: String,
    mapped_onto: Option<String>,
}

impl Item {
    fn new(name: &str, summary: &str, reference: &str) -> Item {
        Item {
            name: name.into(),
            kind: None,
            summary: summary.into(),
            formula: None,
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
        put("formula", self.formula.as_deref());
        put("mapped_onto", self.mapped_onto.as_deref());
        put("reference", Some(&self.reference));
        object
    }
}

const EVERYTHING: [Listing; 7] = [
    Listing::Rheologies,
    Listing::Conditions,
    Listing::Waves,
    Listing::Schemes,
    Listing::Solvers,
    Listing::Functions,
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
        for more in [item.formula.as_deref(), Some(item.reference.as_str())].into_iter().flatten() {
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
            .map(|e| Item {
                formula: Some(e.formula.into()),
                ..Item::new(e.name, e.summary, e.reference)
            })
            .collect(),
        Listing::Conditions => granflow_fv::conditions::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.reference))
            .collect(),
        Listing::Waves => granflow_fv::waves::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.reference))
            .collect(),
        Listing::Schemes => schemes(),
        Listing::Solvers => granflow_linsolve::ALL
            .iter()
            .map(|e| Item {
                kind: Some(e.kind.to_string()),
                mapped_onto: e.mapped_onto.map(Into::into),
                ..Item::new(e.name, e.summary, e.reference)
            })
            .collect(),
        Listing::Functions => granflow_case::functions::ALL
            .iter()
            .map(|e| Item::new(e.name, e.summary, e.reference))
            .collect(),
        Listing::Cases => {
            catalogue::ALL.iter().map(|c| Item::new(c.name, &c.summary(), &c.reference())).collect()
        }
    }
}

/// Kind, name, summary, reference. The limiters' names come from `fv`; a test keeps this table
/// complete.
const SCHEMES: &[(&str, &str, &str, &str)] = &[
    ("time", "Euler", "implicit, first order", HIRSCH),
    (
        "time",
        "backward",
        "differences over two steps, second order",
        "C. W. Gear, Numerical Initial Value Problems in Ordinary Differential Equations, 1971",
    ),
    (
        "time",
        "CrankNicolson",
        "trapezoidal rule, second order; `CrankNicolson 0.9` has a little of Euler in it, 0 is Euler",
        "J. Crank, P. Nicolson, Math. Proc. Camb. Phil. Soc. 43 (1947) 50",
    ),
    (
        "time",
        "localEuler",
        "Euler with a step of its own for every cell, towards a steady state: `maxCo`, `maxDeltaT`, \
         `rDeltaTSmoothingCoeff` of PIMPLE",
        HIRSCH,
    ),
    (
        "time",
        "bounded",
        "before another scheme: takes out the flux's divergence, which there is none of here",
        "book, Finite volumes",
    ),
    (
        "time",
        "steadyState",
        "none: a step finds the steady state of the conditions at its end",
        "book, Steady states",
    ),
    ("gradient", "Gauss", "Gauss's theorem with linear interpolation, `Gauss linear`", FERZIGER),
    ("gradient", "leastSquares", "least squares weighted with the distance", BARTH),
    (
        "gradient",
        "cellLimited",
        "before another scheme, with a number from 0 to 1: the whole gradient shrinks until it says \
         nothing at faces that neighbours do not have; for convection",
        BARTH,
    ),
    (
        "gradient",
        "cellMDLimited",
        "the same, and only its part along the way to the face shrinks",
        BARTH,
    ),
    ("gradient", "faceLimited", "cellLimited by the two cells of every face alone", BARTH),
    ("gradient", "faceMDLimited", "cellMDLimited by the two cells of every face alone", BARTH),
    ("convection", "upwind", "the upwind cell's value, first order, bounded", FERZIGER),
    ("convection", "linear", "central, second order, unbounded", FERZIGER),
    (
        "convection",
        "linearUpwind",
        "upwind with the upwind cell's gradient, second order",
        "R. F. Warming, R. M. Beam, AIAA J. 14 (1976) 1241",
    ),
    (
        "convection",
        "linearUpwindV",
        "linearUpwind, of a vector: along its own change and no further than central",
        "R. F. Warming, R. M. Beam, AIAA J. 14 (1976) 1241",
    ),
    (
        "convection",
        "cubic",
        "the cubic through values and gradients of both cells, unbounded",
        "Ch. Hermite, J. reine angew. Math. 84 (1878) 70",
    ),
    (
        "convection",
        "LUST",
        "three quarters central, one quarter linearUpwind",
        "H. Weller, Mon. Weather Rev. 140 (2012) 3220",
    ),
    ("convection", "blended", "a share of central, the rest upwind: `blended 0.8`", FERZIGER),
    (
        "convection",
        "fixedBlended",
        "two schemes in fixed shares: `fixedBlended 0.8 linear linearUpwind grad(U)`",
        FERZIGER,
    ),
    ("convection", "limitedLinear", "central limited towards upwind, `limitedLinear 1`", SWEBY),
    (
        "convection",
        "vanLeer",
        "van Leer's harmonic limiter",
        "B. van Leer, J. Comput. Phys. 14 (1974) 361",
    ),
    (
        "convection",
        "vanAlbada",
        "van Albada's smooth limiter",
        "G. D. van Albada, B. van Leer, W. W. Roberts, Astron. Astrophys. 108 (1982) 76",
    ),
    (
        "convection",
        "Minmod",
        "the most diffusive second-order limiter",
        "P. L. Roe, Annu. Rev. Fluid Mech. 18 (1986) 337",
    ),
    (
        "convection",
        "SuperBee",
        "the most compressive second-order limiter",
        "P. L. Roe, in Lectures in Applied Mathematics 22 (1985) 163",
    ),
    (
        "convection",
        "MUSCL",
        "van Leer's monotonised central limiter",
        "B. van Leer, J. Comput. Phys. 32 (1979) 101",
    ),
    (
        "convection",
        "QUICK",
        "quadratic upwind, limited",
        "B. P. Leonard, Comput. Methods Appl. Mech. Eng. 19 (1979) 59",
    ),
    (
        "convection",
        "OSPRE",
        "a smooth limiter",
        "N. P. Waterson, H. Deconinck, 9th Int. Conf. Numer. Meth. Laminar Turbul. Flow (1995)",
    ),
    (
        "convection",
        "UMIST",
        "QUICK's symmetric bounded relative",
        "F. S. Lien, M. A. Leschziner, Int. J. Numer. Meth. Fluids 19 (1994) 527",
    ),
    (
        "convection",
        "Gamma",
        "central, blended into upwind where it would overshoot: `Gamma 1`",
        "H. Jasak, H. G. Weller, A. D. Gosman, Int. J. Numer. Meth. Fluids 31 (1999) 431",
    ),
    ("correction", "corrected", "full non-orthogonal correction of the normal gradient", JASAK),
    (
        "correction",
        "limited",
        "the correction up to a multiple of the cells' difference, `limited 0.5` or `limited corrected 0.5`",
        JASAK,
    ),
    ("correction", "uncorrected", "no non-orthogonal correction", JASAK),
    (
        "correction",
        "orthogonal",
        "the difference over the distance of the centres; as a Laplacian it is `uncorrected`",
        JASAK,
    ),
];
const HIRSCH: &str = "C. Hirsch, Numerical Computation of Internal and External Flows, 1988";
const FERZIGER: &str = "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4";
const BARTH: &str = "T. J. Barth, D. C. Jespersen, AIAA 89-0366 (1989)";
const SWEBY: &str = "P. K. Sweby, SIAM J. Numer. Anal. 21 (1984) 995";
const JASAK: &str = "H. Jasak, PhD thesis, Imperial College 1996, ch. 3.3";

fn schemes() -> Vec<Item> {
    let one = |(kind, name, summary, reference): &(&str, &str, &str, &str)| Item {
        kind: Some((*kind).into()),
        ..Item::new(name, summary, reference)
    };
    SCHEMES.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_fv::LimiterKind;

    #[test]
    fn every_convection_scheme_is_listed_and_nothing_else() {
        let mut listed: Vec<&str> =
            SCHEMES.iter().filter(|s| s.0 == "convection").map(|s| s.1).collect();
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
                assert!(!i.name.contains(['/', '\\', ' ']), "{}", i.name);
                assert!(!i.summary.ends_with('.') && !i.reference.ends_with('.'), "{}", i.name);
            }
        }
    }
}
