//! `system/fvSolution`: linear solvers, corrections, outer iterations, pressure reference.
//!
//! Defaults where entries or the file are missing:
//!
//! | | viscosity that varies | Newtonian |
//! |---|---|---|
//! | nOuterCorrectors | 150 | 1 (PISO) |
//! | nCorrectors | 1 | 2 |
//! | solver of U | GAMG, relTol 1e-3 | PBiCGStab with DILU, 1e-10 |
//! | solver of p | GAMG, relTol 1e-3 | GAMG, 1e-10 |
//! | solver of fluidity | PBiCGStab with DILU, 1e-10, relTol 1e-2 (its Jacobian may be indefinite) | |
//! | residualControl U, p | 1e-8 | 1e-8 |
//! | residualControl viscosity | 1e-7 (steadyState: 1e-8) | |
//! | residualControl fluidity | 1e-10 (steadyState: 1e-12) | |
//!
//! `ddtSchemes steadyState` takes 150 outer iterations of either, and reads SIMPLE first.
//! With more than one outer iteration, and for granular models always, momentum and continuity are
//! solved together: the solvers of U and p precondition, to an accuracy that is fixed, and their
//! tolerances, nCorrectors, nNonOrthogonalCorrectors and momentumPredictor have no effect.

use crate::Notices;
use granflow_base::{Dims, Vec3};
use granflow_dict::{Dict, Reader, Severity, Sink, Span, Value, nearest};
use granflow_flow::{LocalSteps, ResidualControl};
use granflow_linsolve::{ALL, SolverSpec, Tolerance, build};

/// A linear solver with its tolerances.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSolve {
    /// Which solver.
    pub spec: SolverSpec,
    /// Tolerance of inner corrections.
    pub tolerance: Tolerance,
    /// Tolerance of the last correction (`pFinal`).
    pub last: Tolerance,
}

/// Where the pressure level is fixed.
#[derive(Clone, Debug)]
pub enum ReferenceCell {
    /// `pRefCell`, in the user's numbering.
    Cell(usize),
    /// The cell around or nearest to `pRefPoint`, m.
    Point(Vec3),
}

/// `pRefCell` or `pRefPoint` with `pRefValue`.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Where.
    pub cell: ReferenceCell,
    /// The pressure there, in the units of the pressure file.
    pub value: f64,
    /// Where it was written.
    pub span: Span,
}

/// What `fvSolution` says.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Momentum.
    pub u: LinearSolve,
    /// Pressure.
    pub p: LinearSolve,
    /// The fluidity equation.
    pub fluidity: LinearSolve,
    /// Most outer iterations of a step.
    pub outer: usize,
    /// Pressure corrections of a single pass (PISO).
    pub correctors: usize,
    /// Repetitions of a correction for non-orthogonality.
    pub non_orthogonal_correctors: usize,
    /// Whether velocity and pressure stay as they are (`frozenFlow`).
    pub frozen: bool,
    /// Whether momentum is solved before the pressure.
    pub predictor: bool,
    /// When outer iterations stop.
    pub control: ResidualControl,
    /// When the Newton iterations of the fluidity stop.
    pub newton: f64,
    /// How long the steps of cells are where each has its own.
    pub local: LocalSteps,
    /// The pressure level where no boundary fixes it.
    pub reference: Option<Reference>,
}

/// Entries that choose details of OpenFOAM's own solvers.
const DETAILS: &[&str] = &[
    "agglomerator",
    "nCellsInCoarsestLevel",
    "mergeLevels",
    "cacheAgglomeration",
    "nPreSweeps",
    "nPostSweeps",
    "nFinestSweeps",
    "nSweeps",
    "directSolveCoarsest",
    "scaleCorrection",
    "interpolateCorrection",
    "processorAgglomerator",
    "coarsestLevelCorr",
    "nVcycles",
    "minIter",
    "log",
];

/// Unknowns that other solvers have and their cases may carry along.
const OTHERS: &[&str] = &[
    "pcorr",
    "pcorrFinal",
    "Phi",
    "k",
    "epsilon",
    "omega",
    "nuTilda",
    "T",
    "h",
    "e",
    "cellDisplacement",
];

/// What decides defaults.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind {
    /// Whether the viscosity follows the flow.
    pub(super) varies: bool,
    /// Whether the fluid is made of grains.
    pub(super) granular: bool,
    /// Whether a steady state is looked for.
    pub(super) steady: bool,
    /// Whether every cell has a step of its own.
    pub(super) local: bool,
}

