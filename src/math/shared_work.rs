//! CPU time of the work that is shared among threads, in this process.

use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// CPU time of shared work so far, ns.
static SHARED: AtomicU64 = AtomicU64::new(0);

/// Piece of shared work on the thread that began it; its CPU time is counted when it is dropped.
pub(crate) struct SharedWork(Option<ThreadTime>);

impl SharedWork {
    /// Begins a piece of work; it must be dropped on the same thread, and no other piece begins within it.
    pub fn begin() -> Self {
        Self(ThreadTime::try_now().ok())
    }
}

impl Drop for SharedWork {
    fn drop(&mut self) {
        // The difference of the library panics where a clock goes back.
        let spent =
            |begun: ThreadTime| Some(ThreadTime::try_now().ok()?.as_duration().saturating_sub(begun.as_duration()));
        let nanoseconds = self.0.and_then(spent).map_or(0, |spent| u64::try_from(spent.as_nanos()).unwrap_or(u64::MAX));
        SHARED.fetch_add(nanoseconds, Ordering::Relaxed);
    }
}

/// Returns the CPU time that the threads of this process have spent on shared work.
pub(crate) fn shared_cpu_time() -> Duration {
    Duration::from_nanos(SHARED.load(Ordering::Relaxed))
}

#[cfg(test)]
mod tests {
    use super::super::map_in_order;
    use super::*;

    #[test]
    fn work_on_a_pool_is_counted() {
        let items: Vec<u64> = (0..64).collect();
        let work = |item: &u64| (0..20_000).fold(*item, |sum, i| std::hint::black_box(sum ^ i));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads can be started");
        let before = shared_cpu_time();
        let done = pool.install(|| map_in_order(&items, 1, work));
        assert!(shared_cpu_time() > before && done.len() == items.len());
    }
}
