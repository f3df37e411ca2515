//! Means over time and what fluctuates about them.
//!
//! The mean of `n` steps weighs each with its length (`base time`) or the same (`base iteration`):
//! `mean = (1 - b) mean + b x` with `b` the share of the last step. `UPrime2Mean` is the mean of
//! `(x - mean)^2`, kept up to date without the earlier values: the mean of squares less the square
//! of the mean (T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983) 242).

use super::quantity::{Named, Wanted};
use super::remembered::spread;
use super::schedule::{Every, Schedule};
use super::{
    Components, Entry, Function, Info, Plan, Rank, Reading, Remembered, Values, View, Written,
};
use crate::CaseConfig;
use granflow_base::Dims;
use granflow_dict::{Reader, Sink, Span, Value, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "fieldAverage",
    summary: "the fields `<field>Mean` and `<field>Prime2Mean`: means over time, kept over restarts",
    formula: "M_n = (1 - b) M_{n-1} + b phi, prime2: P_n = (1 - b) (P_{n-1} + M_{n-1}^2) + b \
              phi^2 - M_n^2; b = dt/T (base time) or 1/n (base iteration)",
    reference: "T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983) 242",
    read: |r, reading| Box::new(FieldAverage::read(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

/// What is averaged of one field.
#[derive(Clone)]
struct Item {
    of: Named,
    prime2: bool,
    /// Whether steps weigh by their length.
    by_time: bool,
}

#[derive(Clone)]
struct FieldAverage {
    items: Vec<Item>,
    /// The fields with their place, for complaints.
    fields: Wanted,
    /// A restart begins anew.
    anew: bool,
    /// Every written time begins anew.
    anew_at_writes: bool,
    from: f64,
    to: f64,
}

impl FieldAverage {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> FieldAverage {
        let span = r.value_span("fields");
        let mut out = FieldAverage {
            items: Vec::new(),
            fields: Wanted { list: Vec::new(), span: span.clone() },
            anew: r.opt_switch("restartOnRestart", false),
            anew_at_writes: r.opt_switch("restartOnOutput", false),
            from: r.opt_scalar("timeStart", Dims::TIME, f64::NEG_INFINITY),
            to: r.opt_scalar("timeEnd", Dims::TIME, f64::INFINITY),
        };
        if r.opt_switch("periodicRestart", false) {
            let help = "`restartOnOutput yes;` begins anew at written times";
            let message = "`periodicRestart` is not supported";
            r.error_at_key("periodicRestart", message, "write `no`", Some(help));
        }
        r.ignore("restartPeriod");
        if let Some(Value::Dict(_)) = r.dict().get("fields") {
            let subs = r.opt_sub("fields").map_or(Vec::new(), |s| s.subs());
            for (name, sub) in subs {
                out.item(&sub, &span, name, reading);
            }
        } else if let Some(mut list) = r.list("fields") {
            while !list.is_empty() {
                let (at, left) = (list.here(), list.rest().len());
                let name = list.string("the name of a field");
                if let Some(sub) = list.dict("`{ mean on; prime2Mean on; base time; }`") {
                    out.item(&sub, &at, name, reading);
                }
                if list.rest().len() == left {
                    break;
                }
            }
        }
        out
    }

    fn item(&mut self, r: &Reader<'_>, at: &Span, name: &str, reading: &Reading<'_>) {
        let of = Named::read(r, at, name, reading);
        if !r.opt_switch("mean", true) {
            let message = format!("`mean` of `{name}` cannot be off: all else is measured from it");
            r.error_at_key("mean", message, "write `on`", None);
        }
        let prime2 = r.opt_switch("prime2Mean", false);
        if prime2 && !matches!(of.quantity.rank(), Rank::Scalar | Rank::Vector) {
            let message = format!("`{name}` is a tensor: it has no prime2Mean");
            r.error_at_key("prime2Mean", message, "of scalars and vectors only", None);
        }
        for key in ["window", "windowName", "windowType", "allowRestart"] {
            if r.has(key) && r.opt_word(key, "none") != "none" {
                let help = "leave it out: the mean is over all steps; `timeStart` begins it later";
                let message = format!("`{key}` is not supported");
                r.error_at_key(key, message, "no moving windows", Some(help));
            }
        }
        let by_time = r.opt_one_of("base", &[("time", true), ("iteration", false)], true);
        self.fields.list.push(of.clone());
        self.items.push(Item { of, prime2, by_time });
    }
}

impl Plan for FieldAverage {
    fn check(&self, _: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
    }
    fn makes(&self) -> Vec<Info> {
        let mut out = Vec::new();
        for Item { of, prime2, .. } in &self.items {
            let (rank, unit, on_faces) = (of.quantity.rank(), of.unit, of.on_faces);
            out.push(Info { name: format!("{}Mean", of.name), rank, unit, on_faces });
            if *prime2 {
                let rank = if rank == Rank::Vector { Rank::SymmTensor } else { Rank::Scalar };
                let (name, unit) = (format!("{}Prime2Mean", of.name), unit.times(unit));
                out.push(Info { name, rank, unit, on_faces });
            }
        }
        out
    }
    fn uses(&self) -> Vec<usize> {
        self.fields.uses()
    }
    fn remembers(&self) -> bool {
        true
    }
    fn build(&self, mesh: &Mesh, _: &Exec, earlier: Option<&Remembered>) -> Box<dyn Function> {
        let makes = self.makes();
        let mut values: Vec<Values> = makes.iter().map(|info| Values::new(mesh, info)).collect();
        let mut sums = vec![Sum::default(); self.items.len()];
        if let Some(earlier) = earlier.filter(|_| !self.anew) {
            for (v, whole) in values.iter_mut().zip(&earlier.fields) {
                spread(mesh, whole, v);
            }
            for (sum, item) in sums.iter_mut().zip(&self.items) {
                let Some(d) = earlier.memory.sub(&item.of.name) else { continue };
                sum.steps = d.number("totalIter").unwrap_or(0.0);
                sum.time = d.number("totalTime").unwrap_or(0.0);
            }
        }
        Box::new(Averages { plan: self.clone(), values, sums })
    }
}

/// What a mean is made of.
#[derive(Clone, Copy, Default)]
struct Sum {
    /// Steps.
    steps: f64,
    /// Their length, s.
    time: f64,
}

struct Averages {
    plan: FieldAverage,
    values: Vec<Values>,
    sums: Vec<Sum>,
}

/// The square of `x`: a symmetric tensor of a vector.
fn square(rank: Rank, x: &Components) -> Components {
    let [a, b, c, ..] = *x;
    match rank {
        Rank::Vector => [a * a, a * b, a * c, b * b, b * c, c * c, 0.0, 0.0, 0.0],
        _ => [a * a, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    }
}

/// Takes `x` with the share `b` into a mean and, if it is kept, the mean of squares about it.
fn take(rank: Rank, b: f64, x: &Components, mean: &mut [f64], prime2: Option<&mut [f64]>) {
    let old = super::field::components(mean);
    for (m, x) in mean.iter_mut().zip(x) {
        *m = (1.0 - b) * *m + b * x;
    }
    let Some(prime2) = prime2 else { return };
    let new = super::field::components(mean);
    let (old, new, now) = (square(rank, &old), square(rank, &new), square(rank, x));
    for (k, p) in prime2.iter_mut().enumerate() {
        *p = (1.0 - b) * (*p + old[k]) + b * now[k] - new[k];
    }
}

impl Function for Averages {
    fn needs_derived(&self) -> bool {
        self.plan.fields.derived()
    }
    fn execute(&mut self, view: &View<'_>) {
        if view.time < self.plan.from || view.time > self.plan.to {
            return;
        }
        let mesh = view.mesh;
        let mut values = self.values.iter_mut();
        for (item, sum) in self.plan.items.iter().zip(&mut self.sums) {
            let Some(mean) = values.next() else { return };
            let mut prime2 = if item.prime2 { values.next() } else { None };
            sum.steps += 1.0;
            sum.time += view.dt;
            // Of the first step the mean is the step itself, to the bit.
            let b = match item.by_time {
                _ if sum.steps == 1.0 => 1.0,
                true => view.dt / sum.time,
                false => 1.0 / sum.steps,
            };
            let (q, n) = (item.of.quantity, mean.n);
            for c in 0..mesh.n_cells {
                let p = prime2.as_mut().map(|p| &mut p.cells[p.n * c..p.n * (c + 1)]);
                let mean = &mut mean.cells[n * c..n * (c + 1)];
                take(q.rank(), b, &view.cell(q, c), mean, p);
            }
            for i in 0..mean.faces.len() / n {
                let p = prime2.as_mut().map(|p| &mut p.faces[p.n * i..p.n * (i + 1)]);
                let mean = &mut mean.faces[n * i..n * (i + 1)];
                take(q.rank(), b, &view.on_boundary(q, mesh.n_inner + i), mean, p);
            }
            mean.update_ghosts(view.exec, mesh);
            if let Some(p) = prime2 {
                p.update_ghosts(view.exec, mesh);
            }
        }
    }
    fn fields(&self) -> &[Values] {
        &self.values
    }
    fn ready(&self) -> bool {
        self.sums.iter().any(|s| s.steps > 0.0)
    }
    fn sample(&mut self, _: &View<'_>) -> Vec<Written> {
        Vec::new()
    }
    fn written(&mut self) {
        if self.plan.anew_at_writes {
            self.sums.fill(Sum::default());
        }
    }
    fn memory(&self) -> Vec<(String, Vec<(&'static str, String)>)> {
        let entry = |(item, sum): (&Item, &Sum)| {
            let kept = if self.plan.anew_at_writes { Sum::default() } else { *sum };
            let entries = [("totalIter", kept.steps), ("totalTime", kept.time)];
            (item.of.name.clone(), entries.map(|(key, x)| (key, number(x))).to_vec())
        };
        self.plan.items.iter().zip(&self.sums).map(entry).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_any_length_make_the_mean_and_the_variance() {
        let (steps, values) = ([0.1, 0.3, 0.2, 0.4], [2.0, -1.0, 5.0, 0.5]);
        let (mut mean, mut prime2, mut time) = ([0.0], [0.0], 0.0);
        for (dt, x) in steps.iter().zip(values) {
            time += dt;
            let x = super::super::field::components(&[x]);
            take(Rank::Scalar, dt / time, &x, &mut mean, Some(&mut prime2));
        }
        let exact: f64 = steps.iter().zip(values).map(|(dt, x)| dt * x).sum();
        let spread: f64 =
            steps.iter().zip(values).map(|(dt, x)| dt * (x - exact) * (x - exact)).sum();
        assert!((mean[0] - exact).abs() < 1e-14, "{mean:?} {exact}");
        assert!((prime2[0] - spread).abs() < 1e-14, "{prime2:?} {spread}");
    }
}
