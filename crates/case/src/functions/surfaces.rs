//! Fields on surfaces: planes through the mesh, patches, surfaces of equal value.

use super::cut::{Cut, CutPlan};
use super::quantity::Wanted;
use super::schedule::{Every, Schedule};
use super::surface_format::{OnSurface, SurfaceFormat, files};
use super::{Entry, Function, Plan, Reading, Remembered, View, Written};
use crate::CaseConfig;
use granflow_dict::{Reader, Sink, Value};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "surfaces",
    summary: "fields on planes, patches, surfaces of equal value and of equal distance from a plane or sphere, as `.vtp` or columns",
    formula: "interpolate false: phi_P of the cell that is cut (phi_f on a patch); interpolate \
              true: the linear function that fits the cells around each point",
    reference: "OpenFOAM user guide, sampling; A. Doi, A. Koide, IEICE Trans. E74 (1991) 214",
    read: |r, reading| Box::new(Surfaces::read(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

#[derive(Clone)]
struct Surfaces {
    fields: Wanted,
    surfaces: Vec<CutPlan>,
    format: SurfaceFormat,
}

impl Surfaces {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> Surfaces {
        // What OpenFOAM's surfaces.cfg defines for macros.
        for key in ["x", "y", "z", "origin", "cuttingPlane", "isosurface", "patchSurface"] {
            r.ignore(key);
        }
        let schemes = ["cell", "cellPoint", "cellPointFace"].map(|s| (s, ()));
        r.opt_one_of("interpolationScheme", &schemes, ());
        let mut surfaces = Vec::new();
        if matches!(r.dict().get("surfaces"), Some(Value::Dict(_))) {
            let subs = r.opt_sub("surfaces").map_or(Vec::new(), |s| s.subs());
            surfaces.extend(subs.iter().map(|(name, sub)| CutPlan::read(sub, name, reading)));
        } else if let Some(mut list) = r.list("surfaces") {
            while !list.is_empty() {
                let left = list.rest().len();
                let name = list.word("the name of a surface");
                if let Some(sub) = list.dict("a surface") {
                    surfaces.push(CutPlan::read(&sub, name, reading));
                }
                if list.rest().len() == left {
                    break;
                }
            }
        }
        Surfaces {
            fields: Wanted::read(r, "fields", reading),
            surfaces,
            format: SurfaceFormat::read(r),
        }
    }
}

impl Plan for Surfaces {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.fields.check(config, sink);
        self.surfaces.iter().for_each(|s| s.check(mesh, config, sink));
    }
    fn uses(&self) -> Vec<usize> {
        let own = self.surfaces.iter().flat_map(CutPlan::uses);
        self.fields.uses().into_iter().chain(own).collect()
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        let cuts = self.surfaces.iter().map(|_| None).collect();
        Box::new(Placed { plan: self.clone(), cuts })
    }
}

struct Placed {
    plan: Surfaces,
    /// The surfaces where they were cut last, on the first rank.
    cuts: Vec<Option<Cut>>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        self.plan.fields.derived() || self.plan.surfaces.iter().any(CutPlan::derived)
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        for (plan, cut) in self.plan.surfaces.iter().zip(&mut self.cuts) {
            plan.update(view, cut);
        }
        let list = &self.plan.fields.list;
        let all: Vec<_> = list.iter().filter_map(|f| view.everywhere(f.quantity)).collect();
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let mut out = Vec::new();
        for (plan, cut) in self.plan.surfaces.iter().zip(&self.cuts) {
            let Some(cut) = cut else { continue };
            let on = |(field, all)| OnSurface {
                field,
                values: match plan.interpolate {
                    true => cut.on_points(view.grid(), all),
                    false => cut.on_faces(view.grid(), all),
                },
            };
            let fields: Vec<OnSurface<'_>> = list.iter().zip(&all).map(on).collect();
            let format = self.plan.format;
            out.extend(files(format, &plan.name, view.time, cut, plan.interpolate, &fields));
        }
        out
    }
}
