//! Sums, means and extremes of fields over a patch, a zone of faces or a cut: what flows through it, for
//! instance.

use super::cut::{Cut, CutPlan};
use super::face_zone::{FaceZonePlan, Side};
use super::field::{Components, components};
use super::operations::{Element, OVER_FACES, Operation};
use super::patches::Patches;
use super::quantity::{Named, Quantity, Wanted};
use super::schedule::{Every, Schedule};
use super::{Around, Entry, Function, Plan, Rank, Reading, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::Dims;
use granflow_dict::{Diag, Reader, Sink, Span, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "surfaceFieldValue",
    summary: "sum, mean, integral, variation or extremes of fields over a patch, a zone of faces or a sampled surface",
    formula: "sum: sum w phi_f; average: sum w phi_f/sum w; areaIntegrate: sum w phi_f |S|; \
              areaAverage: sum w phi_f |S|/sum w |S|; areaNormalIntegrate: sum U_f . S; CoV: \
              sqrt(sum |S| (phi_f - m)^2/A)/m; uniformity: 1 - sum |S| |phi_f - m|/(2 |m| A); \
              w = 1, the weightField, or its size (absWeighted)",
    reference: "OpenFOAM user guide, function objects",
    read: |r, reading| Box::new(SurfaceFieldValue::read(r, reading)),
    schedule: Schedule::always(Every::Steps(1)),
};

/// A field on faces.
#[derive(Clone)]
enum OnFaces {
    /// Volume flux outwards, m3/s.
    Phi,
    /// Mass flux outwards, kg/s.
    RhoPhi,
    /// A field.
    Of(Quantity),
}

impl OnFaces {
    fn read(r: &Reader<'_>, span: &Span, name: &str, reading: &Reading<'_>) -> OnFaces {
        match name {
            "phi" => OnFaces::Phi,
            "rhoPhi" => OnFaces::RhoPhi,
            _ => OnFaces::Of(Named::read(r, span, name, reading).quantity),
        }
    }
    fn rank(&self) -> Rank {
        match self {
            OnFaces::Of(q) => q.rank(),
            _ => Rank::Scalar,
        }
    }
    fn at(&self, view: &View<'_>, f: usize) -> Components {
        match self {
            OnFaces::Phi => components(&[view.phi[f]]),
            OnFaces::RhoPhi => components(&[view.mass_flux.map_or(0.0, |m| m[f])]),
            OnFaces::Of(q) => view.on_boundary(*q, f),
        }
    }
}

/// Where values are taken.
#[derive(Clone)]
enum Region {
    Patch(Patches),
    Zone(FaceZonePlan),
    Cut(CutPlan),
}

#[derive(Clone)]
struct SurfaceFieldValue {
    region: Region,
    /// Its name in the table.
    name: String,
    fields: Vec<(String, OnFaces)>,
    /// The fields of the flow among them, and the one that weighs.
    wanted: Wanted,
    operation: Operation,
    factor: f64,
}

impl SurfaceFieldValue {
    fn read(r: &Reader<'_>, reading: &Reading<'_>) -> SurfaceFieldValue {
        r.ignore("surfaceFormat");
        if r.opt_switch("writeFields", false) && r.opt_word("surfaceFormat", "none") != "none" {
            let message = "`writeFields` writes no surfaces: the function `surfaces` does";
            r.warn_at_key("writeFields", message, "not written", None);
        }
        let kinds = [
            ("patch", 0),
            ("sampledSurface", 1),
            ("faceZone", 2),
            ("surface", 3),
            ("functionObjectSurface", 3),
        ];
        let kind = r.one_of("regionType", &kinds);
        if kind == 3 {
            let help =
                "write `regionType sampledSurface;` with the surface in `sampledSurfaceDict`";
            let message = "surfaces of other functions are not read";
            r.error_at_key("regionType", message, "refused", Some(help));
        }
        let region = match kind {
            1 => match r.sub("sampledSurfaceDict") {
                Some(sub) => {
                    Region::Cut(CutPlan::read(&sub, r.opt_word("name", "surface"), reading))
                }
                None => Region::Patch(Patches::or_walls(r, "sampledSurfaceDict")),
            },
            2 => Region::Zone(FaceZonePlan::read(r)),
            _ => Region::Patch(Patches::read(r, "name")),
        };
        let span = r.value_span("fields");
        let names = r.words("fields");
        let fields: Vec<(String, OnFaces)> = names
            .into_iter()
            .map(|w| (w.to_owned(), OnFaces::read(r, &span, w, reading)))
            .collect();
        let found = fields.iter().filter_map(|(name, _)| Named::find(name, reading));
        let mut wanted = Wanted { list: found.collect(), span };
        let operation = Operation::read(r, OVER_FACES, reading);
        operation.check(r, &wanted.list);
        wanted.list.extend(operation.weight.iter().flat_map(|w| w.list.clone()));
        SurfaceFieldValue {
            region,
            name: r.opt_word("name", "surface").to_owned(),
            fields,
            wanted,
            operation,
            factor: r.opt_scalar("scaleFactor", Dims::NONE, 1.0),
        }
    }
}

impl Plan for SurfaceFieldValue {
    fn wants_zones(&self) -> bool {
        matches!(self.region, Region::Zone(_))
    }
    fn place(&mut self, around: &Around<'_>, sink: &Sink) {
        let Region::Zone(zone) = &mut self.region else { return };
        zone.place(around, sink);
        if let (Some(field), true) = (self.wanted.list.first(), zone.inside(around.poly.n_inner()))
        {
            let message =
                format!("`{}` has no values on the faces between cells in this zone", field.name);
            let help = "there are `phi` and `rhoPhi`; fields are known on patches and on a `sampledSurface`";
            sink.push(Diag::error(&self.wanted.span, message).label("a field of cells").help(help));
        }
    }
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        match &self.region {
            Region::Patch(patches) => {
                patches.check(mesh, sink);
                patches.check_open(mesh, sink);
            }
            Region::Zone(_) => {}
            Region::Cut(cut) => cut.check(mesh, config, sink),
        }
        self.wanted.check(config, sink);
        for (name, field) in &self.fields {
            let why = match field {
                OnFaces::RhoPhi if config.transport.second.is_none() => "it has one phase only",
                OnFaces::Phi | OnFaces::RhoPhi if matches!(self.region, Region::Cut(_)) => {
                    "fluxes are known on patches: use `areaNormalIntegrate` of `U`"
                }
                _ => continue,
            };
            let message = format!("the case has no field `{name}` there");
            sink.push(Diag::error(&self.wanted.span, message).label(why));
        }
    }
    fn uses(&self) -> Vec<usize> {
        let mut all = self.wanted.uses();
        if let Region::Cut(cut) = &self.region {
            all.extend(cut.uses());
        }
        all
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        let patches = match &self.region {
            Region::Patch(patches) => patches.indices(mesh),
            Region::Zone(_) | Region::Cut(_) => Vec::new(),
        };
        Box::new(Placed { patches, sides: None, cut: None, plan: self.clone() })
    }
}

