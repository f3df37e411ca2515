//! The levels, from the matrix down to one that is inverted. Built again for other values in the
//! memory they have.

use granflow_par::Exec;

use super::aggregate::Aggregator;
use super::cycle::Cycle;
use super::dense::Dense;
use super::graph::{Graph, NONE, clear, fill};
use super::level::{Matrix, Slots, Transfer};
use crate::csr::Csr;

/// Rows of a level that is inverted.
const DIRECT: usize = 64;
/// Aggregates are of this quality or better; where that hardly makes a level smaller, whatever
/// they cost.
const WORST: f32 = 8.0;

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
pub(crate) struct Level<const N: usize> {
    graph: Graph,
    aggregates: Aggregator,
    /// Its rows, close together what is strongly coupled.
    order: Vec<u32>,
    pub(crate) matrix: Matrix,
    /// To the next level; of no meaning at the coarsest.
    pub(crate) down: Transfer,
    pub(crate) b: Slots<N>,
    pub(crate) z: Slots<N>,
    pub(crate) t: Slots<N>,
    /// For the Krylov steps: first direction, its image.
    pub(crate) c: Slots<N>,
    pub(crate) v: Slots<N>,
}

/// The coarsest matrix, inverted.
#[derive(Debug, Default)]
pub(crate) struct Bottom<const N: usize> {
    graph: Graph,
    dense: Dense,
    pub(crate) b: Slots<N>,
    pub(crate) x: Slots<N>,
    /// Its rows in their order: they are not rearranged.
    rows: Vec<u32>,
}

impl<const N: usize> Bottom<N> {
    /// `x = A^-1 b`.
    pub(crate) fn solve(&mut self) {
        self.dense.apply(&self.b, &mut self.x);
    }
}

/// Levels from fine to coarse.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy<const N: usize> {
    /// Those in use, then some that an earlier matrix needed.
    levels: Vec<Level<N>>,
    used: usize,
    bottom: Bottom<N>,
    /// Whether the bottom is in use.
    direct: bool,
}

impl<const N: usize> Hierarchy<N> {
    /// Builds levels for the values of `a`, each times `k`.
    pub(crate) fn build(&mut self, exec: &Exec, a: &Csr, k: f64, params: Params) {
        self.direct = params.levels > 1 && a.rows() <= DIRECT;
        self.used = usize::from(!self.direct);
        self.coarsen(exec, a, k, params);
        let Hierarchy { levels, used, bottom, direct } = self;
        let levels = &mut levels[..*used];
        bottom.rows.clear();
        if *direct {
            let n = bottom.graph.rows();
            bottom.dense.resize(n);
            clear(&mut bottom.rows, DIRECT);
            bottom.rows.extend(0..n as u32);
            fill(&mut bottom.b, n, [0.0; N]);
            fill(&mut bottom.x, n, [0.0; N]);
        }
        for l in (0..levels.len()).rev() {
            let (fine, coarse) = levels[l..].split_at_mut(1);
            let fine = &mut fine[0];
            let below = match coarse.first() {
                Some(next) => {
                    Some((&next.order, &next.matrix.layout.row, &next.matrix.layout.slot))
                }
                None => direct.then_some((&bottom.rows, &bottom.rows, &bottom.rows)),
            };
            fine.arrange(below.map(|(order, ..)| &order[..]));
            if let Some((_, row, slot)) = below {
                fine.down.place(&fine.matrix.layout, &fine.aggregates.parent, row, slot);
            }
        }
        self.refresh_matrices(exec);
    }

