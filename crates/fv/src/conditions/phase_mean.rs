//! An outlet through which one phase leaves with a given mean velocity.

use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Value, Vec3, dot, norm, scale};
use granflow_dict::Reader;

/// The velocity that arrives, brought to a mean over fluid 1 of `mean`: slowed down where it is faster, mixed
/// with a velocity along the normal where it is slower.
struct OutletPhaseMean {
    mean: TimeFunction<f64>,
    /// Number of inner faces of the mesh.
    n_inner: usize,
    entries: Vec<(String, String)>,
}

impl Condition<Vec3> for OutletPhaseMean {
    fn name(&self) -> &'static str {
        "outletPhaseMeanVelocity"
    }
    fn n_totals(&self) -> usize {
        2
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        let first = view.first_boundary(self.n_inner);
        for (i, (s, cell)) in view.area.iter().zip(view.owner).enumerate() {
            let wet = view.around.face_fraction.get(first + i).map_or(1.0, |a| a.clamp(0.0, 1.0));
            out[0] += wet * dot(view.cells[*cell as usize], *s);
            out[1] += wet * norm(*s);
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.free();
        let wanted = self.mean.at(view.around.time);
        let [flux, area] = [view.totals[0], view.totals[1]];
        // Nothing of the phase is there, or nothing is asked for and nothing comes.
        if area <= 0.0 || flux.max(wanted) <= 0.0 {
            return;
        }
        let found = flux / area;
        let (along, share) = match found >= wanted {
            true => (0.0, 1.0 - wanted / found),
            false => (wanted + found, 1.0 - found / wanted),
        };
        for (i, n) in view.normal.iter().enumerate() {
            closure.offset[i] = scale(*n, along).scaled(share);
            closure.slope[i] = 1.0 - share;
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn gives_value(&self) -> bool {
        false
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.entries.clone()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "outletPhaseMeanVelocity",
    summary: "of two phases: what arrives, brought to a mean velocity `Umean` of fluid 1 out of the patch, a \
              function of time",
    formula: "U_f = U_P scaled (below the mean that arrives) or moved along it, such that sum alpha_f U_f . S = Umean(t) sum alpha_f |S|",
    keys: &[("alpha", "the fraction of fluid 1"), ("Umean", "m/s, outwards, a function of time")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(read),
};

fn read(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    super::read::leave_value(r);
    let alpha = r.word("alpha").to_owned();
    let mean = TimeFunction::read(r, "Umean", c.dims, c.case);
    let mut entries = vec![("alpha".to_owned(), alpha)];
    entries.extend(mean.entries("Umean"));
    Box::new(OutletPhaseMean { mean, n_inner: c.n_inner, entries })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    /// Outwards is (-1 0 0); of four faces of 1/4 m2 two and a half are wet.
    #[test]
    fn the_mean_over_the_phase_is_what_is_asked_for() {
        let of = |mean: &str| {
            let text = format!("type outletPhaseMeanVelocity; alpha alpha.water; Umean {mean};");
            let cells = [[-4.0, 1.0, 0.0], [-2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [-9.0, 0.0, 0.0]];
            Probe::of::<[f64; 3]>(&text).fraction([1.0, 1.0, 0.5, 0.0]).values(cells)
        };
        // What arrives has the mean (4 + 2 + 1)/2.5 = 2.8: half of it is all values halved.
        assert_eq!(of("1.4")[0], [-2.0, 0.5, 0.0]);
        assert_eq!(of("1.4")[3], [-4.5, 0.0, 0.0]);
        // Twice of it: half of what arrives and half of (5.6 + 2.8).
        assert_eq!(of("5.6")[1].map(|x| (1e9 * x).round() / 1e9), [-5.2, 0.0, 0.0]);
        assert_eq!(of("2.8")[1], [-2.0, 0.0, 0.0]);
        for (mean, wanted) in [("1.4", 1.4), ("5.6", 5.6)] {
            let u = of(mean);
            let found = -(u[0][0] + u[1][0] + 0.5 * u[2][0]) / 2.5;
            assert!((found - wanted).abs() < 1e-12, "{found}, not {wanted}");
        }
    }
}
