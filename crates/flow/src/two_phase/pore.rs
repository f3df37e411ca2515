//! The pressure of the fluid between the grains, which is no pressure between them.
//!
//! Grains rub with the pressure of the mixture less that of the fluid in their pores. At the surface of the
//! grains the latter is the other fluid's; inside it obeys Darcy's law with a permeability that is the same
//! everywhere, `lap p_pore = 0` (K. Terzaghi, Theoretical Soil Mechanics (1943)), nothing flowing through
//! walls: below a level surface it is the pressure at the surface.

use super::grains::sparse;
use crate::StepError;
use granflow_base::{Dims, Vec3, dot};
use granflow_fv::{CellField, Condition, Equation, FaceField, Unknown, laplacian, sp};
use granflow_linsolve::{LinearSolver, SolveError, Tolerance};
use granflow_mesh::Mesh;
use granflow_par::Exec;

/// What fills the pores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pores {
    /// Nothing that weighs: the density of the grains is that of dry bulk.
    #[default]
    Dry,
    /// Fluid 2: the density of the grains is that of the saturated bulk, of which the fluid bears its part.
    Saturated,
}

impl Pores {
    /// Every choice by its name in `transportProperties`.
    pub const ALL: &'static [(&'static str, Pores)] =
        &[("dry", Pores::Dry), ("saturated", Pores::Saturated)];
}

/// How exactly the equation is solved.
const TOLERANCE: Tolerance = Tolerance { abs: 0.0, rel: 1e-12, max_iter: 2000 };
/// Weight of a given value over the couplings of its cell.
const GIVEN: f64 = 1e8;

pub(crate) struct PorePressure {
    /// Less the weight of the fluid, where pores are saturated; cells and ghosts, Pa.
    pressure: Unknown<f64>,
    equation: Equation<f64>,
    conducts: FaceField<f64>,
    given: CellField<f64>,
    rhs: Vec<f64>,
    /// `rho_2 G` where pores are saturated, else zero.
    weight: Vec3,
}

impl PorePressure {
    pub(crate) fn new(exec: &Exec, mesh: &Mesh, weight: Vec3) -> PorePressure {
        let free = |_| Box::new(granflow_fv::conditions::ZeroGradient) as Box<dyn Condition<f64>>;
        let conditions = mesh.patches.iter().map(free).collect();
        PorePressure {
            pressure: Unknown::new(mesh, "pPore", Dims::PRESSURE, 0.0, conditions),
            equation: Equation::new(exec, mesh),
            conducts: FaceField::new(mesh, "share", Dims::NONE, 0.0),
            given: CellField::new(mesh, "given", Dims::AREA.inv(), 0.0),
            rhs: vec![0.0; mesh.n_cells],
            weight,
        }
    }

    /// At `x` near cell or ghost `c`, Pa.
    #[inline]
    pub(crate) fn at(&self, c: usize, x: Vec3) -> f64 {
        self.pressure.cells.data[c] + dot(self.weight, x)
    }

    /// The surface of the grains has moved: `share` of them in cells and ghosts.
    pub(crate) fn enclose(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        share: &[f64],
    ) -> Result<(), StepError> {
        exec.for_each(&mut self.conducts.data, |first, out| {
            for (i, k) in out.iter_mut().enumerate() {
                let f = first + i;
                let o = mesh.owner[f] as usize;
                let n = mesh.neighbour.get(f).map_or(o, |&n| n as usize);
                *k = if sparse(share[o]) && sparse(share[n]) { 0.0 } else { 1.0 };
            }
        });
        exec.for_each(&mut self.given.data[..mesh.n_cells], |first, out| {
            for (i, k) in out.iter_mut().enumerate() {
                let c = first + i;
                let couplings = mesh.faces_of(c).map(|(f, _)| mesh.mag_area[f] * mesh.inv_dist[f]);
                let whole = GIVEN * couplings.sum::<f64>() / mesh.volume[c];
                *k = if sparse(share[c]) { whole } else { 0.0 };
            }
        });
        let equation = sp(&self.given) - laplacian(&self.conducts);
        self.equation.assemble(exec, mesh, &self.pressure, &equation)?;
        Ok(())
    }

    /// Solves for the pores with the pressure of the mixture, `total`, outside of the grains.
    pub(crate) fn update(
        &mut self,
        exec: &Exec,
        mesh: &Mesh,
        solver: &mut dyn LinearSolver<f64>,
        (share, total): (&[f64], &[f64]),
        time: f64,
    ) -> Result<(), StepError> {
        let n = mesh.n_cells;
        let outside = exec.sum(n, |r| r.filter(|c| sparse(share[*c])).count() as f64);
        if outside == 0.0 {
            self.pressure.cells.data.fill(0.0);
            return Ok(());
        }
        let (given, weight) = (&self.given.data, self.weight);
        exec.for_each2(&mut self.rhs, &mut self.pressure.cells.data[..n], |first, b, p| {
            for (i, (b, p)) in b.iter_mut().zip(p).enumerate() {
                let c = first + i;
                *b = 0.0;
                if sparse(share[c]) {
                    *p = total[c] - dot(weight, mesh.cell_centre[c]);
                    *b = given[c] * mesh.volume[c] * *p;
                }
            }
        });
        let failed = |source| StepError::Solve { field: "the pressure in the pores", time, source };
        let x = &mut self.pressure.cells.data;
        solver.refresh(exec, &self.equation.a).map_err(failed)?;
        match solver.solve(exec, &self.equation.a, &self.rhs, x, &TOLERANCE) {
            Ok(_) | Err(SolveError::NotConverged(_) | SolveError::Spent(_)) => {}
            Err(e) => return Err(failed(e)),
        }
        mesh.halo.update(exec, &mut self.pressure.cells.data);
        Ok(())
    }
}
