//! Surface tension as a force on faces, `sigma K d alpha/dn` (J. U. Brackbill, D. B. Kothe, C.
//! Zemach, J. Comput. Phys. 100 (1992) 335). The curvature is that of the reconstructed interface
//! ([`crate::vof::Geometric::curvature`]) or, where fractions are smeared by algebraic transport, the
//! divergence of the unit normals of smoothed fractions. Either knows the angles at walls.

use crate::vof::Vof;
use granflow_base::{Value, Vec3, add, dot, norm, scale};
use granflow_fv::{Gradient, Surroundings, Unknown};
use granflow_mesh::{Mesh, PatchKind};
use granflow_par::Exec;

/// How often the volume fraction is smoothed before normals are taken from it: fractions of a sharp
/// interface have gradients that jump from cell to cell (B. Lafaurie et al., J. Comput. Phys. 113
/// (1994) 134).
const SMOOTHINGS: usize = 2;
/// Weight of a curvature away from the interface.
const LEAST_WEIGHT: f64 = 1e-3;
/// Passes that make the angle at the wall and the gradient beside it agree.
const PASSES: usize = 3;

/// Curvature of the interface, and what it takes.
pub(crate) struct SurfaceTension {
    /// Curvature in cells and ghosts, positive where fluid 1 is a drop, 1/m.
    pub(crate) curvature: Vec<f64>,
    /// Normal gradient of alpha that contact angles ask for, boundary faces, 1/m.
    pub(crate) contact_gradient: Vec<f64>,
    gradient: Vec<Vec3>,
    /// The volume fraction, smoothed, under its own conditions.
    smooth: Vec<f64>,
    /// Smoothed fractions on faces, then the curvature there, 1/m.
    faces: Vec<f64>,
    /// Whether the mean of a cell's faces takes the face: inner ones, and those with a contact angle.
    takes: Vec<bool>,
    /// How much the curvature of a cell counts: most at the interface.
    weight: Vec<f64>,
    /// Flux of the unit normal through the faces, m2.
    normal_flux: Vec<f64>,
    /// Cosine of the angle at which the interface meets each boundary face, NaN where nothing is known.
    cosine: Vec<f64>,
    /// Gradient below which there is no interface, 1/m: 1e-8 over the mean cell's size.
    least_gradient: f64,
}

impl SurfaceTension {
    pub(crate) fn new(exec: &Exec, mesh: &Mesh) -> SurfaceTension {
        let [volume, cells] =
            exec.sums(mesh.n_cells, |r| [mesh.volume[r.clone()].iter().sum(), r.len() as f64]);
        SurfaceTension {
            curvature: vec![0.0; mesh.n_all()],
            contact_gradient: vec![0.0; mesh.n_faces() - mesh.n_inner],
            gradient: vec![[0.0; 3]; mesh.n_all()],
            smooth: vec![0.0; mesh.n_all()],
            faces: vec![0.0; mesh.n_faces()],
            takes: (0..mesh.n_faces()).map(|f| f < mesh.n_inner).collect(),
            weight: vec![0.0; mesh.n_all()],
            normal_flux: vec![0.0; mesh.n_faces()],
            cosine: vec![f64::NAN; mesh.n_faces() - mesh.n_inner],
            least_gradient: 1e-8 / (volume / cells).cbrt(),
        }
    }

