//! The beginning of every solve: first residual, its normalisation, the noise below which no
//! iteration can help.

use granflow_base::Value;
use granflow_par::Exec;

use crate::csr::Csr;
use crate::solver::{SolveError, Solved, Tolerance};

/// Residuals below this part of `sum(|A||x| + |b|)` are rounding noise.
const NOISE: f64 = 1e-14;
/// A right-hand side of a singular system may miss the range of the matrix by this part of the
/// normalisation: the part that no `x` can match is left out.
const INCOMPATIBLE: f64 = 1e-6;

/// How residuals are judged during one solve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judge {
    norm: f64,
    /// Residual (not normalised) at which to stop.
    goal: f64,
    noise: f64,
    /// Mean residual of a singular system, already taken out; per component.
    pub(crate) singular: bool,
    /// Sum of magnitudes of what was taken out.
    missed: f64,
    pub(crate) solved: Solved,
}

/// `sum |components|`.
#[inline]
pub(crate) fn one_norm<T: Value>(x: T) -> f64 {
    (0..T::N).map(|c| x.comp(c).abs()).sum()
}

impl Judge {
    /// Computes the residual `r` of the guess and how to judge it. `work` is [`Csr::cols`] long.
    pub(crate) fn begin<T: Value>(
        exec: &Exec,
        a: &Csr,
        b: &[T],
        x: &mut [T],
        r: &mut [T],
        work: &mut [T],
        tol: &Tolerance,
    ) -> Result<Judge, SolveError> {
        let n = a.rows();
        a.halo.update(exec, x);
        let x = &*x;
        let mut mean = T::ZERO;
        let count = exec.sum(n, |r| r.len() as f64);
        for c in 0..T::N {
            let s = exec.sum(n, |r| x[r].iter().map(|x| x.comp(c)).sum());
            mean.set_comp(c, if count > 0.0 { s / count } else { 0.0 });
        }
        // Ghosts that are turned make A times a constant vector differ from row sum times it.
        // Whether any are is for all ranks to agree on: the exchange below waits for every one.
        let own = || a.halo.links().iter().any(|l| l.rotation.is_some());
        let turned = T::N > 1 && (exec.ranks() > 1 || own());
        if turned {
            work.fill(mean);
            a.halo.update(exec, work);
        }
        let work = &*work;
        let [norm, scale, size, rows] = exec.for_each_sums(&mut r[..n], |first, r| {
            let mut s = [0.0; 4];
            for (i, r) in r.iter_mut().enumerate() {
                let i = first + i;
                let (col, val) = a.row(i);
                let (mut ax, mut am, mut mag) = (T::ZERO, T::ZERO, 0.0);
                let (mut row, mut row_mag) = (0.0, 0.0);
                for (&c, &v) in col.iter().zip(val) {
                    let xc = x[c as usize];
                    ax = ax.axpy(v, xc);
                    mag += v.abs() * one_norm(xc);
                    row += v;
                    row_mag += v.abs();
                    if turned {
                        am = am.axpy(v, work[c as usize]);
                    }
                }
                if !turned {
                    am = mean.scaled(row);
                }
                *r = b[i].minus(ax);
                s[0] += one_norm(ax.minus(am)) + one_norm(b[i].minus(am));
                s[1] += mag + one_norm(b[i]);
                s[2] += one_norm(*r);
                s[3] += if row.abs() > 1e-11 * row_mag { 1.0 } else { 0.0 };
            }
            s
        });
        if !(norm.is_finite() && scale.is_finite() && size.is_finite()) {
            return Err(SolveError::NotFinite { iteration: 0 });
        }
        let noise = NOISE * scale;
        let norm = norm.max(noise).max(f64::MIN_POSITIVE);
        let mut judge = Judge {
            norm,
            goal: 0.0,
            noise,
            singular: rows == 0.0 && T::N == 1,
            missed: 0.0,
            solved: Solved::default(),
        };
        let first = judge.normalised(size);
        judge.solved = Solved { iterations: 0, first, last: first };
        judge.goal = tol.abs.max(tol.rel * first) * norm;
        if judge.singular && !judge.done_at(size) {
            // Project: only the part of mean zero can be matched.
            let sum = exec.sum(n, |s| r[s].iter().map(|r| r.comp(0)).sum());
            let mut shift = T::ZERO;
            shift.set_comp(0, -sum / count);
            judge.missed = sum.abs();
            exec.for_each(&mut r[..n], |_, r| r.iter_mut().for_each(|r| *r = r.plus(shift)));
        }
        Ok(judge)
    }

    fn normalised(&self, size: f64) -> f64 {
        if size <= self.noise { 0.0 } else { size / self.norm }
    }
    pub(crate) fn done_at(&self, size: f64) -> bool {
        size <= self.goal.max(self.noise)
    }
    /// Whether the guess was good enough.
    pub(crate) fn done_at_start(&self) -> bool {
        self.solved.first == 0.0 || self.solved.first * self.norm <= self.goal
    }
    /// Records the residual's sum of magnitudes after an iteration; says whether to stop.
    pub(crate) fn record(&mut self, iteration: usize, size: f64) -> Result<bool, SolveError> {
        if !size.is_finite() {
            return Err(SolveError::NotFinite { iteration });
        }
        self.solved.iterations = iteration;
        self.solved.last = self.normalised(size);
        Ok(self.done_at(size))
    }
    /// Reduction of the residual so far, in powers of ten.
    pub(crate) fn decades(&self) -> f64 {
        (self.solved.first / self.solved.last.max(self.noise / self.norm)).log10()
    }
    /// The verdict of a solve that met its goal.
    pub(crate) fn finish(&self) -> Result<Solved, SolveError> {
        if self.missed > INCOMPATIBLE * self.norm && self.missed > self.goal {
            let last = self.solved.last + self.missed / self.norm;
            return Err(SolveError::NotConverged(Solved { last, ..self.solved }));
        }
        Ok(self.solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_lost_in_noise_is_no_miracle() {
        let (noise, solved) = (1e-9, Solved { iterations: 0, first: 1e-2, last: 1e-2 });
        let mut judge =
            Judge { norm: 10.0, goal: 0.0, noise, singular: false, missed: 0.0, solved };
        assert_eq!(judge.record(5, 1e-12), Ok(true));
        assert_eq!(judge.solved.last, 0.0);
        assert!((judge.decades() - 8.0).abs() < 1e-9, "{}", judge.decades());
    }
}
