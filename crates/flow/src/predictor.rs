//! The momentum predictor of a single pass: velocity from momentum with the pressure as it is.

use crate::{Flow, Purpose, StepError};
use granflow_linsolve::Solved;

impl Flow {
    /// Solves momentum for the velocity; the equation has been assembled.
    pub(crate) fn predict_velocity(&mut self, last: bool) -> Result<Solved, StepError> {
        let time = self.state.time;
        let failed = |source| StepError::Solve { field: "U", time, source };
        let Flow { exec, state, numerics, work: w, .. } = self;
        let solve = &mut numerics.u;
        solve.solver.refresh(exec, &w.u_eqn.a).map_err(failed)?;
        let tolerance = if last { &solve.last } else { &solve.tolerance };
        let (a, b, u) = (&w.u_eqn.a, &w.b, &mut state.u.cells.data);
        let result = solve.solver.solve(exec, a, b, u, tolerance);
        let solved = crate::settle(result, u, Purpose::Values, &mut w.solves[0]).map_err(failed)?;
        self.update_conditions();
        Ok(solved)
    }
}
