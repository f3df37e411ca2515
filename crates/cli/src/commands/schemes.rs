//! The words of `system/fvSchemes`, for `granflow list` and the book.

/// One word.
pub(super) struct Scheme {
    /// What it is a scheme of.
    pub(super) kind: &'static str,
    pub(super) name: &'static str,
    /// One line for lists and the book.
    pub(super) summary: &'static str,
    /// What it makes: `phi` a field, `_f` on a face, `_P` and `_N` its cells, `_U` and `_D` the cells upstream and
    /// downstream, `d` from one centre to the other, `_0` a step earlier.
    pub(super) formula: &'static str,
    pub(super) reference: &'static str,
}

/// Every word. The limiters' names come from `fv`; a test keeps this table complete.
pub(super) const ALL: &[Scheme] = &[
    Scheme {
        kind: "time",
        name: "Euler",
        summary: "implicit, first order",
        formula: "d phi/dt = (phi - phi_0)/dt",
        reference: HIRSCH,
    },
    Scheme {
        kind: "time",
        name: "backward",
        summary: "differences over two steps, second order",
        formula: "d phi/dt = ((1 + r/(1 + r)) phi - (1 + r) phi_0 + r^2/(1 + r) phi_00)/dt, r = \
                  dt/dt_0; (3 phi - 4 phi_0 + phi_00)/(2 dt) for equal steps",
        reference: "C. W. Gear, Numerical Initial Value Problems in Ordinary Differential \
                    Equations, 1971",
    },
    Scheme {
        kind: "time",
        name: "CrankNicolson",
        summary: "trapezoidal rule, second order; `CrankNicolson 0.9` has a little of Euler in \
                  it, 0 is Euler",
        formula: "(1 + c) (phi - phi_0)/dt - c (d phi/dt)_0 = R(phi), c the number behind the \
                  name",
        reference: "J. Crank, P. Nicolson, Math. Proc. Camb. Phil. Soc. 43 (1947) 50",
    },
    Scheme {
        kind: "time",
        name: "localEuler",
        summary: "Euler with a step of its own for every cell, towards a steady state: `maxCo`, \
                  `maxDeltaT`, `rDeltaTSmoothingCoeff` of PIMPLE",
        formula: "d phi/dt = (phi - phi_0)/dt_P, dt_P = min(maxDeltaT, 2 maxCo V/sum |flux|), \
                  smoothed",
        reference: HIRSCH,
    },
    Scheme {
        kind: "time",
        name: "bounded",
        summary: "before another scheme: takes out the flux's divergence, which there is none of \
                  here",
        formula: "the scheme behind it less phi div flux, which is 0 here",
        reference: "book, Finite volumes",
    },
    Scheme {
        kind: "time",
        name: "steadyState",
        summary: "none: a step finds the steady state of the conditions at its end",
        formula: "d phi/dt = 0",
        reference: "book, Steady states",
    },
    Scheme {
        kind: "gradient",
        name: "Gauss",
        summary: "Gauss's theorem with linear interpolation, `Gauss linear`",
        formula: "grad phi = sum S phi_f/V, phi_f linear between the centres, corrected for \
                  skewness",
        reference: FERZIGER,
    },
    Scheme {
        kind: "gradient",
        name: "leastSquares",
        summary: "least squares weighted with the distance",
        formula: "min over g of sum_N w_N^2 (phi_N - phi_P - g . d_N)^2, w_N = 1/|d_N|",
        reference: BARTH,
    },
    Scheme {
        kind: "gradient",
        name: "cellLimited",
        summary: "before another scheme, with a number from 0 to 1: the whole gradient shrinks \
                  until it says nothing at faces that neighbours do not have; for convection",
        formula: "g <- c g, the greatest c <= 1 with phi_P + c g . (x_f - x_P) within the values \
                  of all neighbours at every face",
        reference: BARTH,
    },
    Scheme {
        kind: "gradient",
        name: "cellMDLimited",
        summary: "the same, and only its part along the way to the face shrinks",
        formula: "g <- g - max(g . e - b, 0) e/|e|^2 at each face in turn, e = x_f - x_P, b the \
                  greatest change that neighbours allow",
        reference: BARTH,
    },
    Scheme {
        kind: "gradient",
        name: "faceLimited",
        summary: "cellLimited by the two cells of every face alone",
        formula: "as cellLimited, each face with the values of its two cells",
        reference: BARTH,
    },
    Scheme {
        kind: "gradient",
        name: "faceMDLimited",
        summary: "cellMDLimited by the two cells of every face alone",
        formula: "as cellMDLimited, each face with the values of its two cells",
        reference: BARTH,
    },
    Scheme {
        kind: "convection",
        name: "upwind",
        summary: "the upwind cell's value, first order, bounded",
        formula: "phi_f = phi_U, the cell that the flux comes from",
        reference: FERZIGER,
    },
    Scheme {
        kind: "convection",
        name: "linear",
        summary: "central, second order, unbounded",
        formula: "phi_f = w phi_P + (1 - w) phi_N, w by distance from the face",
        reference: FERZIGER,
    },
    Scheme {
        kind: "convection",
        name: "linearUpwind",
        summary: "upwind with the upwind cell's gradient, second order",
        formula: "phi_f = phi_U + (x_f - x_U) . (grad phi)_U",
        reference: "R. F. Warming, R. M. Beam, AIAA J. 14 (1976) 1241",
    },
    Scheme {
        kind: "convection",
        name: "linearUpwindV",
        summary: "linearUpwind, of a vector: along its own change and no further than central",
        formula: "phi_f = phi_U + c (x_f - x_U) . (grad phi)_U along the change of phi, no more \
                  than central has",
        reference: "R. F. Warming, R. M. Beam, AIAA J. 14 (1976) 1241",
    },
    Scheme {
        kind: "convection",
        name: "cubic",
        summary: "the cubic through values and gradients of both cells, unbounded",
        formula: "phi_f = central + d/8 . ((grad phi)_P - (grad phi)_N) where the face is in the \
                  middle",
        reference: "Ch. Hermite, J. reine angew. Math. 84 (1878) 70",
    },
    Scheme {
        kind: "convection",
        name: "LUST",
        summary: "three quarters central, one quarter linearUpwind",
        formula: "phi_f = 3/4 central + 1/4 linearUpwind",
        reference: "H. Weller, Mon. Weather Rev. 140 (2012) 3220",
    },
    Scheme {
        kind: "convection",
        name: "blended",
        summary: "a share of central, the rest upwind: `blended 0.8`",
        formula: "phi_f = g central + (1 - g) upwind, g the number behind the name",
        reference: FERZIGER,
    },
    Scheme {
        kind: "convection",
        name: "fixedBlended",
        summary: "two schemes in fixed shares: `fixedBlended 0.8 linear linearUpwind grad(U)`",
        formula: "phi_f = g first + (1 - g) second",
        reference: FERZIGER,
    },
    Scheme {
        kind: "convection",
        name: "limitedLinear",
        summary: "central limited towards upwind, `limitedLinear 1`",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = min(max(2 r/k, 0), 1); r = 2 \
                  d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: SWEBY,
    },
    Scheme {
        kind: "convection",
        name: "vanLeer",
        summary: "van Leer's harmonic limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = (r + |r|)/(1 + |r|); r = 2 d \
                  . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "B. van Leer, J. Comput. Phys. 14 (1974) 361",
    },
    Scheme {
        kind: "convection",
        name: "vanAlbada",
        summary: "van Albada's smooth limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = r (r + 1)/(r^2 + 1), 0 where \
                  r < 0; r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "G. D. van Albada, B. van Leer, W. W. Roberts, Astron. Astrophys. 108 (1982) \
                    76",
    },
    Scheme {
        kind: "convection",
        name: "Minmod",
        summary: "the most diffusive second-order limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(r, 1), 0); r = 2 d . \
                  (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "P. L. Roe, Annu. Rev. Fluid Mech. 18 (1986) 337",
    },
    Scheme {
        kind: "convection",
        name: "SuperBee",
        summary: "the most compressive second-order limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(2 r, 1), min(r, 2), \
                  0); r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "P. L. Roe, in Lectures in Applied Mathematics 22 (1985) 163",
    },
    Scheme {
        kind: "convection",
        name: "MUSCL",
        summary: "van Leer's monotonised central limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(2 r, (r + 1)/2, 2), \
                  0); r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "B. van Leer, J. Comput. Phys. 32 (1979) 101",
    },
    Scheme {
        kind: "convection",
        name: "QUICK",
        summary: "quadratic upwind, limited",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(2 r, (r + 3)/4, 2), \
                  0); r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "B. P. Leonard, Comput. Methods Appl. Mech. Eng. 19 (1979) 59",
    },
    Scheme {
        kind: "convection",
        name: "OSPRE",
        summary: "a smooth limiter",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = 3 r (r + 1)/(2 (r (r + 1) + \
                  1)), 0 where r < 0; r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "N. P. Waterson, H. Deconinck, 9th Int. Conf. Numer. Meth. Laminar Turbul. \
                    Flow (1995)",
    },
    Scheme {
        kind: "convection",
        name: "UMIST",
        summary: "QUICK's symmetric bounded relative",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(2 r, (3 r + 1)/4, (r \
                  + 3)/4, 2), 0); r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "F. S. Lien, M. A. Leschziner, Int. J. Numer. Meth. Fluids 19 (1994) 527",
    },
    Scheme {
        kind: "convection",
        name: "Gamma",
        summary: "central, blended into upwind where it would overshoot: `Gamma 1`",
        formula: "phi_f = psi central + (1 - psi) upwind, psi(r) = max(min(2 r/(k (1 + r)), 1), \
                  0); r = 2 d . (grad phi)_U/(phi_D - phi_U) - 1",
        reference: "H. Jasak, H. G. Weller, A. D. Gosman, Int. J. Numer. Meth. Fluids 31 (1999) \
                    431",
    },
    Scheme {
        kind: "correction",
        name: "corrected",
        summary: "full non-orthogonal correction of the normal gradient",
        formula: "d phi/dn = (phi_N - phi_P)/(n . d) + (grad phi)_f . (n - d/(n . d))",
        reference: JASAK,
    },
    Scheme {
        kind: "correction",
        name: "limited",
        summary: "the correction up to a multiple of the cells' difference, `limited 0.5` or `limited corrected 0.5`",
        formula: "d phi/dn as corrected, the second part no more than k/(1 - k) times the first",
        reference: JASAK,
    },
    Scheme {
        kind: "correction",
        name: "uncorrected",
        summary: "no non-orthogonal correction",
        formula: "d phi/dn = (phi_N - phi_P)/(n . d)",
        reference: JASAK,
    },
    Scheme {
        kind: "correction",
        name: "orthogonal",
        summary: "the difference over the distance of the centres; as a Laplacian it is `uncorrected`",
        formula: "d phi/dn = (phi_N - phi_P)/|d|",
        reference: JASAK,
    },
];
const HIRSCH: &str = "C. Hirsch, Numerical Computation of Internal and External Flows, 1988";
const FERZIGER: &str = "J. H. Ferziger, M. Peric, Computational Methods for Fluid Dynamics, ch. 4";
const BARTH: &str = "T. J. Barth, D. C. Jespersen, AIAA 89-0366 (1989)";
const SWEBY: &str = "P. K. Sweby, SIAM J. Numer. Anal. 21 (1984) 995";
const JASAK: &str = "H. Jasak, PhD thesis, Imperial College 1996, ch. 3.3";
