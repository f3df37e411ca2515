//! One cycle: a forward sweep, a coarse correction by at most two steps of a Krylov method
//! (K-cycle; Notay and Vassilevski 2008), a backward sweep. All in single precision.

use granflow_par::Exec;

use super::hierarchy::{Bottom, Level};

/// A coarse residual reduced to this part needs no second Krylov step.
const ENOUGH: f64 = 0.25;

/// What a cycle needs to know.
pub(crate) struct Cycle<'a> {
    pub(crate) exec: &'a Exec,
    pub(crate) symmetric: bool,
}

impl Cycle<'_> {
    /// `z = M b` on the first of `levels`.
    pub(crate) fn precondition<const N: usize>(
        &self,
        levels: &mut [Level<N>],
        bottom: Option<&mut Bottom<N>>,
    ) {
        let Some((Level { matrix, down, b, z, t, .. }, coarse)) = levels.split_first_mut() else {
            return;
        };
        let exec = self.exec;
        matrix.forward(exec, b, z);
        match (coarse.first_mut(), bottom) {
            (None, None) => return matrix.backward(exec, z),
            (Some(next), bottom) => {
                matrix.left_over(exec, z, t);
                down.restrict(exec, t, &mut next.b);
                self.solve(coarse, bottom);
                down.prolong(exec, &coarse[0].c, z);
            }
            (None, Some(bottom)) => {
                matrix.left_over(exec, z, t);
                down.restrict(exec, t, &mut bottom.b);
                bottom.solve();
                down.prolong(exec, &bottom.x, z);
            }
        }
        matrix.sweep_back(exec, b, z, t);
    }

    /// `c = A^-1 b` roughly, on the first of `levels`: one or two steps of flexible conjugate
    /// gradients or, for an unsymmetric matrix, of conjugate residuals.
    fn solve<const N: usize>(&self, levels: &mut [Level<N>], mut bottom: Option<&mut Bottom<N>>) {
        let exec = self.exec;
        self.precondition(levels, bottom.as_deref_mut());
        let Level { matrix, b, z, c, v, .. } = &mut levels[0];
        std::mem::swap(z, c);
        let (bb, cc) = (&*b, &*c);
        // The test space: directions, or their images.
        let [rho, alpha, size] = matrix.times(exec, cc, v, |first, v| {
            let w = if self.symmetric { &cc[first..first + v.len()] } else { v };
            let b = &bb[first..first + v.len()];
            [inner(w, v), inner(w, b), inner(b, b)]
        });
        if rho <= 0.0 || rho.is_nan() {
            return;
        }
        let step = (alpha / rho) as f32;
        let vv = &*v;
        let [left] = exec.for_each_local_sums(b, |first, b| {
            for (b, v) in b.iter_mut().zip(&vv[first..]) {
                (0..N).for_each(|k| b[k] -= step * v[k]);
            }
            [inner(b, b)]
        });
        if left <= ENOUGH * ENOUGH * size {
            return combine(exec, c, step, &[], 0.0);
        }
        self.precondition(levels, bottom);
        let Level { matrix, b, z, t, c, v, .. } = &mut levels[0];
        let (bb, cc, vv) = (&*b, &*z, &*v);
        let [gamma, beta, alpha2] = matrix.times(exec, cc, t, |first, t| {
            let all = first..first + t.len();
            let w = if self.symmetric { &cc[all.clone()] } else { t };
            [inner(w, &vv[all.clone()]), inner(w, t), inner(w, &bb[all])]
        });
        let rho2 = beta - gamma * gamma / rho;
        if rho2 <= 0.0 || rho2.is_nan() {
            return combine(exec, c, step, &[], 0.0);
        }
        let second = alpha2 / rho2;
        combine(exec, c, (alpha / rho - gamma * second / rho) as f32, z, second as f32);
    }
}

/// `c = p c + q z`.
fn combine<const N: usize>(exec: &Exec, c: &mut [[f32; N]], p: f32, z: &[[f32; N]], q: f32) {
    exec.for_each(c, |first, c| {
        c.iter_mut().for_each(|c| *c = c.map(|c| p * c));
        if !z.is_empty() {
            for (c, z) in c.iter_mut().zip(&z[first..]) {
                (0..N).for_each(|k| c[k] += q * z[k]);
            }
        }
    });
}

/// Scalar product of two blocks: single precision side by side over short stretches.
fn inner<const N: usize>(a: &[[f32; N]], b: &[[f32; N]]) -> f64 {
    let stretch = |a: &[[f32; N]], b: &[[f32; N]]| {
        let mut s = [0.0f32; 16];
        for (a, b) in a.chunks_exact(16).zip(b.chunks_exact(16)) {
            for lane in 0..16 {
                for c in 0..N {
                    s[lane] += a[lane][c] * b[lane][c];
                }
            }
        }
        s.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    a.chunks(256).zip(b.chunks(256)).map(|(a, b)| stretch(a, b)).sum()
}
