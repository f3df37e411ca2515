//! isoAdvector: geometric transport of the volume fraction on any mesh (Roenby, Bredmose & Jasak,
//! R. Soc. Open Sci. 3 (2016) 160405).
//!
//! 1. Find the interface in the mixed cells ([`Reconstructor`]) and how fast it moves.
//! 2. Every face takes from its upwind cell: where that is mixed, the time integral of the part
//!    of the face behind the moving plane.
//! 3. What a cell would hold beyond itself, or lack, goes through its outflow faces; then to
//!    the next cell downwind if it has no room either.

use super::corners::Corners;
use super::curvature::Curvature;
use super::face_integral::{FaceWork, Front};
use super::reconstruct::{BLOCK, Interface, Reconstruct, Reconstructor, gradient};
use super::stencil::Stencil;
use super::{Drive, VofError, VofReport, bounds_of, outflow, volume_of};
use granflow_base::{Dims, Vec3, add, apply, dot, inverse_symmetric, scale};
use granflow_fv::{FaceField, Unknown};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, PolyPatch};
use granflow_par::Exec;
use std::cell::RefCell;

/// Parameters of [`Geometric`]; the keys of `fvSolution` are in brackets.
#[derive(Clone, Debug, PartialEq)]
pub struct GeometricParams {
    /// How the interface is found (`reconstructionScheme`, plicRDF).
    pub reconstruction: Reconstruct,
    /// Cells with a fraction nearer to 0 or 1 than this hold no interface (`surfCellTol`, of old
    /// `isoAlphaTol`; 1e-8).
    pub surf_cell_tol: f64,
    /// Passes that redistribute over- and undershoots (`nAlphaBounds`, 3); up to twenty times as
    /// many where that is not enough. None at all with 0.
    pub n_alpha_bounds: usize,
    /// Fractions nearer to 0 or 1 than this are set there (`snapTol`). The default, 1e-16, only
    /// keeps fractions from fading for ever: OpenFOAM's 1e-12 costs a vortex 1e-10 of its volume.
    pub snap_tol: f64,
    /// Whether what is out of bounds after all passes is cut off (`clip`). No by default, as that
    /// is rounding, and cutting it off makes volume drift one way.
    pub clip: bool,
    /// Steps the time step is divided into (`nAlphaSubCycles`, 1).
    pub n_alpha_sub_cycles: usize,
    /// Whether cells behind a periodic side receive the fraction of the cell before it, whatever its plane sends
    /// through the side: what v1912 does, where volume is lost or made there (false).
    pub sides_apart: bool,
}

impl Default for GeometricParams {
    fn default() -> Self {
        GeometricParams {
            reconstruction: Reconstruct::PlicRdf,
            surf_cell_tol: 1e-8,
            n_alpha_bounds: 3,
            snap_tol: 1e-16,
            clip: false,
            n_alpha_sub_cycles: 1,
            sides_apart: false,
        }
    }
}

/// How often the usual number of passes may be used: a violation that is cut off is volume lost,
/// and few cells are still concerned.
const PATIENCE: usize = 20;
/// Violations up to this are rounding.
const ROUNDING: f64 = 1e-14;

/// isoAdvector with its work arrays.
pub struct Geometric {
    params: GeometricParams,
    corners: Corners,
    stencil: Stencil,
    reconstructor: Reconstructor,
    /// Iterations that the interface took.
    iterations: usize,
    curvature: Curvature,
    /// Inner faces behind which lie ghosts whose planes tell what comes in.
    coupled_faces: Vec<u32>,
    /// Velocity in the cells near the interface, wide, m/s.
    velocity: Vec<Vec3>,
    near_velocity: Vec<Vec3>,
    /// Speed of the interface along its normal, wide, m/s.
    speed: Vec<f64>,
    mixed_speed: Vec<f64>,
    /// Faces whose upwind cell is mixed, and what crosses them.
    cut_faces: Vec<u32>,
    cut_volumes: Vec<f64>,
    /// Volume of fluid 1 that crosses each face in a sub-step, m3.
    swept: FaceField<f64>,
    /// New fractions while they are tried.
    next: Vec<f64>,
    /// Share of its outflow's room (positive) or content (negative) a cell has to use.
    correction: Vec<f64>,
    /// See [`super::Vof::alpha_phi`].
    pub alpha_phi: FaceField<f64>,
}