    /// Forms the matrices of all levels.
    fn coarsen(&mut self, exec: &Exec, a: &Csr, k: f64, params: Params) {
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        let finest = if self.direct { &mut self.bottom.graph } else { &mut self.levels[0].graph };
        finest.adopt(a);
        finest.refresh(exec, a, k);
        while !self.direct && self.used < params.levels {
            if self.levels.len() == self.used {
                self.levels.push(Level::default());
            }
            let (fine, next) = self.levels.split_at_mut(self.used);
            let (fine, next) = (&mut fine[self.used - 1], &mut next[0]);
            let n = fine.graph.rows();
            let mut coarse = fine.aggregates.aggregate(&fine.graph, params.passes, WORST);

            if coarse * 4 > n * 3 {
                coarse = fine.aggregates.aggregate(&fine.graph, params.passes, f32::MAX);
            }
            if coarse == 0 || coarse * 10 > n * 9 {
                break;
            }
            self.direct = coarse <= DIRECT;
            let next = if self.direct { &mut self.bottom.graph } else { &mut next.graph };
            let galerkin = &mut fine.down.galerkin;
            galerkin.build(&fine.graph, &fine.aggregates.parent, coarse, next);
            galerkin.refresh(exec, &fine.graph, next);
            self.used += usize::from(!self.direct);
        }
    }

    /// Takes up the values of `a`, each times `k`; the aggregates stay.
    pub(crate) fn refresh(&mut self, exec: &Exec, a: &Csr, k: f64) {
        let Hierarchy { levels, used, bottom, direct } = self;
        match levels[..*used].first_mut() {
            Some(l) => l.graph.refresh(exec, a, k),
            None => bottom.graph.refresh(exec, a, k),
        }
        for l in 0..*used {
            let (fine, coarse) = levels[l..*used].split_at_mut(1);
            let next = match coarse.first_mut() {
                Some(next) => &mut next.graph,
                None if *direct => &mut bottom.graph,
                None => break,
            };
            fine[0].down.galerkin.refresh(exec, &fine[0].graph, next);
        }
        self.refresh_matrices(exec);
    }

    fn refresh_matrices(&mut self, exec: &Exec) {
        self.levels[..self.used].iter_mut().for_each(|l| l.matrix.refresh(exec, &l.graph));
        if self.direct {
            self.bottom.dense.refresh(&self.bottom.graph);
        }
    }

    /// The vector of the finest level to be filled with the right-hand side, in slots, and the row
    /// in each slot.
    pub(crate) fn input(&mut self) -> (&mut [[f32; N]], &[u32]) {
        match self.levels[..self.used].first_mut() {
            Some(l) => (&mut l.b, &l.matrix.layout.row),
            None => (&mut self.bottom.b, &self.bottom.rows),
        }
    }
    /// The result of [`Hierarchy::cycle`] and the slot of each row.
    pub(crate) fn output(&self) -> (&[[f32; N]], &[u32]) {
        match self.levels[..self.used].first() {
            Some(l) => (&l.z, &l.matrix.layout.slot),
            None => (&self.bottom.x, &self.bottom.rows),
        }
    }
    /// One cycle on the input.
    pub(crate) fn cycle(&mut self, exec: &Exec, symmetric: bool) {
        let cycle = Cycle { exec, symmetric };
        match self.used {
            0 => self.bottom.solve(),
            used => {
                let bottom = self.direct.then_some(&mut self.bottom);
                cycle.precondition(&mut self.levels[..used], bottom);
            }
        }
    }
}

impl<const N: usize> Level<N> {
    /// Orders the rows, aggregate by aggregate in the order of the next level, then the rest:
    /// stretches of it are clusters along the strong couplings, of whatever shape.
    fn arrange(&mut self, below: Option<&[u32]>) {
        let Level { graph, aggregates, order, matrix, down, b, z, t, c, v } = self;
        let n = graph.rows();
        clear(order, n);
        match below {
            None => order.extend(0..n as u32),
            Some(below) => {
                let children = &down.galerkin.children;
                below.iter().for_each(|&i| order.extend_from_slice(children.of(i as usize)));
                let rest = (0..n as u32).filter(|&i| aggregates.parent[i as usize] == NONE);
                order.extend(rest);
            }
        }
        matrix.build(graph, order);
        [b, z, t, c, v].into_iter().for_each(|w| fill(w, matrix.slots(), [0.0; N]));
    }
}
