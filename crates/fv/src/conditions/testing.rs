//! A patch of four faces for tests of conditions: `xMin` of the unit box, two by two faces of
//! 1/4 m2 with one cell behind each, whose centre lies 0.5 m away. The outward normal is (-1 0 0).

use super::{CaseContext, Condition, Fault, PatchContext, Surroundings, ZeroGradient};
use super::{read_scalar, read_vector};
use crate::{Differentiable, FaceField, Unknown};
use granflow_base::{Dims, Vec3};
use granflow_dict::{Diags, Reader, Sink, parse_str};
use granflow_mesh::{Mesh, PatchKind, shapes};
use granflow_par::Exec;

/// Values that conditions are read for.
pub(crate) trait Read: Differentiable {
    fn read(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Self>>;
}
impl Read for f64 {
    fn read(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Self>> {
        read_scalar(r, c)
    }
}
impl Read for Vec3 {
    fn read(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Self>> {
        read_vector(r, c)
    }
}

/// What is wrong with the condition `text`.
pub(crate) fn mistakes<T: Read>(text: &str) -> Diags {
    mistakes_within::<T>(text, CaseContext::NONE)
}
/// The same in a case.
pub(crate) fn mistakes_within<T: Read>(text: &str, case: CaseContext<'_>) -> Diags {
    read_with::<T>(text, case, 1.0).1
}

fn read_with<T: Read>(
    text: &str,
    case: CaseContext<'_>,
    factor: f64,
) -> (Box<dyn Condition<T>>, Diags) {
    let (dict, diags) = parse_str(text);
    assert!(diags.is_empty(), "{diags:?}");
    let sink = Sink::new();
    let r = Reader::new(&dict, &sink);
    let context = PatchContext {
        patch: "inlet",
        kind: &PatchKind::Patch,
        n_faces: 4,
        n_inner: Mesh::new(&shapes::unit_box([1, 2, 2])).unwrap().n_inner,
        field: "f",
        dims: Dims::NONE,
        factor,
        case,
        wave: None,
    };
    let condition = T::read(&r, &context);
    r.finish(granflow_dict::Severity::Error);
    (condition, sink.take())
}

/// A condition on the patch and what surrounds it.
pub(crate) struct Probe<'a, T> {
    condition: Box<dyn Condition<T>>,
    flux: Option<[f64; 4]>,
    around: Surroundings<'a>,
    face_velocity: Vec<Vec3>,
    density: Vec<f64>,
    face_fraction: Vec<f64>,
}

impl Probe<'_, ()> {
    /// Of the condition `text`, which must be right.
    pub(crate) fn of<'a, T: Read>(text: &str) -> Probe<'a, T> {
        Self::within(text, CaseContext::NONE)
    }
    /// The same in a case.
    pub(crate) fn within<'a, T: Read>(text: &str, case: CaseContext<'_>) -> Probe<'a, T> {
        let (condition, mistakes) = read_with::<T>(text, case, 1.0);
        assert!(mistakes.is_empty(), "{mistakes}");
        Probe {
            condition,
            flux: None,
            around: Surroundings::default(),
            face_velocity: Vec::new(),
            density: Vec::new(),
            face_fraction: Vec::new(),
        }
    }
}

impl<T: Read> Probe<'_, T> {
    pub(crate) fn at(mut self, time: f64) -> Self {
        self.around.time = time;
        self
    }
    pub(crate) fn flux(mut self, flux: [f64; 4]) -> Self {
        self.flux = Some(flux);
        self
    }
    pub(crate) fn gravity(mut self, g: Vec3) -> Self {
        self.around.gravity = g;
        self
    }
    pub(crate) fn velocity(mut self, u: [Vec3; 4]) -> Self {
        self.face_velocity = u.to_vec();
        self
    }
    pub(crate) fn density(mut self, rho: [f64; 4]) -> Self {
        self.density = rho.to_vec();
        self
    }
    pub(crate) fn fraction(mut self, alpha: [f64; 4]) -> Self {
        self.face_fraction = alpha.to_vec();
        self
    }
    /// The condition as it was read.
    pub(crate) fn condition(&self) -> &dyn Condition<T> {
        &*self.condition
    }
    /// What the patch's faces get from these values in the cells behind them.
    pub(crate) fn values(self, cells: [T; 4]) -> [T; 4] {
        self.updated(cells).0
    }
    /// What an update with these values in the cells finds at fault.
    pub(crate) fn fault(self, cells: [T; 4]) -> Option<Fault> {
        self.updated(cells).1
    }
    fn updated(self, cells: [T; 4]) -> ([T; 4], Option<Fault>) {
        let mesh = Mesh::new(&shapes::unit_box([1, 2, 2])).unwrap();
        let patch = mesh.patches[0].faces.clone();
        assert_eq!(patch.len(), 4);
        let mut conditions = vec![self.condition];
        conditions.extend((1..mesh.patches.len()).map(|_| Box::new(ZeroGradient) as _));
        let mut field = Unknown::new(&mesh, "f", Dims::NONE, T::ZERO, conditions);
        let mut flux = FaceField::new(&mesh, "phi", Dims::VOLUME_FLUX, 0.0);
        let n_boundary = mesh.n_faces() - mesh.n_inner;
        let first = patch.start - mesh.n_inner;
        // Everything given of the patch, over all faces or cells.
        let spread = |given: &[f64], n: usize, place: &dyn Fn(usize) -> usize| {
            let mut out = vec![0.0; if given.is_empty() { 0 } else { n }];
            given.iter().enumerate().for_each(|(i, v)| out[place(i)] = *v);
            out
        };
        let owner = |i: usize| mesh.owner[patch.start + i] as usize;
        let density = spread(&self.density, mesh.n_cells, &owner);
        let face_fraction = spread(&self.face_fraction, n_boundary, &|i| first + i);
        let mut face_velocity = Vec::new();
        if !self.face_velocity.is_empty() {
            face_velocity = vec![[0.0; 3]; n_boundary];
            face_velocity[first..first + 4].copy_from_slice(&self.face_velocity);
        }
        for (i, v) in cells.into_iter().enumerate() {
            field.cells.data[owner(i)] = v;
            flux.data[patch.start + i] = self.flux.map_or(0.0, |f| f[i]);
        }
        let around = Surroundings {
            density: &density,
            face_fraction: &face_fraction,
            face_velocity: &face_velocity,
            ..self.around
        };
        let flux = self.flux.is_some().then_some(&flux);
        field.update(&Exec::serial(), &mesh, &around, flux);
        let values = std::array::from_fn(|i| field.boundary_value(&mesh, patch.start + i));
        (values, field.conditions[0].fault().cloned())
    }
}
