//! A standing team of threads: spawned once, woken for each loop by a barrier that spins first.
//!
//! Waking a pool that sleeps costs some 15 us, a spinning team 0.2 us; at 1e4 to 1e5 cells this
//! decides whether a second core helps. A worker that found nothing to do for a while parks.

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;

/// What the team runs: called once per thread with the number of the thread.
type Job<'a> = dyn Fn(usize) + Sync + 'a;

/// Keeps a counter that one thread writes and others poll in a cache line of its own.
#[repr(align(128))]
struct Line<T>(T);

struct Shared {
    /// Number of jobs announced so far.
    epoch: Line<AtomicUsize>,
    /// Workers that have not finished the present job.
    remaining: Line<AtomicUsize>,
    /// The present job; written by the caller only while every worker waits for the next epoch.
    job: UnsafeCell<Option<*const Job<'static>>>,
    stop: AtomicBool,
    sleepers: AtomicUsize,
    lock: Mutex<()>,
    wake: Condvar,
    /// First panic of a worker, to be carried on by the caller.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    /// Polls before yielding.
    spin: u32,
}

// SAFETY: `job` is the only field that is not `Sync` by itself. The caller writes it before the
// release increment of `epoch` and workers read it after the acquire load that sees it; the next
// write comes after every worker's release decrement of `remaining` was acquired. The pointee is
// `Sync`, so sharing it is sound.
#[allow(unsafe_code)]
unsafe impl Sync for Shared {}
// SAFETY: as above; the pointer is only followed while the caller of `Team::run` is inside `run`.
#[allow(unsafe_code)]
unsafe impl Send for Shared {}

/// The threads of an [`crate::Exec`] besides the calling one.
pub(crate) struct Team {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
    /// Set while a job runs: a nested or concurrent call runs on its own thread instead.
    busy: AtomicBool,
}

impl Team {
    /// Spawns `threads - 1` workers; fewer when the system refuses more.
    pub(crate) fn new(threads: usize) -> Team {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let shared = Arc::new(Shared {
            epoch: Line(AtomicUsize::new(0)),
            remaining: Line(AtomicUsize::new(0)),
            job: UnsafeCell::new(None),
            stop: AtomicBool::new(false),
            sleepers: AtomicUsize::new(0),
            lock: Mutex::new(()),
            wake: Condvar::new(),
            panic: Mutex::new(None),
            // More threads than cores: spinning would only keep the others from working.
            spin: if threads <= cores { 4000 } else { 20 },
        });
        let mut workers = Vec::new();
        for k in 1..threads {
            let s = Arc::clone(&shared);
            let builder = std::thread::Builder::new().name(format!("granflow-{k}"));
            match builder.spawn(move || work(&s, k)) {
                Ok(w) => workers.push(w),
                Err(_) => break,
            }
        }
        Team { shared, workers, busy: AtomicBool::new(false) }
    }

    /// Threads including the caller.
    pub(crate) fn threads(&self) -> usize {
        self.workers.len() + 1
    }

    /// Runs `f(0)` here and `f(1)`, `f(2)`, ... on the workers; returns when all have finished.
    /// A call from inside a job (or from a second thread at the same time) runs them in turn here.
    pub(crate) fn run(&self, f: &Job<'_>) {
        if self.workers.is_empty() || self.busy.swap(true, Ordering::Acquire) {
            (0..self.threads()).for_each(f);
            return;
        }
        let s = &*self.shared;
        // SAFETY: the lifetime of `f` is erased, but no worker follows the pointer after
        // `remaining` has reached zero, which is awaited below before returning or unwinding.
        // `busy` makes this the only writer, and all workers wait for the next epoch.
        #[allow(unsafe_code)]
        unsafe {
            *s.job.get() = Some(std::mem::transmute::<*const Job<'_>, *const Job<'static>>(f));
        }
        s.remaining.0.store(self.workers.len(), Ordering::Relaxed);
        s.epoch.0.fetch_add(1, Ordering::SeqCst);
        s.rouse();
        let mine = catch_unwind(AssertUnwindSafe(|| f(0)));
        s.poll(|| s.remaining.0.load(Ordering::Acquire) == 0, u32::MAX);
        let theirs = s.panic.lock().unwrap_or_else(PoisonError::into_inner).take();
        self.busy.store(false, Ordering::Release);
        if let Err(p) = mine {
            resume_unwind(p);
        }
        if let Some(p) = theirs {
            resume_unwind(p);
        }
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.epoch.0.fetch_add(1, Ordering::SeqCst);
        self.shared.rouse();
        for w in self.workers.drain(..) {
            // A worker catches the panics of its jobs; there is nothing left to report.
            let _ = w.join();
        }
    }
}

