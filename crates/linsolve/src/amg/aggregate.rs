//! Aggregates by repeated pairwise matching, each checked for its quality (Napov and Notay 2012,
//! An algebraic multigrid method with guaranteed convergence rate, SIAM J. Sci. Comput. 34).
//!
//! The quality of a set of rows `G` is the largest `v.D(v - mean v) / v.A_G v`, where `A_G` keeps
//! the couplings within the set: how much worse than on its coarse unknown the matrix acts on what
//! varies within. Lines of strong couplings give aggregates of 4, isotropic ones of 8.

use super::graph::{Graph, Groups, NONE, clear, fill};
use super::quality::Quality;

/// A row whose off-diagonals sum to less than this part of its diagonal needs no coarse correction.
const DOMINANT: f32 = 0.6;
/// Rows of an aggregate at most.
const MOST: usize = 12;
/// Partners looked at before a row is left alone.
const TRIES: usize = 2;
/// A later candidate must be better by this factor: rounding must not choose.
const CLEARLY: f32 = 0.9999;

/// Finds aggregates, in memory that is kept.
#[derive(Debug, Default)]
pub(crate) struct Aggregator {
    /// The aggregate of each row, [`NONE`] for none.
    pub(crate) parent: Vec<u32>,
    /// Aggregates of the rounds before: their rows, their matrix, sums of fine diagonals.
    groups: Groups,
    mid: Graph,
    weight: Vec<f32>,
    /// One round: new aggregate of each old one, the old ones of each new one as a list.
    joined: Vec<u32>,
    head: Vec<u32>,
    next: Vec<u32>,
    alone: Vec<u32>,
    place: Vec<u32>,
    quality: Quality,
}

impl Aggregator {
    /// Fills `parent` for the rows of `g` by `passes` rounds of pairing; returns the number of
    /// aggregates. None is worse than `worst`.
    pub(crate) fn aggregate(&mut self, g: &Graph, passes: usize, worst: f32) -> usize {
        let n = g.rows();
        clear(&mut self.parent, n);
        clear(&mut self.weight, n);
        let mut count = 0;
        for i in 0..n {
            let off: f32 = g.row(i).map(|(_, v)| v.abs()).sum();
            let out = off < DOMINANT * g.diagonal(i);
            self.parent.push(if out { NONE } else { count });
            count += u32::from(!out);
        }
        self.quality.begin(n);
        for _ in 0..passes {
            self.groups.sort(&self.parent, count as usize);
            self.mid.collapse(g, &self.parent, &self.groups, &mut self.place);
            self.weight.clear();
            let diagonals = |i| self.groups.of(i).iter().map(|&c| g.diagonal(c as usize)).sum();
            self.weight.extend((0..count as usize).map(|i| -> f32 { diagonals(i) }));
            let before = count;
            count = self.pair(g, worst);
            let joined = &self.joined;
            let held = self.parent.iter_mut().filter(|p| **p != NONE);
            held.for_each(|p| *p = joined[*p as usize]);
            if count == before {
                break;
            }
        }
        count as usize
    }

    /// One round: each aggregate joins the one among its neighbours, still free, with which it is
    /// at its best. Those left over join a pair if that stays good: without this, high contrast
    /// leaves stars of rows that never shrink.
    fn pair(&mut self, g: &Graph, worst: f32) -> u32 {
        let n = self.mid.rows();
        fill(&mut self.joined, n, NONE);
        fill(&mut self.next, n, NONE);
        clear(&mut self.head, n);
        clear(&mut self.alone, n);
        for i in 0..n {
            if self.joined[i] != NONE {
                continue;
            }
            match self.partner(g, i, worst, true) {
                Some(j) => {
                    let new = self.head.len() as u32;
                    (self.joined[i], self.joined[j]) = (new, new);
                    self.head.push(i as u32);
                    self.next[i] = j as u32;
                }
                None => self.alone.push(i as u32),
            }
        }
        for k in 0..self.alone.len() {
            let i = self.alone[k] as usize;
            // A later row may have taken what an earlier one gave up.
            if self.joined[i] != NONE {
                continue;
            }
            match self.partner(g, i, worst, false) {
                Some(j) => {
                    self.joined[i] = self.joined[j];
                    let head = &mut self.head[self.joined[j] as usize];
                    self.next[i] = std::mem::replace(head, i as u32);
                }
                None => {
                    self.joined[i] = self.head.len() as u32;
                    self.head.push(i as u32);
                }
            }
        }
        // Numbered in the order of their first rows, which keeps neighbours close.
        let number = &mut self.place;
        fill(number, self.head.len(), NONE);
        let mut count = 0;
        for p in &mut self.joined {
            let new = &mut number[*p as usize];
            if *new == NONE {
                *new = count;
                count += 1;
            }
            *p = *new;
        }
        count
    }

