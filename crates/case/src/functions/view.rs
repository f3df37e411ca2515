//! The flow as functions see it: fields by name, at cells, on faces and in between.

use super::field::{Components, components};
use super::quantity::Quantity;
use super::{Function, whole::Whole};
use granflow_base::{Dims, Tensor, Vec3, dot, norm, sub};
use granflow_flow::{Flow, Report, StepError};
use granflow_fv::{FaceField, Unknown};
use granflow_mesh::Mesh;
use granflow_par::Exec;
use granflow_physics::rheology::Granular;

/// Fields that follow from the state, cells and ghosts; made once for all functions of a moment.
#[derive(Default)]
pub struct Derivations {
    /// `sqrt(2 D:D)`, 1/s.
    pub strain_rate: Vec<f64>,
    /// Viscosity, Pa s.
    pub viscosity: Vec<f64>,
    /// Pressure between grains (with its hydrostatic part), Pa.
    pub pressure: Vec<f64>,
    /// Velocity gradient, 1/s.
    pub gradient_u: Vec<Tensor>,
    /// Viscosity on faces, Pa s.
    pub viscosity_f: Option<FaceField<f64>>,
}

impl Derivations {
    /// Computes them anew. Every rank calls it.
    ///
    /// # Errors
    /// The rheology gives no viscosity.
    pub fn update(&mut self, flow: &mut Flow) -> Result<(), StepError> {
        let n_all = flow.mesh.n_all();
        let mesh = flow.mesh.clone();
        let d = flow.derived()?;
        let copy = |to: &mut Vec<f64>, from: &[f64]| {
            to.resize(n_all, 0.0);
            to[..from.len()].copy_from_slice(from);
        };
        copy(&mut self.strain_rate, d.strain_rate);
        copy(&mut self.viscosity, d.viscosity);
        copy(&mut self.pressure, d.pressure);
        self.gradient_u.clear();
        self.gradient_u.extend_from_slice(d.gradient_u);
        let faces = self
            .viscosity_f
            .get_or_insert_with(|| FaceField::new(&mesh, "viscosity", Dims::VISCOSITY, 0.0));
        faces.data.copy_from_slice(d.viscosity_f);
        for ghosts in [&mut self.strain_rate, &mut self.viscosity, &mut self.pressure] {
            mesh.halo.update(&flow.exec, ghosts);
        }
        Ok(())
    }
}

/// The flow as functions see it.
pub struct View<'a> {
    /// Threads and ranks.
    pub exec: &'a Exec,
    /// This rank's mesh.
    pub mesh: &'a Mesh,
    /// Velocity.
    pub u: &'a Unknown<Vec3>,
    /// Pressure, p or p_rgh, Pa.
    pub p: &'a Unknown<f64>,
    /// Fluidity, 1/s.
    pub fluidity: Option<&'a [f64]>,
    /// What follows from the state; empty unless a function asked for it.
    pub derived: &'a Derivations,
    /// The grains, if any.
    pub grains: Option<Granular>,
    /// Volume fraction of the first phase, where there are two.
    pub alpha: Option<&'a Unknown<f64>>,
    /// Volume flux through faces, m3/s.
    pub phi: &'a [f64],
    /// Mass flux through faces in the last step, kg/s, where there are two phases.
    pub mass_flux: Option<&'a [f64]>,
    /// Density in the cells, kg/m3.
    pub density: &'a [f64],
    /// The part of gravity in p_rgh, m/s2.
    pub gravity: Vec3,
    /// Pressure inside over pressure in files.
    pub pressure_factor: f64,
    /// Time, s.
    pub time: f64,
    /// Text of the time in tables.
    pub time_name: &'a str,
    /// Length of the last step, s.
    pub dt: f64,
    /// What the step did.
    pub report: &'a Report,
    /// The functions before this one, which may have made fields.
    pub made: &'a [Box<dyn Function>],
    /// Ways to the whole mesh, for what is computed on one rank.
    pub(crate) whole: Whole<'a>,
}

