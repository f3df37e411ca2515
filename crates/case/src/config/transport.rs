//! `constant/transportProperties`: what flows.

use crate::{CaseError, Notices, files};
use granflow_base::Dims;
use granflow_dict::{Diag, Dict, Entry, Reader, Severity, Sink, Token, Value, nearest};
use granflow_flow::{Mixing, Pores};
use granflow_linsolve::{SolverSpec, Tolerance, build};
use granflow_mesh::{Mesh, shapes};
use granflow_par::Exec;
use granflow_physics::rheology::{
    self, FluidContext, Granular, LawValues, NgfNumerics, Points, Rheology,
};
use std::path::Path;

/// What `transportProperties` says.
#[derive(Clone, Debug)]
pub struct Transport {
    /// Density, kg/m3; 1 for a Newtonian or generalised Newtonian fluid that does not give it.
    pub rho: f64,
    /// `transportModel`.
    pub model: String,
    /// The grains, when it is a granular model.
    pub grains: Option<Granular>,
    /// Least cooperativity length xi below yield, m: that at mu = 0; `None` without a fluidity.
    pub cooperativity: Option<f64>,
    /// Whether the model has a fluidity of its own.
    pub has_fluidity: bool,
    /// Whether the viscosity never changes.
    pub is_constant: bool,
    /// The second phase where there are two; everything else is of the first.
    pub second: Option<Box<SecondPhase>>,
    dict: Dict,
}

/// What `phases` adds to the first of them.
#[derive(Clone, Debug)]
pub struct SecondPhase {
    /// Names of both phases; the volume fraction is `alpha.<first>`.
    pub names: [String; 2],
    /// Surface tension, N/m.
    pub sigma: f64,
    /// How the viscosities mix.
    pub mixing: Mixing,
    /// What is between the grains, where the first phase is made of them.
    pub pores: Pores,
    /// The second one.
    pub transport: Transport,
}

impl SecondPhase {
    /// Name of the volume fraction of the first phase.
    pub fn alpha(&self) -> String {
        format!("alpha.{}", self.names[0])
    }
}

/// N/m.
const SURFACE_TENSION: Dims = Dims::new(1, 0, -2);

/// Models whose density must be given: their stress is written in Pa.
const GRANULAR: &[&str] = &["muI", "muIRegularised", "NGF"];

/// `phases` names a phase that has no dictionary: which of both is misspelt nobody knows.
fn no_such_phase(r: &Reader<'_>, name: &str, names: &[&str]) {
    let word = |t: &&Token| t.word() == Some(name);
    let at = r.raw("phases").and_then(|t| t.iter().find(word)).map(|t| t.span.clone());
    let at = at.unwrap_or_else(|| r.value_span("phases"));
    let strangers = r.keys().into_iter().filter(|k| !names.contains(k));
    let help = match nearest(name, strangers) {
        Some(near) => {
            // It has had its word.
            r.ignore(near);
            format!("there is a dictionary `{near}`: one of the two is misspelt")
        }
        None => format!("add `{name} {{ transportModel ...; }}`"),
    };
    let message = format!("the phase `{name}` has no dictionary");
    r.error_at(&at, message, "named here", Some(&help));
}

impl Transport {
    /// Reads the file; mistakes go to the sink.
    pub(super) fn read(
        root: &Path,
        sink: &Sink,
        notices: &Notices,
    ) -> Result<Transport, CaseError> {
        let file = "constant/transportProperties";
        let found = match files::dict(root, file, sink)? {
            Some(d) => Some(d),
            None => files::dict(root, "constant/physicalProperties", sink)?,
        };
        let Some(mut dict) = found else {
            let d = Diag::file(root.join(file).display().to_string(), "this file is missing");
            sink.push(d.help(
                "it names the rheology: `transportModel Newtonian; nu 1e-6;` (`granflow list \
                 rheologies`)",
            ));
            return Ok(Transport::water());
        };
        if dict.find("phases").is_some() {
            return Ok(Transport::two(&dict, sink));
        }
        if let Some(e) = dict.remove("viscosityModel")
            && dict.find("transportModel").is_none()
        {
            // What newer versions call the same entry, and the constant model in it.
            let value = if is_word(&e, "constant") { "Newtonian".into() } else { e.value };
            dict.set("transportModel", value);
        }
        if dict.find("transportModel").is_none() && dict.find("nu").is_some() {
            dict.set("transportModel", "Newtonian");
            notices.say("transportProperties: no transportModel, so the viscosity is `nu`");
        }
        Ok(Transport::checked(dict, sink))
    }

