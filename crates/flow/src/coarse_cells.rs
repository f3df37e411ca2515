//! The strain rate of a nonlocal model in cells that are longer than its grains are wide.
//!
//! The rate is the mean stress of the cell over its viscosity ([`granflow_fv::Reconstruction::viscous_stress`]): faces
//! have the geometric mean of two viscosities, so that a viscosity which goes up and down from cell to cell leaves the stress as it is.
//! Such a disturbance changes the rate by its own inverse, and what the local law makes of that is the
//! disturbance itself but for the share I/I0 by which friction grows: any checkerboard is next to a solution. Where cells resolve grains the
//! fluidity's own diffusion smooths it. Where they do not, the rate has the viscosity that the faces have in the mean, each by
//! its share in the stress; in flows that the mesh resolves the two differ by the square of the cell's length.

use crate::Flow;
use granflow_base::{norm, sub};
use granflow_mesh::Mesh;

/// Distances between cell centres, over the diameter of grains, up to which the cell's own viscosity counts, and
/// from which on that of the faces does.
const RESOLVED: f64 = 0.5;
const COARSE: f64 = 1.0;

/// From 0, for faces between cells that resolve grains, to 1.
#[inline]
fn coarseness(mesh: &Mesh, f: usize, d: f64) -> f64 {
    ((1.0 / (mesh.inv_dist[f] * d) - RESOLVED) / (COARSE - RESOLVED)).clamp(0.0, 1.0)
}

impl Flow {
    /// Takes `work.strain_rate` from the cells' own viscosity to the faces' where cells are coarse.
    pub(crate) fn mean_viscosity_where_coarse(&mut self) {
        let Flow { exec, mesh, work: w, state, two_phase, fluid, .. } = self;
        let Some(material) = fluid.rheology.grains() else { return };
        let grains = two_phase.as_ref().and_then(|t| t.work.grains.as_ref());
        let (eta, eta_f, u) = (&w.eta.data, &w.eta_f.data, &state.u);
        exec.for_each(&mut w.strain_rate[..mesh.n_cells], |first, out| {
            for (i, rate) in out.iter_mut().enumerate() {
                let c = first + i;
                let own = grains.map_or(eta[c], |g| g.viscosity_of_rate(c, eta[c]));
                let (mut ln_ratio, mut weights) = (0.0, 0.0);
                for (f, sign) in mesh.faces_of(c) {
                    let (beyond, coarse) = match mesh.neighbour.get(f) {
                        None => (u.boundary_value(mesh, f), 0.0),
                        Some(&n) => {
                            let n = if sign > 0.0 { n } else { mesh.owner[f] } as usize;
                            (u.cells.data[n], coarseness(mesh, f, material.d))
                        }
                    };
                    let across = norm(sub(beyond, u.cells.data[c])) * mesh.inv_dist[f];
                    let weight = (eta_f[f] * across * mesh.mag_area[f]).powi(2);
                    weights += weight;
                    if coarse * weight > 0.0 {
                        ln_ratio += weight * coarse * (own / eta_f[f]).ln();
                    }
                }
                if ln_ratio != 0.0 {
                    *rate *= (ln_ratio / weights).exp();
                }
            }
        });
    }
}
