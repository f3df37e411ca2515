//! `system/setAlphaFieldDict` and `system/setFieldsDict`: the fields that a case starts from.
//!
//! They act in this order, and on fields that are uniform as yet: what has been set before, by this
//! program or by OpenFOAM's tools, is taken as it is. Shapes fill cells exactly; regions take the
//! cells whose centres they hold.

use crate::fields::VolField;
use crate::files;
use crate::restart::WholeState;
use crate::store::StoreError;
use crate::{Case, CaseError, Notices, Options};
use granflow_base::{Dims, Value, Vec3, dot, norm, scale, sub, unit};
use granflow_dict::{Reader, Severity, Sink, TokenReader};
use granflow_flow::vof::{Body, Corners, Shape, fill};
use granflow_mesh::{Mesh, PolyMesh};
use granflow_par::Exec;
use std::path::Path;

/// By region.
pub const SET_FIELDS: &str = "system/setFieldsDict";
/// By shape.
pub const SET_ALPHA: &str = "system/setAlphaFieldDict";

/// Whether the case has either.
pub fn present(root: &Path) -> bool {
    files::exists(root, SET_FIELDS) || files::exists(root, SET_ALPHA)
}

/// Does what the dictionaries say to the fields of `state` that are uniform, and returns the names
/// of those that were set. Mistakes go to the sink.
///
/// # Errors
/// A file is there and cannot be read.
pub(crate) fn apply(
    root: &Path,
    poly: &PolyMesh,
    mesh: &Mesh,
    state: &mut WholeState,
    sink: &Sink,
    notices: &Notices,
) -> Result<Vec<String>, StoreError> {
    let mut target = Target { mesh, state, done: Vec::new(), fresh: Vec::new() };
    target.fresh = target.uniform();
    if let Some(dict) = files::dict(root, SET_ALPHA, sink)? {
        set_alpha(&Reader::new(&dict, sink), poly, &mut target);
    }
    if let Some(dict) = files::dict(root, SET_FIELDS, sink)? {
        set_regions(&Reader::new(&dict, sink), &mut target, notices);
    }
    Ok(target.done)
}

/// Sets the fields of the time that the case starts from, on the disk; returns their names.
///
/// # Errors
/// The case has mistakes (see the sink), or the disk refuses.
pub fn write(root: &Path, sink: &Sink, notices: &Notices) -> Result<Vec<String>, CaseError> {
    let case = Case::load(root, &Options::default(), sink, notices)?;
    crate::output::write_set_fields(&case)?;
    Ok(case.fields_set)
}

struct Target<'a> {
    mesh: &'a Mesh,
    state: &'a mut WholeState,
    /// Fields that were uniform.
    fresh: Vec<String>,
    done: Vec<String>,
}

impl Target<'_> {
    fn uniform(&self) -> Vec<String> {
        fn same<T: PartialEq>(f: &VolField<T>) -> Option<String> {
            f.cells.windows(2).all(|w| w[0] == w[1]).then(|| f.name.clone())
        }
        let s = &self.state;
        let all = [s.alpha.as_ref().and_then(same), same(&s.p), same(&s.u)];
        all.into_iter().flatten().collect()
    }
    fn note(&mut self, name: &str) {
        if !self.done.iter().any(|d| d == name) {
            self.done.push(name.to_owned());
        }
    }
    fn scalar(&mut self, name: &str) -> Option<&mut VolField<f64>> {
        let s = &mut *self.state;
        [s.alpha.as_mut(), Some(&mut s.p)].into_iter().flatten().find(|f| f.name == name)
    }
}

