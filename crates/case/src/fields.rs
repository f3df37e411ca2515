//! Field files: values in the user's numbering, in the file's units.

use crate::boundary::{FieldType, of_kind, resolve};
use crate::files;
use crate::store::StoreError;
use granflow_base::Dims;
use granflow_dict::{Diag, Dict, Format, Header, Reader, Severity, Sink, Writer};
use granflow_fv::conditions::CaseContext;
use granflow_mesh::{PatchKind, PolyMesh};
use std::path::Path;

/// A field on cells with the entries of its patches.
#[derive(Clone, Debug)]
pub struct VolField<T> {
    /// Name.
    pub name: String,
    /// Dimensions of the file.
    pub dims: Dims,
    /// Cell values.
    pub cells: Vec<T>,
    /// The entry of every patch as the user wrote it.
    pub boundary: Vec<Dict>,
}

impl<T: FieldType> VolField<T> {
    /// A uniform field with the conditions that patches dictate and zero gradient elsewhere.
    pub fn uniform(name: &str, dims: Dims, v: T, poly: &PolyMesh) -> Self {
        VolField {
            name: name.into(),
            dims,
            cells: vec![v; poly.n_cells()],
            boundary: poly.patches.iter().map(|p| of_kind(&p.kind)).collect(),
        }
    }
}

/// Reads `time/name`, `None` when there is no such file. Mistakes go to the sink.
///
/// # Errors
/// The file is there and cannot be read.
pub fn read_vol<T: FieldType>(
    root: &Path,
    time: &str,
    name: &str,
    accept: &[Dims],
    (poly, case): (&PolyMesh, CaseContext<'_>),
    sink: &Sink,
) -> Result<Option<VolField<T>>, StoreError> {
    let Some(dict) = files::dict(root, Path::new(time).join(name), sink)? else { return Ok(None) };
    check_class(&dict, T::CLASS, name, sink);
    let r = Reader::new(&dict, sink);
    let dims = r.dims("dimensions");
    check_dims(&r, name, dims, accept);
    let n = poly.n_cells();
    let before = sink.n_errors();
    let cells = r.field::<T>("internalField", n).into_vec(n);
    if sink.n_errors() == before
        && let Some(c) = cells.iter().position(|v| !v.is_finite())
    {
        let message = format!("field `{name}` is not finite in cell {c}");
        r.error_at(&r.key_span("internalField"), message, "holds nan or inf", None);
    }
    let boundary = match r.sub("boundaryField") {
        Some(sub) => resolve::<T>(&sub, plain(name), dims, poly, case),
        None => Vec::new(),
    };
    r.finish(Severity::Warning);
    Ok(Some(VolField { name: name.into(), dims, cells, boundary }))
}

/// The name of the field whose conditions a file holds: an earlier time or the original of it has
/// the same.
fn plain(name: &str) -> &str {
    name.strip_suffix("_0").or_else(|| name.strip_suffix(".orig")).unwrap_or(name)
}

fn check_class(dict: &Dict, class: &str, name: &str, sink: &Sink) {
    let Some(header) = dict.header() else { return };
    if let Some(found) = header.word("class")
        && found != class
    {
        let r = Reader::new(header, sink);
        let message = format!("field `{name}` must be a {class}, found a {found}");
        r.error_at_key("class", message, "wrong class", Some(&format!("write `class {class};`")));
    }
}

fn check_dims(r: &Reader<'_>, name: &str, found: Dims, accept: &[Dims]) {
    if accept.contains(&found) || !r.has("dimensions") {
        return;
    }
    let known: Vec<String> = accept.iter().map(Dims::to_string).collect();
    let expected = known.join(" or ");
    let message =
        format!("field `{name}` has the wrong dimensions: expected {expected}, found {found}");
    r.error_at_key("dimensions", message, format!("expected {expected}"), None);
}

/// Reads a `surfaceScalarField` on all faces of the mesh (zero on empty patches), `None` when
/// there is no such file.
///
/// # Errors
/// The file is there and cannot be read.
pub fn read_surface(
    root: &Path,
    time: &str,
    name: &str,
    dims: Dims,
    poly: &PolyMesh,
    sink: &Sink,
) -> Result<Option<Vec<f64>>, StoreError> {
    let Some(dict) = files::dict(root, Path::new(time).join(name), sink)? else { return Ok(None) };
    check_class(&dict, "surfaceScalarField", name, sink);
    let r = Reader::new(&dict, sink);
    check_dims(&r, name, r.dims("dimensions"), &[dims]);
    r.ignore("oriented");
    let mut faces = r.field::<f64>("internalField", poly.n_inner()).into_vec(poly.n_inner());
    faces.resize(poly.n_faces(), 0.0);
    if let Some(boundary) = r.sub("boundaryField") {
        for p in poly.patches.iter().filter(|p| p.kind != PatchKind::Empty && p.len > 0) {
            let Some(sub) = boundary.opt_sub(&p.name) else {
                let message = format!("field `{name}` has no values for patch `{}`", p.name);
                let help = "remove the file: it is computed from U";
                boundary.error_here(message, "not found before this brace", Some(help));
                continue;
            };
            sub.ignore("type");
            let values = sub.field::<f64>("value", p.len).into_vec(p.len);
            faces[p.faces()].copy_from_slice(&values);
        }
        boundary.ignore_all();
    }
    r.finish(Severity::Warning);
    if let Some(f) = faces.iter().position(|v| !v.is_finite()) {
        sink.push(Diag::file(
            root.join(time).join(name).display().to_string(),
            format!("field `{name}` is not finite on face {f}"),
        ));
    }
    Ok(Some(faces))
}

/// What a field file is made of.
pub struct Sheet<'a> {
    /// Name of the field.
    pub name: &'a str,
    /// Time directory it is for.
    pub time: &'a str,
    /// Its dimensions.
    pub dims: Dims,
    /// Ascii or binary.
    pub format: Format,
    /// The mesh in the user's numbering.
    pub poly: &'a PolyMesh,
}

