//! Threads that stay awake between what is shared: one that sleeps needs some 30 µs to come, and a tick is shared two or three times.

use rayon::Yield;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How long a thread waits for more to do: longer than one thread is busy between two ticks that are shared, some 75 µs with 169 200
/// elements (contact of the first, and a tick of what contact steps more often; 165 µs when this was chosen). It makes two threads 3 to 5 %
/// faster there and takes 4 to 7 % more CPU time; longer it would only take a core.
pub(super) const SPIN_TIME: Duration = Duration::from_micros(250);

/// What a thread is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ThreadDuty {
    /// Nothing.
    None,
    /// A part of what is shared: while it waits for another part it must begin no watch.
    Part,
    /// All that comes: it watches, or leads.
    Whole,
}

thread_local! {
    // What is run while its thread waits for another part can ask nobody else what that thread does.
    static DUTY: Cell<ThreadDuty> = const { Cell::new(ThreadDuty::None) };
}

/// While this lives its thread has this duty, unless it has a greater one.
pub(super) struct DutyGuard {
    before: ThreadDuty,
}

impl DutyGuard {
    pub fn with(duty: ThreadDuty) -> Self {
        Self { before: DUTY.replace(DUTY.get().max(duty)) }
    }
}

impl Drop for DutyGuard {
    fn drop(&mut self) {
        DUTY.set(self.before);
    }
}

/// What threads watch for.
#[derive(Debug)]
pub(super) struct WorkerSpin {
    spin_time: Duration,
    /// Whether more may come.
    is_running: AtomicBool,
    /// Whether all threads were called, and none has left or could not come since.
    workers_called: AtomicBool,
    /// How many threads watch.
    n_spinning: AtomicUsize,
}

impl WorkerSpin {
    pub fn new(spin_time: Duration) -> Self {
        Self { spin_time, is_running: false.into(), workers_called: false.into(), n_spinning: 0.into() }
    }

    /// Does a work on a thread of a pool; the others watch from its first [call](Self::call) on.
    pub fn keep_awake<R>(&self, work: impl FnOnce() -> R) -> R {
        let (_engaged, _open) = (DutyGuard::with(ThreadDuty::Whole), SpinGuard::new(self));
        work()
    }

    /// Calls the other threads of the pool that this one is of, unless they were called.
    pub fn wake_workers(self: &Arc<Self>) {
        if self.is_running.load(Ordering::Relaxed) && !self.workers_called.swap(true, Ordering::Relaxed) {
            let spin = Arc::clone(self);
            rayon::spawn_broadcast(move |_| spin.spin());
        }
    }

    /// Does what is shared until nothing more can come, or nothing comes for a while.
    fn spin(&self) {
        match DUTY.get() {
            ThreadDuty::None => {}
            ThreadDuty::Part => return self.workers_called.store(false, Ordering::Relaxed),
            ThreadDuty::Whole => return,
        }
        let _engaged = DutyGuard::with(ThreadDuty::Whole);
        self.n_spinning.fetch_add(1, Ordering::Relaxed);
        let mut since = Instant::now();
        while self.is_running.load(Ordering::Relaxed) && since.elapsed() < self.spin_time {
            if rayon::yield_now() == Some(Yield::Executed) {
                since = Instant::now();
            } else {
                // Who has something to do has the core.
                std::thread::yield_now();
            }
        }
        self.n_spinning.fetch_sub(1, Ordering::Relaxed);
        self.workers_called.store(false, Ordering::Relaxed);
    }
}

/// While this lives, more may come; it ends also where a panic ends the work.
struct SpinGuard<'a>(&'a WorkerSpin);

impl<'a> SpinGuard<'a> {
    fn new(spin: &'a WorkerSpin) -> Self {
        spin.workers_called.store(false, Ordering::Relaxed);
        spin.is_running.store(true, Ordering::Relaxed);
        Self(spin)
    }
}

impl Drop for SpinGuard<'_> {
    fn drop(&mut self) {
        self.0.is_running.store(false, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pool;
    use super::super::pool::{SplitWork, share_work};
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// As long as no test takes.
    const FOREVER: Duration = Duration::from_hours(1);

    /// So many numbers to count.
    struct Numbers(usize);

    impl SplitWork for Numbers {
        fn split_at_part(self, part: usize, of: usize) -> (Self, Self) {
            let first = self.0 * part / of;
            (Self(first), Self(self.0 - first))
        }
    }

    /// Shares numbers again and again, as many as are returned in all.
    fn count(pool: &Pool) -> usize {
        let counted = AtomicUsize::new(0);
        let add = |numbers: Numbers| _ = counted.fetch_add(numbers.0, Ordering::Relaxed);
        (0..100).for_each(|_| share_work(Some(pool), 16, Numbers(1000), add));
        counted.into_inner()
    }

    /// Shares until all others watch.
    fn wait_until_all_spin(pool: &Pool) {
        wait_for(|| {
            share_work(Some(pool), 2, Numbers(2), |_| ());
            n_spinning(pool) == pool.threads() - 1
        });
    }

    fn n_spinning(pool: &Pool) -> usize {
        pool.spin().n_spinning.load(Ordering::Relaxed)
    }

    fn wait_for(mut done: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !done() {
            assert!(begun.elapsed().as_secs() < 60, "it takes too long");
            std::thread::yield_now();
        }
    }

    #[test]
    fn other_threads_watch_while_one_leads_and_no_longer() {
        for threads in [2, 4] {
            let pool = Pool::with_spin_time(threads, FOREVER).expect("threads");
            for _ in 0..3 {
                assert_eq!(pool.lead(|| count(&pool)), 100_000);
                pool.lead(|| wait_until_all_spin(&pool));
                wait_for(|| n_spinning(&pool) == 0);
            }
        }
    }

    #[test]
    fn nobody_waits_for_who_has_panicked() {
        let pool = Pool::with_spin_time(2, FOREVER).expect("threads");
        let panics = || {
            wait_until_all_spin(&pool);
            share_work(Some(&pool), 16, Numbers(1000), |_| panic!("on purpose"));
        };
        assert!(catch_unwind(AssertUnwindSafe(|| pool.lead(panics))).is_err());
        wait_for(|| n_spinning(&pool) == 0);
        assert_eq!(pool.lead(|| count(&pool)), 100_000);
    }

    #[test]
    fn who_has_left_for_want_of_work_is_called_again() {
        let pool = Pool::with_spin_time(3, Duration::from_millis(20)).expect("threads");
        pool.lead(|| {
            for _ in 0..3 {
                wait_until_all_spin(&pool);
                wait_for(|| n_spinning(&pool) == 0);
            }
        });
    }
}
