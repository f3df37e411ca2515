//! Finite volumes: fields, boundary conditions, limiters, gradients, equations as data.
