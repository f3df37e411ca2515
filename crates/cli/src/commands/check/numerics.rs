//! Schemes and linear solvers, and what serves for what the case names.

use super::page::Page;
use crate::text::number;
use granflow_case::Case;
use granflow_case::config::{GradientKind, LinearSolve};
use granflow_case::files::exists;
use granflow_flow::{NormalDerivative, TimeScheme};
use granflow_fv::GradientLimiter;

/// Whether a notice is about schemes or solvers.
pub(super) fn is_of(notice: &str) -> bool {
    let of = [
        "fvSolution",
        "fvSchemes",
        "gradSchemes",
        "divSchemes",
        "laplacianSchemes",
        "interpolationSchemes",
    ];
    of.iter().any(|f| notice.starts_with(f))
}

pub(super) fn say(case: &Case, mapped: &[String], page: &mut Page) {
    page.open("Schemes and solvers");
    for file in ["fvSchemes", "fvSolution"] {
        if !exists(&case.root, &format!("system/{file}")) {
            page.say(file, "the case has none: defaults");
        }
    }
    let (schemes, solution) = (&case.config.schemes, &case.config.solution);
    let time = match schemes.ddt {
        TimeScheme::Euler => "Euler".to_owned(),
        TimeScheme::Backward => "backward".to_owned(),
        TimeScheme::CrankNicolson(psi) => format!("CrankNicolson {}", number(psi)),
        TimeScheme::Local(steps) => {
            format!("localEuler (Courant number {} in every cell)", number(steps.courant))
        }
        TimeScheme::Steady => "steadyState".to_owned(),
    };
    let gradient = match schemes.gradient {
        GradientKind::GaussLinear => "Gauss linear",
        GradientKind::LeastSquares => "leastSquares",
    };
    let mut text = format!("time {time}, gradients {gradient}, U by {}", schemes.convection.name());
    if let Some(limiter) = schemes.limiter {
        let word = GradientLimiter::NAMES.iter().find(|n| n.1 == limiter.limit).map_or("", |n| n.0);
        text += &format!(" with grad(U) by {word} {}", number(limiter.k));
    }
    if case.config.transport.second.is_some() {
        text += &match case.config.control.application.as_str() {
            "interIsoFoam" => ", alpha by isoAdvector".to_owned(),
            _ => format!(", alpha by {}", schemes.alpha.name()),
        };
    }
    let angle = case.mesh.max_nonorth_deg;
    text += &match schemes.non_orthogonal {
        _ if angle < 0.05 => String::new(),
        1.0 => ", non-orthogonal faces corrected".to_owned(),
        0.0 => ", non-orthogonal faces not corrected".to_owned(),
        k => format!(", non-orthogonal faces corrected up to {}", number(k)),
    };
    if let (Some(how), Some(_)) = (schemes.sn_grad, &case.config.transport.second)
        && angle >= 0.05
        && how != (NormalDerivative { limit: schemes.non_orthogonal, orthogonal: false })
    {
        text += &format!(", density and fraction on faces {}", named(how));
        page.warn(
            "snGradSchemes are not laplacianSchemes: pressure and weight do not balance on faces that lean, \
             and still fluids move",
        );
    }
    if schemes.compatible {
        text += match schemes.sides_apart {
            true => {
                ", in a single pass with OpenFOAM's forms, those of periodic sides too (`compatible yes;`)"
            }
            false => ", in a single pass with OpenFOAM's forms (`compatible no;` has ours)",
        };
    }
    page.say("schemes", text);
    if schemes.non_orthogonal == 0.0 && angle > 5.0 {
        page.warn(format!(
            "faces are up to {} degrees from orthogonal and laplacianSchemes leaves that out: write \
             `corrected`",
            number(angle)
        ));
    }
    let granular = case.config.transport.grains.is_some();
    let coupled = granular || solution.outer > 1;
    page.say("U", solver(&solution.u, coupled));
    page.say(case.config.pressure(), solver(&solution.p, coupled));
    if case.config.transport.has_fluidity {
        page.say("fluidity", solver(&solution.fluidity, false));
    }
    let control = &solution.control;
    page.say(
        "a step",
        match coupled {
            true => format!(
                "at most {} passes of momentum and continuity together, until the residuals of U, p \
                 and viscosity are {}, {} and {}",
                solution.outer,
                number(control.u),
                number(control.p),
                number(control.viscosity)
            ),
            false => format!(
                "PISO: momentum {}, then {} corrections of the pressure",
                if solution.predictor { "solved" } else { "not solved beforehand" },
                solution.correctors
            ),
        },
    );
    for notice in mapped {
        page.say("mapped", notice);
    }
}

/// As the dictionary has it.
fn named(how: NormalDerivative) -> String {
    match how {
        NormalDerivative { orthogonal: true, .. } => "orthogonal".to_owned(),
        NormalDerivative { limit: 1.0, .. } => "corrected".to_owned(),
        NormalDerivative { limit: 0.0, .. } => "uncorrected".to_owned(),
        NormalDerivative { limit, .. } => format!("limited {}", number(limit)),
    }
}

fn solver(s: &LinearSolve, coupled: bool) -> String {
    let mut text = s.spec.solver.clone();
    let extra = [("with", &s.spec.preconditioner), ("smoothed by", &s.spec.smoother)];
    for (word, name) in extra {
        if let Some(name) = name {
            text += &format!(" {word} {name}");
        }
    }
    if coupled {
        return text + ", preconditioning";
    }
    let (t, last) = (s.tolerance, s.last);
    text += &format!(" to {}", number(t.abs));
    if t.rel > 0.0 {
        text += &format!(" or {} of the start", number(t.rel));
    }
    if last != t {
        text += &format!(", the last to {}", number(last.abs));
    }
    text
}