impl View<'_> {
    /// The value in a cell (own or ghost): as many components as the quantity has.
    pub fn cell(&self, q: Quantity, c: usize) -> Components {
        let d = self.derived;
        let scalar = |x: f64| components(&[x]);
        // Where grains lose contact there is no pressure to divide by.
        let loose = self.grains.map_or(f64::MIN_POSITIVE, |g| g.loose());
        // Nothing is said of a fluid beside the grains.
        let here = |c: usize| self.alpha.is_none_or(|a| a.cells.data[c] > 0.5);
        let mu = |c: usize| match here(c) {
            true => d.strain_rate[c] * d.viscosity[c] / d.pressure[c].max(loose),
            false => 0.0,
        };
        match q {
            Quantity::U => components(&self.u.cells.data[c]),
            Quantity::P => {
                let weight = self.density[c] * dot(self.gravity, self.mesh.cell_centre[c]);
                scalar((self.p.cells.data[c] + weight) / self.pressure_factor)
            }
            Quantity::PRgh => scalar(self.p.cells.data[c] / self.pressure_factor),
            Quantity::Alpha => scalar(self.alpha.map_or(0.0, |a| a.cells.data[c])),
            Quantity::Rho => scalar(self.density[c]),
            Quantity::Made { function, slot, .. } => match self.made.get(function) {
                Some(f) => f.fields()[slot].cell(c),
                None => [0.0; 9],
            },
            Quantity::Fluidity => scalar(self.fluidity.map_or(0.0, |g| g[c])),
            Quantity::StrainRate => scalar(d.strain_rate[c]),
            Quantity::Viscosity => scalar(d.viscosity[c]),
            Quantity::StressRatio => scalar(mu(c)),
            Quantity::InertialNumber => scalar(
                self.grains
                    .filter(|_| here(c))
                    .map_or(0.0, |g| g.inertial_number(d.strain_rate[c], d.pressure[c])),
            ),
        }
    }

    /// The value on a boundary face, where the field has one of its own there.
    pub fn boundary(&self, q: Quantity, f: usize) -> Option<Components> {
        let scalar = |x: f64| Some(components(&[x]));
        match q {
            Quantity::U => Some(components(&self.u.boundary_value(self.mesh, f))),
            Quantity::PRgh => scalar(self.p.boundary_value(self.mesh, f) / self.pressure_factor),
            Quantity::Alpha => scalar(self.alpha?.boundary_value(self.mesh, f)),
            Quantity::P => scalar(self.pressure_at(f) / self.pressure_factor),
            Quantity::Made { function, slot, .. } => {
                self.made.get(function)?.fields()[slot].face(self.mesh, f)
            }
            _ => None,
        }
    }

    /// The value on a boundary face, that of its cell where the field has none of its own.
    pub fn on_boundary(&self, q: Quantity, f: usize) -> Components {
        let cell = || self.cell(q, self.mesh.owner[f] as usize);
        self.boundary(q, f).unwrap_or_else(cell)
    }

    /// The value on any face: interpolated linearly between cells.
    pub fn on_face(&self, q: Quantity, f: usize) -> Components {
        let Some(&n) = self.mesh.neighbour.get(f) else { return self.on_boundary(q, f) };
        let w = self.mesh.weight[f];
        let (a, b) = (self.cell(q, self.mesh.owner[f] as usize), self.cell(q, n as usize));
        std::array::from_fn(|k| w * a[k] + (1.0 - w) * b[k])
    }

    /// The pressure itself on boundary face `f`, Pa.
    pub fn pressure_at(&self, f: usize) -> f64 {
        let rho = self.density[self.mesh.owner[f] as usize];
        let weight = rho * dot(self.gravity, self.mesh.face_centre[f]);
        self.p.boundary_value(self.mesh, f) + weight
    }

    /// The value at `x` in cell `c`: the cell's own, or with `linear` continued by the gradient
    /// that fits its neighbours best.
    pub fn at(&self, q: Quantity, c: usize, x: Vec3, linear: bool) -> Components {
        let here = self.cell(q, c);
        if !linear {
            return here;
        }
        let (mesh, n) = (self.mesh, q.n());
        let mut m = [0.0; 9];
        let mut rhs = [[0.0; 9]; 3];
        for (f, s) in mesh.faces_of(c) {
            let d = mesh.delta[f].map(|x| s * x);
            let there = if f < mesh.n_inner {
                let other = if s > 0.0 { mesh.neighbour[f] } else { mesh.owner[f] };
                self.cell(q, other as usize)
            } else {
                match self.boundary(q, f) {
                    Some(v) => v,
                    None => continue,
                }
            };
            let w = 1.0 / dot(d, d);
            for i in 0..3 {
                (0..3).for_each(|j| m[3 * i + j] += w * d[i] * d[j]);
                (0..n).for_each(|j| rhs[i][j] += w * d[i] * (there[j] - here[j]));
            }
        }
        let offset = sub(x, mesh.cell_centre[c]);
        let t = solve_symmetric(&m, offset);
        // offset . M^-1 rhs: M is symmetric.
        let mut v = here;
        for (j, v) in v.iter_mut().enumerate().take(n) {
            *v += (0..3).map(|i| t[i] * rhs[i][j]).sum::<f64>();
        }
        v
    }
}

/// `M x = b` in the directions that `M` spans (symmetric, positive semidefinite).
fn solve_symmetric(m: &Tensor, b: Vec3) -> Vec3 {
    // Directions without neighbours (empty patches) get no gradient: a small ridge does that to
    // a relative 1e-12 of the others.
    let trace = m[0] + m[4] + m[8];
    let mut a = *m;
    for k in 0..3 {
        let bare = m[4 * k] <= 1e-10 * trace;
        if bare {
            for j in 0..3 {
                a[3 * k + j] = 0.0;
                a[3 * j + k] = 0.0;
            }
            a[4 * k] = trace.max(f64::MIN_POSITIVE);
        }
    }
    let b = [0, 1, 2].map(|k| if m[4 * k] <= 1e-10 * trace { 0.0 } else { b[k] });
    let col = |k: usize| [a[k], a[3 + k], a[6 + k]];
    let det = dot(col(0), granflow_base::cross(col(1), col(2)));
    if det.abs() <= 1e-14 * norm(col(0)) * norm(col(1)) * norm(col(2)) {
        return [0.0; 3];
    }
    [
        dot(b, granflow_base::cross(col(1), col(2))) / det,
        dot(col(0), granflow_base::cross(b, col(2))) / det,
        dot(col(0), granflow_base::cross(col(1), b)) / det,
    ]
}
