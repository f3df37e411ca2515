//! The hierarchy and its cycle: a forward sweep, a coarse correction by at most two steps of a
//! Krylov method (K-cycle; Notay and Vassilevski 2008), a backward sweep. All in single precision.

use granflow_par::Exec;

use super::aggregate::aggregate;
use super::dense::Dense;
use super::graph::{Galerkin, Graph, NONE};
use super::level::{Matrix, Slots, Transfer};
use crate::csr::Csr;

/// Rows of a level that is inverted.
const DIRECT: usize = 64;
/// A coarse residual reduced to this part needs no second Krylov step.
const ENOUGH: f64 = 0.25;

/// How a hierarchy is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Params {
    /// Levels at most; one makes a symmetric Gauss-Seidel sweep.
    pub(crate) levels: usize,
    /// Rounds of pairing per level.
    pub(crate) passes: usize,
}

/// A level that is swept.
#[derive(Debug, Default)]
struct Level<const N: usize> {
    graph: Graph,
    matrix: Matrix,
    /// To the next level; `None` at the coarsest.
    down: Option<Transfer>,
    b: Slots<N>,
    z: Slots<N>,
    t: Slots<N>,
    /// For the Krylov steps: first direction, its image.
    c: Slots<N>,
    v: Slots<N>,
}

/// The coarsest matrix, inverted.
#[derive(Debug, Default)]
struct Bottom<const N: usize> {
    graph: Graph,
    dense: Dense,
    b: Slots<N>,
    x: Slots<N>,
}

/// Levels from fine to coarse.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy<const N: usize> {
    levels: Vec<Level<N>>,
    bottom: Option<Bottom<N>>,
}

impl<const N: usize> Hierarchy<N> {
    /// Builds levels for the values of `a`, each times `k`.
    pub(crate) fn build(exec: &Exec, a: &Csr, k: f64, params: Params) -> Hierarchy<N> {
        let mut finest = Graph::of(a);
        finest.refresh(exec, a, k);
        let mut graphs = vec![finest];
        let mut links: Vec<(Galerkin, Vec<u32>)> = Vec::new();
        let direct = loop {
            let fine = &graphs[graphs.len() - 1];
            let n = fine.rows();
            if params.levels > 1 && n <= DIRECT {
                break true;
            }
            if graphs.len() >= params.levels {
                break false;
            }
            let (parent, coarse) = aggregate(fine, params.passes, links.is_empty());
            if coarse == 0 || coarse * 10 > n * 9 {
                break false;
            }
            let (galerkin, mut next) = Galerkin::build(fine, &parent, coarse);
            galerkin.refresh(exec, fine, &mut next);
            links.push((galerkin, parent));
            graphs.push(next);
        };
        let mut order: Vec<u32> = (0..graphs[graphs.len() - 1].rows() as u32).collect();
        let mut orders = vec![order.clone()];
        for (galerkin, parent) in links.iter().rev() {
            order = clustered(galerkin, parent, &order);
            orders.push(order.clone());
        }
        orders.reverse();
        let bottom = if direct { graphs.pop().map(Bottom::new) } else { None };
        let mut levels: Vec<Level<N>> =
            graphs.into_iter().zip(&orders).map(|(g, o)| Level::new(g, o)).collect();
        for (l, (galerkin, parent)) in links.into_iter().enumerate() {
            let own: Vec<u32>;
            let (row, slot) = match levels.get(l + 1) {
                Some(next) => (&next.matrix.layout.row, &next.matrix.layout.slot),
                None => {
                    own = (0..bottom.as_ref().map_or(0, |b| b.graph.rows() as u32)).collect();
                    (&own, &own)
                }
            };
            let t = Transfer::new(galerkin, &levels[l].matrix.layout, &parent, row, slot);
            levels[l].down = Some(t);
        }
        let mut h = Hierarchy { levels, bottom };
        h.refresh_matrices(exec);
        h
    }

