//! Conditions of the pressure without its hydrostatic part, p_rgh = p - rho G.x.

use super::basic::{field_text, pick};
use super::read::{field_values, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_base::dot;
use granflow_dict::Reader;

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

pub(super) const PRGH: Entry = Entry {
    name: "prghPressure",
    summary: "the pressure p is given; p_rgh = p - rho G.x follows",
    formula: "p_rgh,f = p - rho_P g . x_f",
    keys: &[("p", "Pa, `uniform` or one a face")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(prgh_pressure),
    vector: None,
};
pub(super) const FIXED_FLUX: Entry = Entry {
    name: "fixedFluxPressure",
    summary: "the normal gradient of pressure that makes the flux match the velocity condition",
    formula: "p_f = p_P + h dp/dn, dp/dn = (F - U_f . S)/(r |S|); F: the flux that \
              momentum gives without the gradient of pressure, r: the velocity that a gradient of \
              1 Pa/m takes away, m2 s-1 Pa-1",
    keys: &[],
    reference: "P. M. Gresho, R. L. Sani, Int. J. Numer. Meth. Fluids 7 (1987) 1111",
    scalar: Some(fixed_flux_pressure),
    vector: None,
};

fn prgh_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("rho");
    Box::new(PrghPressure::new(field_values(r, "p", c)))
}
fn fixed_flux_pressure(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    for key in ["gradient", "phi", "rho"] {
        r.ignore(key);
    }
    Box::new(FixedFluxPressure::new(c.n_inner))
}