thread_local! {
    static FACE: RefCell<FaceWork> = RefCell::default();
}

impl Geometric {
    /// The method on `mesh`, which was made from `poly` or is a part of it.
    ///
    /// # Errors
    /// [`VofError::Mesh`].
    pub fn new(
        exec: &Exec,
        poly: &PolyMesh,
        mesh: &Mesh,
        params: GeometricParams,
    ) -> Result<Geometric, VofError> {
        let corners = Corners::new(poly, mesh);
        let stencil = Stencil::new(exec, poly, mesh)?;
        let reconstructor =
            Reconstructor::new(mesh, &stencil, params.reconstruction, params.surf_cell_tol);
        let (n, all, faces) = (stencil.n_cells, stencil.n_all, mesh.n_faces());
        let apart = params.sides_apart;
        let ghost = |&f: &u32| {
            mesh.neighbour[f as usize] as usize >= n && !(apart && is_periodic(poly, mesh, f))
        };
        Ok(Geometric {
            params,
            curvature: Curvature::new(&stencil),
            corners,
            reconstructor,
            iterations: 0,
            coupled_faces: (0..mesh.n_inner as u32).filter(ghost).collect(),
            velocity: vec![[0.0; 3]; all],
            near_velocity: Vec::with_capacity(n),
            speed: vec![0.0; all],
            mixed_speed: Vec::with_capacity(n),
            cut_faces: Vec::with_capacity(faces),
            cut_volumes: Vec::with_capacity(faces),
            swept: FaceField::new(mesh, "alphaSwept", Dims::VOLUME_FLUX, 0.0),
            next: vec![0.0; n],
            correction: vec![0.0; mesh.n_all()],
            alpha_phi: FaceField::new(mesh, "alphaPhi", Dims::VOLUME_FLUX, 0.0),
            stencil,
        })
    }

    /// The interface found last: as of the beginning of the last sub-step, or of what
    /// [`Self::reconstruct`] was called with since.
    pub fn interface(&self) -> &Interface {
        &self.reconstructor.interface
    }
    /// Points and facets of the mesh.
    pub fn corners(&self) -> &Corners {
        &self.corners
    }
    /// Neighbours across corners, and the layout of [`Self::interface`].
    pub fn stencil(&self) -> &Stencil {
        &self.stencil
    }
    /// Curvature of the interface of `alpha` as it stands, and the area of the interface that it is
    /// worth, both in the layout of [`Self::interface`]: 1/m, positive where fluid 1 is a drop, and
    /// m2. It reaches one cell beyond the mixed ones. `cosine` is that of the angle at which the
    /// interface meets each boundary face, measured through fluid 1; NaN where nothing is known.
    pub fn curvature(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &[f64],
        cosine: &[f64],
    ) -> (&[f64], &[f64]) {
        self.reconstruct(exec, mesh, alpha);
        let Geometric { curvature, corners, stencil, reconstructor, .. } = self;
        curvature.update(exec, mesh, corners, stencil, reconstructor, cosine);
        (&curvature.value, &curvature.area)
    }
    /// Finds the interface of `alpha` as it stands, without moving it.
    /// Nothing is done where it is known.
    pub fn reconstruct(&mut self, exec: &Exec, mesh: &Mesh, alpha: &[f64]) -> usize {
        let known = &self.reconstructor.alpha;
        let changed = exec.max(self.stencil.n_cells, |r| {
            f64::from(u8::from(r.into_iter().any(|c| known[c].to_bits() != alpha[c].to_bits())))
        });
        if changed > 0.0 {
            self.iterations =
                self.reconstructor.update(exec, mesh, &self.corners, &self.stencil, alpha);
        }
        self.iterations
    }

