//! `constant/waveProperties`: the waves of patches whose conditions are `waveAlpha` and
//! `waveVelocity`.
//!
//! The depth of still water before such a patch is measured once, from the fraction in the cells
//! behind it when the run begins. It goes on as `waterDepthRef` in `uniform/waveProperties.<patch>` of
//! every time directory, where a restart (of the reference tool as well) finds it.

use crate::restart::WholeState;
use crate::{CaseError, files};
use granflow_base::{Dims, Vec3, add, scale};
use granflow_dict::{Diag, Dict, Format, Header, Reader, Severity, Sink, Writer, nearest, number};
use granflow_fv::conditions::WavePatch;
use granflow_fv::waves::{Frame, Source};
use granflow_mesh::{Mesh, PolyMesh};
use std::path::Path;

const FILE: &str = "constant/waveProperties";
const DEPTH: &str = "waterDepthRef";
/// Another name for it.
const DEPTH_TOO: &str = "waterDepth";
/// Conditions that are about fluid 1 (what lets in as much as there is of it, and what holds its mean velocity),
/// and what is like them where there is one fluid.
const OF_A_PHASE: [(&str, &str); 2] = [
    ("variableHeightFlowRateInletVelocity", "flowRateInletVelocity"),
    ("outletPhaseMeanVelocity", "flowRateOutletVelocity"),
];

/// The waves of one patch.
struct Waves {
    entry: Dict,
    frame: Frame,
}

/// The waves of all patches, in the order of the mesh; empty before they were read.
#[derive(Default)]
pub struct WaveTable(Vec<Option<Waves>>);

/// Extent of the faces of a patch on one rank, for [`WaveTable::at`].
#[derive(Default)]
pub(crate) struct Extents {
    spans: Vec<[f64; 2]>,
    centres: Vec<Vec3>,
}

impl WaveTable {
    /// Reads the waves that the conditions in `start` ask for. Mistakes go to the sink.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub(crate) fn read(
        root: &Path,
        start: &WholeState,
        gravity: Vec3,
        (poly, mesh): (&PolyMesh, &Mesh),
        sink: &Sink,
    ) -> Result<WaveTable, CaseError> {
        let asks = |entries: &[Dict], word: &str, p: usize| {
            entries.get(p).is_some_and(|d| d.word("type") == Some(word))
        };
        let alpha = start.alpha.as_ref().map_or(&[][..], |a| &a.boundary);
        let wanted: Vec<usize> = (0..poly.patches.len())
            .filter(|&p| asks(&start.u.boundary, "waveVelocity", p) || asks(alpha, "waveAlpha", p))
            .collect();
        let mut table = WaveTable::default();
        for entry in &start.u.boundary {
            let kind = entry.word("type");
            let kind = OF_A_PHASE.iter().find(|(name, _)| kind == Some(*name));
            let (Some((kind, alone)), r) = (kind, Reader::new(entry, sink)) else { continue };
            match &start.alpha {
                Some(field) => check_fraction(&r, &field.name),
                None => {
                    let message = format!("`{kind}` needs two phases");
                    let help = format!("with one fluid write `{alone}`");
                    r.error_at_key("type", message, "the case has one", Some(&help));
                }
            }
        }
        if wanted.is_empty() {
            return Ok(table);
        }
        let path = root.join(FILE).display().to_string();
        let Some(field) = &start.alpha else {
            let message = "waves need two phases: water and what is above it";
            sink.push(Diag::file(
                root.join("constant/transportProperties").display().to_string(),
                message,
            ));
            return Ok(table);
        };
        let Some(dict) = files::dict(root, FILE, sink)? else {
            let message = "this file is missing: it says what waves are at the patches with the \
                           condition `waveVelocity` or `waveAlpha`";
            sink.push(Diag::file(path, message));
            return Ok(table);
        };
        table.0 = (0..poly.patches.len()).map(|_| None).collect();
        let all = Reader::new(&dict, sink);
        for p in wanted {
            let patch = &poly.patches[p];
            let Some(r) = all.opt_sub(&patch.name) else {
                let help = nearest(&patch.name, all.keys()).map(|n| format!("did you mean `{n}`?"));
                let message = format!("no waves are given for patch `{}`", patch.name);
                all.error_here(message, "not found before the end", help.as_deref());
                continue;
            };
            check_fraction(&r, &field.name);
            let Some(mut frame) = frame_of(p, gravity, poly, mesh) else {
                let message = format!("waves cannot come in through patch `{}`", patch.name);
                let help = "a patch with waves stands upright, and gravity acts (constant/g)";
                sink.push(Diag::file(path.clone(), message).help(help));
                continue;
            };
            let given = [DEPTH, DEPTH_TOO].into_iter().find(|key| r.has(key));
            frame.depth = match given {
                // What the user says counts before what an earlier run measured.
                Some(key) => r.positive(key, Dims::LENGTH),
                None => match stored(root, &start.dir, &patch.name, sink)? {
                    Some(depth) => depth,
                    None => frame.level(wet_share(p, &field.cells, mesh)),
                },
            };
            if r.opt_non_negative("initialDepth", Dims::LENGTH, 0.0) > 0.0 {
                let message = "a depth that is added to what is measured is not there";
                let help = "give the depth of still water as `waterDepthRef`";
                r.error_at_key("initialDepth", message, "not 0", Some(help));
            }
            if given.is_some() && (frame.depth <= 0.0 || frame.depth.is_nan()) {
                continue;
            }
            if frame.depth <= 0.0 {
                let message = format!("there is no water before patch `{}`", patch.name);
                let help = "fill cells behind it (system/setFieldsDict), or give `waterDepthRef`";
                r.error_here(message, "needs a depth of still water", Some(help));
                continue;
            }
            Source::read(&r, frame);
            r.finish(Severity::Warning);
            let mut entry = r.dict().clone();
            entry.set(DEPTH, vec![granflow_dict::Token::of_number(frame.depth)]);
            table.0[p] = Some(Waves { entry, frame });
        }
        Ok(table)
    }

    /// Extent of the faces `mine` (places in the patch) of patch `p`; empty where there are no waves.
    pub(crate) fn extents(
        &self,
        p: usize,
        poly: &PolyMesh,
        mesh: &Mesh,
        mine: &[usize],
    ) -> Extents {
        let Some(Some(waves)) = self.0.get(p) else { return Extents::default() };
        let start = poly.patches[p].start;
        let spans = mine.iter().map(|i| waves.frame.span(corners(poly, start + i))).collect();
        let centres = mesh.patches[p].faces.clone().map(|f| mesh.face_centre[f]).collect();
        Extents { spans, centres }
    }

    /// What conditions of patch `p` are told.
    pub(crate) fn at<'a>(&'a self, p: usize, extents: &'a Extents) -> Option<WavePatch<'a>> {
        let waves = self.0.get(p)?.as_ref()?;
        let Extents { spans, centres } = extents;
        Some(WavePatch { entry: &waves.entry, frame: waves.frame, spans, centres })
    }

    /// Files of `uniform` in the time directory `dir`: name and text.
    pub(crate) fn sheets(&self, poly: &PolyMesh, dir: &str) -> Vec<(String, Vec<u8>)> {
        let one = |(p, waves): (usize, &Option<Waves>)| {
            let waves = waves.as_ref()?;
            let name = format!("waveProperties.{}", poly.patches[p].name);
            let class = waves.entry.word("waveModel").unwrap_or("dictionary").to_owned();
            let header = Header::new(class, name.clone()).location(format!("{dir}/uniform"));
            let mut w = Writer::new(&header.format(Format::Ascii));
            let mut rest = waves.entry.clone();
            rest.remove(DEPTH);
            w.dict(&rest);
            // To the last bit.
            w.entry(DEPTH, number(waves.frame.depth));
            Some((name, w.finish()))
        };
        self.0.iter().enumerate().filter_map(one).collect()
    }
}

