//! Idle threads that spin between parallel sections: a sleeping thread needs some 30 µs to wake, and a tick has two
//! or three sections.

use rayon::Yield;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Time that an idle thread spins: longer than the serial work between two parallel sections.
///
/// That work is some 75 µs with 169 200 elements (contact, and a tick of the elements that contact steps more
/// often; 165 µs when this was chosen). Spinning makes two threads 3 to 5 % faster there for 4 to 7 % more CPU
/// time; a longer time would only occupy a core.
pub(super) const SPIN_TIME: Duration = Duration::from_micros(250);

/// Duty of a thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ThreadDuty {
    /// The thread has no duty.
    None,
    /// The thread runs one part of a job; while it waits for another part it must not start to spin.
    Part,
    /// The thread spins or leads the job.
    Whole,
}

thread_local! {
    // A task run while its thread waits for another part has no other way to learn the duty of the thread.
    static DUTY: Cell<ThreadDuty> = const { Cell::new(ThreadDuty::None) };
}

/// Guard that gives its thread a duty while it lives, unless the thread has a greater one.
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

/// State shared by the spinning threads.
#[derive(Debug)]
pub(super) struct WorkerSpin {
    spin_time: Duration,
    /// True while more work may come.
    is_running: AtomicBool,
    /// True if all threads were woken, and none has left or failed to come since.
    workers_called: AtomicBool,
    /// Number of spinning threads.
    n_spinning: AtomicUsize,
}

impl WorkerSpin {
    pub fn new(spin_time: Duration) -> Self {
        Self { spin_time, is_running: false.into(), workers_called: false.into(), n_spinning: 0.into() }
    }

    /// Runs a job on a thread of a pool; the other threads spin from the first [`Self::wake_workers`] on.
    pub fn keep_awake<R>(&self, work: impl FnOnce() -> R) -> R {
        let (_duty, _spinning) = (DutyGuard::with(ThreadDuty::Whole), SpinGuard::new(self));
        work()
    }

    /// Wakes the other threads of this thread's pool, unless they were woken before.
    pub fn wake_workers(self: &Arc<Self>) {
        if self.is_running.load(Ordering::Relaxed) && !self.workers_called.swap(true, Ordering::Relaxed) {
            let spin = Arc::clone(self);
            rayon::spawn_broadcast(move |_| spin.spin());
        }
    }

    /// Runs parts of jobs until no more can come, or none comes for the spin time.
    fn spin(&self) {
        match DUTY.get() {
            ThreadDuty::None => {}
            ThreadDuty::Part => return self.workers_called.store(false, Ordering::Relaxed),
            ThreadDuty::Whole => return,
        }
        let _duty = DutyGuard::with(ThreadDuty::Whole);
        self.n_spinning.fetch_add(1, Ordering::Relaxed);
        let mut since = Instant::now();
        while self.is_running.load(Ordering::Relaxed) && since.elapsed() < self.spin_time {
            if rayon::yield_now() == Some(Yield::Executed) {
                since = Instant::now();
            } else {
                // A thread with work gets the core.
                std::thread::yield_now();
            }
        }
        self.n_spinning.fetch_sub(1, Ordering::Relaxed);
        self.workers_called.store(false, Ordering::Relaxed);
    }
}

/// Guard that keeps the threads spinning while it lives; a panic of the job ends it as well.
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
    use super::super::WorkerPool;
    use super::super::pool::{SplitWork, share_work};
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// Spin time longer than any test.
    const FOREVER: Duration = Duration::from_hours(1);

    /// Job of counting numbers.
    struct Numbers(usize);

    impl SplitWork for Numbers {
        fn split_at_part(self, part: usize, of: usize) -> (Self, Self) {
            let first = self.0 * part / of;
            (Self(first), Self(self.0 - first))
        }
    }

    /// Shares the counting of 1000 numbers a hundred times; returns the count.
    fn count(pool: &WorkerPool) -> usize {
        let counted = AtomicUsize::new(0);
        let add = |numbers: Numbers| _ = counted.fetch_add(numbers.0, Ordering::Relaxed);
        (0..100).for_each(|_| share_work(Some(pool), 16, Numbers(1000), add));
        counted.into_inner()
    }

    /// Shares jobs until all other threads spin.
    fn wait_until_all_spin(pool: &WorkerPool) {
        wait_for(|| {
            share_work(Some(pool), 2, Numbers(2), |_| ());
            n_spinning(pool) == pool.threads() - 1
        });
    }

    fn n_spinning(pool: &WorkerPool) -> usize {
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
    fn workers_spin_while_a_job_runs_and_no_longer() {
        for threads in [2, 4] {
            let pool = WorkerPool::with_spin_time(threads, FOREVER).expect("threads");
            for _ in 0..3 {
                assert_eq!(pool.lead(|| count(&pool)), 100_000);
                pool.lead(|| wait_until_all_spin(&pool));
                wait_for(|| n_spinning(&pool) == 0);
            }
        }
    }

    #[test]
    fn workers_stop_spinning_after_a_panic() {
        let pool = WorkerPool::with_spin_time(2, FOREVER).expect("threads");
        let panics = || {
            wait_until_all_spin(&pool);
            share_work(Some(&pool), 16, Numbers(1000), |_| panic!("on purpose"));
        };
        assert!(catch_unwind(AssertUnwindSafe(|| pool.lead(panics))).is_err());
        wait_for(|| n_spinning(&pool) == 0);
        assert_eq!(pool.lead(|| count(&pool)), 100_000);
    }

    #[test]
    fn workers_that_stopped_spinning_are_woken_again() {
        let pool = WorkerPool::with_spin_time(3, Duration::from_millis(20)).expect("threads");
        pool.lead(|| {
            for _ in 0..3 {
                wait_until_all_spin(&pool);
                wait_for(|| n_spinning(&pool) == 0);
            }
        });
    }
}