/// `field`, `type` and what the shape needs.
fn set_alpha(r: &Reader<'_>, poly: &PolyMesh, target: &mut Target<'_>) {
    let field = r.string("field").to_owned();
    #[derive(Clone, Copy)]
    enum Kind {
        Sphere,
        Cylinder,
        Plane,
        Sin,
    }
    let kinds = [
        ("sphere", Kind::Sphere),
        ("cylinder", Kind::Cylinder),
        ("plane", Kind::Plane),
        ("sin", Kind::Sin),
    ];
    let kind = r.one_of("type", &kinds);
    let origin = r.vector("origin", Dims::LENGTH);
    let mesh = target.mesh;
    let corners = Corners::new(poly, mesh);
    let mut alpha = vec![0.0; mesh.n_all()];
    let filled = |shape: Shape, alpha: &mut [f64]| {
        fill(&Exec::serial(), mesh, &corners, &shape, alpha);
    };
    match kind {
        Kind::Sphere => {
            filled(Shape::sphere(origin, r.positive("radius", Dims::LENGTH)), &mut alpha)
        }
        Kind::Cylinder => {
            let axis = direction(r, "direction");
            let radius = r.positive("radius", Dims::LENGTH);
            filled(Shape::cylinder(origin, axis, radius), &mut alpha);
        }
        // The half space that the normal points into is full.
        Kind::Plane => {
            let normal = direction(r, if r.has("normal") { "normal" } else { "direction" });
            filled(Shape::half_space(scale(normal, -1.0), origin), &mut alpha);
        }
        Kind::Sin => {
            let (along, up) = (direction(r, "direction"), direction(r, "up"));
            let wave = std::f64::consts::TAU / r.positive("period", Dims::LENGTH);
            let phase = r.opt_scalar("phase", Dims::NONE, 0.0);
            let amplitude =
                r.scalar("amplitude", Dims::LENGTH) * r.opt_scalar("scale", Dims::NONE, 1.0);
            let height = |x: Vec3| {
                let x = sub(x, origin);
                dot(x, up) - amplitude * (wave * dot(x, along) + phase).sin()
            };
            below(mesh, &corners, height, &mut alpha);
        }
    }
    let invert = r.opt_switch("invert", false);
    r.finish(Severity::Warning);
    if r.sink().has_errors() {
        return;
    }
    if !target.fresh.contains(&field) {
        return;
    }
    let global = &mesh.global_cell;
    let Some(f) = target.scalar(&field) else {
        let help = "the field is `alpha.<first phase>`";
        return r.error_at_key("field", format!("no field `{field}`"), "not known", Some(help));
    };
    for (c, &user) in global.iter().enumerate() {
        f.cells[user as usize] = if invert { 1.0 - alpha[c] } else { alpha[c] };
    }
    target.note(&field);
}

/// A vector that is not null, as a unit vector.
fn direction(r: &Reader<'_>, key: &str) -> Vec3 {
    let v = r.vector(key, Dims::NONE);
    if norm(v) == 0.0 {
        r.error_at_key(key, format!("`{key}` has no direction"), "zero vector", None);
    }
    unit(v)
}

/// The share of each cell where `height`, linear along edges, is negative.
fn below(mesh: &Mesh, corners: &Corners, height: impl Fn(Vec3) -> f64, alpha: &mut [f64]) {
    let (mut body, mut values) = (Body::default(), Vec::new());
    for (c, a) in alpha[..mesh.n_cells].iter_mut().enumerate() {
        body.load(corners, mesh, c);
        values.clear();
        let at = body.origin();
        values.extend(body.points().iter().map(|&x| height(granflow_base::add(x, at))));
        let wet = values.iter().filter(|h| **h < 0.0).count();
        *a = if wet == 0 {
            0.0
        } else if wet == values.len() {
            1.0
        } else {
            (body.volume_below(0.0, &values, None) / body.volume()).clamp(0.0, 1.0)
        };
    }
}

/// `defaultFieldValues` and `regions`.
fn set_regions(r: &Reader<'_>, target: &mut Target<'_>, notices: &Notices) {
    if let Some(mut list) = r.maybe_list("defaultFieldValues") {
        let all: Vec<usize> = (0..target.mesh.n_cells).collect();
        set_values(&mut list, &all, target, notices);
    }
    if let Some(mut list) = r.list("regions") {
        while !list.is_empty() {
            let at = list.here();
            let kind = list.word("the kind of region");
            let Some(region) = list.dict("the region") else { break };
            let Some(cells) = cells_of(kind, &region, target.mesh) else {
                let names: Vec<&str> = REGIONS.iter().map(|k| k.0).collect();
                let near = granflow_dict::nearest(kind, names.iter().copied());
                let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
                let help = format!("{near}known are {}", names.join(", "));
                list.error_at(&at, format!("unknown region `{kind}`"), "not known", Some(&help));
                region.ignore_all();
                continue;
            };
            if let Some(mut values) = region.list("fieldValues") {
                set_values(&mut values, &cells, target, notices);
            }
            region.finish(Severity::Warning);
        }
    }
    r.finish(Severity::Warning);
}

