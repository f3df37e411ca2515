//! `#includeEtc`: what fields and functions of cases need of OpenFOAM's `etc` folder, written anew.

use crate::diag::Diag;
use crate::nearest;
use crate::parse::{Cursor, Parser};
use crate::source::{Source, Span};
use crate::token::Lexeme;

/// Types of patch that leave a field no choice. Each is also the name of a group that its patches
/// belong to, so that one entry serves them all.
pub const CONSTRAINT_TYPES: &[&str] = &[
    "cyclic",
    "cyclicACMI",
    "cyclicAMI",
    "cyclicSlip",
    "empty",
    "nonuniformTransformCyclic",
    "processor",
    "processorCyclic",
    "symmetry",
    "symmetryPlane",
    "wedge",
];

/// What fields include in their `boundaryField`.
const CONSTRAINTS: &str = "caseDicts/setConstraintTypes";

/// What functions of tutorials include: path below `caseDicts/postProcessing` and its entries.
const FUNCTIONS: &[(&str, &str)] = &[
    (
        "graphs/graph.cfg",
        "type sets; writeControl writeTime; sets (line { $setConfig; start $start; end $end; });",
    ),
    (
        "graphs/sampleDict.cfg",
        "interpolationScheme cellPoint; setFormat raw;
         setConfig { type uniform; axis distance; nPoints 100; }",
    ),
    ("numerical/residuals.cfg", "type solverInfo; writeControl timeStep; writeInterval 1;"),
    ("probes/probes.cfg", "type probes; writeControl timeStep; writeInterval 1;"),
    ("minMax/fieldMinMax.cfg", "type fieldMinMax; mode magnitude;"),
    ("minMax/minMaxComponents.cfg", "type fieldMinMax; mode component;"),
    ("minMax/cellMinMax.cfg", "type volFieldValue; regionType all; operation max;"),
    ("minMax/cellMin.cfg", "type volFieldValue; regionType all; operation min;"),
    ("surfaceFieldValue/surfaceRegion.cfg", "type surfaceFieldValue; writeFields false;"),
    ("surfaceFieldValue/patch.cfg", "type surfaceFieldValue; writeFields false; regionType patch;"),
    (
        "flowRate/flowRatePatch.cfg",
        "type surfaceFieldValue; writeFields false; regionType patch; fields (phi); operation sum;",
    ),
    ("forces/forces.cfg", "type forces; writeControl timeStep; writeInterval 1;"),
    (
        "forces/forcesIncompressible.cfg",
        "type forces; rho rhoInf; writeControl timeStep; writeInterval 1;",
    ),
    ("forces/forceCoeffs.cfg", "type forceCoeffs; writeControl timeStep; writeInterval 1;"),
    (
        "forces/forceCoeffsIncompressible.cfg",
        "type forceCoeffs; rho rhoInf; rhoInf 1; writeControl timeStep; writeInterval 1;",
    ),
    (
        "visualization/streamlines.cfg",
        "type streamLine; writeControl writeTime; setFormat vtk; trackForward true; lifeTime 10000;
         nSubCycle 5; cloud particleTracks;
         seedSampleSet { type uniform; axis x; start $start; end $end; nPoints $nLines; }",
    ),
    (
        "visualization/surfaces.cfg",
        "type surfaces; writeControl writeTime; surfaceFormat vtk; interpolationScheme cellPoint;
         x (1 0 0); y (0 1 0); z (0 0 1); origin (0 0 0);
         cuttingPlane { type cuttingPlane; planeType pointAndNormal;
           pointAndNormalDict { point $origin; normal $x; } interpolate true; }
         isosurface { type isoSurfaceCell; interpolate true; }
         patchSurface { type patch; interpolate true; }",
    ),
];

impl Parser<'_> {
    /// Reads the file that is built in; refuses any other by name.
    pub(crate) fn include_etc(&mut self, c: &mut Cursor, span: &Span) {
        let (lexeme, at) = c.next();
        let (Lexeme::Str { text: name, .. } | Lexeme::Word(name)) = lexeme else {
            let d = Diag::error(span, "the name of a file is needed behind `#includeEtc`");
            self.push(d.label(format!("such as `#includeEtc \"{CONSTRAINTS}\"`")));
            c.at = at.range.start;
            return;
        };
        let name = name.strip_prefix("<etc>").unwrap_or(&name).trim_start_matches('/');
        if name == CONSTRAINTS {
            let entry = |t: &&str| format!("{t} {{ type {t}; }}\n");
            let text: String = CONSTRAINT_TYPES.iter().map(entry).collect();
            let src = Source::new(format!("etc/{CONSTRAINTS} (built in)"), text.into_bytes());
            self.entries(&mut Cursor::new(&src), None);
            return;
        }
        let function = name.strip_prefix("caseDicts/postProcessing/");
        if let Some((_, text)) = FUNCTIONS.iter().find(|f| Some(f.0) == function) {
            let src = Source::new(format!("etc/{name} (built in)"), text.as_bytes().to_vec());
            self.entries(&mut Cursor::new(&src), None);
            return;
        }
        let near = nearest(name, [CONSTRAINTS]).map(|n| format!("did you mean \"{n}\"? "));
        let help = format!(
            "{}granflow does not read OpenFOAM's `etc` folder, but for \"{CONSTRAINTS}\" and what \
             functions include, which are built in; copy the entries that are needed into the case",
            near.unwrap_or_default()
        );
        let message = format!("`#includeEtc \"{name}\"` is not available");
        self.push(Diag::error(&span.to(&at), message).label("refused").help(help));
        self.lose();
    }

    /// Entries of the dictionary at hand are lost, which was said.
    pub(crate) fn lose(&mut self) {
        self.lost = true;
        self.here().incomplete = true;
    }
}
