//! `constant/fvOptions` (or `system/fvOptions`): forces on the bulk beside gravity.
//!
//! Done are `vectorSemiImplicitSource`, `explicitPorositySource` with `DarcyForchheimer`, and
//! `meanVelocityForce`; the others are refused by name. In a case with one fluid the forces are per
//! density, as OpenFOAM's solvers for one fluid have them; with two they are forces.

use crate::{CaseError, Zones, files};
use granflow_base::{Dims, Vec3, cross, dot, norm, scale, sub, unit};
use granflow_dict::{Reader, Severity, Sink, nearest};
use granflow_flow::{MeanVelocity, Porous, SemiImplicit, Source, Zone};
use granflow_mesh::Mesh;
use std::path::Path;

/// Where the dictionary may be.
const FILES: [&str; 2] = ["constant/fvOptions", "system/fvOptions"];

/// A force on the bulk.
pub struct SourceEntry {
    /// The word behind `type`.
    pub name: &'static str,
    /// One line for lists and the book.
    pub summary: &'static str,
    /// The force per volume (per density of it with one fluid), `U` the velocity.
    pub formula: &'static str,
    /// Where it comes from.
    pub reference: &'static str,
    read: fn(&Of<'_, '_>, &mut Vec<Source>),
}

/// Every kind, by OpenFOAM's names.
pub const SOURCES: &[SourceEntry] = &[
    SourceEntry {
        name: "vectorSemiImplicitSource",
        summary: "a given force and a drag, in all cells or in a zone, perhaps for a time",
        formula: "f = S + k U, k <= 0, of `U (S k);` in injectionRateSuSp; over the volume of the zone \
                  with volumeMode absolute",
        reference: "OpenFOAM user guide, fvOptions",
        read: |of, all| of.semi_implicit(all),
    },
    SourceEntry {
        name: "explicitPorositySource",
        summary: "a porous body: the drag of Darcy and Forchheimer along three axes",
        formula: "f = -(eta d + rho |U|/2 f) . U, d and f along the axes of coordinateSystem",
        reference: "P. Forchheimer, Z. Ver. Dtsch. Ing. 45 (1901) 1782",
        read: |of, all| of.porous(all),
    },
    SourceEntry {
        name: "meanVelocityForce",
        summary: "the uniform force that keeps the mean velocity over a zone at Ubar",
        formula: "f = g Ubar/|Ubar|, g such that sum U V . Ubar/|Ubar| = |Ubar| sum V",
        reference: "OpenFOAM user guide, fvOptions",
        read: |of, all| of.mean_velocity(all),
    },
];
/// Another name of the first.
const ALIAS: (&str, &str) = ("semiImplicitSource", "vectorSemiImplicitSource");

/// Whether the case has such a file.
pub(crate) fn present(root: &Path) -> bool {
    FILES.iter().any(|file| files::exists(root, file))
}

/// Reads the sources of a case, their zones in the user's numbering. `rho` is the density that
/// accelerations are multiplied with to make forces, 1 where forces are given, `two` whether there are two phases. Mistakes go to the sink.
///
/// # Errors
/// A file is there and cannot be read.
pub(crate) fn read(
    root: &Path,
    mesh: &Mesh,
    zones: &Zones,
    (rho, two): (f64, bool),
    sink: &Sink,
) -> Result<Vec<Source>, CaseError> {
    let mut sources = Vec::new();
    let mut found = None;
    for file in FILES {
        // The first that is there, as OpenFOAM has it.
        found = files::dict(root, file, sink)?;
        if found.is_some() {
            break;
        }
    }
    if let Some(dict) = found {
        let all = Reader::new(&dict, sink);
        all.ignore("FoamFile");
        for (name, r) in all.subs() {
            if name == "FoamFile" {
                continue;
            }
            if !r.opt_switch("active", true) {
                r.ignore_all();
                continue;
            }
            let kind = r.word("type").to_owned();
            // Entries stand beside the type, or in a dictionary of their own.
            let inner = r.opt_sub(&format!("{kind}Coeffs"));
            let of = Of { name, r: inner.as_ref().unwrap_or(&r), outer: &r, mesh, zones, rho, two };
            let known = if kind == ALIAS.0 { ALIAS.1 } else { kind.as_str() };
            match SOURCES.iter().find(|e| e.name == known) {
                Some(entry) => (entry.read)(&of, &mut sources),
                None if kind.is_empty() => {}
                None => {
                    let kinds: Vec<&str> = SOURCES.iter().map(|e| e.name).collect();
                    let near = nearest(&kind, kinds.iter().copied());
                    let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
                    let help = format!("{near}there are {}; or add `active no;`", kinds.join(", "));
                    let message = format!("the source `{kind}` is not done here");
                    r.error_at_key("type", message, "not available", Some(&help));
                    r.ignore_all();
                    if let Some(inner) = &inner {
                        inner.ignore_all();
                    }
                }
            }
            for key in ["selectionMode", "cellZone", "cellSet", "fields"] {
                r.ignore(key);
            }
            if let Some(inner) = &inner {
                inner.finish(Severity::Error);
            }
            r.finish(Severity::Error);
        }
        all.finish(Severity::Warning);
    }
    Ok(sources)
}

