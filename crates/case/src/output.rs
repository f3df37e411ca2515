//! Time directories and the tables of functions. Only rank 0 comes here.

use crate::boundary::of_kind;
use crate::fields::{Sheet, VolField};
use crate::functions::{Info, Whole, Written, field_file, remembered};
use crate::restart::Clock;
use crate::store::{Operation, StoreError, TimeWriter, write_atomic, write_whole};
use crate::worker::Sheets;
use crate::{Case, CaseError};
use granflow_base::{Dims, dot};
use granflow_dict::{Dict, Format, Header, Writer, number};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Folder of everything that functions write.
pub const POST: &str = "postProcessing";

/// Writes what functions return below `postProcessing`.
pub(crate) struct Tables {
    root: PathBuf,
    start: String,
    begun: BTreeSet<PathBuf>,
}

impl Tables {
    /// Tables of a run that begins at the time called `start`.
    pub(crate) fn new(case: &Path, start: &str) -> Tables {
        Tables { root: case.join(POST), start: start.into(), begun: BTreeSet::new() }
    }

    /// Puts what was `written` at the time called `time` into the function's `folder`.
    pub(crate) fn put(
        &mut self,
        folder: &str,
        time: &str,
        written: Vec<Written>,
    ) -> Result<(), StoreError> {
        for w in written {
            match w {
                Written::File { file, bytes } => {
                    write_whole(&self.root.join(folder).join(time).join(file), &bytes)?;
                }
                Written::Line { file, header, line } => {
                    let path = self.root.join(folder).join(&self.start).join(file);
                    // A table begins anew with the run: it belongs to its start time.
                    if self.begun.insert(path.clone()) {
                        write_atomic(&path, format!("{header}\n{line}\n").as_bytes())?;
                    } else {
                        append(&path, &format!("{line}\n"))?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn append(path: &Path, line: &str) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(Operation::Write, path, e);
    let mut file: File = OpenOptions::new().append(true).open(path).map_err(fail)?;
    let end = file.metadata().map_err(fail)?.len();
    file.write_all(line.as_bytes()).map_err(|e| {
        // Never half a line.
        let _ = file.set_len(end);
        fail(e)
    })
}

/// What functions add to a time directory.
#[derive(Default)]
pub(crate) struct MadeFields {
    /// Their fields.
    pub(crate) fields: Vec<(Info, Whole)>,
    /// What a restart must know of them.
    pub(crate) memories: Vec<remembered::Memory>,
}

/// Writes the time directory `name`, whole or not at all.
pub(crate) fn write_time(
    case: &Case,
    name: &str,
    clock: &Clock,
    s: &Sheets,
    made: &MadeFields,
) -> Result<(), CaseError> {
    let (control, entries, k) = (&case.config.control, &case.start, case.pressure_factor());
    let mut dir = TimeWriter::begin(&case.root, name)?.compressed(control.compression);
    let sheet = |field, dims| Sheet {
        name: field,
        time: name,
        dims,
        format: control.format,
        poly: &case.poly,
    };
    let per = |v: &[f64]| v.iter().map(|p| p / k).collect::<Vec<f64>>();
    let dictated: Vec<Dict> = case.poly.patches.iter().map(|p| of_kind(&p.kind)).collect();

    let u = sheet("U", Dims::VELOCITY).vol(&s.u, &entries.u.boundary, Some(&s.u_faces));
    dir.file("U", &u)?;
    if let Some(u_old) = &s.u_old {
        dir.file("U_0", &sheet("U_0", Dims::VELOCITY).vol(u_old, &entries.u.boundary, None))?;
    }
    let pressure = case.config.pressure();
    let (p, p_faces) = (per(&s.p), per(&s.p_faces));
    let text = sheet(pressure, entries.p.dims).vol(&p, &entries.p.boundary, Some(&p_faces));
    dir.file(pressure, &text)?;
    dir.file("phi", &sheet("phi", Dims::VOLUME_FLUX).surface(&s.phi))?;
    if let Some(phi_old) = &s.phi_old {
        dir.file("phi_0", &sheet("phi_0", Dims::VOLUME_FLUX).surface(phi_old))?;
    }
    if let (Some(a), Some(field)) = (&s.alpha, &entries.alpha) {
        let text = sheet(&field.name, Dims::NONE).vol(a, &field.boundary, Some(&s.alpha_faces));
        dir.file(&field.name, &text)?;
    }
    if let Some(g) = &s.fluidity {
        let faces = owner_values(case, g);
        let text = sheet("fluidity", Dims::RATE).vol(g, &entries.fluidity.boundary, Some(&faces));
        dir.file("fluidity", &text)?;
    }
    if let (Some(total), "p_rgh") = (&s.total, pressure) {
        let faces = per(&total_on_faces(case, s));
        let calculated: Vec<Dict> = dictated.iter().map(calculated).collect();
        let text = sheet("p", entries.p.dims).vol(&per(total), &calculated, Some(&faces));
        dir.file("p", &text)?;
    }
    let mut derived = |field, dims, values: &[f64]| {
        dir.file(field, &sheet(field, dims).vol(values, &dictated, None))
    };
    if let (Some(rate), Some(eta), Some(p)) = (&s.strain_rate, &s.viscosity, &s.pressure) {
        derived("strainRate", Dims::RATE, rate)?;
        derived("viscosity", Dims::VISCOSITY, eta)?;
        if let Some(grains) = case.config.transport.grains {
            // Nothing is said of a fluid beside the grains.
            let here = |c: usize| s.alpha.as_ref().is_none_or(|a| a[c] > 0.5);
            let of = |c: usize, value: f64| if here(c) { value } else { 0.0 };
            let ratio = |c: usize| of(c, rate[c] * eta[c] / p[c].max(grains.loose()));
            let ratios: Vec<f64> = (0..p.len()).map(ratio).collect();
            derived("stressRatio", Dims::NONE, &ratios)?;
            let number = |c: usize| of(c, grains.inertial_number(rate[c], p[c]));
            let numbers: Vec<f64> = (0..p.len()).map(number).collect();
            derived("inertialNumber", Dims::NONE, &numbers)?;
        }
    }
    for (info, whole) in &made.fields {
        let dims = info.unit.dims(entries.p.dims);
        dir.file(&info.name, &field_file(info, dims, whole, &sheet(&info.name, dims)))?;
    }
    if !made.memories.is_empty() {
        dir.file_plain(remembered::PROPERTIES, &remembered::properties(name, &made.memories))?;
    }
    dir.file_plain("uniform/time", &clock.text(name))?;
    let held = case.sources.iter().filter_map(|s| s.held()).map(|m| &m.name);
    for (source, gradient) in held.zip(&s.gradients) {
        let file = format!("{source}Properties");
        let header = Header::new("dictionary", &file).location(format!("{name}/uniform"));
        let mut w = Writer::new(&header.format(Format::Ascii));
        w.entry("gradient", number(*gradient));
        dir.file_plain(format!("uniform/{file}"), &w.finish())?;
    }
    if let Some((file, text)) = crate::frames::sheet(&case.sources, name, clock.time) {
        dir.file_plain(file, &text)?;
    }
    for (file, text) in case.waves.sheets(&case.poly, name) {
        dir.file_plain(format!("uniform/{file}"), &text)?;
    }
    dir.commit()?;
    Ok(())
}

/// Writes the fields that were set into the directory they came from.
pub(crate) fn write_set_fields(case: &Case) -> Result<(), CaseError> {
    if case.fields_set.is_empty() {
        return Ok(());
    }
    let (control, start) = (&case.config.control, &case.start);
    let mut dir =
        TimeWriter::begin(&case.root, &start.dir)?.keep_existing()?.compressed(control.compression);
    for name in &case.fields_set {
        let sheet =
            |dims| Sheet { name, time: &start.dir, dims, format: control.format, poly: &case.poly };
        let scalar = |f: &VolField<f64>| {
            let faces = owner_values(case, &f.cells);
            sheet(f.dims).vol(&f.cells, &f.boundary, Some(&faces))
        };
        let text = match &start.alpha {
            Some(alpha) if alpha.name == *name => scalar(alpha),
            _ if start.p.name == *name => scalar(&start.p),
            _ => sheet(start.u.dims).vol(&start.u.cells, &start.u.boundary, None),
        };
        dir.file(name, &text)?;
    }
    dir.commit()?;
    Ok(())
}

/// On every face the value of its owner.
fn owner_values(case: &Case, cells: &[f64]) -> Vec<f64> {
    case.poly.owner.iter().map(|&c| cells[c as usize]).collect()
}

/// p on boundary faces from p_rgh there.
fn total_on_faces(case: &Case, s: &Sheets) -> Vec<f64> {
    let (mesh, mut out) = (&case.mesh, s.p_faces.clone());
    let transport = &case.config.transport;
    let rho = |face: usize| match &transport.second {
        Some(second) => {
            let a = s.alpha_faces[face].clamp(0.0, 1.0);
            a * transport.rho + (1.0 - a) * second.transport.rho
        }
        None => transport.rho,
    };
    for f in mesh.n_inner..mesh.n_faces() {
        let face = (mesh.poly_face[f] >> 1) as usize;
        out[face] += rho(face) * dot(case.gravity.hydrostatic, mesh.face_centre[f]);
    }
    out
}

fn calculated(dictated: &Dict) -> Dict {
    let mut d = dictated.clone();
    if d.word("type") == Some("zeroGradient") {
        d.set("type", "calculated");
    }
    d
}
