//! The faces of a zone, each with the direction the zone gives it.

use super::field::{Components, components};
use super::whole::Everywhere;
use super::{Around, View};
use crate::zones::ZoneFace;
use granflow_dict::{Dict, Reader, Sink};
use granflow_mesh::Mesh;

/// A zone of faces by its name.
#[derive(Clone)]
pub(super) struct FaceZonePlan {
    /// The function's dictionary, for complaints once the mesh is known.
    dict: Dict,
    name: String,
    /// Its faces in the user's numbering.
    faces: Vec<ZoneFace>,
}

/// A face of the whole mesh with its side.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// Its number in the user's mesh.
    user: usize,
    /// And in the numerics' view of the whole mesh.
    own: usize,
    /// 1 where the zone's normal is that of the numerics' face, else -1.
    sign: f64,
    /// The same against the user's face.
    user_sign: f64,
}

impl FaceZonePlan {
    /// Reads `name`.
    pub(super) fn read(r: &Reader<'_>) -> FaceZonePlan {
        FaceZonePlan { dict: r.dict().clone(), name: r.word("name").to_owned(), faces: Vec::new() }
    }
    /// Finds its faces; faces of empty patches do not count.
    pub(super) fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        if self.name.is_empty() {
            return;
        }
        let r = Reader::new(&self.dict, sink);
        self.faces = around.zones.expect_faces(&r, "name", &self.name);
    }
    /// Whether faces between cells are among them.
    pub(super) fn inside(&self, n_inner: usize) -> bool {
        self.faces.iter().any(|f| (f.0 as usize) < n_inner)
    }
    /// Its faces in the numerics' view of the whole mesh.
    pub(super) fn sides(&self, mesh: &Mesh) -> Vec<Side> {
        let mut at =
            vec![None; mesh.poly_face.iter().map(|e| (*e >> 1) as usize + 1).max().unwrap_or(0)];
        for (own, e) in mesh.poly_face.iter().enumerate() {
            at[(e >> 1) as usize] = Some((own, e & 1 == 1));
        }
        let side = |(user, against): &ZoneFace| {
            let (own, turned) = at.get(*user as usize).copied().flatten()?;
            let sign = |minus: bool| if minus { -1.0 } else { 1.0 };
            let user_sign = sign(*against);
            Some(Side { user: *user as usize, own, sign: user_sign * sign(turned), user_sign })
        };
        self.faces.iter().filter_map(side).collect()
    }
}

impl Side {
    /// Its area vector, m2.
    pub(super) fn area(self, mesh: &Mesh) -> [f64; 3] {
        mesh.area[self.own].map(|x| self.sign * x)
    }
    /// What passes it, of the fluxes of all faces in the user's numbering and direction.
    pub(super) fn flux(self, all: &[f64]) -> Components {
        components(&[self.user_sign * all[self.user]])
    }
    /// The value of a field on it; it lies on a boundary.
    pub(super) fn value(self, view: &View<'_>, all: &Everywhere) -> Components {
        let poly = &view.whole.case.poly;
        all.at(poly.n_cells() + self.user - poly.n_inner())
    }
}
