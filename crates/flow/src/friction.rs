//! Walls with Coulomb friction: what decides between stick and slip, and how the traction of a
//! sliding wall answers a change of the flow.
//!
//! Stick or slip of a face follows from the state of its cell
//! ([`granflow_fv::conditions::CoulombFriction`]), so that residuals are those of the exact
//! complementarity. One outer pass is one step of a semismooth Newton method, which is a
//! primal-dual active set (M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2003) 865):
//! faces that stick keep the wall's velocity, faces that slide have the traction `mu P`, and both
//! its pressure and its direction follow the flow inside the operator of the coupled solve.

use crate::Flow;
use crate::two_phase::Grains;
use granflow_base::{Value, Vec3, apply, dot, norm, scale, sub};
use granflow_fv::{FaceField, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::{Beyond, magnitude};
use std::ops::Range;

/// The walls with friction of a flow.
pub(crate) struct Friction {
    walls: Vec<Wall>,
    /// Pressure of the material on all boundary faces times its share of them, Pa; empty without such
    /// walls.
    pub(crate) pressure: Vec<f64>,
    /// That share, and
    share: Vec<f64>,
    /// the viscosity of what fills the rest times its share, Pa s.
    pub(crate) rest: Vec<f64>,
    /// Which way faces slid in the last pass of this step, over all boundary faces.
    pub(crate) slid: Vec<Vec3>,
}

struct Wall {
    faces: Range<usize>,
    mu: f64,
    velocity: Vec3,
}

impl Friction {
    pub(crate) fn new(mesh: &Mesh, u: &Unknown<Vec3>) -> Self {
        let with = mesh.patches.iter().zip(&u.conditions);
        let walls: Vec<Wall> = with
            .filter_map(|(patch, condition)| {
                let (mu, velocity) = condition.friction()?;
                Some(Wall { faces: patch.faces.clone(), mu, velocity })
            })
            .collect();
        let boundary = if walls.is_empty() { 0 } else { mesh.n_faces() - mesh.n_inner };
        Friction {
            walls,
            pressure: vec![0.0; boundary],
            share: vec![1.0; boundary],
            rest: vec![0.0; boundary],
            slid: vec![[0.0; 3]; boundary],
        }
    }

    /// Forgets which way faces slid: to be called as a step begins.
    pub(crate) fn forget(&mut self) {
        self.slid.fill([0.0; 3]);
    }

    /// Remembers which way faces slide: to be called as a pass begins.
    pub(crate) fn remember(&mut self, mesh: &Mesh, u: &Unknown<Vec3>) {
        for wall in &self.walls {
            for b in wall.faces.clone().map(|f| f - mesh.n_inner) {
                // The drag, without what a fluid beside the grains adds to it.
                let (drag, slope) = (u.closure.offset[b], u.closure.slope[b]);
                self.slid[b] = match slope != 0.0 {
                    true => wall.velocity.scaled(1.0 - slope).minus(drag),
                    false => [0.0; 3],
                };
            }
        }
    }

    /// Whether there is any wall with friction.
    pub(crate) fn any(&self) -> bool {
        !self.walls.is_empty()
    }

    /// The pressure on the walls, `P = p_rgh + rho G.x`, Pa, less that of what surrounds the grains.
    pub(crate) fn press(
        &mut self,
        mesh: &Mesh,
        p: &Unknown<f64>,
        (rho, gravity): (&[f64], Vec3),
        grains: Option<&Grains>,
    ) {
        for f in self.walls.iter().flat_map(|w| w.faces.clone()) {
            let (b, c, x) = (f - mesh.n_inner, mesh.owner[f] as usize, mesh.face_centre[f]);
            self.pressure[b] = p.boundary_value(mesh, f) + rho[c] * dot(gravity, x);
            if let Some(grains) = grains {
                let share = grains.share[c];
                self.pressure[b] = share * (self.pressure[b] - grains.pore.at(c, x));
                (self.share[b], self.rest[b]) = (share, (1.0 - share) * grains.eta_2.data[c]);
            }
        }
    }

    /// Takes out of the forces on sliding faces what lies along the wall: that is the traction
    /// `mu P`, which the matrix has, and nothing else (`grad(U.n)` vanishes along a wall, and
    /// the viscosity has no say in it).
    pub(crate) fn keep_normal(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        force: &mut FaceField<Vec3>,
    ) {
        self.each_sliding(exec, mesh, u, force, |_, f, force| {
            let n = u.boundary_normal(mesh, f);
            *force = scale(n, dot(*force, n));
        });
    }

    /// Adds to `force`, the viscous force on faces for a change `du` of velocity and `dp` of
    /// pressure, what the traction of sliding faces makes of it:
    /// `-|S| (mu dP e + mu P (1 - e e - n n) dU/|U_cell - U_wall|)`, e the direction of sliding.
    pub(crate) fn add_change(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        (du, dp): (&[Vec3], &Unknown<f64>),
        force: &mut FaceField<Vec3>,
    ) {
        self.each_sliding(exec, mesh, u, force, |wall, f, force| {
            let (c, n) = (mesh.owner[f] as usize, u.boundary_normal(mesh, f));
            let along = |v: Vec3| v.axpy(-dot(v, n), n);
            let apart = along(sub(u.cells.data[c], wall.velocity));
            let distance = norm(apart);
            let p = self.pressure[f - mesh.n_inner];
            // Nothing holds where grains are pulled off the wall.
            if distance == 0.0 || p <= 0.0 {
                return;
            }
            let e = scale(apart, 1.0 / distance);
            let across = along(du[c]);
            let across = across.axpy(-dot(across, e), e);
            let area = wall.mu * mesh.mag_area[f];
            *force = force
                .axpy(-area * self.share[f - mesh.n_inner] * dp.boundary_value(mesh, f), e)
                .axpy(-area * p / distance, across);
        });
    }

    /// Calls `change` with the wall, the number and the force of every face that slides.
    fn each_sliding(
        &self,
        exec: &Exec,
        mesh: &Mesh,
        u: &Unknown<Vec3>,
        force: &mut FaceField<Vec3>,
        change: impl Fn(&Wall, usize, &mut Vec3) + Sync,
    ) {
        for wall in &self.walls {
            let start = wall.faces.start;
            exec.for_each(&mut force.data[wall.faces.clone()], |first, force| {
                for (i, force) in force.iter_mut().enumerate() {
                    let f = start + first + i;
                    if slides(mesh, u, f) {
                        change(wall, f, force);
                    }
                }
            });
        }
    }
}

impl Flow {
    /// Where grains that slide along walls have a stress ratio of `mu_2` or more on the wall: its friction there,
    /// and what the cell bears in directions that the wall does not see; in the corner with a free surface, where
    /// pressure and stress vanish together, what drives the flow over what presses the grains together
    /// (`tan^2(theta) + mu_wall^2 < mu_2^2` on a slope). None for laws without a field of their own.
    pub(crate) fn beyond_at_walls(&self) -> Option<Beyond> {
        let grains = self.fluid.rheology.grains()?;
        if self.fluid.rheology.is_local() || self.two_phase.is_some() {
            return None;
        }
        let Flow { mesh, state, work: w, .. } = self;
        let mut worst: Option<Beyond> = None;
        let mut here = 0.0;
        for wall in &w.friction.walls {
            for f in wall.faces.clone().filter(|&f| slides(mesh, &state.u, f)) {
                let (c, n) = (mesh.owner[f] as usize, mesh.normal(f));
                let p = w.pressure[c].max(grains.loose());
                let stress = &w.stress[c];
                let traction = apply(stress, n);
                let along = traction.axpy(-dot(traction, n), n);
                let rest = magnitude(stress).powi(2) - dot(along, along);
                let rest = rest.max(0.0).sqrt() / p;
                let mu = rest.max(self.slope_at_surface(c)).hypot(wall.mu);
                if mu < grains.mu_2 {
                    continue;
                }
                here += 1.0;
                let inertial = grains.inertial_number(w.strain_rate[c], p);
                let one = Beyond {
                    mu,
                    mu_2: grains.mu_2,
                    inertial,
                    cell: mesh.global_cell[c] as usize,
                    place: mesh.face_centre[f],
                    cells: 1,
                };
                worst = Some(worst.filter(|b| b.mu >= mu).unwrap_or(one));
            }
        }
        let mut faces = [here];
        self.exec.comm().sum(&mut faces);
        if faces[0] == 0.0 {
            return None;
        }
        // The rank that has the worst one tells the others.
        let mut most = [worst.map_or(f64::NEG_INFINITY, |b| b.mu)];
        self.exec.comm().max(&mut most);
        let own = worst.filter(|b| b.mu == most[0]);
        let mut told = own.map_or([f64::NEG_INFINITY; 5], |b| {
            [b.cell as f64, b.inertial, b.place[0], b.place[1], b.place[2]]
        });
        self.exec.comm().max(&mut told);
        let [cell, inertial, x, y, z] = told;
        Some(Beyond {
            mu: most[0],
            mu_2: grains.mu_2,
            inertial,
            cell: cell as usize,
            place: [x, y, z],
            cells: faces[0] as usize,
        })
    }

    /// What drives the grains of a cell along its free surface over what presses them together; 0 away from one.
    fn slope_at_surface(&self, c: usize) -> f64 {
        let Flow { mesh, state, gravity, .. } = self;
        let (drives, presses) = (norm(gravity.driving), gravity.hydrostatic);
        let open = |f: &usize| *f >= mesh.n_inner && state.p.closure.slope[f - mesh.n_inner] == 0.0;
        let surface = mesh.faces_of(c).map(|(f, _)| f).find(open);
        let pressed = surface.map_or(0.0, |f| dot(presses, mesh.normal(f)).abs());
        if pressed > 0.0 { drives / pressed } else { 0.0 }
    }
}

/// Whether boundary face `f` of a wall with friction slides.
#[inline]
fn slides(mesh: &Mesh, u: &Unknown<Vec3>, f: usize) -> bool {
    u.closure.slope[f - mesh.n_inner] != 0.0
}

impl Flow {
    /// To be called when the viscosity has changed: what walls with friction hold depends on it.
    pub(crate) fn viscosity_meets_walls(&mut self) {
        if self.work.friction.any() {
            self.update_conditions();
        }
    }
}
