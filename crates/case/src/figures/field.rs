//! Fields of a time directory for figures: expressions of fields where they are known.

use super::expression::{self, ExpressionError};
use super::table::Table;
use crate::section::{Grid, Samples};
use crate::store::StoreError;
use crate::{CaseError, boundary, export, files, meshing};
use granflow_base::{Value, Vec3, dot, scale, sub, unit};
use granflow_dict::{Diag, Dict, Reader, Sink, nearest};
use granflow_mesh::PatchKind;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

/// The mesh of a case.
pub(super) fn grid(root: &Path, sink: &Sink) -> Result<Grid, CaseError> {
    let poly = meshing::load(root, sink)?.poly;
    if let Err(e) = poly.validate() {
        let path = root.join(meshing::POLY_MESH).display().to_string();
        sink.push(Diag::file(path, e.to_string()).help("`granflow check` says more"));
        return Err(CaseError::Invalid);
    }
    Ok(Grid::new(poly))
}

/// A case at one time.
pub(super) struct Scene<'a> {
    root: &'a Path,
    /// Name of the time directory.
    pub(super) time: &'a str,
    pub(super) grid: &'a Grid,
    /// Fields read so far: components.
    read: RefCell<BTreeMap<String, Option<Vec<Samples>>>>,
}

impl<'a> Scene<'a> {
    pub(super) fn new(root: &'a Path, time: &'a str, grid: &'a Grid) -> Scene<'a> {
        Scene { root, time, grid, read: RefCell::default() }
    }

    /// Values of an expression at the points of the mesh; `None` after a mistake, which is
    /// reported at `key`.
    pub(super) fn at_points(
        &self,
        r: &Reader<'_>,
        key: &str,
        text: &str,
    ) -> Result<Option<Vec<f64>>, CaseError> {
        Ok(self.samples(r, key, text)?.map(|s| self.grid.at_points(&s)))
    }

    /// Values of an expression in cells and on boundary faces.
    pub(super) fn samples(
        &self,
        r: &Reader<'_>,
        key: &str,
        text: &str,
    ) -> Result<Option<Samples>, CaseError> {
        // A mistake of form was reported when the dictionary was read.
        let Ok(names) = expression::names(text) else { return Ok(None) };
        let n = self.grid.n_samples();
        let (mut known, mut periodic) = (vec![true; n], true);
        let mut table = Table::default();
        for name in names {
            let Some(column) = self.column(&name, r.sink())? else {
                if name != "pi" {
                    self.unknown(r, key, &name)?;
                    return Ok(None);
                }
                continue;
            };
            known.iter_mut().zip(&column.known).for_each(|(a, b)| *a &= b);
            periodic &= column.periodic;
            table.names.push(name);
            table.columns.push(column.values);
        }
        if table.columns.is_empty() {
            // A number is a field, too.
            table.names.push("x".into());
            table.columns.push(vec![0.0; n]);
        }
        match expression::evaluate(text, &table) {
            Ok(values) => Ok(Some(Samples { values, known, periodic })),
            Err(e) => {
                r.error_at_key(key, format!("`{text}`: {e}"), "cannot be evaluated", None);
                Ok(None)
            }
        }
    }

    /// The length of a vector, or the size of a scalar.
    fn size(&self, name: &str, sink: &Sink) -> Result<Option<Samples>, CaseError> {
        let Some(parts) = self.field(name, sink)? else { return Ok(None) };
        let mut out = parts[0].clone();
        for (i, v) in out.values.iter_mut().enumerate() {
            *v = parts.iter().map(|p| p.values[i] * p.values[i]).sum::<f64>().sqrt();
        }
        Ok(Some(out))
    }

    fn column(&self, name: &str, sink: &Sink) -> Result<Option<Samples>, CaseError> {
        if let Some(all) = self.field(name, sink)?
            && let [only] = &all[..]
        {
            return Ok(Some(only.clone()));
        }
        if let Some(inside) = name.strip_prefix("mag(").and_then(|n| n.strip_suffix(')'))
            && let Some(size) = self.size(inside, sink)?
        {
            return Ok(Some(size));
        }
        let axis = |s: &str| ["x", "y", "z"].iter().position(|a| *a == s);
        if let Some(k) = axis(name) {
            let n = self.grid.n_samples();
            let values = (0..n).map(|s| self.grid.place(s)[k]).collect();
            return Ok(Some(Samples { values, known: vec![true; n], periodic: false }));
        }
        let Some((vector, k)) = name.rsplit_once('_').and_then(|(v, a)| Some((v, axis(a)?))) else {
            return Ok(None);
        };
        Ok(self.field(vector, sink)?.filter(|all| all.len() == 3).map(|mut all| all.swap_remove(k)))
    }

    /// An error about a name that is no field of this time.
    fn unknown(&self, r: &Reader<'_>, key: &str, name: &str) -> Result<(), CaseError> {
        let inside = name.strip_prefix("mag(").and_then(|n| n.strip_suffix(')'));
        let name = inside.unwrap_or(name);
        let mut there = Vec::new();
        for file in export::names_in(&self.root.join(self.time))? {
            match self.field(&file, r.sink())?.map_or(0, |all| all.len()) {
                1 => there.push(file),
                3 => there.extend(["x", "y", "z"].map(|a| format!("{file}_{a}"))),
                _ => {}
            }
        }
        let vector = there.contains(&format!("{name}_x"));
        let message = if vector {
            format!("`{name}` is a vector")
        } else {
            format!("there is no field `{name}` at the time {}", self.time)
        };
        let close = nearest(name, there.iter().map(String::as_str));
        let help = match close {
            _ if vector => format!("write {name}_x, {name}_y, {name}_z or \"mag({name})\""),
            Some(close) => format!("did you mean `{close}`? There are {}", there.join(", ")),
            None => format!("there are {}", there.join(", ")),
        };
        r.error_at_key(key, message, "not there", Some(&help));
        Ok(())
    }

    /// The components of a field, `None` when there is no such field of scalars or vectors.
    fn field(&self, name: &str, sink: &Sink) -> Result<Option<Vec<Samples>>, StoreError> {
        if let Some(found) = self.read.borrow().get(name) {
            return Ok(found.clone());
        }
        // What is no dictionary at all is somebody else's file.
        let aside = Sink::new();
        let found = match files::dict(self.root, Path::new(self.time).join(name), &aside)? {
            None => None,
            Some(dict) => {
                let class = dict.header().and_then(|h| h.word("class")).unwrap_or("");
                let found = match class {
                    "volScalarField" => Some(self.values::<f64>(&dict, &aside)),
                    "volVectorField" => Some(self.values::<Vec3>(&dict, &aside)),
                    _ => None,
                };
                if found.is_some() {
                    sink.extend(aside.take());
                }
                found
            }
        };
        let found = found.map(|mut all| {
            if name.starts_with("alpha.") {
                // What a fraction has beyond its bounds is rounding.
                all.iter_mut().flat_map(|s| &mut s.values).for_each(|v| *v = v.clamp(0.0, 1.0));
            }
            all
        });
        self.read.borrow_mut().insert(name.to_owned(), found.clone());
        Ok(found)
    }

    fn values<T: Mirrored>(&self, dict: &Dict, sink: &Sink) -> Vec<Samples> {
        let (grid, poly) = (self.grid, &self.grid.poly);
        let n = poly.n_cells();
        let r = Reader::new(dict, sink);
        let mut all: Vec<Option<T>> =
            r.field::<T>("internalField", n).into_vec(n).into_iter().map(Some).collect();
        all.resize(grid.n_samples(), None);
        let patches = dict.sub("boundaryField");
        for patch in &poly.patches {
            let entry = patches.and_then(|b| b.sub(&boundary::key_of(b, patch)?));
            let first = n + patch.start - poly.n_inner();
            let kind = entry.and_then(|e| e.word("type")).unwrap_or("");
            if patch.kind.coupled() || patch.kind == PatchKind::Empty {
                continue;
            }
            let mirror = matches!(patch.kind, PatchKind::Symmetry | PatchKind::SymmetryPlane);
            let given = entry
                .map(|e| Reader::new(e, sink))
                .and_then(|e| e.maybe_field::<T>("value", patch.len))
                .map(|v| v.into_vec(patch.len));
            for i in 0..patch.len {
                let face = patch.start + i;
                let cell = all[poly.owner[face] as usize].unwrap_or(T::ZERO);
                all[first + i] = match (&given, kind) {
                    _ if mirror || kind == "slip" => Some(cell.along(grid.geometry.area[face])),
                    (Some(v), _) => v.get(i).copied(),
                    (None, "noSlip") => Some(T::ZERO),
                    (None, "zeroGradient") => Some(cell),
                    _ => None,
                };
            }
        }
        let component = |k: usize| Samples {
            values: all
                .iter()
                .enumerate()
                .map(|(s, v)| {
                    let own = |face: usize| all[poly.owner[face] as usize];
                    // Where nothing is known, what the cell has; it does not count.
                    let v = v.or_else(|| own(s.checked_sub(n)? + poly.n_inner()));
                    v.map_or(0.0, |v| v.comp(k))
                })
                .collect(),
            known: all.iter().map(Option::is_some).collect(),
            periodic: true,
        };
        (0..T::N).map(component).collect()
    }
}

/// Values that a plane of symmetry mirrors.
trait Mirrored: Value {
    /// What is left of it along a face with the normal `n`.
    fn along(self, n: Vec3) -> Self;
}

impl Mirrored for f64 {
    fn along(self, _: Vec3) -> f64 {
        self
    }
}

impl Mirrored for Vec3 {
    fn along(self, n: Vec3) -> Vec3 {
        let n = unit(n);
        sub(self, scale(n, dot(self, n)))
    }
}

/// Reports a mistake in the form of an expression.
pub(super) fn check(r: &Reader<'_>, key: &str, text: &str) {
    // A missing one was reported.
    if text.is_empty() {
        return;
    }
    if let Err(e) = expression::check(text) {
        let e: ExpressionError = e;
        r.error_at_key(key, format!("`{key}`: {e}"), "cannot be evaluated", None);
    }
}
