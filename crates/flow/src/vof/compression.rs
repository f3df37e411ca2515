//! The flux that keeps an interface sharp on a mesh that would smear it: `U_r alpha (1 - alpha)`
//! along the interface's normal (H. G. Weller's, as described by Rusche, PhD thesis, Imperial
//! College 2002, section 4.2.3, and Deshpande, Anumolu & Trujillo, Comput. Sci. Discov. 5 (2012)
//! 014016).

use granflow_base::{Value, Vec3, dot, norm};
use granflow_mesh::Mesh;

/// What the compressive velocity is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compression<'a> {
    /// Multiple of the speed through the face (`cAlpha`).
    pub(super) c_alpha: f64,
    /// Share that follows the speed of the flow in any direction (`icAlpha`).
    pub(super) ic_alpha: f64,
    /// Gradients of alpha in cells and ghosts, 1/m.
    pub(super) gradient: &'a [Vec3],
    /// Speed in cells and ghosts, m/s; used if `ic_alpha` is not zero.
    pub(super) speed: &'a [f64],
    /// Gradient below which there is no interface, 1/m.
    pub(super) least_gradient: f64,
    /// Least share of central interpolation.
    pub(super) least_centrality: f64,
}

impl Compression<'_> {
    /// The compressive flux through inner face `f`, m3/s.
    #[inline]
    pub(super) fn flux(&self, mesh: &Mesh, alpha: &[f64], phi: f64, f: usize) -> f64 {
        let (o, n, w) = (mesh.owner[f] as usize, mesh.neighbour[f] as usize, mesh.weight[f]);
        if alpha[o] == alpha[n] && (alpha[o] == 0.0 || alpha[o] == 1.0) {
            // Within one of the fluids.
            return 0.0;
        }
        let g = self.gradient[o].scaled(w).axpy(1.0 - w, self.gradient[n]);
        let mut speed = self.c_alpha * (1.0 - self.ic_alpha) * phi.abs() / mesh.mag_area[f];
        if self.ic_alpha > 0.0 {
            let isotropic = w * self.speed[o] + (1.0 - w) * self.speed[n];
            speed += self.c_alpha * self.ic_alpha * isotropic;
        }
        let phi_r = speed * dot(g, mesh.area[f]) / (norm(g) + self.least_gradient);
        // Fluid 1 comes from one side and fluid 2 from the other.
        let (up, down) = if phi_r >= 0.0 { (alpha[o], alpha[n]) } else { (alpha[n], alpha[o]) };
        let linear = w * alpha[o] + (1.0 - w) * alpha[n];
        let k = centrality(alpha[o]).min(centrality(alpha[n])).max(self.least_centrality);
        let one = k * linear + (1.0 - k) * up;
        let other = k * (1.0 - linear) + (1.0 - k) * (1.0 - down);
        phi_r * one * other
    }
}

/// The share of central interpolation: 1 in the middle of an interface, 0 in either fluid
/// (Deshpande et al., eq. 10).
#[inline]
fn centrality(alpha: f64) -> f64 {
    let away = 1.0 - (4.0 * alpha * (1.0 - alpha)).max(0.0).sqrt();
    (1.0 - away * away).clamp(0.0, 1.0)
}
