//! When functions act, and what they add to a time directory.

use super::Run;
use crate::CaseError;
use crate::functions::schedule::Moment;
use crate::functions::{Planned, Written};
use crate::output::MadeFields;
use crate::worker::{Answer, Order};

impl Run {
    /// Lets the functions act that are due.
    pub(super) fn functions(&mut self, moment: &Moment) -> Result<(), CaseError> {
        let case = self.case.clone();
        let plans = &case.config.functions;
        let due: Vec<bool> = plans.iter().map(|f| f.schedule.due(moment)).collect();
        let acts = |(f, due): (&Planned, &bool)| match f.execute {
            Some(execute) => execute.due(moment),
            None => *due || f.plan.remembers(),
        };
        let needed: Vec<bool> = plans.iter().zip(&due).map(acts).collect();
        let mut fresh = false;
        self.make_fields(needed, Some(moment), &mut fresh)?;
        for i in (0..plans.len()).filter(|i| due[*i]) {
            self.derive_for(i, &mut fresh)?;
            let written: Vec<Written> = match self.crew.worker.order(Order::Sample(i)) {
                Ok(Answer::Sampled(w)) => w,
                _ => Vec::new(),
            };
            let inside = plans[i].plan.folder().map_or(String::new(), |f| format!("{f}/"));
            let folder = format!("{inside}{}", plans[i].name);
            self.tables.put(&folder, &self.crew.worker.time_name, written)?;
        }
        Ok(())
    }

    /// Lets the `needed` functions, and those whose fields they look at, make theirs.
    fn make_fields(
        &mut self,
        mut needed: Vec<bool>,
        moment: Option<&Moment>,
        fresh: &mut bool,
    ) -> Result<(), CaseError> {
        let case = self.case.clone();
        let plans = &case.config.functions;
        // What a function looks at was made before it.
        let mut seen = vec![false; plans.len()];
        for i in (0..plans.len()).rev() {
            if needed[i] {
                for used in plans[i].plan.uses() {
                    (needed[used], seen[used]) = (true, true);
                }
            }
        }
        // A function that says when is not asked in between, but once, where somebody looks at what it never made.
        let first = |i: usize| seen[i] && !self.executed[i] && !plans[i].plan.remembers();
        let due = |i: usize| plans[i].execute.is_none_or(|e| moment.is_some_and(|m| e.due(m)));
        let asked = |i: &usize| due(*i) || first(*i);
        let makes = |i: &usize| needed[*i] && asked(i) && !plans[*i].plan.makes().is_empty();
        let made: Vec<usize> = (0..plans.len()).filter(makes).collect();
        for i in made {
            self.derive_for(i, fresh)?;
            let _ = self.crew.worker.order(Order::Make(i));
            self.executed[i] = true;
        }
        Ok(())
    }

    /// Computes what follows from the state, once, if function `i` needs it.
    fn derive_for(&mut self, i: usize, fresh: &mut bool) -> Result<(), CaseError> {
        if !*fresh && self.crew.worker.needs_derived(i) {
            if let Err(e) = self.crew.worker.order(Order::Derive) {
                return Err(CaseError::Step { source: e, kept: None });
            }
            *fresh = true;
        }
        Ok(())
    }

    /// The fields that functions add to the present time; without what follows from the state
    /// (`derived`) those that remember earlier steps.
    pub(super) fn made_fields(&mut self, derived: bool) -> MadeFields {
        let case = self.case.clone();
        let plans = &case.config.functions;
        let moment = self.moment;
        // A write that nobody planned has them all.
        let wanted = |f: &Planned| {
            let now = moment.is_none_or(|m| f.schedule.with_times(&m));
            !f.plan.makes().is_empty() && if derived { now } else { f.plan.remembers() }
        };
        let makers: Vec<bool> = plans.iter().map(wanted).collect();
        let mut out = MadeFields::default();
        if derived && self.make_fields(makers.clone(), moment.as_ref(), &mut true).is_err() {
            return out;
        }
        for (i, f) in plans.iter().enumerate().filter(|(i, _)| makers[*i]) {
            let idle = f.execute.is_some() && !self.executed[i];
            if idle || !self.crew.worker.has_fields(i) {
                continue;
            }
            for (slot, info) in f.plan.makes().into_iter().enumerate() {
                if let Ok(Answer::Field(whole)) = self.crew.worker.order(Order::Field(i, slot)) {
                    out.fields.push((info, whole));
                }
            }
            let memory = self.crew.worker.memory(i);
            if !memory.is_empty() {
                out.memories.push((f.name.clone(), memory));
            }
            let _ = self.crew.worker.order(Order::Written(i));
        }
        out
    }
}