/// `alpha`, which names the fraction that there is.
fn check_fraction(r: &Reader<'_>, name: &str) {
    let given = r.maybe_word("alpha").unwrap_or(name);
    if given != name && !given.is_empty() {
        let message = format!("`{given}` is not the volume fraction of the first phase");
        r.error_at_key("alpha", message, "no such field", Some(&format!("write `alpha {name};`")));
    }
}

/// The depth that an earlier run stored.
fn stored(root: &Path, dir: &str, patch: &str, sink: &Sink) -> Result<Option<f64>, CaseError> {
    let path = Path::new(dir).join("uniform").join(format!("waveProperties.{patch}"));
    let Some(dict) = files::dict(root, path, sink)? else { return Ok(None) };
    Ok(Reader::new(&dict, sink).maybe_scalar(DEPTH, Dims::LENGTH))
}

fn corners(poly: &PolyMesh, face: usize) -> impl Iterator<Item = Vec3> + '_ {
    let range = poly.face_ptr[face] as usize..poly.face_ptr[face + 1] as usize;
    poly.face_points[range].iter().map(|&p| poly.points[p as usize])
}

fn frame_of(p: usize, gravity: Vec3, poly: &PolyMesh, mesh: &Mesh) -> Option<Frame> {
    let faces = mesh.patches[p].faces.clone();
    let (mut area, mut moment, mut whole) = ([0.0; 3], [0.0; 3], 0.0);
    for f in faces {
        area = add(area, mesh.area[f]);
        moment = add(moment, scale(mesh.face_centre[f], mesh.mag_area[f]));
        whole += mesh.mag_area[f];
    }
    let patch = &poly.patches[p];
    let points = (patch.start..patch.start + patch.len).flat_map(|f| corners(poly, f));
    match whole > 0.0 {
        true => Frame::new(gravity, area, scale(moment, 1.0 / whole), points),
        false => None,
    }
}

/// The share of a patch's area behind which there is water.
fn wet_share(p: usize, alpha: &[f64], mesh: &Mesh) -> f64 {
    let (mut wet, mut whole) = (0.0, 0.0);
    for f in mesh.patches[p].faces.clone() {
        wet += mesh.mag_area[f] * alpha[mesh.global_cell[mesh.owner[f] as usize] as usize];
        whole += mesh.mag_area[f];
    }
    wet / whole
}
