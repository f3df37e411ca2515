//! Constitutive models: what stress a flow meets.
//!
//! A [`LocalLaw`] is a pure function of one point. A [`Rheology`] sees the whole flow and may own
//! a field and an equation of its own: that is what the nonlocal granular fluidity does.

pub mod rheology;

pub use rheology::{
    ALL, Entry, FlowView, FluidContext, Local, LocalLaw, Point, Rheology, RheologyError,
    RheologyInfo, read,
};