struct Placed {
    plan: SurfaceFieldValue,
    /// Numbers of the patches in the mesh.
    patches: Vec<usize>,
    /// The faces of the zone, on the first rank.
    sides: Option<Vec<Side>>,
    /// The surface where it was cut last, on the first rank.
    cut: Option<Cut>,
}

impl Placed {
    /// The faces of the patches with one field, on this rank.
    fn on_patches(&self, view: &View<'_>, field: &OnFaces) -> Vec<Element> {
        let weight = self.plan.operation.weight.as_ref().map(|w| w.list[0].quantity);
        let faces = self.patches.iter().flat_map(|i| view.mesh.patches[*i].faces.clone());
        let element = |f: usize| Element {
            value: field.at(view, f).map(|x| self.plan.factor * x),
            size: view.mesh.mag_area[f],
            weight: weight.map_or(1.0, |w| view.on_boundary(w, f)[0]),
            area: view.mesh.area[f],
        };
        faces.map(element).collect()
    }

    /// The faces of the zone with one field, all of them on the first rank.
    fn on_zone(&self, view: &View<'_>, field: &OnFaces) -> Vec<Element> {
        let of = |field: &OnFaces| -> Vec<Components> {
            let collector = view.whole.collector;
            let gathered = |flux: &[f64]| collector.faces(view.exec, flux, true);
            let sides = self.sides.iter().flatten();
            match field {
                OnFaces::Phi => gathered(view.phi).map(|all| sides.map(|s| s.flux(&all)).collect()),
                OnFaces::RhoPhi => {
                    let flux = view.mass_flux.and_then(gathered);
                    flux.map(|all| sides.map(|s| s.flux(&all)).collect())
                }
                OnFaces::Of(q) => {
                    let all = view.everywhere(*q);
                    all.map(|all| sides.map(|s| s.value(view, &all)).collect())
                }
            }
            .unwrap_or_default()
        };
        let weight = self.plan.operation.weight.as_ref().map(|w| OnFaces::Of(w.list[0].quantity));
        let weights = weight.as_ref().map(of);
        let values = of(field);
        let element = |(i, side): (usize, &Side)| {
            let area = side.area(&view.whole.case.mesh);
            Element {
                value: values[i].map(|x| self.plan.factor * x),
                size: granflow_base::norm(area),
                weight: weights.as_ref().map_or(1.0, |w| w[i][0]),
                area,
            }
        };
        self.sides.iter().flatten().enumerate().map(element).collect()
    }

