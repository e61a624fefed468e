use super::worker_spin::{DutyGuard, SPIN_TIME, ThreadDuty, WorkerSpin};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Runs of a work for each thread: who is done first takes one more. With one, the slower of two halves of a tick took a tenth longer
/// than the other, of a tick of some of the elements twice as long; with four a thread still waited for 5 to 15 % of the nodes of one.
const PARTS_PER_THREAD: usize = 16;

/// Threads of one simulation, joined when it is dropped: none may outlive the library they run in.
pub struct Pool {
    workers: Option<rayon::ThreadPool>,
    spin: Arc<WorkerSpin>,
    handles: Arc<Mutex<Vec<JoinHandle<()>>>>,
}

impl Pool {
    /// A pool of so many threads, 0 for all cores; `None` where one thread is enough or no thread can be had.
    #[must_use]
    pub fn new(threads: usize) -> Option<Arc<Self>> {
        Self::with_spin_time(threads, SPIN_TIME)
    }

    /// The same, with how long threads stay awake.
    pub(super) fn with_spin_time(threads: usize, spin_time: Duration) -> Option<Arc<Self>> {
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
        Some(Arc::new(Self {
            workers: Some(builder.build().ok()?),
            spin: Arc::new(WorkerSpin::new(spin_time)),
            handles,
        }))
    }

    /// How many threads there are.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.workers.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Into how many runs a work is cut that can be cut into so many at most.
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

impl Pool {
    /// Runs a work of many parts that are shared: between these the other threads stay awake for a while.
    pub(super) fn lead<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.run(|| self.spin.keep_awake(work))
    }

    /// Who stays awake.
    #[cfg(test)]
    pub(super) fn spin(&self) -> &WorkerSpin {
        &self.spin
    }
}

/// Work that can be cut into a first and a second run.
pub(super) trait SplitWork: Sized + Send {
    /// The first `part` of `of` equal parts, and the rest.
    fn split_at_part(self, part: usize, of: usize) -> (Self, Self);
}

/// Does a work, cut into runs for the threads of the pool, so many at most; without a pool as a whole.
pub(super) fn share_work<W: SplitWork>(pool: Option<&Pool>, max_parts: usize, work: W, task: impl Fn(W) + Sync) {
    match pool {
        Some(pool) => pool.run(|| {
            pool.spin.wake_workers();
            run_halves(work, pool.part_count(max_parts), &task);
        }),
        None => task(work),
    }
}

fn run_halves<W: SplitWork>(work: W, n_parts: usize, task: &(impl Fn(W) + Sync)) {
    if n_parts == 1 {
        return task(work);
    }
    let _engaged = DutyGuard::with(ThreadDuty::Part);
    let half = n_parts / 2;
    let (first, second) = work.split_at_part(half, n_parts);
    rayon::join(|| run_halves(first, half, task), || run_halves(second, n_parts - half, task));
}

/// One of a kind for each thread of a pool, for what it works with: what it used last is still near, and so much need not be kept as there
/// are runs.
#[derive(Debug)]
pub(super) struct PerThread<T>(Vec<Mutex<T>>);

impl<T> PerThread<T> {
    /// One, for the thread of the caller.
    pub fn new(first: T) -> Self {
        Self(vec![Mutex::new(first)])
    }

    /// As many as the pool has threads.
    pub fn ensure_threads(&mut self, pool: &Pool, new: impl Fn() -> T) {
        self.0.resize_with(pool.threads().max(self.0.len()), || Mutex::new(new()));
    }

    /// That of this thread: no other asks for it.
    pub fn own(&self) -> MutexGuard<'_, T> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        // What a panic left is begun anew.
        self.0[thread % self.0.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        drop(self.workers.take());
        let mut handles = self.handles.lock().unwrap_or_else(PoisonError::into_inner);
        for handle in handles.drain(..) {
            // A worker that panicked has reported it already; dropping must not panic again.
            let _ = handle.join();
        }
    }
}

impl std::fmt::Debug for Pool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pool").finish_non_exhaustive()
    }
}
