//! The forms of OpenFOAM's PISO solvers (v1912) where ours are others: what `compatible yes;` asks for.
//!
//! Momentum in one cell alone, `U = H/a - (1/a) grad p` (R. I. Issa, J. Comput. Phys. 62 (1986) 40; H. Jasak,
//! thesis, Imperial College (1996), sec. 3.8), is interpolated to faces as `(H/a)_f - (1/a)_f dp/dn`; old
//! fluxes are remembered the less the further they are from the flux of the old velocities; viscosity is
//! interpolated linearly and its transpose part is `grad U . grad nu` of the cells. That the mesh has no skewness
//! is seen to where the flow is built ([`granflow_mesh::Mesh::without_skewness`]).

use crate::Flow;
use crate::interpolation::open_share;
use granflow_base::{Tensor, Value, Vec3, dot, scale};
use granflow_fv::operators;
use granflow_physics::rheology::{LawValues, Points};

impl Flow {
    /// Mobilities of one cell alone in place of those of all cells and of faces without inertia.
    pub(crate) fn mobility_of_one_cell(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        w.r_at.data.copy_from_slice(&w.r_a.data);
        operators::to_faces(exec, mesh, &w.r_a.data, &mut w.r_a_f);
        w.r_at_f.data.copy_from_slice(&w.r_a_f.data);
    }

    /// `S . (H/a)_f - (1/a)_f |S| dp/dn` into `phi_star`, with `H/a - grad p/a` in `hby_a` and the slopes of the
    /// pressure as they belong to it. Where a condition leaves the velocity free, the boundary is the cell's.
    pub(crate) fn flux_of_one_cell(&mut self) {
        let Flow { exec, mesh, state, work: w, .. } = self;
        let (hby_a, grad_p, r_a) = (&w.hby_a, &w.grad_p, &w.r_a.data);
        let (r_a_f, dp_dn, u) = (&w.r_a_f.data, &w.dp_dn, &state.u);
        let cell = |c: u32| hby_a[c as usize].axpy(r_a[c as usize], grad_p[c as usize]);
        exec.for_each(&mut w.phi_star.data, |first, out| {
            for (i, phi) in out.iter_mut().enumerate() {
                let f = first + i;
                let here = cell(mesh.owner[f]);
                let on_face = match mesh.neighbour.get(f) {
                    Some(&n) => here.scaled(mesh.weight[f]).axpy(1.0 - mesh.weight[f], cell(n)),
                    None => {
                        let given = u.boundary_value(mesh, f);
                        let free = open_share(u, f - mesh.n_inner);
                        given.axpy(free, here.minus(u.cells.data[mesh.owner[f] as usize]))
                    }
                };
                *phi = dot(on_face, mesh.area[f]) - r_a_f[f] * mesh.mag_area[f] * dp_dn[f];
            }
        });
    }

    /// The viscosity on faces of a local law: linear between cells, the law's own at the boundary, where the
    /// normal derivative of the velocity is that of its condition. The cell gradients must be up to date.
    pub(crate) fn viscosity_from_cells(&mut self) {
        let Flow { exec, mesh, state, work: w, fluid, .. } = self;
        mesh.halo.update(exec, &mut w.eta.data);
        operators::to_faces(exec, mesh, &w.eta.data, &mut w.eta_f);
        let crate::newton::Newton { rate, pressure, eta, slopes, .. } = &mut w.newton;
        if rate.is_empty() {
            return;
        }
        let (u, gradient) = (&state.u, &w.grad_u);
        exec.for_each2(rate, pressure, |first, rate, _| {
            for (i, rate) in rate.iter_mut().enumerate() {
                let f = first + i;
                let of = match f < mesh.n_inner {
                    // Not looked at.
                    true => gradient[mesh.owner[f] as usize],
                    false => operators::face_gradient(mesh, u, gradient, false, f),
                };
                *rate = (2.0 * granflow_base::double_dot_sym(&of)).sqrt();
            }
        });
        let points = Points { strain_rate: rate, pressure, density: fluid.rho };
        fluid.rheology.at_points(exec, &points, LawValues { viscosity: eta, slopes });
        let boundary = mesh.n_inner..mesh.n_faces();
        w.eta_f.data[boundary.clone()].copy_from_slice(&eta[boundary]);
    }

    /// Adds `(grad U) . (grad eta)` to the force per volume, the transpose part of the viscous force where the
    /// velocity has no divergence.
    pub(crate) fn push_of_viscosity(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        let (gradient, eta): (&[Tensor], _) = (&w.grad_u, &w.eta_f.data);
        exec.for_each(&mut w.body.data[..mesh.n_cells], |first, out| {
            for (i, body) in out.iter_mut().enumerate() {
                let c = first + i;
                let mut slope: Vec3 = [0.0; 3];
                for (f, s) in mesh.faces_of(c) {
                    slope = slope.axpy(s * eta[f], mesh.area[f]);
                }
                let slope = scale(slope, 1.0 / mesh.volume[c]);
                *body = body.plus(granflow_base::apply(&gradient[c], slope));
            }
        });
    }
}

/// How much of what an old flux was ahead of the flux of the old velocities is remembered.
pub(crate) fn remembered(flux: f64, ahead: f64) -> f64 {
    if ahead == 0.0 { 0.0 } else { (1.0 - (ahead / flux).abs()).max(0.0) }
}
