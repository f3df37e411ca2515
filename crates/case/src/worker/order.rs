//! What rank 0 asks of every rank, and how it is told.

/// What rank 0 asks of every rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Order {
    /// A time step of so many seconds.
    Step(f64),
    /// Back to the state before the step.
    Rollback,
    /// Compute what follows from the state.
    Derive,
    /// Let function number so and so make its fields.
    Make(usize),
    /// Sample function number so and so.
    Sample(usize),
    /// Collect a field of a function.
    Field(usize, usize),
    /// A function's fields have been written.
    Written(usize),
    /// Collect the state, with or without what follows from it.
    Collect(bool),
    /// Go on as a restart from what was written would.
    Renew,
    /// Greatest Courant number of a step of one second, over what it may be.
    Courant,
    /// Whether boundaries ask the same at all steps of so many seconds to come.
    Settled(f64),
    /// The end.
    Stop,
}

impl Order {
    pub(super) fn code(self) -> Vec<f64> {
        match self {
            Order::Step(dt) => vec![0.0, dt],
            Order::Rollback => vec![1.0, 0.0],
            Order::Derive => vec![2.0, 0.0],
            Order::Sample(i) => vec![3.0, i as f64],
            Order::Collect(derived) => vec![4.0, f64::from(u8::from(derived))],
            Order::Renew => vec![5.0, 0.0],
            Order::Courant => vec![6.0, 0.0],
            Order::Settled(dt) => vec![7.0, dt],
            Order::Make(i) => vec![8.0, i as f64],
            Order::Field(i, slot) => vec![9.0, i as f64, slot as f64],
            Order::Written(i) => vec![10.0, i as f64],
            Order::Stop => vec![11.0, 0.0],
        }
    }
    pub(super) fn from_code(code: &[f64]) -> Order {
        let arg = code.get(1).copied().unwrap_or(0.0);
        let second = code.get(2).copied().unwrap_or(0.0);
        match code.first().map_or(11, |c| *c as u8) {
            0 => Order::Step(arg),
            1 => Order::Rollback,
            2 => Order::Derive,
            3 => Order::Sample(arg as usize),
            4 => Order::Collect(arg != 0.0),
            5 => Order::Renew,
            6 => Order::Courant,
            7 => Order::Settled(arg),
            8 => Order::Make(arg as usize),
            9 => Order::Field(arg as usize, second as usize),
            10 => Order::Written(arg as usize),
            _ => Order::Stop,
        }
    }
}
