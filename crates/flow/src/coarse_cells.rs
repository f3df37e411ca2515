//! The strain rate of a nonlocal model in cells that are longer than its grains are wide.
//!
//! The rate is the mean stress of the cell over its viscosity ([`granflow_fv::Reconstruction::viscous_stress`]): faces
//! have the geometric mean of two viscosities, so that a viscosity which goes up and down from cell to cell leaves the stress as it is.
//! Such a disturbance changes the rate by its own inverse, and what the local law makes of that is the
//! disturbance itself but for the share I/I0 by which friction grows: any checkerboard is next to a solution. Where cells resolve grains the
//! fluidity's own diffusion smooths it. Where they do not, the rate has the viscosity that the faces have in the mean, each by
//! its share in the stress; in flows that the mesh resolves the two differ by the square of the cell's length.

use crate::Flow;
use crate::viscosity::weight_beyond;
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
        let share = two_phase.as_ref().and_then(|t| t.share());
        let (eta, eta_f, u) = (&w.eta.data, &w.eta_f.data, &state.u);
        // ln of the viscosity that the rate of cell c was made with over that of its face to cell n.
        let off = |c: usize, n: usize, f: usize, beyond: f64| match grains {
            // Faces have the mixture's there, the rate is the grains' alone.
            Some(grains) if !grains.compares(c, n) => match weight_beyond(share, [c, n], beyond) {
                0.0 => 0.0,
                beyond => beyond * (eta[c] / eta[n]).ln(),
            },
            Some(grains) => (grains.viscosity_of_rate(c, eta[c]) / eta_f[f]).ln(),
            None => (eta[c] / eta_f[f]).ln(),
        };
        exec.for_each(&mut w.strain_rate[..mesh.n_cells], |first, out| {
            for (i, rate) in out.iter_mut().enumerate() {
                let c = first + i;
                let (mut ln_ratio, mut weights) = (0.0, 0.0);
                for (f, sign) in mesh.faces_of(c) {
                    let other = mesh.neighbour.get(f).map(|&n| match sign > 0.0 {
                        true => (n as usize, 1.0 - mesh.weight[f]),
                        false => (mesh.owner[f] as usize, mesh.weight[f]),
                    });
                    let there =
                        other.map_or_else(|| u.boundary_value(mesh, f), |(n, _)| u.cells.data[n]);
                    let across = norm(sub(there, u.cells.data[c])) * mesh.inv_dist[f];
                    let weight = (eta_f[f] * across * mesh.mag_area[f]).powi(2);
                    weights += weight;
                    let (Some((n, beyond)), coarse) = (other, coarseness(mesh, f, material.d))
                    else {
                        continue;
                    };
                    if coarse * weight > 0.0 {
                        ln_ratio += weight * coarse * off(c, n, f, beyond);
                    }
                }
                if ln_ratio != 0.0 {
                    *rate *= (ln_ratio / weights).exp();
                }
            }
        });
    }
}
