//! Conditions whose formulae give what cannot be.

use crate::{Flow, StepError};
use granflow_fv::{Differentiable, Unknown};
use granflow_mesh::Mesh;

impl Flow {
    /// Refuses to go on with a condition that its last update found at fault, on any rank.
    pub(crate) fn refuse_faults(&self) -> Result<(), StepError> {
        let Flow { state, mesh, .. } = self;
        self.refuse_fault(mesh, &state.u, "U")?;
        self.refuse_fault(mesh, &state.p, "the pressure")?;
        match &state.alpha {
            Some(alpha) => self.refuse_fault(mesh, alpha, "the volume fraction"),
            None => Ok(()),
        }
    }

    fn refuse_fault<T: Differentiable>(
        &self,
        mesh: &Mesh,
        unknown: &Unknown<T>,
        field: &'static str,
    ) -> Result<(), StepError> {
        if !unknown.may_fail() {
            return Ok(());
        }
        // One that stops alone would leave the others waiting.
        let mut first = [unknown.fault().map_or(0.0, |patch| 1.0 + patch as f64)];
        self.exec.comm().max(&mut first);
        if first[0] == 0.0 {
            return Ok(());
        }
        let patch = first[0] as usize - 1;
        let condition = &unknown.conditions[patch];
        let fault = match condition.fault() {
            Some(fault) => fault.text.clone(),
            None => {
                let entries = condition.entries();
                let all: Vec<String> = entries.iter().map(|(k, v)| format!("{k} {v}")).collect();
                let time = self.state.time;
                format!("one of its formulae ({}) cannot be at time {time} s", all.join(", "))
            }
        };
        let (patch, time) = (mesh.patches[patch].name.clone(), self.state.time);
        Err(StepError::Condition { field, patch, fault, time })
    }
}
