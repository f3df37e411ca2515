//! Forces on patches over the dynamic pressure: drag, lift, side force and moments.

use super::forces::{Forces, Sum};
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::{Dims, Vec3, add, cross, dot, norm, scale, sub, unit};
use granflow_dict::{Reader, Sink, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "forceCoeffs",
    summary: "coefficients of drag, side force, lift, roll, pitch and yaw of patches",
    formula: "C = F . e/(rho magUInf^2 Aref/2), C_m = M . e/(rho magUInf^2 Aref lRef/2); e: \
              dragDir, liftDir x dragDir, liftDir",
    reference: "J. D. Anderson, Fundamentals of Aerodynamics, ch. 1.5",
    read: |r, _| Box::new(Coefficients::read(r)),
    schedule: Schedule::always(Every::Steps(1)),
};

#[derive(Clone)]
struct Coefficients {
    forces: Forces,
    /// Directions of drag, side force and lift: also the axes of roll, pitch and yaw.
    axes: [Vec3; 3],
    speed: f64,
    length: f64,
    area: f64,
}

impl Coefficients {
    fn read(r: &Reader<'_>) -> Coefficients {
        // Follows from the two directions.
        r.ignore("pitchAxis");
        let lift = r.vector("liftDir", Dims::NONE);
        let drag = r.vector("dragDir", Dims::NONE);
        if norm(cross(lift, drag)) <= 1e-9 * norm(lift) * norm(drag) {
            r.error_at_key("dragDir", "`liftDir` and `dragDir` are parallel", "no plane", None);
        }
        let lift = unit(lift);
        let drag = unit(sub(drag, scale(lift, dot(lift, drag))));
        Coefficients {
            forces: Forces::read(r),
            axes: [drag, cross(lift, drag), lift],
            speed: r.positive("magUInf", Dims::VELOCITY),
            length: r.positive("lRef", Dims::LENGTH),
            area: r.positive("Aref", Dims::AREA),
        }
    }
}

impl Plan for Coefficients {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        self.forces.check(mesh, config, sink);
    }
    fn build(&self, mesh: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Placed { sum: self.forces.sum(mesh), plan: self.clone() })
    }
}

struct Placed {
    plan: Coefficients,
    sum: Sum,
}

/// Names of the columns: forces, moments, and forces on the front and the rear half.
const HEADS: [&str; 12] = [
    "Cd", "Cs", "Cl", "CmRoll", "CmPitch", "CmYaw", "Cd(f)", "Cd(r)", "Cs(f)", "Cs(r)", "Cl(f)",
    "Cl(r)",
];

impl Function for Placed {
    fn needs_derived(&self) -> bool {
        true
    }
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let [pressure, viscous, turn_pressure, turn_viscous] = self.sum.total(view);
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let plan = &self.plan;
        let own = view.whole.case.config.transport.rho;
        let rho = plan.forces.rho_inf.unwrap_or(own);
        let push = 0.5 * rho * plan.speed * plan.speed * plan.area;
        let force = scale(add(pressure, viscous), 1.0 / push);
        let moment = scale(add(turn_pressure, turn_viscous), 1.0 / (push * plan.length));
        let [cd, cs, cl] = plan.axes.map(|axis| dot(force, axis));
        let [roll, pitch, yaw] = plan.axes.map(|axis| dot(moment, axis));
        let halves = [(cd, roll), (cs, yaw), (cl, pitch)];
        let halves = halves.map(|(c, m)| [0.5 * c + m, 0.5 * c - m]);
        let all = [cd, cs, cl, roll, pitch, yaw].into_iter().chain(halves.concat());
        let cells: Vec<String> = all.map(number).collect();
        let names = ["dragDir", "sideDir", "liftDir", "rollAxis", "pitchAxis", "yawAxis"];
        let axes = plan.axes.iter().chain(&plan.axes);
        let mut header = String::from("# Force coefficients\n");
        for (name, axis) in names.into_iter().zip(axes) {
            header += &columns::property(name, &columns::vector(*axis));
        }
        header += &columns::property("magUInf", &number(plan.speed));
        header += &columns::property("lRef", &number(plan.length));
        header += &columns::property("Aref", &number(plan.area));
        header += &columns::property("CofR", &columns::vector(plan.forces.centre));
        header += &format!("#\n{}", columns::head(&HEADS.map(str::to_owned)));
        let line = columns::row(view, &cells);
        vec![Written::Line { file: "coefficient.dat".into(), header, line }]
    }
}
