//! What a field may hold.

use crate::tensor::{Tensor, Vec3, apply, rotate_tensor};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for [f64; 3] {}
    impl Sealed for [f64; 9] {}
}

/// A field's value: scalar, vector or tensor. Sealed: three implementations, not an open hierarchy.
pub trait Value:
    sealed::Sealed + Copy + Default + PartialEq + Send + Sync + std::fmt::Debug + 'static
{
    /// Number of Cartesian components.
    const N: usize;
    /// The additive zero.
    const ZERO: Self;
    /// OpenFOAM's word for the type: `scalar`, `vector`, `tensor`.
    const WORD: &'static str;
    /// `self + a x`.
    fn axpy(self, a: f64, x: Self) -> Self;
    /// `a self`.
    fn scaled(self, a: f64) -> Self {
        Self::ZERO.axpy(a, self)
    }
    /// `self + o`.
    fn plus(self, o: Self) -> Self {
        self.axpy(1.0, o)
    }
    /// `self - o`.
    fn minus(self, o: Self) -> Self {
        self.axpy(-1.0, o)
    }
    /// Sum of the products of the components.
    fn inner(self, o: Self) -> f64;
    /// Component `c`.
    fn comp(&self, c: usize) -> f64;
    /// Sets component `c`.
    fn set_comp(&mut self, c: usize, v: f64);
    /// The value seen in a frame turned by the rotation `r`; scalars do not change.
    fn rotated(self, r: &Tensor) -> Self;
    /// Whether every component is a finite number.
    fn is_finite(self) -> bool {
        (0..Self::N).all(|c| self.comp(c).is_finite())
    }
}

impl Value for f64 {
    const N: usize = 1;
    const ZERO: Self = 0.0;
    const WORD: &'static str = "scalar";
    #[inline]
    fn axpy(self, a: f64, x: Self) -> Self {
        self + a * x
    }
    #[inline]
    fn inner(self, o: Self) -> f64 {
        self * o
    }
    #[inline]
    fn comp(&self, _: usize) -> f64 {
        *self
    }
    #[inline]
    fn set_comp(&mut self, _: usize, v: f64) {
        *self = v;
    }
    #[inline]
    fn rotated(self, _: &Tensor) -> Self {
        self
    }
}

impl Value for Vec3 {
    const N: usize = 3;
    const ZERO: Self = [0.0; 3];
    const WORD: &'static str = "vector";
    #[inline]
    fn axpy(self, a: f64, x: Self) -> Self {
        [self[0] + a * x[0], self[1] + a * x[1], self[2] + a * x[2]]
    }
    #[inline]
    fn inner(self, o: Self) -> f64 {
        self[0] * o[0] + self[1] * o[1] + self[2] * o[2]
    }
    #[inline]
    fn comp(&self, c: usize) -> f64 {
        self[c]
    }
    #[inline]
    fn set_comp(&mut self, c: usize, v: f64) {
        self[c] = v;
    }
    #[inline]
    fn rotated(self, r: &Tensor) -> Self {
        apply(r, self)
    }
}

impl Value for Tensor {
    const N: usize = 9;
    const ZERO: Self = [0.0; 9];
    const WORD: &'static str = "tensor";
    #[inline]
    fn axpy(mut self, a: f64, x: Self) -> Self {
        self.iter_mut().zip(x).for_each(|(s, x)| *s += a * x);
        self
    }
    #[inline]
    fn inner(self, o: Self) -> f64 {
        self.iter().zip(o).map(|(a, b)| a * b).sum()
    }
    #[inline]
    fn comp(&self, c: usize) -> f64 {
        self[c]
    }
    #[inline]
    fn set_comp(&mut self, c: usize, v: f64) {
        self[c] = v;
    }
    #[inline]
    fn rotated(self, r: &Tensor) -> Self {
        rotate_tensor(r, &self)
    }
}