/// When a steady state is found.
const STEADY: ResidualControl = ResidualControl { u: 1e-8, p: 1e-8, viscosity: 1e-8 };

impl Solution {
    /// Reads the dictionary (empty when the file is missing); mistakes go to the sink.
    pub(super) fn read(
        dict: &Dict,
        application: &str,
        pressure: &str,
        kind: Kind,
        sink: &Sink,
        notices: &Notices,
    ) -> Solution {
        let Kind { varies, steady, .. } = kind;
        let r = Reader::new(dict, sink);
        let default_u = if varies || steady { ("GAMG", None) } else { ("PBiCGStab", Some("DILU")) };
        let (mut u, mut p, mut fluidity) = (
            LinearSolve::default_of(default_u, 1e-10),
            LinearSolve::default_of(("GAMG", None), 1e-10),
            LinearSolve::default_of(("PBiCGStab", Some("DILU")), 1e-10),
        );
        // Newton's method needs no more of a step than that.
        fluidity.tolerance.rel = 1e-2;
        if varies {
            for t in [&mut u.tolerance, &mut u.last, &mut p.tolerance, &mut p.last] {
                *t = Tolerance { abs: 1e-12, rel: 1e-3, ..*t };
            }
        }
        if let Some(solvers) = r.opt_sub("solvers") {
            u = LinearSolve::read(&solvers, "U", u, notices);
            let name = if solvers.has(pressure) { pressure } else { "p" };
            p = LinearSolve::read(&solvers, name, p, notices);
            p.precondition_with_multigrid(name, notices);
            if steady && !varies && u.spec.solver != "GAMG" {
                notices.say(format!(
                    "fvSolution: `{}` for `U` is served by `GAMG`: without inertia the others take many \
                     iterations",
                    u.spec.solver
                ));
                u.spec = LinearSolve::default_of(("GAMG", None), 1e-10).spec;
            }
            let default = fluidity.clone();
            fluidity = LinearSolve::read(&solvers, "fluidity", fluidity, notices);
            if matches!(fluidity.spec.solver.as_str(), "PCG" | "GAMG") {
                notices.say(format!(
                    "fvSolution: {} needs a symmetric positive matrix, which the fluidity's is not: \
                     PBiCGStab with DILU takes its place",
                    fluidity.spec.solver
                ));
                fluidity.spec = default.spec;
            }
            for other in OTHERS {
                solvers.ignore(other);
            }
            // Patterns as well: `"alpha.water.*"`.
            let keys = solvers.dict().entries.iter().map(|e| e.key.text());
            for key in keys.filter(|k| k.trim_start_matches('(').starts_with("alpha")) {
                solvers.ignore(key);
            }
            for other in ["p", "pFinal", "p_rgh", "p_rghFinal"] {
                solvers.ignore(other);
            }
        }
        let mut out = Solution {
            u,
            p,
            fluidity,
            outer: if varies || steady { 150 } else { 1 },
            correctors: if varies { 1 } else { 2 },
            non_orthogonal_correctors: 0,
            frozen: false,
            predictor: true,
            control: if steady { STEADY } else { ResidualControl::default() },
            newton: if steady { 1e-12 } else { 1e-10 },
            local: super::schemes::LOCAL,
            reference: None,
        };
        let order: [&str; 3] = match application {
            _ if steady => ["SIMPLE", "PIMPLE", "PISO"],
            "icoFoam" | "pisoFoam" | "nonNewtonianIcoFoam" => ["PISO", "PIMPLE", "SIMPLE"],
            _ => ["PIMPLE", "PISO", "SIMPLE"],
        };
        let chosen = order.into_iter().find(|k| r.has(k));
        for name in order {
            if Some(name) == chosen {
                if let Some(sub) = r.opt_sub(name) {
                    out.algorithm(&sub, name, pressure, kind);
                }
            } else if let Some(sub) = r.entry(name).and_then(|_| r.opt_sub(name)) {
                sub.ignore_all();
            }
        }
        if let Some(relax) =
            r.entry("relaxationFactors").and_then(|_| r.opt_sub("relaxationFactors"))
        {
            relax.ignore_all();
            if !relax.keys().is_empty() {
                notices.say("fvSolution: relaxationFactors are not used: no relaxation is needed");
            }
        }
        if let Some(sub) = r.entry("potentialFlow").and_then(|_| r.opt_sub("potentialFlow")) {
            sub.ignore_all();
        }
        r.ignore("cache");
        r.finish(Severity::Warning);
        out
    }