    /// `phases (first second);` with a dictionary for each, and `sigma`.
    fn two(dict: &Dict, sink: &Sink) -> Transport {
        let r = Reader::new(dict, sink);
        let names = r.words("phases");
        let [first, second] = names[..] else {
            let message = format!("two phases are needed, found {}", names.len());
            let help = "write `phases (water air);`: the first is the one of alpha";
            r.error_at_key("phases", message, "two names", Some(help));
            return Transport::water();
        };
        let sigma = r.non_negative("sigma", SURFACE_TENSION);
        let phase = |name: &str| {
            if !r.has(name) {
                no_such_phase(&r, name, &names);
                return Transport::water();
            }
            let Some(sub) = r.sub(name) else { return Transport::water() };
            let mut dict = sub.dict().clone();
            sub.ignore_all();
            let model = dict.word("transportModel").map(|m| format!("{m}Coeffs"));
            // OpenFOAM's tutorials carry the coefficients of models that are not in use.
            let unused = |e: &Entry| {
                let key = e.key.text();
                key.ends_with("Coeffs") && Some(key) != model.as_deref()
            };
            dict.entries.retain(|e| !unused(e));
            if dict.find("transportModel").is_none() {
                dict.set("transportModel", "Newtonian");
            }
            let at = Reader::new(&dict, sink);
            if !at.has("rho") {
                at.positive("rho", Dims::DENSITY);
            }
            let phase = Transport::checked(dict, sink);
            if phase.grains.is_some() && name == second {
                let message = format!("`{}` is a model of grains, which come first", phase.model);
                let help = format!(
                    "write `phases ({second} {first});`, with the fraction `alpha.{second}`"
                );
                sub.error_at_key("transportModel", message, "the second phase", Some(&help));
            }
            phase
        };
        let (one, two) = (phase(first), phase(second));
        let granular = one.grains.is_some();
        if granular
            && let Some(at) = r.opt_sub(second)
            && at.dict().number("nu") == Some(0.0)
        {
            let message = "grains need a fluid with a viscosity beside them";
            let help =
                "without one nothing resists where grains thin out; that of air is 1.5e-5 m2/s";
            at.error_at_key("nu", message, "none", Some(help));
        }
        let usual = if granular { Mixing::Harmonic } else { Mixing::Arithmetic };
        let mixing = r.opt_one_of("mixing", Mixing::ALL, usual);
        let pores =
            if granular { r.opt_one_of("pores", Pores::ALL, Pores::Dry) } else { Pores::Dry };
        r.finish(Severity::Warning);
        let names = [first.to_owned(), second.to_owned()];
        let second = SecondPhase { names, sigma, mixing, pores, transport: two };
        Transport { second: Some(Box::new(second)), ..one }
    }

    /// Reads everything once, on a mesh of one cell: every mistake shows whatever the mesh is.
    fn checked(dict: Dict, sink: &Sink) -> Transport {
        let mut out = Transport { dict, ..Transport::water() };
        let r = Reader::new(&out.dict, sink);
        out.model =
            r.raw("transportModel").and_then(|t| t.first()?.word()).unwrap_or("").to_owned();
        let granular = GRANULAR.contains(&out.model.as_str());
        out.rho = match granular {
            true => r.positive("rho", Dims::DENSITY),
            false => r.opt_positive("rho", Dims::DENSITY, 1.0),
        };
        let coeffs = format!("{}Coeffs", out.model);
        if r.has(&coeffs) {
            // OpenFOAM's tutorials carry a `nu` that the model in use does not read.
            r.ignore("nu");
        }
        let exec = Exec::serial();
        if let Ok(mesh) = Mesh::new(&shapes::unit_box([1, 1, 1]))
            && let Some(numerics) = any_numerics()
        {
            let context = FluidContext {
                density: out.rho,
                exec: &exec,
                mesh: &mesh,
                fluidity_conditions: Vec::new(),
                numerics,
            };
            let rheology = rheology::read(&r, context);
            out.has_fluidity = rheology.field().is_some();
            out.is_constant = rheology.is_constant();
            out.grains = rheology.grains();
        }
        r.finish(Severity::Error);
        let again = Reader::new(&out.dict, &Sink::new());
        let coeffs = again.opt_sub(&coeffs).unwrap_or(again);
        if granular && out.grains.is_none() {
            out.grains = Some(Granular::read(&coeffs));
        }
        if let (true, Some(g)) = (out.has_fluidity, &out.grains) {
            let a = coeffs.opt_scalar("A", Dims::NONE, f64::NAN);
            let xi = a * g.d * (g.mu_2 / ((g.mu_2 - g.mu_s) * g.mu_s)).sqrt();
            out.cooperativity = Some(xi).filter(|xi| xi.is_finite());
        }
        out
    }

    fn water() -> Transport {
        Transport {
            rho: 1.0,
            model: "Newtonian".into(),
            grains: None,
            cooperativity: None,
            has_fluidity: false,
            is_constant: true,
            second: None,
            dict: Dict::new(),
        }
    }

    /// Viscosity at the strain rate `rate` (1/s), Pa s, of a fluid for which it depends on nothing else.
    pub fn viscosity_at(&self, mesh: &Mesh, rate: f64) -> Option<f64> {
        if self.grains.is_some() {
            return None;
        }
        let exec = Exec::serial();
        let context = FluidContext {
            density: self.rho,
            exec: &exec,
            mesh,
            fluidity_conditions: Vec::new(),
            numerics: any_numerics()?,
        };
        let points = Points { strain_rate: &[rate], pressure: &[0.0], density: self.rho };
        let (mut viscosity, mut slopes) = ([0.0], [[0.0; 2]]);
        let out = LawValues { viscosity: &mut viscosity, slopes: &mut slopes };
        self.rheology(context).at_points(&exec, &points, out).then_some(viscosity[0])
    }

    /// The rheology on a mesh. The dictionary was checked before: nothing is reported again.
    pub fn rheology(&self, context: FluidContext<'_>) -> Box<dyn Rheology> {
        let silent = Sink::new();
        rheology::read(&Reader::new(&self.dict, &silent), context)
    }
}

fn is_word(e: &Entry, word: &str) -> bool {
    matches!(&e.value, Value::Stream(t) if t.first().and_then(|t| t.word()) == Some(word))
}

fn any_numerics() -> Option<NgfNumerics> {
    let spec = SolverSpec { solver: "PBiCGStab".into(), ..SolverSpec::default() };
    let solver = build(&spec).ok()?;
    Some(NgfNumerics { solver, tolerance: Tolerance::default(), residual: 1e-10 })
}