    /// What contact angles ask of alpha at the boundary: a function of the cells alone, so that a
    /// restart repeats it. Leaves the conditions of `alpha` up to date.
    pub(crate) fn meet_walls(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        (around, compatible): (&Surroundings<'_>, bool),
    ) {
        self.contact_gradient.fill(0.0);
        alpha.update(exec, mesh, around, None);
        if !alpha.conditions.iter().any(|c| c.contact_angle().is_some()) {
            return;
        }
        for _ in 0..PASSES {
            Gradient::GaussLinear.of(exec, mesh, alpha, &mut self.gradient);
            for (patch, condition) in mesh.patches.iter().zip(&alpha.conditions) {
                let Some(angle) = condition.contact_angle() else { continue };
                let first = patch.faces.start - mesh.n_inner;
                let out = &mut self.contact_gradient[first..][..patch.faces.len()];
                let gradient = |f: usize| self.gradient[mesh.owner[f] as usize];
                let faces = patch.faces.clone().zip(out);
                if compatible {
                    let along = |f| in_plane(gradient(f), mesh.normal(f));
                    faces.for_each(|(f, out)| *out = norm(along(f)) / angle.tan());
                } else {
                    faces.for_each(|(f, out)| *out = angle.cos() * norm(gradient(f)));
                }
            }
            let around = Surroundings { contact_gradient: &self.contact_gradient, ..*around };
            alpha.update(exec, mesh, &around, None);
        }
    }

    /// Curvature of the interface, in cells and on faces; the conditions of `alpha` are up to date. What is
    /// `compatible` is that of algebraic transport without smoothing, and linear between cells.
    pub(crate) fn update(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        (vof, compatible): (&mut Vof, bool),
    ) {
        let a = &alpha.cells.data;
        exec.for_each(&mut self.weight, |first, out| {
            for (i, w) in out.iter_mut().enumerate() {
                let a = a[first + i].clamp(0.0, 1.0);
                *w = a * (1.0 - a) + LEAST_WEIGHT;
            }
        });
        match vof {
            Vof::Algebraic(_) => {
                self.curve_smoothed(exec, mesh, alpha, if compatible { 0 } else { SMOOTHINGS });
            }
            Vof::Geometric(vof) => {
                self.find_cosines(mesh, alpha);
                let curvature = vof.curvature(exec, mesh, &alpha.cells.data, &self.cosine).0;
                self.curvature[..mesh.n_cells].copy_from_slice(&curvature[..mesh.n_cells]);
                mesh.halo.update(exec, &mut self.curvature);
            }
        }
        let algebraic = matches!(vof, Vof::Algebraic(_));
        self.put_on_faces(exec, mesh, compatible && algebraic);
    }

    /// The angles at which walls are met. Where a wall or a plane of symmetry says nothing else, the
    /// interface is normal to it, as its fraction does not change there.
    fn find_cosines(&mut self, mesh: &Mesh, alpha: &Unknown<f64>) {
        use PatchKind::{Symmetry, SymmetryPlane, Wall};
        for (patch, condition) in mesh.patches.iter().zip(&alpha.conditions) {
            let meets = matches!(patch.kind, Wall | Symmetry | SymmetryPlane);
            let cosine = match condition.contact_angle() {
                Some(angle) => angle.cos(),
                None if meets && !condition.fixes_value() => 0.0,
                None => f64::NAN,
            };
            self.cosine[patch.faces.start - mesh.n_inner..patch.faces.end - mesh.n_inner]
                .fill(cosine);
        }
    }

    /// Curvature `-div(n)` with the normals `n = grad alpha/|grad alpha|` of the faces, for fractions
    /// that are smeared over some cells, where no plane tells where the interface is.
    fn curve_smoothed(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        smoothings: usize,
    ) {
        for (patch, condition) in mesh.patches.iter().zip(&alpha.conditions) {
            self.takes[patch.faces.clone()].fill(condition.contact_angle().is_some());
        }
        // The conditions hold for the smoothed fraction too: it takes the place of the other.
        self.smooth.copy_from_slice(&alpha.cells.data);
        std::mem::swap(&mut self.smooth, &mut alpha.cells.data);
        for _ in 0..smoothings {
            self.smoothen(exec, mesh, alpha);
        }
        Gradient::GaussLinear.of(exec, mesh, alpha, &mut self.gradient);
        self.curve(exec, mesh, alpha);
        std::mem::swap(&mut self.smooth, &mut alpha.cells.data);
    }

    /// Every cell takes the mean of its faces, but of boundaries that say nothing about the interface.
    fn smoothen(&mut self, exec: &Exec, mesh: &Mesh, alpha: &mut Unknown<f64>) {
        let of = &*alpha;
        exec.for_each(&mut self.faces, |first, out| {
            out.iter_mut().enumerate().for_each(|(i, a)| *a = of.face_value(mesh, first + i));
        });
        let (faces, takes) = (&self.faces, &self.takes);
        exec.for_each(&mut alpha.cells.data[..mesh.n_cells], |first, out| {
            for (i, a) in out.iter_mut().enumerate() {
                let (mut sum, mut area) = (0.0, 0.0);
                for (f, _) in mesh.faces_of(first + i).filter(|(f, _)| takes[*f]) {
                    sum += mesh.mag_area[f] * faces[f];
                    area += mesh.mag_area[f];
                }
                if area > 0.0 {
                    *a = sum / area;
                }
            }
        });
        mesh.halo.update(exec, &mut alpha.cells.data);
    }

    /// Curvature from the gradient as it stands.
    fn curve(&mut self, exec: &Exec, mesh: &Mesh, alpha: &Unknown<f64>) {
        let SurfaceTension { gradient, normal_flux, curvature, least_gradient, .. } = self;
        let least = *least_gradient;
        exec.for_each(&mut normal_flux[..mesh.n_inner], |first, out| {
            for (i, q) in out.iter_mut().enumerate() {
                let f = first + i;
                let (o, n, w) =
                    (mesh.owner[f] as usize, mesh.neighbour[f] as usize, mesh.weight[f]);
                let g = gradient[o].scaled(w).axpy(1.0 - w, gradient[n]);
                *q = dot(g, mesh.area[f]) / (norm(g) + least);
            }
        });
        for (patch, condition) in mesh.patches.iter().zip(&alpha.conditions) {
            let angle = condition.contact_angle();
            for f in patch.faces.clone() {
                let o = mesh.owner[f] as usize;
                let n = mesh.normal(f);
                let along = in_plane(gradient[o], n);
                let size = norm(gradient[o]);
                let cosine = match angle {
                    Some(angle) => angle.cos() * size / (size + least),
                    None => {
                        let change = alpha.boundary_value(mesh, f) - alpha.cells.data[o];
                        let outward = change * mesh.inv_dist[f];
                        outward / (outward.hypot(norm(along)) + least)
                    }
                };
                normal_flux[f] = cosine * mesh.mag_area[f];
            }
        }
        exec.for_each(&mut curvature[..mesh.n_cells], |first, out| {
            for (i, k) in out.iter_mut().enumerate() {
                let c = first + i;
                let net: f64 = mesh.faces_of(c).map(|(f, s)| s * normal_flux[f]).sum();
                *k = -net / mesh.volume[c];
            }
        });
        mesh.halo.update(exec, curvature);
    }

    /// The curvature of the cells on their faces: that of the interface, which cells know the better the more
    /// they have of it, or linear between their centres.
    fn put_on_faces(&mut self, exec: &Exec, mesh: &Mesh, linear: bool) {
        let SurfaceTension { faces, curvature, weight, .. } = self;
        let inner = &mut faces[..mesh.n_inner];
        match linear {
            true => mean_on_faces(exec, mesh, curvature, inner, |f, _, _| {
                (mesh.weight[f], 1.0 - mesh.weight[f])
            }),
            false => mean_on_faces(exec, mesh, curvature, inner, |_, o, n| (weight[o], weight[n])),
        }
        exec.for_each(&mut faces[mesh.n_inner..], |first, out| {
            for (i, k) in out.iter_mut().enumerate() {
                *k = curvature[mesh.owner[mesh.n_inner + first + i] as usize];
            }
        });
    }

    /// Curvature on face `f`, 1/m.
    #[inline]
    pub(crate) fn on_face(&self, f: usize) -> f64 {
        self.faces[f]
    }
}

/// Mean of the two cells of inner faces, weighed by what `share` gives for a face and its cells.
fn mean_on_faces(
    exec: &Exec,
    mesh: &Mesh,
    of: &[f64],
    out: &mut [f64],
    share: impl Fn(usize, usize, usize) -> (f64, f64) + Sync,
) {
    exec.for_each(out, |first, out| {
        for (i, k) in out.iter_mut().enumerate() {
            let f = first + i;
            let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
            let (w, v) = share(f, o, n);
            *k = (w * of[o] + v * of[n]) / (w + v);
        }
    });
}

/// What of `v` lies in the plane with the unit normal `n`.
fn in_plane(v: Vec3, n: Vec3) -> Vec3 {
    add(v, scale(n, -dot(v, n)))
}