    /// See [`super::Vof::advance`].
    ///
    /// # Errors
    /// [`VofError::NotFinite`].
    pub fn advance(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut Unknown<f64>,
        drive: Drive<'_>,
    ) -> Result<VofReport, VofError> {
        let Drive { phi, dt, around } = drive;
        let n = mesh.n_cells;
        let cycles = self.params.n_alpha_sub_cycles.max(1);
        let step = dt / cycles as f64;
        let mut report = VofReport::default();
        let before = volume_of(exec, mesh, &alpha.cells.data);
        self.alpha_phi.data.fill(0.0);
        for _ in 0..cycles {
            alpha.update(exec, mesh, around, Some(phi));
            let iterations = self.reconstruct(exec, mesh, &alpha.cells.data);
            report.iterations = report.iterations.max(iterations);
            self.interface_speed(exec, mesh, phi);
            self.sweep(exec, mesh, alpha, phi, step);
            let courant = self.interface_courant(exec, mesh, phi, dt);
            report.interface_courant = report.interface_courant.max(courant);
            report.bound_passes += self.bound(exec, mesh, &alpha.cells.data, phi, step);
            let (snap, clip) = (self.params.snap_tol, self.params.clip);
            let next = &self.next;
            exec.for_each(&mut alpha.cells.data[..n], |first, a| {
                for (i, a) in a.iter_mut().enumerate() {
                    *a = tidy(next[first + i], snap, clip);
                }
            });
            let swept = &self.swept.data;
            exec.for_each(&mut self.alpha_phi.data, |first, q| {
                q.iter_mut().enumerate().for_each(|(i, q)| *q += swept[first + i] / dt);
            });
        }
        alpha.update(exec, mesh, around, Some(phi));
        (report.min, report.max) = bounds_of(exec, &alpha.cells.data[..n]);
        if !(report.min.is_finite() && report.max.is_finite()) {
            return Err(VofError::NotFinite);
        }
        report.volume = volume_of(exec, mesh, &alpha.cells.data);
        report.volume_error = report.volume - before + dt * outflow(exec, mesh, &self.alpha_phi);
        report.mixed_cells = exec.sum(self.reconstructor.mixed.len(), |r| r.len() as f64) as usize;
        Ok(report)
    }

    /// Velocity of the interface along its normal, at its centre. The velocity of a cell fits the
    /// fluxes of its faces best; between cells it varies linearly.
    fn interface_speed(&mut self, exec: &Exec, mesh: &Mesh, phi: &FaceField<f64>) {
        let Geometric { reconstructor: r, stencil, velocity, near_velocity, .. } = self;
        let near = &r.near;
        near_velocity.clear();
        near_velocity.resize(near.len(), [0.0; 3]);
        exec.for_each_block(near_velocity, BLOCK, |first, out| {
            for (i, u) in out.iter_mut().enumerate() {
                *u = cell_velocity(mesh, phi, near[first + i] as usize);
            }
        });
        for (&c, &u) in near.iter().zip(near_velocity.iter()) {
            velocity[c as usize] = u;
        }
        stencil.halo.update(exec, velocity);
        let (mixed, velocity) = (&r.mixed, &self.velocity);
        let Interface { normal, offset, .. } = &r.interface;
        self.mixed_speed.clear();
        self.mixed_speed.resize(mixed.len(), 0.0);
        exec.for_each_block(&mut self.mixed_speed, BLOCK, |first, out| {
            for (i, speed) in out.iter_mut().enumerate() {
                let c = mixed[first + i] as usize;
                let here = velocity[c];
                let g = gradient(stencil, mesh.solved_dirs, c, |d| {
                    Some(granflow_base::sub(velocity[d], here))
                });
                let change = std::array::from_fn(|j| {
                    (0..3).map(|k| g[3 * k + j] * offset[c][k]).sum::<f64>()
                });
                *speed = dot(normal[c], add(here, change));
            }
        });
        for (&c, &s) in mixed.iter().zip(&self.mixed_speed) {
            self.speed[c as usize] = s;
        }
        stencil.halo.update(exec, &mut self.speed);
    }

