//! Forces and moments of the flow on patches.
//!
//! The viscous part is the very sum of face fluxes that the momentum equation holds: the compact
//! normal derivative times the viscosity on the face, and the transpose part. Forces on all
//! patches therefore balance to the solver's tolerance.

use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, View, Written, columns};
use crate::CaseConfig;
use granflow_base::{Dims, Vec3, add, cross, scale, sub};
use granflow_dict::{Diag, Reader, Sink, Span, nearest};
use granflow_fv::{FaceField, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "forces",
    summary: "pressure and viscous force and moment of the flow on patches",
    reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 9",
    read: |r, name| Box::new(Forces::read(r, name)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct Forces {
    patches: Vec<String>,
    span: Span,
    centre: Vec3,
    p_ref: f64,
}

impl Forces {
    fn read(r: &Reader<'_>, _: &str) -> Forces {
        for key in ["rho", "rhoInf", "p", "U", "porosity", "directForceDensity", "writeFields"] {
            r.ignore(key);
        }
        Forces {
            patches: r.words("patches").into_iter().map(str::to_owned).collect(),
            span: r.value_span("patches"),
            centre: r.opt_vector("CofR", Dims::LENGTH, [0.0; 3]),
            p_ref: r.opt_scalar("pRef", Dims::NONE, 0.0),
        }
    }
    fn indices(&self, mesh: &Mesh) -> Vec<usize> {
        let wanted = |p: &granflow_mesh::Patch| {
            self.patches.iter().any(|w| *w == p.name || p.in_groups.contains(w))
        };
        (0..mesh.patches.len()).filter(|&i| wanted(&mesh.patches[i])).collect()
    }
}

impl Plan for Forces {
    fn check(&self, mesh: &Mesh, _: &CaseConfig, sink: &Sink) {
        for w in &self.patches {
            if mesh.patches.iter().any(|p| p.name == *w || p.in_groups.contains(w)) {
                continue;
            }
            let names = mesh.patches.iter().map(|p| p.name.as_str());
            let known: Vec<&str> = names.clone().collect();
            let help = nearest(w, names).map_or_else(
                || format!("the patches are {}", known.join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            let d = Diag::error(&self.span, format!("the mesh has no patch `{w}`"));
            sink.push(d.label("no such patch").help(help));
        }
    }
    fn build(&self, mesh: &Mesh, _: &Exec) -> Box<dyn Function> {
        Box::new(Placed {
            patches: self.indices(mesh),
            transpose: FaceField::new(mesh, "transposeStress", Dims::FORCE, [0.0; 3]),
            plan: self.clone(),
        })
    }
}

struct Placed {
    plan: Forces,
    patches: Vec<usize>,
    transpose: FaceField<Vec3>,
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        true
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let [pressure, viscous, turn_pressure, turn_viscous] = self.total(view);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let table = |file, title: &str, p: Vec3, v: Vec3| Written::Line {
            file,
            header: format!(
                "# {title}\n# CofR : {}\n#\n# Time\t(total_x total_y total_z)\t(pressure_x \
                 pressure_y pressure_z)\t(viscous_x viscous_y viscous_z)",
                columns::vector(self.plan.centre)
            ),
            line: format!(
                "{}\t{}\t{}\t{}",
                view.time_name,
                columns::vector(add(p, v)),
                columns::vector(p),
                columns::vector(v)
            ),
        };
        vec![
            table("force.dat", "Force", pressure, viscous),
            table("moment.dat", "Moment", turn_pressure, turn_viscous),
        ]
    }
}

impl Placed {
    /// Pressure and viscous force, pressure and viscous moment, of all ranks; N and N m.
    fn total(&mut self, view: &View<'_>) -> [Vec3; 4] {
        let (mesh, d) = (view.mesh, view.derived);
        let mut sum = [[0.0; 3]; 4];
        if let Some(eta) = &d.viscosity_f {
            let out = &mut self.transpose;
            operators::transpose_stress_flux(view.exec, mesh, view.u, &d.gradient_u, eta, out);
            let p_ref = self.plan.p_ref * view.pressure_factor;
            for &i in &self.patches {
                for f in mesh.patches[i].faces.clone() {
                    let p = scale(mesh.area[f], view.pressure_at(f) - p_ref);
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
        let mut flat: Vec<f64> = sum.iter().flatten().copied().collect();
        view.exec.comm().sum(&mut flat);
        std::array::from_fn(|k| [flat[3 * k], flat[3 * k + 1], flat[3 * k + 2]])
    }
}
