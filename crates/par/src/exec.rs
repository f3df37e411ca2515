//! Loops and sums over arrays, on a team of threads, with results that do not depend on its size.

use std::ops::Range;
use std::sync::{Mutex, TryLockError};

use granflow_base::Value;

use crate::comm::{Comm, Solo};
use crate::team::Team;

/// Entries per partial sum. Part of the definition of every sum: do not tune it per machine.
pub const BLOCK: usize = 4096;
/// Below this a loop is not worth a barrier, unless [`Exec::sharing_from`] says so.
const MIN_SPLIT: usize = 1024;

/// A team of threads and a communicator: everything a loop needs to know about parallelism.
///
/// Calls from inside a loop body are allowed and run on the calling thread.
pub struct Exec {
    team: Team,
    comm: Box<dyn Comm>,
    /// Loops of fewer entries are not split.
    least: usize,
    /// Partial sums, kept between calls.
    parts: Mutex<Vec<f64>>,
}

impl std::fmt::Debug for Exec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Exec({} threads, rank {}/{})", self.threads(), self.rank(), self.ranks())
    }
}

/// A pointer to a slice whose disjoint parts go to different threads.
struct Parts<T>(*mut T, usize);
// SAFETY: every use hands each index to one thread only, and `T: Send`.
#[allow(unsafe_code)]
unsafe impl<T: Send> Sync for Parts<T> {}
impl<T> Parts<T> {
    fn new(s: &mut [T]) -> Self {
        Parts(s.as_mut_ptr(), s.len())
    }
    /// The entries `r` of the slice.
    ///
    /// # Safety
    /// The slice outlives the result, and no two results that live at once overlap.
    #[allow(unsafe_code, clippy::mut_from_ref)]
    unsafe fn get(&self, r: Range<usize>) -> &mut [T] {
        debug_assert!(r.start <= r.end && r.end <= self.1);
        // SAFETY: in bounds by construction of the callers' ranges; disjoint by contract.
        unsafe { std::slice::from_raw_parts_mut(self.0.add(r.start), r.end - r.start) }
    }
}

