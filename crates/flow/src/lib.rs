//! One time step: momentum, pressure, fluidity.
