//! Aggregates by repeated pairwise matching along the strongest couplings (Notay 2010, An
//! aggregation-based algebraic multigrid method, ETNA 37).

use granflow_par::Exec;

use super::graph::{Galerkin, Graph, NONE};

/// A pair is made only along couplings of at least this part of the row's strongest.
const STRONG: f32 = 0.25;
/// A row whose off-diagonals sum to less than this part of its diagonal needs no coarse correction.
const DOMINANT: f32 = 0.6;
/// A row left alone joins a pair that holds at least this part of its couplings.
const HANGS: f32 = 0.3;

/// The aggregate of each row ([`NONE`]: none) and their number, after `passes` rounds of pairing
/// (up to `2^passes` rows each).
pub(crate) fn aggregate(g: &Graph, passes: usize, finest: bool) -> (Vec<u32>, usize) {
    let skip = |i: usize| {
        let off: f32 = g.row(i).map(|(_, v)| v.abs()).sum();
        off < DOMINANT * g.diagonal(i)
    };
    let (mut parent, mut n) = pair(g, |i| finest && skip(i));
    let exec = Exec::serial();
    for _ in 1..passes {
        let (galerkin, mut mid) = Galerkin::build(g, &parent, n);
        galerkin.refresh(&exec, g, &mut mid);
        let (up, m) = pair(&mid, |_| false);
        parent.iter_mut().filter(|p| **p != NONE).for_each(|p| *p = up[*p as usize]);
        n = m;
    }
    (parent, n)
}

/// One round: each row joins the strongest of its neighbours that is still free. Rows left over
/// join the pair they hang on; without this, high contrast leaves stars of rows that never shrink.
fn pair(g: &Graph, skip: impl Fn(usize) -> bool) -> (Vec<u32>, usize) {
    let mut parent = vec![NONE; g.rows()];
    let out: Vec<bool> = (0..g.rows()).map(skip).collect();
    let mut n = 0u32;
    let mut alone = Vec::new();
    for i in 0..g.rows() {
        if parent[i] != NONE || out[i] {
            continue;
        }
        let strongest = g.row(i).map(|(_, v)| -v).fold(0.0, f32::max);
        let mut best = (STRONG * strongest, None);
        for (j, v) in g.row(i) {
            // A later candidate must be clearly stronger: rounding must not choose.
            let better = if best.1.is_some() { -v > best.0 * 1.0001 } else { -v >= best.0 };
            if parent[j] == NONE && !out[j] && better && v < 0.0 {
                best = (-v, Some(j));
            }
        }
        match best.1 {
            Some(j) => {
                (parent[i], parent[j]) = (n, n);
                n += 1;
            }
            None => alone.push(i),
        }
    }
    // Decided before any of them moves: a row joins a pair, never another that was left over.
    let home: Vec<u32> = alone.iter().map(|&i| home(g, &parent, i)).collect();
    for (&i, &p) in alone.iter().zip(&home) {
        parent[i] = if p == NONE { n } else { p };
        n += u32::from(p == NONE);
    }
    // Numbered in the order of their first rows, which keeps neighbours close.
    let mut number = vec![NONE; n as usize];
    let mut next = 0;
    for p in parent.iter_mut().filter(|p| **p != NONE) {
        let new = &mut number[*p as usize];
        if *new == NONE {
            *new = next;
            next += 1;
        }
        *p = *new;
    }
    (parent, n as usize)
}

/// The pair that row `i` hangs on, if any.
fn home(g: &Graph, parent: &[u32], i: usize) -> u32 {
    let total: f32 = g.row(i).map(|(_, v)| v.abs()).sum();
    let mut best = (HANGS * total, NONE);
    for (j, v) in g.row(i).filter(|(j, _)| parent[*j] != NONE) {
        let p = parent[j];
        let held: f32 = g.row(i).filter(|(k, _)| parent[*k] == p).map(|(_, v)| -v).sum();
        if v < 0.0 && held > best.0 * 1.0001 {
            best = (held, p);
        }
    }
    best.1
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
        let (parent, count) = aggregate(&g, 1, true);
        assert_eq!(parent[1], parent[2]);
        assert_ne!(parent[2], parent[3]);
        // The two ends have nobody left but the pair next to them.
        assert_eq!((count, parent[0], parent[n - 1]), (7, parent[1], parent[n - 2]));
        let (_, count) = aggregate(&g, 2, true);
        assert!(count <= 4, "{count}");
    }
}
