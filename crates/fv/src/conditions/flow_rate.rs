//! A given volume per second through a patch.

use super::{Condition, PatchClosure, PatchView, TimeTable};
use granflow_base::{Vec3, add, dot, norm, scale};

/// Inflow of a given rate, with the same speed along the normal on every face.
pub struct FlowRateInlet {
    /// What enters, m3/s, against time.
    pub rate: TimeTable<f64>,
}

impl Condition<Vec3> for FlowRateInlet {
    fn name(&self) -> &'static str {
        "flowRateInletVelocity"
    }
    fn n_totals(&self) -> usize {
        1
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        out[0] = view.area.iter().map(|s| norm(*s)).sum();
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let speed = self.rate.at(view.around.time) / view.totals[0].max(f64::MIN_POSITIVE);
        for (offset, n) in closure.offset.iter_mut().zip(view.normal) {
            *offset = scale(*n, -speed);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("volumetricFlowRate".into(), self.rate.text())]
    }
}

/// Outflow of a given rate: the profile of the cells behind the patch, scaled where they bring more
/// than half of the rate, else shifted. What would come in stands still; what is along the patch
/// passes freely.
pub struct FlowRateOutlet {
    /// What leaves, m3/s, against time.
    pub rate: TimeTable<f64>,
}

/// Speed out of the patch in the cell behind face `i`, not below zero, m/s.
fn outward(view: &PatchView<'_, Vec3>, i: usize) -> f64 {
    dot(view.cells[view.owner[i] as usize], view.normal[i]).max(0.0)
}

impl Condition<Vec3> for FlowRateOutlet {
    fn name(&self) -> &'static str {
        "flowRateOutletVelocity"
    }
    fn n_totals(&self) -> usize {
        2
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        for (i, s) in view.area.iter().enumerate() {
            let area = norm(*s);
            out[0] += area;
            out[1] += area * outward(view, i);
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        let (area, out) = (view.totals[0], view.totals[1]);
        let rate = self.rate.at(view.around.time);
        let (factor, shift) = match out > 0.5 * rate && out > 0.0 {
            true => (rate / out, 0.0),
            false => (1.0, (rate - out) / area.max(f64::MIN_POSITIVE)),
        };
        closure.fix([0.0; 3]);
        for (i, offset) in closure.offset.iter_mut().enumerate() {
            let (n, u) = (view.normal[i], view.cells[view.owner[i] as usize]);
            let along = add(u, scale(n, -dot(u, n)));
            *offset = add(along, scale(n, factor * outward(view, i) + shift));
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("volumetricFlowRate".into(), self.rate.text())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::ZeroGradient;
    use crate::{Surroundings, Unknown};
    use granflow_base::Dims;
    use granflow_mesh::{Mesh, shapes};
    use granflow_par::Exec;

    /// Speeds out of patch `xMin`, two by two faces of 1/4 m2 each, while the cells have (u, 3, 0).
    fn outflow(condition: Box<dyn Condition<Vec3>>, u: [f64; 4]) -> Vec<Vec3> {
        let mesh = Mesh::new(&shapes::unit_box([1, 2, 2])).unwrap();
        let patch = mesh.patches[0].faces.clone();
        assert_eq!(patch.len(), 4);
        let mut conditions: Vec<Box<dyn Condition<Vec3>>> = vec![condition];
        conditions.extend((1..mesh.patches.len()).map(|_| Box::new(ZeroGradient) as _));
        let mut field = Unknown::new(&mesh, "U", Dims::VELOCITY, [0.0; 3], conditions);
        for (f, u) in patch.clone().zip(u) {
            field.cells.data[mesh.owner[f] as usize] = [u, 3.0, 0.0];
        }
        let around = Surroundings { time: 2.0, ..Surroundings::default() };
        field.update(&Exec::serial(), &mesh, &around, None);
        patch.map(|f| field.boundary_value(&mesh, f)).collect()
    }
    fn rate(v: f64) -> TimeTable<f64> {
        TimeTable::new(vec![(0.0, 0.0), (4.0, 2.0 * v)]).unwrap()
    }

    #[test]
    fn an_inlet_lets_in_what_it_says_at_its_time() {
        let inlet = Box::new(FlowRateInlet { rate: rate(0.5) });
        assert_eq!(outflow(inlet, [7.0; 4]), [[0.5, 0.0, 0.0]; 4]);
    }

    #[test]
    fn an_outlet_scales_or_shifts_what_arrives() {
        // 0.25 (1 + 3) = 1 m3/s arrive; the third cell comes in, which counts as nothing.
        let u = [-1.0, -3.0, 2.0, 0.0];
        let x = |v: Vec<Vec3>| v.iter().map(|v| v[0]).collect::<Vec<_>>();
        let scaled = outflow(Box::new(FlowRateOutlet { rate: rate(1.5) }), u);
        assert!(scaled.iter().all(|v| v[1] == 3.0));
        assert_eq!(x(scaled), [-1.5, -4.5, 0.0, 0.0]);
        let shifted = outflow(Box::new(FlowRateOutlet { rate: rate(2.5) }), u);
        assert_eq!(x(shifted), [-2.5, -4.5, -1.5, -1.5]);
    }
}
