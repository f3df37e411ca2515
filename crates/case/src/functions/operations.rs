//! What is made of many values: sums, means, integrals, extremes, with or without weights.

use super::field::Components;
use super::quantity::{Named, Wanted};
use super::{Rank, Reading};
use granflow_dict::Reader;
use granflow_par::Exec;

/// What is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Nothing.
    None,
    Min,
    Max,
    Sum,
    SumMag,
    Average,
    /// Mean over the size of cells or faces.
    SizeAverage,
    /// Integral over the size of cells or faces.
    SizeIntegrate,
    /// Standard deviation over the mean, by size.
    CoV,
    /// Mean over a surface of the component along its normal.
    NormalAverage,
    /// What passes a surface.
    NormalIntegrate,
    /// One for what is uniform over a surface, zero for what is concentrated.
    Uniformity,
}

/// How values are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weights {
    /// Not at all.
    Equal,
    /// By a field.
    Field,
    /// By the size of a field.
    Abs,
}

/// An operation by its name.
type Known = (&'static str, Kind, Weights);

/// Over cells.
pub(super) const OVER_CELLS: &[Known] = &[
    ("none", Kind::None, Weights::Equal),
    ("min", Kind::Min, Weights::Equal),
    ("max", Kind::Max, Weights::Equal),
    ("sum", Kind::Sum, Weights::Equal),
    ("sumMag", Kind::SumMag, Weights::Equal),
    ("average", Kind::Average, Weights::Equal),
    ("volAverage", Kind::SizeAverage, Weights::Equal),
    ("volIntegrate", Kind::SizeIntegrate, Weights::Equal),
    ("CoV", Kind::CoV, Weights::Equal),
    ("weightedSum", Kind::Sum, Weights::Field),
    ("weightedAverage", Kind::Average, Weights::Field),
    ("weightedVolAverage", Kind::SizeAverage, Weights::Field),
    ("weightedVolIntegrate", Kind::SizeIntegrate, Weights::Field),
];

/// Over faces.
pub(super) const OVER_FACES: &[Known] = &[
    ("none", Kind::None, Weights::Equal),
    ("min", Kind::Min, Weights::Equal),
    ("max", Kind::Max, Weights::Equal),
    ("sum", Kind::Sum, Weights::Equal),
    ("sumMag", Kind::SumMag, Weights::Equal),
    ("average", Kind::Average, Weights::Equal),
    ("areaAverage", Kind::SizeAverage, Weights::Equal),
    ("areaIntegrate", Kind::SizeIntegrate, Weights::Equal),
    ("CoV", Kind::CoV, Weights::Equal),
    ("areaNormalAverage", Kind::NormalAverage, Weights::Equal),
    ("areaNormalIntegrate", Kind::NormalIntegrate, Weights::Equal),
    ("uniformity", Kind::Uniformity, Weights::Equal),
    ("weightedSum", Kind::Sum, Weights::Field),
    ("weightedAverage", Kind::Average, Weights::Field),
    ("weightedAreaAverage", Kind::SizeAverage, Weights::Field),
    ("weightedAreaIntegrate", Kind::SizeIntegrate, Weights::Field),
    ("absWeightedSum", Kind::Sum, Weights::Abs),
    ("absWeightedAverage", Kind::Average, Weights::Abs),
    ("absWeightedAreaAverage", Kind::SizeAverage, Weights::Abs),
    ("absWeightedAreaIntegrate", Kind::SizeIntegrate, Weights::Abs),
];

/// An operation as a dictionary names it.
#[derive(Clone)]
pub(super) struct Operation {
    pub(super) name: &'static str,
    kind: Kind,
    weights: Weights,
    /// The field that weighs.
    pub(super) weight: Option<Wanted>,
}

impl Operation {
    /// Reads `operation` and, where it weighs, `weightField`.
    pub(super) fn read(
        r: &Reader<'_>,
        known: &'static [Known],
        reading: &Reading<'_>,
    ) -> Operation {
        let choices: Vec<(&str, Known)> = known.iter().map(|k| (k.0, *k)).collect();
        let (name, kind, weights) = r.one_of("operation", &choices);
        let mut weight = None;
        if weights != Weights::Equal {
            let field = Wanted::one(r, "weightField", reading);
            if field.list[0].quantity.rank() != Rank::Scalar {
                let message = format!("`{}` is no scalar: it cannot weigh", field.list[0].name);
                r.error_at_key("weightField", message, "a scalar is needed", None);
            }
            weight = Some(field);
        } else {
            r.ignore("weightField");
        }
        r.opt_one_of("postOperation", &[("none", ())], ());
        Operation { name, kind, weights, weight }
    }

    /// Whether nothing is computed.
    pub(super) fn idle(&self) -> bool {
        self.kind == Kind::None
    }
    /// What it makes of values of this rank; `None` where it makes nothing of them.
    pub(super) fn rank(&self, rank: Rank) -> Option<Rank> {
        match self.kind {
            Kind::NormalAverage | Kind::NormalIntegrate => {
                (rank == Rank::Vector).then_some(Rank::Scalar)
            }
            Kind::Uniformity => (rank <= Rank::Vector).then_some(Rank::Scalar),
            _ => Some(rank),
        }
    }
    /// Complains where it makes nothing of a field.
    pub(super) fn check(&self, r: &Reader<'_>, fields: &[Named]) {
        for f in fields.iter().filter(|f| self.rank(f.quantity.rank()).is_none()) {
            let needed =
                if self.kind == Kind::Uniformity { "scalars and vectors" } else { "vectors" };
            let message = format!("`{}` makes nothing of `{}`", self.name, f.name);
            r.error_at_key("operation", message, format!("of {needed} only"), None);
        }
    }
}

/// A value with what it weighs.
#[derive(Clone, Copy)]
pub(super) struct Element {
    pub(super) value: Components,
    /// Volume or area.
    pub(super) size: f64,
    /// Value of the field that weighs.
    pub(super) weight: f64,
    /// Area vector, of surfaces.
    pub(super) area: [f64; 3],
}

impl Operation {
    /// Of the elements of all ranks. Every rank calls it.
    pub(super) fn of(&self, exec: &Exec, n: usize, elements: &[Element]) -> Components {
        let weight = |e: &Element| match self.weights {
            Weights::Equal => 1.0,
            Weights::Field => e.weight,
            Weights::Abs => e.weight.abs(),
        };
        let sum = |of: &dyn Fn(&Element) -> Components| {
            let mut all = [0.0; 9];
            for e in elements {
                all.iter_mut().zip(of(e)).for_each(|(s, x)| *s += x);
            }
            exec.comm().sum(&mut all);
            all
        };
        let total = |of: &dyn Fn(&Element) -> f64| {
            let mut s = [elements.iter().map(of).sum::<f64>()];
            exec.comm().sum(&mut s);
            // Of nothing the mean is nothing.
            if s[0] == 0.0 { f64::MIN_POSITIVE } else { s[0] }
        };
        let through = |e: &Element| (0..3).map(|k| e.value[k] * e.area[k]).sum::<f64>() * weight(e);
        match self.kind {
            Kind::None => [0.0; 9],
            Kind::Min => extreme(exec, elements, -1.0),
            Kind::Max => extreme(exec, elements, 1.0),
            Kind::Sum => sum(&|e| e.value.map(|x| weight(e) * x)),
            Kind::SumMag => sum(&|e| e.value.map(f64::abs)),
            Kind::Average => {
                let all = total(&weight);
                sum(&|e| e.value.map(|x| weight(e) * x)).map(|x| x / all)
            }
            Kind::SizeIntegrate => sum(&|e| e.value.map(|x| weight(e) * e.size * x)),
            Kind::SizeAverage => {
                let all = total(&|e| weight(e) * e.size);
                sum(&|e| e.value.map(|x| weight(e) * e.size * x)).map(|x| x / all)
            }
            Kind::CoV => {
                let all = total(&|e| e.size);
                let mean = sum(&|e| e.value.map(|x| e.size * x)).map(|x| x / all);
                let off =
                    |e: &Element| std::array::from_fn(|k| e.size * (e.value[k] - mean[k]).powi(2));
                let spread = sum(&off);
                std::array::from_fn(|k| match k < n && mean[k] != 0.0 {
                    true => (spread[k] / all).sqrt() / mean[k],
                    false => 0.0,
                })
            }
            Kind::NormalIntegrate => sum(&|e| super::field::components(&[through(e)])),
            Kind::NormalAverage => {
                let all = total(&|e| e.size);
                sum(&|e| super::field::components(&[through(e) / all]))
            }
            Kind::Uniformity => {
                let all = total(&|e| weight(e) * e.size);
                let mean = sum(&|e| e.value.map(|x| weight(e) * e.size * x)).map(|x| x / all);
                let far =
                    |v: &dyn Fn(usize) -> f64| (0..n).map(|k| v(k) * v(k)).sum::<f64>().sqrt();
                let off = |e: &Element| weight(e) * e.size * far(&|k| e.value[k] - mean[k]);
                let whole = 2.0 * far(&|k| mean[k]) * all.abs();
                let even = if whole > 0.0 { 1.0 - total(&off) / whole } else { 1.0 };
                super::field::components(&[even.clamp(0.0, 1.0)])
            }
        }
    }
}

/// Least (`sign` -1) or greatest value of each component.
fn extreme(exec: &Exec, elements: &[Element], sign: f64) -> Components {
    let mut most = [f64::NEG_INFINITY; 9];
    for e in elements {
        most.iter_mut().zip(e.value).for_each(|(m, x)| *m = m.max(sign * x));
    }
    exec.comm().max(&mut most);
    most.map(|m| if m.is_finite() { sign * m } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_par::{Exec, Solo};

    fn of(name: &str, known: &'static [Known]) -> f64 {
        let (name, kind, weights) = *known.iter().find(|k| k.0 == name).unwrap();
        let operation = Operation { name, kind, weights, weight: None };
        let element = |value: f64, size: f64, weight: f64| Element {
            value: super::super::field::components(&[value]),
            size,
            weight,
            area: [0.0; 3],
        };
        let all = [element(1.0, 1.0, 2.0), element(3.0, 3.0, -1.0)];
        operation.of(&Exec::new(1, Box::new(Solo)), 1, &all)[0]
    }

    #[test]
    fn every_operation_weighs_as_its_name_says() {
        let cells = [
            ("min", 1.0),
            ("max", 3.0),
            ("sum", 4.0),
            ("sumMag", 4.0),
            ("average", 2.0),
            ("volAverage", 2.5),
            ("volIntegrate", 10.0),
            // Standard deviation sqrt(0.75) about 2.5.
            ("CoV", 0.75f64.sqrt() / 2.5),
            ("weightedSum", -1.0),
            ("weightedAverage", -1.0),
            ("weightedVolAverage", 7.0),
            ("weightedVolIntegrate", -7.0),
        ];
        for (name, value) in cells {
            assert!((of(name, OVER_CELLS) - value).abs() < 1e-14, "{name}");
        }
        let faces = [
            ("absWeightedSum", 5.0),
            ("absWeightedAverage", 5.0 / 3.0),
            ("absWeightedAreaAverage", 11.0 / 5.0),
            ("absWeightedAreaIntegrate", 11.0),
            ("uniformity", 1.0 - (1.5 + 1.5) / (2.0 * 2.5 * 4.0)),
        ];
        for (name, value) in faces {
            assert!((of(name, OVER_FACES) - value).abs() < 1e-14, "{name}");
        }
    }
}
