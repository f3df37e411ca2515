//! What every other room builds on: physical dimensions, small vectors and tensors, and the
//! sealed [`Value`] trait that says what a field may hold. No dependencies, no allocation.

mod dims;
mod tensor;
mod timer;
mod value;

pub use dims::{Dims, ParseDimsError};
pub use tensor::{
    IDENTITY, Tensor, Vec3, add, apply, cross, dot, double_dot, double_dot_sym, inverse_symmetric,
    norm, rotate_tensor, rotation_about, scale, sub, symm, trace, transpose, unit,
};
pub use timer::{Stages, Stopwatch};
pub use value::Value;
