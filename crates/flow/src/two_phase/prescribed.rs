//! Flows that are given, for tests of the interface alone.

use crate::Flow;
use granflow_base::{Value, Vec3, add, dot, scale, sub};
use granflow_mesh::{Mesh, PolyMesh};

/// A flux through the faces times a factor that changes with time.
pub struct Prescribed {
    /// Volume flux through the faces where the factor is 1, m3/s.
    pub flux: Vec<f64>,
    /// The factor at a time, s.
    pub factor: Box<dyn Fn(f64) -> f64 + Send + Sync>,
}

/// Points and weights of Gauss's rule with five points on (-1, 1).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189),
    (-0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.0, 0.568_888_888_888_889),
    (0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.906_179_845_938_664, 0.236_926_885_056_189),
];

impl Prescribed {
    /// Flux of `curl A` through every face by Stokes's theorem: every edge counts once each way, so
    /// that the sum over a cell is null but for rounding. `mesh` was made from `poly` or is a part.
    pub fn flux_of(poly: &PolyMesh, mesh: &Mesh, potential: impl Fn(Vec3) -> Vec3) -> Vec<f64> {
        // One direction per edge, so that both faces get the same bits.
        let edge = |p: u32, q: u32| {
            let (i, j, sign) = if p < q { (p, q, 1.0) } else { (q, p, -1.0) };
            let (x, y) = (poly.points[i as usize], poly.points[j as usize]);
            let (along, middle) = (scale(sub(y, x), 0.5), scale(add(x, y), 0.5));
            let at = |t: f64| dot(potential(add(middle, scale(along, t))), along);
            sign * GAUSS.iter().map(|(t, w)| w * at(*t)).sum::<f64>()
        };
        let one = |e: &u32| {
            let ring = poly.face((e >> 1) as usize);
            let around = (0..ring.len()).map(|i| edge(ring[i], ring[(i + 1) % ring.len()]));
            let sum: f64 = around.sum();
            if e & 1 == 1 { -sum } else { sum }
        };
        mesh.poly_face.iter().map(one).collect()
    }
}

impl Flow {
    /// The given flux at `time` into the state, and the velocity that fits it, where one is given.
    pub(crate) fn prescribe(&mut self, time: f64) {
        let Flow { exec, mesh, state, two_phase, .. } = self;
        let Some(two) = two_phase else { return };
        let Some(given) = &two.prescribed else { return };
        let (k, flux) = ((given.factor)(time), &given.flux);
        exec.for_each(&mut state.phi.data, |first, phi| {
            phi.iter_mut().enumerate().for_each(|(i, phi)| *phi = k * flux[first + i]);
        });
        let (phi, forces) = (&state.phi.data, &two.work.forces);
        exec.for_each(&mut state.u.cells.data[..mesh.n_cells], |first, u| {
            for (i, u) in u.iter_mut().enumerate() {
                let c = first + i;
                let mut sum = [0.0; 3];
                for (f, _) in mesh.faces_of(c) {
                    sum = sum.axpy(phi[f] / mesh.mag_area[f], mesh.area[f]);
                }
                *u = forces.rebuilt(c, sum);
            }
        });
    }
}
