//! Conditions of the pressure without its hydrostatic part, p_rgh = p - rho G.x.

use super::basic::{field_text, pick};
use super::{Condition, PatchClosure, PatchView};
use granflow_base::dot;

/// The pressure p itself is given at the patch; p_rgh follows from the density and gravity there.
pub struct PrghPressure {
    p: Vec<f64>,
}
impl PrghPressure {
    /// Pressure in Pa: one for the patch or one per face.
    pub fn new(p: Vec<f64>) -> Self {
        PrghPressure { p }
    }
}
impl Condition<f64> for PrghPressure {
    fn name(&self) -> &'static str {
        "prghPressure"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.fix(0.0);
        let g = view.around.gravity;
        for (i, o) in closure.offset.iter_mut().enumerate() {
            let rho = view.around.density.get(view.owner[i] as usize).copied().unwrap_or(0.0);
            *o = pick(&self.p, i) - rho * dot(g, view.centre[i]);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("p".into(), field_text(&self.p))]
    }
}

/// The normal gradient that makes the flux through the face match the velocity condition.
pub struct FixedFluxPressure {
    n_inner: usize,
}
impl FixedFluxPressure {
    /// `n_inner`: number of inner faces of the mesh.
    pub fn new(n_inner: usize) -> Self {
        FixedFluxPressure { n_inner }
    }
}
impl Condition<f64> for FixedFluxPressure {
    fn name(&self) -> &'static str {
        "fixedFluxPressure"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        let gradient = view.around.flux_gradient;
        if gradient.is_empty() {
            return;
        }
        let first = view.first_boundary(self.n_inner);
        for (i, o) in closure.offset.iter_mut().enumerate() {
            *o = gradient[first + i] / view.inv_dist[i];
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}
