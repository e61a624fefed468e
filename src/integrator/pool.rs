//! Thread pool of a simulation, and the sharing of work among its threads.

use crate::math::SharedWork;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Parts of a job per thread; a thread that finishes takes another part. With one part the slower of two halves of
/// a tick took a tenth longer than the other, and twice as long where few elements were active. With four parts a
/// thread still waited for 5 to 15 % of a node loop.
const PARTS_PER_THREAD: usize = 16;

/// Thread pool of one simulation. Its threads are joined on drop, as none may outlive the library whose code they run.
pub struct WorkerPool {
    workers: Option<rayon::ThreadPool>,
    handles: Arc<Mutex<Vec<JoinHandle<()>>>>,
}

impl WorkerPool {
    /// Builds a pool of `threads` threads, 0 for one per core; `None` where one thread is enough or no thread can
    /// be started.
    #[must_use]
    pub fn new(threads: usize) -> Option<Arc<Self>> {
        let threads = if threads == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { threads };
        if threads == 1 {
            return None;
        }
        let handles = Arc::new(Mutex::new(vec![]));
        let kept = Arc::clone(&handles);
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads).spawn_handler(move |thread| {
            let handle = std::thread::Builder::new().name("gel".into()).spawn(|| thread.run())?;
            kept.lock().unwrap_or_else(PoisonError::into_inner).push(handle);
            Ok(())
        });
        Some(Arc::new(Self { workers: Some(builder.build().ok()?), handles }))
    }

    /// Returns the number of threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.workers.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Returns the number of parts for a job that can be split into at most `max_parts`.
    #[must_use]
    pub(super) fn part_count(&self, max_parts: usize) -> usize {
        max_parts.clamp(1, PARTS_PER_THREAD * self.threads())
    }

    /// Runs `work` on the pool.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// Work that can be split into two parts.
pub(super) trait SplitWork: Sized + Send {
    /// Splits off the first `part` of `of` equal parts; returns it and the rest.
    fn split_at_part(self, part: usize, of: usize) -> (Self, Self);
}

/// Performs a job on the pool, split into at most `max_parts` parts; as a whole without a pool.
pub(super) fn share_work<W: SplitWork>(pool: Option<&WorkerPool>, max_parts: usize, work: W, task: impl Fn(W) + Sync) {
    match pool {
        Some(pool) => pool.run(|| run_halves(work, pool.part_count(max_parts), &task)),
        None => task(work),
    }
}

/// Runs a job in `n_parts` parts by recursive halving.
fn run_halves<W: SplitWork>(work: W, n_parts: usize, task: &(impl Fn(W) + Sync)) {
    if n_parts == 1 {
        let _work = SharedWork::begin();
        return task(work);
    }
    let half = n_parts / 2;
    let (first, second) = work.split_at_part(half, n_parts);
    rayon::join(|| run_halves(first, half, task), || run_halves(second, n_parts - half, task));
}

/// One value per thread of a pool, the workspace of a task. The last used one is still in cache, and fewer are
/// needed than there are parts.
#[derive(Debug)]
pub(super) struct PerThread<T>(Vec<Mutex<T>>);

impl<T> PerThread<T> {
    /// Holds one value, for the thread of the caller.
    pub fn new(first: T) -> Self {
        Self(vec![Mutex::new(first)])
    }

    /// Extends to one value per thread of the pool.
    pub fn ensure_threads(&mut self, pool: &WorkerPool, new: impl Fn() -> T) {
        self.0.resize_with(pool.threads().max(self.0.len()), || Mutex::new(new()));
    }

    /// Locks the value of this thread; no other thread asks for it.
    pub fn own(&self) -> MutexGuard<'_, T> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        // A value poisoned by a panic is reset before use.
        self.0[thread % self.0.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for WorkerPool {
    fn drop(&mut self) {
        drop(self.workers.take());
        let mut handles = self.handles.lock().unwrap_or_else(PoisonError::into_inner);
        for handle in handles.drain(..) {
            // A worker that panicked has reported it already; dropping must not panic again.
            let _ = handle.join();
        }
    }
}

impl std::fmt::Debug for WorkerPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pool").finish_non_exhaustive()
    }
}