    fn algorithm(&mut self, r: &Reader<'_>, name: &str, pressure: &str, kind: Kind) {
        let count = |key: &str, default: usize, least: i64| {
            r.opt_label_in(key, least..=i64::from(i32::MAX), default as i64) as usize
        };
        if name == "PISO" {
            if count("nOuterCorrectors", 1, 1) > 1 {
                r.warn_at_key(
                    "nOuterCorrectors",
                    "`nOuterCorrectors` is ignored: PISO has none",
                    "no entry of PISO",
                    Some("name the dictionary PIMPLE for outer iterations"),
                );
            }
            if !kind.granular && !kind.steady {
                self.outer = 1;
            }
        }
        if name != "PISO" {
            self.outer = count("nOuterCorrectors", self.outer, 1);
        }
        self.frozen = r.opt_switch("frozenFlow", false);
        if self.frozen {
            // Cases of OpenFOAM write -1 there.
            r.ignore("nCorrectors");
            r.ignore("nNonOrthogonalCorrectors");
        }
        if !self.frozen {
            self.correctors = count("nCorrectors", self.correctors, 1);
            self.non_orthogonal_correctors = count("nNonOrthogonalCorrectors", 0, 0);
        }
        self.predictor = r.opt_switch("momentumPredictor", true);
        self.read_reference(r);
        if kind.local {
            let l = &mut self.local;
            l.courant = r.opt_positive("maxCo", Dims::NONE, l.courant);
            l.longest = r.opt_positive("maxDeltaT", Dims::TIME, l.longest);
            l.growth = r.opt_positive("rDeltaTSmoothingCoeff", Dims::NONE, l.growth);
            r.ignore("rDeltaTDampingCoeff");
        }
        for other in [
            "consistent",
            "transonic",
            "turbOnFinalIterOnly",
            "nAlphaCorr",
            "nAlphaSubCycles",
            "cAlpha",
            "icAlpha",
            "nAlphaBounds",
            "checkMeshCourantNo",
            "correctPhi",
            "ddtCorr",
            "moveMeshOuterCorrectors",
            "pMin",
            "pMax",
        ] {
            r.ignore(other);
        }
        for key in ["residualControl", "outerCorrectorResidualControl"] {
            let Some(sub) = r.opt_sub(key) else { continue };
            let c = &mut self.control;
            c.u = tolerance(&sub, "U").unwrap_or(c.u);
            c.p = tolerance(&sub, pressure).or_else(|| tolerance(&sub, "p")).unwrap_or(c.p);
            c.viscosity = tolerance(&sub, "viscosity").unwrap_or(c.viscosity);
            self.newton = tolerance(&sub, "fluidity").unwrap_or(self.newton);
        }
    }

    fn read_reference(&mut self, r: &Reader<'_>) {
        let value = r.maybe_scalar("pRefValue", Dims::NONE);
        let cell = r.entry("pRefCell").map(|_| r.label_in("pRefCell", 0..=i64::from(i32::MAX)));
        let point = r.maybe_vector("pRefPoint", Dims::LENGTH);
        let (cell, key) = match (point, cell) {
            (Some(p), _) => (ReferenceCell::Point(p), "pRefPoint"),
            (None, Some(c)) => (ReferenceCell::Cell(c as usize), "pRefCell"),
            (None, None) if value.is_some() => (ReferenceCell::Cell(0), "pRefValue"),
            (None, None) => return,
        };
        let span = r.value_span(key);
        self.reference = Some(Reference { cell, value: value.unwrap_or(0.0), span });
    }
}

/// `key 1e-6;` or `key { tolerance 1e-6; relTol 0; }`.
fn tolerance(r: &Reader<'_>, key: &str) -> Option<f64> {
    match &r.entry(key)?.value {
        Value::Stream(_) => Some(r.positive(key, Dims::NONE)),
        Value::Dict(_) => {
            let sub = r.opt_sub(key)?;
            sub.ignore("relTol");
            Some(sub.positive("tolerance", Dims::NONE))
        }
    }
}