impl Exec {
    /// One thread, one rank.
    pub fn serial() -> Exec {
        Exec::new(1, Box::new(Solo))
    }
    /// `threads` threads (at least one; the caller counts as the first) on each rank of `comm`.
    pub fn new(threads: usize, comm: Box<dyn Comm>) -> Exec {
        let (team, parts) = (Team::new(threads.max(1)), Mutex::new(Vec::new()));
        Exec { team, comm, least: MIN_SPLIT, parts }
    }
    /// Shares loops of `least` entries or more among the threads: small meshes then show in tests
    /// whether threads change the result. Where sums begin and end stays as it is.
    #[must_use]
    pub fn sharing_from(self, least: usize) -> Exec {
        Exec { least, ..self }
    }
    /// Threads of this rank.
    pub fn threads(&self) -> usize {
        self.team.threads()
    }
    /// The communicator.
    pub fn comm(&self) -> &dyn Comm {
        &*self.comm
    }
    /// Number of this rank.
    pub fn rank(&self) -> usize {
        self.comm.rank()
    }
    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.comm.size()
    }

    /// Calls `f(first_index, chunk)` on disjoint chunks that cover `out`. Where the chunks begin
    /// depends on the number of threads: `f` must treat each entry independently of them.
    pub fn for_each<T: Send>(&self, out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
        let n = out.len();
        if n < self.least || self.threads() == 1 {
            return if n > 0 {
                f(0, out)
            };
        }
        let parts = Parts::new(out);
        self.split(n, &|r| {
            // SAFETY: `split` hands out disjoint ranges of 0..n, and `out` is borrowed meanwhile.
            #[allow(unsafe_code)]
            f(r.start, unsafe { parts.get(r.clone()) });
        });
    }

    /// As [`Exec::for_each`] for two arrays.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn for_each2<A: Send, B: Send>(
        &self,
        a: &mut [A],
        b: &mut [B],
        f: impl Fn(usize, &mut [A], &mut [B]) + Sync,
    ) {
        assert_eq!(a.len(), b.len(), "for_each2 needs arrays of one length");
        let n = a.len();
        if n < self.least || self.threads() == 1 {
            return if n > 0 {
                f(0, a, b)
            };
        }
        let (a, b) = (Parts::new(a), Parts::new(b));
        self.split(n, &|r| {
            // SAFETY: as in `for_each`.
            #[allow(unsafe_code)]
            unsafe {
                f(r.start, a.get(r.clone()), b.get(r.clone()));
            }
        });
    }

    /// Calls `f(first_index, block)` once for each block of `block` entries of `out` (the last may
    /// be shorter), for methods whose result depends on where blocks begin: they stay the same for
    /// any number of threads.
    ///
    /// # Panics
    /// When `block` is zero.
    pub fn for_each_block<T: Send>(
        &self,
        out: &mut [T],
        block: usize,
        f: impl Fn(usize, &mut [T]) + Sync,
    ) {
        assert!(block > 0, "blocks hold at least one entry");
        let n = out.len();
        let out = Parts::new(out);
        self.each_block(n.div_ceil(block), &|k| {
            let r = k * block..((k + 1) * block).min(n);
            // SAFETY: the blocks are disjoint parts of 0..n, each given out once.
            #[allow(unsafe_code)]
            f(r.start, unsafe { out.get(r.clone()) });
        });
    }

    /// Sum of `f` over blocks that cover `0..n`, over all ranks.
    pub fn sum(&self, n: usize, f: impl Fn(Range<usize>) -> f64 + Sync) -> f64 {
        self.sums(n, |r| [f(r)])[0]
    }

    /// `K` sums at once: `f` returns the partial sums of a block. Blocks of [`BLOCK`] entries are
    /// added in order, then ranks in order. No allocation after the first call of a size.
    pub fn sums<const K: usize>(
        &self,
        n: usize,
        f: impl Fn(Range<usize>) -> [f64; K] + Sync,
    ) -> [f64; K] {
        self.all_ranks(self.blocks(n, [0.0; K], &f, add))
    }

    /// As [`Exec::sums`], of this rank alone: for work that other ranks do not share.
    pub fn local_sums<const K: usize>(
        &self,
        n: usize,
        f: impl Fn(Range<usize>) -> [f64; K] + Sync,
    ) -> [f64; K] {
        self.blocks(n, [0.0; K], &f, add)
    }

    /// Largest value of `f` over blocks that cover `0..n` of all ranks; NaN when any is NaN and
    /// minus infinity when there are none.
    pub fn max(&self, n: usize, f: impl Fn(Range<usize>) -> f64 + Sync) -> f64 {
        let mut m = self.blocks(n, [f64::NEG_INFINITY], &|r| [f(r)], |a, b| [larger(a[0], b[0])]);
        self.comm.max(&mut m);
        m[0]
    }

    /// Changes `out` block by block and sums what `f(first_index, block)` returns: a loop and its
    /// sums in one pass over memory. Order of addition as in [`Exec::sums`].
    pub fn for_each_sums<T: Send, const K: usize>(
        &self,
        out: &mut [T],
        f: impl Fn(usize, &mut [T]) -> [f64; K] + Sync,
    ) -> [f64; K] {
        self.all_ranks(self.for_each_local_sums(out, f))
    }

    /// As [`Exec::for_each_sums`], with the sums of this rank alone.
    pub fn for_each_local_sums<T: Send, const K: usize>(
        &self,
        out: &mut [T],
        f: impl Fn(usize, &mut [T]) -> [f64; K] + Sync,
    ) -> [f64; K] {
        let n = out.len();
        let out = Parts::new(out);
        let g = |r: Range<usize>| {
            // SAFETY: `blocks` gives each block of 0..n to one thread, once.
            #[allow(unsafe_code)]
            f(r.start, unsafe { out.get(r.clone()) })
        };
        self.blocks(n, [0.0; K], &g, add)
    }

    /// As [`Exec::for_each_sums`] for two arrays.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn for_each2_sums<A: Send, B: Send, const K: usize>(
        &self,
        a: &mut [A],
        b: &mut [B],
        f: impl Fn(usize, &mut [A], &mut [B]) -> [f64; K] + Sync,
    ) -> [f64; K] {
        assert_eq!(a.len(), b.len(), "for_each2_sums needs arrays of one length");
        let n = a.len();
        let (a, b) = (Parts::new(a), Parts::new(b));
        let g = |r: Range<usize>| {
            // SAFETY: as in `for_each_sums`.
            #[allow(unsafe_code)]
            unsafe {
                f(r.start, a.get(r.clone()), b.get(r.clone()))
            }
        };
        self.all_ranks(self.blocks(n, [0.0; K], &g, add))
    }

    /// Scalar product of the first `b.len()` entries, over all ranks (`a` may carry ghosts).
    ///
    /// # Panics
    /// When `a` is shorter than `b`.
    pub fn dot<T: Value>(&self, a: &[T], b: &[T]) -> f64 {
        let a = &a[..b.len()];
        self.sum(b.len(), |r| {
            // Eight sums side by side: the compiler may use vector registers.
            let (a, b) = (&a[r.clone()], &b[r]);
            let mut s = [0.0; 8];
            let (pa, pb) = (a.chunks_exact(8), b.chunks_exact(8));
            let tail = pa.remainder().iter().zip(pb.remainder());
            let rest: f64 = tail.map(|(x, y)| x.inner(*y)).sum();
            for (a, b) in pa.zip(pb) {
                for k in 0..8 {
                    s[k] += a[k].inner(b[k]);
                }
            }
            ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])) + rest
        })
    }

    fn all_ranks<const K: usize>(&self, mut s: [f64; K]) -> [f64; K] {
        self.comm.sum(&mut s);
        s
    }

    /// One range per thread.
    fn split(&self, n: usize, f: &(dyn Fn(Range<usize>) + Sync)) {
        // Multiples of 16 entries: threads seldom share a cache line.
        let chunk = n.div_ceil(self.threads()).next_multiple_of(16);
        self.team.run(&|k| {
            let r = (k * chunk).min(n)..((k + 1) * chunk).min(n);
            if !r.is_empty() {
                f(r);
            }
        });
    }

    /// Calls `f` once for each block number, contiguous ranges of them per thread.
    fn each_block(&self, blocks: usize, f: &(dyn Fn(usize) + Sync)) {
        let t = self.threads();
        if blocks < 2 || t == 1 {
            return (0..blocks).for_each(f);
        }
        self.team.run(&|k| (k * blocks / t..(k + 1) * blocks / t).for_each(f));
    }

    /// Combines `f` of all blocks of `0..n` in block order.
    fn blocks<const K: usize>(
        &self,
        n: usize,
        zero: [f64; K],
        f: &(impl Fn(Range<usize>) -> [f64; K] + Sync),
        combine: impl Fn([f64; K], [f64; K]) -> [f64; K],
    ) -> [f64; K] {
        let range = |k: usize| k * BLOCK..((k + 1) * BLOCK).min(n);
        let blocks = n.div_ceil(BLOCK);
        if blocks < 2 || self.threads() == 1 {
            return (0..blocks).fold(zero, |s, k| combine(s, f(range(k))));
        }
        let mut fresh = Vec::new();
        let mut kept = match self.parts.try_lock() {
            Ok(g) => Some(g),
            Err(TryLockError::Poisoned(g)) => Some(g.into_inner()),
            // A sum inside a sum: rare, so it may allocate.
            Err(TryLockError::WouldBlock) => None,
        };
        let parts = kept.as_deref_mut().unwrap_or(&mut fresh);
        if parts.len() < blocks * K {
            parts.resize(blocks * K, 0.0);
        }
        let out = Parts::new(parts);
        self.each_block(blocks, &|k| {
            let s = f(range(k));
            // SAFETY: each block number is given out once; its K places overlap no others.
            #[allow(unsafe_code)]
            unsafe { out.get(k * K..(k + 1) * K) }.copy_from_slice(&s);
        });
        (0..blocks).fold(zero, |s, k| combine(s, std::array::from_fn(|i| parts[k * K + i])))
    }
}

