//! One case at many values of its entries: `granflow sweep` walks a parameter, `granflow fit` finds parameters from
//! measured profiles.
//!
//! Every point is a case of its own, a copy with some entries changed, so that it can be looked at, drawn and run
//! again like any other.

mod edit;
pub mod fit;
mod least_squares;
mod point;
mod setting;
pub mod sweep;
mod sweep_table;

pub use edit::{EditError, set_entry};
pub use point::{Point, Solution};
pub use setting::{Quantity, Setting};