    /// Takes up the values of `a`, each times `k`; the aggregates stay.
    pub(crate) fn refresh(&mut self, exec: &Exec, a: &Csr, k: f64) {
        match (self.levels.first_mut(), self.bottom.as_mut()) {
            (Some(l), _) => l.graph.refresh(exec, a, k),
            (None, Some(b)) => b.graph.refresh(exec, a, k),
            (None, None) => {}
        }
        for l in 0..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            let fine = &fine[l];
            let next = match coarse.first_mut() {
                Some(next) => Some(&mut next.graph),
                None => self.bottom.as_mut().map(|b| &mut b.graph),
            };
            if let (Some(down), Some(next)) = (&fine.down, next) {
                down.galerkin.refresh(exec, &fine.graph, next);
            }
        }
        self.refresh_matrices(exec);
    }

    fn refresh_matrices(&mut self, exec: &Exec) {
        self.levels.iter_mut().for_each(|l| l.matrix.refresh(exec, &l.graph));
        if let Some(b) = &mut self.bottom {
            b.dense.refresh(&b.graph);
        }
    }

    /// The vector of the finest level to be filled with the right-hand side, in slots, and the row
    /// in each slot (`None`: slots are rows).
    pub(crate) fn input(&mut self) -> (&mut [[f32; N]], Option<&[u32]>) {
        match (self.levels.first_mut(), self.bottom.as_mut()) {
            (Some(l), _) => (&mut l.b, Some(&l.matrix.layout.row)),
            (None, Some(b)) => (&mut b.b, None),
            (None, None) => (&mut [], None),
        }
    }
    /// The result of [`Hierarchy::cycle`] and the slot of each row (`None`: slots are rows).
    pub(crate) fn output(&self) -> (&[[f32; N]], Option<&[u32]>) {
        match (self.levels.first(), self.bottom.as_ref()) {
            (Some(l), _) => (&l.z, Some(&l.matrix.layout.slot)),
            (None, Some(b)) => (&b.x, None),
            (None, None) => (&[], None),
        }
    }
    /// One cycle on the input.
    pub(crate) fn cycle(&mut self, exec: &Exec, symmetric: bool) {
        let cycle = Cycle { exec, symmetric };
        match self.levels.is_empty() {
            true => cycle.solve(&mut [], self.bottom.as_mut()),
            false => cycle.precondition(&mut self.levels, self.bottom.as_mut()),
        }
    }
}

impl<const N: usize> Level<N> {
    fn new(graph: Graph, order: &[u32]) -> Self {
        let matrix = Matrix::new(&graph, order);
        let zero = vec![[0.0; N]; matrix.slots()];
        let [b, z, t, c, v] = std::array::from_fn(|_| zero.clone());
        Level { graph, matrix, down: None, b, z, t, c, v }
    }
}
impl<const N: usize> Bottom<N> {
    fn new(graph: Graph) -> Self {
        let zero = vec![[0.0; N]; graph.rows()];
        Bottom { dense: Dense::new(graph.rows()), graph, b: zero.clone(), x: zero }
    }
}

/// The rows of a level, aggregate by aggregate in the `order` of the next level, then the rest:
/// stretches of it are clusters along the strong couplings, of whatever shape.
fn clustered(galerkin: &Galerkin, parent: &[u32], order: &[u32]) -> Vec<u32> {
    let mut out = Vec::with_capacity(parent.len());
    for &i in order {
        let own =
            galerkin.child_ptr[i as usize] as usize..galerkin.child_ptr[i as usize + 1] as usize;
        out.extend_from_slice(&galerkin.child[own]);
    }
    out.extend((0..parent.len() as u32).filter(|&i| parent[i as usize] == NONE));
    out
}

/// What a cycle needs to know.
struct Cycle<'a> {
    exec: &'a Exec,
    symmetric: bool,
}

impl Cycle<'_> {
    /// `z = M b` on the first of `levels`.
    fn precondition<const N: usize>(
        &self,
        levels: &mut [Level<N>],
        bottom: Option<&mut Bottom<N>>,
    ) {
        let Some((fine, coarse)) = levels.split_first_mut() else {
            return;
        };
        let exec = self.exec;
        let Level { matrix, down, b, z, t, .. } = fine;
        matrix.forward(exec, b, z);
        let Some(down) = down else {
            return matrix.backward(exec, z);
        };
        matrix.left_over(exec, z, t);
        let to = match (coarse.first_mut(), &bottom) {
            (Some(next), _) => &mut next.b,
            (None, _) => match bottom {
                Some(bottom) => {
                    down.restrict(exec, t, &mut bottom.b);
                    bottom.dense.apply(&bottom.b, &mut bottom.x);
                    down.prolong(exec, &bottom.x, z);
                    return matrix.sweep_back(exec, b, z, t);
                }
                None => return matrix.backward(exec, z),
            },
        };
        down.restrict(exec, t, to);
        self.solve(coarse, bottom);
        down.prolong(exec, &coarse[0].c, z);
        matrix.sweep_back(exec, b, z, t);
    }

    /// `c = A^-1 b` roughly, on the first of `levels` (or the bottom): one or two steps of
    /// flexible conjugate gradients or, for an unsymmetric matrix, of conjugate residuals.
    fn solve<const N: usize>(&self, levels: &mut [Level<N>], mut bottom: Option<&mut Bottom<N>>) {
        let Some(_) = levels.first() else {
            if let Some(b) = bottom {
                b.dense.apply(&b.b, &mut b.x);
            }
            return;
        };
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
