//! The matrix of a level while the hierarchy is built and refreshed: off-diagonals by rows and the
//! sum of each row. The diagonal is `row sum - off-diagonals`, which keeps single precision free of
//! cancellation: coarse row sums are sums of fine ones.

use granflow_par::{Exec, large_pages};

use crate::csr::Csr;

/// No row, no entry.
pub(crate) const NONE: u32 = u32::MAX;
/// A row sum below this part of the row's magnitudes is rounding: kept, it would make a singular
/// system one of any sign.
const NOISE: f64 = 1e-14;

/// Empties `v` and makes room for `n` entries, with some to spare: a hierarchy that is built again
/// for other values is about as large as before, and must not allocate.
pub(crate) fn clear<T>(v: &mut Vec<T>, n: usize) {
    v.clear();
    if v.capacity() < n {
        v.reserve_exact(n + n / 4);
        large_pages(v);
    }
}
/// As [`clear`], and fills it with `n` times `x`.
pub(crate) fn fill<T: Clone>(v: &mut Vec<T>, n: usize, x: T) {
    clear(v, n);
    v.resize(n, x);
}

/// One level's matrix.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub(crate) ptr: Vec<u32>,
    /// Column; [`NONE`] where an entry counts for the row sum only (diagonal) or not at all.
    pub(crate) col: Vec<u32>,
    pub(crate) val: Vec<f32>,
    /// Row sums.
    pub(crate) sum: Vec<f32>,
}

impl Graph {
    pub(crate) fn rows(&self) -> usize {
        self.sum.len()
    }
    pub(crate) fn entries(&self, i: usize) -> std::ops::Range<usize> {
        self.ptr[i] as usize..self.ptr[i + 1] as usize
    }
    /// Couplings of row `i` to other rows.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let r = self.entries(i);
        let each = self.col[r.clone()].iter().zip(&self.val[r]);
        each.filter(|(c, _)| **c != NONE).map(|(c, v)| (*c as usize, *v))
    }
    pub(crate) fn diagonal(&self, i: usize) -> f32 {
        (f64::from(self.sum[i]) - self.row(i).map(|(_, v)| f64::from(v)).sum::<f64>()) as f32
    }

    /// Takes up the pattern of the finest level: ghosts folded, other ranks left out.
    pub(crate) fn adopt(&mut self, a: &Csr) {
        let (nnz, n) = (a.col.len(), a.rows());
        clear(&mut self.ptr, n + 1);
        self.ptr.extend_from_slice(&a.ptr);
        clear(&mut self.col, nnz);
        for i in 0..n {
            let row = a.row(i).0.iter();
            let own = |&c: &u32| a.folded(c).filter(|&j| j != i).map_or(NONE, |j| j as u32);
            self.col.extend(row.map(own));
        }
        fill(&mut self.val, nnz, 0.0);
        fill(&mut self.sum, n, 0.0);
    }
    /// Takes up the values of `a`, each times `k`.
    pub(crate) fn refresh(&mut self, exec: &Exec, a: &Csr, k: f64) {
        exec.for_each(&mut self.val, |first, val| {
            let each = val.iter_mut().zip(&a.val[first..]);
            each.for_each(|(v, x)| *v = (x * k) as f32);
        });
        exec.for_each(&mut self.sum, |first, sum| {
            for (i, s) in sum.iter_mut().enumerate() {
                let (col, val) = a.row(first + i);
                let kept = col.iter().zip(val).filter(|(c, _)| a.folded(**c).is_some());
                let (sum, size) = kept.fold((0.0, 0.0), |s, (_, v)| (s.0 + v, s.1 + v.abs()));
                *s = if sum.abs() > NOISE * size { (sum * k) as f32 } else { 0.0 };
            }
        });
    }

    /// Becomes the matrix that `fine` has on `groups` of its rows; `parent` is their inverse.
    pub(crate) fn collapse(
        &mut self,
        fine: &Graph,
        parent: &[u32],
        groups: &Groups,
        place: &mut Vec<u32>,
    ) {
        let n = groups.len();
        clear(&mut self.ptr, n + 1);
        self.ptr.push(0);
        clear(&mut self.col, fine.col.len());
        clear(&mut self.val, fine.col.len());
        clear(&mut self.sum, n);
        fill(place, n, NONE);
        for i in 0..n {
            let start = self.col.len();
            let mut sum = 0.0;
            for &c in groups.of(i) {
                sum += fine.sum[c as usize];
                for (j, v) in fine.row(c as usize) {
                    match parent[j] {
                        NONE => sum -= v,
                        j if j as usize == i => {}
                        j => {
                            let p = &mut place[j as usize];
                            if *p == NONE || (*p as usize) < start {
                                *p = self.col.len() as u32;
                                self.col.push(j);
                                self.val.push(v);
                            } else {
                                self.val[*p as usize] += v;
                            }
                        }
                    }
                }
            }
            self.sum.push(sum);
            self.ptr.push(self.col.len() as u32);
        }
    }
}