/// One entry and what it refers to.
struct Of<'r, 'd> {
    name: &'r str,
    r: &'r Reader<'d>,
    outer: &'r Reader<'d>,
    mesh: &'r Mesh,
    zones: &'r Zones,
    rho: f64,
    /// Whether there are two phases.
    two: bool,
}

impl<'d> Of<'_, 'd> {
    /// The reader that has `key`.
    fn with(&self, key: &str) -> &Reader<'d> {
        if self.r.has(key) { self.r } else { self.outer }
    }

    /// `selectionMode`.
    fn zone(&self) -> Zone {
        let r = self.with("selectionMode");
        let modes = [("all", 0), ("cellZone", 1), ("cellSet", 2), ("points", 3)];
        let key = match r.one_of("selectionMode", &modes) {
            0 => return Zone::All,
            1 => "cellZone",
            2 => "cellSet",
            _ => {
                let help = Some("write `cellZone` and make one with system/topoSetDict");
                r.error_at_key("selectionMode", "`points` is not done here", "set here", help);
                return Zone::All;
            }
        };
        let r = self.with(key);
        let name = r.word(key).to_owned();
        let known = self.zones.get(&name).is_some();
        let cells = self.zones.expect(r, key, &name).to_vec();
        if known && cells.is_empty() {
            let help = Some("no centre of a cell lies within it: look at system/topoSetDict");
            r.error_at_key(key, format!("the zone `{name}` has no cells"), "empty", help);
        }
        Zone::Cells(cells)
    }

    /// `timeStart` and `duration`: first and last time.
    fn window(&self) -> [f64; 2] {
        let start = self.with("timeStart").maybe_scalar("timeStart", Dims::TIME);
        let lasts = self.with("duration").maybe_scalar("duration", Dims::TIME);
        match start {
            None => [f64::NEG_INFINITY, f64::INFINITY],
            Some(start) => [start, start + lasts.unwrap_or(f64::INFINITY)],
        }
    }

    /// Refuses a window where the source acts all the time.
    fn always(&self) {
        for key in ["timeStart", "duration"] {
            let r = self.with(key);
            if r.has(key) {
                let help = Some("remove it, or run the times before without the source");
                r.error_at_key(key, "this source acts all the time", "not available", help);
            }
        }
    }

    /// Volume of the zone, m3.
    fn volume(&self, zone: &Zone) -> f64 {
        let volume = &self.mesh.volume;
        match zone {
            Zone::All => volume[..self.mesh.n_cells].iter().sum(),
            Zone::Cells(cells) => {
                let mut here = vec![false; self.mesh.n_cells];
                cells.iter().for_each(|c| here[*c as usize] = true);
                let of = |c: usize| here[self.mesh.global_cell[c] as usize];
                (0..self.mesh.n_cells).filter(|c| of(*c)).map(|c| volume[c]).sum()
            }
        }
    }

    fn semi_implicit(&self, sources: &mut Vec<Source>) {
        let (r, zone) = (self.r, self.zone());
        let window = self.window();
        let absolute = r.one_of("volumeMode", &[("specific", false), ("absolute", true)]);
        let per = self.rho / if absolute { self.volume(&zone) } else { 1.0 };
        let Some(rates) = r.sub("injectionRateSuSp") else { return };
        if rates.keys().is_empty() {
            let help = Some("write `U ((x y z) 0);` in it");
            r.error_at_key("injectionRateSuSp", "no force is given", "empty", help);
        }
        for key in rates.keys() {
            let Some(mut t) = rates.tokens(key) else { continue };
            if key != "U" {
                let help = Some("forces act on `U`");
                rates.error_at_key(
                    key,
                    format!("there is no equation of `{key}`"),
                    "not known",
                    help,
                );
                continue;
            }
            let Some(mut pair) = t.list("force and drag, `((x y z) 0)`") else { continue };
            let force = scale(pair.vector("the force"), per);
            // OpenFOAM's rate of the implicit part is that of growth.
            let drag = -pair.number("the rate of the implicit part") * per;
            pair.finish();
            if drag < 0.0 {
                let help = Some("a drag is negative: `((x y z) -5)`");
                rates.error_at_key(key, "a force that grows with the velocity", "positive", help);
            }
            sources.push(Source::SemiImplicit(SemiImplicit {
                zone: zone.clone(),
                force,
                drag,
                window,
            }));
        }
    }

    fn porous(&self, sources: &mut Vec<Source>) {
        let zone = self.zone();
        self.always();
        let r = self.r;
        let model = if r.has("type") { r.word("type") } else { "DarcyForchheimer" };
        if !matches!(model, "DarcyForchheimer" | "explicitPorositySource") {
            let help = Some("there is `DarcyForchheimer`");
            let message = format!("the porous body `{model}` is not done here");
            r.error_at_key("type", message, "not available", help);
            r.ignore_all();
            return;
        }
        let inner = r.opt_sub("DarcyForchheimerCoeffs");
        let of = inner.as_ref().unwrap_or(r);
        let darcy = positive(of.vector("d", Dims::LENGTH.mul(Dims::LENGTH).inv()));
        let forchheimer = positive(of.vector("f", Dims::LENGTH.inv()));
        for key in ["mu", "rho", "nu", "U"] {
            of.ignore(key);
        }
        let axes = axes(of);
        if let Some(inner) = &inner {
            inner.finish(Severity::Error);
        }
        sources.push(Source::Porous(Porous { zone, darcy, forchheimer, axes }));
    }

    fn mean_velocity(&self, sources: &mut Vec<Source>) {
        let (r, zone) = (self.r, self.zone());
        self.always();
        for key in ["fields", "fieldNames"] {
            r.ignore(key);
        }
        let mean = r.vector("Ubar", Dims::VELOCITY);
        if norm(mean) == 0.0 || !norm(mean).is_finite() {
            let message = "the mean velocity has no direction";
            r.error_at_key(
                "Ubar",
                message,
                "zero, or beyond numbers",
                Some("leave the source out"),
            );
        }
        if (0..3).any(|k| mean[k] != 0.0 && !self.mesh.solved_dirs[k]) {
            let message = "the mean velocity points where the mesh has no cells side by side";
            r.error_at_key("Ubar", message, "out of the plane", None);
        }
        if self.two {
            let message = "a held mean velocity is for one fluid";
            let help = Some("give the force: `vectorSemiImplicitSource`");
            self.outer.error_at_key("type", message, "two phases", help);
        }
        let relaxation = r.opt_in_range("relaxation", Dims::NONE, 1e-3..=1.0, 1.0);
        sources.push(Source::MeanVelocity(MeanVelocity {
            name: self.name.to_owned(),
            zone,
            direction: unit(mean),
            mean: norm(mean),
            relaxation,
            gradient: 0.0,
            start: 0.0,
            last: None,
            response: None,
        }));
    }
}

