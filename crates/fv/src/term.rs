//! Terms of an equation, held as data: signed, checked for dimensions, printable, fused into one
//! pass over the mesh.

use crate::{CellField, FaceField};
use granflow_base::{Dims, Value};
use std::fmt;
use std::ops::{Add, Sub};

/// One term of an equation for the unknown `phi`, integrated over a cell.
#[derive(Clone, Copy)]
pub enum Term<'a, T> {
    /// `d(rho phi)/dt`: see [`Ddt`].
    Ddt(Ddt<'a, T>),
    /// `sum_f F phi_f` with owner weights of the convection scheme.
    Div {
        /// Flux through the faces.
        flux: &'a FaceField<f64>,
        /// Owner weights on inner faces.
        weights: &'a FaceField<f64>,
    },
    /// `sum_f gamma |S| dphi/dn`, the part along the line of cell centres.
    Laplacian {
        /// Diffusivity on faces.
        gamma: &'a FaceField<f64>,
    },
    /// `sum_f q`: an explicit flux out of the cell, already times the area.
    Flux {
        /// The flux, owner to neighbour.
        flux: &'a FaceField<T>,
    },
    /// Implicit `k phi V`.
    Sp {
        /// The coefficient.
        k: &'a CellField<f64>,
    },
    /// Explicit source density times the volume.
    Su {
        /// The source per volume.
        s: &'a CellField<T>,
    },
}

/// Rate of change of `rho phi`, implicit: `(c0 rho phi - c1 rho0 old + c2 rho0 older) V / dt`,
/// `(c0, c1, c2)` = (1, 1, 0) for Euler and, with equal steps, (3/2, 2, 1/2) for backward
/// differences (Gear 1971).
#[derive(Clone, Copy)]
pub struct Ddt<'a, T> {
    /// Density, or any weight, now.
    pub rho: &'a CellField<f64>,
    /// The same at the old time.
    pub rho_old: &'a CellField<f64>,
    /// The unknown at the old time.
    pub old: &'a [T],
    /// The unknown one time earlier.
    pub older: &'a [T],
    /// Time step, s.
    pub dt: f64,
    /// Coefficients.
    pub c: [f64; 3],
}

impl<T> Term<'_, T> {
    /// Dimensions of the integrated term for an unknown of dimensions `phi`.
    pub fn dims(&self, phi: Dims) -> Dims {
        match self {
            Term::Ddt(d) => d.rho.dims.mul(phi).mul(Dims::VOLUME).div(Dims::TIME),
            Term::Div { flux, .. } => flux.dims.mul(phi),
            Term::Laplacian { gamma } => gamma.dims.mul(phi).mul(Dims::LENGTH),
            Term::Flux { flux } => flux.dims,
            Term::Sp { k } => k.dims.mul(phi).mul(Dims::VOLUME),
            Term::Su { s } => s.dims.mul(Dims::VOLUME),
        }
    }
}

impl<T> fmt::Display for Term<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Term::Ddt(d) => write!(f, "ddt({})", d.rho.name),
            Term::Div { flux, .. } => write!(f, "div({})", flux.name),
            Term::Laplacian { gamma } => write!(f, "laplacian({})", gamma.name),
            Term::Flux { flux } => write!(f, "div({})", flux.name),
            Term::Sp { k } => write!(f, "sp({})", k.name),
            Term::Su { s } => write!(f, "{}", s.name),
        }
    }
}

/// Most terms an equation may have: a fixed number, so that writing one allocates nothing.
const MOST: usize = 8;

/// A signed sum of terms.
#[derive(Clone, Copy)]
pub struct Terms<'a, T>([Option<(f64, Term<'a, T>)>; MOST]);

impl<'a, T: Value> Terms<'a, T> {
    /// The terms with their signs, in the order they were written.
    pub fn iter(&self) -> impl Iterator<Item = &(f64, Term<'a, T>)> {
        self.0.iter().flatten()
    }
    fn with(mut self, sign: f64, t: Term<'a, T>) -> Self {
        let free = self.0.iter_mut().find(|t| t.is_none());
        debug_assert!(free.is_some(), "an equation has at most {MOST} terms");
        if let Some(free) = free {
            *free = Some((sign, t));
        }
        self
    }
    fn of(sign: f64, t: Term<'a, T>) -> Self {
        Terms([None; MOST]).with(sign, t)
    }
}

impl<T: Value> fmt::Display for Terms<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (sign, t)) in self.iter().enumerate() {
            let glue = match (i, *sign < 0.0) {
                (0, true) => "-",
                (0, false) => "",
                (_, true) => " - ",
                (_, false) => " + ",
            };
            write!(f, "{glue}{t}")?;
        }
        write!(f, " = 0")
    }
}
impl<'a, T: Value> Add<Term<'a, T>> for Terms<'a, T> {
    type Output = Terms<'a, T>;
    fn add(self, t: Term<'a, T>) -> Self {
        self.with(1.0, t)
    }
}
impl<'a, T: Value> Sub<Term<'a, T>> for Terms<'a, T> {
    type Output = Terms<'a, T>;
    fn sub(self, t: Term<'a, T>) -> Self {
        self.with(-1.0, t)
    }
}
impl<'a, T: Value> From<Term<'a, T>> for Terms<'a, T> {
    fn from(t: Term<'a, T>) -> Self {
        Terms::of(1.0, t)
    }
}
impl<'a, T: Value> std::ops::Neg for Term<'a, T> {
    type Output = Terms<'a, T>;
    fn neg(self) -> Terms<'a, T> {
        Terms::of(-1.0, self)
    }
}
impl<'a, T: Value> Add for Term<'a, T> {
    type Output = Terms<'a, T>;
    fn add(self, t: Self) -> Terms<'a, T> {
        Terms::of(1.0, self).with(1.0, t)
    }
}
impl<'a, T: Value> Sub for Term<'a, T> {
    type Output = Terms<'a, T>;
    fn sub(self, t: Self) -> Terms<'a, T> {
        Terms::of(1.0, self).with(-1.0, t)
    }
}

/// `d(rho phi)/dt`.
pub fn ddt<T>(d: Ddt<'_, T>) -> Term<'_, T> {
    Term::Ddt(d)
}
/// `div(flux phi)`.
pub fn div<'a, T>(flux: &'a FaceField<f64>, weights: &'a FaceField<f64>) -> Term<'a, T> {
    Term::Div { flux, weights }
}
/// `div(gamma grad phi)`, the part along the line of cell centres.
pub fn laplacian<T>(gamma: &FaceField<f64>) -> Term<'_, T> {
    Term::Laplacian { gamma }
}
/// `div(q)` of an explicit flux through the faces.
pub fn div_explicit<T>(flux: &FaceField<T>) -> Term<'_, T> {
    Term::Flux { flux }
}
/// Implicit `k phi`.
pub fn sp<T>(k: &CellField<f64>) -> Term<'_, T> {
    Term::Sp { k }
}
/// Explicit source.
pub fn source<T>(s: &CellField<T>) -> Term<'_, T> {
    Term::Su { s }
}
