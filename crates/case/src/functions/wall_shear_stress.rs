//! What walls do to the flow along them.
//!
//! The stress is the very flux of momentum that the momentum equation holds on the face, so that it adds
//! up to the viscous part of `forces`.

use super::derived_field::result;
use super::field::components;
use super::patches::Patches;
use super::schedule::{Every, Schedule};
use super::{
    Entry, Function, Info, Plan, Rank, Reading, Remembered, Unit, Values, View, Written, columns,
};
use crate::CaseConfig;
use granflow_base::{Dims, Vec3, add, scale};
use granflow_dict::{Reader, Sink};
use granflow_fv::{FaceField, operators};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "wallShearStress",
    summary: "the field `wallShearStress` on walls and its extremes a patch: viscous stress of the wall on the flow",
    formula: "R = eta (dU/dn + (grad U)^T . n), over rho where the pressure is kinematic",
    reference: "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 9",
    read: |r, reading| Box::new(WallShearStress::read(r, reading)),
    schedule: Schedule::always(Every::Writes(1)),
};

#[derive(Clone)]
struct WallShearStress {
    patches: Patches,
    info: Info,
}

impl WallShearStress {
    fn read(r: &Reader<'_>, _: &Reading<'_>) -> WallShearStress {
        WallShearStress {
            patches: Patches::or_walls(r, "patches"),
            info: Info {
                name: result(r, "wallShearStress"),
                rank: Rank::Vector,
                // In the units of the pressure: per density where that is.
                unit: Unit::PRESSURE,
                on_faces: true,
            },
        }
    }
}

impl Plan for WallShearStress {
    fn check(&self, mesh: &Mesh, _: &CaseConfig, sink: &Sink) {
        self.patches.check(mesh, sink);
    }
    fn makes(&self) -> Vec<Info> {
        vec![self.info.clone()]
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Placed {
            patches: self.patches.indices(mesh),
            transpose: FaceField::new(mesh, "transposeStress", Dims::FORCE, [0.0; 3]),
            values: [Values::new(mesh, &self.info)],
        })
    }
}

struct Placed {
    patches: Vec<usize>,
    transpose: FaceField<Vec3>,
    values: [Values; 1],
}

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        true
    }
    fn execute(&mut self, view: &View<'_>) {
        let (mesh, d) = (view.mesh, view.derived);
        let Some(eta) = &d.viscosity_f else { return };
        let out = &mut self.transpose;
        operators::transpose_stress_flux(view.exec, mesh, view.u, &d.gradient_u, eta, out);
        for &i in &self.patches {
            for f in mesh.patches[i].faces.clone() {
                let slope = operators::normal_derivative(mesh, view.u, None, f);
                let across = scale(self.transpose.data[f], 1.0 / mesh.mag_area[f]);
                let stress = add(scale(slope, eta.data[f]), across);
                let stress = scale(stress, 1.0 / view.pressure_factor);
                self.values[0].set_face(mesh, f, &components(&stress));
            }
        }
    }
    fn fields(&self) -> &[Values] {
        &self.values
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let mesh = view.mesh;
        let mut out = Vec::new();
        for &i in &self.patches {
            // Greatest of each component, and of its opposite.
            let mut most = [f64::NEG_INFINITY; 6];
            for f in mesh.patches[i].faces.clone() {
                let v = self.values[0].face(mesh, f).unwrap_or_default();
                for k in 0..3 {
                    most[k] = most[k].max(v[k]);
                    most[3 + k] = most[3 + k].max(-v[k]);
                }
            }
            view.exec.comm().max(&mut most);
            if view.exec.rank() != 0 || most[0] == f64::NEG_INFINITY {
                continue;
            }
            let [x, y, z, a, b, c] = most;
            let (least, most) = (columns::vector([-a, -b, -c]), columns::vector([x, y, z]));
            out.push(Written::Line {
                file: "wallShearStress.dat".into(),
                header: format!(
                    "# Wall shear stress\n{}",
                    columns::head(&["patch", "min", "max"].map(str::to_owned))
                ),
                line: columns::row(view, &[mesh.patches[i].name.clone(), least, most]),
            });
        }
        out
    }
}