fn add<const K: usize>(a: [f64; K], b: [f64; K]) -> [f64; K] {
    std::array::from_fn(|k| a[k] + b[k])
}

/// The larger of two numbers, NaN when either is.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn for_each_visits_every_entry_once() {
        let exec = |least| Exec::new(3, Box::new(Solo)).sharing_from(least);
        for (n, exec) in [0, 1, 7, 40, 1023, 1024, 5000, 100_000]
            .into_iter()
            .flat_map(|n| [(n, exec(1)), (n, exec(1024))])
        {
            let mut x = vec![0usize; n];
            exec.for_each(&mut x, |first, c| {
                c.iter_mut().enumerate().for_each(|(i, x)| *x += first + i + 1)
            });
            assert!(x.iter().enumerate().all(|(i, x)| *x == i + 1), "{n}");
            let mut y = vec![0usize; n];
            exec.for_each2(&mut x, &mut y, |_, x, y| y.copy_from_slice(x));
            assert_eq!(x, y);
            exec.for_each_block(&mut x, 1000, |first, c| {
                assert!(first % 1000 == 0 && c.len() <= 1000);
                c.iter_mut().for_each(|x| *x *= 2);
            });
            assert!(x.iter().zip(&y).all(|(x, y)| *x == 2 * y));
        }
    }

    #[test]
    fn small_loops_are_shared_on_demand_only() {
        let begun = |exec: Exec| {
            let mut x = [usize::MAX; 64];
            exec.for_each(&mut x, |first, c| c.fill(first));
            let mut parts = x.to_vec();
            parts.dedup();
            parts
        };
        assert_eq!(begun(Exec::new(3, Box::new(Solo))), [0]);
        assert_eq!(begun(Exec::new(3, Box::new(Solo)).sharing_from(1)), [0, 32]);
    }

    #[test]
    fn max_carries_nan_on() {
        let exec = Exec::new(2, Box::new(Solo));
        let mut x = vec![1.0; 20_000];
        x[15_000] = 3.0;
        let max = |x: &[f64]| exec.max(x.len(), |r| x[r].iter().copied().fold(-1.0, larger));
        assert_eq!(max(&x), 3.0);
        x[3] = f64::NAN;
        assert!(max(&x).is_nan());
        assert_eq!(exec.max(0, |_| 0.0), f64::NEG_INFINITY);
    }

    #[test]
    fn a_loop_with_sums_equals_loop_then_sum() {
        let exec = Exec::new(2, Box::new(Solo));
        let mut x: Vec<f64> = (0..30_000).map(|i| f64::from(i).sin()).collect();
        let [s] = exec.for_each_sums(&mut x, |_, c| {
            c.iter_mut().for_each(|x| *x *= 3.0);
            [c.iter().sum()]
        });
        assert_eq!(s, exec.sum(x.len(), |r| x[r].iter().sum()));
        let mut y = x.clone();
        let [s] = exec.for_each2_sums(&mut x, &mut y, |_, x, y| {
            [x.iter().zip(y).map(|(x, y)| *x * *y).sum()]
        });
        assert!((s - exec.dot(&x, &y)).abs() < 1e-9 * s);
    }
}
