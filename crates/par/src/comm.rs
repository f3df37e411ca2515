//! Communication between ranks.

/// What the numerics ask of a set of ranks. Every rank must make the same calls in the same order.
///
/// Sums and maxima are formed in rank order, so every rank gets the same bits.
pub trait Comm: Send + Sync {
    /// Number of this rank, from zero.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn size(&self) -> usize;
    /// Replaces each entry by its sum over the ranks.
    fn sum(&self, x: &mut [f64]);
    /// Replaces each entry by its maximum over the ranks; NaN when any is NaN.
    fn max(&self, x: &mut [f64]);
    /// `sends[k]` goes to `peers[k]` (never oneself) and `recvs[k]` is filled from `peers[k]`.
    /// A peer may occur several times: its messages pair up in order. Only the peers take part.
    fn exchange(&self, peers: &[usize], sends: &[Vec<f64>], recvs: &mut [Vec<f64>]);
    /// Returns when every rank has arrived.
    fn barrier(&self);
    /// Rank 0 gets everybody's numbers in rank order, the others `None`.
    fn gather(&self, mine: Vec<f64>) -> Option<Vec<Vec<f64>>>;
    /// Replaces `x` by rank 0's.
    fn broadcast(&self, x: &mut Vec<f64>);
}

/// The only rank.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solo;

impl Comm for Solo {
    fn rank(&self) -> usize {
        0
    }
    fn size(&self) -> usize {
        1
    }
    fn sum(&self, _: &mut [f64]) {}
    fn max(&self, _: &mut [f64]) {}
    fn exchange(&self, peers: &[usize], _: &[Vec<f64>], _: &mut [Vec<f64>]) {
        debug_assert!(peers.is_empty(), "a single rank has no peers");
    }
    fn barrier(&self) {}
    fn gather(&self, mine: Vec<f64>) -> Option<Vec<Vec<f64>>> {
        Some(vec![mine])
    }
    fn broadcast(&self, _: &mut Vec<f64>) {}
}
