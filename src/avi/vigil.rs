//! Threads that stay awake between what is shared: one that sleeps needs some 30 µs to come, and a tick is shared twice.

use rayon::Yield;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How long a thread waits for more to do: longer than one thread is busy between two ticks that are shared, books and contact of
/// 169 200 elements and the tick of what contact steps more often.
const PATIENCE: Duration = Duration::from_micros(250);

/// What a thread is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Duty {
    /// Nothing.
    None,
    /// A part of what is shared: while it waits for another part it must begin no watch.
    Part,
    /// It watches, or leads.
    Watch,
}

thread_local! {
    static DUTY: Cell<Duty> = const { Cell::new(Duty::None) };
}

/// While this lives its thread has this duty, unless it has a greater one.
pub(super) struct Engaged {
    before: Duty,
}

impl Engaged {
    pub fn with(duty: Duty) -> Self {
        Self { before: DUTY.replace(DUTY.get().max(duty)) }
    }
}

impl Drop for Engaged {
    fn drop(&mut self) {
        DUTY.set(self.before);
    }
}

/// What threads watch for.
#[derive(Debug, Default)]
pub(super) struct Vigil {
    /// Whether more may come.
    is_open: AtomicBool,
    /// Whether all threads were called, and none has left or could not come since.
    was_called: AtomicBool,
    /// How many threads watch.
    watching: AtomicUsize,
}

impl Vigil {
    /// Does a work on a thread of a pool; the others watch from its first [call](Self::call) on.
    pub fn during<R>(&self, work: impl FnOnce() -> R) -> R {
        let (_engaged, _open) = (Engaged::with(Duty::Watch), Open::new(self));
        work()
    }

    /// Calls the other threads of the pool that this one is of, unless they were called.
    pub fn call(self: &Arc<Self>) {
        if self.is_open.load(Ordering::Relaxed) && !self.was_called.swap(true, Ordering::Relaxed) {
            let vigil = Arc::clone(self);
            rayon::spawn_broadcast(move |_| vigil.watch());
        }
    }

    /// Does what is shared until nothing more can come, or nothing comes for a while.
    fn watch(&self) {
        match DUTY.get() {
            Duty::None => {}
            Duty::Part => return self.was_called.store(false, Ordering::Relaxed),
            Duty::Watch => return,
        }
        let _engaged = Engaged::with(Duty::Watch);
        self.watching.fetch_add(1, Ordering::Relaxed);
        let mut since = Instant::now();
        while self.is_open.load(Ordering::Relaxed) && since.elapsed() < PATIENCE {
            if rayon::yield_now() == Some(Yield::Executed) {
                since = Instant::now();
            } else {
                // Who has something to do has the core.
                std::thread::yield_now();
            }
        }
        self.watching.fetch_sub(1, Ordering::Relaxed);
        self.was_called.store(false, Ordering::Relaxed);
    }
}

/// While this lives, more may come; it ends also where a panic ends the work.
struct Open<'a>(&'a Vigil);

impl<'a> Open<'a> {
    fn new(vigil: &'a Vigil) -> Self {
        vigil.was_called.store(false, Ordering::Relaxed);
        vigil.is_open.store(true, Ordering::Relaxed);
        Self(vigil)
    }
}

impl Drop for Open<'_> {
    fn drop(&mut self) {
        self.0.is_open.store(false, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pool;
    use super::super::pool::{Cut, share};
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// So many numbers to count.
    struct Numbers(usize);

    impl Cut for Numbers {
        fn cut(self, part: usize, of: usize) -> (Self, Self) {
            let first = self.0 * part / of;
            (Self(first), Self(self.0 - first))
        }
    }

    /// Shares a work again and again, and at last waits until the others watch.
    fn lead(pool: &Pool, vigil: &Vigil) -> usize {
        pool.lead(|| {
            let counted = AtomicUsize::new(0);
            for _ in 0..100 {
                share(Some(pool), Numbers(1000), |numbers| _ = counted.fetch_add(numbers.0, Ordering::Relaxed));
            }
            wait_for(|| {
                share(Some(pool), Numbers(1), |_| ());
                vigil.watching.load(Ordering::Relaxed) == pool.threads() - 1
            });
            counted.into_inner()
        })
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
            let pool = Pool::new(threads).expect("threads");
            let vigil = pool.vigil();
            for _ in 0..3 {
                assert_eq!(lead(&pool, vigil), 100_000);
                wait_for(|| vigil.watching.load(Ordering::Relaxed) == 0);
            }
        }
    }

    #[test]
    fn nobody_waits_for_who_has_panicked() {
        let pool = Pool::new(2).expect("threads");
        let panics = || pool.lead(|| share(Some(&pool), Numbers(1000), |_| panic!("on purpose")));
        assert!(catch_unwind(AssertUnwindSafe(panics)).is_err());
        wait_for(|| pool.vigil().watching.load(Ordering::Relaxed) == 0);
        assert_eq!(lead(&pool, pool.vigil()), 100_000);
    }
}
