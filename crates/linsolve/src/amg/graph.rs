//! The matrix of a level while the hierarchy is built and refreshed: off-diagonals by rows and the
//! sum of each row. The diagonal is `row sum - off-diagonals`, which keeps single precision free of
//! cancellation: coarse row sums are sums of fine ones.

use granflow_par::Exec;

use crate::csr::Csr;

/// No row, no entry.
pub(crate) const NONE: u32 = u32::MAX;

/// A row sum below this part of the row's magnitudes is rounding: kept, it would make a singular
/// system one of any sign.
const NOISE: f64 = 1e-14;

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

    /// The pattern of the finest level: ghosts folded, other ranks left out.
    pub(crate) fn of(a: &Csr) -> Graph {
        let mut col = Vec::with_capacity(a.col.len());
        for i in 0..a.rows() {
            let row = a.row(i).0.iter();
            col.extend(row.map(|&c| a.folded(c).filter(|&j| j != i).map_or(NONE, |j| j as u32)));
        }
        let (nnz, n) = (col.len(), a.rows());
        Graph { ptr: a.ptr.clone(), col, val: vec![0.0; nnz], sum: vec![0.0; n] }
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
}

/// How a coarse matrix is summed from a fine one (Galerkin with piecewise constants): sums of
/// entries, for each coarse entry and each coarse row.
#[derive(Debug, Default)]
pub(crate) struct Galerkin {
    entry_ptr: Vec<u32>,
    entry_src: Vec<u32>,
    pub(crate) child_ptr: Vec<u32>,
    pub(crate) child: Vec<u32>,
    /// Couplings to rows that the coarse level leaves out; they stay on the diagonal.
    dropped_ptr: Vec<u32>,
    dropped: Vec<u32>,
}

/// Groups `0..key.len()` by key: `(ptr, members)`; [`NONE`] is left out.
fn group(key: &[u32], n: usize) -> (Vec<u32>, Vec<u32>) {
    let mut ptr = vec![0u32; n + 1];
    key.iter().filter(|k| **k != NONE).for_each(|k| ptr[*k as usize + 1] += 1);
    (0..n).for_each(|i| ptr[i + 1] += ptr[i]);
    let mut at = ptr.clone();
    let mut members = vec![0u32; ptr[n] as usize];
    for (i, k) in key.iter().enumerate().filter(|(_, k)| **k != NONE) {
        members[at[*k as usize] as usize] = i as u32;
        at[*k as usize] += 1;
    }
    (ptr, members)
}

impl Galerkin {
    /// The coarse pattern for the aggregates `parent` (`coarse` of them) and how to fill it.
    pub(crate) fn build(fine: &Graph, parent: &[u32], coarse: usize) -> (Galerkin, Graph) {
        let (child_ptr, child) = group(parent, coarse);
        let mut g = Galerkin { child_ptr, child, dropped_ptr: vec![0], ..Galerkin::default() };
        let mut out = Graph { ptr: vec![0], sum: vec![0.0; coarse], ..Graph::default() };
        let mut to = vec![NONE; fine.col.len()];
        let mut place = vec![NONE; coarse];
        for i in 0..coarse {
            let start = out.col.len() as u32;
            for c in g.child_ptr[i] as usize..g.child_ptr[i + 1] as usize {
                for k in fine.entries(g.child[c] as usize) {
                    if fine.col[k] == NONE {
                        continue;
                    }
                    let j = parent[fine.col[k] as usize];
                    if j == NONE {
                        g.dropped.push(k as u32);
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
            g.dropped_ptr.push(g.dropped.len() as u32);
        }
        (g.entry_ptr, g.entry_src) = group(&to, out.col.len());
        out.val.resize(out.col.len(), 0.0);
        (g, out)
    }

    /// Fills the coarse values.
    pub(crate) fn refresh(&self, exec: &Exec, fine: &Graph, coarse: &mut Graph) {
        let range = |p: &[u32], i: usize| p[i] as usize..p[i + 1] as usize;
        exec.for_each(&mut coarse.val, |first, val| {
            for (e, v) in val.iter_mut().enumerate() {
                let src = &self.entry_src[range(&self.entry_ptr, first + e)];
                *v = src.iter().map(|&k| fine.val[k as usize]).sum();
            }
        });
        exec.for_each(&mut coarse.sum, |first, sum| {
            for (i, s) in sum.iter_mut().enumerate() {
                let own = &self.child[range(&self.child_ptr, first + i)];
                let lost = &self.dropped[range(&self.dropped_ptr, first + i)];
                *s = own.iter().map(|&c| fine.sum[c as usize]).sum::<f32>()
                    - lost.iter().map(|&k| fine.val[k as usize]).sum::<f32>();
            }
        });
    }
}