    /// The faces of the cut with one field, all of them on the first rank.
    fn on_cut(&self, view: &View<'_>, field: &OnFaces) -> Vec<Element> {
        let OnFaces::Of(q) = field else { return Vec::new() };
        let of = |q: Quantity| {
            let everywhere = view.everywhere(q);
            let (Some(everywhere), Some(cut)) = (everywhere, &self.cut) else { return Vec::new() };
            cut.on_faces(view.grid(), &everywhere)
        };
        let weights = self.plan.operation.weight.as_ref().map(|w| of(w.list[0].quantity));
        let values = of(*q);
        let Some(cut) = &self.cut else { return Vec::new() };
        let areas = cut.areas();
        let element = |(i, area): (usize, [f64; 3])| Element {
            value: values[i].map(|x| self.plan.factor * x),
            size: granflow_base::norm(area),
            weight: weights.as_ref().map_or(1.0, |w| w[i][0]),
            area,
        };
        areas.into_iter().enumerate().map(element).collect()
    }
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        self.plan.wanted.derived()
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        if self.plan.operation.idle() {
            return Vec::new();
        }
        match &self.plan.region {
            Region::Cut(plan) => plan.update(view, &mut self.cut),
            Region::Zone(zone) if view.exec.rank() == 0 => {
                self.sides.get_or_insert_with(|| zone.sides(&view.whole.case.mesh));
            }
            Region::Zone(_) | Region::Patch(_) => {}
        }
        let mut values = Vec::new();
        let mut size = [0.0; 2];
        for (_, field) in &self.plan.fields {
            let elements = match self.plan.region {
                Region::Patch(_) => self.on_patches(view, field),
                Region::Zone(_) => self.on_zone(view, field),
                Region::Cut(_) => self.on_cut(view, field),
            };
            size = [elements.len() as f64, elements.iter().map(|e| e.size).sum()];
            let rank = field.rank();
            let v = self.plan.operation.of(view.exec, rank.n(), &elements);
            values.push(columns::value(self.plan.operation.rank(rank).unwrap_or(rank), &v));
        }
        view.exec.comm().sum(&mut size);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let operation = &self.plan.operation;
        let kind = match self.plan.region {
            Region::Patch(_) => "patch",
            Region::Zone(_) => "faceZone",
            Region::Cut(_) => "sampledSurface",
        };
        let mut header = columns::property("Region type", &format!("{kind} {}", self.plan.name));
        header += &columns::property("Faces", &number(size[0]));
        header += &columns::property("Area", &number(size[1]));
        header += &columns::property("Scale factor", &number(self.plan.factor));
        if let Some(w) = &operation.weight {
            header += &columns::property("Weight field", &w.list[0].name);
        }
        let heads = self.plan.fields.iter().map(|(name, _)| format!("{}({name})", operation.name));
        header += &columns::head(&heads.collect::<Vec<_>>());
        let line = columns::row(view, &values);
        vec![Written::Line { file: "surfaceFieldValue.dat".into(), header, line }]
    }
}