    /// The best partner of aggregate `i`, among those that are free or those that are not.
    fn partner(&mut self, g: &Graph, i: usize, worst: f32, free: bool) -> Option<usize> {
        let mut refused = [NONE; TRIES];
        for k in 0..TRIES {
            let mut best = (f32::INFINITY, None);
            for (j, v) in self.mid.row(i) {
                let open = (self.joined[j] == NONE) == free && j != i;
                if !open || v >= 0.0 || refused.contains(&(j as u32)) {
                    continue;
                }
                let pair = self.rigid(i, j, -v);
                if pair < CLEARLY * best.0 {
                    best = (pair, Some(j));
                }
            }
            let j = best.1.filter(|_| best.0 <= worst)?;
            // Two rows vary in no other way than against each other; they are to grow on.
            let two = self.groups.of(i).len() == 1 && self.groups.of(j).len() == 1 && free;
            let good = if two { best.0 <= 0.5 * worst } else { self.good(g, i, j, worst) };
            if good {
                return Some(j);
            }
            refused[k] = j as u32;
        }
        None
    }

    /// The quality of two aggregates joined, if nothing varied within each: it is no better.
    fn rigid(&self, i: usize, j: usize, coupling: f32) -> f32 {
        let series = |a: f32, b: f32| if a > 0.0 && b > 0.0 { a * b / (a + b) } else { 0.0 };
        let held = coupling + series(self.mid.sum[i], self.mid.sum[j]);
        series(self.weight[i], self.weight[j]) / held
    }

    /// Whether `i` and what `j` has joined so far make a good aggregate.
    fn good(&mut self, g: &Graph, i: usize, j: usize, worst: f32) -> bool {
        let quality = &mut self.quality;
        quality.clear();
        self.groups.of(i).iter().for_each(|&r| quality.add(r));
        let mut at = match self.joined[j] {
            NONE => j as u32,
            new => self.head[new as usize],
        };
        while at != NONE {
            self.groups.of(at as usize).iter().for_each(|&r| quality.add(r));
            at = self.next[at as usize];
        }
        quality.size() <= MOST && quality.within(g, worst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain with alternating strong and weak couplings.
    #[test]
    fn pairs_follow_the_strong_couplings() {
        let n = 16usize;
        let mut g = Graph { ptr: vec![0], ..Graph::default() };
        for i in 0..n {
            // The coupling between i and i + 1 is strong for odd i.
            let a = |left: usize| if left % 2 == 1 { -100.0 } else { -1.0 };
            if i > 0 {
                g.col.push(i as u32 - 1);
                g.val.push(a(i - 1));
            }
            if i + 1 < n {
                g.col.push(i as u32 + 1);
                g.val.push(a(i));
            }
            g.ptr.push(g.col.len() as u32);
            g.sum.push(0.0);
        }
        let mut made = Aggregator::default();
        let count = made.aggregate(&g, 1, 8.0);
        let parent = &made.parent;
        assert_eq!(parent[1], parent[2]);
        assert_ne!(parent[2], parent[3]);
        // The two ends have nobody left but the pair next to them.
        assert_eq!((count, parent[0], parent[n - 1]), (7, parent[1], parent[n - 2]));
    }

    /// A chain of equal couplings: four rows vary little enough, eight would not.
    #[test]
    fn chains_are_cut_in_fours() {
        let mut g = Graph { ptr: vec![0], ..Graph::default() };
        for i in 0..64u32 {
            for j in [i.wrapping_sub(1), i + 1].into_iter().filter(|j| *j < 64) {
                g.col.push(j);
                g.val.push(-1.0);
            }
            g.ptr.push(g.col.len() as u32);
            g.sum.push(0.0);
        }
        assert_eq!(Aggregator::default().aggregate(&g, 4, 8.0), 16);
    }
}
