//! Fixed value, zero gradient, fixed gradient.

use super::{Condition, PatchClosure, PatchView};
use granflow_base::Value;
use granflow_dict::number;

/// Text of a value as dictionaries write it: `1` or `(1 0 0)`.
pub(crate) fn text<T: Value>(v: T) -> String {
    if T::N == 1 {
        return number(v.comp(0));
    }
    let parts: Vec<String> = (0..T::N).map(|c| number(v.comp(c))).collect();
    format!("({})", parts.join(" "))
}

/// Text of a field entry: `uniform v` or `nonuniform List<..> n(...)`.
pub(crate) fn field_text<T: Value>(values: &[T]) -> String {
    match values {
        [one] => format!("uniform {}", text(*one)),
        many => {
            let items: Vec<String> = many.iter().map(|v| text(*v)).collect();
            format!("nonuniform List<{}> {}({})", T::WORD, many.len(), items.join(" "))
        }
    }
}

/// The value of face `i` in a list of one (uniform) or one per face.
#[inline]
pub(crate) fn pick<T: Copy>(values: &[T], i: usize) -> T {
    values[if values.len() == 1 { 0 } else { i }]
}

/// Dirichlet: the face value is given (one for the patch, or one per face).
pub struct FixedValue<T> {
    name: &'static str,
    values: Vec<T>,
}
impl<T: Value> FixedValue<T> {
    /// A uniform value.
    pub fn uniform(v: T) -> Self {
        FixedValue { name: "fixedValue", values: vec![v] }
    }
    /// One value per face of the patch.
    pub fn per_face(values: Vec<T>) -> Self {
        FixedValue { name: "fixedValue", values }
    }
    /// The same under another name (`movingWallVelocity`).
    pub(super) fn under_name(name: &'static str, values: Vec<T>) -> Self {
        FixedValue { name, values }
    }
    /// A uniform value under another name (`noSlip`).
    pub fn named(name: &'static str, v: T) -> Self {
        FixedValue { name, values: vec![v] }
    }
}
impl<T: Value> Condition<T> for FixedValue<T> {
    fn name(&self) -> &'static str {
        self.name
    }
    fn update(&mut self, _: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(T::ZERO);
        closure.offset.iter_mut().enumerate().for_each(|(i, o)| *o = pick(&self.values, i));
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        if self.name == "noSlip" {
            return Vec::new();
        }
        vec![("value".into(), field_text(&self.values))]
    }
}

/// Neumann with zero gradient: the face takes the cell's value.
pub struct ZeroGradient;

/// Zero gradient under the name of a condition whose value is an outcome.
pub(super) struct Calculated(pub(super) &'static str);
impl<T: Value> Condition<T> for Calculated {
    fn name(&self) -> &'static str {
        self.0
    }
    fn update(&mut self, _: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

impl<T: Value> Condition<T> for ZeroGradient {
    fn name(&self) -> &'static str {
        "zeroGradient"
    }
    fn update(&mut self, _: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
    }
    fn entries(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

/// Neumann: the outward normal gradient is given, in units of the field per metre.
pub struct FixedGradient<T> {
    gradient: Vec<T>,
}
impl<T: Value> FixedGradient<T> {
    /// One gradient for the patch or one per face.
    pub fn new(gradient: Vec<T>) -> Self {
        FixedGradient { gradient }
    }
}
impl<T: Value> Condition<T> for FixedGradient<T> {
    fn name(&self) -> &'static str {
        "fixedGradient"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        for (i, o) in closure.offset.iter_mut().enumerate() {
            *o = pick(&self.gradient, i).scaled(1.0 / view.inv_dist[i]);
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        vec![("gradient".into(), field_text(&self.gradient))]
    }
}
