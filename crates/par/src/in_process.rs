//! Ranks as threads of one process: decomposed runs are tested without a launcher.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::comm::Comm;
use crate::exec::larger;

/// One of several ranks that live in one process.
pub struct InProcess {
    rank: usize,
    board: Arc<Board>,
}

impl std::fmt::Debug for InProcess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "InProcess({}/{})", self.rank, self.size())
    }
}

struct Board {
    size: usize,
    state: Mutex<State>,
    changed: Condvar,
}

/// Everything shared; one lock, for clarity rather than speed.
struct State {
    arrived: usize,
    generation: usize,
    /// What each rank brought to the present collective call.
    slots: Vec<Vec<f64>>,
    /// Messages from rank `i` to rank `j` at `i * size + j`.
    mail: Vec<Channel>,
    /// A rank has panicked: the others must not wait for it.
    dead: bool,
}

/// Messages on their way from one rank to another, and the buffers they travel in.
///
/// A rank can be one exchange ahead of its peer, no more: it has to read the peer's answer before
/// it sends again. Two buffers for each message of an exchange are therefore enough whatever the
/// threads' timing is, and all of them exist after the first exchange.
#[derive(Clone, Default)]
struct Channel {
    /// Oldest first.
    letters: VecDeque<Vec<f64>>,
    spare: Vec<Vec<f64>>,
    /// Buffers made so far, on their way or spare.
    buffers: usize,
    /// Length of the longest message so far.
    longest: usize,
}

impl Channel {
    /// Makes room for `messages` of an exchange, each no longer than `longest`.
    fn reserve(&mut self, messages: usize, longest: usize) {
        if longest > self.longest {
            self.longest = longest;
            self.spare.iter_mut().for_each(|b| b.reserve(longest));
        }
        if self.buffers < 2 * messages {
            let new = 2 * messages - self.buffers;
            self.spare.reserve(2 * messages);
            self.letters.reserve(2 * messages);
            self.spare.extend((0..new).map(|_| Vec::with_capacity(self.longest)));
            self.buffers += new;
        }
    }
    fn send(&mut self, data: &[f64]) {
        let mut letter = self.spare.pop().unwrap_or_else(|| {
            self.buffers += 1;
            Vec::new()
        });
        letter.extend_from_slice(data);
        self.letters.push_back(letter);
    }
    /// Reads the oldest message into `data`.
    fn receive(&mut self, data: &mut Vec<f64>) {
        if let Some(mut letter) = self.letters.pop_front() {
            data.clear();
            data.extend_from_slice(&letter);
            letter.clear();
            letter.reserve(self.longest);
            self.spare.push(letter);
        }
    }
}

impl InProcess {
    /// The `n` ranks of a new world, to be moved to a thread each.
    pub fn world(n: usize) -> Vec<InProcess> {
        let board = Arc::new(Board {
            size: n,
            state: Mutex::new(State {
                arrived: 0,
                generation: 0,
                slots: vec![Vec::new(); n],
                mail: vec![Channel::default(); n * n],
                dead: false,
            }),
            changed: Condvar::new(),
        });
        (0..n).map(|rank| InProcess { rank, board: Arc::clone(&board) }).collect()
    }

    /// Waits until `ready`.
    ///
    /// # Panics
    /// When another rank has panicked: its partners could only wait for ever.
    fn wait<'a>(
        &self,
        mut s: MutexGuard<'a, State>,
        ready: impl Fn(&State) -> bool,
    ) -> MutexGuard<'a, State> {
        while !ready(&s) {
            assert!(!s.dead, "another rank has panicked");
            s = self.board.changed.wait(s).unwrap_or_else(PoisonError::into_inner);
        }
        s
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.board.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Brings `mine`, meets everybody, reads all, meets again.
    fn meet<R>(&self, mine: &[f64], read: impl FnOnce(&[Vec<f64>]) -> R) -> R {
        let mut s = self.lock();
        s.slots[self.rank].clear();
        s.slots[self.rank].extend_from_slice(mine);
        s = self.arrive(s);
        let out = read(&s.slots);
        drop(self.arrive(s));
        out
    }

    fn arrive<'a>(&self, mut s: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        s.arrived += 1;
        if s.arrived == self.board.size {
            s.arrived = 0;
            s.generation = s.generation.wrapping_add(1);
            self.board.changed.notify_all();
            return s;
        }
        let present = s.generation;
        self.wait(s, |s| s.generation != present)
    }

    fn fold(&self, x: &mut [f64], start: f64, f: impl Fn(f64, f64) -> f64) {
        // Through the slots, so that every rank folds the same numbers in the same order.
        let mut s = self.lock();
        s.slots[self.rank].clear();
        s.slots[self.rank].extend_from_slice(x);
        s = self.arrive(s);
        for (i, x) in x.iter_mut().enumerate() {
            *x = s.slots.iter().fold(start, |a, slot| f(a, slot[i]));
        }
        drop(self.arrive(s));
    }
}

