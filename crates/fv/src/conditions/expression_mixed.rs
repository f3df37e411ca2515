//! Between a value and a gradient that are formulae of place and time.

use super::expression::{entries, formula, value_at, variables};
use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::formula::Formula;
use granflow_base::Value;
use granflow_dict::Reader;

/// Robin: `f value + (1 - f) (cell value + gradient * distance)` with formulae for all three.
struct ExprMixed {
    /// Zero where there is none.
    value: Option<Formula>,
    /// Outward, units of the field per metre; zero where there is none.
    gradient: Option<Formula>,
    /// The share `f` of the value, kept from 0 to 1; one where there is none.
    fraction: Option<Formula>,
    /// Whether the share is the number zero: no value is given then, at no time.
    free: bool,
    /// From the units of the file to those inside.
    factor: f64,
    entries: Vec<(String, String)>,
}
impl<T: Value> Condition<T> for ExprMixed {
    fn name(&self) -> &'static str {
        "exprMixed"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.free();
        for (i, inv_dist) in view.inv_dist.iter().enumerate() {
            let of = |formula: &mut Option<Formula>| {
                formula.as_mut().map_or(T::ZERO, |f| value_at::<T, T>(f, view, i))
            };
            let (value, gradient) = (of(&mut self.value), of(&mut self.gradient));
            let fraction = self.fraction.as_mut().map_or(1.0, |f| value_at::<f64, T>(f, view, i));
            let fixed = fraction.clamp(0.0, 1.0);
            let rise = gradient.scaled((1.0 - fixed) / inv_dist);
            closure.offset[i] = rise.axpy(fixed, value).scaled(self.factor);
            closure.slope[i] = 1.0 - fixed;
        }
    }
    fn fixes_value(&self) -> bool {
        !self.free
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.entries.clone()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "exprMixed",
    summary: "Robin: formulae valueExpr (0 if left out), gradientExpr (outward, 0) and fractionExpr, the \
              share of the value (1)",
    formula: "phi_f = w valueExpr + (1 - w)(phi_P + gradientExpr h), w = fractionExpr",
    keys: &[
        ("valueExpr", "the formula of the value, a text, optional beside gradientExpr: 0"),
        (
            "gradientExpr",
            "the formula of the outward gradient, a text, optional beside valueExpr: 0",
        ),
        ("fractionExpr", "the formula of the share of the value, 0 to 1, a text, optional: 1"),
        ("variables", "a list of texts `name = formula`, in their order, optional"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: Some(read),
    vector: Some(read),
};

fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    // What OpenFOAM writes beside the formulae.
    for key in ["refValue", "refGradient", "valueFraction"] {
        r.ignore(key);
    }
    leave_value(r);
    let variables = variables(r);
    let of = |key: &str, vector| r.has(key).then(|| formula(r, key, &variables, vector)).flatten();
    if !r.has("valueExpr") && !r.has("gradientExpr") {
        let help = Some("give `valueExpr`, `gradientExpr` or both");
        r.error_here("`exprMixed` has no formula", "neither value nor gradient", help);
    }
    let keys = ["variables", "valueExpr", "gradientExpr", "fractionExpr"];
    let share = r.has("fractionExpr").then(|| r.string("fractionExpr").trim().parse::<f64>());
    Box::new(ExprMixed {
        free: share.is_some_and(|f| f.is_ok_and(|f| f <= 0.0)),
        value: of("valueExpr", T::N == 3),
        gradient: of("gradientExpr", T::N == 3),
        fraction: of("fractionExpr", false),
        factor: c.factor,
        entries: entries(r, &keys),
    })
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;

    #[test]
    fn no_share_of_a_value_fixes_none() {
        let of = |share: &str| {
            let text = format!("type exprMixed; gradientExpr \"0\"; fractionExpr \"{share}\";");
            Probe::of::<f64>(&text).condition().fixes_value()
        };
        assert!(!of("0") && !of(" 0.0 ") && of("1") && of("time()"));
    }

    /// Half a metre from the cells. What is left out is what icoFoam v1912 takes.
    #[test]
    fn formulae_of_value_gradient_and_share() {
        let of = |text: &str| Probe::of::<f64>(&format!("type exprMixed; {text}")).at(0.5);
        let all = "variables (\"y = pos().y()\"); valueExpr \"8*y\"; gradientExpr \"4*time()\"; \
                   fractionExpr \"0.5*y\";";
        // At y = 1/4 and 3/4: f = 1/8 and 3/8 of 2 and 6, the rest of 10 + 2/2.
        let [a, b] = [0.125 * 2.0 + 0.875 * 11.0, 0.375 * 6.0 + 0.625 * 11.0];
        assert_eq!(of(all).values([10.0; 4]), [a, b, a, b]);
        assert_eq!(of("valueExpr \"3\";").values([10.0; 4]), [3.0; 4]);
        assert_eq!(of("gradientExpr \"3\";").values([10.0; 4]), [0.0; 4]);
        let quarter = "valueExpr \"2\"; fractionExpr \"0.25\";";
        assert_eq!(of(quarter).values([10.0; 4]), [8.0; 4]);
        let vector = "type exprMixed; valueExpr \"vector(2, 0, time())\";";
        assert_eq!(
            Probe::of::<[f64; 3]>(vector).at(3.0).values([[9.0; 3]; 4]),
            [[2.0, 0.0, 3.0]; 4]
        );
        assert!(mistakes::<f64>("type exprMixed;").to_string().contains("no formula"));
        let wrong = mistakes::<f64>("type exprMixed; valueExpr \"1\"; fractionExpr \"2*\";");
        assert!(wrong.to_string().contains("fractionExpr"), "{wrong}");
    }
}
