//! How the volume fraction moves: `solvers { "alpha.water.*" { .. } }` of `fvSolution`.

use super::schemes::Schemes;
use crate::Notices;
use granflow_base::Dims;
use granflow_dict::{Dict, Reader, Severity, Sink};
use granflow_flow::vof::{AlgebraicParams, GeometricParams, Params, Reconstruct};

/// Entries of OpenFOAM's solvers that change nothing here.
const HARMLESS: &[&str] = &[
    "solver",
    "smoother",
    "preconditioner",
    "relTol",
    "minIter",
    "maxIter",
    "nSweeps",
    "smoothLimiter",
    "alphaApplyPrevCorr",
    "alphaOuterCorrectors",
    "writeFields",
    "writeIsoFaces",
    "maxUnboundedness",
    "CoCoeff",
    "cYC",
    "nNonOrthogonalCorrectors",
    "extremaCoeff",
    "boundaryExtremaCoeff",
    "isoAlphaTol",
    "vof2IsoTol",
    "isoFaceTol",
    "splitWarpedFaces",
    "interfaceNormal",
    "iterations",
    "tol",
    "relTol",
    "mapAlphaField",
];

/// Reads the dictionary of the field `alpha` (all defaults when there is none). Isoadvection where
/// `geometric` says so or a `reconstructionScheme` is named.
pub(super) fn read(
    solution: &Dict,
    alpha: &str,
    geometric: bool,
    schemes: &Schemes,
    sink: &Sink,
    notices: &Notices,
) -> Params {
    let silent = Sink::new();
    let empty = Dict::new();
    let whole = Reader::new(solution, &silent);
    let found = whole.opt_sub("solvers").and_then(|s| s.opt_sub(alpha).map(|r| r.dict()));
    let r = Reader::new(found.unwrap_or(&empty), sink);
    HARMLESS.iter().for_each(|key| r.ignore(key));
    let count = |key: &str, default: usize, least: i64| {
        r.opt_label_in(key, least..=i64::from(i32::MAX), default as i64) as usize
    };
    let known: Vec<(&str, Reconstruct)> =
        Reconstruct::NAMES.into_iter().filter_map(|n| Some((n, Reconstruct::parse(n)?))).collect();
    // interIsoFoam finds iso-surfaces unless it is told otherwise.
    let default = if geometric { Reconstruct::IsoAlpha } else { Reconstruct::PlicRdf };
    let named = r.has("reconstructionScheme");
    let reconstruction = r.opt_one_of("reconstructionScheme", &known, default);
    let (a, g) = (AlgebraicParams::default(), GeometricParams::default());
    let algebraic = AlgebraicParams {
        c_alpha: r.opt_non_negative("cAlpha", Dims::NONE, a.c_alpha),
        ic_alpha: r.opt_non_negative("icAlpha", Dims::NONE, a.ic_alpha),
        n_alpha_corr: count("nAlphaCorr", a.n_alpha_corr, 1),
        n_alpha_sub_cycles: count("nAlphaSubCycles", a.n_alpha_sub_cycles, 1),
        mules_corr: r.opt_switch("MULESCorr", a.mules_corr),
        n_limiter_iter: count("nLimiterIter", a.n_limiter_iter, 1),
        central_compression: schemes.compatible && schemes.central_compression != Some(false),
        convection: schemes.alpha,
        tolerance: granflow_linsolve::Tolerance {
            abs: r.opt_positive("tolerance", Dims::NONE, a.tolerance.abs),
            ..a.tolerance
        },
    };
    if r.opt_non_negative("scAlpha", Dims::NONE, 0.0) > 0.0 {
        notices.say("fvSolution: scAlpha is left out, there is no shear compression");
    }
    let cut = GeometricParams {
        reconstruction,
        surf_cell_tol: r.opt_positive("surfCellTol", Dims::NONE, g.surf_cell_tol),
        n_alpha_bounds: count("nAlphaBounds", g.n_alpha_bounds, 0),
        snap_tol: r.opt_non_negative("snapTol", Dims::NONE, g.snap_tol),
        clip: r.opt_switch("clip", g.clip),
        n_alpha_sub_cycles: algebraic.n_alpha_sub_cycles,
        sides_apart: schemes.sides_apart,
    };
    r.finish(Severity::Warning);
    if geometric || named {
        return Params::Geometric(cut);
    }
    if schemes.central_compression == Some(true) && !schemes.compatible {
        notices.say(
            "fvSchemes: the compression of `div(phirb,alpha)` is central in the middle of an interface only",
        );
    }
    Params::Algebraic(algebraic)
}
