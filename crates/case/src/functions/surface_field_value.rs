//! Sums, means and extremes of fields over a patch: what flows through it, for instance.

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Quantity, View, Written, columns};
use crate::CaseConfig;
use granflow_base::{Vec3, add, scale};
use granflow_dict::{Diag, Reader, Sink, Span, nearest, number};
use granflow_mesh::{Mesh, PatchKind};
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "surfaceFieldValue",
    summary: "sum, mean, integral or extremes of fields over the faces of a patch",
    reference: "OpenFOAM user guide, function objects",
    read: |r, _| Box::new(SurfaceFieldValue::read(r)),
    schedule: Schedule::always(Every::Steps(1)),
};

/// What is made of the values on the faces.
#[derive(Clone, Copy, PartialEq)]
enum Operation {
    Sum,
    SumMag,
    Average,
    AreaAverage,
    AreaIntegrate,
    Min,
    Max,
}

impl Operation {
    const ALL: &[(&str, Operation)] = &[
        ("sum", Operation::Sum),
        ("sumMag", Operation::SumMag),
        ("average", Operation::Average),
        ("areaAverage", Operation::AreaAverage),
        ("areaIntegrate", Operation::AreaIntegrate),
        ("min", Operation::Min),
        ("max", Operation::Max),
    ];
    fn name(self) -> &'static str {
        Self::ALL.iter().find(|o| o.1 == self).map_or("", |o| o.0)
    }
}

/// A field on boundary faces.
#[derive(Clone, Copy)]
enum OnFaces {
    /// Volume flux outwards, m3/s.
    Phi,
    /// Mass flux outwards, kg/s.
    RhoPhi,
    /// A field with a condition on the patch.
    Of(Quantity),
}

impl OnFaces {
    const ALL: &[(&str, OnFaces)] = &[
        ("phi", OnFaces::Phi),
        ("rhoPhi", OnFaces::RhoPhi),
        ("U", OnFaces::Of(Quantity::U)),
        ("p", OnFaces::Of(Quantity::P)),
        ("p_rgh", OnFaces::Of(Quantity::PRgh)),
    ];
    fn n(self) -> usize {
        if matches!(self, OnFaces::Of(Quantity::U)) { 3 } else { 1 }
    }
    fn at(self, view: &View<'_>, f: usize) -> Vec3 {
        match self {
            OnFaces::Phi => [view.phi[f], 0.0, 0.0],
            OnFaces::RhoPhi => [view.mass_flux.map_or(0.0, |m| m[f]), 0.0, 0.0],
            OnFaces::Of(q) => view.boundary(q, f).unwrap_or([0.0; 3]),
        }
    }
}

#[derive(Clone)]
struct SurfaceFieldValue {
    patch: String,
    patch_span: Span,
    operation: Operation,
    fields: Vec<(String, OnFaces)>,
    fields_span: Span,
}

impl SurfaceFieldValue {
    fn read(r: &Reader<'_>) -> Self {
        for key in ["writeFields", "writeArea", "surfaceFormat"] {
            r.ignore(key);
        }
        for (key, plain) in
            [("weightField", "none"), ("scaleFactor", "1"), ("postOperation", "none")]
        {
            if r.raw(key).is_some_and(|t| t.len() != 1 || t[0].describe() != plain) {
                r.ignore(key);
                let help = "sum, means, integral and extremes are there";
                let message = format!("`{key}` is not supported");
                r.error_at_key(key, message, "set here", Some(help));
            }
        }
        r.one_of("regionType", &[("patch", ())]);
        let fields_span = r.value_span("fields");
        let mut fields = Vec::new();
        for w in r.words("fields") {
            let alpha = w.starts_with("alpha.").then_some(OnFaces::Of(Quantity::Alpha));
            let known = OnFaces::ALL.iter().find(|f| f.0 == w).map(|f| f.1);
            if let Some(field) = alpha.or(known) {
                fields.push((w.to_owned(), field));
                continue;
            }
            let names = OnFaces::ALL.iter().map(|f| f.0);
            let near = nearest(w, names.clone());
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let known: Vec<&str> = names.collect();
            let help = format!("{near}known on patches are {}, alpha", known.join(", "));
            r.error_at(&fields_span, format!("unknown field `{w}`"), "not known", Some(&help));
        }
        SurfaceFieldValue {
            patch_span: r.value_span("name"),
            patch: r.word("name").to_owned(),
            operation: r.one_of("operation", Operation::ALL),
            fields,
            fields_span,
        }
    }
}

