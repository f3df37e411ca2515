//! Formulae of conditions as they are when the run begins: what cannot be is a mistake of the case, and not
//! a step that fails.

use crate::boundary::FieldType;
use crate::fields::VolField;
use crate::{Case, boundary};
use granflow_dict::{Diag, Sink};
use granflow_fv::conditions::ZeroGradient;
use granflow_fv::{Condition, Surroundings, Unknown};
use granflow_par::Exec;

/// Says what formulae give that cannot be.
pub(crate) fn check(case: &Case, sink: &Sink) {
    let start = &case.start;
    field(case, &start.u, sink);
    field(case, &start.p, sink);
    start.alpha.iter().for_each(|alpha| field(case, alpha, sink));
    field(case, &start.fluidity, sink);
}

fn field<T: FieldType>(case: &Case, field: &VolField<T>, sink: &Sink) {
    let mesh = &*case.mesh;
    if field.boundary.len() != mesh.patches.len() {
        return;
    }
    let of = (field.name.as_str(), field.dims);
    let all = boundary::conditions::<T>(&field.boundary, mesh, case.patches(), of, 1.0);
    // The others may need a flow.
    let alone = |c: Box<dyn Condition<T>>| match c.may_fail() {
        true => c,
        false => Box::new(ZeroGradient),
    };
    let conditions = all.into_iter().map(alone).collect();
    let mut unknown = Unknown::new(mesh, &field.name, field.dims, T::ZERO, conditions);
    if !unknown.may_fail() {
        return;
    }
    let around = Surroundings { time: case.start.time, ..Surroundings::default() };
    unknown.update(&Exec::serial(), mesh, &around, None);
    for (i, condition) in unknown.conditions.iter().enumerate() {
        let (Some(fault), entry) = (condition.fault(), &field.boundary[i]) else { continue };
        let at = entry.find(fault.key).map_or(&entry.close, |e| &e.key_span);
        let message = format!("patch `{}`: {}", mesh.patches[i].name, fault.text);
        sink.push(Diag::error(at, message).label("cannot be when the run begins"));
    }
}