impl Sheet<'_> {
    fn header(&self, class: &str) -> Header {
        Header::new(class, self.name).location(self.time).format(self.format)
    }

    /// A field on cells: `boundary` are the entries of the patches, `faces` the values on all
    /// faces of the mesh, from which the `value` entries come.
    pub fn vol<T: FieldType>(
        &self,
        cells: &[T],
        boundary: &[Dict],
        faces: Option<&[T]>,
    ) -> Vec<u8> {
        let mut w = Writer::new(&self.header(T::CLASS));
        w.dims("dimensions", self.dims);
        w.blank();
        w.field("internalField", cells);
        w.blank();
        w.open("boundaryField");
        for (p, entry) in self.poly.patches.iter().zip(boundary) {
            w.open(&p.name);
            let mut given = entry.clone();
            let dictated = !matches!(p.kind, PatchKind::Patch | PatchKind::Wall);
            // `value` is what the user asked for in fixedValue, and an outcome elsewhere.
            let evaluated = given.word("type") != Some("fixedValue");
            if evaluated {
                given.remove("value");
            }
            w.dict(&given);
            if let (true, false, Some(faces)) = (evaluated, dictated, faces)
                && p.len > 0
            {
                w.field("value", &faces[p.faces()]);
            }
            w.close();
        }
        w.close();
        w.finish()
    }

    /// A field on faces, oriented as the mesh's faces are.
    pub fn surface(&self, faces: &[f64]) -> Vec<u8> {
        let mut w = Writer::new(&self.header("surfaceScalarField"));
        w.dims("dimensions", self.dims);
        w.blank();
        w.entry("oriented", "oriented");
        w.blank();
        w.field("internalField", &faces[..self.poly.n_inner()]);
        w.blank();
        w.open("boundaryField");
        for p in &self.poly.patches {
            w.open(&p.name);
            let kind = match p.kind {
                PatchKind::Patch | PatchKind::Wall => "calculated",
                ref other => other.word(),
            };
            w.entry("type", kind);
            if p.kind == PatchKind::Empty || p.len == 0 {
                w.entry("value", "nonuniform List<scalar> 0()");
            } else {
                w.field("value", &faces[p.faces()]);
            }
            w.close();
        }
        w.close();
        w.finish()
    }
}