/// A negative coefficient is that many times the greatest.
fn positive(v: Vec3) -> Vec3 {
    let most = v.iter().copied().fold(0.0, f64::max);
    v.map(|x| if x < 0.0 { -x * most } else { x })
}

/// The axes of space.
const SPACE: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Origin and axes that stand in `coordinateSystem` or beside it.
pub(crate) fn axes_of(r: &Reader<'_>) -> (Vec3, [Vec3; 3]) {
    let origin = r.maybe_vector("origin", Dims::LENGTH);
    if let Some(system) = r.opt_sub("coordinateSystem") {
        let inner = system.maybe_vector("origin", Dims::LENGTH);
        return (origin.or(inner).unwrap_or_default(), axes(r));
    }
    let turned = ["rotation", "coordinateRotation"].iter().any(|k| r.has(k));
    (origin.unwrap_or_default(), if turned { rotated(r, r) } else { SPACE })
}

/// The axes of `coordinateSystem`, or those of space.
fn axes(r: &Reader<'_>) -> [Vec3; 3] {
    let Some(system) = r.opt_sub("coordinateSystem") else { return SPACE };
    for key in ["type", "origin"] {
        system.ignore(key);
    }
    let found = rotated(r, &system);
    system.ignore_all();
    found
}

/// The axes `e1` and `e2` (or `e3`) of `system`, perhaps in `rotation`; what is wrong is said of `r`.
fn rotated(r: &Reader<'_>, system: &Reader<'_>) -> [Vec3; 3] {
    let own = SPACE;
    let turned = system.opt_sub("rotation").or_else(|| {
        system.entry("coordinateRotation").and_then(|_| system.opt_sub("coordinateRotation"))
    });
    let of = turned.as_ref().unwrap_or(system);
    let kind = of.opt_word("type", "axes");
    let (e1, e2, e3) = (
        of.maybe_vector("e1", Dims::NONE),
        of.maybe_vector("e2", Dims::NONE),
        of.maybe_vector("e3", Dims::NONE),
    );
    let found = match (e1, e2, e3) {
        _ if kind == "none" => Some(own),
        (None, None, None) if kind == "axes" => Some(own),
        (Some(a), Some(b), _) => right_handed(a, b),
        (None, Some(b), Some(c)) => right_handed(b, c).map(|[b, c, a]| [a, b, c]),
        (Some(a), None, Some(c)) => right_handed(c, a).map(|[c, a, b]| [a, b, c]),
        _ => None,
    };
    if let Some(turned) = &turned {
        turned.ignore_all();
    }
    found.unwrap_or_else(|| {
        let help = Some(
            "give two of them: `coordinateSystem { origin (0 0 0); e1 (1 0 0); e2 (0 1 0); }`",
        );
        r.error_at_key("coordinateSystem", "the axes are not given", "needs two axes", help);
        own
    })
}

/// Unit vectors along `a`, along `b` as far as it is perpendicular to `a`, and along `a x b`.
fn right_handed(a: Vec3, b: Vec3) -> Option<[Vec3; 3]> {
    let a = unit(a);
    let b = sub(b, scale(a, dot(a, b)));
    (norm(a) > 0.0 && norm(b) > 0.0).then(|| [a, unit(b), cross(a, unit(b))])
}
