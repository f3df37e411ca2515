//! The rates that the fluidity equation reads: that of shear, and `sqrt(P/rho_s)/d`.

use super::{FlowView, Form, Ngf};

impl Ngf {
    /// Fills `local` and `rate`.
    pub(super) fn local_rates(&mut self, v: &FlowView<'_>) {
        let (grains, pressure, strain_rate) = (self.law.grains, v.pressure, v.strain_rate);
        // Without a fluidity to start from, material at rest is taken to creep everywhere.
        let rest = if self.known { grains.floors.creep } else { grains.floors.first_guess };
        let primitive = self.law.form != Form::Steady;
        let remembers = primitive && self.known;
        if primitive {
            let n = v.mesh.n_cells;
            self.mu[..n].copy_from_slice(&pressure[..n]);
            v.mesh.halo.update(v.exec, &mut self.mu);
        }
        let (fit, p, g_old) = (&self.fit, &self.mu, &self.g_old);
        v.exec.for_each2(&mut self.local, &mut self.rate, |first, local, rate| {
            for i in 0..local.len() {
                let c = first + i;
                local[i] = if primitive && v.has(c) {
                    // Half the range of what is linear is sqrt(3) standard deviations.
                    grains.mean_rate(p[c], 3f64.sqrt() * fit.deviation(v, p, c))
                } else {
                    grains.rate(pressure[c])
                };
                let mut floor = rest * local[i];
                if remembers && g_old[c] > 0.0 {
                    floor = floor.min(grains.floors.still * g_old[c].max(grains.floors.fluidity));
                }
                rate[i] = strain_rate[c].max(floor);
            }
        });
    }
}
