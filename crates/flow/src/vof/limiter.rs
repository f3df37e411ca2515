//! How much of a flux that sharpens may be added to one that is bounded: S. T. Zalesak, J. Comput.
//! Phys. 31 (1979) 335, on polyhedra.
//!
//! Every cell finds what may still come in and go out before it passes the extremes of its
//! neighbourhood; a face takes the smaller of what its two cells allow. What is left over is
//! tried again from the result (Schar & Smolarkiewicz, J. Comput. Phys. 128 (1996) 101), so more
//! passes give more of the flux and every one of them keeps the bounds to rounding.

use granflow_base::Dims;
use granflow_fv::{FaceField, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// Work arrays of the limiter.
pub(super) struct FluxLimiter {
    low: Vec<f64>,
    high: Vec<f64>,
    /// Shares of what wants to come in that may (ghosts included).
    inward: Vec<f64>,
    /// Shares of what wants to go out that may (ghosts included).
    outward: Vec<f64>,
    /// Cells that a correction wants to pass in or out of: those beside the interface.
    concerned: Vec<bool>,
    /// Part of the correction that a pass takes, m3/s.
    taken: FaceField<f64>,
}

impl FluxLimiter {
    pub(super) fn new(mesh: &Mesh) -> Self {
        FluxLimiter {
            low: vec![0.0; mesh.n_cells],
            high: vec![0.0; mesh.n_cells],
            inward: vec![0.0; mesh.n_all()],
            outward: vec![0.0; mesh.n_all()],
            concerned: vec![true; mesh.n_cells],
            taken: FaceField::new(mesh, "limitedCorrection", Dims::VOLUME_FLUX, 0.0),
        }
    }

    /// The least and the greatest of the fractions in every cell, its neighbours and its boundary
    /// faces, of `alpha` as it is and of `old` (both with ghosts), within 0..1.
    pub(super) fn find_bounds(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &Unknown<f64>,
        old: &[f64],
    ) {
        let now = &alpha.cells.data;
        exec.for_each2(&mut self.low, &mut self.high, |first, low, high| {
            for (i, (low, high)) in low.iter_mut().zip(high).enumerate() {
                let c = first + i;
                let (mut least, mut most) = (now[c].min(old[c]), now[c].max(old[c]));
                for (f, s) in mesh.faces_of(c) {
                    let (a, b) = match mesh.neighbour.get(f) {
                        Some(&n) => {
                            let d = if s > 0.0 { n } else { mesh.owner[f] } as usize;
                            (now[d], old[d])
                        }
                        None => {
                            let v = alpha.boundary_value(mesh, f);
                            (v, v)
                        }
                    };
                    least = least.min(a).min(b);
                    most = most.max(a).max(b);
                }
                (*low, *high) = (least.clamp(0.0, 1.0), most.clamp(0.0, 1.0));
            }
        });
    }

    /// Moves as much of `correction` (zero on boundary faces) into `flux`, and its effect over
    /// `dt` into `alpha`, as the bounds allow in `passes` passes. Ghosts of `alpha` are fresh
    /// before and after.
    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of one kernel, spelled out")]
    pub(super) fn add(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        alpha: &mut [f64],
        correction: &mut FaceField<f64>,
        flux: &mut FaceField<f64>,
        dt: f64,
        passes: usize,
    ) {
        let n = mesh.n_cells;
        // A pass only takes from what is wanted: no cell becomes concerned.
        let wanted = &correction.data;
        exec.for_each(&mut self.concerned, |first, out| {
            for (i, concerned) in out.iter_mut().enumerate() {
                *concerned = mesh.faces_of(first + i).any(|(f, _)| wanted[f] != 0.0);
            }
        });
        self.inward.fill(1.0);
        self.outward.fill(1.0);
        for _ in 0..passes.max(1) {
            let FluxLimiter { low, high, inward, outward, concerned, taken } = self;
            let (now, wanted, concerned) = (&*alpha, &correction.data, &*concerned);
            exec.for_each2(&mut inward[..n], &mut outward[..n], |first, inward, outward| {
                for (i, (r_in, r_out)) in inward.iter_mut().zip(outward).enumerate() {
                    let c = first + i;
                    if !concerned[c] {
                        continue;
                    }
                    let (mut gain, mut loss) = (0.0, 0.0);
                    for (f, s) in mesh.faces_of(c) {
                        let out = s * wanted[f];
                        if out > 0.0 {
                            loss += out;
                        } else {
                            gain -= out;
                        }
                    }
                    let k = mesh.volume[c] / dt;
                    *r_in = allowed(k * (high[c] - now[c]), gain);
                    *r_out = allowed(k * (now[c] - low[c]), loss);
                }
            });
            mesh.halo.update(exec, inward);
            mesh.halo.update(exec, outward);
            let (inward, outward) = (&*inward, &*outward);
            exec.for_each2(
                &mut taken.data[..mesh.n_inner],
                &mut correction.data[..mesh.n_inner],
                |first, taken, wanted| {
                    for (i, (t, w)) in taken.iter_mut().zip(wanted).enumerate() {
                        if *w == 0.0 {
                            *t = 0.0;
                            continue;
                        }
                        let f = first + i;
                        let (o, n) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize);
                        let (from, to) = if *w > 0.0 { (o, n) } else { (n, o) };
                        *t = *w * outward[from].min(inward[to]);
                        *w -= *t;
                    }
                },
            );
            let taken = &taken.data;
            exec.for_each(&mut flux.data[..mesh.n_inner], |first, flux| {
                flux.iter_mut().enumerate().for_each(|(i, q)| *q += taken[first + i]);
            });
            exec.for_each(&mut alpha[..n], |first, alpha| {
                for (i, a) in alpha.iter_mut().enumerate() {
                    let c = first + i;
                    if !concerned[c] {
                        continue;
                    }
                    let net: f64 = mesh.faces_of(c).map(|(f, s)| s * taken[f]).sum();
                    *a -= dt / mesh.volume[c] * net;
                }
            });
            mesh.halo.update(exec, alpha);
        }
    }
}

/// The share of `wanted` that `room` has place for.
#[inline]
fn allowed(room: f64, wanted: f64) -> f64 {
    if wanted <= room.max(0.0) { 1.0 } else { room.max(0.0) / wanted }
}