/// Names of all kinds of region.
pub(crate) fn region_names() -> impl Iterator<Item = &'static str> {
    REGIONS.iter().map(|r| r.0)
}

pub(crate) type Inside = Box<dyn Fn(Vec3) -> bool>;
/// A kind of region: its name, and how it is read.
type Region = (&'static str, fn(&Reader<'_>) -> Inside);

/// Regions by name: each reads its dictionary and says what lies inside.
const REGIONS: &[Region] =
    &[("boxToCell", in_box), ("sphereToCell", in_sphere), ("cylinderToCell", in_cylinder)];

/// The cells whose centres a region holds, in the numbering of `mesh`; none for an unknown kind.
pub(crate) fn cells_of(kind: &str, r: &Reader<'_>, mesh: &Mesh) -> Option<Vec<usize>> {
    let (_, read) = REGIONS.iter().find(|k| k.0 == kind)?;
    let inside = read(r);
    Some((0..mesh.n_cells).filter(|&c| inside(mesh.cell_centre[c])).collect())
}

pub(crate) fn in_box(r: &Reader<'_>) -> Inside {
    let mut boxes = Vec::new();
    let mut corner_pair = |list: &mut TokenReader<'_>| {
        let lo = list.vector("the lower corner");
        boxes.push((lo, list.vector("the upper corner")));
    };
    if r.has("boxes") {
        if let Some(mut list) = r.list("boxes") {
            while !list.is_empty() {
                corner_pair(&mut list);
            }
        }
    } else if let Some(mut list) = r.tokens("box") {
        corner_pair(&mut list);
    }
    Box::new(move |x| boxes.iter().any(|(lo, hi)| (0..3).all(|k| lo[k] <= x[k] && x[k] <= hi[k])))
}

fn in_sphere(r: &Reader<'_>) -> Inside {
    let key = if r.has("origin") { "origin" } else { "centre" };
    let (centre, radius) = (r.vector(key, Dims::LENGTH), r.positive("radius", Dims::LENGTH));
    Box::new(move |x| norm(sub(x, centre)) <= radius)
}

fn in_cylinder(r: &Reader<'_>) -> Inside {
    let key = |new, old| if r.has(new) { new } else { old };
    let a = r.vector(key("point1", "p1"), Dims::LENGTH);
    let b = r.vector(key("point2", "p2"), Dims::LENGTH);
    let radius = r.positive("radius", Dims::LENGTH);
    let axis = sub(b, a);
    Box::new(move |x| {
        let along = dot(sub(x, a), axis) / dot(axis, axis);
        let off = sub(sub(x, a), scale(axis, along));
        (0.0..=1.0).contains(&along) && norm(off) <= radius
    })
}

/// `volScalarFieldValue name value` and `volVectorFieldValue name (x y z)`.
fn set_values(
    list: &mut TokenReader<'_>,
    cells: &[usize],
    target: &mut Target<'_>,
    notices: &Notices,
) {
    while !list.is_empty() {
        let kinds = [("volScalarFieldValue", false), ("volVectorFieldValue", true)];
        let Some(vector) = list.one_of("the kind of value", &kinds) else { return };
        let name = list.word("the field").to_owned();
        if vector {
            let v = list.vector("the value");
            let Target { mesh, state, fresh, .. } = target;
            if name == "U" && fresh.contains(&name) {
                put(&mut state.u, mesh, cells, v);
                target.note(&name);
            } else if name != "U" {
                notices.say(format!("setFieldsDict: the field `{name}` is not used"));
            }
            continue;
        }
        let v = list.number("the value");
        if !target.fresh.contains(&name) {
            if target.scalar(&name).is_none() {
                notices.say(format!("setFieldsDict: the field `{name}` is not used"));
            }
            continue;
        }
        let mesh = target.mesh;
        if let Some(field) = target.scalar(&name) {
            put(field, mesh, cells, v);
        }
        target.note(&name);
    }
}

fn put<T: Value>(field: &mut VolField<T>, mesh: &Mesh, cells: &[usize], v: T) {
    for &c in cells {
        field.cells[mesh.global_cell[c] as usize] = v;
    }
}