impl Drop for InProcess {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.lock().dead = true;
            self.board.changed.notify_all();
        }
    }
}

impl Comm for InProcess {
    fn rank(&self) -> usize {
        self.rank
    }
    fn size(&self) -> usize {
        self.board.size
    }
    fn sum(&self, x: &mut [f64]) {
        self.fold(x, 0.0, |a, b| a + b);
    }
    fn max(&self, x: &mut [f64]) {
        self.fold(x, f64::NEG_INFINITY, larger);
    }
    fn exchange(&self, peers: &[usize], sends: &[Vec<f64>], recvs: &mut [Vec<f64>]) {
        let n = self.board.size;
        let mut s = self.lock();
        for &p in peers {
            let to_p = || peers.iter().zip(sends).filter(|(q, _)| **q == p).map(|(_, d)| d.len());
            s.mail[self.rank * n + p].reserve(to_p().count(), to_p().max().unwrap_or(0));
        }
        for (&p, data) in peers.iter().zip(sends) {
            s.mail[self.rank * n + p].send(data);
        }
        self.board.changed.notify_all();
        for (&p, data) in peers.iter().zip(recvs) {
            s = self.wait(s, |s| !s.mail[p * n + self.rank].letters.is_empty());
            s.mail[p * n + self.rank].receive(data);
        }
    }
    fn barrier(&self) {
        drop(self.arrive(self.lock()));
    }
    fn gather(&self, mine: Vec<f64>) -> Option<Vec<Vec<f64>>> {
        self.meet(&mine, |all| (self.rank == 0).then(|| all.to_vec()))
    }
    fn broadcast(&self, x: &mut Vec<f64>) {
        let mine = std::mem::take(x);
        *x = self.meet(&mine, |all| all[0].clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn everywhere<R: Send>(n: usize, f: impl Fn(InProcess) -> R + Sync) -> Vec<R> {
        std::thread::scope(|s| {
            let f = &f;
            let ranks: Vec<_> =
                InProcess::world(n).into_iter().map(|c| s.spawn(move || f(c))).collect();
            ranks.into_iter().map(|r| r.join().expect("rank")).collect()
        })
    }

    #[test]
    fn sums_and_maxima_agree_on_every_rank() {
        let got = everywhere(3, |c| {
            let mut s = [c.rank() as f64, 1.0];
            let mut m = [c.rank() as f64, if c.rank() == 1 { f64::NAN } else { 0.0 }];
            (0..50).for_each(|_| c.barrier());
            c.sum(&mut s);
            c.max(&mut m);
            (s, m)
        });
        assert!(got.iter().all(|(s, m)| *s == [3.0, 3.0] && m[0] == 2.0 && m[1].is_nan()));
    }

    #[test]
    fn messages_to_one_peer_keep_their_order() {
        let got = everywhere(2, |c| {
            let p = 1 - c.rank();
            let own = c.rank() as f64;
            let mut r = vec![Vec::new(), Vec::new()];
            for round in 0..20 {
                let t = f64::from(round);
                c.exchange(&[p, p], &[vec![own, t], vec![own + 10.0, t]], &mut r);
                assert_eq!(r, [vec![p as f64, t], vec![p as f64 + 10.0, t]]);
            }
            r.len()
        });
        assert_eq!(got, [2, 2]);
    }

    #[test]
    fn gather_and_broadcast() {
        let got = everywhere(3, |c| {
            let all = c.gather(vec![c.rank() as f64; c.rank()]);
            let mut x = vec![c.rank() as f64; 2];
            c.broadcast(&mut x);
            (all, x)
        });
        assert_eq!(got[0].0, Some(vec![vec![], vec![1.0], vec![2.0, 2.0]]));
        assert!(got[1].0.is_none() && got.iter().all(|g| g.1 == [0.0, 0.0]));
    }

    #[test]
    fn a_dead_rank_does_not_hang_the_others() {
        let dead = std::thread::scope(|s| {
            let ranks: Vec<_> = InProcess::world(2)
                .into_iter()
                .map(|c| {
                    s.spawn(move || {
                        assert!(c.rank() != 1, "dies");
                        c.barrier();
                    })
                })
                .collect();
            ranks.into_iter().map(|r| r.join().is_err()).collect::<Vec<_>>()
        });
        assert_eq!(dead, [true, true]);
    }
}
