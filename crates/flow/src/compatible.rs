//! The forms of OpenFOAM's PISO solvers (v1912) where ours are others: the cases of its solvers have them, and those that ask by
//! `compatible yes;`.
//!
//! Momentum in one cell alone, `U = H/a - (1/a) grad p` (R. I. Issa, J. Comput. Phys. 62 (1986) 40; H. Jasak,
//! thesis, Imperial College (1996), sec. 3.8), is interpolated to faces as `(H/a)_f - (1/a)_f dp/dn`; old
//! fluxes are remembered the less the further they are from the flux of the old velocities. That the mesh has no skewness
//! is seen to where the flow is built ([`granflow_mesh::Mesh::without_skewness`]).
//!
//! With two fluids the memory is the same ([`crate::two_phase`]); the compression has the face's central fraction
//! ([`crate::vof::AlgebraicParams::central_compression`]), the curvature is that of the fraction as it is (J. U. Brackbill et al.,
//! J. Comput. Phys. 100 (1992) 335). Where asked for only, periodic sides are upwind on one side ([`crate::vof::GeometricParams::sides_apart`]).

use crate::Flow;
use crate::interpolation::open_share;
use granflow_base::{Value, apply, dot};
use granflow_fv::operators;

impl Flow {
    /// Whether a viscosity that varies has those forms.
    pub(crate) fn has_compatible_viscosity(&self) -> bool {
        self.numerics.compatible && !self.fluid.rheology.is_constant()
    }

    /// Leaves of `work.ahead`, what the old fluxes of the state are ahead of the flux of its velocities, what is remembered.
    pub(crate) fn limit_memory(&mut self) {
        let Flow { exec, state, work: w, .. } = self;
        let phi = &state.phi.data;
        exec.for_each(&mut w.ahead.data, |first, out| {
            let each = out.iter_mut().enumerate();
            each.for_each(|(i, ahead)| *ahead *= remembered(phi[first + i], *ahead));
        });
    }

    /// Mobilities of one cell alone in place of those of all cells and of faces without inertia.
    pub(crate) fn mobility_of_one_cell(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        w.r_at.data.copy_from_slice(&w.r_a.data);
        operators::to_faces(exec, mesh, &w.r_a.data, &mut w.r_a_f);
        w.r_at_f.data.copy_from_slice(&w.r_a_f.data);
    }

    /// The viscosity on faces: linear between cells, at boundaries what the law makes of the strain rate there. The
    /// cell gradients of velocity and the viscosity of cells must be up to date.
    pub(crate) fn viscosity_between_cells(&mut self) {
        self.evaluate_law_on_faces();
        let Flow { exec, mesh, work: w, .. } = self;
        operators::to_faces(exec, mesh, &w.eta.data, &mut w.eta_f);
        let boundary = mesh.n_inner..;
        w.eta_f.data[boundary.clone()].copy_from_slice(&w.newton.eta[boundary]);
    }

    /// Adds `grad U . grad eta`, what the transposed part of the stress is where the flow is free of divergence, to
    /// the force per volume in `body`, from the cell gradients of both.
    pub(crate) fn add_transposed_stress(&mut self) {
        let Flow { exec, mesh, work: w, .. } = self;
        let (eta_f, grad_u) = (&w.eta_f.data, &w.grad_u);
        exec.for_each(&mut w.body.data[..mesh.n_cells], |first, body| {
            for (i, body) in body.iter_mut().enumerate() {
                let c = first + i;
                let mut grad_eta = [0.0; 3];
                for (f, sign) in mesh.faces_of(c) {
                    grad_eta = grad_eta.axpy(sign * eta_f[f], mesh.area[f]);
                }
                *body = body.axpy(1.0 / mesh.volume[c], apply(&grad_u[c], grad_eta));
            }
        });
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
}

/// How much of what an old flux was ahead of the flux of the old velocities is remembered.
fn remembered(flux: f64, ahead: f64) -> f64 {
    if ahead == 0.0 { 0.0 } else { (1.0 - (ahead / flux).abs()).max(0.0) }
}
