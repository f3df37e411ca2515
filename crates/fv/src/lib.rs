//! Finite volumes: fields and their boundary closures, gradients, convection schemes, equations
//! as data, and explicit operators.

pub mod conditions;
mod convection;
mod differentiable;
mod equation;
mod field;
pub mod formula;
mod gradient;
mod gradient_limiter;
mod limiter;
pub mod operators;
mod reconstruction;
mod term;
pub mod time_function;
mod unknown;
pub mod waves;

pub use conditions::{Affine, Condition, Fault, PatchClosure, PatchView, Surroundings};
pub use convection::{Convection, Shares, defer_to_upwind};
pub use differentiable::Differentiable;
pub use equation::{DimError, Equation};
pub use field::{Cell, CellField, Face, FaceField, Field};
pub use gradient::{Gradient, LeastSquares};
pub use gradient_limiter::{GradientLimit, GradientLimiter};
pub use limiter::{Limiter, LimiterKind, LimiterVisitor};
pub use reconstruction::Reconstruction;
pub use term::{Ddt, Term, Terms, ddt, div, div_explicit, laplacian, source, sp};
pub use time_function::TimeFunction;
pub use unknown::Unknown;