impl Plan for SurfaceFieldValue {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        if !mesh.patches.iter().any(|p| p.name == self.patch) {
            let names = mesh.patches.iter().map(|p| p.name.as_str());
            let known: Vec<&str> = names.clone().collect();
            let help = nearest(&self.patch, names).map_or_else(
                || format!("the patches are {}", known.join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            let message = format!("the mesh has no patch `{}`", self.patch);
            sink.push(Diag::error(&self.patch_span, message).label("no such patch").help(help));
        }
        if mesh.patches.iter().any(|p| p.name == self.patch && p.kind == PatchKind::Empty) {
            let message = format!("nothing passes patch `{}`: it is empty", self.patch);
            let help = "choose a patch of the directions that are solved for";
            sink.push(Diag::error(&self.patch_span, message).label("of type empty").help(help));
        }
        for (name, field) in &self.fields {
            let why = match field {
                OnFaces::RhoPhi | OnFaces::Of(Quantity::Alpha)
                    if config.transport.second.is_none() =>
                {
                    "it has one phase only"
                }
                OnFaces::Of(Quantity::PRgh) if config.pressure() == "p" => {
                    "the case has no gravity: use `p`"
                }
                _ => continue,
            };
            let message = format!("the case has no field `{name}`");
            sink.push(Diag::error(&self.fields_span, message).label(why));
        }
    }
    fn build(&self, mesh: &Mesh, _: &Exec) -> Box<dyn Function> {
        let patch = mesh.patches.iter().position(|p| p.name == self.patch);
        Box::new(Placed { patch, plan: self.clone() })
    }
}

struct Placed {
    plan: SurfaceFieldValue,
    /// Its index in the mesh.
    patch: Option<usize>,
}

impl Placed {
    /// The value of one field over the patch, on all ranks.
    fn value(&self, view: &View<'_>, field: OnFaces, count: f64, area: f64) -> Vec3 {
        use Operation::{AreaAverage, AreaIntegrate, Average, Max, Min, Sum, SumMag};
        let faces = self.patch.map_or(0..0, |i| view.mesh.patches[i].faces.clone());
        let operation = self.plan.operation;
        if matches!(operation, Min | Max) {
            let sign = if operation == Max { 1.0 } else { -1.0 };
            let mut most = [f64::NEG_INFINITY; 3];
            for f in faces {
                let v = field.at(view, f);
                (0..3).for_each(|k| most[k] = most[k].max(sign * v[k]));
            }
            view.exec.comm().max(&mut most);
            return scale(most, sign);
        }
        let mut sum = [0.0; 3];
        for f in faces {
            let v = field.at(view, f);
            sum = add(
                sum,
                match operation {
                    AreaAverage | AreaIntegrate => scale(v, view.mesh.mag_area[f]),
                    SumMag => v.map(f64::abs),
                    _ => v,
                },
            );
        }
        view.exec.comm().sum(&mut sum);
        match operation {
            Average => scale(sum, 1.0 / count.max(1.0)),
            AreaAverage => scale(sum, 1.0 / area.max(f64::MIN_POSITIVE)),
            Sum | SumMag | AreaIntegrate | Min | Max => sum,
        }
    }
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        false
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let faces = self.patch.map_or(0..0, |i| view.mesh.patches[i].faces.clone());
        let mut size = [faces.len() as f64, faces.map(|f| view.mesh.mag_area[f]).sum::<f64>()];
        view.exec.comm().sum(&mut size);
        let [count, area] = size;
        let fields = self.plan.fields.iter();
        let values: Vec<String> = fields
            .map(|(_, field)| {
                let v = self.value(view, *field, count, area);
                if field.n() == 3 { columns::vector(v) } else { number(v[0]) }
            })
            .collect();
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let operation = self.plan.operation.name();
        let names = self.plan.fields.iter().map(|(name, _)| format!("{operation}({name})"));
        let names: Vec<String> = names.collect();
        vec![Written::Line {
            file: "surfaceFieldValue.dat",
            header: format!(
                "# Region type : patch {}\n# Faces       : {count}\n# Area        : {}\n# Time\t{}",
                self.plan.patch,
                number(area),
                names.join("\t")
            ),
            line: format!("{}\t{}", view.time_name, values.join("\t")),
        }]
    }
}
