//! One value for the whole patch, which depends on time.

use super::read::{leave_flux, leave_value};
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::Value;
use granflow_dict::Reader;

/// Dirichlet: one value for the patch.
pub struct UniformFixedValue<T> {
    /// The value against time.
    pub value: TimeFunction<T>,
}
impl<T: Value> Condition<T> for UniformFixedValue<T> {
    fn name(&self) -> &'static str {
        "uniformFixedValue"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(self.value.at(view.around.time));
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.value.entries("uniformValue")
    }
}

pub(super) const FIXED_VALUE: Entry = Entry {
    name: "uniformFixedValue",
    summary: "Dirichlet: one value for the patch, a function of time",
    formula: "phi_f = uniformValue(t)",
    keys: &[("uniformValue", "units of the field, a function of time")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(fixed_value),
    vector: Some(fixed_value),
};
fn fixed_value<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    let value = TimeFunction::read(r, "uniformValue", c.dims, c.case).times(c.factor);
    Box::new(UniformFixedValue { value })
}

/// Neumann: one normal gradient for the patch.
struct UniformFixedGradient<T> {
    /// Outward, units of the field per metre, against time.
    gradient: TimeFunction<T>,
}
impl<T: Value> Condition<T> for UniformFixedGradient<T> {
    fn name(&self) -> &'static str {
        "uniformFixedGradient"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        let gradient = self.gradient.at(view.around.time);
        for (o, inv_dist) in closure.offset.iter_mut().zip(view.inv_dist) {
            *o = gradient.scaled(1.0 / inv_dist);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.gradient.entries("uniformGradient")
    }
}

pub(super) const FIXED_GRADIENT: Entry = Entry {
    name: "uniformFixedGradient",
    summary: "Neumann: one outward normal gradient for the patch, a function of time",
    formula: "phi_f = phi_P + uniformGradient(t) h",
    keys: &[("uniformGradient", "units of the field a metre, outwards, a function of time")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(fixed_gradient),
    vector: Some(fixed_gradient),
};
fn fixed_gradient<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    r.ignore("gradient");
    let dims = c.dims.div(granflow_base::Dims::LENGTH);
    let gradient = TimeFunction::read(r, "uniformGradient", dims, c.case).times(c.factor);
    Box::new(UniformFixedGradient { gradient })
}

/// Zero gradient where the flow leaves, one value where it enters.
struct UniformInletOutlet<T> {
    inlet: TimeFunction<T>,
}
impl<T: Value> Condition<T> for UniformInletOutlet<T> {
    fn name(&self) -> &'static str {
        "uniformInletOutlet"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        let inlet = self.inlet.at(view.around.time);
        for (i, f) in view.flux.into_iter().flatten().enumerate() {
            if *f < 0.0 {
                (closure.offset[i], closure.slope[i]) = (inlet, 0.0);
            }
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.inlet.entries("uniformInletValue")
    }
}

pub(super) const INLET_OUTLET: Entry = Entry {
    name: "uniformInletOutlet",
    summary: "zero gradient where the flow leaves, where it enters one value, a function of time",
    formula: "phi_f = uniformInletValue(t) where flux < 0, else phi_P",
    keys: &[("uniformInletValue", "units of the field, a function of time")],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(inlet_outlet),
    vector: Some(inlet_outlet),
};
fn inlet_outlet<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    leave_flux(r);
    let inlet = TimeFunction::read(r, "uniformInletValue", c.dims, c.case).times(c.factor);
    Box::new(UniformInletOutlet { inlet })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn values_and_gradients_follow_their_function() {
        let ramp = "{ type scale; scale linearRamp; duration 4; value (2 0 4); }";
        let text = format!("type uniformFixedValue; uniformValue {ramp};");
        let found = Probe::of::<[f64; 3]>(&text).at(1.0).values([[9.0; 3]; 4]);
        assert_eq!(found, [[0.5, 0.0, 1.0]; 4]);
        // The cells' centres lie 0.5 m behind the faces.
        let text = "type uniformFixedGradient; uniformGradient table ((0 0) (2 8));";
        assert_eq!(
            Probe::of::<f64>(text).at(1.0).values([1.0, 2.0, 3.0, 4.0]),
            [3.0, 4.0, 5.0, 6.0]
        );
        let text = "type uniformInletOutlet; uniformInletValue sine; \
                    uniformInletValueCoeffs { amplitude 3; frequency 0.25; level 1; }";
        let flux = [1.0, -1.0, 0.0, -2.0];
        let found = Probe::of::<f64>(text).at(1.0).flux(flux).values([7.0; 4]);
        assert_eq!(found, [7.0, 4.0, 7.0, 4.0]);
    }
}
