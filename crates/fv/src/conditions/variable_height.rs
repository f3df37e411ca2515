//! Inflow of a given volume per second through the part of a patch that fluid 1 fills.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Vec3, norm, scale};
use granflow_dict::{Reader, number};

/// Of a volume fraction: the cell's value, kept within bounds. The level at the patch is that of
/// the water behind it.
pub struct VariableHeightFlowRate {
    /// Least fraction.
    pub lower: f64,
    /// Greatest fraction.
    pub upper: f64,
}

impl Condition<f64> for VariableHeightFlowRate {
    fn name(&self) -> &'static str {
        "variableHeightFlowRate"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        for (i, cell) in view.owner.iter().enumerate() {
            let a = view.cells[*cell as usize];
            let kept = a.max(self.lower).min(self.upper);
            if kept != a {
                (closure.offset[i], closure.slope[i]) = (kept, 0.0);
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("lowerBound".into(), number(self.lower)), ("upperBound".into(), number(self.upper))]
    }
}

/// Of the velocity: inwards along the normal, in proportion to the fraction of fluid 1, `rate`
/// together.
pub struct VariableHeightFlowRateInlet {
    /// What enters, m3/s, against time.
    pub rate: TimeFunction<f64>,
    /// Number of inner faces of the mesh.
    pub n_inner: usize,
}

impl VariableHeightFlowRateInlet {
    /// The fraction on face `i`.
    fn wet(&self, view: &PatchView<'_, Vec3>, i: usize) -> f64 {
        let at = view.first_boundary(self.n_inner) + i;
        view.around.face_fraction.get(at).map_or(0.0, |a| a.clamp(0.0, 1.0))
    }
}

impl Condition<Vec3> for VariableHeightFlowRateInlet {
    fn name(&self) -> &'static str {
        "variableHeightFlowRateInletVelocity"
    }
    fn n_totals(&self) -> usize {
        1
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        out[0] = view.area.iter().enumerate().map(|(i, s)| norm(*s) * self.wet(view, i)).sum();
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        // Nothing enters a dry patch.
        if view.totals[0] <= 0.0 {
            return;
        }
        let speed = self.rate.at(view.around.time) / view.totals[0];
        for (i, n) in view.normal.iter().enumerate() {
            closure.offset[i] = scale(*n, -speed * self.wet(view, i));
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.rate.entries("flowRate")
    }
}

pub(super) const FRACTION: Entry = Entry {
    name: "variableHeightFlowRate",
    summary: "of a volume fraction: the value of the cell, kept within bounds, so that the level at \
              the patch is that of the water behind it",
    formula: "alpha_f = min(max(alpha_P, lowerBound), upperBound)",
    keys: &[("lowerBound", "0 to 1"), ("upperBound", "0 to 1")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(variable_height),
    vector: None,
};
pub(super) const VELOCITY: Entry = Entry {
    name: "variableHeightFlowRateInletVelocity",
    summary: "inflow of a given volume per second through the part of the patch that the first \
              fluid fills, a function of time",
    formula: "U_f = -alpha_f flowRate(t)/(sum alpha_f |S|) n",
    keys: &[
        ("flowRate", "m3/s, a function of time"),
        ("alpha", "name of the fraction, of which there is one"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(variable_height_inlet),
};

fn variable_height(r: &Reader<'_>, _: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("phi");
    let lower = r.in_range("lowerBound", Dims::NONE, 0.0..=1.0);
    let upper = r.in_range("upperBound", Dims::NONE, 0.0..=1.0);
    if lower > upper {
        let message = "the lower bound is above the upper one";
        r.error_at_key("lowerBound", message, "above `upperBound`", None);
    }
    Box::new(VariableHeightFlowRate { lower, upper })
}
fn variable_height_inlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    leave_value(r);
    // The name of the volume fraction, of which there is one.
    r.ignore("alpha");
    let rate = TimeFunction::read(r, "flowRate", Dims::VOLUME_FLUX, c.case);
    Box::new(VariableHeightFlowRateInlet { rate, n_inner: c.n_inner })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::ZeroGradient;
    use crate::{Differentiable, Surroundings, Unknown};
    use granflow_base::Dims;
    use granflow_mesh::{Mesh, shapes};
    use granflow_par::Exec;

    /// What a condition makes of patch `xMin`, two by two faces of 1/4 m2, of these cell values.
    fn at_patch<T: Differentiable>(
        condition: impl Fn(&Mesh) -> Box<dyn Condition<T>>,
        values: [T; 4],
        face_fraction: &[f64],
    ) -> Vec<T> {
        let mesh = Mesh::new(&shapes::unit_box([1, 2, 2])).unwrap();
        let patch = mesh.patches[0].faces.clone();
        assert_eq!(patch.len(), 4);
        let mut conditions = vec![condition(&mesh)];
        conditions.extend((1..mesh.patches.len()).map(|_| Box::new(ZeroGradient) as _));
        let mut field = Unknown::new(&mesh, "f", Dims::NONE, T::ZERO, conditions);
        for (f, v) in patch.clone().zip(values) {
            field.cells.data[mesh.owner[f] as usize] = v;
        }
        let around = Surroundings { face_fraction, ..Surroundings::default() };
        field.update(&Exec::serial(), &mesh, &around, None);
        patch.map(|f| field.boundary_value(&mesh, f)).collect()
    }

    #[test]
    fn fractions_are_the_cells_within_bounds() {
        let condition = |_: &Mesh| -> Box<dyn Condition<f64>> {
            Box::new(VariableHeightFlowRate { lower: 0.1, upper: 0.9 })
        };
        let found = at_patch(condition, [0.0, 0.4, 1.1, 0.9], &[]);
        assert_eq!(found, [0.1, 0.4, 0.9, 0.9]);
    }

    #[test]
    fn what_enters_is_the_rate_of_fluid_1() {
        let condition = |mesh: &Mesh| -> Box<dyn Condition<Vec3>> {
            Box::new(VariableHeightFlowRateInlet {
                rate: TimeFunction::constant(0.75),
                n_inner: mesh.n_inner,
            })
        };
        let fraction = [1.0, 1.0, 0.5, 0.0];
        let found = at_patch(condition, [[0.0; 3]; 4], &fraction);
        let speeds: Vec<f64> = found.iter().map(|u| u[0]).collect();
        // 0.75 m3/s through 2.5 quarters of a square metre, and the partly wet face in proportion.
        assert_eq!(speeds, [1.2, 1.2, 0.6, 0.0]);
        let dry = at_patch(condition, [[0.0; 3]; 4], &[0.0; 4]);
        assert_eq!(dry, [[0.0; 3]; 4]);
    }
}