impl Shared {
    /// Wakes parked workers. SeqCst orders this load after the increment of `epoch`, and a worker
    /// counts itself a sleeper before it looks at `epoch` again: one of the two sees the other.
    fn rouse(&self) {
        if self.sleepers.load(Ordering::SeqCst) > 0 {
            let _guard = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
            self.wake.notify_all();
        }
    }

    /// Spins, then yields up to `yields` times, until `ready`; says whether it became so.
    fn poll(&self, ready: impl Fn() -> bool, yields: u32) -> bool {
        for _ in 0..self.spin {
            if ready() {
                return true;
            }
            std::hint::spin_loop();
        }
        let mut left = yields;
        while !ready() {
            if left == 0 {
                return false;
            }
            if yields != u32::MAX {
                left -= 1;
            }
            std::thread::yield_now();
        }
        true
    }

    fn await_epoch_after(&self, seen: usize) {
        let news = || self.epoch.0.load(Ordering::SeqCst) != seen;
        if self.poll(news, 64) {
            return;
        }
        let mut guard = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        self.sleepers.fetch_add(1, Ordering::SeqCst);
        while !news() {
            guard = self.wake.wait(guard).unwrap_or_else(PoisonError::into_inner);
        }
        self.sleepers.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Life of a worker.
fn work(s: &Shared, k: usize) {
    let mut seen = 0usize;
    loop {
        s.await_epoch_after(seen);
        seen = seen.wrapping_add(1);
        if s.stop.load(Ordering::SeqCst) {
            return;
        }
        // SAFETY: the job was written before the epoch that was just acquired, and its referent
        // outlives the job because `run` waits for the decrement below.
        #[allow(unsafe_code)]
        let job = unsafe { *s.job.get() };
        if let Some(job) = job {
            // SAFETY: see above.
            #[allow(unsafe_code)]
            let job: &Job<'_> = unsafe { &*job };
            if let Err(p) = catch_unwind(AssertUnwindSafe(|| job(k))) {
                s.panic.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(p);
            }
        }
        s.remaining.0.fetch_sub(1, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_thread_runs_every_job_once() {
        let team = Team::new(3);
        let hits: Vec<AtomicUsize> = (0..3).map(|_| AtomicUsize::new(0)).collect();
        for round in 0..200 {
            if round % 50 == 0 {
                // Long enough for the workers to park.
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            team.run(&|k| {
                hits[k].fetch_add(1, Ordering::Relaxed);
            });
        }
        assert!(hits.iter().all(|h| h.load(Ordering::Relaxed) == 200));
    }

    #[test]
    fn a_nested_call_runs_in_place() {
        let team = Team::new(2);
        let n = AtomicUsize::new(0);
        team.run(&|_| {
            team.run(&|_| {
                n.fetch_add(1, Ordering::Relaxed);
            })
        });
        assert_eq!(n.load(Ordering::Relaxed), 4);
    }

    #[test]
    fn a_panic_of_a_worker_reaches_the_caller_and_the_team_survives() {
        let team = Team::new(2);
        let caught = catch_unwind(AssertUnwindSafe(|| team.run(&|k| assert_eq!(k, 0, "worker"))));
        assert!(caught.is_err());
        let n = AtomicUsize::new(0);
        team.run(&|_| {
            n.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(n.load(Ordering::Relaxed), 2);
    }
}