    /// What crosses every face in `dt`, into `self.swept`.
    fn sweep(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
        phi: &FaceField<f64>,
        dt: f64,
    ) {
        let Geometric { reconstructor: r, stencil, corners, speed, .. } = self;
        let upwind = |f: usize| match (phi.data[f] >= 0.0, stencil.neighbour.get(f)) {
            (true, _) => Some(mesh.owner[f] as usize),
            (false, n) => n.map(|&n| n as usize),
        };
        exec.for_each(&mut self.swept.data, |first, out| {
            for (i, v) in out.iter_mut().enumerate() {
                let f = first + i;
                let carried = match upwind(f) {
                    Some(c) => r.alpha[c],
                    None => alpha.boundary_value(mesh, f),
                };
                *v = carried * phi.data[f] * dt;
            }
        });
        self.cut_faces.clear();
        for &c in r.mixed.iter().filter(|&&c| r.has_interface(c as usize)) {
            let out = mesh.faces_of(c as usize).filter(|&(f, s)| s * phi.data[f] > 0.0);
            self.cut_faces.extend(out.map(|(f, _)| f as u32));
        }
        let incoming = |&&f: &&u32| {
            let ghost = stencil.neighbour[f as usize] as usize;
            phi.data[f as usize] < 0.0 && r.has_interface(ghost)
        };
        self.cut_faces.extend(self.coupled_faces.iter().filter(incoming));
        self.cut_volumes.clear();
        self.cut_volumes.resize(self.cut_faces.len(), 0.0);
        let cut_faces = &self.cut_faces;
        exec.for_each_block(&mut self.cut_volumes, BLOCK, |first, out| {
            FACE.with_borrow_mut(|work| {
                work.reserve(corners.largest_cell[1]);
                for (i, v) in out.iter_mut().enumerate() {
                    let f = cut_faces[first + i] as usize;
                    let Some(c) = upwind(f) else { continue };
                    let front = Front {
                        normal: r.interface.normal[c],
                        point: add(stencil.centre[c], r.interface.offset[c]),
                        speed: speed[c],
                    };
                    *v = phi.data[f] * dt * work.mean_share(corners, f, &front, dt);
                }
            });
        });
        for (&f, &v) in self.cut_faces.iter().zip(&self.cut_volumes) {
            self.swept.data[f as usize] = v;
        }
    }

    /// Redistributes until the new fractions, in `self.next`, are within bounds or the passes are
    /// used up, and returns how many passes that took. Where the fluxes are free of divergence a
    /// cell that lets out nothing but fluid 1 cannot overfill, and one that lets out none of it
    /// cannot run dry: so every pass moves a violation downwind, and most of it stays there.
    fn bound(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        old: &[f64],
        phi: &FaceField<f64>,
        dt: f64,
    ) -> usize {
        let n = mesh.n_cells;
        let Geometric { swept, next, correction, .. } = self;
        let most = PATIENCE * self.params.n_alpha_bounds;
        for pass in 0..=most {
            let s = &swept.data;
            let [beyond] = exec.for_each2_sums(next, &mut correction[..n], |first, next, k| {
                let mut beyond = 0.0;
                for (i, (a, k)) in next.iter_mut().zip(k).enumerate() {
                    let c = first + i;
                    let net: f64 = mesh.faces_of(c).map(|(f, sign)| sign * s[f]).sum();
                    *a = old[c] - net / mesh.volume[c];
                    *k = if *a > 1.0 + ROUNDING {
                        beyond += 1.0;
                        let room =
                            outflowing(mesh, phi, c).map(|f| (phi.data[f] * dt - s[f]).abs());
                        share((*a - 1.0) * mesh.volume[c], room.sum())
                    } else if *a < -ROUNDING {
                        beyond += 1.0;
                        let content = outflowing(mesh, phi, c).map(|f| s[f].abs());
                        -share(-*a * mesh.volume[c], content.sum())
                    } else {
                        0.0
                    };
                }
                [beyond]
            });
            if beyond == 0.0 || pass == most {
                return pass;
            }
            mesh.halo.update(exec, correction);
            let correction = &*correction;
            exec.for_each(&mut swept.data, |first, out| {
                for (i, v) in out.iter_mut().enumerate() {
                    let f = first + i;
                    let upwind = match (phi.data[f] >= 0.0, mesh.neighbour.get(f)) {
                        (true, _) => mesh.owner[f],
                        (false, Some(&n)) => n,
                        (false, None) => continue,
                    };
                    let k = correction[upwind as usize];
                    if k > 0.0 {
                        *v += k * (phi.data[f] * dt - *v);
                    } else if k < 0.0 {
                        *v += k * *v;
                    }
                }
            });
        }
        most
    }

