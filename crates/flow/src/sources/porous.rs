//! Drag of a porous body: `-(eta D + rho |U|/2 F) U`, with `D` and `F` diagonal along given axes
//! (H. Darcy, Les fontaines publiques de la ville de Dijon, 1856; P. Forchheimer, Z. Ver. Dtsch. Ing. 45
//! (1901) 1782).

use super::{Seen, Zone};
use granflow_base::{Value, Vec3, dot, norm};

/// A porous body.
#[derive(Clone, Debug)]
pub struct Porous {
    /// Where.
    pub zone: Zone,
    /// The viscous coefficients along the axes, 1/m2.
    pub darcy: Vec3,
    /// The coefficients of the square, 1/m.
    pub forchheimer: Vec3,
    /// The axes: unit vectors, perpendicular to each other.
    pub axes: [Vec3; 3],
}

impl Porous {
    /// The greatest of the three drags is implicit, what the others are short of it is not: with it on
    /// the diagonal nothing overshoots. What is `compatible` has the sum of the three there.
    pub(super) fn add(
        &self,
        seen: &Seen<'_>,
        n: usize,
        compatible: bool,
        body: &mut [Vec3],
        sink: &mut [f64],
    ) {
        self.zone.each(n, |c| {
            let u = seen.u[c];
            let dynamic = 0.5 * seen.rho[c] * norm(u);
            let drag = |k: usize| seen.eta[c] * self.darcy[k] + dynamic * self.forchheimer[k];
            let drags = [drag(0), drag(1), drag(2)];
            let implicit = match compatible {
                true => drags.iter().sum(),
                false => drags.iter().copied().fold(0.0, f64::max),
            };
            sink[c] += implicit;
            for (axis, drag) in self.axes.iter().zip(drags) {
                body[c] = body[c].axpy((implicit - drag) * dot(u, *axis), *axis);
            }
        });
    }
}
