//! A formula of place and time.

use super::read::leave_value;
use super::{Condition, Entry, Fault, PatchClosure, PatchContext, PatchView};
use crate::formula::{Formula, Place, Quantity};
use crate::time_function::{of_components, raw_text};
use granflow_base::{Value, Vec3};
use granflow_dict::{Reader, number};

/// Dirichlet: a formula.
struct ExprFixedValue {
    /// `None` where it was wrong.
    formula: Option<Expression>,
    /// From the units of the file to those inside.
    factor: f64,
    entries: Vec<(String, String)>,
    fault: Option<Fault>,
}
impl<T: Value> Condition<T> for ExprFixedValue {
    fn name(&self) -> &'static str {
        "exprFixedValue"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(T::ZERO);
        self.fault = None;
        let Some(formula) = &mut self.formula else { return };
        for (i, o) in closure.offset.iter_mut().enumerate() {
            *o = formula.at::<T, T>(view, i, &mut self.fault).scaled(self.factor);
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn may_fail(&self) -> bool {
        true
    }
    fn fault(&self) -> Option<&Fault> {
        self.fault.as_ref()
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.entries.clone()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "exprFixedValue",
    summary: "Dirichlet: a formula of pos(), time(), normal() and variables",
    formula: "phi_f = valueExpr",
    keys: &[
        ("valueExpr", "the formula, a text"),
        ("variables", "a list of texts `name = formula`, in their order, optional"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(read),
    vector: Some(read),
};

fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    let formula = formula(r, "valueExpr", &variables(r), T::N == 3);
    let entries = entries(r, &["variables", "valueExpr"]);
    Box::new(ExprFixedValue { formula, factor: c.factor, entries, fault: None })
}

/// The definitions under `variables`.
pub(super) fn variables<'a>(r: &Reader<'a>) -> Vec<&'a str> {
    if r.has("variables") { definitions(r) } else { Vec::new() }
}

/// The formula under `key`, of a vector or a number; `None` where it is wrong, which is said.
pub(super) fn formula(
    r: &Reader<'_>,
    key: &'static str,
    variables: &[&str],
    vector: bool,
) -> Option<Expression> {
    let told = r.sink().n_errors();
    let text = r.string(key);
    if r.sink().n_errors() > told {
        return None;
    }
    match Formula::new(variables, text, vector) {
        Ok(mut formula) => {
            if formula.constant().is_some_and(|q| !q.is_finite()) {
                let message = format!("the formula `{text}` is not finite");
                r.error_at_key(key, message, "infinite, or no number", None);
            }
            Some(Expression { key, text: text.to_owned(), formula })
        }
        Err((place, e)) => {
            let (key, what) = match place {
                None => (key, text),
                Some(k) => ("variables", variables[k]),
            };
            let message = format!("the formula `{what}` cannot be evaluated");
            r.error_at_key(key, message, e.to_string(), None);
            None
        }
    }
}

/// The entries `keys` as they were given.
pub(super) fn entries(r: &Reader<'_>, keys: &[&str]) -> Vec<(String, String)> {
    let given = |k: &&str| Some(((*k).to_owned(), raw_text(r.dict().get(k)?)));
    keys.iter().filter_map(given).collect()
}

/// A number as a person reads it.
pub(super) fn brief(x: f64) -> String {
    format!("{x:.5e}").parse().map_or_else(|_| x.to_string(), number)
}

/// A formula under its entry.
pub(super) struct Expression {
    key: &'static str,
    text: String,
    formula: Formula,
}

impl Expression {
    /// The value on face `i` of a patch; the first that is not finite is a `fault`.
    pub(super) fn at<T: Value, U>(
        &mut self,
        view: &PatchView<'_, U>,
        i: usize,
        fault: &mut Option<Fault>,
    ) -> T {
        let (position, time) = (view.centre[i], view.around.time);
        let value = self.formula.at(&Place { position, area: view.area[i], time });
        if !value.is_finite() && fault.is_none() {
            *fault = Some(self.fault("is not finite", position, time));
        }
        match value {
            Quantity::Scalar(x) => of_components(&[x]),
            Quantity::Vector(v) => of_components(&v),
        }
    }

    /// The number that it is everywhere and always.
    pub(super) fn constant(&mut self) -> Option<f64> {
        match self.formula.constant() {
            Some(Quantity::Scalar(x)) => Some(x),
            _ => None,
        }
    }

    /// What is at fault: it `is` what it must not be.
    pub(super) fn fault(&self, is: &str, at: Vec3, time: f64) -> Fault {
        let [x, y, z] = at.map(brief);
        let (text, time) = (&self.text, brief(time));
        let text = format!("the formula `{text}` {is} at ({x} {y} {z}) m, time {time} s");
        Fault { key: self.key, text }
    }
}

/// `("a = 1" "b = 2*a")`, or one text with `;` between them.
fn definitions<'a>(r: &Reader<'a>) -> Vec<&'a str> {
    let Some(tokens) = r.raw("variables") else {
        r.error_at_key("variables", "`variables` must be a list of texts", "not a list", None);
        return Vec::new();
    };
    let inner = tokens.iter().find_map(|t| t.list()).unwrap_or(tokens);
    let texts = inner.iter().filter_map(|t| t.text());
    texts.flat_map(|t| t.split(';')).filter(|t| !t.trim().is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn a_formula_of_place_and_time() {
        let text = "type exprFixedValue; variables (\"a = 2\" \"y = pos().y()\"); \
                    valueExpr \"vector(4*y*(1 - y)*(1 + a*time()), 0, 0)\";";
        // At y = 1/4 and 3/4.
        assert_eq!(Probe::of::<[f64; 3]>(text).at(0.5).values([[9.0; 3]; 4]), [[1.5, 0.0, 0.0]; 4]);
        let text = "type exprFixedValue; valueExpr \"time() > 1 ? 3 : 5\";";
        assert_eq!(Probe::of::<f64>(text).at(2.0).values([9.0; 4]), [3.0; 4]);
        let said = mistakes::<f64>("type exprFixedValue; valueExpr \"1/0\";").to_string();
        assert!(said.contains("the formula `1/0` is not finite"), "{said}");
        let said = mistakes::<f64>("type exprFixedValue; valueExpr \"2*snGrad(U)\";").to_string();
        assert!(said.contains("text:1:32") && said.contains("`snGrad` is no function"), "{said}");
    }
}
