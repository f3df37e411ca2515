//! Between a value and a gradient that are formulae of place and time.

use super::expression::{Expression, brief, entries, formula, variables};
use super::read::leave_value;
use super::{Condition, Entry, Fault, PatchClosure, PatchContext, PatchView};
use granflow_base::Value;
use granflow_dict::Reader;

/// What rounding may take a share beyond 0 and 1.
const ROUNDING: f64 = 1e-9;

/// Robin: `f value + (1 - f) (cell value + gradient * distance)` with formulae for all three.
struct ExprMixed {
    /// Zero where there is none.
    value: Option<Expression>,
    /// Outward, units of the field per metre; zero where there is none.
    gradient: Option<Expression>,
    /// The share `f` of the value; one where there is none.
    fraction: Option<Expression>,
    /// The share where it is the same everywhere and always.
    share: Option<f64>,
    fault: Option<Fault>,
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
        let mut fault = None;
        for (i, inv_dist) in view.inv_dist.iter().enumerate() {
            let mut of = |formula: &mut Option<Expression>| {
                formula.as_mut().map_or(T::ZERO, |f| f.at::<T, T>(view, i, &mut fault))
            };
            let (value, gradient) = (of(&mut self.value), of(&mut self.gradient));
            let mut fixed = 1.0;
            if let Some(f) = &mut self.fraction {
                let share = f.at::<f64, T>(view, i, &mut fault);
                fixed = share.clamp(0.0, 1.0);
                if (share - fixed).abs() > ROUNDING && fault.is_none() {
                    let is = format!("is {}, a share from 0 to 1 is needed,", brief(share));
                    fault = Some(f.fault(&is, view.centre[i], view.around.time));
                }
            }
            let rise = gradient.scaled((1.0 - fixed) / inv_dist);
            closure.offset[i] = rise.axpy(fixed, value).scaled(self.factor);
            closure.slope[i] = 1.0 - fixed;
        }
        self.fault = fault;
    }
    fn fixes_value(&self) -> bool {
        self.share != Some(0.0)
    }
    fn gives_value(&self) -> bool {
        self.share == Some(1.0)
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
    let of = |key: &'static str, vector| {
        r.has(key).then(|| formula(r, key, &variables, vector)).flatten()
    };
    if !r.has("valueExpr") && !r.has("gradientExpr") {
        let help = Some("give `valueExpr`, `gradientExpr` or both");
        r.error_here("`exprMixed` has no formula", "neither value nor gradient", help);
    }
    let keys = ["variables", "valueExpr", "gradientExpr", "fractionExpr"];
    let mut fraction = of("fractionExpr", false);
    let share = fraction.as_mut().map_or(Some(1.0), Expression::constant);
    if let Some(f) = share.filter(|f| f.is_finite() && !(0.0..=1.0).contains(f)) {
        let message = "`fractionExpr` must be from 0 to 1";
        let help = Some("1 gives the value, 0 the gradient");
        r.error_at_key("fractionExpr", message, format!("{} is no share", brief(f)), help);
    }
    Box::new(ExprMixed {
        share,
        fault: None,
        value: of("valueExpr", T::N == 3),
        gradient: of("gradientExpr", T::N == 3),
        fraction,
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
        assert!(!of("0") && !of(" 0.0 ") && !of("1 - 1") && of("1") && of("time()"));
        let gives = |share: &str| {
            let text = format!("type exprMixed; valueExpr \"0\"; {share}");
            Probe::of::<f64>(&text).condition().gives_value()
        };
        assert!(gives("") && gives("fractionExpr \"2/2\";"));
        assert!(!gives("fractionExpr \"0.5\";") && !gives("fractionExpr \"time()\";"));
    }

    #[test]
    fn what_cannot_be_is_known_at_once_or_told_with_its_time() {
        for (text, told) in [
            ("valueExpr \"1\"; fractionExpr \"1.5\";", "1.5 is no share"),
            ("valueExpr \"1\"; fractionExpr \"-1e-3\";", "must be from 0 to 1"),
            ("valueExpr \"sqrt(-1)\";", "the formula `sqrt(-1)` is not finite"),
            ("gradientExpr \"1/0\";", "the formula `1/0` is not finite"),
        ] {
            let said = mistakes::<f64>(&format!("type exprMixed; {text}")).to_string();
            assert!(said.contains(told), "{said}");
        }
        let at = |text: &str, time: f64| {
            let probe = Probe::of::<f64>(&format!("type exprMixed; {text}")).at(time);
            probe.fault([0.0; 4])
        };
        let share = "valueExpr \"1\"; fractionExpr \"2*time()\";";
        assert_eq!(at(share, 0.5), None);
        let fault = at(share, 0.75).unwrap();
        assert_eq!(fault.key, "fractionExpr");
        let told = "the formula `2*time()` is 1.5, a share from 0 to 1 is needed, at (0 0.25 0.25) m, \
                    time 0.75 s";
        assert_eq!(fault.text, told);
        let fault = at("valueExpr \"1/(time() - 1)\";", 1.0).unwrap();
        assert!(fault.text.contains("`1/(time() - 1)` is not finite at ("), "{}", fault.text);
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
