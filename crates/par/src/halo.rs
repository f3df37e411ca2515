//! Ghost values: copies of cells that live on other ranks or across a periodic or wedge patch.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use granflow_base::{Tensor, Value};

use crate::exec::Exec;

/// One stretch of ghosts and where their values come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The rank at the other end; the own rank for a periodic or wedge image.
    pub rank: usize,
    /// Own cells whose values go there, in the order of the receiver's ghosts. Never ghosts.
    pub send: Vec<u32>,
    /// Own ghosts filled from there; for a link to oneself as many as `send`.
    pub recv: Range<usize>,
    /// Rotation that the receiver applies to what arrives.
    pub rotation: Option<Tensor>,
}

/// The exchange plan of a mesh. Ghosts live at the tail of every cell array.
///
/// Two ranks may share several links; they pair up in the order in which both list them.
#[derive(Default)]
pub struct Halo {
    links: Vec<Link>,
    /// First ghost: everything before is an own cell.
    first: usize,
    buffers: Mutex<Buffers>,
}

/// One entry per link to another rank.
#[derive(Default)]
struct Buffers {
    peers: Vec<usize>,
    sends: Vec<Vec<f64>>,
    recvs: Vec<Vec<f64>>,
}

impl std::fmt::Debug for Halo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Halo").field("links", &self.links.len()).finish_non_exhaustive()
    }
}

impl Halo {
    /// A plan of these links.
    ///
    /// # Panics
    /// When a link sends a ghost; ghosts of ghosts are not supported.
    pub fn new(links: Vec<Link>) -> Halo {
        let first = links.iter().map(|l| l.recv.start).min().unwrap_or(0);
        assert!(
            links.iter().all(|l| l.send.iter().all(|&c| (c as usize) < first)),
            "a link sends own cells only, and ghosts come after them"
        );
        Halo { links, first, buffers: Mutex::default() }
    }
    /// No ghosts.
    pub fn none() -> Halo {
        Halo::default()
    }
    /// The links.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Fills the ghosts of `x`. All ranks that share a link must call. No allocation after the
    /// first call.
    ///
    /// # Panics
    /// When `x` has no room for the ghosts, or a peer sends a different number of values.
    pub fn update<T: Value>(&self, exec: &Exec, x: &mut [T]) {
        if self.links.is_empty() {
            return;
        }
        let me = exec.rank();
        self.copy_images(exec, me, x);
        if self.links.iter().any(|l| l.rank != me) {
            self.swap(exec, me, x);
        }
    }

    fn copy_images<T: Value>(&self, exec: &Exec, me: usize, x: &mut [T]) {
        let (own, ghosts) = x.split_at_mut(self.first);
        let own = &*own;
        for l in self.links.iter().filter(|l| l.rank == me) {
            let out = &mut ghosts[l.recv.start - self.first..l.recv.end - self.first];
            let turn = l.rotation.filter(|_| T::N > 1);
            exec.for_each(out, |first, out| {
                let from = &l.send[first..first + out.len()];
                match &turn {
                    None => out.iter_mut().zip(from).for_each(|(g, &c)| *g = own[c as usize]),
                    Some(r) => {
                        let each = out.iter_mut().zip(from);
                        each.for_each(|(g, &c)| *g = own[c as usize].rotated(r));
                    }
                }
            });
        }
    }

    fn swap<T: Value>(&self, exec: &Exec, me: usize, x: &mut [T]) {
        let mut b = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let b = &mut *b;
        let away = || self.links.iter().filter(|l| l.rank != me);
        b.peers.clear();
        b.peers.extend(away().map(|l| l.rank));
        b.sends.resize_with(b.peers.len(), Vec::new);
        b.recvs.resize_with(b.peers.len(), Vec::new);
        for (l, out) in away().zip(&mut b.sends) {
            out.clear();
            for &c in &l.send {
                let v = x[c as usize];
                out.extend((0..T::N).map(|k| v.comp(k)));
            }
        }
        exec.comm().exchange(&b.peers, &b.sends, &mut b.recvs);
        for (l, data) in away().zip(&b.recvs) {
            assert_eq!(data.len(), l.recv.len() * T::N, "halo: rank {} sent too few", l.rank);
            for (g, d) in x[l.recv.clone()].iter_mut().zip(data.chunks_exact(T::N)) {
                (0..T::N).for_each(|k| g.set_comp(k, d[k]));
                if let Some(r) = &l.rotation {
                    *g = g.rotated(r);
                }
            }
        }
    }

    /// For every ghost the own cell it images, or `u32::MAX` when it lives on another rank.
    pub fn local_image(&self, own_rank: usize, n_ghosts: usize) -> Vec<u32> {
        let mut image = vec![u32::MAX; n_ghosts];
        for l in self.links.iter().filter(|l| l.rank == own_rank) {
            for (g, &c) in l.recv.clone().zip(&l.send) {
                image[g - self.first] = c;
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_base::rotation_about;

    #[test]
    fn images_are_copied_and_vectors_turned() {
        let turn = rotation_about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        let halo = Halo::new(vec![
            Link { rank: 0, send: vec![0, 2], recv: 3..5, rotation: None },
            Link { rank: 0, send: vec![1], recv: 5..6, rotation: Some(turn) },
        ]);
        let exec = Exec::serial();
        let mut x = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0];
        halo.update(&exec, &mut x);
        assert_eq!(x[3..], [1.0, 3.0, 2.0]);
        let mut v = [[1.0, 0.0, 0.0]; 6];
        halo.update(&exec, &mut v);
        assert!((v[5][1] - 1.0).abs() < 1e-15 && v[5][0].abs() < 1e-15);
        assert_eq!(halo.local_image(0, 3), [0, 2, 1]);
        assert_eq!(halo.local_image(1, 3), [u32::MAX; 3]);
    }

    #[test]
    #[should_panic(expected = "own cells only")]
    fn a_ghost_of_a_ghost_is_refused() {
        let link = |send, recv| Link { rank: 0, send: vec![send], recv, rotation: None };
        Halo::new(vec![link(0, 1..2), link(1, 2..3)]);
    }
}