/// Numbers `0..n` in groups.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    ptr: Vec<u32>,
    members: Vec<u32>,
}

impl Groups {
    pub(crate) fn len(&self) -> usize {
        self.ptr.len() - 1
    }
    #[inline]
    pub(crate) fn of(&self, i: usize) -> &[u32] {
        &self.members[self.ptr[i] as usize..self.ptr[i + 1] as usize]
    }
    /// Groups `0..key.len()` by key; [`NONE`] is left out.
    pub(crate) fn sort(&mut self, key: &[u32], n: usize) {
        fill(&mut self.ptr, n + 1, 0);
        // Counted one place further on, so that filling in moves each to where it belongs.
        let count = |k: &u32| *k != NONE && (*k as usize) + 2 <= n;
        key.iter().filter(|k| count(k)).for_each(|k| self.ptr[*k as usize + 2] += 1);
        (1..n).for_each(|i| self.ptr[i + 1] += self.ptr[i]);
        let all = key.iter().filter(|k| **k != NONE).count();
        fill(&mut self.members, all, 0);
        for (i, k) in key.iter().enumerate().filter(|(_, k)| **k != NONE) {
            let at = &mut self.ptr[*k as usize + 1];
            self.members[*at as usize] = i as u32;
            *at += 1;
        }
    }
}

/// How a coarse matrix is summed from a fine one (Galerkin with piecewise constants): sums of
/// entries, for each coarse entry and each coarse row.
#[derive(Debug, Default)]
pub(crate) struct Galerkin {
    entries: Groups,
    /// Rows of each aggregate.
    pub(crate) children: Groups,
    /// Couplings to rows that the coarse level leaves out; they stay on the diagonal.
    dropped_ptr: Vec<u32>,
    dropped: Vec<u32>,
    to: Vec<u32>,
    place: Vec<u32>,
}

impl Galerkin {
    /// Makes `out` the coarse pattern for the aggregates `parent` (`coarse` of them) and remembers
    /// how to fill it.
    pub(crate) fn build(&mut self, fine: &Graph, parent: &[u32], coarse: usize, out: &mut Graph) {
        let Galerkin { entries, children, dropped_ptr, dropped, to, place } = self;
        children.sort(parent, coarse);
        clear(&mut out.ptr, coarse + 1);
        clear(&mut out.col, fine.col.len());
        fill(&mut out.sum, coarse, 0.0);
        clear(dropped_ptr, coarse + 1);
        clear(dropped, fine.col.len() / 4);
        fill(to, fine.col.len(), NONE);
        fill(place, coarse, NONE);
        out.ptr.push(0);
        dropped_ptr.push(0);
        for i in 0..coarse {
            let start = out.col.len() as u32;
            for &c in children.of(i) {
                for k in fine.entries(c as usize) {
                    if fine.col[k] == NONE {
                        continue;
                    }
                    let j = parent[fine.col[k] as usize];
                    if j == NONE {
                        dropped.push(k as u32);
                    } else if j as usize != i {
                        let p = &mut place[j as usize];
                        if *p == NONE || *p < start {
                            *p = out.col.len() as u32;
                            out.col.push(j);
                        }
                        to[k] = *p;
                    }
                }
            }
            out.ptr.push(out.col.len() as u32);
            dropped_ptr.push(dropped.len() as u32);
        }
        entries.sort(to, out.col.len());
        fill(&mut out.val, out.col.len(), 0.0);
    }

    /// Fills the coarse values.
    pub(crate) fn refresh(&self, exec: &Exec, fine: &Graph, coarse: &mut Graph) {
        exec.for_each(&mut coarse.val, |first, val| {
            for (e, v) in val.iter_mut().enumerate() {
                *v = self.entries.of(first + e).iter().map(|&k| fine.val[k as usize]).sum();
            }
        });
        exec.for_each(&mut coarse.sum, |first, sum| {
            for (i, s) in sum.iter_mut().enumerate() {
                let i = first + i;
                let lost = self.dropped_ptr[i] as usize..self.dropped_ptr[i + 1] as usize;
                let own = self.children.of(i);
                *s = own.iter().map(|&c| fine.sum[c as usize]).sum::<f32>()
                    - self.dropped[lost].iter().map(|&k| fine.val[k as usize]).sum::<f32>();
            }
        });
    }
}
