//! Forces and moments of the flow on patches.
//!
//! The viscous part is the very sum of face fluxes that the momentum equation holds: the compact
//! normal derivative times the viscosity on the face, and the transpose part. Forces on all
//! patches therefore balance to the solver's tolerance.

use super::patches::Patches;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::{Dims, Vec3, add, cross, scale, sub};
use granflow_dict::{Diag, Reader, Sink, Span};
use granflow_fv::{FaceField, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "forces",
    summary: "pressure and viscous force and moment of the flow on patches",
    formula: "F = sum (p_f - pRef) S - tau . S over the patches, M = sum (x_f - CofR) x dF; \
              tau = eta (grad U + grad U^T)",
    reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 9",
    read: |r, _| Box::new(Forces::read(r)),
    schedule: Schedule::always(Every::Steps(1)),
};

/// What forces are made of.
#[derive(Clone)]
pub(super) struct Forces {
    patches: Patches,
    pub(super) centre: Vec3,
    /// Pressure outside, Pa.
    p_ref: f64,
    /// Density that forces are computed with, in place of the case's, kg/m3.
    pub(super) rho_inf: Option<f64>,
    rho_span: Span,
}

impl Forces {
    pub(super) fn read(r: &Reader<'_>) -> Forces {
        for key in ["p", "U", "writeFields", "binData", "nBin", "binDir", "cumulative"] {
            r.ignore(key);
        }
        if r.opt_switch("porosity", false) {
            r.error_at_key("porosity", "nothing is porous here", "write `no`", None);
        }
        if r.opt_switch("directForceDensity", false) {
            let help = "forces follow from `U`, `p` and the viscosity";
            let message = "`directForceDensity` is not supported";
            r.error_at_key("directForceDensity", message, "write `no`", Some(help));
        }
        let given = r.opt_word("rho", "rhoInf") == "rhoInf";
        let rho_inf = r.maybe_scalar("rhoInf", Dims::NONE).filter(|_| given);
        if rho_inf.is_some_and(|rho| rho <= 0.0) {
            r.error_at_key("rhoInf", "a density is positive", "not positive", None);
        }
        if let Some(own) = r.opt_sub("coordinateSystem") {
            own.ignore_all();
            let help = "give `CofR`; axes are those of the mesh";
            let message = "`coordinateSystem` is not supported";
            r.error_at_key("coordinateSystem", message, "refused", Some(help));
        }
        Forces {
            patches: Patches::read(r, "patches"),
            centre: r.opt_vector("CofR", Dims::LENGTH, [0.0; 3]),
            p_ref: r.opt_scalar("pRef", Dims::NONE, 0.0),
            rho_inf,
            rho_span: r.value_span("rhoInf"),
        }
    }

    pub(super) fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.patches.check(mesh, sink);
        if self.rho_inf.is_some() && config.transport.second.is_some() {
            let message =
                "two fluids have the densities of their own, and `rhoInf` changes nothing";
            sink.push(Diag::warning(&self.rho_span, message).label("has no effect"));
        }
    }

    pub(super) fn sum(&self, mesh: &Mesh) -> Sum {
        Sum {
            patches: self.patches.indices(mesh),
            transpose: FaceField::new(mesh, "transposeStress", Dims::FORCE, [0.0; 3]),
            plan: self.clone(),
        }
    }
}

/// Forces on the patches of one rank's mesh.
pub(super) struct Sum {
    plan: Forces,
    patches: Vec<usize>,
    transpose: FaceField<Vec3>,
}

impl Plan for Forces {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        Forces::check(self, mesh, config, sink);
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Placed { sum: self.sum(mesh) })
    }
}

struct Placed {
    sum: Sum,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        true
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let [pressure, viscous, turn_pressure, turn_viscous] = self.sum.total(view);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let table = |file: &str, title: &str, p: Vec3, v: Vec3| Written::Line {
            file: file.into(),
            header: format!(
                "# {title:<12}\n{}#\n# {:<12}\t(total_x total_y total_z)\t(pressure_x pressure_y \
                 pressure_z)\t(viscous_x viscous_y viscous_z)",
                columns::property("CofR", &columns::vector(self.sum.plan.centre)),
                "Time"
            ),
            line: columns::row(view, &[add(p, v), p, v].map(columns::vector)),
        };
        vec![
            table("force.dat", "Force", pressure, viscous),
            table("moment.dat", "Moment", turn_pressure, turn_viscous),
        ]
    }
}

impl Sum {
    /// Pressure and viscous force, pressure and viscous moment, of all ranks; N and N m.
    pub(super) fn total(&mut self, view: &View<'_>) -> [Vec3; 4] {
        let (mesh, d) = (view.mesh, view.derived);
        let mut sum = [[0.0; 3]; 4];
        let rho = view.whole.case.config.transport.rho;
        let alone = view.alpha.is_none() && view.whole.case.start.kinematic();
        // The fluid's forces, were its density another one.
        let factor = self.plan.rho_inf.filter(|_| alone).map_or(1.0, |other| other / rho);
        if let Some(eta) = &d.viscosity_f {
            let out = &mut self.transpose;
            operators::transpose_stress_flux(view.exec, mesh, view.u, &d.gradient_u, eta, out);
            for &i in &self.patches {
                for f in mesh.patches[i].faces.clone() {
                    let p = scale(mesh.area[f], view.pressure_at(f) - self.plan.p_ref / factor);
                    let slope = operators::normal_derivative(mesh, view.u, None, f);
                    let traction =
                        add(scale(slope, eta.data[f] * mesh.mag_area[f]), self.transpose.data[f]);
                    // What the wall does to the flow, reversed.
                    let v = scale(traction, -1.0);
                    let arm = sub(mesh.face_centre[f], self.plan.centre);
                    for (sum, part) in sum.iter_mut().zip([p, v, cross(arm, p), cross(arm, v)]) {
                        *sum = add(*sum, part);
                    }
                }
            }
        }
        let mut flat: Vec<f64> = sum.iter().flatten().map(|x| factor * x).collect();
        view.exec.comm().sum(&mut flat);
        std::array::from_fn(|k| [flat[3 * k], flat[3 * k + 1], flat[3 * k + 2]])
    }
}
