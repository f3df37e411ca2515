//! Grains that are pulled apart: pressure between them that is not positive.

use granflow_base::{Vec3, dot};
use granflow_flow::Flow;

/// Cells in which the pressure between grains is zero or less: the models say nothing about them.
/// Of all ranks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensile {
    /// How many.
    pub cells: usize,
    /// The worst one's number in the user's mesh.
    pub cell: usize,
    /// Its centre, m.
    pub place: Vec3,
    /// Its pressure, Pa.
    pub pressure: f64,
}

/// Finds them in the present state.
pub(crate) fn find(flow: &Flow) -> Option<Tensile> {
    let (exec, mesh, n) = (&flow.exec, &flow.mesh, flow.mesh.n_cells);
    let (p, g, rho) = (&flow.state.p.cells.data, flow.gravity.hydrostatic, flow.fluid.rho);
    let beside_fluid = flow.grains_in_fluid();
    let pressure = |c: usize| match beside_fluid {
        None => p[c] + rho * dot(g, mesh.cell_centre[c]),
        Some((share, pressure)) if share[c] > 0.5 => pressure[c],
        Some(_) => f64::INFINITY,
    };
    let [cells] = exec.sums(n, |r| [r.filter(|c| pressure(*c) <= 0.0).count() as f64]);
    if cells == 0.0 {
        return None;
    }
    // The rank that has the worst cell tells the others where it is.
    let here = (0..n).min_by(|a, b| pressure(*a).total_cmp(&pressure(*b)));
    let suction = exec.max(n, |r| r.map(|c| -pressure(c)).fold(f64::NEG_INFINITY, f64::max));
    let mut told = [f64::NEG_INFINITY; 4];
    if let Some(c) = here.filter(|c| -pressure(*c) == suction) {
        let x = mesh.cell_centre[c];
        told = [f64::from(mesh.global_cell[c]), x[0], x[1], x[2]];
    }
    exec.comm().max(&mut told);
    let [cell, x, y, z] = told;
    // No minus before a zero.
    let pressure = 0.0 - suction;
    Some(Tensile { cells: cells as usize, cell: cell as usize, place: [x, y, z], pressure })
}