impl LinearSolve {
    fn default_of((solver, preconditioner): (&str, Option<&str>), abs: f64) -> LinearSolve {
        let spec = SolverSpec {
            solver: solver.into(),
            preconditioner: preconditioner.map(Into::into),
            smoother: None,
        };
        let tolerance = Tolerance { abs, rel: 0.0, max_iter: 1000 };
        LinearSolve { spec, tolerance, last: tolerance }
    }

    /// `name` and `nameFinal` of `solvers`.
    fn read(solvers: &Reader<'_>, name: &str, default: LinearSolve, notices: &Notices) -> Self {
        let final_name = format!("{name}Final");
        let Some(r) = solvers.opt_sub(name) else {
            solvers.ignore(&final_name);
            return default;
        };
        let spec = solver_spec(&r, notices);
        let tolerance = read_tolerance(&r, default.tolerance);
        let last = match solvers.opt_sub(&final_name) {
            Some(f) => {
                // One solver serves all corrections; its words are checked all the same.
                solver_spec(&f, notices);
                read_tolerance(&f, Tolerance { rel: 0.0, ..tolerance })
            }
            None => Tolerance { rel: 0.0, ..tolerance },
        };
        LinearSolve { spec, tolerance, last }
    }

    /// Incomplete factorisation takes the more iterations the finer the mesh is; one cycle of multigrid
    /// takes the same few, and is ahead on the 2268 cells of the damBreak tutorial already.
    fn precondition_with_multigrid(&mut self, name: &str, notices: &Notices) {
        let given = self.spec.preconditioner.as_deref();
        if self.spec.solver == "PCG" && matches!(given, None | Some("DIC" | "FDIC" | "DILU")) {
            if let Some(given) = given {
                notices.say(format!(
                    "fvSolution: `{given}` for `{name}` is served by a cycle of `GAMG`, to the same tolerance"
                ));
            }
            self.spec.preconditioner = Some("GAMG".into());
        }
    }
}

fn read_tolerance(r: &Reader<'_>, default: Tolerance) -> Tolerance {
    Tolerance {
        abs: r.opt_non_negative("tolerance", Dims::NONE, default.abs),
        rel: r.opt_in_range("relTol", Dims::NONE, 0.0..=1.0, default.rel),
        max_iter: r.opt_label_in("maxIter", 1..=i64::from(i32::MAX), default.max_iter as i64)
            as usize,
    }
}

fn solver_spec(r: &Reader<'_>, notices: &Notices) -> SolverSpec {
    for detail in DETAILS {
        r.ignore(detail);
    }
    let solver = r.word("solver").to_owned();
    let preconditioner = match r.entry("preconditioner").map(|e| &e.value) {
        // `preconditioner { preconditioner GAMG; tolerance ..; }`
        Some(Value::Dict(_)) => r.opt_sub("preconditioner").map(|s| {
            s.ignore_all();
            s.word("preconditioner").to_owned()
        }),
        Some(Value::Stream(_)) => r.maybe_word("preconditioner").map(str::to_owned),
        None => None,
    };
    let smoother = r.maybe_word("smoother").map(str::to_owned);
    let mut spec = SolverSpec { solver, preconditioner, smoother };
    if spec.solver == "GAMG" {
        // It brings its own; the words are accepted whatever they are.
        spec.preconditioner = None;
        spec.smoother = None;
    }
    if let Err(unknown) = build::<f64>(&spec)
        && !unknown.word.is_empty()
    {
        let key = unknown.kind.to_string();
        let near = nearest(&unknown.word, unknown.known());
        let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
        let known: Vec<&str> = unknown.known().collect();
        let help = format!("{near}known are {}", known.join(", "));
        let message = format!("unknown {key} `{}`", unknown.word);
        r.error_at_key(&key, message, "not known", Some(&help));
    }
    let words = [Some(&spec.solver), spec.preconditioner.as_ref(), spec.smoother.as_ref()];
    for word in words.into_iter().flatten() {
        // What PCG is for takes multigrid instead, and that is said there.
        if spec.solver == "PCG" && word == "FDIC" {
            continue;
        }
        let entry = ALL.iter().find(|e| e.name == word && e.mapped_onto.is_some());
        if let Some((name, onto)) = entry.and_then(|e| Some((e.name, e.mapped_onto?))) {
            notices.say(format!("fvSolution: `{name}` is served by `{onto}`"));
        }
    }
    spec
}
