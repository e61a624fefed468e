//! CPU time of the work that is shared among threads, in this process.

use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// CPU time of shared work so far, ns.
static SHARED: AtomicU64 = AtomicU64::new(0);

/// Piece of shared work on the thread that began it; its CPU time is counted when it is dropped.
pub(crate) struct SharedWork(Option<ThreadTime>);

impl SharedWork {
    /// Begins a piece of work; it must be dropped on the same thread.
    pub fn begin() -> Self {
        Self(ThreadTime::try_now().ok())
    }
}

impl Drop for SharedWork {
    fn drop(&mut self) {
        let spent = self.0.and_then(|begun| begun.try_elapsed().ok());
        let nanoseconds = spent.map_or(0, |spent| u64::try_from(spent.as_nanos()).unwrap_or(u64::MAX));
        SHARED.fetch_add(nanoseconds, Ordering::Relaxed);
    }
}

/// Returns the CPU time that the threads of this process have spent on shared work.
pub(crate) fn shared_cpu_time() -> Duration {
    Duration::from_nanos(SHARED.load(Ordering::Relaxed))
}