    fn interface_courant(&self, exec: &Exec, mesh: &Mesh, phi: &FaceField<f64>, dt: f64) -> f64 {
        let mixed = &self.reconstructor.mixed;
        let most = exec.max(mixed.len(), |r| {
            let out = |c: usize| outflowing(mesh, phi, c).map(|f| phi.data[f].abs()).sum::<f64>();
            let courant = |&c: &u32| dt * out(c as usize) / mesh.volume[c as usize];
            mixed[r].iter().map(courant).fold(0.0, f64::max)
        });
        most.max(0.0)
    }
}

/// Whether face `f` is one of a periodic side, whoever holds the cell behind it.
fn is_periodic(poly: &PolyMesh, mesh: &Mesh, f: u32) -> bool {
    let face = (mesh.poly_face[f as usize] >> 1) as usize;
    let cyclic = |p: &&PolyPatch| matches!(p.kind, PatchKind::Cyclic { .. });
    poly.patches.iter().filter(cyclic).any(|p| p.faces().contains(&face))
}

/// Faces through which fluid leaves cell `c`.
fn outflowing<'a>(
    mesh: &'a Mesh,
    phi: &'a FaceField<f64>,
    c: usize,
) -> impl Iterator<Item = usize> + 'a {
    mesh.faces_of(c).filter(|&(f, s)| s * phi.data[f] > 0.0).map(|(f, _)| f)
}

/// The share of `available` that `wanted` is, at most all of it.
fn share(wanted: f64, available: f64) -> f64 {
    if available > 0.0 { (wanted / available).min(1.0) } else { 0.0 }
}

/// The velocity whose flux through the faces of `c` comes nearest to `phi`, weights `1/|S|`:
/// `(sum S S/|S|)^-1 sum S phi/|S|`.
pub(super) fn cell_velocity(mesh: &Mesh, phi: &FaceField<f64>, c: usize) -> Vec3 {
    let (mut m, mut rhs) = ([0.0; 9], [0.0; 3]);
    for (f, _) in mesh.faces_of(c) {
        let (s, k) = (mesh.area[f], 1.0 / mesh.mag_area[f]);
        for i in 0..9 {
            m[i] += k * s[i / 3] * s[i % 3];
        }
        rhs = add(rhs, scale(s, k * phi.data[f]));
    }
    apply(&inverse_symmetric(&mesh.fit_to_invert(m)), rhs)
}

/// Fractions next to 0 or 1 are put there.
fn tidy(a: f64, snap: f64, clip: bool) -> f64 {
    let a = if a.abs() < snap {
        0.0
    } else if (1.0 - a).abs() < snap {
        1.0
    } else {
        a
    };
    if clip { a.clamp(0.0, 1.0) } else { a }
}
