//! Everything a case's dictionaries say, checked, as plain data.
//!
//! One sink collects the mistakes of all files, so that one run reports them all. Missing files
//! and entries get the defaults that each submodule documents.

mod compatible;
mod control;
mod corrections;
mod forbidden;
mod gradients;
pub(crate) mod mrf;
mod schemes;
mod solution;
pub(crate) mod sources;
mod transport;
mod vof;

use compatible::Forms;
pub use control::{APPLICATIONS, Adjust, Control, StartFrom, WriteControl};
pub use schemes::{GradientKind, PLAIN, Schemes};
pub use solution::{LinearSolve, Reference, ReferenceCell, Solution};
pub use transport::{SecondPhase, Transport};

use self::solution::Kind;
use crate::functions::Planned;
use crate::{CaseError, Notices, files};
use granflow_base::{Dims, Vec3};
use granflow_dict::{Diag, Dict, Reader, Severity, Sink};
use granflow_flow::TimeScheme;
use std::path::Path;

/// A case's dictionaries as plain data.
pub struct CaseConfig {
    /// `system/controlDict`.
    pub control: Control,
    /// `system/fvSchemes`.
    pub schemes: Schemes,
    /// `system/fvSolution`.
    pub solution: Solution,
    /// `constant/transportProperties`.
    pub transport: Transport,
    /// `constant/g`, m/s2; with it the pressure is p_rgh.
    pub gravity: Option<Vec3>,
    /// How the volume fraction moves, where there are two phases.
    pub vof: Option<granflow_flow::vof::Params>,
    /// `functions` of `controlDict`.
    pub functions: Vec<Planned>,
}

impl CaseConfig {
    /// Reads every dictionary but the mesh's. Mistakes go to the sink; the values are usable only
    /// when it holds no error.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn read(root: &Path, sink: &Sink, notices: &Notices) -> Result<CaseConfig, CaseError> {
        forbidden::refuse(root, sink)?;
        let gravity = read_gravity(root, sink)?;
        refuse_other_heights(root, sink)?;
        let transport = Transport::read(root, sink, notices)?;
        let found = files::dict(root, "system/controlDict", sink)?;
        let absent = found.is_none();
        let control_dict = match found {
            Some(d) => d,
            None => {
                let d = Diag::file(
                    root.join("system/controlDict").display().to_string(),
                    "this file is missing: it says how long to run and what to write",
                );
                sink.push(d.help("`granflow new NAME` writes a complete case"));
                Dict::new()
            }
        };
        let reader = Reader::new(&control_dict, sink);
        let control = Control::read(&reader, absent);
        let functions = crate::functions::read(&reader);
        reader.finish(Severity::Warning);
        let schemes_dict = files::dict(root, "system/fvSchemes", sink)?;
        let alpha = transport.second.as_deref().map(SecondPhase::alpha);
        let kind = (alpha.as_deref(), transport.grains.is_some());
        let mut schemes = match &schemes_dict {
            Some(d) => Schemes::read(d, kind, sink, notices),
            None => Schemes::default(),
        };
        let solution_dict = files::dict(root, "system/fvSolution", sink)?.unwrap_or_default();
        let two = transport.second.as_deref();
        let pressure = if gravity.is_some() || two.is_some() { "p_rgh" } else { "p" };
        let solution = Solution::read(
            &solution_dict,
            &control.application,
            pressure,
            Kind {
                varies: two.is_none() && transport.model != "Newtonian",
                granular: transport.grains.is_some(),
                steady: schemes.ddt == TimeScheme::Steady,
                local: matches!(schemes.ddt, TimeScheme::Local(_)),
            },
            sink,
            notices,
        );
        let newtonian = |model: &str| model == "Newtonian";
        let kind = compatible::Kind {
            two: two.is_some(),
            grains: transport.grains.is_some(),
            newtonian: newtonian(&transport.model)
                && two.is_none_or(|second| newtonian(&second.transport.model)),
            outer: solution.outer,
            ddt: schemes.ddt,
        };
        let said = (sink, notices);
        let forms = compatible::decide(schemes_dict.as_ref(), &control.application, &kind, said);
        schemes.compatible = forms != Forms::Ours;
        schemes.sides_apart = forms == Forms::AskedFor;
        if let TimeScheme::Local(steps) = &mut schemes.ddt {
            *steps = solution.local;
        }
        let vof = two.map(|two| {
            let geometric = control.application == "interIsoFoam";
            vof::read(&solution_dict, &two.alpha(), geometric, &schemes, sink, notices)
        });
        Ok(CaseConfig { control, schemes, solution, transport, gravity, functions, vof })
    }

    /// What makes a force per volume of what `fvOptions` gives: with one fluid that is per density.
    pub fn acceleration_to_force(&self) -> f64 {
        if self.transport.second.is_some() { 1.0 } else { self.transport.rho }
    }

    /// The pressure that is solved for: `p_rgh` where gravity acts or two phases meet, else `p`.
    pub fn pressure(&self) -> &'static str {
        let two = self.transport.second.is_some();
        if self.gravity.is_some() || two { "p_rgh" } else { "p" }
    }
}

/// Heights are measured from the origin: another `constant/hRef` would change what p_rgh means.
fn refuse_other_heights(root: &Path, sink: &Sink) -> Result<(), CaseError> {
    let Some(dict) = files::dict(root, "constant/hRef", sink)? else { return Ok(()) };
    let r = Reader::new(&dict, sink);
    if r.opt_scalar("value", Dims::LENGTH, 0.0) != 0.0 {
        let help = "write 0, and p_rgh = p - rho g.x in the conditions; or use prghPressure";
        r.error_at_key("value", "hRef is not supported", "not zero", Some(help));
    }
    Ok(())
}

/// `constant/g`, a uniformDimensionedVectorField.
fn read_gravity(root: &Path, sink: &Sink) -> Result<Option<Vec3>, CaseError> {
    let Some(dict) = files::dict(root, "constant/g", sink)? else { return Ok(None) };
    let r = Reader::new(&dict, sink);
    if let Some(d) = r.maybe_dims("dimensions")
        && d != Dims::ACCELERATION
    {
        let message = format!("gravity has the dimensions {}, found {d}", Dims::ACCELERATION);
        r.error_at_key("dimensions", message, "wrong dimensions", None);
    }
    let g = r.vector("value", Dims::ACCELERATION);
    r.finish(Severity::Warning);
    Ok(Some(g))
}
