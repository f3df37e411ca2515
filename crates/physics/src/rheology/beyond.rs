//! Where a flow asks for more friction than grains can give.

use super::{FlowView, Granular};
use granflow_base::Vec3;

/// Cells whose friction is used up: stress over pressure at mu_2 or beyond, or so fast a shear that
/// mu(I) is mu_2 but for a few percent of what separates it from mu_s. Faster shear finds no more
/// friction there, so no steady flow exists. Of all ranks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// How many.
    pub cells: usize,
    /// The worst one's number in the user's mesh.
    pub cell: usize,
    /// Its centre, m.
    pub place: Vec3,
    /// Its stress ratio, or mu(I) where that is more.
    pub mu: f64,
    /// Its inertial number.
    pub inertial: f64,
    /// The greatest that grains carry.
    pub mu_2: f64,
}

/// Share of mu_2 - mu_s that is left where friction counts as used up: I above 32 I0, a hundred
/// times what mu(I) was measured for.
const LEFT: f64 = 0.03;

/// Finds them: by the stress where it is known, and by mu(I). Grains out of contact carry nothing and are no part of
/// this; what is no longer a number neither.
pub(super) fn beyond(v: &FlowView<'_>, grains: &Granular) -> Option<Beyond> {
    let (loose, n) = (grains.loose(), v.mesh.n_cells);
    let most = grains.mu_2 - LEFT * grains.delta_mu();
    let inertial = |c: usize| grains.inertial_number(v.strain_rate[c], v.pressure[c]);
    let mu = |c: usize| {
        let p = v.pressure[c];
        if p <= loose || v.share(c) < 0.5 {
            return 0.0;
        }
        let (carried, local) = (v.stress.map_or(0.0, |s| s[c] / p), grains.mu(inertial(c)));
        let worst = if carried >= grains.mu_2 { carried } else { local };
        if worst.is_finite() { worst } else { 0.0 }
    };
    let [cells] = v.exec.sums(n, |r| [r.filter(|c| mu(*c) >= most).count() as f64]);
    if cells == 0.0 {
        return None;
    }
    // The rank that has the worst cell tells the others where it is.
    let here = (0..n).max_by(|a, b| mu(*a).total_cmp(&mu(*b)));
    let worst = v.exec.max(n, |r| r.map(mu).fold(0.0, f64::max));
    let mut told = [f64::NEG_INFINITY; 5];
    if let Some(c) = here.filter(|c| mu(*c) == worst) {
        let x = v.mesh.cell_centre[c];
        told = [f64::from(v.mesh.global_cell[c]), inertial(c), x[0], x[1], x[2]];
    }
    v.exec.comm().max(&mut told);
    let [cell, inertial, x, y, z] = told;
    Some(Beyond {
        cells: cells as usize,
        cell: cell as usize,
        place: [x, y, z],
        mu: worst,
        inertial,
        mu_2: grains.mu_2,
    })
}
